//! A trial in memory: its metadata and its samples.

use crate::{COLUMNS, Signal, Storage, StoreError};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_numerics::wide::widest;
use zwidth_study::{Channel, ChannelId, Sample, TrialForm, TrialMeta};

/// The samples of a trial: a column a signal, all of one length; absent where not recorded.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    columns: [Option<Vec<f64>>; Signal::COUNT],
    /// The columns of the study's own channels, by name.
    channels: BTreeMap<ChannelId, Vec<f64>>,
}

impl Samples {
    /// The samples of these rows, with the columns that they have: a quantity that one of them
    /// lacks has no column. The device's channels are left out.
    pub fn from_rows(rows: &[Sample]) -> Self {
        let mut samples = Self::default();
        for column in &COLUMNS {
            if let Some(values) = rows.iter().map(|row| value(row, column.signal)).collect() {
                samples.set(column.signal, values);
            }
        }
        samples
    }

    /// The same with the channels of the `device`; only those that are channels of `form`.
    #[must_use]
    pub fn with_channels(mut self, rows: &[Sample], device: &[Channel], form: &TrialForm) -> Self {
        for (place, channel) in device.iter().enumerate() {
            if form.channels.iter().all(|c| c.id != channel.id) {
                continue;
            }
            // One row that lacks the value leaves the channel out: a column is whole, or null.
            let values = rows.iter().map(|row| row.extra.values().get(place).copied());
            if let Some(values) = values.collect() {
                self.set_channel(channel.id.clone(), values);
            }
        }
        self
    }

    /// The column of `signal`, where the recording has it.
    pub fn get(&self, signal: Signal) -> Option<&[f64]> {
        self.columns[signal as usize].as_deref()
    }

    /// Sets the column of `signal`.
    pub fn set(&mut self, signal: Signal, values: Vec<f64>) {
        self.columns[signal as usize] = Some(values);
    }

    /// The values of a channel of the study's own, where the recording has it.
    pub fn channel(&self, id: &ChannelId) -> Option<&[f64]> {
        self.channels.get(id).map(Vec::as_slice)
    }

    /// The study's own channels that the recording has, by name.
    pub fn channels(&self) -> impl Iterator<Item = (&ChannelId, &[f64])> {
        self.channels.iter().map(|(id, values)| (id, values.as_slice()))
    }

    /// Sets the values of a channel of the study's own.
    pub fn set_channel(&mut self, id: ChannelId, values: Vec<f64>) {
        self.channels.insert(id, values);
    }

    /// Its columns, by the names and the storage that they have in a file.
    pub(crate) fn named(&self) -> impl Iterator<Item = (&str, Storage, &[f64])> {
        let signals = COLUMNS.iter().filter_map(|c| Some((c.name, c.storage, self.get(c.signal)?)));
        signals.chain(self.channels().map(|(id, values)| (id.as_str(), Storage::F64, values)))
    }

