//! The times of a stream's samples on the recorder's clock: as `pyxdf` 1.17 has them with its usual
//! settings.
//!
//! Source: `pyxdf` 1.17, `_clock_sync`, `_detect_clock_resets`, `_robust_fit` and
//! `_jitter_removal`; the fit is that of S. Boyd et al., "Distributed Optimization and Statistical
//! Learning via the Alternating Direction Method of Multipliers" (2011), section 6.1.1.

use super::super::convert::median;
use std::ops::Range;

/// When the clocks were compared, on the stream's clock, s, and what then lacked to the recorder's,
/// s.
pub(super) type Offset = (f64, f64);

/// A difference of offsets beyond which one counts as an outlier, s.
const WINSOR_S: f64 = 1e-4;
/// Steps of the robust fit.
const STEPS: usize = 1000;
/// A clock was set anew where the time between comparisons is off its median by so many median
/// deviations and so many seconds, and the offset too.
const TIME_RESET: (f64, f64) = (5.0, 5.0);
const OFFSET_RESET: (f64, f64) = (10.0, 1.0);
/// Offsets that differ by more than this, s, are not of one setting of the clocks: networks delay less.
const STEP_S: f64 = 0.5;
/// A break in a regular stream: a step from one sample to the next of more than so many intervals …
const BREAK_INTERVALS: f64 = 3.0;
/// … that lasts for so many samples, because one that comes late is followed by one in time.
const LASTS: usize = 50;
/// How far, as a part, the rate of the samples may lie from the one that the stream names.
const RATE_OFF: f64 = 0.05;

/// What came of putting times on the recorder's clock.
pub(super) struct Synchronised {
    /// Whether each stretch of offsets had a line; otherwise its times stay as they are.
    pub(super) all_used: bool,
    /// Clocks that were set anew.
    pub(super) doubts: Vec<String>,
}

/// The offsets without those that are off by themselves, and which these are.
pub(super) fn without_outliers(offsets: &[Offset]) -> (Vec<Offset>, Vec<String>) {
    let differ = |a: usize, b: usize| (offsets[a].1 - offsets[b].1).abs() > STEP_S;
    let is_alone = |i: usize| match i {
        _ if offsets.len() < 3 => false,
        0 => differ(0, 1) && !differ(1, 2),
        _ if i + 1 == offsets.len() => differ(i, i - 1) && !differ(i - 1, i - 2),
        _ => differ(i, i - 1) && differ(i, i + 1) && !differ(i - 1, i + 1),
    };
    let (mut kept, mut doubts) = (Vec::new(), Vec::new());
    for (i, offset) in offsets.iter().enumerate() {
        if !is_alone(i) {
            kept.push(*offset);
            continue;
        }
        let (n, of) = (i + 1, offsets.len());
        let by_s = offset.1 - offsets[if i == 0 { 1 } else { i - 1 }].1;
        doubts.push(format!(
            "clock offset {n} of {of} lies {by_s:.3} s off those beside it, and is left out: was a clock set while this was \
             recorded?"
        ));
    }
    (kept, doubts)
}

/// Adds to each time what the offsets say: a line through those between two resets of the clock.
pub(super) fn synchronise(times: &mut [f64], offsets: &[Offset]) -> Synchronised {
    let stretches = stretches(offsets);
    let mut rest = times;
    let (mut all_used, mut doubts) = (true, Vec::new());
    for (i, stretch) in stretches.iter().enumerate() {
        let line = line(&offsets[stretch.clone()]);
        all_used &= line.is_some();
        let (start, slope) = line.unwrap_or((0.0, 0.0));
        let here = match offsets.get(stretch.end).filter(|_| i + 1 < stretches.len()) {
            Some(next) => {
                let last = offsets[stretch.end - 1];
                let step_s = next.1 - last.1;
                doubts.push(format!(
                    "a clock was set anew by {step_s:.3} s while this was recorded: times before and behind that are lined up \
                     each by themselves"
                ));
                // Where the stream's own clock steps as far the other way, or else up to the first time that is
                // nearer to the next comparison than to the last one.
                let steps = |pair: &[f64]| (pair[1] - pair[0] + step_s).abs() < 0.1 * step_s.abs();
                let at_step = rest.windows(2).position(steps).map(|before| before + 1);
                let nearer = || rest.iter().position(|t| (t - last.0).abs() >= (t - next.0).abs());
                at_step.or_else(nearer).unwrap_or(rest.len())
            }
            None => rest.len(),
        };
        let (now, later) = std::mem::take(&mut rest).split_at_mut(here);
        now.iter_mut().for_each(|t| *t += start + slope * *t);
        rest = later;
    }
    Synchronised { all_used, doubts }
}

