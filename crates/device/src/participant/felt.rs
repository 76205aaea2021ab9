//! What was felt in a trial, accumulated step by step in a few sums.

use zwidth_dynamics::DrivenState;

/// Bins of angle over the work space, in which forces going in and coming out are compared.
const BINS: usize = 18;
/// Speed above which the hand counts as moving, m/s.
const MOVING_M_S: f64 = 0.005;

/// What a participant felt.
#[derive(Debug, Clone, PartialEq)]
pub struct Felt {
    range_rad: [f64; 2],
    start_rad: f64,
    highest_rad: f64,
    last_rad: f64,
    greatest_n: f64,
    /// Sums of 1, θ, F, θθ, θF and FF while going in.
    sums: [f64; 6],
    /// Sums of force and number of steps in each bin, going in and coming out.
    inward: [[f64; 2]; BINS],
    outward: [[f64; 2]; BINS],
}

impl Felt {
    /// Nothing yet; the lever turns within `range_rad` and starts at its lower end.
    pub(crate) fn nothing(range_rad: [f64; 2]) -> Self {
        Self {
            range_rad,
            start_rad: range_rad[0],
            highest_rad: range_rad[0],
            last_rad: range_rad[0],
            greatest_n: 0.0,
            sums: [0.0; 6],
            inward: [[0.0; 2]; BINS],
            outward: [[0.0; 2]; BINS],
        }
    }

    /// One step.
    pub(crate) fn feel(&mut self, state: &DrivenState) {
        let theta = state.theta_rad;
        let force = state.contact_n;
        self.highest_rad = self.highest_rad.max(theta);
        self.last_rad = theta;
        self.greatest_n = self.greatest_n.max(force);
        let bin = self.bin(theta);
        if state.hand_m_s > MOVING_M_S && force > 0.0 {
            for (sum, x) in self.sums.iter_mut().zip([
                1.0,
                theta,
                force,
                theta * theta,
                theta * force,
                force * force,
            ]) {
                *sum += x;
            }
            add(&mut self.inward[bin], force);
        } else if state.hand_m_s < -MOVING_M_S {
            add(&mut self.outward[bin], force);
        }
    }

    fn bin(&self, theta_rad: f64) -> usize {
        let [low, high] = self.range_rad;
        // Beyond the ends the nearest bin: stops give a little.
        (((theta_rad - low) / (high - low) * BINS as f64) as usize).min(BINS - 1)
    }

    /// How well force over angle was a line while going in: R², 0…1; 0 if nothing was felt.
    pub(crate) fn linearity(&self) -> f64 {
        let [n, x, y, xx, xy, yy] = self.sums;
        let sxx = n * xx - x * x;
        let sxy = n * xy - x * y;
        let syy = n * yy - y * y;
        let scale = sxx * syy;
        if scale > 0.0 { (sxy * sxy / scale).min(1.0) } else { 0.0 }
    }

    /// How far the lever came back, as a share of how far it went, 0…1.
    pub(crate) fn returned(&self) -> f64 {
        let travel_rad = self.highest_rad - self.start_rad;
        if travel_rad > 0.0 { (self.highest_rad - self.last_rad) / travel_rad } else { 0.0 }
    }

    /// Mean difference between the forces going in and coming out at the same angle, N; over the
    /// bins that were felt both ways, 0 without one.
    pub(crate) fn discrepancy_n(&self) -> f64 {
        let both = self.inward.iter().zip(&self.outward).filter(|(i, o)| i[1] > 0.0 && o[1] > 0.0);
        let (sum, bins) = both.fold((0.0, 0.0), |(sum, bins), (i, o)| {
            (sum + (i[0] / i[1] - o[0] / o[1]).abs(), bins + 1.0)
        });
        if bins > 0.0 { sum / bins } else { 0.0 }
    }

    /// How far the lever went past an angle, rad; below 0 if it was not reached.
    pub(crate) fn past_rad(&self, angle_rad: f64) -> f64 {
        self.highest_rad - angle_rad
    }

    /// Greatest force, N.
    pub(crate) fn greatest_n(&self) -> f64 {
        self.greatest_n
    }
}

fn add(bin: &mut [f64; 2], force_n: f64) {
    bin[0] += force_n;
    bin[1] += 1.0;
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    pub(crate) fn state(theta_rad: f64, contact_n: f64, hand_m_s: f64) -> DrivenState {
        DrivenState {
            theta_rad,
            theta_dot_rad_s: 0.0,
            motor_n: 0.0,
            brake_n: 0.0,
            contact_n,
            hand_m: 0.0,
            hand_m_s,
        }
    }

    /// Feels forces along a path there and back, as functions of the angle; `stays` for a lever
    /// that does not return.
    pub(crate) fn walk(
        top_rad: f64,
        stays: bool,
        going: impl Fn(f64) -> f64,
        coming: impl Fn(f64) -> f64,
    ) -> Felt {
        let mut felt = Felt::nothing([-FRAC_PI_4, FRAC_PI_4]);
        let mut step = |theta_rad, contact_n, hand_m_s| {
            felt.feel(&state(theta_rad, contact_n, hand_m_s));
        };
        let at = |i: i32| -FRAC_PI_4 + (top_rad + FRAC_PI_4) * f64::from(i) / 400.0;
        (0..=400).for_each(|i| step(at(i), going(at(i)), 0.1));
        (0..=400)
            .rev()
            .for_each(|i| step(if stays { top_rad } else { at(i) }, coming(at(i)), -0.1));
        felt
    }

    #[test]
    fn a_line_is_a_line_and_a_plateau_is_less_of_one() {
        let spring = |theta: f64| 4.0 * (theta + FRAC_PI_4);
        assert!((walk(0.5, false, spring, spring).linearity() - 1.0).abs() < 1e-9);
        let saturated = |theta: f64| spring(theta).min(2.0);
        assert!(walk(0.5, false, saturated, saturated).linearity() < 0.9);
        assert!(Felt::nothing([-1.0, 1.0]).linearity() < 1e-12);
    }

    #[test]
    fn a_lever_that_stays_did_not_return() {
        let spring = |theta: f64| 4.0 * (theta + FRAC_PI_4);
        assert!(walk(0.5, true, spring, |_| 0.0).returned() < 1e-12);
        assert!(walk(0.5, false, spring, spring).returned() > 1.0 - 1e-12);
    }

    #[test]
    fn the_discrepancy_is_the_mean_gap_between_both_ways() {
        let felt = walk(0.5, false, |_| 3.0, |_| 1.25);
        assert!((felt.discrepancy_n() - 1.75).abs() < 1e-12);
        assert!((felt.past_rad(0.4) - 0.1).abs() < 1e-12);
        assert!((felt.greatest_n() - 3.0).abs() < 1e-12);
    }
}
