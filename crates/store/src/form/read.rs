//! Strict reading: a file that is not exactly what it should be is one clear error.

use crate::disk::stamp::Stamp;
use crate::form::bounds::MOST_VALUES;
use crate::form::columns::{Columns, LONG, Values};
use crate::form::footer::{OF_TRIAL, form_of, meta_from, recorded, rest_of};
use crate::form::opened::{ParquetFile, table_error};
use crate::form::seen::Signals;
use crate::form::trial::{check_column, check_time};
use crate::form::values::column_values;
use crate::{Column, Files, RealFiles, Samples, Signal, Storage, StoreError, Trial, TrialFile};
use arrow::array::RecordBatch;
use arrow::datatypes::{DataType, SchemaRef};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::Arc;
use zwidth_numerics::series::ends;
use zwidth_study::{Channel, ChannelId, TrialForm, TrialMeta};

/// Reads a trial, with only the requested `signals` (all: `Signal::all()`). Time is always read.
///
/// Every column read is checked: type, unit, digest, finite values, time that runs forward.
pub fn read_trial(
    path: &Path,
    signals: impl IntoIterator<Item = Signal>,
) -> Result<Trial, StoreError> {
    read_trial_from(&RealFiles, path, signals)
}

/// Reads a trial's time, and of the study's own channels those of these names that its file has.
/// Checks are those of [`read_trial`].
///
/// # Errors
/// Those of [`read_trial`].
pub fn read_channels(path: &Path, wanted: &[ChannelId]) -> Result<Trial, StoreError> {
    read_trial_and_channels(path, [], wanted)
}

/// Reads a trial with the requested `signals`, and with those of the named channels that its file
/// has. Checks are those of [`read_trial`].
///
/// # Errors
/// Those of [`read_trial`].
pub fn read_trial_and_channels(
    path: &Path,
    signals: impl IntoIterator<Item = Signal>,
    wanted: &[ChannelId],
) -> Result<Trial, StoreError> {
    let open = OpenColumns::open(&RealFiles, path)?;
    open.read(&with_time(signals), &|channel| wanted.contains(&channel.id))
}

/// Reads a trial with all that its file has.
pub(crate) fn read_whole_trial(files: &dyn Files, path: &Path) -> Result<Trial, StoreError> {
    let all: Vec<Signal> = Signal::all().collect();
    OpenColumns::open(files, path)?.read(&all, &|_| true)
}

/// [`read_trial`] from any disk.
///
/// # Errors
/// Those of [`read_trial`].
pub fn read_trial_from(
    files: &dyn Files,
    path: &Path,
    signals: impl IntoIterator<Item = Signal>,
) -> Result<Trial, StoreError> {
    OpenColumns::open(files, path)?.read(&with_time(signals), &|_| false)
}

/// These signals and time, each once and in order.
pub(crate) fn with_time(signals: impl IntoIterator<Item = Signal>) -> Vec<Signal> {
    let mut wanted: Vec<Signal> = signals.into_iter().chain([Signal::Time]).collect();
    wanted.sort();
    wanted.dedup();
    wanted
}

/// A trial's file, opened: its columns are read one by one.
pub(crate) struct OpenColumns {
    form: TrialForm,
    file: ParquetFile,
    schema: SchemaRef,
    /// The signals that the file has.
    recorded: Signals,
    /// Those that are known to match their digests.
    pub(crate) matched: Signals,
    /// Those that were read and matched.
    proved: Cell<Signals>,
    /// Those of them that are what a trial's file promises.
    sound: Cell<Signals>,
    /// What the system says of a long trial's file, if it would reveal any change.
    stamp: Option<Stamp>,
    /// The columns that were looked at last.
    last: RefCell<VecDeque<(Signal, Arc<Vec<f64>>)>>,
    /// Which were looked at, and so read and checked.
    seen: RefCell<[bool; Signal::COUNT]>,
    failed: RefCell<Option<StoreError>>,
}

/// Columns that an open trial keeps in memory.
const KEPT: usize = 2;

