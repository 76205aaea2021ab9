//! The samples of many trials as one table: a row group for each trial, with the keys of the trial
//! beside them. Memory holds one trial.

use crate::form::constant::Constant;
use crate::form::encode::{GROUP_ROWS, read_once, recorded};
use crate::form::write::{all_entries, cannot_encode, channel_column, described, signal_column};
use crate::{Samples, Signal, StoreError};
use arrow::array::{Array as _, ArrayRef, RecordBatch};
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_writer::{
    ArrowRowGroupWriterFactory, ArrowWriterOptions, compute_leaves,
};
use parquet::errors::ParquetError;
use parquet::file::writer::SerializedFileWriter;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_study::{Channel, TaskLevel, TrialMeta};

/// What a table of samples is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasting {
    /// Kept: it is made small.
    Kept,
    /// Read once, and removed: it is made quickly.
    Once,
}

/// Writes the samples of trials into one Parquet file.
pub struct SamplesWriter<W: Write + Send> {
    path: PathBuf,
    columns: SampleColumns,
    writer: SerializedFileWriter<W>,
    column_writers: ArrowRowGroupWriterFactory,
}

/// The columns of a table of samples: the keys of each sample's trial, then signals and channels.
#[derive(Debug, Clone)]
pub struct SampleColumns {
    schema: SchemaRef,
    signals: Vec<Signal>,
    channels: Vec<Channel>,
    tasks: bool,
}

impl SampleColumns {
    /// A column for each of these signals and channels, and for what was presented where there are
    /// `tasks`.
    pub fn new(signals: &[Signal], channels: &[Channel], tasks: bool) -> Self {
        let signals = signals.to_vec();
        let channels = channels.to_vec();
        let fields = keys(None, tasks).into_iter().map(|(field, _)| field);
        let own = sample_columns(&Samples::default(), &signals, &channels).into_iter();
        let fields: Vec<Field> = fields.chain(own.map(|(field, _)| field)).collect();
        Self { schema: Arc::new(Schema::new(fields)), signals, channels, tasks }
    }

    /// What the columns are: names, types, units, descriptions.
    pub fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// The signals among them.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// The study's own channels among them.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The samples of a trial; null throughout where it lacks a signal. `path` is for errors.
    ///
    /// # Errors
    /// Columns of different lengths, which no trial that was read has.
    pub fn batch(
        &self,
        meta: &TrialMeta,
        samples: &Samples,
        path: &Path,
    ) -> Result<RecordBatch, StoreError> {
        let keys = keys(Some(meta), self.tasks).into_iter();
        let keys = keys.map(|(_, constant)| constant.array(samples.len()));
        let own = sample_columns(samples, &self.signals, &self.channels);
        let arrays = keys.chain(own.into_iter().map(|(_, array)| array)).collect();
        RecordBatch::try_new(self.schema.clone(), arrays).map_err(|e| StoreError::defect(path, &e))
    }
}

impl<W: Write + Send> SamplesWriter<W> {
    /// Begins a file with a column for each of these signals and channels, and with what was presented
    /// where there are `tasks`; `path` is its final place, for errors.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin(
        out: W,
        signals: &[Signal],
        channels: &[Channel],
        tasks: bool,
        lasting: Lasting,
        path: &Path,
    ) -> Result<Self, StoreError> {
        let columns = SampleColumns::new(signals, channels, tasks);
        let schema = columns.schema.clone();
        let encoded = |e| cannot_encode(path, &e);
        let properties = match lasting {
            Lasting::Kept => recorded(&schema, Vec::new(), None).map_err(encoded)?,
            Lasting::Once => read_once(&schema),
        };
        let options = ArrowWriterOptions::new().with_properties(properties);
        let options = options.with_skip_arrow_metadata(true); // it is among the entries
        let writer = ArrowWriter::try_new_with_options(out, schema.clone(), options);
        let (writer, column_writers) =
            writer.and_then(ArrowWriter::into_serialized_writer).map_err(encoded)?;
        Ok(Self { path: path.to_owned(), columns, writer, column_writers })
    }

    /// The columns of the file: name, unit, description, type in Arrow.
    pub fn fields(&self) -> impl Iterator<Item = (&str, &str, &str, String)> {
        self.columns.schema.fields().iter().map(|field| {
            let said = |key| field.metadata().get(key).map_or("", String::as_str);
            let kind = field.data_type().to_string();
            (field.name().as_str(), said("unit"), said("description"), kind)
        })
    }

    /// Adds a trial, in a row group of its own: in several where it is longer than one may be.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn add(&mut self, meta: &TrialMeta, samples: &Samples) -> Result<(), StoreError> {
        let keys = keys(Some(meta), self.columns.tasks);
        let own = sample_columns(samples, &self.columns.signals, &self.columns.channels);
        for first in (0..samples.len()).step_by(GROUP_ROWS) {
            let rows = GROUP_ROWS.min(samples.len() - first);
            self.add_group(&keys, &own, first, rows).map_err(|e| cannot_encode(&self.path, &e))?;
        }
        Ok(())
    }

    fn add_group(
        &mut self,
        keys: &[(Field, Constant)],
        own: &[(Field, ArrayRef)],
        first: usize,
        rows: usize,
    ) -> Result<(), ParquetError> {
        let writers = self.column_writers.create_column_writers(0)?; // the number serves encryption alone
        let described = self.writer.schema_descr().columns().to_vec();
        let mut group = self.writer.next_row_group()?;
        let n = u32::try_from(rows).map_err(|e| ParquetError::External(e.into()))?;
        for ((_, key), column) in keys.iter().zip(described) {
            key.append(n, column, &mut group)?;
        }
        for ((field, array), mut writer) in own.iter().zip(writers.into_iter().skip(keys.len())) {
            for leaf in compute_leaves(field, &array.slice(first, rows))? {
                writer.write(&leaf)?;
            }
            writer.close()?.append_to_row_group(&mut group)?;
        }
        group.close().map(drop)
    }

    /// Ends the file, with what its footer says.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn end(mut self, footer: BTreeMap<String, String>) -> Result<(), StoreError> {
        for entry in all_entries(&self.columns.schema, footer) {
            self.writer.append_key_value_metadata(entry);
        }
        self.writer.close().map(drop).map_err(|e| cannot_encode(&self.path, &e))
    }
}