/// The offsets between two resets of the clock.
fn stretches(offsets: &[Offset]) -> Vec<Range<usize>> {
    let difference = |of: fn(&Offset) -> f64| -> Vec<f64> {
        offsets.windows(2).map(|pair| of(&pair[1]) - of(&pair[0])).collect()
    };
    let times = difference(|offset| offset.0);
    let (late, off) = (glitches(&times, TIME_RESET), glitches(&difference(|o| o.1), OFFSET_RESET));
    // pyxdf lets a line run through a step that took no time, which is wrong on both sides of it.
    let near = |a: usize, b: usize| (offsets[a].1 - offsets[b].1).abs() <= STEP_S;
    let steps = |i: usize| {
        !near(i, i + 1)
            && offsets.len() > 2
            && (i == 0 || near(i - 1, i))
            && (i + 2 >= offsets.len() || near(i + 1, i + 2))
    };
    let is_reset = |i: &usize| times[*i] < 0.0 || (late[*i] && off[*i]) || steps(*i);
    let resets = (0..times.len()).filter(is_reset);
    parts(offsets.len(), resets)
}

/// `0..length`, parted behind each of `ends`.
fn parts(length: usize, ends: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = 0;
    for end in ends.map(|i| i + 1).chain([length]) {
        if end > from {
            parts.push(from..end);
        }
        from = end;
    }
    parts
}

/// Which values are off their median by more than so many median deviations, and by more than so
/// much.
fn glitches(values: &[f64], (deviations, at_least): (f64, f64)) -> Vec<bool> {
    let middle = median(values.to_vec());
    let off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    let usual = median(off.clone()) + f64::EPSILON;
    off.iter().map(|off| off / usual > deviations && *off > at_least).collect()
}

/// Start, s, and slope of the line offset = start + slope · t through a stretch; `None` where it
/// has none.
fn line(offsets: &[Offset]) -> Option<Offset> {
    match offsets {
        [] => None,
        [(_, offset)] => Some((*offset, 0.0)),
        _ => robust_line(offsets),
    }
}

/// The line that minimises the sum of Huber's loss of offset − start − slope · t in units of
/// [`WINSOR_S`], by the alternating directions method of multipliers with ρ = 1.
fn robust_line(offsets: &[Offset]) -> Option<Offset> {
    let scaled: Vec<Offset> =
        offsets.iter().map(|(t, offset)| (t / WINSOR_S, offset / WINSOR_S)).collect();
    let first = scaled.iter().map(|(t, _)| *t).fold(f64::INFINITY, f64::min);
    let rows: Vec<Offset> = scaled.iter().map(|(t, y)| (t - first, *y)).collect();
    #[allow(clippy::cast_precision_loss)] // At most 2¹⁶ of them.
    let n = rows.len() as f64;
    let (sum_t, sum_tt) = rows.iter().fold((0.0, 0.0), |(a, b), (t, _)| (a + t, b + t * t));
    let pivot = sum_tt - sum_t * sum_t / n;
    if !(pivot > 0.0 && pivot.is_finite()) {
        return None;
    }
    // z − u of each row, in which alone the rows remember the last step.
    let mut held = vec![(0.0, 0.0); rows.len()];
    let mut found = (0.0, 0.0);
    for _ in 0..STEPS {
        let (mut b0, mut b1) = (0.0, 0.0);
        for ((t, y), (z, u)) in rows.iter().zip(&held) {
            let right = y + z - u;
            b0 += right;
            b1 += t * right;
        }
        let slope = (b1 - sum_t * b0 / n) / pivot;
        found = ((b0 - slope * sum_t) / n, slope);
        for ((t, y), held) in rows.iter().zip(&mut held) {
            let d = found.0 + found.1 * t - y + held.1;
            let z = 0.5 * d + 0.5 * shrunk(d);
            *held = (z, d - z);
        }
    }
    let (start, slope) = found;
    Some(((start - slope * first) * WINSOR_S, slope))
}

/// d · max(0, 1 − 2 / |d|), the proximal step of |d| twice.
fn shrunk(d: f64) -> f64 {
    if d.abs() > 2.0 { d * (1.0 - 2.0 / d.abs()) } else { 0.0 }
}

