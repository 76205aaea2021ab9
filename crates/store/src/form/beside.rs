//! Streams that other programs recorded beside a session: a row for each of their samples.

use crate::form::write::described;
use crate::{StoreError, write_parquet};
use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
use arrow::datatypes::{DataType, Schema};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use zwidth_study::StreamId;

/// The columns before a stream's channels.
const STAMP: &str = "stamp_s";
const RECORDER: &str = "recorder_s";
const TRIAL: &str = "trial";
const TIME: &str = "t_s";

/// A stream, with the trial and the time in it of each of its samples.
#[derive(Debug, Clone)]
pub struct BesideStream {
    /// What it is called here.
    pub id: StreamId,
    /// The times that the stream's source gave its samples, by its own clock, s.
    pub stamp_s: Vec<f64>,
    /// The same by the recorder's clock, s.
    pub recorder_s: Vec<f64>,
    /// The trial during which each was taken, and when in it, s: as `t_s` of the trial's file.
    pub in_trial: Vec<Option<(u32, f64)>>,
    /// Its channels.
    pub channels: Vec<BesideChannel>,
    /// What is told of the stream in the file's footer.
    pub about: BTreeMap<String, String>,
}

/// A channel of a stream, and the column that it becomes.
#[derive(Debug, Clone)]
pub struct BesideChannel {
    /// The column's name.
    pub name: String,
    /// The unit that the recording names; `1` for none.
    pub unit: String,
    /// What the recording calls it.
    pub label: String,
    /// A value for each sample.
    pub values: ArrayRef,
}

impl BesideStream {
    /// Whether a channel may have this name.
    pub fn is_taken(name: &str) -> bool {
        [STAMP, RECORDER, TRIAL, TIME, "participant", "session"].contains(&name)
    }
}

/// The bytes of a stream's table.
///
/// # Errors
/// Columns of unequal lengths, which is a defect.
pub(crate) fn beside_bytes(
    stream: &BesideStream,
    table: u32,
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    let seconds = |values: &[f64]| -> ArrayRef { Arc::new(Float64Array::from(values.to_vec())) };
    let trials =
        Int64Array::from_iter(stream.in_trial.iter().map(|at| at.map(|(trial, _)| trial.into())));
    let times = Float64Array::from_iter(stream.in_trial.iter().map(|at| at.map(|(_, t_s)| t_s)));
    let number =
        |name, nullable, unit, about| described(name, DataType::Float64, nullable, unit, about);
    let mut columns: Vec<(_, ArrayRef)> = vec![
        (
            number(STAMP, false, "s", "time by the clock of the stream's source"),
            seconds(&stream.stamp_s),
        ),
        (
            number(RECORDER, false, "s", "the same by the recorder's clock"),
            seconds(&stream.recorder_s),
        ),
        (
            described(TRIAL, DataType::Int64, true, "1", "the trial during which it was taken"),
            Arc::new(trials),
        ),
        (number(TIME, true, "s", "time since that trial's start, as in its file"), Arc::new(times)),
    ];
    columns.extend(stream.channels.iter().map(|channel| {
        let BesideChannel { name, unit, label, values } = channel;
        (described(name, values.data_type().clone(), true, unit, label), Arc::clone(values))
    }));
    let mut footer = stream.about.clone();
    footer.insert("stream".to_owned(), stream.id.to_string());
    footer.insert("table".to_owned(), table.to_string());
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
        .map_err(|e| StoreError::defect(path, &e))?;
    write_parquet(&batch, footer, path)
}
