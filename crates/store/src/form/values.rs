//! The values of one column of a recording, whatever their encoding in its file.

use crate::form::bounds::MOST_RECORDED_BYTES;
use crate::form::digest::ColumnDigest;
use crate::form::opened::{BATCH_ROWS, DAMAGED, ParquetFile, guarded};
use crate::form::pages::Pages;
use crate::form::write::DIGEST;
use crate::{Storage, StoreError};
use arrow::array::{Array, ArrayRef, AsArray};
use arrow::datatypes::{DataType, Float32Type, Float64Type, UInt16Type};
use parquet::basic::Type as PhysicalType;
use parquet::column::reader::ColumnReaderImpl;
use parquet::data_type::{DataType as ParquetType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::schema::types::ColumnDescPtr;
use rayon::prelude::*;
use std::ops::Range;

/// The values of one column of a trial, in the memory of `room`; `None` where the column is null
/// throughout. One that is known to match its digest is not held against it.
pub(crate) fn column_values(
    file: &ParquetFile,
    name: &str,
    storage: Storage,
    room: Vec<f64>,
    is_known: bool,
) -> Result<Option<Vec<f64>>, StoreError> {
    let digest = file.footer.get(&format!("{DIGEST}{name}"));
    // What comes out of a file is as narrow as its storage.
    let new_digest = || (!is_known).then(|| ColumnDigest::new(Storage::F64));
    let mut digest_now = new_digest();
    let mut whole = Part { values: room, ..Part::default() };
    if digest.is_some() && in_place(file, name, storage, &mut whole.values, &mut digest_now) {
        whole.rows = whole.values.len();
    } else {
        file.check_pages(&[name], MOST_RECORDED_BYTES)?;
        // Without a digest it has no value, or is damaged: no room is taken for it.
        whole.values.clear();
        digest_now = new_digest();
        let mut groups = file.groups();
        // One part is taken as it was decoded.
        let is_joined = groups.len() > 1 && digest.is_some();
        whole.values.reserve_exact(if is_joined { file.rows } else { 0 });
        let wanted = (name, storage, digest.is_some());
        let mut parts = some_groups(file, wanted, &mut groups)?;
        // Nobody is woken where nothing is left to be decoded meanwhile: a short trial has one group.
        while !groups.is_empty() {
            let (next, ()) = rayon::join(
                || some_groups(file, wanted, &mut groups),
                || add_parts(&mut whole, &mut digest_now, parts),
            );
            parts = next?;
        }
        add_parts(&mut whole, &mut digest_now, parts);
    }
    let Part { values, rows, nulls, first_null, is_missing } = whole;
    if is_missing {
        return Err(column_error(file, name, "the column is missing"));
    }
    // With a digest it had values once.
    if nulls == rows && digest.is_none() {
        return Ok(None);
    }
    if let Some(row) = first_null {
        let what = "the value is null in a column that has others";
        return Err(column_error(file, name, what).row0(row));
    }
    if digest.is_none_or(|digest| digest_now.is_some_and(|now| now.end() != *digest)) {
        let what = "the column is damaged: its values do not match their digest";
        return Err(column_error(file, name, what));
    }
    Ok(Some(values))
}

/// Decodes a column of several row groups into `values`, as many groups at a time as there are cores,
/// and digests those before meanwhile; whether all lie as the writer of recordings lays them. Then no page
/// claims more than its values take, and nothing else bounds them.
fn in_place(
    file: &ParquetFile,
    name: &str,
    storage: Storage,
    values: &mut Vec<f64>,
    digest: &mut Option<ColumnDigest>,
) -> bool {
    let rows = file.metadata.row_groups().iter().map(|g| usize::try_from(g.num_rows()));
    let Ok(rows) = rows.collect::<Result<Vec<usize>, _>>() else { return false };
    if rows.len() < 2 {
        return false;
    }
    values.clear();
    values.reserve_exact(file.rows);
    let mut digested = 0;
    let groups: Vec<(usize, usize)> = rows.into_iter().enumerate().collect();
    for some in groups.chunks(rayon::current_num_threads()) {
        let from = values.len();
        values.resize(from + some.iter().map(|(_, rows)| rows).sum::<usize>(), 0.0);
        let (before, mut new) = values.split_at_mut(from);
        let mut own = Vec::new();
        for (group, rows) in some {
            let (first, rest) = new.split_at_mut(*rows);
            own.push((*group, first));
            new = rest;
        }
        let (are_split, ()) = rayon::join(
            || own.into_par_iter().all(|(group, own)| split(file, (name, storage), group, own)),
            || digest.iter_mut().for_each(|digest| digest.add(&before[digested..])),
        );
        if !are_split {
            return false;
        }
        digested = from;
    }
    digest.iter_mut().for_each(|digest| digest.add(&values[digested..]));
    true
}

/// Decodes a row group of a column whose bytes are split into streams, without a null; whether it is such
/// a one.
fn split(
    file: &ParquetFile,
    (name, storage): (&str, Storage),
    group: usize,
    into: &mut [f64],
) -> bool {
    let pages = pages_of(file, (name, storage), group);
    let split = pages.and_then(|(_, pages)| match storage {
        Storage::F64 => pages.split_values::<f64>(into),
        Storage::F32 => pages.split_values::<f32>(into),
        Storage::U16 => None,
    });
    split.is_some()
}

fn add_parts(whole: &mut Part, digest: &mut Option<ColumnDigest>, parts: Vec<Part>) {
    for part in parts {
        if let Some(digest) = digest {
            digest.add(&part.values);
        }
        whole.add(part);
    }
}

fn column_error(file: &ParquetFile, name: &str, what: &str) -> StoreError {
    StoreError::new(&file.path, what, DAMAGED).column(name)
}

/// What some rows of a column hold.
#[derive(Default)]
struct Part {
    /// As far as there are any.
    values: Vec<f64>,
    rows: usize,
    nulls: usize,
    first_null: Option<usize>,
    is_missing: bool,
}

impl Part {
    fn add(&mut self, next: Self) {
        self.first_null = self.first_null.or(next.first_null.map(|row| self.rows + row));
        self.rows += next.rows;
        self.nulls += next.nulls;
        self.is_missing |= next.is_missing;
        if self.values.capacity() == 0 {
            self.values = next.values;
        } else {
            self.values.extend_from_slice(&next.values);
        }
    }
}

/// The next row groups of a column, as many as there are cores, decoded side by side.
fn some_groups(
    file: &ParquetFile,
    column: Wanted,
    groups: &mut Range<usize>,
) -> Result<Vec<Part>, StoreError> {
    let next: Vec<usize> = groups.take(rayon::current_num_threads()).collect();
    match *next {
        // One is decoded in this thread: nobody is woken for it.
        [group] => Ok(vec![decode(file, column, group)?]),
        _ => next.into_par_iter().map(|group| decode(file, column, group)).collect(),
    }
}

fn decode(file: &ParquetFile, column: Wanted, group: usize) -> Result<Part, StoreError> {
    match decoded_by_pages(file, column, group)? {
        Some(part) => Ok(part),
        None => decoded(file, column, group),
    }
}

/// A column's name, its type, and whether its values are wanted: else it is only counted.
type Wanted<'a> = (&'a str, Storage, bool);

