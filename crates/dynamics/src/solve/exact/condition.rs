//! The condition number of a region's exponential.

use zwidth_numerics::expm::{self, Matrix};

use crate::solve::with_length;
use crate::system::System;
use crate::system::region::Region;

impl System {
    /// Relative condition number of `exp(A step_s)` for the augmented matrix of a region.
    pub(crate) fn condition(&self, region: &Region, step_s: f64) -> f64 {
        with_length!(self.layout.n, self.condition_n(region, step_s))
    }

    fn condition_n<const N: usize>(&self, region: &Region, step_s: f64) -> f64 {
        let flow = self.flow(region);
        expm::condition(&Matrix::<N>::from_fn(|i, j| step_s * flow.rows[i].0[j]))
    }
}
