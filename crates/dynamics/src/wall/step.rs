//! Whether a solver's step is stable on the wall as a continuous spring and damper.

use super::SampledWall;
use super::plant::{ENTRIES, U, V, V2, X, X2};
use crate::solve::Solver;
use crate::system::linear::LinearPart;
use crate::system::row::MOST;
use crate::verdict::Growth;
use zwidth_numerics::expm::Matrix;

impl SampledWall {
    /// |R(hλ)| of a solver over the exact flow's own growth, at its worst eigenvalue, for the wall
    /// as a model has it that knows no controller: u = K x + B ẋ at every instant. Unstable above 1
    /// (rounding: 1e-6); none for methods without a limit.
    pub fn step_growth(&self, solver: &dyn Solver, step_s: f64) -> Option<f64> {
        let plant = self.plant();
        let kept = ENTRIES - 1;
        let stiffness = self.stiffness_n_per_m;
        let damping = self.wall_damping_ns_per_m;
        let a = Matrix::<MOST>::from_fn(|i, j| match j {
            _ if i >= kept || j >= kept => 0.0,
            X => plant.at(i, X) + stiffness * plant.at(i, U),
            V => plant.at(i, V) + damping * plant.at(i, U),
            _ => plant.at(i, j),
        });
        let velocities = std::array::from_fn(|i| i < kept && i != X && i != X2);
        debug_assert!(velocities[V] && velocities[V2]);
        Growth::of(solver, &LinearPart { a, velocities }, step_s).map(Growth::excess)
    }
}
