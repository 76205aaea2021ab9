//! Runs jobs: declared inputs, outputs, parameters and versions; content hashes; does only what changed.
//!
//! **A job is made again** exactly when one of these differs from the record of its last success:
//! its stage's algorithm version, its parameters, the set or the content of its input files, the set
//! or the content of its output files (a missing or edited output counts). Nothing else matters: no
//! time stamp, no order, no number of threads. Outputs of jobs that are no longer planned are removed.
//!
//! Jobs that do not need each other run in parallel. A failed job fails alone; jobs that need its
//! outputs are passed over and say so.

mod job;
mod plan;
mod record;
mod run;

pub use job::{Job, Made, Make, Provenance};
pub use record::Records;
pub use run::{Options, Report, Verdict, run};
