//! Movement and force in several axes: how long, how far, how straight, how hard, and across the push
//! how much.

use crate::MetricsError;
use crate::signals::Signals;
use zwidth_numerics::activity::{Activity, activity};
use zwidth_numerics::low_pass::EvenTimes;
use zwidth_numerics::series::{central_differences, trapezoid};
use zwidth_store::Signal;
use zwidth_study::Axes;

const POSITIONS: [Signal; 3] = [Signal::X, Signal::Y, Signal::Z];
const FORCES: [Signal; 3] = [Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// A device has at least so many axes: with one, everything is along it.
const LEAST_AXES: usize = 2;

/// Movement and force in the axes that were recorded: three, or two of a planar device; null for one.
///
/// Positions go through the low-pass of `[axes]` ([`EvenTimes`]: straight lines to even times, then
/// Butterworth's filter of fourth order without lag, each stretch without a gap by itself). The
/// **movement in space** lasts from the first even time at which the speed, from central differences
/// of the filtered positions, exceeds `axes.onset_m_s` to the first at which it is below
/// `axes.offset_m_s` after it last exceeded that, or to the last if it is still moving there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Space {
    /// Completion time: how long the movement in space lasts, pauses included, s. Null if there is none.
    pub completion_s: Option<f64>,
    /// Path length: Σ |pᵢ₊₁ − pᵢ| of the filtered positions over that movement, m; across a gap the
    /// straight line.
    pub path_m: Option<f64>,
    /// |p_end − p_begin| of that movement, m.
    pub distance_m: Option<f64>,
    /// Path over distance: 1 of a straight line. Null at a distance of 0.
    pub path_over_distance: Option<f64>,
    /// How much of the movement is in gaps, across which the path is not known, s.
    pub path_gap_s: Option<f64>,
    /// Largest |F| of the recording, N, not filtered.
    pub force_largest_n: Option<f64>,
    /// ∫|F| dt / Δt over the recording, N; the value itself of a single sample. Of noise of σ in each
    /// of three axes alone it is σ √(8/π) = 1.596 σ.
    pub force_mean_n: Option<f64>,
    /// The same over what is before and after the movement in space, N: what |F| is when nothing moves.
    /// Null where the recording has nothing of that.
    pub force_rest_n: Option<f64>,
    /// ∫|F − (F·push) push| dt / ∫|F| dt over the recording: 0 where all force is along the push, 1
    /// where it is all across. Null without force.
    pub force_across_share: Option<f64>,
    /// ∫F·dp over the movement in space, J: work of the user on the device, by the trapezoidal rule
    /// over the recorded samples, which are not filtered: noise of force and position adds nothing on
    /// average. Null unless both are recorded in the same axes.
    pub work_j: Option<f64>,
}

/// The metrics in space of a study with axes.
pub(crate) fn space(signals: &Signals, axes: &Axes) -> Result<Space, MetricsError> {
    let t = signals.t()?;
    let moved = Moved::of(signals, &t, axes)?;
    let span_s = moved.as_ref().map(|moved| [moved.from_s, moved.to_s]);
    let all = Space {
        completion_s: span_s.map(|[from_s, to_s]| to_s - from_s),
        path_m: moved.as_ref().map(|moved| moved.path_m),
        distance_m: moved.as_ref().map(|moved| moved.distance_m),
        path_over_distance: moved.as_ref().and_then(Moved::path_over_distance),
        path_gap_s: moved.as_ref().map(|moved| moved.gap_s),
        work_j: span_s.and_then(|span_s| work_j(signals, &t, span_s)),
        ..forces(signals, &t, axes.push, span_s)?
    };
    Ok(all.finite())
}

impl Space {
    /// Without numbers that are beyond what a number can be: of coordinates near the largest of them
    /// nothing is known.
    fn finite(self) -> Self {
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Self {
            completion_s: finite(self.completion_s),
            path_m: finite(self.path_m),
            distance_m: finite(self.distance_m),
            path_over_distance: finite(self.path_over_distance),
            path_gap_s: finite(self.path_gap_s),
            force_largest_n: finite(self.force_largest_n),
            force_mean_n: finite(self.force_mean_n),
            force_rest_n: finite(self.force_rest_n),
            force_across_share: finite(self.force_across_share),
            work_j: finite(self.work_j),
        }
    }
}

