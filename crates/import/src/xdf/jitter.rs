//! Removes the jitter of a regular stream's times: between gaps, they are put on straight lines.
//!
//! Source: `pyxdf` 1.17, `_jitter_removal`. It breaks the line only at gaps of more than a second
//! and 500 samples, and spreads shorter gaps over the whole recording.

use super::super::convert::median;
use super::clock::parts;
use std::collections::VecDeque;
use std::ops::Range;

/// Samples are judged by so many behind them, and by those of so long, s: a sample that comes late,
/// alone or with its chunk, is followed by one in time, and a lost one is not …
const LASTS: usize = 50;
const LASTS_S: f64 = 1.0;
/// … but by no more than so many: the interval is not known better than for these.
const LASTS_AT_MOST: usize = 500;
/// A sample is lost where those behind it lie later by more than this part of the interval …
const LEAST_LOST: f64 = 0.5;
/// … by this much more than such times fall again, which they do for jitter alone …
const FALLS: f64 = 2.0;
/// … and, where few samples tell, by this much more than most of them are late.
const LATES: f64 = 2.0;
/// "Most" of the samples.
const MOST: f64 = 0.95;
/// A recording of so many stretches of [`LASTS`] samples shows how far times fall for jitter.
const FEW: usize = 10;
/// A stall holds samples up for more than so many intervals …
const STALL_INTERVALS: f64 = 10.0;
/// … and so many times what the middle one of all samples is late …
const STALL_LATES: f64 = 4.0;
/// … and ends where times are late by less than this part of it …
const STALL_ENDS: f64 = 0.1;
/// … within so many intervals for each that it lasts: what was held up comes faster than it was sampled.
const STALL_LASTS: f64 = 4.0;
/// The interval is that of spans of a recording's so many-th part at most, so that a gap is within few of them.
const SPANS: usize = 8;
/// Lines are tried so often without the gaps at which they would run backwards.
const TRIES: usize = 20;
/// A clock ran backwards where a time lies before the last one by more intervals than this.
const BACKWARDS: f64 = 3.0;
/// How far from the line the times may lie over [`LASTS`] samples, s.
const MOST_OFF_LINE_S: f64 = 0.05;
/// Gaps that are shorter in all are told to the millisecond, s.
const SHORT_S: f64 = 0.1;
/// Jitter hid gaps where the samples missing by their count differ from those of the gaps by this part of them.
const COUNT_OFF: f64 = 0.1;
/// How far, as a part, the rate of the samples may lie from the one that the stream names.
const RATE_OFF: f64 = 0.05;

/// Samples that are missing behind a sample, and their time.
struct Gap {
    behind: usize,
    lasts_s: f64,
}

/// Puts the times of a regular stream on a straight line through them, between two gaps each; the gaps, times
/// that lie on no line, and a rate that is not the one which the stream names.
pub(super) fn remove_jitter(times: &mut [f64], rate_hz: f64) -> Vec<String> {
    let lasts = ((LASTS_S * rate_hz) as usize).clamp(LASTS, LASTS_AT_MOST);
    let mut gaps = Vec::new();
    let mut spanned_s = 0.0;
    let mut intervals = 0;
    // The samples that the rate has in the time of all, and how far the worst line is off.
    let mut by_rate = 0.0;
    let mut off_s = 0.0_f64;
    let mut is_off = false;
    let mut hides_gaps = false;
    let set_back = set_back(times, 1.0 / rate_hz, lasts);
    for part in parts(times.len(), set_back.into_iter()) {
        let interval_s = interval_s(&times[part.clone()], rate_hz, lasts);
        let mut late = Late::new(&times[part.clone()], interval_s, lasts);
        late.end_stalls();
        let (own_gaps, jitter_s) = late.gaps();
        let from = part.start;
        let times = &mut times[part];
        let stamps = late.times();
        let lines = straight_lines(times, &stamps, own_gaps.iter().map(|gap| gap.behind).collect());
        gaps.extend(own_gaps.into_iter().map(|gap| Gap { behind: from + gap.behind, ..gap }));
        let residuals: Vec<f64> = times.iter().zip(&stamps).map(|(on, at)| at - on).collect();
        by_rate += (times[times.len() - 1] - times[0]) * rate_hz + 1.0;
        hides_gaps |= jitter_s > LEAST_LOST * interval_s;
        for line in lines {
            spanned_s += times[line.end - 1] - times[line.start];
            intervals += line.len() - 1;
            let wander_s = Late { by_s: residuals[line].to_vec(), ..late }.wander_s();
            is_off |= wander_s > MOST_OFF_LINE_S.max(LATES * jitter_s);
            off_s = off_s.max(wander_s);
        }
    }
    let mut doubts = Vec::new();
    let samples = times.len();
    let missing_s = gaps.iter().map(|gap| gap.lasts_s).sum::<f64>();
    if let Some(first) = gaps.first() {
        let (missing, are) = match (missing_s * rate_hz).round() {
            1.0 => ("1 sample".to_owned(), "is"),
            n => (format!("{n} samples"), "are"),
        };
        let which = match gaps.len() {
            1 => "behind".to_owned(),
            n => format!("in {n} gaps, the first behind"),
        };
        let digits = if missing_s < SHORT_S { 3 } else { 2 };
        doubts.push(format!(
            "{missing_s:.digits$} s ({missing} at {rate_hz} Hz) {are} missing {which} sample {}",
            first.behind + 1
        ));
        let by_gaps = missing_s * rate_hz;
        is_off |= hides_gaps && (by_rate - samples as f64 - by_gaps).abs() > COUNT_OFF * by_gaps;
    }
    if is_off {
        doubts.push(format!(
            "{samples} samples were recorded in a time for {by_rate:.0} at {rate_hz} Hz, and their times lie up to \
             {off_s:.2} s off the straight line on which they are put: samples may be missing, or the rate \
             changed, and times may be wrong; dejitter = false in [time] keeps the recorded ones"
        ));
    }
    let recorded_hz = intervals as f64 / spanned_s;
    if (recorded_hz / rate_hz - 1.0).abs() > RATE_OFF {
        doubts.push(format!(
            "the stream says {rate_hz} Hz, and {recorded_hz:.1} samples per second were recorded"
        ));
    }
    doubts
}

