//! What can go wrong with a session.

use std::path::{Path, PathBuf};
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
    /// The session on the disk was laid down with other things than those at hand.
    #[error("cannot go on with {session}: {}; begin a new session, or restore what this one began with", .differences.join("; "))]
    Differs {
        /// The session's record.
        session: PathBuf,
        /// What differs, with both sides.
        differences: Vec<String>,
    },
    /// The session on the disk is not as it was laid down and recorded.
    #[error("{}", not_whole(.session, .findings))]
    NotWhole {
        /// Participant and session.
        session: String,
        /// What is wrong with it.
        findings: Vec<StoreError>,
    },
    /// `study.toml` has changed in what the session records, and nobody has accepted that.
    #[error(
        "{session}: study.toml has changed since the session began: {}; put it back, or go on by the session's own copy of \
         it with --accept-study-change",
        .changes.join("; ")
    )]
    StudyChanged {
        /// The session's record.
        session: PathBuf,
        /// What changed, with both sides.
        changes: Vec<String>,
    },
    /// A mode that this device must not run.
    #[error(transparent)]
    Mode(#[from] Refusal),
    /// What was asked for does not go together.
    #[error("{what}; {remedy}")]
    Refused {
        /// What is wrong, with the value.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// The study's folder is not where it was when the session began.
    #[error("{}", gone(.folder, .now.as_deref()))]
    Gone {
        /// Where it was.
        folder: PathBuf,
        /// Where it is now, if that is known.
        now: Option<PathBuf>,
    },
    /// The terminal, or the pipe, is gone. A session that runs is left in order then.
    #[error("the terminal is gone ({0}); the session can be resumed with the same command")]
    Front(#[from] std::io::Error),
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

/// What became of the study's folder, and what to do.
fn gone(folder: &Path, now: Option<&Path>) -> String {
    let folder = folder.display();
    let went = match now {
        Some(now) => format!("what was recorded is now in {}", now.display()),
        None => "what was recorded went with it".to_owned(),
    };
    format!(
        "{folder}: the study's folder was moved or removed while the session ran, and nothing is written to another; {went}, the samples of a trial in progress in its folder journal; put it back, and give the same command"
    )
}
