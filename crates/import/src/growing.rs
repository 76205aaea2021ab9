//! Rows of a recording become a trial: whole, or part by part as a long text is read.

use super::axes::Projection;
use super::convert::{central, slope};
use super::counter::{self, Elsewhere};
use super::errors::Errors;
use super::limits::{check_sizes, check_time};
use super::mapping::Rule;
use super::mend::unwrap_angle;
use super::plan::{Plan, rate_times};
use super::recording::{Gaps, Recording, Standing};
use super::zero;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_store::{Samples, Signal, StoreError, TrialWriter};
use zwidth_study::ChannelId;

/// Rows that are written at a time. Tests have many parts in few rows.
const PART: usize = if cfg!(test) { 700 } else { TrialWriter::AT_ONCE };

/// The signal or channel that a column becomes.
#[derive(Debug, Clone, PartialEq)]
enum To {
    Signal(Signal),
    Channel(ChannelId),
}

impl To {
    fn name(&self) -> &str {
        match self {
            Self::Signal(signal) => signal.name(),
            Self::Channel(id) => id.as_str(),
        }
    }
}

/// Rows of one trial that follow each other in a recording, or in a block of one.
pub(super) struct Part<'a> {
    pub(super) recording: &'a Recording,
    /// The places of the columns taken.
    pub(super) numeric: &'a [usize],
    /// The places of the columns that labels come from.
    pub(super) labels: &'a [usize],
    pub(super) rows: &'a [usize],
    /// Their numbers, a column each.
    pub(super) values: Vec<&'a [f64]>,
    /// Rows of the file before those of `recording`.
    pub(super) before: Standing,
    /// Whether the trial has no other rows.
    pub(super) is_whole: bool,
}

/// Notes on the zeros of a trial's sensors.
#[derive(Debug, Default)]
pub(super) struct Zeros {
    pub(super) words: Vec<String>,
    pub(super) doubts: Vec<String>,
}

/// A trial on its way from the rows of a recording to its samples, whole or part by part.
pub(super) struct Growing<'a> {
    pub(super) plan: &'a Plan<'a>,
    path: PathBuf,
    /// Columns in the order of the plan, then the time from a rate, then those that are computed.
    columns: Vec<(To, Vec<f64>)>,
    /// Of each projection on the push, its first value.
    first_places: BTreeMap<Signal, f64>,
    /// The zero subtracted from each column, as recorded; empty before the first rows.
    zeros: Vec<f64>,
    /// Notes on the zeros, for the trial's file.
    pub(super) zero_notes: Zeros,
    /// The places of its first and its last row in the file.
    ends: Option<[Standing; 2]>,
    /// The samples that other columns pass over, in the rows so far, and the doubt that this raises.
    hidden: (Elsewhere, Option<String>),
    /// Rows that were taken.
    pub(super) taken: usize,
    /// First and last time, s.
    times: Option<[f64; 2]>,
    /// Rows that the writer has and that are kept because the next row's derivative needs them: the
    /// last one.
    written: usize,
    /// Rows that the writer has.
    pub(super) rows: usize,
}

