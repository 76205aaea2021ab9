//! The homogeneous part of a region's flow, by which a method's stability is judged.

use super::region::Region;
use super::row::MOST;
use super::{System, THETA};
use zwidth_numerics::expm::Matrix;

/// The homogeneous part of a region's flow: the dynamic entries alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearPart {
    /// ż = A z; rows and columns of the inputs are zero.
    pub a: Matrix<MOST>,
    /// Rows of velocities, which symplectic methods take first.
    pub velocities: [bool; MOST],
}

impl System {
    pub(crate) fn linear_part(&self, region: &Region) -> LinearPart {
        let flow = self.flow(region);
        let dynamic = self.layout.dynamic;
        let a = Matrix::from_fn(
            |i, j| if i < dynamic && j < dynamic { flow.rows[i].0[j] } else { 0.0 },
        );
        let positions = [Some(THETA), self.layout.finger];
        let velocities = std::array::from_fn(|i| i < dynamic && !positions.contains(&Some(i)));
        LinearPart { a, velocities }
    }
}