    /// Checks that trial files of this form have a column for each.
    ///
    /// # Errors
    /// A column that they have not.
    pub(crate) fn check_form(&self, form: &TrialForm, path: &Path) -> Result<(), StoreError> {
        let mut signals = COLUMNS.iter().filter(|c| self.get(c.signal).is_some());
        if let Some(column) = signals.find(|c| c.signal.schema() > form.schema) {
            let what =
                format!("trial files of schema {} have no such column", form.schema.number());
            let remedy = format!(
                "leave it out, or begin a study with schema = {}",
                column.signal.schema().number()
            );
            return Err(StoreError::new(path, what, remedy).column(column.name));
        }
        let mut channels = self.channels();
        if let Some((id, _)) = channels.find(|(id, _)| form.channels.iter().all(|c| c.id != **id)) {
            let what = "the study's trial files have no such channel";
            return Err(StoreError::new(path, what, "leave it out").column(id.as_str()));
        }
        Ok(())
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.columns.iter().flatten().chain(self.channels.values()).map(Vec::len).max().unwrap_or(0)
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Checks what every trial file promises: samples there, one length, finite numbers that fit
    /// their storage, and a time that runs forward. The error names column and row.
    pub fn check(&self, path: &Path) -> Result<(), StoreError> {
        if self.get(Signal::Time).is_none() {
            let remedy =
                "a trial needs its time; give the recording's rate where it has no time column";
            return Err(StoreError::new(path, "the column is missing", remedy).column("t_s"));
        }
        if self.is_empty() {
            let remedy = "record the trial again, or leave it out";
            return Err(StoreError::new(path, "there is no sample", remedy));
        }
        for (name, storage, values) in self.named() {
            check_column(path, name, storage, values, self.len())?;
        }
        check_time(path, self.get(Signal::Time).unwrap_or_default())
    }
}

/// Checks that a column has `length` values, all of which its storage can hold.
pub(crate) fn check_column(
    path: &Path,
    name: &str,
    storage: Storage,
    values: &[f64],
    length: usize,
) -> Result<(), StoreError> {
    if values.len() != length {
        let what = format!("it has {} values where others have {length}", values.len());
        let remedy = "columns must be equally long";
        return Err(StoreError::new(path, what, remedy).column(name));
    }
    // Without a way out of the loop a processor looks at several values at once.
    let all = match storage {
        Storage::F64 => widest(
            #[inline(always)]
            || values.iter().fold(true, |all, v| all & v.is_finite()),
        ),
        _ => values.iter().fold(true, |all, v| all & fits(*v, storage)),
    };
    if let Some(row) = values.iter().position(|v| !all && !fits(*v, storage)) {
        let what = format!("{} is not a number this column can hold", values[row]);
        let remedy = "mend or drop the row; a gap is a null column, never a NaN";
        return Err(StoreError::new(path, what, remedy).column(name).row0(row));
    }
    Ok(())
}

/// Checks that time runs forward.
pub(crate) fn check_time(path: &Path, t: &[f64]) -> Result<(), StoreError> {
    let mut pairs = t.iter().zip(t.iter().skip(1));
    // Without a way out of the loop, as above; where something is wrong, it is looked for.
    if pairs.clone().fold(true, |all, (now, next)| all & (next > now)) {
        return Ok(());
    }
    match pairs.position(|(now, next)| next <= now) {
        None => Ok(()),
        Some(i) => Err(backwards(path, t[i], t[i + 1]).row0(i + 1)),
    }
}

/// The error of a time that does not come after the one before it.
pub(crate) fn backwards(path: &Path, before: f64, after: f64) -> StoreError {
    let what = format!("time runs backwards or stands still: {after} s after {before} s");
    StoreError::new(path, what, "sort or mend the recording").column("t_s")
}

/// A row's value of a signal, where it has one.
fn value(row: &Sample, signal: Signal) -> Option<f64> {
    match signal {
        Signal::Time => Some(row.t_s),
        Signal::DeviceTime => row.t_device_s,
        Signal::Theta => Some(row.theta_rad),
        Signal::ThetaDot => Some(row.theta_dot_rad_s),
        Signal::ForceEx => Some(row.force_ex_n),
        Signal::VoltageMotor => Some(row.voltages.motor_v),
        Signal::VoltageBrake => Some(row.voltages.brake_v),
        Signal::ForceAge => row.force_age_s,
        Signal::ThetaRaw => row.theta_raw.map(f64::from),
        Signal::ForceCmd => Some(row.force_cmd_n),
        Signal::StateBits => Some(row.flags.0.into()),
        Signal::ThetaDdot
        | Signal::TorqueEx
        | Signal::X
        | Signal::Y
        | Signal::Z
        | Signal::ForceX
        | Signal::ForceY
        | Signal::ForceZ => None,
    }
}

fn fits(value: f64, storage: Storage) -> bool {
    match storage {
        Storage::F64 => value.is_finite(),
        Storage::F32 => value.abs() <= f64::from(f32::MAX),
        Storage::U16 => (0.0..=f64::from(u16::MAX)).contains(&value) && value.fract() == 0.0,
    }
}

/// The entries of a trial file's footer besides the trial's metadata: key → value.
///
/// Known keys: `study_blake3`, `calibration_blake3`, `device`, `software`, `start_utc`, `seed`,
/// `lever_m` (the lever length that turned lengths into angles or torques into forces),
/// `made_by_import` (what import computed, such as a derivative), `source_blake3` and
/// `mapping_blake3` (the imported file and the mapping it came through), [`JOINED`], [`LOST`] and [`GAPS`].
pub type TrialFile = BTreeMap<String, String>;

/// Footer key of what an import could not read of a recording, in words. Such a trial is to be read
/// with care.
pub const LOST: &str = "samples_lost";

/// Footer key of the samples that a recording lacks between its first and its last, in words: rows
/// that were empty, or left out because the mapping asked for it.
pub const GAPS: &str = "samples_missing";

/// Footer key of what an import saw in a recording that makes it to be read with care, and that its samples
/// no longer show, in words.
pub const DOUBTS: &str = "import_doubts";

/// Footer key of what an import took for the zeros of sensors, in words: a median over a stretch at rest, with
/// its spread.
pub const ZEROS: &str = "zeros";

/// Footer key of the files that an import joined to the recording, in words: each by its hash, with the row or the times.
pub const JOINED: &str = "joined";

/// Footer key of the hash of the recording that a file was made from.
pub const SOURCE: &str = "source_blake3";

/// Footer key of when a trial began.
pub(crate) const START: &str = "start_utc";

/// A trial: its metadata, what its file says about itself, and its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The trial's metadata.
    pub meta: TrialMeta,
    /// What the file says about itself.
    pub file: TrialFile,
    /// The samples.
    pub samples: Samples,
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Schema;

