//! A study for others: what counts of it, in a folder that needs no zwidth to be read.
//!
//! [`Contents`] is what leaves; [`write()`] lays it down. Each form is a file of its own that writes and
//! knows nothing of the others: tables as CSV and Parquet with a Data Package and an RO-Crate around
//! them, and, if they are asked for ([`Format`]), the samples for BIDS, MCAP, MAT and CSV. Trials are
//! read one at a time.

mod ascii;
mod bids;
mod citation;
mod contents;
mod data_package;
mod dictionary;
mod error;
mod folder;
mod format;
mod mapping;
mod mat;
mod mcap;
mod readme;
mod rename;
mod ro_crate;
mod samples;
mod study_file;
mod tables;
mod write;

pub use contents::{Asked, Contents, ExportedTrial, Origin};
pub use error::ExportError;
pub use folder::Written;
pub use format::Format;
pub use rename::Codes;
pub use write::{Beside, Key, planned, write};
