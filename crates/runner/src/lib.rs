//! Runs jobs with declared inputs, outputs, parameters and versions; by content hashes, it makes
//! only what changed.
//!
//! **A job is made again** exactly when one of these differs from the record of its last success:
//! its stage's algorithm version, its parameters, the set or the content of its input files, the
//! set or the content of its output files (a missing or edited output counts). Nothing else
//! matters: no time stamp, no order, no number of threads. (If the system says that a file is in
//! the same state as when it was last hashed, the file is not read again: [`zwidth_store::Seen`].)
//! Outputs of jobs that are no longer planned are removed.
//!
//! A job's function is a plain function of its parameters (one serialisable struct, whose JSON is
//! the key) and of the files that it declares ([`Job::new`]): it has no access to anything else, so
//! nothing that a result depends on can be missing from its key.
//!
//! Each output carries its *origin* ([`ORIGIN`]): stage, version and one digest of everything that
//! its job depends on. By its origin a file found alone is assigned to its job. [`states`] says
//! what a run would do now and why; [`trace`] follows the records back to the files that no job
//! makes.
//!
//! Jobs that do not need each other run in parallel. A failed job fails alone; jobs that need its
//! outputs are passed over and say so.
//!
//! A [`Shard`] makes a share of what is derived from trials, and says in a manifest what it made.
//! It writes nothing else, so that shards may run at the same time, on one disk or on several.
//! [`survey`] says which shards' results belong to the study as it is, and what is missing;
//! [`merge`] adds their records to the study's, and copies their files if these are elsewhere. An
//! engine that distributes parts itself asks [`due`] which parts to make, and writes the returned
//! results ([`lay_down`]) as shards to merge.
//!
//! A run writes and removes only through its [`Results`]: below `derived/<study>` and
//! `reports/<study>`, whatever the records of earlier runs say.

mod change;
mod elsewhere;
mod hashes;
mod job;
mod manifest;
mod members;
mod merge;
mod plan;
mod provenance;
mod record;
mod records;
mod results;
mod run;
mod script;
mod shard;
mod state;
mod survey;
mod trace;
mod twice;

pub use change::{Change, Field, FileChange, How};
pub use elsewhere::{Sent, due, lay_down};
pub use hashes::HashesRead;
pub use job::{Inputs, Job, JobError, Made, Making, Output, Stage, WriteLong, strip_root};
pub use manifest::{PROGRAM, waiting};
pub use merge::{Merged, merge};
pub use provenance::{ORIGIN, Provenance, origins};
pub use record::Record;
pub use records::Records;
pub use results::Results;
pub use run::{Done, JobEnd, Options, Report, run, wanted};
pub use script::{
    ENVIRONMENT, HeldSignals, MOST_PRINTED, Script, ScriptError, Scripts, last_printed, run_script,
};
pub use shard::{MOST_SHARDS, Shard};
pub use state::{Again, State, states};
pub use survey::{Share, Survey, survey};
pub use trace::{Source, Step, Trace, trace};
pub use twice::{Unlike, made_twice};
