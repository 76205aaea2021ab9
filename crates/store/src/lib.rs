//! The one store: the trial and sweep schema, Parquet files written atomically and read strictly,
//! the journal and its recovery, the event log, and `verify`.
//!
//! Layout and promises are those of `docs/data.md`. Recording writes with arrow/parquet; the files
//! are the boundary to the analysis. Whatever is wrong with a file is one [`StoreError`] that says
//! which file, which column, which row, and what to do.

mod accept;
mod alike;
mod atomic;
mod bounds;
mod calibrated;
pub mod claims;
mod codec;
mod columns;
mod command;
pub mod commit;
mod content;
mod digest;
mod encode;
mod entries;
mod error;
mod events;
mod first;
mod fit;
mod footer;
mod form;
mod frame;
mod hash;
mod head;
mod held;
pub mod hostile;
mod journal;
mod json;
mod laid;
mod lately;
mod layout;
mod lock;
mod memo;
mod memory;
mod open;
mod open_log;
mod open_session;
mod opened;
mod pages;
mod parts;
mod plausible;
mod port;
mod raw;
mod read;
mod real_path;
mod record;
mod recover;
mod regular;
mod sealed;
mod sectors;
mod seen;
mod sessions;
mod shown;
mod signal;
mod sources;
mod stamp;
mod stream;
mod streams;
mod study;
mod sweep;
mod sweep_log;
#[cfg(test)]
mod tests;
mod thin;
mod trial;
mod values;
mod verify;
mod walk;
mod whole;
mod write;

pub use accept::{accept_study, study_notes};
pub use alike::{check_session_ids, check_study_id};
pub use atomic::{
    Append, Entry, Files, RealFiles, append_to, is_unfinished, keep_private, replace, sync_names,
    write_new, write_private,
};
pub use bounds::{MOST_COLUMN_BYTES, MOST_COLUMNS, MOST_ROWS};
pub use columns::{Columns, Recorded, Values};
pub use command::{shell_line, shell_option};
pub use commit::commit_events;
pub use content::Content;
pub use encode::{Encoding, decoded_rows, encoded_column, encoding_of};
pub use error::StoreError;
pub use events::{Entered, append_events, new_log, read_events};
pub use first::FirstErrors;
pub use footer::{TrialFooter, read_footer};
pub use form::check_form;
pub use frame::Protocol;
pub use hash::{file_blake3, hex_blake3};
pub use held::Held;
pub use journal::Journal;
pub use json::{MOST_KEYS, from_json};
pub use laid::{laid_down, lay_down, record_bytes};
pub use lately::Lately;
pub use layout::Layout;
pub use lock::{StudyLock, owner};
pub use memory::{Fault, Memory, Survives};
pub use open::OpenTrial;
pub use open_session::OpenSession;
pub use parts::{PART_ROWS, TableParts, TableWriter, write_table};
pub use plausible::{Asked, Plateau, plateau};
pub use port::{PortFile, read_port};
pub use raw::Raw;
pub use read::{
    read_channels, read_entries, read_parquet, read_trial, read_trial_and_channels, read_trial_from,
};
pub use real_path::real_path;
pub use record::record_trial;
pub use recover::{Done, Recovered, recover, unfinished_below};
pub use regular::{MOST_BYTES, MOST_RECORDING, open_named, open_regular, read_named, read_regular};
pub use seen::Seen;
pub use sessions::read_records;
pub use signal::{COLUMNS, Column, Signal, Storage};
pub use sources::{TrialName, readable_records, sweep_sources, trial_sources};
pub use stamp::Stamp;
pub use stream::{Staged, TrialWriter, replace_by};
pub use study::{
    Answer, LeftOutAnswer, MOST_STUDY, Said, SessionLog, StudyData, SweepEntry, TrialEntry,
    read_study,
};
pub use sweep::{Quantity, Sweep, read_sweep, sweep_bytes};
pub use sweep_log::{log_sweeps, record_sweep};
pub use thin::{check_trial, read_thinned};
pub use trial::{DOUBTS, GAPS, LOST, SOURCE, Samples, Trial, TrialFile, ZEROS};
pub use verify::{
    CHECKED, Findings, against_plan, check_samples, findings, verify, verify_from, verify_kept,
    verify_with,
};
pub use walk::files_below;
pub use whole::{WholeSession, read_session, session_study};
pub use write::{described, trial_bytes, write_parquet};
