//! When a participant has let go.

use crate::control::HOLDING_RAD_S;
use zwidth_study::Sample;

/// A movement has been made once the lever was so far from where it began, rad (6°).
const MOVED_RAD: f64 = 0.1;

/// Less than this is no push, N: a tenth of the let-go threshold, a hundred times the load cell's
/// noise.
const QUIET_N: f64 = 0.2;

/// How long it must stay so, s.
const QUIET_S: f64 = 0.5;

/// Looks for the end of a movement: no force on a lever at rest, for half a second.
#[derive(Debug, Default)]
pub(super) struct Ending {
    start_rad: Option<f64>,
    moved: bool,
    quiet_since_s: Option<f64>,
}

impl Ending {
    /// Whether the participant has let go by this sample.
    pub(super) fn let_go(&mut self, sample: &Sample) -> bool {
        let start_rad = *self.start_rad.get_or_insert(sample.theta_rad);
        // Before it moves, a lever at rest without a force is quiet, too.
        self.moved |= (sample.theta_rad - start_rad).abs() > MOVED_RAD;
        let quiet =
            sample.force_ex_n.abs() < QUIET_N && sample.theta_dot_rad_s.abs() < HOLDING_RAD_S;
        if !(self.moved && quiet) {
            self.quiet_since_s = None;
            return false;
        }
        sample.t_s - *self.quiet_since_s.get_or_insert(sample.t_s) >= QUIET_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::tests::sample;

    #[test]
    fn a_lever_that_never_moved_was_not_let_go() {
        let mut ending = Ending::default();
        assert!(!(0..100).any(|i| ending.let_go(&sample(0.1 * f64::from(i), 0.0, 0.0, 0.0))));
    }

    #[test]
    fn half_a_second_of_rest_without_force_ends_a_movement_wherever_the_lever_stays() {
        let mut ending = Ending::default();
        assert!(!ending.let_go(&sample(0.0, 0.0, 0.0, 0.0)));
        assert!(!ending.let_go(&sample(0.5, 0.3, 1.0, 3.0)));
        assert!(!ending.let_go(&sample(1.0, 0.3, 0.0, 0.1)));
        assert!(!ending.let_go(&sample(1.49, 0.3, 0.0, 0.1)));
        assert!(ending.let_go(&sample(1.5, 0.3, 0.0, 0.1)));
    }

    #[test]
    fn a_push_or_a_motion_begins_the_half_second_anew() {
        for (velocity, force_n) in [(0.0, 0.3), (0.1, 0.0)] {
            let mut ending = Ending::default();
            ending.let_go(&sample(0.0, 0.0, 0.0, 0.0));
            ending.let_go(&sample(1.0, 0.3, 0.0, 0.0));
            assert!(!ending.let_go(&sample(1.4, 0.3, velocity, force_n)));
            assert!(!ending.let_go(&sample(1.5, 0.3, 0.0, 0.0)));
            assert!(ending.let_go(&sample(2.0, 0.3, 0.0, 0.0)));
        }
    }
}