impl<'a> Growing<'a> {
    pub(super) fn new(plan: &'a Plan<'a>, path: &Path) -> Self {
        let signals = plan.taken.iter().map(|taken| To::Signal(taken.to));
        let channels = plan.channels.iter().map(|channel| To::Channel(channel.to.clone()));
        let rate = plan.rate_hz.map(|_| To::Signal(Signal::Time));
        let derived = plan.derived.iter().map(|(to, _)| To::Signal(*to));
        let all = signals.chain(channels).chain(rate).chain(derived);
        Self {
            plan,
            path: path.to_owned(),
            columns: all.map(|to| (to, Vec::new())).collect(),
            first_places: BTreeMap::new(),
            zeros: Vec::new(),
            zero_notes: Zeros::default(),
            ends: None,
            hidden: Default::default(),
            taken: 0,
            times: None,
            written: 0,
            rows: 0,
        }
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// Numbers that no file of ours holds, by their column, row and line in the recording; a zero from a
    /// stretch without samples.
    pub(super) fn add(&mut self, part: &Part) -> Result<(), Errors> {
        let standing = |row: &usize| part.before.of(&part.recording.table, *row);
        let [begin, end] = [&part.rows[0], &part.rows[part.rows.len() - 1]].map(standing);
        let first = self.ends.map_or(begin, |[first, _]| first);
        self.ends = Some([first, end]);
        self.taken += part.rows.len();
        let mut samples = Samples::default();
        // The times come first: the zeros of others are taken at some of them.
        if let Some(rate_hz) = self.plan.rate_hz {
            let numbers = part.rows.iter().map(|row| standing(row).place - first.place);
            samples.set(Signal::Time, rate_times(rate_hz, numbers));
        }
        let signals = self.plan.taken.iter().map(|taken| (&taken.line, taken.factor, taken.wrap));
        let channels = self.plan.channels.iter().map(|channel| (&channel.line, 1.0, None));
        for (i, (line, factor, wrap)) in signals.chain(channels).enumerate() {
            let mut values = part.values[i].to_vec();
            if let Some(wrap) = wrap {
                unwrap_angle(&mut values, wrap);
            }
            // At the trial's first rows; those that come later have the same zero.
            if i == self.zeros.len() {
                let t_s = samples.get(Signal::Time).unwrap_or_default();
                let zero = zero::find(line.zero, t_s, &values).map_err(|what| {
                    let remedy = "name another stretch in zero, or leave the trial out";
                    part.recording.cell_error(part.numeric[i], part.rows[0], &what, remedy)
                })?;
                self.zeros.push(zero.value);
                let to = &self.columns[i].0;
                if part.is_whole && *to != To::Signal(Signal::Time) {
                    let name = to.name();
                    let Zeros { words, doubts } = &mut self.zero_notes;
                    words.extend(zero.words.map(|words| format!("{name}: {words}")));
                    doubts.extend(zero.doubt.map(|doubt| format!("{name}: {doubt}")));
                }
            }
            line.apply(&mut values, factor, self.zeros[i]);
            set(&mut samples, &self.columns[i].0, values);
        }
        let t_s = samples.get(Signal::Time).unwrap_or_default();
        self.hidden.1 = match self.plan.time.and_then(|time| time.mend.counts_at_hz) {
            Some(rate_hz) => counter::passed_over(t_s, rate_hz),
            None => {
                let Part { recording, numeric, labels, rows, .. } = part;
                let next = counter::elsewhere(recording, numeric, self.plan, labels, rows, t_s);
                self.hidden.0.add(next);
                counter::doubt(recording, self.plan, &self.hidden.0)
            }
        };
        // Before the rows are kept: errors name their place in this part.
        self.check(&samples).map_err(|e| self.in_their_words(e, part))?;
        let t = samples.get(Signal::Time).unwrap_or_default();
        if let (Some(first), Some(last)) = (t.first(), t.last()) {
            let first = self.times.map_or(*first, |[first, _]| first);
            self.times = Some([first, *last]);
        }
        for (to, values) in &mut self.columns {
            let new = match to {
                To::Signal(signal) => samples.get(*signal),
                To::Channel(id) => samples.channel(id),
            };
            values.extend_from_slice(new.unwrap_or_default());
        }
        Ok(())
    }

    /// The gaps between its first and its last row.
    pub(super) fn gaps(&self) -> Gaps {
        self.ends
            .map_or_else(Gaps::default, |[first, last]| Gaps::between(first, last, self.taken, 0))
    }

    /// A doubt about samples that are missing without a gap in the rows.
    pub(super) fn hidden(&self) -> Option<String> {
        self.hidden.1.clone()
    }

    /// The whole trial, of which nothing was written.
    ///
    /// # Errors
    /// A derivative of one sample; a number that no file of ours holds.
    pub(super) fn samples(mut self) -> Result<Samples, Errors> {
        self.derive(true)?;
        let mut samples = Samples::default();
        for (to, values) in self.columns {
            set(&mut samples, &to, values);
        }
        samples.check(&self.path)?;
        check_sizes(&self.path, &samples)?;
        Ok(samples)
    }

    /// Checks that the next rows can follow in the trial.
    fn check(&self, part: &Samples) -> Result<(), StoreError> {
        part.check(&self.path)?;
        check_sizes(&self.path, part)?;
        let (Some([first, last]), Some(t)) = (self.times, part.get(Signal::Time)) else {
            return Ok(());
        };
        let (row, what, remedy) = if t.first().is_some_and(|t| *t <= last) {
            let what = format!("time runs backwards or stands still: {} s after {last} s", t[0]);
            (
                0,
                what,
                "set equal = \"drop\", wrap or backwards = \"split\" in [time], or sort the recording",
            )
        } else {
            // With the trial's first time, from which its span is counted.
            let with_first: Vec<f64> = std::iter::once(first).chain(t.iter().copied()).collect();
            let Err((row, what)) = check_time(&with_first) else { return Ok(()) };
            (row.max(1) - 1, what, "check the unit of the time, or leave the row out")
        };
        let error = StoreError::new(&self.path, what, remedy);
        Err(error.column(Signal::Time.name()).row0(row))
    }

    /// An error about our column and a sample's number, as one about their column, row and line.
    fn in_their_words(&self, error: StoreError, part: &Part) -> StoreError {
        let mut ours = self.columns.iter().take(part.numeric.len());
        let place = ours.position(|(to, _)| Some(to.name()) == error.column.as_deref());
        let (Some(i), Some(row)) = (place, error.row) else { return error };
        // An error counts rows from 1. The time comes first.
        let at = row - 1;
        let column = part.numeric[i];
        let is_time = i == 0 && self.plan.time.is_some();
        let key = is_time.then(|| part.recording.time_remedy(column, part.rows, at)).flatten();
        let remedy = key.unwrap_or(error.remedy);
        let error = part.recording.cell_error(column, part.rows[at], &error.what, &remedy);
        StoreError { row: error.row.map(|row| row + part.before.row), ..error }
    }

    fn column(&self, signal: Signal) -> &[f64] {
        let column = self.columns.iter().find(|(to, _)| *to == To::Signal(signal));
        column.map_or(&[], |(_, values)| values)
    }

    /// Computes what the rows at hand allow; at the end all.
    ///
    /// dx/dt is by central differences, one-sided at the trial's ends ([`slope`], [`central`]), and
    /// ∫ x dt by the trapezoidal rule from the trial's first sample.
    fn derive(&mut self, end: bool) -> Result<(), Errors> {
        let is_short = end && self.rows == 0 && self.column(Signal::Time).len() < 2;
        for (to, rule) in &self.plan.derived {
            if is_short && matches!(rule, Rule::DerivativeOf(_)) {
                let what = "a derivative needs at least 2 samples in a trial";
                let remedy = "leave the file out, or remove derive from the mapping";
                return Err(StoreError::new(&self.path, what, remedy).into());
            }
            let source = match *rule {
                Rule::DerivativeOf(source) | Rule::IntegralOf(source) => source,
                Rule::AlongPush(_) => {
                    if let Some(projection) = self.plan.projections.get(to) {
                        let more = self.projected(*to, projection);
                        self.extend(*to, more);
                    }
                    continue;
                }
            };
            let t = self.column(Signal::Time);
            let x = self.column(source);
            let have = self.column(*to);
            let n = t.len().min(x.len());
            // Whether the first row at hand is the trial's first.
            let from_start = self.rows == self.written;
            let more: Vec<f64> = match rule {
                Rule::DerivativeOf(_) => {
                    // The last row at hand waits: its slope needs the row behind it.
                    let until = if end { n } else { n.saturating_sub(1) };
                    (have.len()..until)
                        .map(|i| match i {
                            0 if from_start => slope(t, x, 0),
                            _ if i + 1 == n => slope(t, x, i - 1),
                            _ => central(t, x, i),
                        })
                        .collect()
                }
                _ => {
                    let mut sum = have.last().copied().unwrap_or(0.0);
                    let sums = (have.len()..n).map(|i| {
                        if i > 0 {
                            sum += 0.5 * (x[i] + x[i - 1]) * (t[i] - t[i - 1]);
                        }
                        sum
                    });
                    sums.collect()
                }
            };
            self.extend(*to, more);
        }
        Ok(())
    }

    /// The projection on the push of the rows at hand that have none yet.
    fn projected(&mut self, to: Signal, projection: &Projection) -> Vec<f64> {
        let parts: Vec<(&[f64], f64)> =
            projection.parts.iter().map(|(axis, part)| (self.column(*axis), *part)).collect();
        let n = parts.iter().map(|(values, _)| values.len()).min().unwrap_or(0);
        let mut more: Vec<f64> = (self.column(to).len()..n)
            .map(|i| parts.iter().fold(0.0, |sum, (values, part)| sum + part * values[i]))
            .collect();
        let Some(first) = more.first().copied() else { return more };
        let zero = match projection.zero {
            Some(zero) => zero,
            None => *self.first_places.entry(to).or_insert(first),
        };
        for value in &mut more {
            *value = (*value - zero) / projection.per;
        }
        more
    }

    fn extend(&mut self, to: Signal, more: Vec<f64>) {
        if let Some((_, values)) = self.columns.iter_mut().find(|c| c.0 == To::Signal(to)) {
            values.extend(more);
        }
    }

    /// Gives whole parts to the writer; at the end all.
    ///
    /// # Errors
    /// Those of [`Growing::samples`]; the disk's.
    pub(super) fn write(&mut self, writer: &mut TrialWriter, end: bool) -> Result<(), Errors> {
        self.derive(end)?;
        let ready = self.columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
        let mut from = self.written;
        while ready - from >= PART || (end && ready > from) {
            let to = ready.min(from + PART);
            let mut group = Samples::default();
            for (column, values) in &self.columns {
                set(&mut group, column, values[from..to].to_vec());
            }
            check_sizes(&self.path, &group)?;
            writer.add(&group)?;
            self.rows += to - from;
            from = to;
        }
        // The last row written stays: the next one's derivative looks back to it.
        let gone = from.saturating_sub(1);
        if from > self.written {
            self.columns.iter_mut().for_each(|(_, values)| drop(values.drain(..gone)));
            self.written = from - gone;
        }
        Ok(())
    }
}

fn set(samples: &mut Samples, to: &To, values: Vec<f64>) {
    match to {
        To::Signal(signal) => samples.set(*signal, values),
        To::Channel(id) => samples.set_channel(id.clone(), values),
    }
}
