//! The quantities by which models are compared, and when a difference could be felt.

use crate::run::Course;
use std::ops::Range;
use zwidth_study::{Measured, Perception};

/// Half of the window over which a force counts, s: what is quicker is vibration.
const HALF_WINDOW_S: f64 = 0.05;
/// A force jumps where it changes by more than this share of its largest size within a window.
const JUMP: f64 = 0.25;

/// The numbers of a course without a study: largest angle, angle at the end, largest force.
pub fn own(course: &Course) -> Vec<Measured> {
    let number = |name: &str, unit: &str, value: f64| Measured {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: value.is_finite().then_some(value),
    };
    let largest = |x: &[f64]| x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let last = course.theta_rad.last().copied().unwrap_or(f64::NAN);
    let slow = slow(&course.t_s, &course.feedback_n);
    vec![
        number("theta_max_rad", "rad", largest(&course.theta_rad)),
        number("theta_end_rad", "rad", last),
        number("feedback_max_n", "N", largest(&slow)),
    ]
}

/// How far a course is off another, over what can be felt: above 1 it is another one. Angle by its
/// largest difference, force by that of its slow part outside of windows around jumps.
pub(crate) fn off_course(course: &Course, full: &Full, bounds: &Perception) -> [f64; 2] {
    let angle = course.theta_rad.iter().zip(&full.course.theta_rad);
    let angle = angle.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / bounds.angle_rad;
    let slow = slow(&course.t_s, &course.feedback_n);
    let force = slow.iter().zip(&full.slow_n).zip(&full.jumps).filter(|(_, jumps)| !**jumps);
    let force = force.map(|((a, b), _)| (a - b).abs() / bounds.force_bound_n(*b));
    [angle, force.fold(0.0, f64::max)]
}

/// The fullest model's course, made ready to be compared with.
pub(crate) struct Full {
    pub(crate) course: Course,
    slow_n: Vec<f64>,
    /// Where the slow force jumps.
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
    let jumps = |window: Range<usize>| {
        let (low, high) = slow_n[window]
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        high - low > JUMP * largest
    };
    let windows = windows(t_s);
    let jump: Vec<bool> = windows.iter().cloned().map(jumps).collect();
    windows.into_iter().map(|window| jump[window].contains(&true)).collect()
}

/// The samples within 50 ms of each.
fn windows(t_s: &[f64]) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut end = 0;
    let window = |t: &f64| {
        while t_s[start] < t - HALF_WINDOW_S {
            start += 1;
        }
        while end < t_s.len() && t_s[end] <= t + HALF_WINDOW_S {
            end += 1;
        }
        start..end
    };
    t_s.iter().map(window).collect()
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
