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
/// Offsets of one setting of the clocks differ by this, s, at most: networks delay less …
const STEP_S: f64 = 0.05;
/// … and by so many times what one usually differs from the next.
const STEP_DIFFERENCES: f64 = 10.0;
/// No clock gains or loses more than this share of its time.
const MOST_DRIFT: f64 = 1e-3;
/// A sample is missing where the next one comes later by more than this part of an interval, …
const MISSING_INTERVALS: f64 = 0.5;
/// … and by more than this share of the samples are delayed by, …
const USUAL: f64 = 0.95;
/// … near the end, for the last so many samples, by so many times that.
const AT_THE_END: usize = LASTS;
const FAR_DELAYS: f64 = 3.0;
/// A clock was set back by more than so many intervals …
const BREAK_INTERVALS: f64 = 3.0;
/// … and stays so for so many samples. In so many, one comes in time.
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

/// The offsets without those that are no numbers, or off by themselves, and which these are.
pub(super) fn without_outliers(all: &[Offset]) -> (Vec<Offset>, Vec<String>) {
    let is_number = |offset: &&Offset| offset.0.is_finite() && offset.1.is_finite();
    let offsets: Vec<Offset> = all.iter().filter(is_number).copied().collect();
    let mut doubts = Vec::new();
    if offsets.len() < all.len() {
        doubts.push(format!(
            "{} of {} clock offsets are no numbers, and are left out",
            all.len() - offsets.len(),
            all.len()
        ));
    }
    let step_s = step_s(&offsets);
    // Two of five that are wrong leave the middle to the others, and so does the end of a stretch.
    let usual = |i: usize| {
        let near = &offsets[i.saturating_sub(2)..(i + 3).min(offsets.len())];
        median(near.iter().map(|offset| offset.1).collect())
    };
    let mut kept = Vec::new();
    for (i, offset) in offsets.iter().enumerate() {
        let by_s = offset.1 - usual(i);
        if offsets.len() < 3 || by_s.abs() <= step_s {
            kept.push(*offset);
            continue;
        }
        doubts.push(format!(
            "clock offset {} of {} lies {by_s:.3} s off those beside it, and is left out: was a clock set while this was \
             recorded?",
            i + 1,
            offsets.len()
        ));
    }
    (kept, doubts)
}

/// Offsets that differ by more than this are not of one setting of the clocks, s: by far more than one
/// differs from the next, and by more than networks delay.
fn step_s(offsets: &[Offset]) -> f64 {
    let differences = offsets.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).collect();
    STEP_S.max(STEP_DIFFERENCES * median(differences))
}

