//! Whether a recording oscillates, and where.

use crate::Course;
use zwidth_dynamics::FEWEST_SWINGS;
use zwidth_numerics::activity::activity;
use zwidth_numerics::order::upper_median;
use zwidth_numerics::zigzag::zigzag;
use zwidth_study::Analysis;

/// A swing exists from this many σ of the noise on.
const SIGMAS: f64 = 4.0;
/// Neighbours in a row differ by at most this factor in duration: a push and the swings after it
/// are two things.
const ALIKE: f64 = 3.0;
/// Two angles that differ by less are one, rad.
const ROUNDING_RAD: f64 = 1e-12;

/// The oscillation of a recording: its longest row of existing swings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedSwings {
    /// Its beginning, s since the first sample.
    pub from_s: f64,
    /// Its end, likewise.
    pub to_s: f64,
    /// Number of swings.
    pub swings: usize,
    /// Median of half their peak-to-peak angle, rad.
    pub amplitude_rad: f64,
    /// 1 / (2 · the mean of their durations), Hz.
    pub frequency_hz: f64,
}

impl RecordedSwings {
    /// A period, s.
    pub fn period_s(&self) -> f64 {
        1.0 / self.frequency_hz
    }
}

/// One way from a turn to the next.
#[derive(Debug, Clone, Copy)]
struct Swing {
    from_s: f64,
    to_s: f64,
    amplitude_rad: f64,
}

impl Swing {
    fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// One count of a recorded angle: the smallest step between two samples, rad; 0 for one that never
/// changes.
pub(crate) fn count_rad(theta_rad: &[f64]) -> f64 {
    let steps = theta_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let least = steps.filter(|step| *step > ROUNDING_RAD).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Half the peak-to-peak angle from which on a swing of a recording exists, rad: the larger of one
/// count and 4 σ of the noise, which is that of the angle before its velocity first exceeds the
/// study's onset. With fewer than ten samples of rest the count alone is known.
pub(crate) fn bound_rad(course: &Course, analysis: &Analysis) -> f64 {
    const FEWEST: usize = 10;
    let active = activity(&course.theta_dot_rad_s, analysis.onset_rad_s, analysis.offset_rad_s);
    let onset = active.map_or(course.theta_rad.len(), |active| active.onset);
    let rest = &course.theta_rad[..onset];
    let noise_rad = match rest.len() < FEWEST {
        true => 0.0,
        false => {
            // σ by second differences, root mean square over √6: a slow drift has none.
            let bends = rest.windows(3).map(|y| y[0] - 2.0 * y[1] + y[2]);
            let (sum, n) = bends.fold((0.0, 0.0), |(sum, n), bend| (sum + bend * bend, n + 1.0));
            (sum / (6.0 * n)).sqrt()
        }
    };
    count_rad(&course.theta_rad).max(SIGMAS * noise_rad)
}

/// The oscillation of an angle against time; `None` for fewer than six existing swings in a row.
/// Only what lies within `within_s` counts.
pub(crate) fn swings(
    t_s: &[f64],
    theta_rad: &[f64],
    bound_rad: f64,
    within_s: [f64; 2],
) -> Option<RecordedSwings> {
    let legs = zigzag(theta_rad, 2.0 * bound_rad);
    // The first and the last leg begin or end where the recording does, at no turn.
    let inner = legs.get(1..legs.len().saturating_sub(1)).unwrap_or_default();
    let mut all = Vec::new();
    for leg in inner {
        let from_s = t_s[leg.from];
        let to_s = t_s[leg.to];
        if within_s[0] <= from_s && to_s <= within_s[1] {
            let amplitude_rad = 0.5 * (theta_rad[leg.to] - theta_rad[leg.from]).abs();
            all.push(Swing { from_s, to_s, amplitude_rad });
        }
    }
    // The first of equally long rows.
    let rows = all
        .chunk_by(|a, b| {
            let a = a.duration_s();
            let b = b.duration_s();
            a <= ALIKE * b && b <= ALIKE * a
        })
        .filter(|row| row.len() >= FEWEST_SWINGS);
    let row = rows.reduce(|best, row| if row.len() > best.len() { row } else { best })?;
    Some(RecordedSwings {
        from_s: row[0].from_s,
        to_s: row[row.len() - 1].to_s,
        swings: row.len(),
        // The upper of two middle ones is the size of a swing that was there.
        amplitude_rad: upper_median(row.iter().map(|swing| swing.amplitude_rad))?,
        frequency_hz: 0.5 * row.len() as f64 / (row[row.len() - 1].to_s - row[0].from_s),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    fn times() -> Vec<f64> {
        (0..2000).map(|i| f64::from(i) * 2e-3).collect()
    }

    /// A push of a second, and then 0.01 rad at 8 Hz for a second and a half.
    fn angle(t: f64) -> f64 {
        let push = 0.5 * (1.0 - libm::cos(core::f64::consts::PI * t.min(1.0)));
        let swing = if (1.5..3.0).contains(&t) { libm::sin(TAU * 8.0 * (t - 1.5)) } else { 0.0 };
        push + 0.01 * swing
    }

    #[test]
    fn swings_after_a_push_are_found_with_their_size_and_frequency() {
        let t = times();
        let theta: Vec<f64> = t.iter().map(|t| angle(*t)).collect();
        let found = swings(&t, &theta, 1e-3, [0.0, 4.0]).unwrap();
        assert!((found.frequency_hz - 8.0).abs() < 0.2, "{found:?}");
        assert!((found.amplitude_rad - 0.01).abs() < 1e-4, "{found:?}");
        assert!((21..=24).contains(&found.swings) && found.from_s > 1.4, "{found:?}");
        assert_eq!(swings(&t, &theta, 1e-3, [0.0, 1.7]), None, "three swings are none");
        assert_eq!(swings(&t, &theta, 0.02, [0.0, 4.0]), None, "below the bound");
    }

    #[test]
    fn a_count_is_the_smallest_step_and_the_noise_is_that_of_rest() {
        let count = 2.25e-4;
        let theta: Vec<f64> = times().iter().map(|t| (angle(*t) / count).round() * count).collect();
        assert!((count_rad(&theta) - count).abs() < 1e-12);
        assert!(count_rad(&[1.0; 4]) <= 0.0);
        let analysis = Analysis::default();
        let noisy: Vec<f64> = (0..400).map(|i| 0.001 * f64::from(i % 2)).collect();
        let course = Course {
            t_s: (0..400).map(f64::from).collect(),
            theta_rad: noisy,
            theta_dot_rad_s: vec![0.0; 400],
            force_ex_n: vec![0.0; 400],
            feedback_n: None,
        };
        let bound = bound_rad(&course, &analysis);
        // Second differences of ±2 counts.
        assert!((bound - 4.0 * 0.002 / 6_f64.sqrt()).abs() < 1e-12, "{bound}");
    }
}
