//! The times of a stream's samples on the recorder's clock: as `pyxdf` 1.17 gives them with its
//! usual settings, without wrong clock offsets.
//!
//! Source: `pyxdf` 1.17, `_clock_sync`, `_detect_clock_resets` and `_robust_fit`; the fit is that of
//! S. Boyd et al., "Distributed Optimization and Statistical Learning via the Alternating Direction
//! Method of Multipliers" (2011), section 6.1.1.

use super::super::convert::median;
use std::ops::Range;

/// When the clocks were compared, on the stream's clock, s, and what then lacked to the recorder's,
/// s.
pub(crate) type Offset = (f64, f64);

/// A difference of offsets beyond which one counts as an outlier, s.
const WINSOR_S: f64 = 1e-4;
/// Steps of the robust fit.
const STEPS: usize = 1000;
/// A clock was set anew where the time between comparisons is off its median by so many median
/// deviations and so many seconds, and the offset too.
const TIME_RESET: (f64, f64) = (5.0, 5.0);
const OFFSET_RESET: (f64, f64) = (10.0, 1.0);
/// Offsets jump where one differs from the one before by so many times what they usually do …
const JUMP_SCATTERS: f64 = 10.0;
/// … but not by less than this, s, because comparisons over a bad network scatter by some 0.01 s …
const LEAST_JUMP_S: f64 = 0.06;
/// … and by this, s, in any case: networks delay less.
const LARGEST_SCATTER_S: f64 = 0.5;
/// Clocks that run do not drift faster than this, s per s.
const MOST_DRIFT: f64 = 0.002;
/// How well a step of the samples' times must match a jump of the offsets, as a part of it …
const STEP_MATCH: f64 = 0.1;
/// … and how far outside the two comparisons it may lie, s: samples are sent in chunks.
const STEP_NEAR_S: f64 = 5.0;
/// Samples whose steps are off their interval by less than this part of a jump know nothing of it.
const STEADY: f64 = 0.5;
/// Jumps that are looked for in the samples' times; each costs a walk through them.
const MOST_JUMPS: usize = 100;

/// The result of putting times on the recorder's clock.
pub(crate) struct Synchronised {
    /// Whether each stretch of offsets had a line; otherwise its times stay as they are.
    pub(crate) all_used: bool,
    /// Offsets that are left out, and clocks that were set anew.
    pub(crate) doubts: Vec<String>,
}

/// Adds to each time what the offsets say: a line through those between two resets of the clock.
///
/// Offsets that jump while the samples' times go on steadily are wrong, and the fewer ones are left
/// out; pyxdf lets the line run through both, which bends the times. `interval_s` is that of the
/// samples, or 0.
pub(crate) fn synchronise(times: &mut [f64], offsets: &[Offset], interval_s: f64) -> Synchronised {
    // With their numbers in the file, by which they are told.
    let (numbers, sound): (Vec<usize>, Vec<Offset>) = offsets
        .iter()
        .enumerate()
        .filter(|(_, offset)| is_finite(offset))
        .map(|(i, o)| (i + 1, *o))
        .unzip();
    let mut doubts = Vec::new();
    if let Some(bad) = offsets.iter().position(|offset| !is_finite(offset)) {
        doubts.push(format!(
            "clock offset {} of {} is not a number, and is left out{}",
            bad + 1,
            offsets.len(),
            as_are(offsets.len() - sound.len() - 1)
        ));
    }
    let jumps = Jumps::between(&sound);
    let resets = resets(times, &sound, &jumps, interval_s);
    let stretches = parts(sound.len(), resets.iter().map(|reset| reset.behind));
    let ends = resets.iter().map(|reset| reset.sample).chain([times.len()]);
    let mut all_used = true;
    let mut from = 0;
    let mut left_out = Vec::new();
    for (stretch, end) in stretches.into_iter().zip(ends) {
        let kept = jumps.without_those_off(&sound, stretch, &mut left_out);
        let line = line(&kept);
        all_used &= line.is_some();
        let (start, slope) = line.unwrap_or((0.0, 0.0));
        times[from..end].iter_mut().for_each(|t| *t += start + slope * *t);
        from = end;
    }
    if let [(first, by_s), others @ ..] = &left_out[..] {
        let all = offsets.len();
        let which = match first.len() {
            1 => format!(
                "clock offset {} of {all} lies {by_s:.3} s off those beside it, and is",
                numbers[first.start]
            ),
            _ => format!(
                "clock offsets {} to {} of {all} lie {by_s:.3} s off those beside them, and are",
                numbers[first.start],
                numbers[first.end - 1]
            ),
        };
        let more = others.iter().map(|(run, _)| run.len()).sum();
        doubts.push(format!(
            "{which} left out{}: was a clock set while this was recorded?",
            as_are(more)
        ));
    }
    doubts.extend(resets.iter().map(|Reset { behind, .. }| {
        let step_s = sound[behind + 1].1 - sound[*behind].1;
        format!(
            "a clock was set anew by {step_s:.3} s while this was recorded: times before and behind that are lined up \
             each by themselves"
        )
    }));
    Synchronised { all_used, doubts }
}