/// Adds to each time what the offsets say: a line through those between two resets of the clock.
pub(super) fn synchronise(times: &mut [f64], offsets: &[Offset]) -> Synchronised {
    let stretches = stretches(offsets);
    let mut rest = times;
    let (mut all_used, mut doubts) = (true, Vec::new());
    for (i, stretch) in stretches.iter().enumerate() {
        let here = &offsets[stretch.clone()];
        let line = line(here);
        all_used &= line.is_some();
        let (start, slope) = match line {
            Some((_, slope)) if slope.abs() > MOST_DRIFT => {
                doubts.push(format!(
                    "by {} clock offsets the clocks run apart by {:.2} %, which no clock does: one of them is wrong, and the times \
                     are shifted by their middle alone",
                    here.len(),
                    100.0 * slope.abs()
                ));
                (median(here.iter().map(|offset| offset.1).collect()), 0.0)
            }
            line => line.unwrap_or((0.0, 0.0)),
        };
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
    let step_s = step_s(offsets);
    let near = |a: usize, b: usize| (offsets[a].1 - offsets[b].1).abs() <= step_s;
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
    let breaks = breaks(times, 1.0 / rate_hz);
    let mut doubts = Vec::new();
    if let Some((first, gap_s)) = breaks.first() {
        let all_s: f64 = breaks.iter().map(|(_, gap_s)| gap_s).sum();
        let others = match breaks.len() {
            1 => String::new(),
            n => format!(", and {} more gaps: {all_s:.2} s in all", n - 1),
        };
        doubts.push(format!(
            "{gap_s:.2} s ({:.0} samples at {rate_hz} Hz) are missing behind sample {}{others}",
            gap_s * rate_hz,
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

/// Where samples of a regular stream are missing: behind which, and for how long, s.
///
/// Each sample comes late against its place, by what was missing before it and by a delay of its own. A
/// delay passes: some later sample comes in time, also after a stall that is made up for, or behind the
/// chunk that was sent late. What is missing stays: no later sample comes earlier than by that.
fn breaks(times: &[f64], interval_s: f64) -> Vec<(usize, f64)> {
    let n = times.len();
    let late = lateness(times, interval_s);
    // The least of what comes later, and what delays usually are.
    let mut least_later = late.clone();
    for i in (1..n).rev() {
        least_later[i - 1] = least_later[i - 1].min(least_later[i]);
    }
    let usual_s = usual_delay(&late);
    let limit_s = (MISSING_INTERVALS * interval_s).max(usual_s);
    let mut found = Vec::new();
    let mut least = f64::INFINITY;
    for i in 0..n.saturating_sub(1) {
        least = least.min(late[i]);
        let step_s = times[i + 1] - times[i];
        let gap_s = least_later[i + 1] - least;
        let is_gap = step_s - interval_s > MISSING_INTERVALS * interval_s && gap_s > limit_s;
        // A clock that was set back is no delay either: nothing before it is as early as what follows.
        let back_s = least_later[i + 1] - late[i];
        let is_back = step_s < -BREAK_INTERVALS * interval_s
            && n - i > LASTS
            && back_s < -BREAK_INTERVALS * interval_s
            && late[i + 1..(i + 1 + LASTS).min(n)].iter().all(|late| *late < least);
        // Of the last samples of all nobody knows whether one in time would have followed.
        let is_told = n - i > AT_THE_END || gap_s > FAR_DELAYS * usual_s;
        if is_gap && is_told {
            found.push((i, gap_s));
            least = f64::INFINITY;
        } else if is_back {
            found.push((i, late[i + 1] - least));
            least = f64::INFINITY;
        }
    }
    found
}

/// How late each sample comes against its place at the rate, s, less what the true rate differs by: the
/// middle of how much later the samples of one stretch come than those of the stretch before.
fn lateness(times: &[f64], interval_s: f64) -> Vec<f64> {
    let late = |i: usize| times[i] - i as f64 * interval_s;
    let least = |from: usize| {
        let to = (from + LASTS).min(times.len());
        (from..to).map(late).fold(f64::INFINITY, f64::min)
    };
    let stretches: Vec<f64> = (0..times.len()).step_by(LASTS).map(least).collect();
    let drifts = stretches.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let drift = median(drifts) / LASTS as f64;
    // A stretch at which samples are missing comes later by whole intervals, a true rate by parts of one.
    let drift = if drift.abs() < RATE_OFF * interval_s { drift } else { 0.0 };
    (0..times.len()).map(|i| late(i) - drift * i as f64).collect()
}

/// What a sample of a hundred or so comes late by against those around it, s.
fn usual_delay(late: &[f64]) -> f64 {
    let least = |chunk: &[f64]| chunk.iter().copied().fold(f64::INFINITY, f64::min);
    let mut delays: Vec<f64> = late
        .chunks(LASTS)
        .flat_map(|chunk| {
            let least = least(chunk);
            chunk.iter().map(move |late| late - least)
        })
        .collect();
    let place = (USUAL * delays.len() as f64) as usize;
    if delays.is_empty() { 0.0 } else { *delays.select_nth_unstable_by(place, f64::total_cmp).1 }
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

    #[test]
    fn single_samples_that_are_missing_are_gaps() {
        let lost = |i: &u32| (1000..1160).contains(i) && i % 2 == 1;
        let stamp = |i: u32| 5.0 + 0.01 * f64::from(i) + 1e-4 * f64::from(i % 3);
        let mut times: Vec<f64> = (0..2500).filter(|i| !lost(i)).map(stamp).collect();
        let expect = times.clone();
        let doubts = remove_jitter(&mut times, 100.0);
        assert!(doubts[0].contains("and 79 more gaps: 0.80 s in all"), "{doubts:?}");
        let off = times.iter().zip(&expect).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 2e-3, "{off}");
    }

    /// Chunks of ten samples, each sent late by up to 15 ms; and a stall of 1.5 s that is made up for.
    #[test]
    fn samples_that_only_come_late_are_not_missing() {
        let late = |chunk: u32| 1e-3 * f64::from(chunk.wrapping_mul(2_654_435_761) >> 28);
        let mut chunks: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i) + late(i / 10)).collect();
        assert_eq!(remove_jitter(&mut chunks, 100.0), [""; 0]);
        let mut stalled: Vec<f64> = (0..2000)
            .map(|i| 0.01 * f64::from(i))
            .map(|t| if (8.0..9.5).contains(&t) { 9.5 + 1e-3 * (t - 8.0) } else { t })
            .collect();
        assert_eq!(remove_jitter(&mut stalled, 100.0), [""; 0]);
    }

    #[test]
    fn offsets_that_step_a_little_lie_alone_or_are_no_numbers_are_told() {
        let at = |i: u32| 5.0 * f64::from(i);
        let scatter = |i: u32| 1e-3 * f64::from(i * 7 % 5);
        let steady: Vec<Offset> = (0..20).map(|i| (at(i), 3.0 + scatter(i))).collect();
        assert!(without_outliers(&steady).1.is_empty());
        let mut found = steady.clone();
        (found[4].1, found[5].1, found[12].1) = (3.44, 3.4, f64::NAN);
        let (kept, doubts) = without_outliers(&found);
        assert_eq!((kept.len(), doubts.len()), (17, 3), "{doubts:?}");
        assert!(doubts[0].contains("1 of 20 clock offsets are no numbers"), "{doubts:?}");
        let stepped: Vec<Offset> =
            steady.iter().map(|(t, o)| (*t, if *t < 50.0 { *o } else { o + 0.2 })).collect();
        let mut times = [10.0, 90.0];
        let told = synchronise(&mut times, &without_outliers(&stepped).0).doubts;
        assert!(told[0].contains("a clock was set anew by 0.197 s"), "{told:?}");
        let told = synchronise(&mut times, &[(0.0, 3.0), (10.0, 9.0)]).doubts;
        assert!(told[0].contains("run apart by 60.00 %"), "{told:?}");
    }
}