/// The pages of a row group of a column, if the writer of recordings laid them.
fn pages_of(
    file: &ParquetFile,
    (name, storage): (&str, Storage),
    group: usize,
) -> Option<(ColumnDescPtr, Pages)> {
    let mut columns = file.metadata.row_group(group).columns().iter();
    let column = columns.find(|c| *c.column_path().parts() == [name])?;
    let descr = column.column_descr_ptr();
    let physical = match storage {
        Storage::F64 => PhysicalType::DOUBLE,
        Storage::F32 => PhysicalType::FLOAT,
        Storage::U16 => PhysicalType::INT32,
    };
    let is_plain = descr.max_rep_level() == 0 && descr.max_def_level() == 1;
    let is_ours = is_plain && column.column_type() == physical;
    Some((descr, Pages::of(&file.content, column).filter(|_| is_ours)?))
}

/// A row group of a column as the writer of recordings laid it; `None` where another writer laid it
/// otherwise.
fn decoded_by_pages(
    file: &ParquetFile,
    (name, storage, has_values): Wanted,
    group: usize,
) -> Result<Option<Part>, StoreError> {
    let Some((descr, pages)) = pages_of(file, (name, storage), group) else { return Ok(None) };
    let rows = usize::try_from(file.metadata.row_group(group).num_rows()).unwrap_or(0);
    // Checked first: the headers, not the group, decide how much memory is taken.
    if has_values && storage != Storage::U16 && pages.rows() == rows {
        let mut values = vec![0.0; rows];
        let split = match storage {
            Storage::F32 => pages.split_values::<f32>(&mut values),
            _ => pages.split_values::<f64>(&mut values),
        };
        if split.is_some() {
            return Ok(Some(Part { values, rows, ..Part::default() }));
        }
    }
    guarded(&file.path, DAMAGED, || match storage {
        Storage::F64 => part_of::<DoubleType>(descr, pages, rows, has_values, |values| values),
        Storage::F32 => part_of::<FloatType>(descr, pages, rows, has_values, widened),
        Storage::U16 => part_of::<Int32Type>(descr, pages, rows, has_values, widened),
    })
    .map(Some)
}

