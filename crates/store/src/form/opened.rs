//! A Parquet file of ours, opened strictly: its footer checked, its columns not read yet.

use crate::disk::content::Content;
use crate::disk::regular::open_end;
use crate::form::bounds::{
    FooterClaims, MOST_COLUMN_BYTES, Why, check_footer_in, check_pages_in, check_size,
};
use crate::form::codec::check_codecs;
use crate::form::write::{FOOTER_DIGEST, TABLE_VERSION, VERSION, footer_digest};
use crate::memo::Memo;
use crate::{Files, MOST_RECORDING, StoreError};
use arrow::array::RecordBatch;
use arrow::compute::concat_batches;
use arrow::datatypes::SchemaRef;
use bytes::Bytes;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader,
    ParquetRecordBatchReaderBuilder,
};
use parquet::arrow::{ARROW_SCHEMA_META_KEY, ProjectionMask, parquet_to_arrow_schema};
use parquet::errors::ParquetError;
use parquet::file::metadata::{
    KeyValue, ParquetMetaData, ParquetMetaDataOptions, ParquetMetaDataReader,
    ParquetStatisticsPolicy,
};
use parquet::file::statistics::Statistics;
use parquet::schema::types::SchemaDescPtr;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_study::Schema;

pub(crate) const DAMAGED: &str = "restore the file from a copy, or exclude the trial";

/// The remedy for a damaged table: unlike a recording, it can be made again.
const MADE_AGAIN: &str = "remove the file, and `zwidth run` makes it again";

/// An error of a table's file.
pub(crate) fn table_error(error: StoreError) -> StoreError {
    let is_damaged = error.remedy == DAMAGED;
    StoreError { remedy: if is_damaged { MADE_AGAIN.to_owned() } else { error.remedy }, ..error }
}

/// Rows that are decoded at a time: what a file claims decides no allocation.
pub(crate) const BATCH_ROWS: usize = 1 << 16;

/// An opened Parquet file of ours: footer checked, columns not read yet.
pub(crate) struct ParquetFile {
    pub(crate) path: PathBuf,
    pub(crate) content: Content,
    pub(crate) metadata: Arc<ParquetMetaData>,
    pub(crate) footer: BTreeMap<String, String>,
    pub(crate) rows: usize,
}

impl ParquetFile {
    /// Opens `path`, checks what it claims, its version and its footer's digest.
    pub(crate) fn open(files: &dyn Files, path: &Path) -> Result<Self, StoreError> {
        Self::of(path, files.open(path, MOST_RECORDING))
    }

    /// The same, but however small the file is, hardly more than the requested columns are read.
    pub(crate) fn open_columns(path: &Path) -> Result<Self, StoreError> {
        Self::of(path, open_end(path, MOST_RECORDING))
    }

    fn of(path: &Path, content: io::Result<Content>) -> Result<Self, StoreError> {
        let content = content.map_err(|e| StoreError::io(path, "read", &e))?;
        let FooterClaims { entries: footer, schema, .. } = read_claims(path, &content)?;
        let metadata = guarded(path, DAMAGED, || parse_metadata(&content, &schema))?;
        check_size(path, &metadata, DAMAGED)?;
        let rows = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(0);
        // Before the digest: a file of another program has none, and is not damaged for that.
        version(path, &footer)?;
        check_codecs(path, &metadata)?;
        check_digest(path, &footer)?;
        Ok(Self { path: path.to_owned(), content, metadata: Arc::new(metadata), footer, rows })
    }

    /// Opens a recording: a file without rows is not one.
    pub(crate) fn open_recording(files: &dyn Files, path: &Path) -> Result<Self, StoreError> {
        let opened = Self::open(files, path)?;
        check_rows(path, opened.rows)?;
        Ok(opened)
    }

    /// Its columns as Arrow has them, with their types and units.
    pub(crate) fn columns(&self) -> Result<ArrowReaderMetadata, StoreError> {
        let options = ArrowReaderOptions::default().with_schema(self.schema()?);
        guarded(&self.path, DAMAGED, || {
            ArrowReaderMetadata::try_new(self.metadata.clone(), options)
        })
    }

    /// Its columns' names, types and units. The files of a study have one of a few: they are read out
    /// once for those that a thread opens one after the other.
    pub(crate) fn schema(&self) -> Result<SchemaRef, StoreError> {
        type Key = (Option<KeyValue>, SchemaDescPtr);
        thread_local! {
            static LAST: RefCell<Memo<Key, SchemaRef>> = const { RefCell::new(Memo::new()) };
        }
        let metadata = self.metadata.file_metadata();
        let mut entries = metadata.key_value_metadata().into_iter().flatten();
        let entry = entries.find(|entry| entry.key == ARROW_SCHEMA_META_KEY);
        let columns = metadata.schema_descr_ptr();
        if let Some(schema) =
            LAST.with_borrow(|last| last.get(|key| key.0.as_ref() == entry && key.1 == columns))
        {
            return Ok(schema);
        }
        let entries = entry.map(|entry| vec![entry.clone()]);
        let schema =
            guarded(&self.path, DAMAGED, || parquet_to_arrow_schema(&columns, entries.as_ref()))?;
        let schema = Arc::new(schema);
        LAST.with_borrow_mut(|last| last.keep((entry.cloned(), columns), schema.clone()));
        Ok(schema)
    }

