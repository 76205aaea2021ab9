//! A derived table that is read and written some rows at a time: however long it is, memory holds
//! only these rows and, of the written ones, one encoded row group.

use crate::form::bounds::MOST_RECORDED_BYTES;
use crate::form::encode::derived;
use crate::form::opened::{DAMAGED, ParquetFile, guarded, table_error};
use crate::form::write::{all_entries, cannot_encode};
use crate::{RealFiles, StoreError};
use arrow::array::{RecordBatch, RecordBatchReader as _};
use arrow::datatypes::SchemaRef;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Rows of a table that are read, or written, at a time.
pub const PART_ROWS: usize = 1 << 13;

/// The rows of a table's file, [`PART_ROWS`] at a time: at least one part, which may have no row.
pub struct TableParts {
    path: PathBuf,
    footer: BTreeMap<String, String>,
    rows: usize,
    reader: ParquetRecordBatchReader,
    is_begun: bool,
}

impl TableParts {
    /// Opens a file that [`write_table`] or [`TableWriter`] wrote, for all its columns or for those of
    /// these names, in its order; a name that the file lacks is passed by.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(path: &Path, names: Option<&[&str]>) -> Result<Self, StoreError> {
        Self::open_recorded(path, names).map_err(table_error)
    }

    /// The same, with errors as those of a recording.
    fn open_recorded(path: &Path, names: Option<&[&str]>) -> Result<Self, StoreError> {
        let file = match names {
            Some(_) => ParquetFile::open_columns(path)?,
            None => ParquetFile::open(&RealFiles, path)?,
        };
        let columns = file.columns()?;
        let names: Vec<&str> = match names {
            Some(names) => names.to_vec(),
            None => columns.schema().fields().iter().map(|f| f.name().as_str()).collect(),
        };
        file.check_pages(&names, MOST_RECORDED_BYTES)?;
        let reader = file.reader(columns.clone(), &names, file.groups(), PART_ROWS)?;
        let path = path.to_owned();
        let rows = file.rows;
        Ok(Self { path, footer: file.footer, rows, reader, is_begun: false })
    }

    /// Takes out the footer's entries: where a table of all trials comes from is megabytes.
    pub fn take_footer(&mut self) -> BTreeMap<String, String> {
        std::mem::take(&mut self.footer)
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }
}

impl Iterator for TableParts {
    type Item = Result<RecordBatch, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = guarded(&self.path, DAMAGED, || Ok(self.reader.next().transpose()?));
        let next = next.map_err(table_error).transpose();
        // The columns of a table without rows are needed too.
        let is_first = !std::mem::replace(&mut self.is_begun, true);
        next.or_else(|| is_first.then(|| Ok(RecordBatch::new_empty(self.reader.schema()))))
    }
}

/// Writes a table's file, as [`write_table`] does, a part at a time. What its footer says is
/// known at its end.
pub struct TableWriter<W: Write + Send> {
    path: PathBuf,
    schema: SchemaRef,
    writer: ArrowWriter<W>,
}

impl<W: Write + Send> TableWriter<W> {
    /// Begins a file with these columns; `path` is its final place, for errors.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin(out: W, schema: SchemaRef, path: &Path) -> Result<Self, StoreError> {
        let options = ArrowWriterOptions::new().with_properties(derived(&schema));
        let options = options.with_skip_arrow_metadata(true); // it is among the entries
        let writer = ArrowWriter::try_new_with_options(out, schema.clone(), options)
            .map_err(|e| cannot_encode(path, &e))?;
        Ok(Self { path: path.to_owned(), schema, writer })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// Other columns; those of `out`.
    pub fn add(&mut self, rows: &RecordBatch) -> Result<(), StoreError> {
        self.writer.write(rows).map_err(|e| cannot_encode(&self.path, &e))
    }

    /// Ends the file, with what its footer says.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn end(mut self, footer: BTreeMap<String, String>) -> Result<(), StoreError> {
        for entry in all_entries(&self.schema, footer) {
            self.writer.append_key_value_metadata(entry);
        }
        self.writer.close().map(drop).map_err(|e| cannot_encode(&self.path, &e))
    }
}

/// The bytes of a derived table's Parquet file, as [`crate::write_parquet`] but for the encodings: the
/// table can be made again and is read again at once, so that it is written quickly rather than
/// small.
pub fn write_table(
    batch: &RecordBatch,
    footer: BTreeMap<String, String>,
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    let mut bytes = Vec::new();
    let mut writer = TableWriter::begin(&mut bytes, batch.schema(), path)?;
    writer.add(batch)?;
    writer.end(footer)?;
    Ok(bytes)
}
