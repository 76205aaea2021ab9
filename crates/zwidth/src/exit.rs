//! Exit codes, and the last resort against a panic.

use anyhow::anyhow;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How the program ends. Bad arguments give 2; clap sees to that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// All was done.
    Fine = 0,
    /// It failed.
    Failed = 1,
    /// Done, but something was skipped or lost, or is to be read with care; it was listed.
    Partly = 3,
}

/// Runs the program; a panic is a defect and becomes one clear error.
pub(crate) fn guarded(program: impl FnOnce() -> anyhow::Result<Exit>) -> anyhow::Result<Exit> {
    catch_unwind(AssertUnwindSafe(program)).unwrap_or_else(|payload| {
        let words = payload
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| payload.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        Err(anyhow!(
            "zwidth has a defect and stopped ({words}); nothing was half-written; please report it"
        ))
    })
}
