//! Passivity of the sampled wall by Colgate & Schenkel's condition.
//!
//! b > max over 0 < ω ≤ π/T of (T/2) Re{(1 − e^(−jωT)) H(e^(jωT))} / (1 − cos ωT)
//! (Colgate & Schenkel 1997, J. Robotic Systems 14:37). For the backward difference it is K T/2 +
//! |B|, with one period of delay and B = 0 it is 3 K T/2, with d of them (2 d + 1) K T/2.

use super::SampledWall;
use std::f64::consts::PI;

/// A complex number as its two parts.
type Complex = [f64; 2];

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn over(a: Complex, b: Complex) -> Complex {
    let size = b[0] * b[0] + b[1] * b[1];
    times(a, [b[0] / size, -b[1] / size])
}

impl SampledWall {
    /// The device's damping b, N s/m, above which the wall is passive; none where the condition
    /// does not apply: a delay of no whole number of periods, a lag of the motor. (A mass or a
    /// finger on the lever changes nothing.)
    pub fn damping_for_passivity(&self) -> Option<f64> {
        /// Places in which the maximum is looked for before it is closed in on, for each period of
        /// delay: the function swings once more with each.
        const PLACES: usize = 64;
        let (whole, rest_s) = self.delay();
        if rest_s > 0.0 || self.motor_lag_s.is_some() {
            return None;
        }
        let places = PLACES * (whole + 2);
        let width = (PI - SLOWEST) / places as f64;
        let values = (0..=places).map(|i| (i, self.damping_at(SLOWEST + i as f64 * width)));
        let (best, highest) = values.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let from = SLOWEST + best.saturating_sub(1) as f64 * width;
        let to = SLOWEST + (best + 1).min(places) as f64 * width;
        // The place itself too: the highest value may stand at an end, which the search only nears.
        Some(self.highest_between(from, to).max(highest))
    }

    /// The stiffness K, N/m, up to which the wall is passive; 0 if it never is, none where the
    /// condition does not apply.
    pub fn stiffest_passive(&self) -> Option<f64> {
        self.damping_for_passivity()?;
        let b = self.damping_ns_per_m;
        let needed = |wall: &SampledWall| wall.damping_for_passivity().unwrap_or(f64::INFINITY);
        // What is needed is convex in K, and at K = 0 the least: it is closed in on from above.
        if needed(&self.with_stiffness(0.0)) >= b {
            return Some(0.0);
        }
        let mut high = 2.0 * b / self.period_s;
        while needed(&self.with_stiffness(high)) < b {
            high *= 2.0;
        }
        let mut low = 0.0;
        while high - low > 1e-10 * high {
            let middle = 0.5 * (low + high);
            let passes = needed(&self.with_stiffness(middle)) < b;
            (low, high) = if passes { (middle, high) } else { (low, middle) };
        }
        Some(0.5 * (low + high))
    }

    /// (T/2) Re{(1 − e^(−jφ)) H} / (1 − cos φ) at φ = ωT; the quotient is j e^(−jφ/2) / sin(φ/2).
    fn damping_at(&self, phi: f64) -> f64 {
        let sin = libm::sin(0.5 * phi);
        let cos = libm::cos(0.5 * phi);
        let quotient = [1.0, cos / sin];
        0.5 * self.period_s * times(quotient, self.response(phi))[0]
    }

    /// H(e^(jφ)) = e^(−jdφ) (K + B (1 − α)(1 − e^(−jφ)) / (T (1 − α e^(−jφ)))).
    fn response(&self, phi: f64) -> Complex {
        let alpha = self.filter();
        let back = [libm::cos(phi), -libm::sin(phi)];
        let gain = self.wall_damping_ns_per_m * (1.0 - alpha) / self.period_s;
        let difference = [gain * (1.0 - back[0]), -gain * back[1]];
        let filtered = over(difference, [1.0 - alpha * back[0], -alpha * back[1]]);
        let late = self.delay().0 as f64 * phi;
        let delayed = [libm::cos(late), -libm::sin(late)];
        times(delayed, [self.stiffness_n_per_m + filtered[0], filtered[1]])
    }

    /// The highest value between two places, by golden section.
    fn highest_between(&self, mut from: f64, mut to: f64) -> f64 {
        const ROUNDS: u32 = 60;
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        for _ in 0..ROUNDS {
            let a = to - GOLDEN * (to - from);
            let b = from + GOLDEN * (to - from);
            if self.damping_at(a) > self.damping_at(b) {
                to = b;
            } else {
                from = a;
            }
        }
        self.damping_at(0.5 * (from + to))
    }
}

/// The lowest ωT that is looked at: the function is flat there, and its cancellation below 1e-12.
const SLOWEST: f64 = 1e-4;
