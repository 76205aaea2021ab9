//! Whether a person could feel the difference between two motions: the error gate of the trade and
//! the ladder.
//!
//! * **Slow part**: force and angle, each as the mean over 100 ms, differ by less than a person can
//!   tell apart: the force by a share of itself and no less than a floor, the angle by a fixed
//!   amount.
//! * **Vibration**: the position of the lever's end by third octaves from 10 to 794 Hz, in windows
//!   of 100 ms and more. A level differs if it exceeds both the smallest level that is felt and the
//!   right level by a share. (The level of a difference signal would not be a vibration: one
//!   microsecond of an event is 0.2 µm.)
//!
//! Nothing is compared within 50 ms of a jump of the right force, because an instant is not felt. A
//! jump is a change of the device's force, within a millisecond, that a person can tell apart, or a
//! jump of an input.

use zwidth_study::Perception;

use super::bands::{Levels, SHORTEST_S};
use super::felt::VibrationThreshold;
use super::path::Path;
use crate::system::System;
use crate::system::transition::EventKind;
use crate::trajectory::Trajectory;

/// Time between the samples of a motion that is compared, s: twice the fastest band.
const STEP_S: f64 = 0.5e-3;
/// This long before and after a jump of the force nothing is compared, s.
const AROUND_A_JUMP_S: f64 = 0.05;
/// A force jumps within so many steps: a millisecond.
const JUMP_STEPS: usize = 2;

/// What a hand feels of a motion: position and force every half millisecond.
#[derive(Debug, Clone, PartialEq)]
pub struct FeltMotion {
    /// θ at the edges of the steps, rad: one more than steps.
    theta_rad: Vec<f64>,
    /// Mean force of the device over each step, N.
    force_n: Vec<f64>,
    /// When an input jumps, s.
    jumps_s: Vec<f64>,
}

impl FeltMotion {
    /// What a hand feels of a run, by the system that was run. Between samples θ is the cubic
    /// through both ends and their velocities, and the force a straight line.
    pub fn of(system: &System, run: &Trajectory) -> Self {
        let path = Path::of(run);
        // An end that is a whole number of steps but for rounding is one.
        let steps = (path.end_s() / STEP_S * (1.0 + 1e-12)) as usize;
        let edges = (0..=steps).map(|i| i as f64 * STEP_S);
        let impulses = impulses(system, run, edges.clone());
        // The one at 0 is the start of every run, not a jump.
        let events = run.events.iter();
        let jumps = events.filter(|event| event.t_s > 0.0 && event.kind == EventKind::Input);
        Self {
            theta_rad: path.along(edges),
            force_n: impulses.windows(2).map(|pair| (pair[1] - pair[0]) / STEP_S).collect(),
            jumps_s: jumps.map(|event| event.t_s).collect(),
        }
    }

    /// ∫ F dt of the device's force on the lever's end, N s.
    pub fn impulse_ns(&self) -> f64 {
        STEP_S * self.force_n.iter().sum::<f64>()
    }

    /// Times between which nothing jumps, as steps from and to.
    fn undisturbed(&self, perception: &Perception) -> Vec<(usize, usize)> {
        let around = (AROUND_A_JUMP_S / STEP_S).round() as usize;
        let steps = self.force_n.len();
        let mut free = vec![true; steps];
        let pairs = self.force_n.windows(JUMP_STEPS + 1).enumerate();
        let force_jumps = pairs.filter_map(|(i, pair)| {
            let before = pair[0];
            let after = pair[JUMP_STEPS];
            let bound_n = perception.force_bound_n(before.abs().min(after.abs()));
            ((after - before).abs() > bound_n).then_some(i + 1)
        });
        let input_jumps = self.jumps_s.iter().map(|t| (t / STEP_S) as usize);
        for at in force_jumps.chain(input_jumps) {
            let to = (at + around).min(steps);
            free[at.saturating_sub(around).min(to)..to].fill(false);
        }
        spans(&free)
    }
}

/// Where a run of `true` begins and ends.
fn spans(free: &[bool]) -> Vec<(usize, usize)> {
    let mut to = 0;
    let runs = free.chunk_by(|a, b| a == b).map(|run| {
        let from = to;
        to += run.len();
        (run[0], (from, to))
    });
    runs.filter_map(|(is_free, span)| is_free.then_some(span)).collect()
}

