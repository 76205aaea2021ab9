//! The row groups of a trial that is written part by part. Columns with values are encoded side by side
//! as their rows come. Those that say the same in each row are most of a trial's: they are encoded once
//! for all groups that were put together alike. The bytes are those that `ArrowWriter` gives.

use arrow::array::{ArrayRef, RecordBatch};
use arrow::datatypes::SchemaRef;
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_writer::{
    ArrowColumnWriter, ArrowRowGroupWriterFactory, ArrowWriterOptions, compute_leaves,
};
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;

/// The row groups of a file that grows.
pub(crate) struct Groups<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    factory: ArrowRowGroupWriterFactory,
    schema: SchemaRef,
    /// Rows of each group but the last.
    most: usize,
    group: Group,
    /// The columns that say the same in each row, as many rows of them as are added at a time.
    same: RecordBatch,
    /// The same columns of a group that was put together of so many rows each time.
    encoded: Option<(Vec<usize>, Same)>,
}

/// The group that is being written.
#[derive(Default)]
struct Group {
    /// The columns with values, and their places.
    columns: Vec<(usize, ArrowColumnWriter)>,
    /// How many rows were added each time.
    parts: Vec<usize>,
    rows: usize,
}

/// Columns of a row group, encoded.
struct Same {
    bytes: Bytes,
    /// By their places.
    columns: BTreeMap<usize, ColumnCloseResult>,
}

