//! From a trial (or any record batch) to the bytes of a Parquet file.

use crate::disk::hash::hex_blake3;
use crate::form::digest::column_digest;
use crate::form::encode::{GROUP_ROWS, recorded};
use crate::memo::Memo;
use crate::{COLUMNS, Column, Samples, Storage, StoreError, Trial, TrialFile};
use arrow::array::{
    ArrayRef, DictionaryArray, Float32Array, Float64Array, Int32Array, RecordBatch, StringArray,
    UInt16Array, new_null_array,
};
use arrow::datatypes::{DataType, Field, Int32Type, Schema as ArrowSchema};
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use parquet::arrow::{ARROW_SCHEMA_META_KEY, ArrowWriter, encode_arrow_schema};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use zwidth_study::{AnswerScale, Channel, Presented, Schema, TaskLevel, TrialForm, TrialMeta};

/// Prefix of the footer keys that carry a column's digest.
pub(crate) const DIGEST: &str = "blake3:";
/// Footer key of the digest over all other keys.
pub(crate) const FOOTER_DIGEST: &str = "footer_blake3";
/// Footer key of the version of the file's form.
pub(crate) const VERSION: &str = "schema_version";
/// Version of the form of sweeps and derived tables.
pub(crate) const TABLE_VERSION: u32 = 1;
/// Footer key of the study's own channels.
pub(crate) const CHANNELS: &str = "channels";
/// Footer key of the units of all columns, for readers that do not show Arrow field metadata.
const UNITS: &str = "units";

/// The bytes of a trial's file of this form. The same trial gives the same bytes. A form without a
/// column for the answer leaves it out: it is an event.
///
/// # Errors
/// Samples that break a promise of the schema, with column and row (`Samples::check`); a signal or
/// a channel that the form has not. `path` only names the file in errors.
pub fn trial_bytes(trial: &Trial, form: &TrialForm, path: &Path) -> Result<Vec<u8>, StoreError> {
    trial.samples.check(path)?;
    trial.samples.check_form(form, path)?;
    let batch = trial_batch(&trial.meta, &trial.samples, form, path)?;
    let mut footer = footer(&trial.meta, &trial.file, form);
    for (name, storage, values) in trial.samples.named() {
        footer.insert(format!("{DIGEST}{name}"), column_digest(values, storage));
    }
    write(&batch, footer, Some(GROUP_ROWS), path)
}

/// The rows of a trial, or some of them, as its file of this form has them.
pub(crate) fn trial_batch(
    meta: &TrialMeta,
    samples: &Samples,
    form: &TrialForm,
    path: &Path,
) -> Result<RecordBatch, StoreError> {
    let mut columns: Vec<(Field, ArrayRef)> = COLUMNS
        .iter()
        .filter(|c| c.signal.schema() <= form.schema)
        .map(|c| signal_column(c, samples))
        .collect();
    columns.extend(form.channels.iter().map(|c| channel_column(c, samples)));
    columns.extend(constant_columns(meta, samples.len(), form));
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    RecordBatch::try_new(Arc::new(ArrowSchema::new(fields)), arrays).map_err(|e| {
        StoreError::new(path, e.to_string(), "this is a defect of zwidth; please report it")
    })
}

/// The bytes of a sweep's Parquet file with one row group, our encodings, and `footer` as its
/// key-value metadata (in key order), to which the units, a digest and, if it is missing, the
/// version are added.
pub fn write_parquet(
    batch: &RecordBatch,
    footer: BTreeMap<String, String>,
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    write(batch, footer, None, path)
}

/// The entries of a file's footer: the given ones, the units, and the digest of them all.
pub(crate) fn entries(schema: &ArrowSchema, mut footer: BTreeMap<String, String>) -> Vec<KeyValue> {
    footer.entry(VERSION.to_owned()).or_insert_with(|| TABLE_VERSION.to_string());
    footer.insert(UNITS.to_owned(), units(schema));
    // Last, for it is of all the others.
    footer.insert(FOOTER_DIGEST.to_owned(), footer_digest(&footer));
    footer.into_iter().map(|(k, v)| KeyValue::new(k, v)).collect()
}

/// [`entries`], and what readers of Arrow are told, which the writer of Arrow would add by itself.
pub(crate) fn all_entries(schema: &ArrowSchema, footer: BTreeMap<String, String>) -> Vec<KeyValue> {
    let mut entries = entries(schema, footer);
    entries.push(KeyValue::new(ARROW_SCHEMA_META_KEY.to_owned(), encoded(schema)));
    entries
}