/// ∫ F dt of the device's force on the lever's end along a run, N s, at increasing times; before
/// the first sample and after the last as there.
fn impulses(system: &System, run: &Trajectory, times_s: impl Iterator<Item = f64>) -> Vec<f64> {
    let t_s = &run.t_s;
    let force_n: Vec<f64> = (0..run.len()).map(|i| run.forces(system, i).device_n()).collect();
    // Up to each sample.
    let mut sum_ns = vec![0.0; run.len()];
    for i in 1..run.len() {
        let step_s = t_s[i] - t_s[i - 1];
        sum_ns[i] = sum_ns[i - 1] + 0.5 * step_s * (force_n[i - 1] + force_n[i]);
    }
    let mut i = 0;
    let at = |t: f64| {
        while i + 2 < t_s.len() && t_s[i + 1] < t {
            i += 1;
        }
        let Some(next_s) = t_s.get(i + 1) else { return 0.0 };
        let step_s = next_s - t_s[i];
        let s = (t - t_s[i]).clamp(0.0, step_s);
        let rate = (force_n[i + 1] - force_n[i]) / step_s;
        sum_ns[i] + s * (force_n[i] + 0.5 * rate * s)
    };
    times_s.map(at).collect()
}

/// A motion that others are compared with, made ready once.
pub struct FeltReference {
    perception: Perception,
    threshold: VibrationThreshold,
    lever_m: f64,
    spans: Vec<(usize, usize)>,
    slow: Slow,
    bands: Vec<RightLevels>,
}

/// The means over 100 ms of force and angle.
struct Slow {
    force_n: Vec<f64>,
    theta_rad: Vec<f64>,
}

impl Slow {
    fn of(motion: &FeltMotion) -> Self {
        let steps = motion.theta_rad.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let steps: Vec<f64> = steps.collect();
        Self { force_n: mean(&motion.force_n), theta_rad: mean(&steps) }
    }
}

