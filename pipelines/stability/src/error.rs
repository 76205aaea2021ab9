//! What can keep a wall from being mapped.

use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// Two axes of one quantity.
    #[error("both axes are {quantity}; choose two quantities")]
    SameQuantity {
        /// The quantity's word.
        quantity: &'static str,
    },
    /// An axis without extent, or without a logarithm where it has one.
    #[error(
        "an axis cannot show {quantity} from {from} to {to}; give two numbers above 0, the smaller first"
    )]
    Span {
        /// The quantity's word.
        quantity: &'static str,
        /// One end, in SI units.
        from: f64,
        /// The other.
        to: f64,
    },
    /// Too few or too many cells.
    #[error("a map cannot have {cells} cells per side; take 2 to {most}")]
    Cells {
        /// Cells asked for.
        cells: usize,
        /// Most cells.
        most: usize,
    },
    /// A line of a file of stiffness and damping that cannot be read.
    #[error(
        "line {line} of the boundary: {what}; give the columns K and B (or K_n_per_m and B_ns_per_m) with a number in each, not below 0"
    )]
    Boundary {
        /// The line, from 1.
        line: usize,
        /// What stands there.
        what: String,
    },
    /// A wall that makes no sense.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}
