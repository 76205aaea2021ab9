//! The condition number of a region's exponential, by which the tests judge errors.

use crate::solve::with_length;
use crate::system::System;
use crate::system::region::Region;
use crate::trajectory::Trajectory;
use zwidth_numerics::expm::{self, Matrix};

impl System {
    /// Largest condition number of `exp(A step_s)` over the regions that a run met.
    pub(super) fn largest_condition(&self, run: &Trajectory, step_s: f64) -> f64 {
        run.regions.iter().map(|region| self.condition(region, step_s)).fold(0.0, f64::max)
    }

    /// Relative condition number of `exp(A step_s)` for the augmented matrix of a region.
    pub(super) fn condition(&self, region: &Region, step_s: f64) -> f64 {
        with_length!(self.layout.n, self.condition_n(region, step_s))
    }

    fn condition_n<const N: usize>(&self, region: &Region, step_s: f64) -> f64 {
        let flow = self.flow(region);
        expm::condition(&Matrix::<N>::from_fn(|i, j| step_s * flow.rows[i].0[j]))
    }
}