fn widened<V: Into<f64>>(values: Vec<V>) -> Vec<f64> {
    values.into_iter().map(Into::into).collect()
}

fn part_of<T: ParquetType>(
    descr: ColumnDescPtr,
    pages: Pages,
    rows: usize,
    has_values: bool,
    widened: impl Fn(Vec<T::T>) -> Vec<f64>,
) -> Result<Part, ParquetError> {
    let mut reader = ColumnReaderImpl::<T>::new(descr, Box::new(pages));
    let mut values = Vec::new();
    let mut is_there = Vec::new();
    let mut part = Part::default();
    while part.rows < rows {
        // So many at a time: what a file claims decides no allocation.
        let most = (rows - part.rows).min(BATCH_ROWS);
        is_there.clear();
        let (read, _, _) = reader.read_records(most, Some(&mut is_there), None, &mut values)?;
        if read == 0 {
            break;
        }
        let nulls = is_there.iter().filter(|is_there| **is_there == 0).count();
        if nulls > 0 && part.first_null.is_none() {
            let first = is_there.iter().position(|is_there| *is_there == 0);
            part.first_null = first.map(|row| part.rows + row);
        }
        (part.rows, part.nulls) = (part.rows + read, part.nulls + nulls);
        if !has_values || part.first_null.is_some() {
            values.clear();
        }
    }
    part.values = widened(values);
    Ok(part)
}

/// A row group of a column in any form that the parquet crate reads.
fn decoded(
    file: &ParquetFile,
    (name, _, has_values): Wanted,
    group: usize,
) -> Result<Part, StoreError> {
    let mut part = Part::default();
    file.each_batch(file.columns()?, &[name], group..group + 1, |batch| {
        let Some(array) = batch.column_by_name(name) else {
            part.is_missing = true;
            return;
        };
        if array.null_count() > 0 && part.first_null.is_none() {
            let null = (0..array.len()).find(|i| array.is_null(*i));
            part.first_null = null.map(|i| part.rows + i);
        }
        (part.rows, part.nulls) = (part.rows + array.len(), part.nulls + array.null_count());
        if has_values && part.first_null.is_none() {
            extend_with(&mut part.values, array);
        }
    })?;
    Ok(part)
}

/// A numeric column as `f64`; its type was checked before.
pub(crate) fn floats(array: &ArrayRef) -> Vec<f64> {
    let mut values = Vec::new();
    extend_with(&mut values, array);
    values
}