    fn check(columns: &[(Signal, &[f64])], words: &str, row: Option<usize>) {
        let mut samples = Samples::default();
        for (signal, values) in columns {
            samples.set(*signal, values.to_vec());
        }
        let error = samples.check(Path::new("x")).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(error.row, row, "{error}");
    }

    #[test]
    fn samples_that_break_a_promise_are_refused_with_column_and_row() {
        use Signal::{StateBits, Theta, Time};
        check(&[(Theta, &[0.0])], "t_s: the column is missing", None);
        check(&[(Time, &[])], "no sample", None);
        check(&[(Time, &[0.0, 1.0]), (Theta, &[0.0])], "1 values where others have 2", None);
        check(&[(Time, &[0.0, 1.0]), (Theta, &[0.0, f64::NAN])], "theta_rad, row 2: NaN", Some(2));
        check(&[(Time, &[0.0, 1.0]), (StateBits, &[0.0, 0.5])], "state_bits, row 2: 0.5", Some(2));
        check(
            &[(Time, &[0.0, 1.0]), (Signal::VoltageMotor, &[0.0, 1e39])],
            "voltage_motor_v, row 2",
            Some(2),
        );
        check(
            &[(Time, &[0.0, 1.0, 1.0])],
            "runs backwards or stands still: 1 s after 1 s",
            Some(3),
        );
    }

    #[test]
    fn rows_become_columns_and_what_a_row_lacks_is_no_column() {
        let mut rows = crate::tests::crashes::rows(1, 3);
        let samples = Samples::from_rows(&rows);
        assert_eq!(samples.get(Signal::Time), Some([0.001, 0.002, 0.003].as_slice()));
        assert_eq!(samples.get(Signal::ThetaRaw), Some([1.0, 2.0, 3.0].as_slice()));
        assert_eq!(samples.get(Signal::StateBits), Some([256.0; 3].as_slice()));
        let lacks = |samples: &Samples| {
            Signal::of(Schema::Two).filter(|s| samples.get(*s).is_none()).collect::<Vec<_>>()
        };
        assert_eq!(lacks(&samples), [Signal::DeviceTime, Signal::ThetaDdot, Signal::TorqueEx]);
        rows[1].force_age_s = None;
        assert!(lacks(&Samples::from_rows(&rows)).contains(&Signal::ForceAge));
        assert!(Samples::from_rows(&[]).get(Signal::Time).is_some_and(<[f64]>::is_empty));
    }

    #[test]
    fn denormals_are_numbers_like_any_other() {
        let mut samples = Samples::default();
        samples.set(Signal::Time, vec![0.0, 1.0]);
        samples.set(Signal::Theta, vec![1e-321, -1e-321]);
        assert_eq!(samples.check(Path::new("x")), Ok(()));
    }
}
