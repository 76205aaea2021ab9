//! Tests of the whole: the architecture, the program run on folders, bad input, real recordings.
//!
//! One test binary, a module a subject. The program under test is the one that `cargo test
//! --workspace` builds beside this binary; `cargo test -p zwidth-tests` alone tests the one that
//! was built last.

// Helpers of tests stand outside of `#[test]` functions, where clippy.toml's exemption does not
// reach.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod acquire;
mod architecture;
mod auto;
mod bad_disk;
mod bad_files;
mod bad_import;
mod bench;
mod beside;
mod binary;
mod blinding;
mod circles;
mod compared;
mod counting;
mod curves;
#[cfg(unix)]
mod door;
mod export;
mod factors;
mod findings;
mod folders;
mod formulas;
mod groups;
mod hostile_import;
mod itself;
mod little_memory;
mod logs;
mod others;
mod outside_metrics;
mod own_metrics;
mod page;
mod participant;
#[cfg(unix)]
mod printed;
mod program_device;
mod provenance;
mod real;
mod records;
mod remade;
mod resuming;
#[cfg(unix)]
mod rig;
mod running;
mod said;
mod schema;
mod scores;
mod shards;
mod shipped;
mod small;
mod source;
#[cfg(unix)]
mod stages;
mod story;
mod survey;
#[cfg(unix)]
mod terminals;
mod versions;
mod whole_run;
#[cfg(unix)]
mod wire;
mod words;
