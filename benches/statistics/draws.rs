//! Random numbers of a seed, by libm: the same data on any machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of draws.
pub(crate) struct Draws(ChaCha8Rng);

impl Draws {
    /// Stream `number` of a seed.
    pub(crate) fn new(seed: u8, number: u64) -> Self {
        let mut rng = ChaCha8Rng::from_seed([seed; 32]);
        rng.set_stream(number);
        Self(rng)
    }

    /// Uniform in (0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Standard normal (Box & Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }

    /// Standard logistic.
    pub(crate) fn logistic(&mut self) -> f64 {
        let share = self.uniform();
        libm::log(share / (1.0 - share))
    }
}
