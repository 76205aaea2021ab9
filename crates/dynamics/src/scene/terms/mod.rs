//! Terms: additional single-valued forces on the lever's end that a model may have, one file each.
//!
//! A term is a type that implements [`Term`]; `scene.terms.set(…)` puts it into a scene, and the
//! equations, the checks, the forces by part, the energy and the tables follow. A new term is one
//! new file. To let scene files name it, add its `mod` and a line in `READERS` here; nothing else
//! changes. A term that is left out is not in any sum.
//!
//! ```
//! use serde::Serialize;
//! use zwidth_dynamics::{Affine, Exact, Grid, Input, DriveMode, Parameter, Plant, Solver, System, Term, table3};
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
//! let mut scene = table3::scene(DriveMode::Hybrid, Input::constant(0.0));
//! scene.terms.set(Bias { force_n: 1.0 });
//! let system = System::new(scene)?;
//! let run = Exact::default().run(&system, &Grid::of(&system))?;
//! let end = run.theta_rad().last().unwrap_or_default();
//! assert!((end + table3::HALF_STROKE_RAD - 0.25).abs() < 1e-6); // 1 N against 4 N/rad
//! # Ok::<(), zwidth_dynamics::DynamicsError>(())
//! ```
//!
//! Parts with regions of their own are not terms: dry friction and the brake (set-valued at θ̇ =
//! 0), the stops, and the finger, which has a mass and a rigid end. They are parts of the scene,
//! and the rules of [`crate::System`] know them.

pub mod gravity;
pub mod pull;
mod set;
mod term;

pub use set::Terms;
pub(crate) use set::names;
pub use term::{Affine, Curve, Term};
use term::{Read, read};

/// What a scene file may ask for: key and reader. A new term has its line here.
const READERS: &[(&str, Read)] =
    &[("gravity", read::<gravity::Gravity>), ("pull", read::<pull::Pull>)];

#[cfg(test)]
mod tests;