impl OpenColumns {
    pub(crate) fn open(files: &dyn Files, path: &Path) -> Result<Self, StoreError> {
        let file = ParquetFile::open_recording(files, path)?;
        // What changed since it was opened is not settled.
        let stamp = (file.rows > LONG).then(|| Stamp::settled(path)).flatten();
        let form = form_of(path, &file.footer)?;
        let schema = file.schema()?;
        let recorded = recorded(&file.footer);
        let (matched, proved, sound, last, seen, failed) = Default::default();
        Ok(Self { form, file, schema, recorded, matched, proved, sound, stamp, last, seen, failed })
    }

    /// BLAKE3 of the whole file, hexadecimal.
    pub(crate) fn blake3(&self) -> Result<String, StoreError> {
        self.file.blake3()
    }

    /// The trial's metadata and the file's other entries.
    pub(crate) fn meta_and_file(&self) -> Result<(TrialMeta, TrialFile), StoreError> {
        let meta = meta_from(&self.file.path, &self.file.footer, &self.form)?;
        Ok((meta, rest_of(&self.file.footer, &OF_TRIAL)))
    }

    /// A trial in memory with these signals, and the channels that are wanted.
    ///
    /// # Errors
    /// Those of [`read_trial`].
    pub(crate) fn read(
        &self,
        wanted: &[Signal],
        is_wanted: &dyn Fn(&Channel) -> bool,
    ) -> Result<Trial, StoreError> {
        let path = &self.file.path;
        let rows = self.file.rows;
        let (meta, file) = self.meta_and_file()?;
        let channels: Vec<&Channel> = self.form.channels.iter().filter(|c| is_wanted(c)).collect();
        let recorded = wanted.iter().filter(|signal| self.has(**signal)).count() + channels.len();
        if rows.saturating_mul(recorded) > MOST_VALUES {
            let what = format!(
                "{rows} rows of {recorded} columns are more numbers than the {MOST_VALUES} that are read at once"
            );
            return Err(StoreError::new(path, what, "split the recording"));
        }
        let mut samples = Samples::default();
        for signal in wanted {
            if let Some(values) = self.signal(*signal)? {
                samples.set(*signal, values);
            }
        }
        for channel in channels {
            if let Some(values) = self.channel(channel)? {
                samples.set_channel(channel.id.clone(), values);
            }
        }
        samples.check(path)?;
        Ok(Trial { meta, file, samples })
    }

    /// Checks what [`read_whole_trial`] checks, a column at a time; those that were looked at as
    /// [`Columns`] are not read again.
    ///
    /// # Errors
    /// Those of [`read_trial`].
    pub(crate) fn check(&self) -> Result<(), StoreError> {
        let path = &self.file.path;
        let rows = self.file.rows;
        self.meta_and_file()?;
        self.forget();
        // If one of them failed, the first error is another one perhaps.
        let seen = *self.seen.borrow();
        let has_failed = self.failed.borrow().is_some();
        let is_checked = |signal: Signal| seen[signal as usize] && self.has(signal) && !has_failed;
        let mut room = Vec::new();
        for signal in Signal::all().filter(|signal| !is_checked(*signal)) {
            let column = signal.column();
            match self.decoded(signal, std::mem::take(&mut room))? {
                Some(values) => {
                    check_column(path, column.name, column.storage, &values, rows)?;
                    if signal == Signal::Time {
                        check_time(path, &values)?;
                    }
                    room = values;
                }
                // Which gives the error of a trial without time.
                None if signal == Signal::Time => Samples::default().check(path)?,
                None => {}
            }
        }
        for channel in &self.form.channels {
            if let Some(values) = self.channel(channel)? {
                check_column(path, channel.id.as_str(), Storage::F64, &values, rows)?;
            }
        }
        Ok(())
    }

    /// The values of a signal; `None` where the column is null throughout. Of one without a digest
    /// whose statistics say that it is, nothing is decoded.
    pub(crate) fn signal(&self, signal: Signal) -> Result<Option<Vec<f64>>, StoreError> {
        self.signal_in(signal, Vec::new())
    }