/// Adds a numeric column as `f64`.
fn extend_with(values: &mut Vec<f64>, array: &ArrayRef) {
    match array.data_type() {
        DataType::Float64 => {
            values.extend_from_slice(array.as_primitive::<Float64Type>().values());
        }
        DataType::Float32 => {
            values
                .extend(array.as_primitive::<Float32Type>().values().iter().map(|v| f64::from(*v)));
        }
        DataType::UInt16 => {
            values
                .extend(array.as_primitive::<UInt16Type>().values().iter().map(|v| f64::from(*v)));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::read::tests::written;
    use crate::{RealFiles, Signal, read_trial};
    use bytes::Bytes;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::arrow::{ARROW_SCHEMA_META_KEY, ArrowWriter};
    use parquet::basic::Compression;
    use parquet::file::properties::{WriterProperties, WriterVersion};

    /// The rows of a file, laid by another writer.
    fn laid(
        bytes: &[u8],
        version: WriterVersion,
        compression: Compression,
        page: usize,
    ) -> Vec<u8> {
        let reader =
            ParquetRecordBatchReaderBuilder::try_new(Bytes::copy_from_slice(bytes)).unwrap();
        let entries = reader.metadata().file_metadata().key_value_metadata().unwrap().iter();
        let entries = entries.filter(|entry| entry.key != ARROW_SCHEMA_META_KEY);
        let properties = WriterProperties::builder()
            .set_writer_version(version)
            .set_compression(compression)
            .set_data_page_row_count_limit(page)
            .set_write_batch_size(page)
            .set_key_value_metadata(Some(entries.cloned().collect()))
            .build();
        let mut bytes = Vec::new();
        let schema = reader.schema().clone();
        let mut writer = ArrowWriter::try_new(&mut bytes, schema, Some(properties)).unwrap();
        reader.build().unwrap().for_each(|batch| writer.write(&batch.unwrap()).unwrap());
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn what_is_put_together_from_streams_is_what_the_parquet_crate_reads() {
        let (_folder, trial, path) = written();
        let file = ParquetFile::open_recording(&RealFiles, &path).unwrap();
        let columns = file.metadata.row_group(0).columns();
        let mut split = 0;
        for signal in Signal::all().filter(|signal| trial.samples.get(*signal).is_some()) {
            let (name, storage) = (signal.name(), signal.column().storage);
            let column = columns.iter().find(|c| c.column_path().string() == name).unwrap();
            let pages = || Pages::of(&file.content, column).unwrap();
            let split_as = |storage: Storage, rows: usize| {
                let mut values = vec![0.0; rows];
                let split = match storage {
                    Storage::F64 => pages().split_values::<f64>(&mut values),
                    Storage::F32 => pages().split_values::<f32>(&mut values),
                    Storage::U16 => None,
                };
                split.map(|()| values)
            };
            let found = split_as(storage, file.rows);
            let is_split = crate::encoding_of(name) == crate::Encoding::ByteStreamSplit;
            assert_eq!(found.is_some(), is_split, "{name}");
            let Some(found) = found else { continue };
            split += 1;
            assert_eq!(found, decoded(&file, (name, storage, true), 0).unwrap().values, "{name}");
            for rows in [file.rows - 1, file.rows + 1] {
                assert_eq!(split_as(storage, rows), None);
            }
            let other = if storage == Storage::F64 { Storage::F32 } else { Storage::F64 };
            let other = split_as(other, file.rows);
            assert_eq!(other, None, "{name}: numbers of another width");
        }
        assert!(split > 2, "{split}");
    }

    #[test]
    fn however_the_pages_of_a_file_are_laid_its_values_are_the_same() {
        use Compression::{SNAPPY, UNCOMPRESSED, ZSTD};
        use WriterVersion::{PARQUET_1_0, PARQUET_2_0};
        let (_folder, _, path) = written();
        let (bytes, trial) =
            (std::fs::read(&path).unwrap(), read_trial(&path, Signal::all()).unwrap());
        let zstd = ZSTD(Default::default());
        for (version, compression, page, by_pages) in [
            (PARQUET_1_0, zstd, 1000, true),
            (PARQUET_1_0, zstd, 7, true),
            (PARQUET_1_0, UNCOMPRESSED, 7, true),
            (PARQUET_1_0, SNAPPY, 7, false),
            (PARQUET_2_0, zstd, 7, false),
        ] {
            std::fs::write(&path, laid(&bytes, version, compression, page)).unwrap();
            let file = ParquetFile::open_recording(&RealFiles, &path).unwrap();
            for signal in Signal::all().filter(|signal| trial.samples.get(*signal).is_some()) {
                let wanted = (signal.name(), signal.column().storage, true);
                let found = decoded_by_pages(&file, wanted, 0).unwrap();
                assert_eq!(found.is_some(), by_pages, "{version:?}, {compression:?}, {page}");
                let expect = trial.samples.get(signal).unwrap();
                assert_eq!(found.map_or_else(|| expect.to_vec(), |part| part.values), expect);
            }
            assert_eq!(read_trial(&path, Signal::all()).unwrap(), trial);
        }
    }
}