    /// BLAKE3 of the whole file, hexadecimal.
    pub(crate) fn blake3(&self) -> Result<String, StoreError> {
        self.content.blake3().map_err(|e| StoreError::io(&self.path, "read", &e))
    }

    /// The columns with these names, as one batch.
    pub(crate) fn read(
        &self,
        columns: ArrowReaderMetadata,
        names: &[&str],
    ) -> Result<RecordBatch, StoreError> {
        let mut batches = Vec::new();
        self.check_pages(names, MOST_COLUMN_BYTES)?;
        let schema = self.each_batch(columns, names, self.groups(), |batch| batches.push(batch))?;
        guarded(&self.path, DAMAGED, || Ok(concat_batches(&schema, &batches)?))
    }

    /// Whether the statistics of a column say that it is null throughout.
    pub(crate) fn is_null_by_statistics(&self, name: &str) -> bool {
        self.metadata.row_groups().iter().all(|group| {
            let column = group.columns().iter().find(|c| *c.column_path().parts() == [name]);
            let nulls = column.and_then(|column| column.statistics()?.null_count_opt());
            nulls.and_then(|nulls| i64::try_from(nulls).ok()) == Some(group.num_rows())
        })
    }

    /// The ends of a column of doubles, where its statistics say them.
    pub(crate) fn ends_by_statistics(&self, name: &str) -> Option<(f64, f64)> {
        let groups = self.metadata.row_groups().iter().map(|group| {
            let mut columns = group.columns().iter();
            let column = columns.find(|c| *c.column_path().parts() == [name])?;
            match column.statistics()? {
                Statistics::Double(ends) => Some((*ends.min_opt()?, *ends.max_opt()?)),
                _ => None,
            }
        });
        let groups = groups.collect::<Option<Vec<_>>>()?;
        groups.into_iter().reduce(|(low, high), next| (low.min(next.0), high.max(next.1)))
    }

    /// Checks that none of the columns of these names unpacks to more than `most` bytes.
    pub(crate) fn check_pages(&self, names: &[&str], most: u64) -> Result<(), StoreError> {
        let schema = self.metadata.file_metadata().schema_descr();
        check_pages_in(&self.content, &self.metadata, most, |place| {
            let root = schema.columns()[place].path().parts().first();
            root.is_some_and(|root| names.contains(&root.as_str()))
        })
        .map(drop)
        .map_err(|why| claim_error(&self.path, why))
    }

    /// Decodes the columns of these names in some row groups, so many rows at a time.
    pub(crate) fn each_batch(
        &self,
        columns: ArrowReaderMetadata,
        names: &[&str],
        groups: Range<usize>,
        mut take: impl FnMut(RecordBatch),
    ) -> Result<SchemaRef, StoreError> {
        let reader = self.reader(columns, names, groups, BATCH_ROWS)?;
        let schema = arrow::array::RecordBatchReader::schema(&reader);
        guarded(&self.path, DAMAGED, || {
            for batch in reader {
                take(batch?);
            }
            Ok(schema)
        })
    }

    /// A reader of the columns of these names in some row groups, which decodes so many rows at a
    /// time.
    pub(crate) fn reader(
        &self,
        columns: ArrowReaderMetadata,
        names: &[&str],
        groups: Range<usize>,
        rows: usize,
    ) -> Result<ParquetRecordBatchReader, StoreError> {
        guarded(&self.path, DAMAGED, || {
            let builder =
                ParquetRecordBatchReaderBuilder::new_with_metadata(self.content.clone(), columns);
            let schema = self.metadata.file_metadata().schema_descr();
            let projection = ProjectionMask::columns(schema, names.iter().copied());
            let rows = self.rows.clamp(1, rows);
            let builder = builder.with_projection(projection).with_batch_size(rows);
            builder.with_row_groups(groups.collect()).build()
        })
    }

    pub(crate) fn groups(&self) -> Range<usize> {
        0..self.metadata.num_row_groups()
    }
}

/// The footer and the number of rows of a recording that was opened before, when its content was the
/// same: where its columns lie is not looked at again.
///
/// # Errors
/// Those of [`ParquetFile::open_recording`], of what is looked at.
pub(crate) fn opened_before(
    path: &Path,
    content: &Content,
) -> Result<(BTreeMap<String, String>, usize), StoreError> {
    let FooterClaims { entries: footer, rows, .. } = read_claims(path, content)?;
    version(path, &footer)?;
    check_digest(path, &footer)?;
    check_rows(path, rows)?;
    Ok((footer, rows))
}

