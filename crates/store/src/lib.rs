//! The one store: the trial and sweep schema, Parquet files written atomically and read strictly,
//! the journal and its recovery, the event log, and `verify`.
//!
//! `docs/data.md` describes layout and promises. Recording writes with arrow/parquet; the files are
//! the boundary to the analysis. Any fault of a file is one [`StoreError`] that says which file,
//! which column, which row, and what to do.

pub mod claims;
mod command;
mod disk;
mod error;
mod first;
mod form;
#[cfg(any(test, feature = "testing"))]
pub mod hostile;
mod judge;
mod keep;
mod memo;
#[cfg(test)]
mod tests;

pub use command::{shell_line, shell_option};
pub use disk::atomic::{
    Append, Entry, Files, RealFiles, append_to, is_unfinished, keep_private, replace, sync_names,
    write_new, write_private,
};
pub use disk::content::Content;
pub use disk::hash::{file_blake3, hex_blake3};
pub use disk::held::Held;
pub use disk::layout::Layout;
pub use disk::lock::{StudyLock, owner};
#[cfg(any(test, feature = "testing"))]
pub use disk::memory::{Fault, Memory, Survives};
pub use disk::port::{PortFile, read_port};
pub use disk::raw::Raw;
pub use disk::real_path::real_path;
pub use disk::regular::{
    MOST_BYTES, MOST_RECORDING, open_named, open_regular, read_named, read_regular,
};
pub use disk::stamp::Stamp;
pub use disk::walk::files_below;
pub use disk::walk::unfinished_below;
pub use error::StoreError;
pub use first::FirstErrors;
pub use form::beside::{BesideChannel, BesideStream};
pub use form::bounds::{MOST_COLUMN_BYTES, MOST_COLUMNS, MOST_ROWS};
pub use form::columns::{Columns, Recorded, Values};
pub use form::encode::{Encoding, encoding_of};
pub use form::entry::{MOST_STUDY, Said, SessionLog, SweepEntry, TrialEntry};
pub use form::events::{Entered, append_events, new_log, read_events};
pub use form::footer::{TrialFooter, read_footer};
pub use form::frame::Protocol;
pub use form::json::{MOST_KEYS, from_json};
pub use form::measure::{decoded_rows, encoded_column};
pub use form::outside::{OutsideRow, outside_bytes};
pub use form::parts::{PART_ROWS, TableParts, TableWriter, write_table};
pub use form::read::{
    read_channels, read_entries, read_parquet, read_trial, read_trial_and_channels, read_trial_from,
};
pub use form::samples_table::{Lasting, SampleColumns, SamplesWriter};
pub use form::seen::Seen;
pub use form::session_record::read_records;
pub use form::signal::{COLUMNS, Column, Signal, Storage};
pub use form::sweep::{Quantity, Sweep, read_sweep, sweep_bytes};
pub use form::trial::{DOUBTS, GAPS, JOINED, LOST, SOURCE, Samples, Trial, TrialFile, ZEROS};
pub use form::write::{described, trial_bytes, write_parquet};
pub use judge::alike::{check_session_ids, check_study_id};
pub use judge::beside::{BesideEntry, beside_of};
pub use judge::lately::Lately;
pub use judge::one_form::check_form;
pub use judge::open::OpenTrial;
pub use judge::outside::{OutsideEntry, outside_log};
pub use judge::people::{ChangedGroup, PersonChanges, read_people};
pub use judge::plausible::{Asked, Plateau, plateau};
pub use judge::samples::{CHECKED, check_samples};
pub use judge::sources::{TrialName, readable_records, sweep_sources, trial_sources};
pub use judge::study::{Answer, LeftOutAnswer, StudyData, read_study};
pub use judge::tasks::TaskAnswer;
pub use judge::thin::{check_trial, read_thinned};
pub use judge::verify::{
    Findings, against_plan, findings, verify, verify_from, verify_kept, verify_with,
};
pub use judge::whole::{WholeSession, read_session, session_study};
pub use keep::accept::{accept_study, study_notes};
pub use keep::beside_log::{give_beside, withdraw_beside};
pub use keep::commit;
pub use keep::commit::commit_events;
pub use keep::journal::Journal;
pub use keep::lay_down::{laid_down, lay_down, record_bytes};
pub use keep::new_folder::NewFolder;
pub use keep::open_session::{OpenSession, record_trial};

pub use keep::outside_log::{GivenFile, give_metric, next_table, withdraw_metric};
pub use keep::recover::recover;
pub use keep::recovered::{Done, Recovered};
pub use keep::stream::{Staged, TrialWriter, replace_by};
pub use keep::sweep_log::{log_sweeps, record_sweep};