/// The movement in space.
struct Moved {
    from_s: f64,
    to_s: f64,
    path_m: f64,
    distance_m: f64,
    gap_s: f64,
}

impl Moved {
    /// `None` without a movement, or if fewer than two axes of the position were recorded.
    fn of(signals: &Signals, t: &[f64], axes: &Axes) -> Result<Option<Self>, MetricsError> {
        if POSITIONS.iter().filter(|signal| signals.has(**signal)).count() < LEAST_AXES {
            return Ok(None);
        }
        let Some(even) = EvenTimes::of(t, axes.low_pass_hz) else { return Ok(None) };
        let times = even.times();
        // One recorded column at a time: long recordings lend them.
        let mut filtered: Vec<Vec<f64>> = Vec::new();
        for signal in POSITIONS {
            filtered.extend(signals.column(signal).map(|x| even.filtered(t, &x, axes.low_pass_hz)));
        }
        let mut speed = vec![0.0; times.len()];
        for x in &filtered {
            for (speed, v) in speed.iter_mut().zip(central_differences(&times, x)?) {
                *speed = libm::hypot(*speed, v);
            }
        }
        let Some(Activity { onset, end }) = activity(&speed, axes.onset_m_s, axes.offset_m_s)
        else {
            return Ok(None);
        };
        let end = end.unwrap_or(times.len() - 1);
        let between = |from: usize, to: usize| {
            filtered.iter().fold(0.0, |length, x| libm::hypot(length, x[to] - x[from]))
        };
        let [from_s, to_s] = [times[onset], times[end]];
        Ok(Some(Self {
            from_s,
            to_s,
            path_m: (onset..end).map(|i| between(i, i + 1)).sum(),
            distance_m: between(onset, end),
            gap_s: even.gaps(from_s, to_s),
        }))
    }

    fn path_over_distance(&self) -> Option<f64> {
        (self.distance_m > 0.0).then(|| self.path_m / self.distance_m)
    }
}

/// |F|, and how much of it is across the push; all null if fewer than two axes of the force were
/// recorded. `moved_s` is from when to when it moves.
fn forces(
    signals: &Signals,
    t: &[f64],
    push: [f64; 3],
    moved_s: Option<[f64; 2]>,
) -> Result<Space, MetricsError> {
    if FORCES.iter().filter(|signal| signals.has(**signal)).count() < LEAST_AXES {
        return Ok(Space::default());
    }
    let mut magnitude = vec![0.0; t.len()];
    let mut along = vec![0.0; t.len()];
    // Of a push along an axis that was not recorded nothing is known.
    let mut is_push_recorded = true;
    for (signal, part) in FORCES.into_iter().zip(push) {
        let Some(force) = signals.column(signal) else {
            is_push_recorded &= part.abs() <= Axes::UNIT;
            continue;
        };
        for (i, f) in force.iter().enumerate() {
            magnitude[i] = libm::hypot(magnitude[i], *f);
            along[i] += part * f;
        }
    }
    let mut across = vec![0.0; t.len()];
    for (signal, part) in FORCES.into_iter().zip(push) {
        let force = signals.column(signal);
        for (i, f) in force.iter().flat_map(|force| force.iter()).enumerate() {
            across[i] = libm::hypot(across[i], f - part * along[i]);
        }
    }
    let mean = |f: &[f64]| -> Result<f64, MetricsError> {
        let span_s = t[t.len() - 1] - t[0];
        // A single sample has no duration to divide by.
        Ok(if span_s > 0.0 { trapezoid(t, f)? / span_s } else { f[0] })
    };
    let mean_n = mean(&magnitude)?;
    let share = mean(&across)? / mean_n;
    Ok(Space {
        force_largest_n: magnitude.iter().copied().max_by(f64::total_cmp),
        force_mean_n: Some(mean_n),
        force_rest_n: moved_s.and_then(|moved_s| mean_outside(t, &magnitude, moved_s)),
        force_across_share: Some(share).filter(|_| is_push_recorded && mean_n > 0.0),
        ..Space::default()
    })
}

