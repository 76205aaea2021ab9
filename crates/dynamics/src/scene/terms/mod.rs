//! Terms: single-valued forces on the lever's end that a model may have on top. One file each.
//!
//! A term is a type that implements [`Term`]; `scene.terms.set(…)` puts it into a scene, and the
//! equations, the checks, the forces by part, the energy and the tables follow. A new one is one
//! new file. For scene files to ask for it by name it has its `mod` and a line in `READERS` here;
//! nothing else changes. A term that is left out is not in any sum.
//!
//! ```
//! use serde::Serialize;
//! use zwidth_dynamics::{Affine, Exact, Grid, Input, Mode, Parameter, Plant, Solver, System, Term, table3};
//!
//! /// A weight on a string over a pulley: F = constant.
//! #[derive(Debug, Serialize)]
//! struct Bias {
//!     force_n: f64,
//! }
//!
//! impl Term for Bias {
//!     fn name(&self) -> &'static str {
//!         "bias"
//!     }
//!     fn about(&self) -> &'static str {
//!         "force of the weight"
//!     }
//!     fn parameters(&self) -> Vec<Parameter> {
//!         vec![Parameter::any("force_n", self.force_n, 1.0)]
//!     }
//!     fn affine(&self, _: &Plant) -> Affine {
//!         Affine { constant_n: self.force_n, ..Affine::default() }
//!     }
//! }
//!
//! let mut scene = table3::scene(Mode::Hybrid, Input::constant(0.0));
//! scene.terms.set(Bias { force_n: 1.0 });
//! let system = System::new(scene)?;
//! let run = Exact::default().run(&system, &Grid::of(&system))?;
//! let end = run.theta_rad().last().unwrap_or_default();
//! assert!((end + table3::HALF_STROKE_RAD - 0.25).abs() < 1e-6); // 1 N against 4 N/rad
//! # Ok::<(), zwidth_dynamics::DynamicsError>(())
//! ```
//!
//! What makes regions of its own is no term: dry friction and the brake (set-valued at θ̇ = 0), the
//! stops, and the finger, which has a mass and a rigid end. They are parts of the scene, and the
//! rules of [`crate::System`] know them.

pub mod gravity;
pub mod pull;
mod set;

use std::fmt;

use super::input::Input;
use super::plant::Plant;
use crate::error::{Result, finite, not_negative};
pub use set::Terms;
pub(crate) use set::names;
use set::{Read, read};

/// What a scene file may ask for: key and reader. A new term has its line here.
const READERS: &[(&str, Read)] =
    &[("gravity", read::<gravity::Gravity>), ("pull", read::<pull::Pull>)];

/// A single-valued force on the lever's end; above 0 it pushes to +θ, into the object.
///
/// It is the sum of a part that is affine in the state and a curved part. Terms with a curved part
/// are for the adaptive and the explicit fixed-step solvers; the others refuse them by name.
pub trait Term: fmt::Debug + Send + Sync {
    /// Key in a scene file, and name in tables (`pull`: the column `force_pull_n`).
    fn name(&self) -> &'static str;

    /// What a table says of the force, for instance "the lever's weight".
    fn about(&self) -> &'static str;

    /// Every number of it, to be checked, and to be named where a run goes wrong.
    fn parameters(&self) -> Vec<Parameter>;

    /// The affine part; none by default.
    fn affine(&self, _plant: &Plant) -> Affine {
        Affine::default()
    }

    /// The curved part at θ (rad) and θ̇ (rad/s); `None`, the default, at every state if there is
    /// none.
    fn curve(&self, _plant: &Plant, _theta_rad: f64, _theta_dot_rad_s: f64) -> Option<Curve> {
        None
    }

    /// A signal of time the force depends on, with the name of its field. One term of a scene may
    /// have one.
    fn input(&self) -> Option<(&'static str, &Input)> {
        None
    }
}

/// F = constant + per_rad θ + per_rad_s θ̇ + per_input d(t).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Affine {
    /// N.
    pub constant_n: f64,
    /// N/rad; a spring's is below 0.
    pub per_rad_n: f64,
    /// N s/rad; a damper's is below 0.
    pub per_rad_s_n: f64,
    /// N per unit of the term's own input d.
    pub per_input_n: f64,
}

/// A curved force at a state, with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Curve {
    /// N.
    pub force_n: f64,
    /// ∂F/∂θ, N/rad.
    pub per_rad_n: f64,
    /// ∂F/∂θ̇, N s/rad.
    pub per_rad_s_n: f64,
}

/// A number of a term.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    name: &'static str,
    value: f64,
    usual: f64,
    check: fn(&str, f64) -> Result<()>,
}

impl Parameter {
    /// A number that may be anything finite: name of its field, value, and a size it usually has.
    pub fn any(name: &'static str, value: f64, usual: f64) -> Self {
        Self { name, value, usual, check: finite }
    }

    /// The same for one that is not below zero.
    pub(crate) fn not_negative(name: &'static str, value: f64, usual: f64) -> Self {
        Self { name, value, usual, check: not_negative }
    }
}

#[cfg(test)]
mod tests;
