//! What can prevent the trade of a scene.

use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum TradeError {
    /// A run that would fill the memory.
    #[error(
        "duration_s = {duration_s} s in steps of {step_s} s are more than {most} samples; make duration_s shorter"
    )]
    TooLong {
        /// Length of the run, s.
        duration_s: f64,
        /// The step, s.
        step_s: f64,
        /// Most samples.
        most: usize,
    },
    /// The scene makes no sense, or no solver could run it.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}