fn is_finite((t, offset): &Offset) -> bool {
    t.is_finite() && offset.is_finite()
}

/// The end of a sentence that says the same of `more` others.
fn as_are(more: usize) -> String {
    match more {
        0 => String::new(),
        1 => ", as is 1 more".to_owned(),
        _ => format!(", as are {more} more"),
    }
}

/// By how much each offset differs from the one before, without what clocks drift.
struct Jumps {
    /// s per s.
    drift: f64,
    by_s: Vec<f64>,
    /// From which on a difference is a jump, s.
    limit_s: f64,
}

impl Jumps {
    fn between(offsets: &[Offset]) -> Self {
        let pairs = offsets.windows(2);
        let steps: Vec<Offset> =
            pairs.map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1)).collect();
        // Two comparisons at one time say nothing of a drift; a wrong offset looks like a huge one.
        let drifts = steps.iter().filter(|(s, _)| *s > 0.0);
        let drift = median(drifts.map(|(s, by)| (by / s).clamp(-MOST_DRIFT, MOST_DRIFT)).collect());
        let by_s: Vec<f64> = steps.iter().map(|(s, by)| by - drift * s).collect();
        let mut sizes: Vec<f64> = by_s.iter().map(|by| by.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // A single wrong offset makes two jumps, which say nothing of how the others scatter.
        sizes.truncate(sizes.len().saturating_sub(2));
        let usual = sizes.get(sizes.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
        let limit_s = (JUMP_SCATTERS * usual).clamp(LEAST_JUMP_S, LARGEST_SCATTER_S);
        Self { drift, by_s, limit_s }
    }

    fn is_jump(&self, behind: usize) -> bool {
        self.by_s[behind].abs() > self.limit_s
    }

    /// The offsets of a stretch that lie at one level with most of those between two jumps. The others
    /// are added to `left_out`, each run with how far it lies off.
    fn without_those_off(
        &self,
        offsets: &[Offset],
        stretch: Range<usize>,
        left_out: &mut Vec<(Range<usize>, f64)>,
    ) -> Vec<Offset> {
        let Range { start, end } = stretch;
        let jumps = (start..end.saturating_sub(1)).filter(|i| self.is_jump(*i));
        let runs = parts(end - start, jumps.map(|i| i - start)).into_iter().map(|run| {
            let run = run.start + start..run.end + start;
            let first = offsets[start].0;
            let levels = offsets[run.clone()].iter().map(|(t, o)| o - self.drift * (t - first));
            (run, median(levels.collect()))
        });
        let runs: Vec<(Range<usize>, f64)> = runs.collect();
        // The first of the longest ones.
        let longest = runs.iter().rev().max_by_key(|(run, _)| run.len());
        let usual = longest.map_or(0.0, |(_, level)| *level);
        let mut kept = Vec::new();
        for (run, level) in runs {
            let off_s = level - usual;
            match off_s.abs() > self.limit_s {
                true => left_out.push((run, off_s)),
                false => kept.extend_from_slice(&offsets[run]),
            }
        }
        kept
    }
}

/// A clock that was set anew: behind which offset, and the first sample on the new time.
struct Reset {
    behind: usize,
    sample: usize,
}

/// Where a clock was set anew while this was recorded.
fn resets(times: &[f64], offsets: &[Offset], jumps: &Jumps, interval_s: f64) -> Vec<Reset> {
    let pairs = offsets.windows(2);
    let (between_s, steps_s): (Vec<f64>, Vec<f64>) =
        pairs.map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1)).unzip();
    let late = glitches(&between_s, TIME_RESET);
    let off = glitches(&steps_s, OFFSET_RESET);
    let mut resets = Vec::new();
    let mut from = 0;
    let mut searched = 0;
    for behind in 0..between_s.len() {
        let last = offsets[behind];
        let next = offsets[behind + 1];
        let step_s = next.1 - last.1;
        let mut at_step = None;
        let mut is_steady = false;
        if jumps.is_jump(behind) && searched < MOST_JUMPS {
            searched += 1;
            let most_s = STEADY * step_s.abs();
            is_steady = interval_s > 0.0
                && times[from..]
                    .windows(2)
                    .all(|pair| (pair[1] - pair[0] - interval_s).abs() < most_s);
            // The stream's own clock steps as far the other way.
            at_step = times[from..].windows(2).position(|pair| {
                (pair[1] - pair[0] - interval_s + step_s).abs() < STEP_MATCH * step_s.abs()
                    && pair[0] > last.0 - STEP_NEAR_S
                    && pair[1] < next.0 + STEP_NEAR_S
            });
        }
        let is_seen_by_pyxdf = between_s[behind] < 0.0 || (late[behind] && off[behind]);
        if at_step.is_none() && (!is_seen_by_pyxdf || is_steady) {
            continue;
        }
        // Else up to the first time that is nearer to the next comparison than to the last one.
        let here = at_step.map(|before| before + 1).or_else(|| {
            times[from..].iter().position(|t| (t - last.0).abs() >= (t - next.0).abs())
        });
        from = here.map_or(times.len(), |here| from + here);
        resets.push(Reset { behind, sample: from });
    }
    resets
}