    /// [`OpenColumns::signal`] in the memory of values that nobody needs any more: to get new memory
    /// from the system and to give it back takes as long as to decode a column into it.
    pub(crate) fn signal_in(
        &self,
        signal: Signal,
        room: Vec<f64>,
    ) -> Result<Option<Vec<f64>>, StoreError> {
        if signal.schema() > self.form.schema {
            return Ok(None);
        }
        let column = signal.column();
        check_field(&self.file.path, &self.schema, column)?;
        let name = column.name;
        if !self.has(signal) && self.file.is_null_by_statistics(name) {
            return Ok(None);
        }
        let one = Signals::of(&[signal]);
        let is_known = self.matched.has(one) || self.is_proved(signal);
        let values = column_values(&self.file, name, column.storage, room, is_known)?;
        self.proved.set(self.proved.get().with(one));
        Ok(values)
    }

    /// Whether a signal of a long trial matched its digest when it was read before, and the file is what it
    /// was: the columns of a long trial are read again and again.
    fn is_proved(&self, signal: Signal) -> bool {
        self.proved.get().has(Signals::of(&[signal]))
            && self.stamp.is_some()
            && Stamp::at(&self.file.path) == self.stamp
    }

    /// [`OpenColumns::signal_in`], decoded whatever the statistics say.
    fn decoded(&self, signal: Signal, room: Vec<f64>) -> Result<Option<Vec<f64>>, StoreError> {
        if signal.schema() > self.form.schema {
            return Ok(None);
        }
        let column = signal.column();
        check_field(&self.file.path, &self.schema, column)?;
        column_values(&self.file, column.name, column.storage, room, false)
    }

    /// [`OpenColumns::signal_in`], and whether it is what a trial's file promises.
    fn checked(&self, signal: Signal, room: Vec<f64>) -> Result<Option<Vec<f64>>, StoreError> {
        let path = &self.file.path;
        let column = signal.column();
        let one = Signals::of(&[signal]);
        let is_sound = self.is_proved(signal) && self.sound.get().has(one);
        let values = self.signal_in(signal, room)?;
        if let Some(values) = values.as_ref().filter(|_| !is_sound) {
            check_column(path, column.name, column.storage, values, self.file.rows)?;
            if signal == Signal::Time {
                check_time(path, values)?;
            }
            self.sound.set(self.sound.get().with(one));
        }
        Ok(values)
    }

    /// What was read; the first failure is noted.
    fn noted<T>(&self, read: Result<Option<T>, StoreError>) -> Option<T> {
        read.unwrap_or_else(|error| {
            self.failed.borrow_mut().get_or_insert(error);
            None
        })
    }

    /// The distance between the ends of a signal, from the file's statistics, else from its values.
    ///
    /// # Errors
    /// Those of [`OpenColumns::signal`], where they are read.
    pub(crate) fn reach_of(&self, signal: Signal) -> Result<Option<f64>, StoreError> {
        let name = signal.column().name;
        // Without a digest there are no values, whatever the statistics say.
        let stated = self.file.ends_by_statistics(name).filter(|_| self.has(signal));
        let ends = match stated {
            Some(ends) => Some(ends),
            None => self.signal(signal)?.map(|values| ends(&values)),
        };
        Ok(ends.map(|(low, high)| high - low))
    }

    /// The values of a channel of the study's own.
    pub(crate) fn channel(&self, channel: &Channel) -> Result<Option<Vec<f64>>, StoreError> {
        let name = channel.id.as_str();
        check_described(&self.file.path, &self.schema, name, &DataType::Float64, &channel.unit)?;
        column_values(&self.file, name, Storage::F64, Vec::new(), false)
    }
}

impl Columns for OpenColumns {
    fn rows(&self) -> usize {
        self.file.rows
    }

