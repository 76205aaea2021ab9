//! Columns that count samples or time, and the samples that the counts skip.

use super::clock::{Clock, clock};
use super::convert::median;
use super::guess_words::parse_name;
use super::plan::Plan;
use super::recording::Recording;
use super::table::ColumnRef;
use super::unit;
use arrow::array::Array as _;
use std::collections::BTreeMap;
use zwidth_numerics::series::ends;
use zwidth_store::Signal;

/// Fewest rows that show what a column counts.
const LEAST: usize = 20;
/// A column counts if it goes on by one and the same step in this share of its rows at least.
const STEADY: f64 = 0.8;
/// Times are steady within this share of their step.
const JITTER: f64 = 0.5;
/// A column of times contradicts the rate if it differs by more than this share.
const OTHER_RATE: f64 = 0.02;
/// A gap is told of so many samples, …
const LEAST_GAP: f64 = 5.0;
/// … or where this share of all samples is missing.
const LEAST_SHARE: f64 = 0.01;

/// From where to where counters of boards and clocks of a day count; the last two are micros() of an
/// Arduino in milliseconds and in seconds.
const COUNTERS: [[f64; 2]; 8] = [
    [0.0, 65_536.0],
    [-32_768.0, 32_768.0],
    [0.0, 16_777_216.0],
    [0.0, 4_294_967_296.0],
    [-2_147_483_648.0, 2_147_483_648.0],
    [0.0, 86_400.0],
    [0.0, 4_294_967.296],
    [0.0, 4_294.967_296],
];

/// Where a time starts over that falls from the end of a counter to its beginning: another trial would begin
/// anywhere.
pub(super) fn wrap_of(times: &[f64]) -> Option<f64> {
    let falls: Vec<&[f64]> = times.windows(2).filter(|t| t[1] < t[0]).collect();
    if falls.is_empty() {
        return None;
    }
    // Up to five usual steps: a few samples may be lost where the counter starts over.
    let near = 5.0 * median(times.windows(2).map(|t| (t[1] - t[0]).abs()).collect());
    let wrap = COUNTERS.iter().find(|[low, high]| {
        falls.iter().all(|fall| {
            let before = high - fall[0];
            let after = fall[1] - low;
            before >= 0.0 && after >= 0.0 && before + after <= near
        })
    });
    wrap.map(|[low, high]| high - low)
}

/// Samples that a counter passes over.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Gaps {
    /// In how many places.
    pub(super) places: usize,
    /// The number of samples, if none of the gaps is longer than the counter counts.
    pub(super) samples: f64,
    longest: f64,
    all: f64,
}

impl Gaps {
    /// Of so many missing samples in each place; fewer than none where a count that came late is made up
    /// for.
    fn of(missing: impl Iterator<Item = f64>, rows: usize) -> Self {
        let mut gaps = Self { all: rows as f64, ..Self::default() };
        for missing in missing {
            gaps.places += usize::from(missing > 0.0);
            gaps.samples += missing;
            gaps.longest = gaps.longest.max(missing);
        }
        gaps
    }

    /// Whether so many samples are missing that a result may depend on it.
    pub(super) fn matter(self) -> bool {
        let is_long = self.longest >= LEAST_GAP && self.samples >= LEAST_GAP;
        is_long || self.samples >= LEAST_SHARE * (self.all + self.samples).max(1.0)
    }
}

/// Columns that are looked at for what they count, besides those of the mapping.
const MOST_LOOKED_AT: usize = 16;

/// The columns that are looked at.
pub(super) fn looked_at() -> impl Iterator<Item = ColumnRef> {
    (1..=MOST_LOOKED_AT).map(ColumnRef::Position)
}

/// Findings about columns from which the mapping does not take the time.
#[derive(Debug, Default)]
pub(super) struct Elsewhere {
    /// The samples that each passes over, by its place.
    gaps: BTreeMap<usize, Gaps>,
    /// Columns of times whose rate is another one, Hz.
    rates: BTreeMap<usize, f64>,
}

impl Elsewhere {
    /// Adds what the next rows say.
    pub(super) fn add(&mut self, next: Self) {
        for (column, gaps) in next.gaps {
            let before = self.gaps.entry(column).or_default();
            before.places += gaps.places;
            before.samples += gaps.samples;
            before.longest = before.longest.max(gaps.longest);
            before.all += gaps.all;
        }
        self.rates.extend(next.rates);
    }
}

