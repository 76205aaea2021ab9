//! What can keep a wall from being mapped.

use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// Axes that make no map, or a boundary that cannot be read: what is wrong, and what to give.
    #[error("{0}")]
    Refused(String),
    /// A wall that makes no sense.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}