fn check_rows(path: &Path, rows: usize) -> Result<(), StoreError> {
    if rows > 0 { Ok(()) } else { Err(StoreError::new(path, "the file has 0 rows", DAMAGED)) }
}

fn read_claims(path: &Path, content: &Content) -> Result<FooterClaims, StoreError> {
    if content.length() == 0 {
        return Err(StoreError::new(path, "the file is empty", DAMAGED));
    }
    let mut claims = check_footer_in(content).map_err(|why| claim_error(path, why))?;
    // The writer of Arrow adds it by itself; our digest is without it.
    claims.entries.remove(ARROW_SCHEMA_META_KEY);
    Ok(claims)
}

fn check_digest(path: &Path, footer: &BTreeMap<String, String>) -> Result<(), StoreError> {
    if footer.get(FOOTER_DIGEST) == Some(&footer_digest(footer)) {
        return Ok(());
    }
    let what = "the file is damaged: its footer does not match its digest";
    Err(StoreError::new(path, what, DAMAGED))
}

/// What a footer says. The files of a study have one of a few schemas: that of the same bytes is not
/// parsed again by a thread that knows it.
fn parse_metadata(content: &Content, schema: &Bytes) -> Result<ParquetMetaData, ParquetError> {
    thread_local! {
        static LAST: RefCell<Memo<Bytes, SchemaDescPtr>> = const { RefCell::new(Memo::new()) };
    }
    let kept = LAST.with_borrow(|last| last.get(|bytes| bytes == schema));
    let is_kept = kept.is_some();
    // What the pages of a column take and how they are encoded, the pages say themselves.
    let mut options = ParquetMetaDataOptions::new()
        .with_encoding_stats_policy(ParquetStatisticsPolicy::SkipAll)
        .with_size_stats_policy(ParquetStatisticsPolicy::SkipAll);
    if let Some(schema) = kept {
        options.set_schema(schema);
    }
    let reader = ParquetMetaDataReader::new().with_metadata_options(Some(options));
    let metadata = reader.parse_and_finish(content)?;
    if !is_kept && schema.len() <= MOST_KEPT {
        let parsed = metadata.file_metadata().schema_descr_ptr();
        // A copy: the bytes are a part of the file's.
        LAST.with_borrow_mut(|last| last.keep(Bytes::copy_from_slice(schema), parsed));
    }
    Ok(metadata)
}

/// Bytes of a schema that is remembered (64 KiB): forty times those of a recording's.
const MOST_KEPT: usize = 1 << 16;

/// Runs a decoder on bytes that may be damaged: an error, or a panic of the decoder, is one error
/// of ours.
pub fn guarded<T>(
    path: &Path,
    remedy: &str,
    decode: impl FnOnce() -> Result<T, ParquetError>,
) -> Result<T, StoreError> {
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(result) => result.map_err(|e| {
            // What the operating system said when the decoder asked it for more of the file.
            let system = match &e {
                ParquetError::External(error) => error.downcast_ref::<io::Error>(),
                _ => None,
            };
            match system.filter(|error| error.raw_os_error().is_some()) {
                Some(error) => StoreError::io(path, "read", error),
                None => unreadable(path, remedy, &e.to_string()),
            }
        }),
        Err(_) => Err(unreadable(path, remedy, "the decoder gave up on it")),
    }
}

fn claim_error(path: &Path, why: Why) -> StoreError {
    match why {
        Why::Claim(words) => unreadable(path, DAMAGED, &words),
        Why::System(error) => StoreError::io(path, "read", &error),
    }
}

fn unreadable(path: &Path, remedy: &str, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable Parquet file: {why}"), remedy)
}

/// The version that a file says it has, if it is one of a file of ours: that of trials, or none of a
/// sweep.
pub(crate) fn version(
    path: &Path,
    footer: &BTreeMap<String, String>,
) -> Result<Option<Schema>, StoreError> {
    let text = footer.get(VERSION);
    let number = text.and_then(|text| {
        // `+1` and `01` are numbers too, and nothing that we write.
        text.parse::<u32>().ok().filter(|number| number.to_string() == *text)
    });
    let schema = number.and_then(Schema::from_number);
    if schema.is_some() || number == Some(TABLE_VERSION) {
        return Ok(schema);
    }
    let what = match text {
        Some(text) => format!("schema version {text} is unknown"),
        None => "not a zwidth file: no schema version in its footer".to_owned(),
    };
    let remedy = format!(
        "this software reads sweeps of version {TABLE_VERSION} and trials of versions {} and {}; use `zwidth import` for \
         other files",
        Schema::Two.number(),
        Schema::Three.number()
    );
    Err(StoreError::new(path, what, remedy))
}