/// A doubt about the samples that the counter which the time is from passes over.
pub(super) fn passed_over(t_s: &[f64], rate_hz: f64) -> Option<String> {
    let step_s = 1.0 / rate_hz;
    let missing = t_s.windows(2).map(|pair| ((pair[1] - pair[0]) / step_s).round() - 1.0);
    let gaps = Gaps::of(missing.filter(|missing| *missing > 0.0), t_s.len());
    gaps.matter().then(|| {
        format!(
            "t_s: its counter passes over {} samples in {} places, or over more if a gap is longer than it counts",
            gaps.samples, gaps.places
        )
    })
}

/// What other columns say of these rows, whose times are `t_s`. Channels of the study's own may count
/// too; `numeric` are the places of signals and channels.
pub(super) fn elsewhere(
    recording: &Recording,
    numeric: &[usize],
    plan: &Plan,
    labels: &[usize],
    rows: &[usize],
    t_s: &[f64],
) -> Elsewhere {
    let signals = &numeric[..plan.taken.len()];
    let mut elsewhere = Elsewhere::default();
    for column in 0..recording.table.columns.len() {
        // Signals are measured, and a label is the same in each row: neither counts.
        if signals.contains(&column) || labels.contains(&column) {
            continue;
        }
        let Some(values) = numbers(recording, column, rows) else { continue };
        elsewhere.gaps.extend(hidden(&values, t_s).map(|gaps| (column, gaps)));
        let rate_hz = plan.rate_hz.zip(rate_hz(&recording.table.name(column), &values));
        let other = rate_hz.filter(|(ours, theirs)| (theirs / ours - 1.0).abs() > OTHER_RATE);
        elsewhere.rates.extend(other.map(|(_, rate_hz)| (column, rate_hz)));
    }
    elsewhere
}

/// A column's numbers, or its times where they are written as those of a clock.
fn numbers(recording: &Recording, column: usize, rows: &[usize]) -> Option<Vec<f64>> {
    if let Ok(values) = recording.numbers(column, rows) {
        return Some(values);
    }
    let read = clock(&recording.table.columns[column], &recording.cells, false);
    let Ok(Some(Clock::Seconds(values))) = read else { return None };
    rows.iter().map(|row| values.is_valid(*row).then(|| values.value(*row))).collect()
}

/// The rate of a column that says by its name that it holds times, and in what unit.
fn rate_hz(name: &str, values: &[f64]) -> Option<f64> {
    let parsed = parse_name(name);
    let unit = parsed.unit.filter(|_| parsed.signal == Some(Signal::Time))?;
    let step = median(values.windows(2).map(|pair| pair[1] - pair[0]).collect());
    let step_s = step * unit::find(&unit)?.to_si;
    (values.len() >= LEAST && step_s > 0.0).then(|| 1.0 / step_s)
}

/// A doubt about the time, if what other columns say matters.
pub(super) fn doubt(recording: &Recording, plan: &Plan, elsewhere: &Elsewhere) -> Option<String> {
    if let Some((column, gaps)) = elsewhere.gaps.iter().find(|(_, gaps)| gaps.matter()) {
        let name = recording.table.name(*column);
        let Gaps { places, samples, .. } = gaps;
        let taken = match plan.rate_hz {
            Some(_) => "rate_hz takes the rows for evenly spaced",
            None => "its times have no gap",
        };
        return Some(format!(
            "t_s: {taken}, but column {name} passes over {samples} samples in {places} places: take the time from it \
             (`from`), or the number of each sample (`counter`, with rate_hz and wrap)"
        ));
    }
    let (column, rate_hz) = elsewhere.rates.iter().next()?;
    let name = recording.table.name(*column);
    Some(format!(
        "t_s: rate_hz is {}, and column {name} has {rate_hz:.1} samples a second: take the time from it (`from`), or \
         mend rate_hz",
        plan.rate_hz.unwrap_or_default()
    ))
}