/// The mean over time of `f` before and after a stretch of the times `t`; `None` where there is nothing.
fn mean_outside(t: &[f64], f: &[f64], [from_s, to_s]: [f64; 2]) -> Option<f64> {
    let mut sum = 0.0;
    let mut span_s = 0.0;
    for (t, f) in t.windows(2).zip(f.windows(2)) {
        if t[1] <= from_s || t[0] >= to_s {
            sum += (t[1] - t[0]) * (f[0] + f[1]) / 2.0;
            span_s += t[1] - t[0];
        }
    }
    (span_s > 0.0).then(|| sum / span_s)
}

/// ∫F·dp over the samples of a stretch of the times `t`; `None` unless force and position are recorded in
/// the same axes.
fn work_j(signals: &Signals, t: &[f64], [from_s, to_s]: [f64; 2]) -> Option<f64> {
    let first = t.partition_point(|t| *t < from_s);
    let end = t.partition_point(|t| *t <= to_s);
    let mut work_j = 0.0;
    for (position, force) in POSITIONS.into_iter().zip(FORCES) {
        match (signals.column(position), signals.column(force)) {
            (Some(p), Some(f)) => {
                let steps = p[first..end].windows(2).zip(f[first..end].windows(2));
                work_j += steps.fold(0.0, |sum, (p, f)| sum + (p[1] - p[0]) * (f[0] + f[1]) / 2.0);
            }
            (None, None) => {}
            _ => return None,
        }
    }
    let is_in_space = FORCES.iter().filter(|force| signals.has(**force)).count() >= LEAST_AXES;
    is_in_space.then_some(work_j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{check, in_spring, meta};
    use crate::{Parameters, trial_metrics};
    use core::f64::consts::{PI, TAU};
    use zwidth_store::{Samples, Trial, TrialFile};

    const RATE_HZ: f64 = 200.0;

    fn axes() -> Axes {
        Axes {
            frame: "x right, y up, z to the person".to_owned(),
            push: [0.0, 0.0, -1.0],
            low_pass_hz: 10.0,
            onset_m_s: 0.01,
            offset_m_s: 0.005,
        }
    }

    fn metrics_by(trial: &Trial, axes: Axes) -> Space {
        let parameters = Parameters { axes: Some(axes), ..in_spring(4.0, 0.0) };
        trial_metrics(trial, &parameters).unwrap().space
    }

    fn metrics(trial: &Trial) -> Space {
        metrics_by(trial, axes())
    }

    /// A trial at these times, with this position and this force.
    fn at(
        times: &[f64],
        position: impl Fn(f64) -> [f64; 3],
        force: impl Fn(f64) -> [f64; 3],
    ) -> Trial {
        let mut samples = Samples::default();
        samples.set(Signal::Time, times.to_vec());
        for (k, signal) in POSITIONS.into_iter().enumerate() {
            samples.set(signal, times.iter().map(|t| position(*t)[k]).collect());
        }
        for (k, signal) in FORCES.into_iter().enumerate() {
            samples.set(signal, times.iter().map(|t| force(*t)[k]).collect());
        }
        Trial { meta: meta(), file: TrialFile::new(), samples }
    }

    fn even(span_s: f64) -> Vec<f64> {
        (0..=(span_s * RATE_HZ) as u32).map(|i| f64::from(i) / RATE_HZ).collect()
    }

    fn none(_: f64) -> [f64; 3] {
        [0.0; 3]
    }

    /// The way of minimum jerk, from 0 to 1 in `span_s`, at rest for a second before and after.
    fn way(t: f64, span_s: f64) -> f64 {
        let s = ((t - 1.0) / span_s).clamp(0.0, 1.0);
        s * s * s * (10.0 + s * (6.0 * s - 15.0))
    }

    #[test]
    fn a_straight_reach_is_as_long_as_its_distance() {
        let reach = |t: f64| [0.1 + 0.2 * way(t, 2.0), 0.1 * way(t, 2.0), -0.2 * way(t, 2.0)];
        let found = metrics(&at(&even(4.0), reach, none));
        // What is left of the way at 10 mm/s and at 5 mm/s is not of the movement.
        check(found.path_m, 0.3, 1.5e-3);
        check(found.path_over_distance, 1.0, 1e-9);
        // 9 s² (1 − s)² = 0.0667 and 0.0333 of the mean speed, 0.15 m/s, at both ends of 2 s.
        assert!((1.7..1.9).contains(&found.completion_s.unwrap()), "{found:?}");
        assert_eq!((found.path_gap_s, found.work_j), (Some(0.0), Some(0.0)));
    }

    /// Its path is √((2π r)² + h²) a turn; the low-pass leaves G(f) of the radius.
    #[test]
    fn a_helix_has_the_path_of_its_formula_and_a_fast_one_what_the_low_pass_leaves() {
        for (turns_per_s, tolerance) in [(0.5, 1e-4), (1.0, 1e-3), (5.0, 3e-2)] {
            let helix = |t: f64| {
                let phase = TAU * turns_per_s * t;
                [0.05 * libm::cos(phase), 0.05 * libm::sin(phase), 0.02 * turns_per_s * t]
            };
            let found = metrics(&at(&even(8.0), helix, none));
            let tangents = |hz: f64| libm::tan(PI * hz / RATE_HZ);
            let ratio = tangents(turns_per_s) * 0.802_243_262_923_150_2 / tangents(10.0);
            let gain = 1.0 / (1.0 + ratio * ratio * ratio * ratio);
            let turns = 8.0 * turns_per_s;
            let path_m = turns * libm::hypot(TAU * 0.05 * gain, 0.02);
            // Straight lines between samples, and both ends.
            assert!((found.path_m.unwrap() / path_m - 1.0).abs() < tolerance, "{found:?} {path_m}");
            check(found.distance_m, 0.02 * turns, 2e-3);
            check(found.completion_s, 8.0, 1e-9);
        }
    }

    #[test]
    fn a_closed_curve_ends_where_it_began_and_a_distance_of_0_has_no_ratio() {
        let circle = |t: f64| [libm::cos(PI * t), libm::sin(PI * t), 0.0].map(|x| 0.1 * x);
        let found = metrics(&at(&even(2.0), circle, none));
        check(found.path_m, 0.1 * TAU, 1e-3);
        assert!(found.distance_m.unwrap() < 1e-3, "{found:?}");
        let still = Moved { from_s: 0.0, to_s: 1.0, path_m: 1.0, distance_m: 0.0, gap_s: 0.0 };
        assert_eq!(still.path_over_distance(), None);
    }

    /// 0.1 mm of noise in each axis at 1 kHz: without a low-pass the path of a reach of 0.3 m is 0.39 m.
    #[test]
    fn noise_makes_the_path_longer_without_the_low_pass_and_hardly_with_it() {
        let times: Vec<f64> = (0..4000).map(|i| f64::from(i) / 1000.0).collect();
        let noise = |t: f64, axis: u32| {
            // Box-Muller on van der Corput's numbers of two bases would be even: a hash is not.
            let hash = |salt: u64| {
                let mut x = (t * 1000.0).round() as u64 * 3 + u64::from(axis) + salt * 1_000_003;
                for _ in 0..3 {
                    x = (x ^ (x >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(salt);
                }
                ((x >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
            };
            1e-4 * (-2.0 * libm::log(hash(1))).sqrt() * libm::cos(TAU * hash(2))
        };
        let reach = |t: f64| {
            let way = 0.3 * way(t, 2.0);
            [way + noise(t, 0), noise(t, 1), noise(t, 2)]
        };
        let trial = at(&times, reach, none);
        let found = metrics(&trial);
        check(found.path_m, 0.3, 3e-3);
        let open = metrics_by(&trial, Axes { low_pass_hz: 249.0, ..axes() });
        assert!(open.path_m.unwrap() > 0.35, "{open:?}");
    }

    #[test]
    fn samples_that_are_missing_or_uneven_change_little_and_a_gap_is_straight_and_told() {
        let circle = |t: f64| [libm::cos(PI * t), libm::sin(PI * t), 0.0].map(|x| 0.1 * x);
        let whole = metrics(&at(&even(4.0), circle, none));
        let uneven: Vec<f64> =
            even(4.0).into_iter().map(|t| t + 0.002 * libm::sin(977.0 * t)).collect();
        let found = metrics(&at(&uneven, circle, none));
        assert!((found.path_m.unwrap() / whole.path_m.unwrap() - 1.0).abs() < 2e-3, "{found:?}");
        let with_gap: Vec<f64> =
            even(4.0).into_iter().filter(|t| !(1.0..2.0).contains(t)).collect();
        let found = metrics(&at(&with_gap, circle, none));
        check(found.path_gap_s, 1.005, 1e-6);
        // Half of the circle is passed over on a straight line.
        check(found.path_m, whole.path_m.unwrap() - 0.1 * PI + 0.2, 3e-3);
    }

    #[test]
    fn the_work_on_a_spring_is_half_its_stiffness_times_the_difference_of_squares() {
        let place = |t: f64| [0.01 + 0.04 * way(t, 1.0), 0.0, 0.02 * way(t, 1.0)];
        let spring = |t: f64| place(t).map(|x| 300.0 * x);
        let trial = at(&even(3.0), place, spring);
        let found = metrics(&trial);
        let squared = |t: f64| place(t).iter().map(|x| x * x).sum::<f64>();
        let (t, mut moved) = (even(3.0), (0.0, 0.0));
        let completion_s = found.completion_s.unwrap();
        for from in &t {
            let to = from + completion_s;
            let path = squared(to) - squared(*from);
            moved = if path > moved.0 { (path, *from) } else { moved };
        }
        // The movement leaves out the slowest parts of the way.
        check(found.work_j, 150.0 * moved.0, 1e-3);
        check(found.work_j, 150.0 * (0.05 * 0.05 + 0.02 * 0.02 - 0.01 * 0.01), 8e-3);
    }

    #[test]
    fn the_force_across_the_push_is_its_share_by_the_sine_of_the_angle() {
        let angle = PI / 6.0;
        let force = |t: f64| {
            let f = 2.0 + libm::sin(TAU * t);
            [f * libm::sin(angle), 0.0, -f * libm::cos(angle)]
        };
        let found = metrics(&at(&even(1.0), none, force));
        check(found.force_across_share, 0.5, 1e-9);
        check(found.force_mean_n, 2.0, 1e-9);
        check(found.force_largest_n, 3.0, 1e-3);
        assert_eq!((found.completion_s, found.path_m, found.force_rest_n), (None, None, None));
        let along = metrics(&at(&even(1.0), none, |_| [0.0, 0.0, 3.0]));
        assert_eq!(along.force_across_share, Some(0.0));
        assert_eq!(metrics(&at(&even(1.0), none, none)).force_across_share, None);
    }

    #[test]
    fn the_force_at_rest_is_that_before_and_after_the_movement() {
        let reach = |t: f64| [0.3 * way(t, 2.0), 0.0, 0.0];
        let force = |t: f64| [if (1.0..3.0).contains(&t) { 5.0 } else { 0.25 }, 0.0, 0.0];
        let found = metrics(&at(&even(4.0), reach, force));
        assert!((0.25..0.9).contains(&found.force_rest_n.unwrap()), "{found:?}");
        assert!(found.force_mean_n.unwrap() > 2.0, "{found:?}");
    }

    #[test]
    fn a_planar_device_has_all_of_this_in_its_two_axes_and_one_axis_has_nothing() {
        let circle = |t: f64| [libm::cos(PI * t), libm::sin(PI * t), 0.0].map(|x| 0.1 * x);
        let three = at(&even(2.0), circle, circle);
        let two = |k: usize| {
            let kept = [POSITIONS, FORCES].map(|of| of.into_iter().take(k)).into_iter().flatten();
            crate::testing::only(&three, kept.chain([Signal::Time]))
        };
        let planar = metrics_by(&two(2), Axes { push: [1.0, 0.0, 0.0], ..axes() });
        let whole = metrics_by(&three, Axes { push: [1.0, 0.0, 0.0], ..axes() });
        assert_eq!(planar, whole);
        assert_eq!(metrics(&two(2)).force_across_share, None, "the push is along z");
        assert_eq!(metrics(&two(1)), Space::default());
    }

    #[test]
    fn numbers_beyond_all_measure_give_null_and_one_sample_its_force_alone() {
        let far = |t: f64| [1e308 * libm::cos(PI * t), 1e308 * libm::sin(PI * t), -1e308];
        let found = metrics(&at(&even(2.0), far, far));
        assert_eq!((found.path_m, found.work_j), (None, None));
        let one = metrics(&at(&[0.0], |_| [1.0; 3], |_| [3.0, 4.0, 0.0]));
        assert_eq!((one.force_mean_n, one.completion_s), (Some(5.0), None));
    }
}