    fn column(&self, signal: Signal) -> Option<Values<'_>> {
        let mut last = self.last.borrow_mut();
        let values = match last.iter().position(|(kept, _)| *kept == signal) {
            Some(at) => last.remove(at)?.1,
            None => {
                // Before the next is read, so that there are never more: of those that nobody holds,
                // which give their memory, the one looked at first. What was not recorded takes none.
                let free = last.iter().rposition(|(_, values)| Arc::strong_count(values) == 1);
                let oldest = last.len().saturating_sub(1);
                let is_full = last.len() >= KEPT && self.has(signal);
                let gone = is_full.then(|| last.remove(free.unwrap_or(oldest))).flatten();
                let room = gone.and_then(|(_, values)| Arc::into_inner(values));
                self.seen.borrow_mut()[signal as usize] = true;
                Arc::new(self.noted(self.checked(signal, room.unwrap_or_default()))?)
            }
        };
        last.push_front((signal, values.clone()));
        Some(Values::Read(values))
    }

    fn has(&self, signal: Signal) -> bool {
        self.recorded.has(Signals::of(&[signal]))
    }

    fn channel(&self, name: &str) -> Option<Values<'_>> {
        let channel = self.form.channels.iter().find(|channel| channel.id.as_str() == name)?;
        Some(Values::Read(Arc::new(self.noted(OpenColumns::channel(self, channel))?)))
    }

    fn reach(&self, signal: Signal) -> Option<f64> {
        self.noted(self.reach_of(signal))
    }

    fn forget(&self) {
        self.last.borrow_mut().retain(|(_, values)| Arc::strong_count(values) > 1);
    }

    fn failure(&self) -> Option<StoreError> {
        let seen = *self.seen.borrow();
        for signal in Signal::all().filter(|signal| !seen[*signal as usize]) {
            drop(self.column(signal));
        }
        self.failed.borrow().clone()
    }
}

/// Reads any Parquet file that [`crate::write_parquet`] or [`crate::write_table`] wrote, whole: its
/// rows and its footer.
pub fn read_parquet(path: &Path) -> Result<(RecordBatch, BTreeMap<String, String>), StoreError> {
    let file = ParquetFile::open(&RealFiles, path).map_err(table_error)?;
    let columns = file.columns().map_err(table_error)?;
    let schema = columns.schema().clone();
    let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
    let batch = file.read(columns, &names).map_err(table_error)?;
    Ok((batch, file.footer))
}

/// The footer of such a file, and how many rows it has.
pub fn read_entries(path: &Path) -> Result<(BTreeMap<String, String>, usize), StoreError> {
    let file = ParquetFile::open(&RealFiles, path).map_err(table_error)?;
    Ok((file.footer, file.rows))
}

/// Checks a column's presence, type and unit.
pub(crate) fn check_field(path: &Path, columns: &SchemaRef, c: &Column) -> Result<(), StoreError> {
    check_described(path, columns, c.name, &c.storage.data_type(), c.unit)
}

