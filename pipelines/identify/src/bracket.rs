//! The force below which the brake lets go, from what the controller did.
//!
//! Thresholds between the same two recorded forces cannot be told apart. So the threshold has a
//! bracket, which certainly contains it, and no interval.

/// A trial with motor and brake, sample by sample; all of one length.
#[derive(Debug, Clone, Copy)]
pub struct Switching<'a> {
    /// θ̇ as the controller used it, rad/s.
    pub theta_dot_rad_s: &'a [f64],
    /// F_ex as the controller used it, N.
    pub force_n: &'a [f64],
    /// Commanded voltages, V.
    pub motor_v: &'a [f64],
    /// Brake.
    pub brake_v: &'a [f64],
}

/// The forces between which the threshold lies, N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bracket {
    /// Largest force at which the brake let go; `None` if it never did.
    pub low_n: Option<f64>,
    /// Smallest force at which it held on to a lever that did not move on; `None` where there was
    /// none.
    pub high_n: Option<f64>,
    /// Times it let go.
    pub releases: usize,
}

impl Bracket {
    /// The bracket that trials leave. The controller's rule is the thesis' (§6.2.1): with the brake
    /// on, a lever that does not move on (θ̇ ≤ 0) keeps it while the user's force is at least
    /// the threshold, and gets the motor once it is below.
    pub fn of<'a>(trials: impl IntoIterator<Item = Switching<'a>>) -> Self {
        let mut bracket = Self::default();
        for trial in trials {
            for i in 1..trial.force_n.len() {
                let force_n = trial.force_n[i];
                if trial.brake_v[i - 1] <= 0.0 {
                    continue;
                }
                if trial.brake_v[i] > 0.0 && trial.theta_dot_rad_s[i] <= 0.0 {
                    bracket.high_n = Some(bracket.high_n.map_or(force_n, |n| n.min(force_n)));
                }
                // The motor tells letting go from a brake that is only switched off.
                if trial.brake_v[i] <= 0.0 && trial.motor_v[i] != 0.0 {
                    bracket.low_n = Some(bracket.low_n.map_or(force_n, |n| n.max(force_n)));
                    bracket.releases += 1;
                }
            }
        }
        bracket
    }

    /// The bracket that the trials of both leave.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            low_n: self.low_n.into_iter().chain(other.low_n).reduce(f64::max),
            high_n: self.high_n.into_iter().chain(other.high_n).reduce(f64::min),
            releases: self.releases + other.releases,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bracket_is_between_the_lowest_held_and_the_highest_released_force() {
        let trial = |theta_dot_rad_s, brake_v| Switching {
            theta_dot_rad_s,
            force_n: &[0.5, 4.0, 2.4, 2.1, 1.8, 1.5],
            motor_v: &[0.0, 0.0, 0.0, 0.0, -8.0, -8.0],
            brake_v,
        };
        let still = trial(&[1.0, 1.0, 0.0, -0.1, 0.0, 0.0], &[0.0, 3.0, 3.0, 3.0, 0.0, 0.0]);
        let found = Bracket::of([still]);
        assert_eq!(found, Bracket { low_n: Some(1.8), high_n: Some(2.1), releases: 1 });
        // moving on keeps the brake whatever the force: that says nothing of the threshold
        let moving = trial(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.0], &[0.0, 3.0, 3.0, 3.0, 3.0, 3.0]);
        assert_eq!(Bracket::of([moving, still]), found);
        assert_eq!(Bracket::of([]), Bracket { low_n: None, high_n: None, releases: 0 });
        // trial by trial is the same
        let earlier = trial(&[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], &[0.0, 3.0, 3.0, 0.0, 0.0, 0.0]);
        let earlier = Switching { motor_v: &[0.0, 0.0, 0.0, -8.0, 0.0, 0.0], ..earlier };
        let apart = Bracket::of([earlier]).and(found).and(Bracket::default());
        assert_eq!(apart, Bracket::of([earlier, still]));
        assert_eq!(apart, Bracket { low_n: Some(2.1), high_n: Some(2.1), releases: 2 });
    }

    #[test]
    fn a_brake_that_is_switched_off_without_the_motor_has_not_let_go() {
        let stopped = Switching {
            theta_dot_rad_s: &[0.0; 2],
            force_n: &[3.0, 1.0],
            motor_v: &[0.0; 2],
            brake_v: &[3.0, 0.0],
        };
        assert_eq!(Bracket::of([stopped]).releases, 0);
    }
}
