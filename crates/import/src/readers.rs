//! The readers of other people's formats as functions of bytes, with the first columns taken.

use super::csv::Dialect;
use super::limits::{Budget, Take};
use super::table::{ColumnRef, Table};
use std::path::Path;
use zwidth_store::StoreError;

/// Columns that are taken.
const TAKEN: usize = 8;

fn taken(read: impl Fn(&Path, &Take) -> Result<Table, StoreError>) -> Result<usize, StoreError> {
    let columns: Vec<ColumnRef> = (1..=TAKEN).map(ColumnRef::Position).collect();
    let budget = Budget::default();
    let take = Take { columns: columns.iter().collect(), pattern: None, budget: &budget };
    read(Path::new("input"), &take).map(|table| table.lines.len())
}

/// Comma-separated values with a header; the number of rows.
///
/// # Errors
/// Why they cannot be read.
pub fn csv(bytes: &[u8]) -> Result<usize, StoreError> {
    let dialect = Dialect { delimiter: b',', header: true, comment: Some(b'#'), skip: 0 };
    taken(|path, take| super::csv::read(path, bytes, dialect, take))
}

/// JSON lines; the number of rows.
///
/// # Errors
/// Why they cannot be read.
pub fn jsonl(bytes: &[u8]) -> Result<usize, StoreError> {
    taken(|path, take| super::jsonl::read(path, bytes, take))
}

/// A MAT file: its vectors, then the columns of the matrix `data`; the number of rows of the
/// vectors.
///
/// # Errors
/// Why it cannot be read.
pub fn mat(bytes: &[u8]) -> Result<usize, StoreError> {
    let _ = taken(|path, take| super::mat::read(path, bytes, Some("data"), take));
    taken(|path, take| super::mat::read(path, bytes, None, take))
}

/// A Parquet file of others; the number of rows.
///
/// # Errors
/// Why it cannot be read.
pub fn parquet(bytes: &[u8]) -> Result<usize, StoreError> {
    taken(|path, take| super::parquet::read(path, bytes.to_vec(), take))
}
