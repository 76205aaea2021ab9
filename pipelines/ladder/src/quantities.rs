//! The quantities by which models are compared, and when a difference could be felt.

use crate::run::Course;
use std::ops::Range;
use zwidth_numerics::series::ends;
use zwidth_study::{Measured, Perception};

/// Half of the window over which a force counts, s: what is quicker is vibration.
const HALF_WINDOW_S: f64 = 0.05;
/// A force jumps where it changes by more than this share of its largest size within a window.
const JUMP: f64 = 0.25;

/// The numbers of a course without a study: largest angle, angle at the end, largest force.
pub fn own(course: &Course) -> Vec<Measured> {
    let slow = slow(&course.t_s, &course.feedback_n);
    let [theta_max_rad, feedback_max_n] = [&course.theta_rad, &slow]
        .map(|signal| signal.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    let theta_end_rad = course.theta_rad.last().copied().unwrap_or(f64::NAN);
    [
        ("theta_max_rad", "rad", theta_max_rad),
        ("theta_end_rad", "rad", theta_end_rad),
        ("feedback_max_n", "N", feedback_max_n),
    ]
    .map(|(name, unit, value)| Measured {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: value.is_finite().then_some(value),
    })
    .into()
}

/// How far a course is off another, over what can be felt: above 1 it is another one. Angle by its
/// largest difference, force by that of its slow part outside of windows around jumps.
pub(crate) fn off_course(course: &Course, full: &Full, bounds: &Perception) -> [f64; 2] {
    let angle = course.theta_rad.iter().zip(&full.course.theta_rad);
    let angle = angle.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / bounds.angle_rad;
    let slow = slow(&course.t_s, &course.feedback_n);
    // At a jump, a command that acts a moment later is off by all of the jump for that moment.
    let force = slow.iter().zip(&full.slow_n).zip(&full.jumps).filter(|(_, jumps)| !**jumps);
    let force = force.map(|((a, b), _)| (a - b).abs() / bounds.force_bound_n(*b));
    [angle, force.fold(0.0, f64::max)]
}

/// The fullest model's course, made ready to be compared with.
pub(crate) struct Full {
    pub(crate) course: Course,
    slow_n: Vec<f64>,
    /// Whether the slow force jumps at each sample.
    jumps: Vec<bool>,
}

impl Full {
    pub(crate) fn new(course: Course) -> Self {
        let slow_n = slow(&course.t_s, &course.feedback_n);
        let jumps = jumps(&course.t_s, &slow_n);
        Self { course, slow_n, jumps }
    }
}

/// Means over windows of 100 ms, shorter at the ends: what is left is what a hand feels as force.
fn slow(t_s: &[f64], force_n: &[f64]) -> Vec<f64> {
    // Running sums: a window is the difference of two.
    let mut sums = vec![0.0];
    for force in force_n {
        sums.push(sums[sums.len() - 1] + force);
    }
    windows(t_s)
        .into_iter()
        .map(|Range { start, end }| (sums[end] - sums[start]) / (end - start) as f64)
        .collect()
}

/// Whether a signal changes by more than its share within the window of each sample, or of one
/// within its window: a jump that comes late is averaged over one window more.
fn jumps(t_s: &[f64], slow_n: &[f64]) -> Vec<bool> {
    let largest = slow_n.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    let windows = windows(t_s);
    let mut jumps = Vec::with_capacity(windows.len());
    for window in &windows {
        let (low, high) = ends(&slow_n[window.clone()]);
        jumps.push(high - low > JUMP * largest);
    }
    windows.into_iter().map(|window| jumps[window].contains(&true)).collect()
}

/// The samples within 50 ms of each.
fn windows(t_s: &[f64]) -> Vec<Range<usize>> {
    let mut windows = Vec::with_capacity(t_s.len());
    let mut start = 0;
    let mut end = 0;
    for t in t_s {
        while t_s[start] < t - HALF_WINDOW_S {
            start += 1;
        }
        while end < t_s.len() && t_s[end] <= t + HALF_WINDOW_S {
            end += 1;
        }
        windows.push(start..end);
    }
    windows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(force: impl Fn(f64) -> f64, angle: f64) -> Course {
        let t_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.01).collect();
        let feedback_n = t_s.iter().map(|t| force(*t)).collect();
        Course { theta_rad: vec![angle; t_s.len()], feedback_n, t_s, ..Course::default() }
    }

    fn off(a: impl Fn(f64) -> f64, b: impl Fn(f64) -> f64) -> f64 {
        off_course(&course(a, 0.0), &Full::new(course(b, 0.0)), &Perception::default())[1]
    }

    #[test]
    fn a_force_is_another_from_seven_percent_on_or_from_its_floor() {
        assert!((off(|_| 4.28, |_| 4.0) - 1.0).abs() < 1e-9);
        assert!((off(|_| 0.05, |_| 0.0) - 1.0).abs() < 1e-9);
        assert!(off(|_| 3.0, |_| 3.0) == 0.0);
    }

    #[test]
    fn an_angle_is_another_from_two_degrees_on() {
        let full = Full::new(course(|_| 1.0, 0.0));
        let found = off_course(&course(|_| 1.0, 1_f64.to_radians()), &full, &Perception::default());
        assert!((found[0] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn what_is_quicker_than_the_window_is_no_force_and_a_jump_that_comes_late_is_none_either() {
        let buzz = |t: f64| 3.0 + if (t * 100.0).round() as i64 % 2 == 0 { 0.5 } else { -0.5 };
        assert!(off(buzz, |_| 3.0) < 1.0);
        let jump = |at: f64| move |t: f64| if t < at { 4.0 } else { 1.0 };
        assert!(off(jump(2.02), jump(2.0)) < 1.0);
        assert!(off(jump(2.5), jump(2.0)) > 1.0);
    }
}
