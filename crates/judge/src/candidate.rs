//! A trajectory that is to be judged, and whether it can be.

use crate::JudgeError;

/// Fewer samples show nothing.
const FEWEST: usize = 16;
/// More are not compared; of a longer trajectory so many are, evenly chosen.
const MOST: usize = 1_000_000;
/// A trajectory may begin and end so many of its steps within the scene: programs write after a
/// step, or before it.
const STEPS: f64 = 2.0;
/// Times whose end is so many times the scene's, to within a tenth, are milliseconds.
const MS_PER_S: f64 = 1e3;

/// A trajectory of any program for a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Candidate {
    /// Times, s, from the scene's start.
    pub t_s: Vec<f64>,
    /// θ at each, rad.
    pub theta_rad: Vec<f64>,
    /// θ̇ at each, rad/s.
    pub theta_dot_rad_s: Vec<f64>,
    /// Whether that was computed from the angles, because the program gave none.
    pub velocity_computed: bool,
    /// The user's force that the program applied, N, if it says so.
    pub force_ex_n: Option<Vec<f64>>,
}

impl Candidate {
    /// Median time between samples, s; 0 of fewer than two.
    pub(crate) fn step_s(&self) -> f64 {
        let steps = self.t_s.windows(2).map(|pair| pair[1] - pair[0]);
        zwidth_numerics::order::median(steps).unwrap_or(0.0)
    }

    /// What of it lies within a scene of this length, at most a million samples.
    ///
    /// # Errors
    /// Columns of different lengths, something that is no number, times that do not increase, a
    /// beginning or an end that is not the scene's, too few samples.
    pub(crate) fn within(&self, duration_s: f64) -> Result<Self, JudgeError> {
        let Self { t_s, theta_rad, theta_dot_rad_s, force_ex_n, .. } = self;
        let [times, angles, velocities] = [t_s, theta_rad, theta_dot_rad_s].map(Vec::len);
        let forces = force_ex_n.as_ref().map_or(times, Vec::len);
        if angles != times || velocities != times || forces != times {
            return Err(JudgeError::Lengths { times, angles, velocities });
        }
        // The times first: velocities that were computed need good ones.
        numbers("t", t_s)?;
        if let Some(at) = t_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            let [before_s, t_s] = [t_s[at], t_s[at + 1]];
            return Err(JudgeError::NotIncreasing { row: at + 2, t_s, before_s });
        }
        numbers("θ", theta_rad)?;
        numbers("θ̇", theta_dot_rad_s)?;
        let (Some(&begin_s), Some(&end_s)) = (t_s.first(), t_s.last()) else {
            return Err(JudgeError::TooShort { samples: 0, least: FEWEST });
        };
        let slack_s = STEPS * self.step_s();
        if (end_s / (MS_PER_S * duration_s) - 1.0).abs() < 0.1 {
            return Err(JudgeError::Milliseconds { end_s, duration_s });
        }
        if begin_s < 0.0 {
            return Err(JudgeError::BeginsEarly { t_s: begin_s });
        }
        if begin_s > slack_s {
            return Err(JudgeError::BeginsLate { t_s: begin_s });
        }
        if end_s < duration_s - slack_s {
            return Err(JudgeError::EndsEarly { end_s, duration_s });
        }
        // An end that is the scene's but for rounding is it.
        let inside = t_s.partition_point(|t| *t <= duration_s * (1.0 + 1e-9));
        if inside < FEWEST {
            return Err(JudgeError::TooShort { samples: inside, least: FEWEST });
        }
        let stride = inside.div_ceil(MOST);
        let some = |values: &[f64]| values[..inside].iter().copied().step_by(stride).collect();
        Ok(Self {
            t_s: some(t_s),
            theta_rad: some(theta_rad),
            theta_dot_rad_s: some(theta_dot_rad_s),
            velocity_computed: self.velocity_computed,
            force_ex_n: force_ex_n.as_deref().map(some),
        })
    }
}

/// Whether all values are numbers.
fn numbers(what: &'static str, values: &[f64]) -> Result<(), JudgeError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(at) => Err(JudgeError::NotFinite { row: at + 1, what, value: values[at] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 101 samples of a lever at rest, 1 s, with one change.
    fn check(change: impl FnOnce(&mut Candidate), words: &str) {
        let t_s: Vec<f64> = (0..=100).map(|i| 0.01 * f64::from(i)).collect();
        let still = vec![0.0; t_s.len()];
        let mut candidate = Candidate {
            t_s,
            theta_rad: still.clone(),
            theta_dot_rad_s: still,
            ..Candidate::default()
        };
        change(&mut candidate);
        let error = candidate.within(1.0).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    #[test]
    fn what_is_no_trajectory_of_the_scene_is_said_with_its_row() {
        check(|c| c.theta_rad.truncate(7), "101 times, 7 angles");
        check(|c| c.theta_rad[4] = f64::NAN, "row 5: θ is NaN");
        check(|c| c.theta_dot_rad_s[4] = f64::INFINITY, "row 5: θ̇ is inf");
        check(|c| c.t_s[3] = 0.02, "row 4: the time 0.02 s does not come after 0.02 s");
        check(|c| c.t_s.iter_mut().for_each(|t| *t *= 0.5), "ends at 0.5 s");
        check(|c| c.t_s.iter_mut().for_each(|t| *t *= 1e3), "are they milliseconds?");
        check(|c| c.t_s.iter_mut().for_each(|t| *t += 0.5), "begins at 0.5 s");
        check(|c| c.t_s.iter_mut().for_each(|t| *t -= 0.5), "begins at -0.5 s");
        check(|c| *c = Candidate::default(), "0 samples");
        check(
            |c| {
                let few = |values: &[f64]| values.iter().copied().step_by(10).collect::<Vec<_>>();
                let [t_s, theta] = [few(&c.t_s), few(&c.theta_rad)];
                *c = Candidate {
                    t_s,
                    theta_rad: theta.clone(),
                    theta_dot_rad_s: theta,
                    ..Candidate::default()
                };
            },
            "11 samples",
        );
    }

    #[test]
    fn of_a_longer_trajectory_what_lies_within_the_scene_is_taken() {
        let t_s: Vec<f64> = (0..3_000_000).map(|i| 1e-6 * f64::from(i)).collect();
        let still = vec![0.0; t_s.len()];
        let all = Candidate {
            t_s,
            theta_rad: still.clone(),
            theta_dot_rad_s: still,
            ..Candidate::default()
        };
        let within = all.within(2.0).unwrap();
        assert_eq!((within.t_s.len(), within.theta_rad.len()), (666_667, 666_667));
        assert!((within.t_s[666_666] - 1.999_998).abs() < 1e-9, "every third");
    }
}
