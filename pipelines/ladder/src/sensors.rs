//! What the controller sees.

use crate::model::Model;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;
use zwidth_device::{COUNTS_PER_TURN, SHAFT_PER_LEVER, Velocity};

/// Values a second of the force sensor (HX711 at its faster setting, thesis Table 4), Hz.
const FORCE_RATE_HZ: f64 = 80.0;
/// The first word of every noise's seed, so that no other draw has it.
const NOISE: u64 = 0x6c61_6464_6572_0000;

/// Angle (rad), velocity (rad/s) and user's force (N) at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    pub(crate) theta_rad: f64,
    pub(crate) theta_dot_rad_s: f64,
    pub(crate) force_n: f64,
}

/// Counted angle, velocity filter, slow and noisy force.
pub(crate) struct Sensors {
    velocity: Velocity,
    zero_counts: f64,
    noise_n: f64,
    noise: ChaCha8Rng,
    force_n: f64,
    /// Number of the next force value.
    next: u64,
}

impl Sensors {
    pub(crate) fn new(model: &Model, velocity: &Velocity) -> Self {
        Self {
            velocity: velocity.clone(),
            zero_counts: model.zero_counts,
            noise_n: model.noise_n,
            noise: ChaCha8Rng::seed_from_u64(NOISE ^ model.seed),
            force_n: 0.0,
            next: 0,
        }
    }

    /// The sensors' values at a time, for a true motion and force.
    pub(crate) fn see(&mut self, t_s: f64, truth: Seen) -> Seen {
        let count_rad = TAU / f64::from(COUNTS_PER_TURN) / SHAFT_PER_LEVER;
        let counts = (truth.theta_rad / count_rad + self.zero_counts).floor() - self.zero_counts;
        let theta_rad = counts * count_rad;
        // From its number, not by adding periods, which would drift. The noise of values between
        // two ticks is drawn, so that it does not depend on the ticks.
        while self.next as f64 / FORCE_RATE_HZ <= t_s {
            self.next += 1;
            self.force_n = truth.force_n + self.noise_n * self.normal();
        }
        let theta_dot_rad_s = self.velocity.step(t_s, theta_rad);
        Seen { theta_rad, theta_dot_rad_s, force_n: self.force_n }
    }

    /// A normal variate (Box & Muller 1958).
    fn normal(&mut self) -> f64 {
        // 53 bits, as many as a number holds, and above 0, whose logarithm is infinite.
        let [a, b] =
            [(); 2].map(|()| ((self.noise.next_u64() >> 11) as f64 + 1.0) / (1_u64 << 53) as f64);
        (-2.0 * libm::log(a)).sqrt() * libm::cos(TAU * b)
    }
}