/// Checks that `schema` has a column of this name, with this type and unit.
pub(crate) fn check_described(
    path: &Path,
    schema: &SchemaRef,
    name: &str,
    data_type: &DataType,
    unit: &str,
) -> Result<(), StoreError> {
    let remedy = "convert the file with `zwidth import`";
    let Ok(field) = schema.field_with_name(name) else {
        return Err(StoreError::new(path, "the column is missing", remedy).column(name));
    };
    if field.data_type() != data_type {
        let what = format!("its type is {} where {data_type} belongs", field.data_type());
        return Err(StoreError::new(path, what, remedy).column(name));
    }
    let actual = field.metadata().get("unit").map_or("", String::as_str);
    if actual != unit {
        let what = format!("its unit is '{actual}' where '{unit}' belongs");
        return Err(StoreError::new(path, what, remedy).column(name));
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::form::write::FOOTER_DIGEST;
    use crate::tests::crashes::meta;
    use crate::{RealFiles, trial_bytes, write_new};
    use parquet::file::metadata::{
        FileMetaData, KeyValue, ParquetMetaData, ParquetMetaDataReader, ParquetMetaDataWriter,
    };
    use std::path::PathBuf;
    use zwidth_study::Source;

    /// That of a study with one question.
    pub(crate) fn form() -> TrialForm {
        TrialForm { likert: true, ..TrialForm::default() }
    }

    pub(crate) fn sample_trial() -> Trial {
        let mut samples = Samples::default();
        let t: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.0083).collect();
        samples.set(Signal::Theta, t.iter().map(|t| libm::sin(*t)).collect());
        samples.set(Signal::StateBits, t.iter().map(|t| f64::from(u8::from(*t > 1.0))).collect());
        samples.set(Signal::VoltageMotor, t.iter().map(|t| t * 0.1).collect());
        samples.set(Signal::Time, t);
        let meta = TrialMeta { repeat: 3, likert: Some(4), source: Source::Twin, ..meta(17) };
        let file = [("seed".to_owned(), "1".to_owned())].into();
        Trial { meta, file, samples }
    }

    /// A trial and its file, which goes with its folder.
    pub(crate) fn written() -> (tempfile::TempDir, Trial, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let trial = sample_trial();
        let path = folder.path().join("participant=P01/session=S01/trial-017.parquet");
        write_new(&RealFiles, &path, &trial_bytes(&trial, &form(), &path).unwrap()).unwrap();
        (folder, trial, path)
    }

    /// A file's bytes with other entries in its footer, which match their own digest.
    pub(crate) fn with_other_entries(
        bytes: &[u8],
        change: impl FnOnce(&mut BTreeMap<String, String>),
    ) -> Vec<u8> {
        let file = bytes::Bytes::copy_from_slice(bytes);
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let of = metadata.file_metadata();
        let entries = of.key_value_metadata().unwrap().iter();
        let mut entries =
            entries.map(|entry| (entry.key.clone(), entry.value.clone().unwrap())).collect();
        change(&mut entries);
        entries.insert(FOOTER_DIGEST.to_owned(), crate::form::write::footer_digest(&entries));
        let entries = entries.into_iter().map(|(key, value)| KeyValue::new(key, value));
        let said = FileMetaData::new(
            of.version(),
            of.num_rows(),
            of.created_by().map(str::to_owned),
            Some(entries.collect()),
            of.schema_descr_ptr(),
            of.column_orders().cloned(),
        );
        let metadata = ParquetMetaData::new(said, metadata.row_groups().to_vec());
        let end = bytes.len() - 8;
        let length = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) as usize;
        let mut changed = bytes[..end - length].to_vec();
        ParquetMetaDataWriter::new(&mut changed, &metadata).finish().unwrap();
        changed
    }

    #[test]
    fn a_trial_comes_back_as_it_was_written() {
        let (_folder, trial, path) = written();
        let again = read_trial(&path, Signal::all()).unwrap();
        assert_eq!(again.meta, trial.meta);
        assert_eq!(again.file, trial.file);
        assert_eq!(again.samples.get(Signal::Theta), trial.samples.get(Signal::Theta));
        assert_eq!(again.samples.get(Signal::ForceEx), None);
    }

    #[test]
    fn the_same_trial_gives_the_same_bytes() {
        let path = Path::new("x");
        let bytes = || trial_bytes(&sample_trial(), &form(), path);
        assert_eq!(bytes(), bytes());
    }

    #[test]
    fn a_footer_says_what_the_parquet_crate_finds_in_it() {
        let (_folder, _, path) = written();
        let file = bytes::Bytes::from(std::fs::read(&path).unwrap());
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let entries = metadata.file_metadata().key_value_metadata().unwrap().iter();
        let mut entries: BTreeMap<String, String> =
            entries.map(|entry| (entry.key.clone(), entry.value.clone().unwrap())).collect();
        assert!(entries.remove("ARROW:schema").is_some() && entries.len() > 10);
        let opened = ParquetFile::open(&RealFiles, &path).unwrap();
        assert_eq!((&opened.footer, opened.rows), (&entries, 200));
    }

    #[test]
    fn only_the_columns_asked_for_are_there() {
        let (_folder, _, path) = written();
        let trial = read_trial(&path, [Signal::Theta]).unwrap();
        assert!(trial.samples.get(Signal::Time).is_some());
        assert!(trial.samples.get(Signal::StateBits).is_none());
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        let (_folder, _, path) = written();
        let bytes = std::fs::read(&path).unwrap();
        for cut in (0..bytes.len()).step_by(97) {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let error = read_trial(&path, Signal::all()).unwrap_err();
            assert!(!error.what.is_empty() && !error.remedy.is_empty());
        }
    }

    #[test]
    fn a_flipped_bit_gives_an_error_or_the_same_trial_never_another_one() {
        let (_folder, _, path) = written();
        let good = read_trial(&path, Signal::all()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for i in (0..bytes.len()).step_by(3) {
            let mut bad = bytes.clone();
            bad[i] ^= 1 << (i % 8);
            std::fs::write(&path, &bad).unwrap();
            if let Ok(trial) = read_trial(&path, Signal::all()) {
                assert_eq!(trial, good, "byte {i}");
            }
        }
    }
}
