//! What a term is.

use crate::scene::input::Input;
use crate::scene::parameter::Parameter;
use crate::scene::plant::Plant;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;
use std::sync::Arc;
use toml::Value;

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

/// A term that can be written down.
pub(super) trait Written: Term {
    fn value(&self) -> Result<Value, toml::ser::Error>;
}

impl<T: Term + Serialize> Written for T {
    fn value(&self) -> Result<Value, toml::ser::Error> {
        Value::try_from(self)
    }
}

/// Makes a term of what a file has under its name.
pub(super) type Read = fn(Value) -> Result<Arc<dyn Written>, toml::de::Error>;

pub(super) fn read<T: Term + Serialize + DeserializeOwned + 'static>(
    value: Value,
) -> Result<Arc<dyn Written>, toml::de::Error> {
    Ok(Arc::new(value.try_into::<T>()?))
}