impl<W: Write + Send> Groups<W> {
    /// Begins a file with the columns of `every`, in groups of `most` rows. It has as many rows as will be
    /// added at a time; those of its columns that are never added are the same in each row.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn begin(
        out: W,
        every: RecordBatch,
        properties: WriterProperties,
        most: usize,
    ) -> Result<Self> {
        let schema = every.schema();
        let writer = ArrowWriter::try_new(out, schema.clone(), Some(properties))?;
        let (writer, factory) = writer.into_serialized_writer()?;
        let group = Group::default();
        Ok(Self { writer, factory, schema, most, group, same: every, encoded: None })
    }

    /// Adds rows: the columns with values, each behind its place, in their order; the same ones each time.
    ///
    /// # Errors
    /// Those of the writer.
    pub(crate) fn add(&mut self, columns: &[(usize, ArrayRef)], rows: usize) -> Result<()> {
        let mut from = 0;
        while from < rows {
            if self.group.rows == 0 {
                self.open(columns)?;
            }
            let length = (rows - from).min(self.most - self.group.rows).min(self.same.num_rows());
            let fields = self.schema.fields();
            let columns = columns.par_iter().zip(&mut self.group.columns);
            columns.try_for_each(|((place, array), (_, writer))| {
                let leaves = compute_leaves(&fields[*place], &array.slice(from, length))?;
                leaves.iter().try_for_each(|leaf| writer.write(leaf))
            })?;
            self.group.parts.push(length);
            self.group.rows += length;
            from += length;
            if self.group.rows == self.most {
                self.close()?;
            }
        }
        Ok(())
    }

    /// Ends the file, whose footer has these entries too.
    ///
    /// # Errors
    /// Those of the writer.
    pub(crate) fn end(&mut self, entries: Vec<KeyValue>) -> Result<()> {
        if self.group.rows > 0 {
            self.close()?;
        }
        for entry in entries {
            self.writer.append_key_value_metadata(entry);
        }
        self.writer.finish().map(drop)
    }

    /// What it writes into.
    pub(crate) fn out(&mut self) -> &mut W {
        self.writer.inner_mut()
    }

    fn open(&mut self, columns: &[(usize, ArrayRef)]) -> Result<()> {
        let number = self.writer.flushed_row_groups().len();
        let writers = self.factory.create_column_writers(number)?.into_iter().enumerate();
        let added = writers.filter(|(place, _)| columns.iter().any(|(added, _)| added == place));
        self.group.columns = added.collect();
        Ok(())
    }

    fn close(&mut self) -> Result<()> {
        let Group { columns, parts, .. } = std::mem::take(&mut self.group);
        let chunks = columns.into_par_iter().map(|(place, writer)| Ok((place, writer.close()?)));
        let mut chunks: BTreeMap<usize, _> = chunks.collect::<Result<_>>()?;
        let same = match self.encoded.take().filter(|(kept, _)| *kept == parts) {
            Some((_, same)) => same,
            None => self.encode_same(&parts, |place| !chunks.contains_key(&place))?,
        };
        let mut group = self.writer.next_row_group()?;
        for place in 0..self.schema.fields().len() {
            match (chunks.remove(&place), same.columns.get(&place)) {
                (Some(chunk), _) => chunk.append_to_row_group(&mut group)?,
                (None, Some(close)) => group.append_column(&same.bytes, close.clone())?,
                (None, None) => {
                    return Err(ParquetError::General(format!("column {place} was not encoded")));
                }
            }
        }
        group.close()?;
        self.encoded = Some((parts, same));
        Ok(())
    }

    /// Encodes the columns that are the same in each row, for a group of so many rows each time.
    fn encode_same(&self, parts: &[usize], is_same: impl Fn(usize) -> bool) -> Result<Same> {
        let places: Vec<usize> = (0..self.schema.fields().len()).filter(|p| is_same(*p)).collect();
        let batch = self.same.project(&places)?;
        let properties = self.writer.properties().as_ref().clone();
        let options = ArrowWriterOptions::new().with_properties(properties);
        let mut writer = ArrowWriter::try_new_with_options(Vec::new(), batch.schema(), options)?;
        for rows in parts {
            writer.write(&batch.slice(0, *rows))?;
        }
        let metadata = writer.finish()?;
        let chunks = metadata.row_group(0).columns().iter().enumerate().map(|(i, chunk)| {
            let offsets = metadata.offset_index().and_then(|groups| groups.first()?.get(i));
            ColumnCloseResult {
                bytes_written: u64::try_from(chunk.compressed_size()).unwrap_or(0),
                rows_written: parts.iter().sum::<usize>() as u64,
                metadata: chunk.clone(),
                bloom_filter: None,
                column_index: None,
                offset_index: offsets.cloned(),
            }
        });
        let columns = places.into_iter().zip(chunks).collect();
        Ok(Same { bytes: Bytes::from(std::mem::take(writer.inner_mut())), columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::encode::recorded;
    use crate::form::read::tests::{form, sample_trial};
    use crate::form::write::trial_batch;
    use std::path::Path;

    /// The file that `ArrowWriter` makes of so many rows each time, in groups of `most`, and ours.
    fn both(parts: &[usize], most: usize) -> [Vec<u8>; 2] {
        let trial = sample_trial();
        let rows = trial_batch(&trial.meta, &trial.samples, &form(), Path::new("x")).unwrap();
        let schema = rows.schema();
        let properties = || recorded(&schema, Vec::new(), Some(most)).unwrap();
        let has_values = |place: &usize| {
            let name = schema.field(*place).name();
            trial.samples.named().any(|(named, ..)| named == name)
        };
        let places: Vec<usize> = (0..rows.num_columns()).filter(has_values).collect();
        let mut theirs =
            ArrowWriter::try_new(Vec::new(), schema.clone(), Some(properties())).unwrap();
        let every = rows.slice(0, parts[0]);
        let mut ours = Groups::begin(Vec::new(), every, properties(), most).unwrap();
        let mut from = 0;
        for length in parts {
            let part = rows.slice(from, *length);
            theirs.write(&part).unwrap();
            let columns: Vec<_> = places.iter().map(|at| (*at, part.column(*at).clone())).collect();
            ours.add(&columns, *length).unwrap();
            from += length;
        }
        let entry = || KeyValue::new("key".to_owned(), "value".to_owned());
        theirs.append_key_value_metadata(entry());
        theirs.finish().unwrap();
        ours.end(vec![entry()]).unwrap();
        [std::mem::take(theirs.inner_mut()), std::mem::take(ours.out())]
    }

    #[test]
    fn groups_have_the_bytes_that_the_writer_of_arrow_gives_them() {
        let [theirs, ours] = both(&[20, 20, 20, 20, 20, 5], 40);
        assert!(theirs == ours, "groups of whole parts");
        let [theirs, ours] = both(&[20, 20, 20, 20, 20, 5], 30);
        assert!(theirs == ours, "parts that lie in two groups");
        let [theirs, ours] = both(&[20, 20], 40);
        assert!(theirs == ours, "one group");
        let [theirs, ours] = both(&[200], 1000);
        assert!(theirs == ours, "one part");
    }
}
