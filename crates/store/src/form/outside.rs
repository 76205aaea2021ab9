//! Tables of metrics that other programs computed: one value per trial.

use crate::form::opened::ParquetFile;
use crate::form::read::check_described;
use crate::form::write::described;
use crate::{Files, StoreError, write_parquet};
use arrow::array::{
    Array as _, ArrayRef, AsArray as _, Float64Array, Int64Array, RecordBatch, StringArray,
};
use arrow::datatypes::{DataType, Field, Float64Type, Int64Type, Schema};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use zwidth_study::{IdError, OutsideMetric, ParticipantId, SessionId};

/// One value of a metric from outside, and the recording that it speaks of.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideRow {
    /// Who.
    pub participant: ParticipantId,
    /// In which session.
    pub session: SessionId,
    /// Its number in the session.
    pub trial: u32,
    /// The value; `None` where there is none.
    pub value: Option<f64>,
    /// BLAKE3 of the trial's file when the value was given, hexadecimal.
    pub recording: String,
}

/// The columns, as [`zwidth_study::OutsideMetric`] and the rows fill them.
const PARTICIPANT: &str = "participant";
const SESSION: &str = "session";
const TRIAL: &str = "trial";
const VALUE: &str = "value";
const RECORDING: &str = "recording_blake3";

const REMEDY: &str = "restore the file from a copy, or give the table again";

/// The bytes of a table of a metric from outside.
///
/// # Errors
/// No row; a value that is not finite, with its row.
pub fn outside_bytes(
    metric: &OutsideMetric,
    table: u32,
    rows: &[OutsideRow],
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    if rows.is_empty() {
        return Err(StoreError::new(path, "there is no value", "give a table with rows"));
    }
    let is_finite = |row: &OutsideRow| row.value.is_none_or(f64::is_finite);
    if let Some(row) = rows.iter().position(|row| !is_finite(row)) {
        let error = StoreError::new(path, "it is not a finite number", "mend or drop the row");
        return Err(error.column(VALUE).row0(row));
    }
    let texts = |text: fn(&OutsideRow) -> &str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(rows.iter().map(text)))
    };
    let trials = Int64Array::from_iter_values(rows.iter().map(|row| i64::from(row.trial)));
    let values = Float64Array::from_iter(rows.iter().map(|row| row.value));
    let text = |name: &str, about: &str| described(name, DataType::Utf8, false, "1", about);
    let columns: Vec<(Field, ArrayRef)> = vec![
        (text(PARTICIPANT, "who"), texts(|row| row.participant.as_str())),
        (text(SESSION, "in which session"), texts(|row| row.session.as_str())),
        (
            described(TRIAL, DataType::Int64, false, "1", "its number in the session"),
            Arc::new(trials),
        ),
        (described(VALUE, DataType::Float64, true, &metric.unit, &metric.label), Arc::new(values)),
        (
            text(RECORDING, "BLAKE3 of the trial's file when the value was given"),
            texts(|row| &row.recording),
        ),
    ];
    let footer = BTreeMap::from([
        ("metric".to_owned(), metric.id.to_string()),
        ("table".to_owned(), table.to_string()),
        ("unit".to_owned(), metric.unit.clone()),
        ("label".to_owned(), metric.label.clone()),
        ("computed_by".to_owned(), metric.program.clone().unwrap_or_default()),
    ]);
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
        .map_err(|e| StoreError::defect(path, &e))?;
    write_parquet(&batch, footer, path)
}

/// The rows of a table of a metric with that unit, and BLAKE3 of its file, hexadecimal.
///
/// # Errors
/// A file that is damaged, or is no such table.
pub(crate) fn read_outside(
    files: &dyn Files,
    path: &Path,
    unit: &str,
) -> Result<(Vec<OutsideRow>, String), StoreError> {
    let mended = |error: StoreError| StoreError { remedy: REMEDY.to_owned(), ..error };
    let file = ParquetFile::open_recording(files, path).map_err(mended)?;
    let blake3 = file.blake3()?;
    let columns = file.columns().map_err(mended)?;
    let text = [PARTICIPANT, SESSION, RECORDING].map(|name| (name, DataType::Utf8, "1"));
    let numbers = [(TRIAL, DataType::Int64, "1"), (VALUE, DataType::Float64, unit)];
    for (name, kind, unit) in text.into_iter().chain(numbers) {
        check_described(path, columns.schema(), name, &kind, unit).map_err(mended)?;
    }
    let names = [PARTICIPANT, SESSION, TRIAL, VALUE, RECORDING];
    let batch = file.read(columns, &names).map_err(mended)?;
    let column = |name: &str| {
        let missing = || StoreError::new(path, "the column is missing", REMEDY).column(name);
        batch.column_by_name(name).ok_or_else(missing)
    };
    let [participants, sessions, recordings] = [PARTICIPANT, SESSION, RECORDING].map(column);
    let (participants, sessions, recordings) = (participants?, sessions?, recordings?);
    let (trials, values) = (column(TRIAL)?, column(VALUE)?);
    let trials = trials.as_primitive::<Int64Type>();
    let values = values.as_primitive::<Float64Type>();
    let rows = (0..batch.num_rows()).map(|row| {
        let bad =
            |name: &str, what: String| StoreError::new(path, what, REMEDY).column(name).row0(row);
        let id = |name: &str, error: IdError| bad(name, error.to_string());
        let number = trials.value(row);
        Ok(OutsideRow {
            participant: participants
                .as_string::<i32>()
                .value(row)
                .parse()
                .map_err(|e| id(PARTICIPANT, e))?,
            session: sessions.as_string::<i32>().value(row).parse().map_err(|e| id(SESSION, e))?,
            trial: u32::try_from(number)
                .map_err(|_| bad(TRIAL, format!("{number} is no trial")))?,
            value: values.is_valid(row).then(|| values.value(row)),
            recording: recordings.as_string::<i32>().value(row).to_owned(),
        })
    });
    Ok((rows.collect::<Result<_, StoreError>>()?, blake3))
}