/// What a file says of its columns to readers of Arrow. Most that a thread writes one after the other
/// have one of a few schemas.
fn encoded(schema: &ArrowSchema) -> String {
    thread_local! {
        static LAST: RefCell<Memo<ArrowSchema, String>> = const { RefCell::new(Memo::new()) };
    }
    LAST.with_borrow_mut(|last| {
        last.get(|kept| kept == schema).unwrap_or_else(|| {
            let encoded = encode_arrow_schema(schema);
            last.keep(schema.clone(), encoded.clone());
            encoded
        })
    })
}

/// The bytes of a recording, whose row groups have so many rows at most.
fn write(
    batch: &RecordBatch,
    footer: BTreeMap<String, String>,
    group_rows: Option<usize>,
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    let bytes = (|| {
        let mut bytes = Vec::new();
        let entries = all_entries(&batch.schema(), footer);
        let properties = recorded(&batch.schema(), entries, group_rows)?;
        let options = ArrowWriterOptions::new().with_properties(properties);
        let options = options.with_skip_arrow_metadata(true); // it is there (`all_entries`)
        let mut writer = ArrowWriter::try_new_with_options(&mut bytes, batch.schema(), options)?;
        writer.write(batch)?;
        writer.close()?;
        Ok(bytes)
    })();
    bytes.map_err(|e| cannot_encode(path, &e))
}

pub(crate) fn cannot_encode(path: &Path, e: &ParquetError) -> StoreError {
    let remedy = "this is a defect of zwidth; please report it";
    StoreError::new(path, format!("cannot encode: {e}"), remedy)
}

/// An Arrow field that carries `unit` and `description`.
pub fn described(
    name: &str,
    data_type: DataType,
    nullable: bool,
    unit: &str,
    about: &str,
) -> Field {
    let metadata = [("unit", unit), ("description", about)];
    Field::new(name, data_type, nullable)
        .with_metadata(metadata.map(|(k, v)| (k.to_owned(), v.to_owned())).into())
}

/// A signal as a column; null throughout where the recording lacks it.
pub(crate) fn signal_column(c: &Column, samples: &Samples) -> (Field, ArrayRef) {
    let field = described(c.name, c.storage.data_type(), true, c.unit, c.description);
    let array = match samples.get(c.signal) {
        None => new_null_array(field.data_type(), samples.len()),
        Some(values) => stored(values, c.storage),
    };
    (field, array)
}

/// The values of a column, as they are stored.
/// The storage types hold the values: floats are narrowed as the schema says, counts were checked.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn stored(values: &[f64], storage: Storage) -> ArrayRef {
    match storage {
        Storage::F64 => Arc::new(Float64Array::from(values.to_vec())),
        Storage::F32 => Arc::new(values.iter().map(|v| *v as f32).collect::<Float32Array>()),
        Storage::U16 => Arc::new(values.iter().map(|v| *v as u16).collect::<UInt16Array>()),
    }
}

/// A study's own channel as a column; null throughout where the recording lacks it.
pub(crate) fn channel_column(channel: &Channel, samples: &Samples) -> (Field, ArrayRef) {
    let Channel { id, unit, description } = channel;
    let field = described(id.as_str(), DataType::Float64, true, unit, description);
    let array = match samples.channel(id) {
        None => new_null_array(field.data_type(), samples.len()),
        Some(values) => stored(values, Storage::F64),
    };
    (field, array)
}

/// The values that are constant in a file, as columns, so that any reader can group by them.
fn constant_columns(meta: &TrialMeta, n: usize, form: &TrialForm) -> Vec<(Field, ArrayRef)> {
    let points = AnswerScale::most_points();
    let about_answer = format!("answer 1…{points}, where given before the file was finished");
    let integers = [
        ("trial", i32::try_from(meta.trial).ok(), "number within the session, from 1"),
        ("repeat", i32::try_from(meta.repeat).ok(), "repeat of the condition, from 1"),
        ("likert", meta.likert.map(i32::from), about_answer.as_str()),
    ];
    let [trial, repeat, likert] = integers.map(|(name, value, about)| {
        let array: ArrayRef = Arc::new(Int32Array::from(vec![value; n]));
        // An answer is given in one file and not in the next, and both open as one data set.
        (described(name, DataType::Int32, value.is_none() || name == "likert", "1", about), array)
    });
    let words = [
        ("kind", meta.kind.as_str(), "trial or familiarisation"),
        ("status", meta.status.as_str(), "complete or incomplete"),
        ("environment", meta.environment.as_str(), "what was rendered"),
        ("mode", meta.mode.as_str(), "how; a sealed code until the session is unsealed"),
    ];
    let words = words.map(|(name, value, about)| {
        // One word and a key per row: a reader groups by it, and the file hardly grows.
        let keys = Int32Array::from(vec![0; n]);
        let words: ArrayRef = Arc::new(StringArray::from(vec![value]));
        let array: ArrayRef = Arc::new(DictionaryArray::<Int32Type>::new(keys, words));
        (described(name, array.data_type().clone(), false, "1", about), array)
    });
    let mut columns = vec![trial, repeat];
    columns.extend(words);
    columns.extend(form.likert.then_some(likert));
    if form.schema >= Schema::Three {
        columns.extend(presented_columns(meta.presented.as_ref(), n));
    }
    columns
}