fn sample_columns(
    samples: &Samples,
    signals: &[Signal],
    channels: &[Channel],
) -> Vec<(Field, ArrayRef)> {
    let signals = signals.iter().map(|signal| signal_column(signal.column(), samples));
    signals.chain(channels.iter().map(|channel| channel_column(channel, samples))).collect()
}

/// Which trial a sample is of, the same for each of its samples.
fn keys(meta: Option<&TrialMeta>, tasks: bool) -> Vec<(Field, Constant)> {
    let text = |name: &str, value: Option<&str>, about: &str| {
        let field = described(name, DataType::Utf8, true, "1", about);
        (field, Constant::Text(value.map(str::to_owned)))
    };
    let whole = |name: &str, value: Option<u32>, about: &str| {
        let value = value.and_then(|value| i32::try_from(value).ok());
        (described(name, DataType::Int32, true, "1", about), Constant::Whole(value))
    };
    let mut keys = vec![
        text("participant", meta.map(|m| m.participant.as_str()), "who"),
        text("session", meta.map(|m| m.session.as_str()), "in which session"),
        whole("trial", meta.map(|m| m.trial), "its number in the session"),
        whole("repeat", meta.map(|m| m.repeat), "of its condition"),
        text("environment", meta.map(|m| m.environment.as_str()), "what was rendered"),
        text("mode", meta.map(|m| m.mode.as_str()), "how it was rendered"),
        text("source", meta.map(|m| m.source.as_str()), "where its numbers come from"),
    ];
    if tasks {
        let presented = meta.and_then(|meta| meta.presented.as_ref());
        let interval = presented.map(|own| own.interval.into());
        let level = presented.and_then(|own| own.level).map(TaskLevel::value);
        let task = presented.map(|own| own.task.as_str());
        keys.push(text("task", task, "the task of the presentation; null outside of tasks"));
        keys.push(whole("interval", interval, "which interval of a presentation, from 1"));
        let about = "what was presented, in the unit of what the task varies";
        let field = described("level", DataType::Float64, true, "1", about);
        keys.push((field, Constant::Number(level)));
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::read::tests::{sample_trial, written};
    use arrow::array::AsArray as _;
    use arrow::datatypes::{Float32Type, Float64Type, Int32Type};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

    #[test]
    fn each_trial_is_a_row_group_with_its_keys_and_what_it_lacks_is_null() {
        let (_folder, _, path) = written();
        let whole = crate::read_trial(&path, Signal::all()).unwrap();
        let mut without = sample_trial();
        without.meta.trial = 18;
        let t = without.samples.get(Signal::Time).unwrap().to_vec();
        without.samples = Samples::default();
        without.samples.set(Signal::Time, t);
        let mut bytes = Vec::new();
        let signals = [Signal::Time, Signal::Theta, Signal::VoltageMotor];
        let mut writer =
            SamplesWriter::begin(&mut bytes, &signals, &[], false, Lasting::Kept, Path::new("x"))
                .unwrap();
        let fields: Vec<String> = writer.fields().map(|(name, ..)| name.to_owned()).collect();
        writer.add(&whole.meta, &whole.samples).unwrap();
        writer.add(&without.meta, &without.samples).unwrap();
        writer.end(BTreeMap::from([("source".to_owned(), "twin".to_owned())])).unwrap();
        let keys = "participant session trial repeat environment mode source";
        assert_eq!(fields.join(" "), format!("{keys} t_s theta_rad voltage_motor_v"));
        let file = ParquetRecordBatchReaderBuilder::try_new(bytes::Bytes::from(bytes)).unwrap();
        let groups = file.metadata().row_groups().iter();
        assert_eq!(groups.map(|group| group.num_rows()).collect::<Vec<_>>(), [200, 200]);
        let rows: Vec<RecordBatch> =
            file.with_batch_size(200).build().unwrap().map(Result::unwrap).collect();
        let numbers = |batch: &RecordBatch, name: &str| {
            batch.column_by_name(name).unwrap().as_primitive::<Float64Type>().values().to_vec()
        };
        assert_eq!(numbers(&rows[0], "theta_rad"), whole.samples.get(Signal::Theta).unwrap());
        let volts = rows[0].column_by_name("voltage_motor_v").unwrap();
        let volts = volts.as_primitive::<Float32Type>().values().iter().map(|v| f64::from(*v));
        assert!(volts.eq(whole.samples.get(Signal::VoltageMotor).unwrap().iter().copied()));
        assert_eq!(rows[1].column_by_name("theta_rad").unwrap().null_count(), 200);
        let trials = rows[1].column_by_name("trial").unwrap();
        assert_eq!(trials.as_primitive::<Int32Type>().value(0), 18);
    }
}
