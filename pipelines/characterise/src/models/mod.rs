//! The candidates: each is a curve with parameters, one file each, with or without hysteresis.
//!
//! A new candidate is a file with a unit struct that implements [`Shape`], and a word of
//! [`CurveModel`] with its curve.

mod hinge;
mod line;
mod nonnegative;
mod power_law;
mod saturation;
mod spline;

use crate::shape::{Quantity, Shape};
use crate::steps::Gathered;
pub use hinge::Hinge;
pub use line::Line;
pub use power_law::PowerLaw;
pub use saturation::Saturation;
pub use spline::Spline;
use zwidth_numerics::branch::Branch;
use zwidth_results::{CommandWay, CurveModel, CurveShape, CurveSymbol};

/// The candidates, by number of free parameters.
pub fn all() -> impl Iterator<Item = Model> {
    CurveModel::ALL.iter().map(|name| Model::of(*name))
}

/// The way of the command to which a branch's curve belongs; without a branch, both.
pub(crate) fn way(branch: Option<Branch>) -> CommandWay {
    match branch {
        None => CommandWay::Both,
        Some(Branch::Up) => CommandWay::Up,
        Some(Branch::Down) => CommandWay::Down,
    }
}

/// A candidate: one curve for all commands, or (hysteresis) one for rising and one for falling
/// commands, each with parameters of its own, up first: an electromagnet may let go at a lower
/// voltage than it takes hold at.
#[derive(Clone, Copy)]
pub struct Model {
    /// Its name among the candidates.
    pub name: CurveModel,
    /// Its curve.
    pub shape: &'static dyn Shape,
    /// Whether the two branches have a curve each.
    pub hysteresis: bool,
}

impl Model {
    /// The candidate of that name.
    pub fn of(name: CurveModel) -> Self {
        let shape: &'static dyn Shape = match name.shape() {
            CurveShape::Line => &Line,
            CurveShape::Hinge => &Hinge,
            CurveShape::Saturation => &Saturation,
            CurveShape::PowerLaw => &PowerLaw,
            CurveShape::Spline => &Spline,
        };
        Self { name, shape, hysteresis: name.has_hysteresis() }
    }

    /// Its branches: `None` stands for both at once.
    pub fn branches(&self) -> &'static [Option<Branch>] {
        if self.hysteresis { &[Some(Branch::Up), Some(Branch::Down)] } else { &[None] }
    }

    /// The equation, x the command and y the response.
    pub fn formula(&self) -> String {
        let twice = if self.hysteresis { ", up and down apart" } else { "" };
        format!("{}{twice}", self.shape.formula())
    }

    /// Number of parameters that are fitted.
    pub fn complexity(&self) -> usize {
        self.shape.complexity() * self.branches().len()
    }

    /// The parameters in the order of every list: branch, name, meaning.
    pub fn parameters(&self) -> Vec<(Option<Branch>, CurveSymbol, Quantity)> {
        let own = self.shape.parameters();
        let branches = self.branches().iter();
        branches.flat_map(|branch| own.iter().map(|(name, q)| (*branch, *name, *q))).collect()
    }

    /// The parameters with the smallest weighted sum of squares; `None` if the data cannot
    /// determine them. `near` are parameters in whose neighbourhood the search may stay.
    pub(crate) fn fit(&self, data: &Gathered, near: Option<&[f64]>) -> Option<Vec<f64>> {
        let each = self.shape.parameters().len();
        let mut all = Vec::with_capacity(each * self.branches().len());
        for (number, branch) in self.branches().iter().enumerate() {
            let near = near.map(|p| &p[number * each..][..each]);
            all.extend(self.shape.fit(&data.of(*branch), near)?);
        }
        Some(all)
    }

    /// The curve at `command` on its way `branch`.
    pub fn predict(&self, parameters: &[f64], command: f64, branch: Branch) -> f64 {
        let each = self.shape.parameters().len();
        let skip = if self.hysteresis { branch as usize * each } else { 0 };
        self.shape.predict(&parameters[skip..skip + each], command)
    }
}