/// What a trial of a task presented, as columns that are constant in a file; null throughout outside of tasks.
fn presented_columns(presented: Option<&Presented>, n: usize) -> [(Field, ArrayRef); 3] {
    let interval = presented.map(|own| i32::from(own.interval));
    let level = presented.and_then(|own| own.level).map(TaskLevel::value);
    let interval: ArrayRef = Arc::new(Int32Array::from(vec![interval; n]));
    let level: ArrayRef = Arc::new(Float64Array::from(vec![level; n]));
    let words: Vec<&str> = presented.iter().map(|own| own.task.as_str()).collect();
    let keys = Int32Array::from(vec![presented.map(|_| 0); n]);
    let words: ArrayRef = Arc::new(StringArray::from(words));
    let task: ArrayRef = Arc::new(DictionaryArray::<Int32Type>::new(keys, words));
    let columns = [
        ("interval", interval, "which interval of a presentation, from 1; null outside of tasks"),
        (
            "level",
            level,
            "what was presented, in the unit of what the task varies (study.toml); null outside of tasks, and while it is sealed which \
             interval holds the standard",
        ),
        ("task", task, "the task of the presentation; null outside of tasks"),
    ];
    columns.map(|(name, array, about)| {
        (described(name, array.data_type().clone(), true, "1", about), array)
    })
}

/// The entries of a trial's footer, except for the digests of its columns.
pub(crate) fn footer(
    meta: &TrialMeta,
    file: &TrialFile,
    form: &TrialForm,
) -> BTreeMap<String, String> {
    let mut footer = file.clone();
    for (key, value) in [
        ("trial", meta.trial.to_string()),
        ("repeat", meta.repeat.to_string()),
        ("kind", meta.kind.as_str().to_owned()),
        ("status", meta.status.as_str().to_owned()),
        ("environment", meta.environment.to_string()),
        ("mode", meta.mode.to_string()),
        ("source", meta.source.as_str().to_owned()),
    ] {
        footer.insert(key.to_owned(), value);
    }
    footer.insert(VERSION.to_owned(), form.schema.number().to_string());
    if form.likert {
        let answer = meta.likert.map(|v| v.to_string()).unwrap_or_default();
        footer.insert("likert".to_owned(), answer);
    }
    if let Some(Presented { task, interval, level }) = &meta.presented
        && form.schema >= Schema::Three
    {
        let level = level.map(|level| level.value().to_string()).unwrap_or_default();
        let entries =
            [("task", task.to_string()), ("interval", interval.to_string()), ("level", level)];
        footer.extend(entries.map(|(key, value)| (key.to_owned(), value)));
    }
    if !form.channels.is_empty() {
        let channels = serde_json::to_string(&form.channels).unwrap_or_default();
        footer.insert(CHANNELS.to_owned(), channels);
    }
    footer
}

fn units(schema: &ArrowSchema) -> String {
    let units: BTreeMap<_, _> = schema
        .fields()
        .iter()
        .filter_map(|f| f.metadata().get("unit").map(|u| (f.name().clone(), u.clone())))
        .collect();
    serde_json::to_string(&units).unwrap_or_default()
}

/// Digest of all footer keys but the digest itself.
pub(crate) fn footer_digest(footer: &BTreeMap<String, String>) -> String {
    let ours = footer.iter().filter(|(k, _)| *k != FOOTER_DIGEST && *k != "ARROW:schema");
    let mut text = String::with_capacity(1 << 13);
    for (k, v) in ours {
        // With lengths, so that no other keys and values give the same text. Writing to a text does
        // not fail.
        let _ = write!(text, "{}:{k}={}:{v};", k.len(), v.len());
    }
    hex_blake3(text.as_bytes())
}