/// Puts times on straight lines through the stamps, parted behind each of `breaks`; the samples of each.
fn straight_lines(times: &mut [f64], stamps: &[f64], mut breaks: Vec<usize>) -> Vec<Range<usize>> {
    let mut tries = 0;
    loop {
        times.copy_from_slice(stamps);
        let lines = parts(times.len(), breaks.iter().copied());
        lines.iter().for_each(|line| straighten(&mut times[line.clone()]));
        let before = breaks.len();
        // Few samples between two gaps may all be late, or the first of them most: their line would run backwards.
        breaks.retain(|i| {
            tries < TRIES
                && times[i.saturating_sub(1)..(i + 3).min(times.len())].is_sorted_by(|a, b| a < b)
        });
        if breaks.len() == before {
            return lines;
        }
        tries += 1;
    }
}

/// Behind which samples the clock ran backwards: all are earlier, by the rate, than all up to it, by more
/// than either differ among themselves.
fn set_back(times: &[f64], interval_s: f64, lasts: usize) -> Vec<usize> {
    (0..times.len().saturating_sub(1))
        .filter(|i| times[i + 1] < times[*i] - BACKWARDS * interval_s)
        .filter(|i| {
            let behind = (i + 1 + lasts).min(times.len());
            let [before, behind] =
                [(i + 1).saturating_sub(lasts)..i + 1, i + 1..behind].map(|samples| {
                    let late = samples.map(|i| times[i] - i as f64 * interval_s);
                    late.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), late| {
                        (late.min(least), late.max(most))
                    })
                });
            before.0 - behind.1 > FALLS * (before.1 - before.0).max(behind.1 - behind.0)
        })
        .collect()
}

/// The time from one sample to the next where none is lost: that of the rate which the stream names,
/// where the samples are not plainly at another one.
fn interval_s(times: &[f64], rate_hz: f64, lasts: usize) -> f64 {
    let over = lasts.min(times.len() / SPANS).max(1);
    let mut means: Vec<f64> =
        (over..times.len()).map(|i| (times[i] - times[i - over]) / over as f64).collect();
    means.sort_by(f64::total_cmp);
    let nominal_s = 1.0 / rate_hz;
    match (means.get(means.len() / 4), means.get(3 * means.len() / 4)) {
        (Some(low), Some(high)) if !(*low..=*high).contains(&nominal_s) => median(means),
        _ => nominal_s,
    }
}

/// How late each sample is against the first one and its interval.
struct Late {
    by_s: Vec<f64>,
    interval_s: f64,
    lasts: usize,
}

impl Late {
    fn new(times: &[f64], interval_s: f64, lasts: usize) -> Self {
        let by_s = times.iter().enumerate().map(|(i, t)| t - i as f64 * interval_s).collect();
        Self { by_s, interval_s, lasts }
    }

    fn times(&self) -> Vec<f64> {
        self.by_s.iter().enumerate().map(|(i, late)| late + i as f64 * self.interval_s).collect()
    }

    /// Takes samples for in time that were held up for long, and of which none is lost: those behind them are
    /// in time again. On the line they would weigh too much.
    fn end_stalls(&mut self) {
        let least_s = STALL_INTERVALS * self.interval_s + STALL_LATES * median(self.delays_s());
        let late = &mut self.by_s;
        // Samples behind this one that are less late than all between, the nearest of them last.
        let mut lows: Vec<usize> = Vec::new();
        let mut stalls = Vec::new();
        for i in (0..late.len().saturating_sub(1)).rev() {
            while lows.last().is_some_and(|low| late[*low] >= late[i + 1]) {
                lows.pop();
            }
            lows.push(i + 1);
            let held_s = late[i + 1] - late[i];
            let in_time = lows.partition_point(|low| late[*low] <= late[i] + STALL_ENDS * held_s);
            let Some(end) = in_time.checked_sub(1).map(|nearest| lows[nearest]) else { continue };
            let most = STALL_LASTS * held_s / self.interval_s;
            if held_s > least_s && ((end - i) as f64) < most {
                stalls.push(i..end);
            }
        }
        let mut from = 0;
        // From the first on; one within another is a part of it.
        for Range { start, end } in stalls.into_iter().rev() {
            if start >= from {
                let in_time = late[start];
                late[start + 1..end].fill(in_time);
                from = end;
            }
        }
    }

