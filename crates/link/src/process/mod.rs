//! A program of one's own as a device: it is asked over its standard input and answers over its
//! standard output, a line of JSON each, in radians, newtons and volts.
//!
//! The messages are those of [`crate::framed`], and so is the host that asks them ([`crate::Rig`]).
//! docs/rig.md describes the lines; `examples/device/lever.py` is such a program. Nothing on a pipe
//! damages a byte, so a line that is not understood is a fault of the program, and stops a trial.

mod lines;
#[cfg(unix)]
mod program;
#[cfg(test)]
#[cfg(unix)]
mod tests;

pub(crate) use lines::{BoardLines, HostLines, STEP_N};
#[cfg(unix)]
pub(crate) use program::Program;

use crate::check::unable;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zwidth_device::DeviceError;

/// The table `[process]` of `rig.toml`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// The program and its arguments; no shell reads them.
    pub command: Vec<String>,
    /// The files that it consists of, from the study's folder on, with `/`: another content of one asks
    /// for consent anew.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// The folder that it works in: that of `rig.toml`.
    #[serde(skip)]
    pub folder: PathBuf,
}

impl Process {
    /// Checks that it makes sense.
    ///
    /// # Errors
    /// No command.
    pub(crate) fn check(&self) -> Result<(), DeviceError> {
        if self.command.first().is_some_and(|program| !program.is_empty()) {
            return Ok(());
        }
        Err(unable(
            "process.command is empty".to_owned(),
            "write the program and its arguments: command = [\"python3\", \"lever.py\"]",
        ))
    }
}