/// What a column counts that the mapping does not take the time from: the samples it passes over without
/// a gap of the times `t_s`, if it counts samples, packets of them, or time at all.
pub(super) fn hidden(values: &[f64], t_s: &[f64]) -> Option<Gaps> {
    if values.len() < LEAST {
        return None;
    }
    let counts = unwrapped(values)?;
    // The first rows of its packets, which all have one number.
    let begins = (0..counts.len()).filter(|row| *row == 0 || counts[*row] > counts[*row - 1]);
    let begins: Vec<usize> = begins.collect();
    let lengths: Vec<f64> = begins.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    // The first packet may have begun before.
    let length = usual(lengths.get(1..)?, 0.0)?;
    let steps: Vec<f64> = begins.windows(2).map(|pair| counts[pair[1]] - counts[pair[0]]).collect();
    let step = usual(&steps, JITTER)?;
    let step_s = median(t_s.windows(2).map(|pair| pair[1] - pair[0]).collect());
    // The first packet may have begun before, and the last go on: only those between others show what a
    // number stood for. A number that is held until the next one, as that of a camera's picture, stands for
    // as many rows.
    let passed_over = (1..steps.len()).filter_map(|i| {
        let missing = (steps[i] / step).round() * length - lengths[i];
        let row = begins[i + 1];
        let between_s = t_s[row] - t_s[row - 1];
        (between_s < (1.0 + missing / 2.0) * step_s || missing < 0.0).then_some(missing)
    });
    Some(Gaps::of(passed_over, values.len()))
}

/// The middle of positive steps, if most are within this share of it.
fn usual(steps: &[f64], share: f64) -> Option<f64> {
    let middle = median(steps.to_vec());
    let steady =
        steps.iter().filter(|step| (**step - middle).abs() <= share * middle).count() as f64;
    // `LEAST` rows have one step fewer, and the first packet is left out.
    let is_steady = steps.len() + 2 >= LEAST && steady >= STEADY * steps.len() as f64;
    (middle > 0.0 && is_steady && steps.iter().all(|step| *step > 0.0)).then_some(middle)
}

/// A column that only grows, or starts over at 0 after a power of two.
fn unwrapped(values: &[f64]) -> Option<Vec<f64>> {
    let falls = values.windows(2).filter(|pair| pair[1] < pair[0]).count();
    if falls == 0 {
        return Some(values.to_vec());
    }
    let (low, high) = ends(values);
    let wrap = high + 1.0;
    // A measured signal may fall to 0 too, but hardly so seldom and from one less than a power of two.
    let is_counter = low == 0.0
        && values.iter().all(|value| value.fract() == 0.0)
        && wrap.log2().fract() == 0.0
        && falls as f64 <= 2.0 * values.len() as f64 / wrap + 1.0;
    if !is_counter {
        return None;
    }
    let mut turns = 0.0;
    let mut before = values[0];
    Some(Vec::from_iter(values.iter().map(|value| {
        turns += f64::from(u8::from(*value < before));
        before = *value;
        value + turns * wrap
    })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_or_a_clock_shows_what_is_missing_and_other_columns_show_nothing() {
        let counter = |lost: std::ops::Range<u32>| -> Vec<f64> {
            (0..300).filter(|n| !lost.contains(n)).map(|n| f64::from(n % 16)).collect()
        };
        let even: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let counted = |values: &[f64]| hidden(values, &even[..values.len()]);
        let found = counted(&counter(100..110)).unwrap();
        assert!((found.places, found.samples) == (1, 10.0) && found.matter());
        assert!(!counted(&counter(100..101)).unwrap().matter());
        let told: Vec<f64> =
            (0..300).filter(|n| !(100..110).contains(n)).map(|n| 0.01 * f64::from(n)).collect();
        assert_eq!(hidden(&counter(100..110), &told).unwrap().places, 0, "its times have the gap");
        let packets: Vec<f64> =
            (0..320).map(|n| n / 8).filter(|n| *n != 20).map(f64::from).collect();
        let found = counted(&packets).unwrap();
        assert!((found.places, found.samples) == (1, 8.0) && found.matter());
        // A camera that skips a picture, beside samples of which none is missing.
        let pictures: Vec<f64> =
            (0..400).map(|n| n / 20).map(|n| if n == 7 { 6 } else { n }).map(f64::from).collect();
        assert!(!counted(&pictures).is_some_and(Gaps::matter));
        // A host's clock that comes late now and then, and is in time again.
        let late: Vec<f64> =
            (0..300).map(|n| f64::from(n) + if n % 20 == 7 { 0.9 } else { 0.0 }).collect();
        assert!(!counted(&late).is_some_and(Gaps::matter));
        let clock: Vec<f64> = counter(0..0)
            .iter()
            .enumerate()
            .map(|(i, n)| 0.01 * i as f64 + 1e-4 * n + if i > 200 { 1.0 } else { 0.0 })
            .collect();
        assert!(counted(&clock).unwrap().matter());
        let swing: Vec<f64> = (0..300).map(|i| libm::sin(0.1 * f64::from(i))).collect();
        assert_eq!(counted(&swing), None);
        let ramp: Vec<f64> = (0..300).map(|i| f64::from(i.min(300 - i))).collect();
        assert_eq!(counted(&ramp), None);
    }
}
