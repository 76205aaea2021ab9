//! What can be wrong with a table.

use zwidth_store::StoreError;

/// What can be wrong with a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// No column of that name.
    #[error("table '{table}' has no column '{column}'; it has {has}")]
    NoColumn {
        /// The table.
        table: String,
        /// The column asked for.
        column: String,
        /// The columns there are.
        has: String,
    },
    /// The column has another type.
    #[error("column '{column}' of table '{table}' is not of type {wanted:?}")]
    WrongType {
        /// The table.
        table: String,
        /// The column asked for.
        column: String,
        /// The type asked for.
        wanted: crate::Type,
    },
    /// Two columns of one name.
    #[error("table '{table}' has the column '{column}' twice")]
    Twice {
        /// The table.
        table: String,
        /// The column.
        column: String,
    },
    /// Tables that are to be one and have different columns.
    #[error(
        "table '{table}' has other columns than those it is to be put to ({columns} instead of {expected})"
    )]
    Unlike {
        /// The table.
        table: String,
        /// Its columns.
        columns: String,
        /// Those of the others.
        expected: String,
    },
    /// Columns of unequal length.
    #[error("column '{column}' of table '{table}' has {found} rows where the first has {expected}")]
    Ragged {
        /// The table.
        table: String,
        /// The column.
        column: String,
        /// Rows of the first column.
        expected: usize,
        /// Its rows.
        found: usize,
    },
    /// A value that is not a number reached a table.
    #[error(
        "column '{column}' of table '{table}', row {row}: {value} is not a number; a missing value is null"
    )]
    NotFinite {
        /// The table.
        table: String,
        /// The column.
        column: String,
        /// The row, from 1.
        row: usize,
        /// The value.
        value: f64,
    },
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
