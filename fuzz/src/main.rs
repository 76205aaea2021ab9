//! `ZWIDTH_FUZZ=journal fuzz CORPUS`: libFuzzer on one reader. `ZWIDTH_FUZZ=seeds fuzz`: the files
//! to begin from.
//!
//! A reader may refuse what it is given, and must neither panic nor hang nor take more memory than
//! is allowed. A panic of a decoder that the reader catches is none.
#![no_main]

mod seeds;
mod targets;

use libfuzzer_sys::fuzz_target;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::OnceLock;

static TARGET: OnceLock<targets::Target> = OnceLock::new();

/// Chooses the target, or writes the seeds and ends: before libFuzzer watches for ends.
fn choose() {
    let name = std::env::var("ZWIDTH_FUZZ").unwrap_or_default();
    if name == "seeds" {
        let written = seeds::write();
        written.as_ref().err().iter().for_each(|e| eprintln!("fuzz/seeds: {e}"));
        std::process::exit(written.is_err().into());
    }
    let Some(target) = targets::named(&name) else {
        eprintln!(
            "'{name}' is no target; ZWIDTH_FUZZ is seeds, or one of {}",
            targets::names().join(", ")
        );
        std::process::exit(2)
    };
    let _ = TARGET.set(target);
    // libFuzzer's hook ends the process at any panic, also one that is caught.
    set_hook(Box::new(|_| {}));
}

fuzz_target!(init: choose(), |bytes: &[u8]| {
    let Some(target) = TARGET.get() else { return };
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| target(bytes))) {
        let said = panic.downcast_ref::<String>().cloned();
        let said = said.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        eprintln!("the reader panicked: {}", said.unwrap_or_default());
        std::process::abort();
    }
});