/// The mean over 100 ms about each value, over what there is of them at the ends.
fn mean(values: &[f64]) -> Vec<f64> {
    let half = (0.5 * SHORTEST_S / STEP_S).round() as usize;
    // By differences of sums from the beginning: one addition per value, however many a mean is of.
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, x| {
        *sum += x;
        Some(*sum)
    }));
    (0..values.len())
        .map(|i| {
            let from = i.saturating_sub(half);
            let to = (i + half + 1).min(values.len());
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// The right levels of bands whose windows are of one length, by window and band.
struct RightLevels {
    levels: Levels,
    windows: Vec<(usize, Vec<f64>)>,
}

/// How far a motion is from another one for a person. A share of 1 is just felt.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FeltDifference {
    /// Largest difference of the slow force, as a share of the just noticeable one.
    pub force_share: f64,
    /// The difference itself, N.
    pub force_n: f64,
    /// Largest difference of the slow angle, as a share of the just noticeable one.
    pub angle_share: f64,
    /// How far the level of vibration is above the right one, as a share of the allowed excess: 0
    /// if it is not above; none if no window is free of jumps.
    pub vibration_share: Option<f64>,
    /// The centre of that band, Hz.
    pub frequency_hz: f64,
    /// Its amplitude at the lever's end, m.
    pub amplitude_m: f64,
    /// The right value there, m.
    pub right_m: f64,
}

impl FeltDifference {
    /// Whether a person could tell the two motions apart. What could not be compared counts as
    /// felt.
    pub fn is_felt(&self) -> bool {
        let shares = [Some(self.force_share), Some(self.angle_share), self.vibration_share];
        // All must be within, rather than none above: a share that is not a number is felt.
        !shares.iter().all(|share| share.is_some_and(|share| share <= 1.0))
    }
}

impl FeltReference {
    /// Makes a motion ready to compare others with; `lever_m` turns angles into positions.
    pub fn new(motion: &FeltMotion, lever_m: f64, perception: &Perception) -> Self {
        let spans = motion.undisturbed(perception);
        let bands = Levels::all(STEP_S).into_iter();
        Self {
            bands: bands.map(|levels| RightLevels::of(levels, motion, lever_m, &spans)).collect(),
            slow: Slow::of(motion),
            threshold: VibrationThreshold::of(&perception.vibration),
            perception: perception.clone(),
            lever_m,
            spans,
        }
    }

    /// Whether a jump of the right force is near: there nothing is compared.
    pub fn is_disturbed(&self, t_s: f64) -> bool {
        let step = (t_s / STEP_S) as usize;
        !self.spans.iter().any(|(from, to)| (*from..=*to).contains(&step))
    }

    /// How far another motion of the same length is from this one.
    pub fn compare(&self, motion: &FeltMotion) -> FeltDifference {
        let right = &self.slow;
        let slow = Slow::of(motion);
        let mut worst = FeltDifference::default();
        for i in self.spans.iter().flat_map(|(from, to)| *from..*to) {
            // A motion that ended early has nothing to compare from then on.
            let Some((force_n, theta_rad)) = slow.force_n.get(i).zip(slow.theta_rad.get(i)) else {
                continue;
            };
            let apart_n = (force_n - right.force_n[i]).abs();
            let share = apart_n / self.perception.force_bound_n(right.force_n[i]);
            if share > worst.force_share {
                (worst.force_share, worst.force_n) = (share, apart_n);
            }
            let apart_rad = (theta_rad - right.theta_rad[i]).abs();
            worst.angle_share = worst.angle_share.max(apart_rad / self.perception.angle_rad);
        }
        for RightLevels { levels, windows } in &self.bands {
            let least: Vec<f64> =
                levels.bands.iter().map(|band| self.threshold.at_m(band.centre_hz)).collect();
            for (from, right) in windows {
                let Some(found) = amplitudes_m(levels, motion, *from, self.lever_m) else {
                    continue;
                };
                for (k, (level_m, right_m)) in found.into_iter().zip(right).enumerate() {
                    let allowed_m = least[k].max(right_m * (1.0 + self.perception.excess_share));
                    // Over the right level, not over nothing: a motion without error has no share.
                    let share = ((level_m - right_m) / (allowed_m - right_m)).max(0.0);
                    if worst.vibration_share.is_none_or(|most| share > most) {
                        worst.vibration_share = Some(share);
                        worst.frequency_hz = levels.bands[k].centre_hz;
                        (worst.amplitude_m, worst.right_m) = (level_m, *right_m);
                    }
                }
            }
        }
        worst
    }
}

impl RightLevels {
    fn of(levels: Levels, motion: &FeltMotion, lever_m: f64, spans: &[(usize, usize)]) -> Self {
        let begins = spans.iter().flat_map(|span| windows(*span, levels.length));
        let windows =
            begins.filter_map(|from| Some((from, amplitudes_m(&levels, motion, from, lever_m)?)));
        Self { windows: windows.collect(), levels }
    }
}

/// Amplitudes of the lever's end in the window that begins at a step, by band, m; `None` where the
/// motion ends before it does.
fn amplitudes_m(
    levels: &Levels,
    motion: &FeltMotion,
    from: usize,
    lever_m: f64,
) -> Option<Vec<f64>> {
    let theta = motion.theta_rad.get(from..=from + levels.length)?;
    Some(levels.amplitudes(theta).into_iter().map(|rad| lever_m * rad).collect())
}

/// Beginnings of windows that overlap by half and fill a span; none where it is too short.
fn windows((from, to): (usize, usize), length: usize) -> Vec<usize> {
    let Some(last) = to.checked_sub(length).filter(|last| *last >= from) else {
        return Vec::new();
    };
    let mut begins: Vec<usize> = (from..last).step_by(length.div_ceil(2)).collect();
    begins.push(last);
    begins
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const LEVER_M: f64 = 0.05;

    /// A second of θ(t) and F(t).
    fn motion(theta: impl Fn(f64) -> f64, force: impl Fn(f64) -> f64) -> FeltMotion {
        let steps = 4000;
        FeltMotion {
            theta_rad: (0..=steps).map(|i| theta(f64::from(i) * STEP_S)).collect(),
            force_n: (0..steps).map(|i| force((f64::from(i) + 0.5) * STEP_S)).collect(),
            jumps_s: Vec::new(),
        }
    }

    fn slow(t: f64) -> f64 {
        0.3 * (TAU * 0.5 * t).sin()
    }

    /// How far `other` is from a slow motion under 4 N.
    fn compare(other: &FeltMotion) -> FeltDifference {
        let right = motion(slow, |_| 4.0);
        FeltReference::new(&right, LEVER_M, &Perception::default()).compare(other)
    }

    #[test]
    fn a_motion_is_not_felt_to_differ_from_itself() {
        let same = compare(&motion(slow, |_| 4.0));
        assert!(!same.is_felt(), "{same:?}");
        assert!(same.force_share.abs() < 1e-12 && same.angle_share.abs() < 1e-12);
        assert!(same.vibration_share.unwrap() < 1e-12, "{same:?}");
    }

    #[test]
    fn a_constant_force_is_felt_from_seven_percent_on_and_a_small_one_from_the_floor_on() {
        for (more_n, share) in [(0.14, 0.5), (0.28, 1.0), (0.56, 2.0)] {
            let found = compare(&motion(slow, |_| 4.0 + more_n));
            assert!((found.force_share - share).abs() < 1e-9, "{found:?}");
            assert!((found.force_n - more_n).abs() < 1e-9);
        }
        let perception = Perception::default();
        assert!((perception.force_bound_n(0.1) - 0.05).abs() < 1e-15);
        assert!((perception.force_bound_n(-10.0) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn an_angle_is_felt_from_two_degrees_on() {
        let found = compare(&motion(|t| slow(t) + 1_f64.to_radians(), |_| 4.0));
        assert!((found.angle_share - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_vibration_counts_by_the_curve_at_its_frequency() {
        let threshold = VibrationThreshold::of(&Perception::default().vibration);
        for (frequency_hz, share) in [(50.118_723, 3.0), (199.526_231, 3.0), (199.526_231, 0.5)] {
            let amplitude_m = share * threshold.at_m(frequency_hz);
            let shaken = |t: f64| slow(t) + amplitude_m / LEVER_M * (TAU * frequency_hz * t).sin();
            let found = compare(&motion(shaken, |_| 4.0));
            assert_eq!(found.is_felt(), share > 1.0, "{found:?}");
            if share > 1.0 {
                assert!((found.vibration_share.unwrap() / share - 1.0).abs() < 0.05, "{found:?}");
                assert!((found.frequency_hz / frequency_hz - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_vibration_of_the_right_motion_itself_may_be_a_fifth_larger_and_no_more() {
        let shaken = |size: f64| motion(move |t| slow(t) + size * (TAU * 100.0 * t).sin(), |_| 4.0);
        let right = FeltReference::new(&shaken(1e-3), LEVER_M, &Perception::default());
        assert!(!right.compare(&shaken(1.19e-3)).is_felt());
        let share = |size: f64| right.compare(&shaken(size)).vibration_share.unwrap();
        assert!(share(1e-3) < 1e-12, "without an error there is nothing to feel");
        assert!(share(0.5e-3) < 0.01, "a weaker one is not felt");
        assert!((share(1.1e-3) - 0.5).abs() < 0.01, "{}", share(1.1e-3));
        assert!((share(1.4e-3) - 2.0).abs() < 0.05, "{}", share(1.4e-3));
    }

    #[test]
    fn a_jump_that_comes_a_millisecond_late_is_not_felt_and_one_half_a_second_late_is() {
        let jump = |at: f64| motion(slow, move |t| if t < at { 2.0 } else { 6.0 });
        let right = FeltReference::new(&jump(1.0), LEVER_M, &Perception::default());
        // From 50 ms before the first step of the jump to 50 ms after its last.
        assert_eq!(right.spans, [(0, 1899), (2100, 4000)]);
        assert!(right.compare(&jump(1.001)).force_share < 1.0);
        let late = right.compare(&jump(1.5));
        assert!(late.is_felt() && late.force_n > 3.9, "{late:?}");
    }

    #[test]
    fn what_is_disturbed_throughout_cannot_be_compared_and_counts_as_felt() {
        let jumps = motion(slow, |t| if (t * 20.0) as i64 % 2 == 0 { 1.0 } else { 5.0 });
        let found = FeltReference::new(&jumps, LEVER_M, &Perception::default()).compare(&jumps);
        assert!(found.vibration_share.is_none() && found.is_felt(), "{found:?}");
    }

    #[test]
    fn windows_fill_a_span_and_need_one_that_is_long_enough() {
        assert_eq!(windows((10, 40), 20), [10, 20]);
        assert_eq!(windows((10, 45), 20), [10, 20, 25]);
        assert_eq!(windows((10, 30), 20), [10]);
        assert!(windows((10, 29), 20).is_empty());
        assert_eq!(spans(&[true, true, false, true]), [(0, 2), (3, 4)]);
    }
}
