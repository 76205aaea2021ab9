//! What can be wrong with a table.

use zwidth_store::StoreError;

/// What can be wrong with a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// A column that is not there, of another type, of another length or there twice; a value that is not
    /// a number; tables that are to be one and have different columns.
    #[error("{0}")]
    Form(String),
    /// It has not the rows that it should have.
    #[error("table '{table}': {source}")]
    Rows {
        /// The table.
        table: String,
        /// What it lacks.
        source: zwidth_results::ReadError,
    },
    /// The file could not be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A table in parts that has none.
    #[error("a table has no part")]
    NoPart,
    /// What takes a file's text part by part did not.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}