/// Puts the times of a regular stream on a straight line through them, between two breaks each; the breaks,
/// and a rate that is not the one which the stream names.
///
/// pyxdf breaks the line at gaps of more than a second and 500 samples alone, and spreads shorter ones over
/// the whole recording.
pub(super) fn remove_jitter(times: &mut [f64], rate_hz: f64) -> Vec<String> {
    let interval_s = 1.0 / rate_hz;
    // How late a sample is against the first at this rate; the least of many, because some are late.
    let late = |i: usize| times[i] - i as f64 * interval_s;
    let least = |range: Range<usize>| range.map(late).fold(f64::INFINITY, f64::min);
    let steps = |i: usize| {
        let (before, after) =
            (i.saturating_sub(LASTS - 1)..i + 1, i + 1..(i + 1 + LASTS).min(times.len()));
        least(after) - least(before)
    };
    let limit_s = BREAK_INTERVALS * interval_s;
    let breaks: Vec<(usize, f64)> = (0..times.len().saturating_sub(1))
        .filter(|i| (times[i + 1] - times[*i]).abs() > limit_s)
        .map(|i| (i, steps(i)))
        .filter(|(_, step_s)| step_s.abs() > limit_s)
        .collect();
    let mut doubts = Vec::new();
    if let Some((first, step_s)) = breaks.first() {
        let all_s: f64 = breaks.iter().map(|(_, step_s)| step_s).sum();
        let others = match breaks.len() {
            1 => String::new(),
            n => format!(", and {} more gaps: {all_s:.2} s in all", n - 1),
        };
        doubts.push(format!(
            "{step_s:.2} s ({:.0} samples at {rate_hz} Hz) are missing behind sample {}{others}",
            step_s * rate_hz,
            first + 1
        ));
    }
    let (mut spanned_s, mut intervals) = (0.0, 0);
    for part in parts(times.len(), breaks.iter().map(|(i, _)| *i)) {
        let part = &mut times[part];
        straighten(part);
        if let [first, .., last] = *part {
            spanned_s += last - first;
            intervals += part.len() - 1;
        }
    }
    let found_hz = intervals as f64 / spanned_s;
    if (found_hz / rate_hz - 1.0).abs() > RATE_OFF {
        doubts.push(format!(
            "the stream says {rate_hz} Hz, and {found_hz:.1} samples per second were recorded"
        ));
    }
    doubts
}

/// Replaces values by those of the least-squares line over their places.
#[allow(clippy::cast_precision_loss)] // Rows are fewer than 2⁵³.
fn straighten(values: &mut [f64]) {
    let n = values.len() as f64;
    let Some(first) = values.first().copied().filter(|_| values.len() > 1) else { return };
    let middle = (n - 1.0) / 2.0;
    let mean = values.iter().map(|v| v - first).sum::<f64>() / n;
    let around = |i: usize| i as f64 - middle;
    let slope = values.iter().enumerate().map(|(i, v)| around(i) * (v - first - mean)).sum::<f64>()
        / (n * (n * n - 1.0) / 12.0);
    for (i, value) in values.iter_mut().enumerate() {
        *value = first + (mean + slope * around(i));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: &[f64], expect: &[f64]) {
        assert_eq!(found.len(), expect.len());
        let off = found.iter().zip(expect).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{found:?} {expect:?}");
    }

    #[test]
    fn a_clock_that_drifts_steadily_is_followed_whatever_one_comparison_says() {
        let mut offsets: Vec<Offset> =
            (0..20).map(|i| 1000.0 + 5.0 * f64::from(i)).map(|t| (t, 3.0 - 1e-5 * t)).collect();
        offsets[7].1 += 0.2;
        let mut times = [1000.0, 1050.0, 1099.0];
        assert!(synchronise(&mut times, &offsets).all_used);
        let expect = [1000.0, 1050.0, 1099.0].map(|t| t + 3.0 - 1e-5 * t);
        // Huber's loss lets an outlier pull like one of the threshold.
        assert!(times.iter().zip(expect).all(|(a, b)| (a - b).abs() < 5e-5), "{times:?}");
    }

    #[test]
    fn one_comparison_shifts_and_none_leaves() {
        let mut times = [1.0, 2.0];
        assert!(synchronise(&mut times, &[(0.0, 10.0)]).all_used);
        near(&times, &[11.0, 12.0]);
        assert!(synchronise(&mut times, &[]).all_used);
        near(&times, &[11.0, 12.0]);
        assert!(!synchronise(&mut times, &[(5.0, 1.0), (5.0, 2.0)]).all_used);
        near(&times, &[11.0, 12.0]);
    }

    #[test]
    fn a_clock_that_was_set_anew_has_a_line_before_and_one_behind() {
        let before = (0..10).map(|i| (100.0 + 5.0 * f64::from(i), 2.0));
        let behind = (0..10).map(|i| (5.0 * f64::from(i), 150.0));
        let offsets: Vec<Offset> = before.chain(behind).collect();
        let mut times = [101.0, 144.0, 1.0, 20.0];
        assert!(synchronise(&mut times, &offsets).all_used);
        near(&times, &[103.0, 146.0, 151.0, 170.0]);
    }

    #[test]
    fn jitter_goes_and_a_break_stays() {
        let jitter = [0.001, -0.001, -0.001, 0.001];
        let steady = |i: usize| 7.0 + 0.01 * i as f64 + if i < 400 { 0.0 } else { 20.0 };
        let mut times: Vec<f64> = (0..800).map(|i| steady(i) + jitter[i % 4]).collect();
        remove_jitter(&mut times, 100.0);
        let expect: Vec<f64> = (0..800).map(steady).collect();
        near(&times[400..401], &expect[400..401]);
        near(&times, &expect);
        let mut alone = [5.0];
        remove_jitter(&mut alone, 100.0);
        near(&alone, &[5.0]);
    }
}