    /// For each sample the least late one from it on, among as many as it is judged by.
    fn lows(&self) -> Vec<usize> {
        let late = &self.by_s;
        let mut window: VecDeque<usize> = VecDeque::new();
        let mut lows = vec![0; late.len()];
        for i in (0..late.len()).rev() {
            while window.back().is_some_and(|low| late[*low] >= late[i]) {
                window.pop_back();
            }
            window.push_back(i);
            while window.front().is_some_and(|low| *low > i + self.lasts) {
                window.pop_front();
            }
            lows[i] = window.front().copied().unwrap_or(i);
        }
        lows
    }

    /// How late each sample is against the least late one behind it.
    fn delays_s(&self) -> Vec<f64> {
        self.by_s.iter().zip(self.lows()).map(|(late, low)| late - self.by_s[low]).collect()
    }

    /// How far the least late samples of all stretches lie from the middle one of them, s.
    fn wander_s(&self) -> f64 {
        let lows = self.lows();
        let whole = lows.len().saturating_sub(self.lasts);
        let levels: Vec<f64> = lows[..whole].iter().map(|low| self.by_s[*low]).collect();
        let middle = median(levels.clone());
        levels.into_iter().map(|level| (level - middle).abs()).fold(0.0, f64::max)
    }

    /// The gaps, and how late most samples are, s.
    fn gaps(&self) -> (Vec<Gap>, f64) {
        let late = &self.by_s;
        let lows = self.lows();
        let levels: Vec<f64> = lows.iter().map(|low| late[*low]).collect();
        let mut delays = self.delays_s();
        delays.sort_by(f64::total_cmp);
        let most = (MOST * delays.len().saturating_sub(1) as f64) as usize;
        let jitter_s = delays.get(most).copied().unwrap_or(0.0);
        let falls = (self.lasts..late.len()).map(|i| -(levels[i] - levels[i - self.lasts]));
        let limit_s = (LEAST_LOST * self.interval_s).max(FALLS * falls.fold(0.0, f64::max));
        let is_short = late.len() < FEW * self.lasts;
        let mut gaps: Vec<Gap> = Vec::new();
        for (i, low) in lows.iter().enumerate().skip(1) {
            let lasts_s = levels[i] - levels[i - 1];
            let few_tell = is_short || i + self.lasts > late.len();
            if lasts_s <= if few_tell { limit_s.max(LATES * jitter_s) } else { limit_s } {
                continue;
            }
            // The largest step, the first of equal ones, up to the sample that is in time again.
            let largest = (i..=*low)
                .rev()
                .max_by(|a, b| (late[*a] - late[*a - 1]).total_cmp(&(late[*b] - late[*b - 1])));
            gaps.push(Gap { behind: largest.unwrap_or(i) - 1, lasts_s });
        }
        (gaps, jitter_s)
    }
}

/// Replaces values by those of the least-squares line over their places.
#[allow(clippy::cast_precision_loss)] // Rows are fewer than 2⁵³.
fn straighten(values: &mut [f64]) {
    let n = values.len() as f64;
    let Some(first) = values.first().copied().filter(|_| values.len() > 1) else { return };
    let middle = (n - 1.0) / 2.0;
    let mean = values.iter().map(|v| v - first).sum::<f64>() / n;
    // Σ (i − middle)² = n (n² − 1) / 12.
    let slope = values
        .iter()
        .enumerate()
        .map(|(i, v)| (i as f64 - middle) * (v - first - mean))
        .sum::<f64>()
        / (n * (n * n - 1.0) / 12.0);
    for (i, value) in values.iter_mut().enumerate() {
        *value = first + (mean + slope * (i as f64 - middle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_goes_and_a_break_stays() {
        let jitter = [0.001, -0.001, -0.001, 0.001];
        let steady = |i: usize| 7.0 + 0.01 * i as f64 + if i < 400 { 0.0 } else { 20.0 };
        let mut times: Vec<f64> = (0..800).map(|i| steady(i) + jitter[i % 4]).collect();
        remove_jitter(&mut times, 100.0);
        let off = times.iter().enumerate().map(|(i, t)| (t - steady(i)).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{off}");
        let mut alone = [5.0];
        remove_jitter(&mut alone, 100.0);
        assert!((alone[0] - 5.0).abs() < 1e-9, "{alone:?}");
    }
}
