//! What can go wrong.

use zwidth_store::StoreError;
use zwidth_tables::TableError;

/// Why an export was not made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A file that could not be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A table that is none.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A file that could not be written to; the disk's own error takes its place.
    #[error("cannot write: {0}")]
    Io(#[from] std::io::Error),
    /// What a form cannot hold, and what to do.
    #[error("{0}")]
    Refused(String),
}
