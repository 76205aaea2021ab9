//! Bytes and what they mean, both ways: the Parquet files of trials and sweeps, the journal, the logs
//! of events, the records of sessions.

pub(crate) mod beside;
pub(crate) mod bounds;
pub(crate) mod change_list;
pub(crate) mod codec;
pub(crate) mod columns;
mod constant;
pub(crate) mod digest;
pub(crate) mod encode;
pub(crate) mod entries;
pub(crate) mod entry;
pub(crate) mod events;
pub(crate) mod footer;
pub(crate) mod frame;
pub(crate) mod groups;
pub(crate) mod head;
pub(crate) mod journaled;
pub(crate) mod json;
pub(crate) mod measure;
pub(crate) mod opened;
pub(crate) mod outside;
pub(crate) mod pages;
pub(crate) mod parts;
pub(crate) mod read;
pub(crate) mod samples_table;
pub(crate) mod seen;
pub(crate) mod session_record;
pub(crate) mod shown;
pub(crate) mod signal;
pub(crate) mod streams;
pub(crate) mod sweep;
pub(crate) mod trial;
pub(crate) mod values;
pub(crate) mod write;
