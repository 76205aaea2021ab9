//! What can go wrong with a session.

use zwidth_device::{DeviceError, Refusal};
use zwidth_store::StoreError;

/// Why a session cannot continue, and what to do about it. The device is at 0 V when one of these
/// is returned.
#[derive(Debug, thiserror::Error)]
pub enum AcquireError {
    /// A file could not be read or written. What was finished before is safe.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The session on the disk is not as it was laid down and recorded.
    #[error("{}", not_whole(.session, .findings))]
    NotWhole {
        /// Participant and session.
        session: String,
        /// What is wrong with it.
        findings: Vec<StoreError>,
    },
    /// A mode that this device must not run.
    #[error(transparent)]
    Mode(#[from] Refusal),
    /// What was asked for does not go together, or not with what is on the disk.
    #[error("{what}; {remedy}")]
    Refused {
        /// What is wrong, with the value.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// The terminal, or the pipe, is gone. A session that runs is left in order then.
    #[error("the terminal is gone ({0}); the session can be resumed with the same command")]
    Front(#[from] std::io::Error),
}

impl AcquireError {
    /// What is wrong, with the value, and what to do.
    pub(crate) fn refused(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Refused { what: what.into(), remedy: remedy.into() }
    }
}

/// Why nothing is recorded onto a session, by its first finding.
fn not_whole(session: &str, findings: &[StoreError]) -> String {
    let first = findings.first().map(ToString::to_string).unwrap_or_default();
    let more = match findings.len() {
        0 | 1 => String::new(),
        n => format!(" (and {} more: `zwidth verify` lists them)", n - 1),
    };
    format!(
        "session {session} is incomplete or damaged, so nothing more is recorded in it: {first}{more}"
    )
}