/// `0..length`, parted behind each of `ends`.
pub(super) fn parts(length: usize, ends: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
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
///
/// It minimises the sum of Huber's loss of offset − start − slope · t in units of [`WINSOR_S`], by
/// the alternating directions method of multipliers with ρ = 1.
fn line(offsets: &[Offset]) -> Option<Offset> {
    if let [(_, offset)] = offsets {
        return Some((*offset, 0.0));
    }
    let scaled: Vec<Offset> =
        offsets.iter().map(|(t, offset)| (t / WINSOR_S, offset / WINSOR_S)).collect();
    // Times may count from the start of a computer: squares of such would lose the digits that matter.
    let first = scaled.iter().map(|(t, _)| *t).fold(f64::INFINITY, f64::min);
    let rows: Vec<Offset> = scaled.iter().map(|(t, y)| (t - first, *y)).collect();
    #[allow(clippy::cast_precision_loss)] // At most 2¹⁶ of them.
    let n = rows.len() as f64;
    let (sum_t, sum_tt) = rows.iter().fold((0.0, 0.0), |(a, b), (t, _)| (a + t, b + t * t));
    // Of no offsets it is no number.
    let pivot = sum_tt - sum_t * sum_t / n;
    if !(pivot > 0.0 && pivot.is_finite()) {
        return None;
    }
    // z − u of each row, in which alone the rows remember the last step.
    let mut held = vec![(0.0, 0.0); rows.len()];
    let mut intercept = 0.0;
    let mut slope = 0.0;
    for _ in 0..STEPS {
        let mut b0 = 0.0;
        let mut b1 = 0.0;
        for ((t, y), (z, u)) in rows.iter().zip(&held) {
            let right = y + z - u;
            b0 += right;
            b1 += t * right;
        }
        slope = (b1 - sum_t * b0 / n) / pivot;
        intercept = (b0 - slope * sum_t) / n;
        for ((t, y), held) in rows.iter().zip(&mut held) {
            let d = intercept + slope * t - y + held.1;
            // d · max(0, 1 − 2 / |d|), the proximal step of |d| twice.
            let shrunk = if d.abs() > 2.0 { d * (1.0 - 2.0 / d.abs()) } else { 0.0 };
            let z = 0.5 * d + 0.5 * shrunk;
            *held = (z, d - z);
        }
    }
    Some(((intercept - slope * first) * WINSOR_S, slope))
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
        assert!(synchronise(&mut times, &offsets, 0.0).all_used);
        let expect = [1000.0, 1050.0, 1099.0].map(|t| t + 3.0 - 1e-5 * t);
        // Huber's loss lets an outlier pull like one of the threshold.
        assert!(times.iter().zip(expect).all(|(a, b)| (a - b).abs() < 5e-5), "{times:?}");
    }

    #[test]
    fn one_comparison_shifts_and_none_leaves() {
        let mut times = [1.0, 2.0];
        assert!(synchronise(&mut times, &[(0.0, 10.0)], 0.0).all_used);
        near(&times, &[11.0, 12.0]);
        assert!(synchronise(&mut times, &[], 0.0).all_used);
        near(&times, &[11.0, 12.0]);
        assert!(!synchronise(&mut times, &[(5.0, 1.0), (5.0, 1.01)], 0.0).all_used);
        near(&times, &[11.0, 12.0]);
    }

    #[test]
    fn a_clock_that_was_set_anew_has_a_line_before_and_one_behind() {
        let before = (0..10).map(|i| (100.0 + 5.0 * f64::from(i), 2.0));
        let behind = (0..10).map(|i| (5.0 * f64::from(i), 150.0));
        let offsets: Vec<Offset> = before.chain(behind).collect();
        let mut times = [101.0, 144.0, 1.0, 20.0];
        assert!(synchronise(&mut times, &offsets, 0.0).all_used);
        near(&times, &[103.0, 146.0, 151.0, 170.0]);
    }
}
