//! Random numbers for the simulation: one seed and one purpose give the same numbers on any
//! machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// Number of bytes of the cipher's key.
const KEY_BYTES: usize = 32;

/// Bits of a random number that fill an `f64`'s significand.
const SIGNIFICAND_BITS: u32 = 53;

/// A stream of numbers from the ChaCha8 cipher: its definition fixes them, on any machine, in any
/// later version.
#[derive(Debug, Clone)]
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    /// The stream of a purpose: every (`seed`, `purpose`, `number`) has its own, so that a trial
    /// does not depend on how many numbers earlier ones drew.
    pub(crate) fn new(seed: u64, purpose: Purpose, number: u64) -> Self {
        let mut key = [0; KEY_BYTES];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8] = purpose as u8;
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(number);
        Self(rng)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        // As many bits as a significand has: the number is exact, and never rounded up to 1.
        let bits = self.0.next_u64() >> (u64::BITS - SIGNIFICAND_BITS);
        libm::ldexp(bits as f64, -(SIGNIFICAND_BITS as i32))
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm, for sizes whose range spans a factor: [low, high), both above 0.
    pub(crate) fn scaled(&mut self, [low, high]: [f64; 2]) -> f64 {
        low * libm::exp(libm::log(high / low) * self.unit())
    }

    /// Normal with mean 0 and standard deviation 1 (Box & Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = 1.0 - self.unit(); // in (0, 1], so that its logarithm is finite
        let turn = self.unit();
        (-2.0 * libm::log(radius)).sqrt() * libm::cos(TAU * turn)
    }

    /// Normal, held to two standard deviations either way: people vary, but not without bound.
    pub(crate) fn moderate(&mut self) -> f64 {
        self.normal().clamp(-2.0, 2.0)
    }
}

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// What a participant is like.
    Person,
    /// What a participant means to do in a trial.
    Intent,
    /// The noise of an answer.
    Answer,
    /// Sensors.
    Sensors,
    /// What one board has and another has not: how its magnet sits, how its clock runs.
    Board,
    /// A sweep.
    Sweep,
    /// What a participant is like on one day.
    Day,
    /// Trials that are given up.
    GivingUp,
    /// Questions that stay open.
    Silence,
    /// Which mode it is said to have been.
    Guess,
    /// Answers to tasks.
    Judgement,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_have_mean_0_and_variance_1() {
        let mut draw = Draw::new(7, Purpose::Sensors, 0);
        let values: Vec<f64> = (0..100_000).map(|_| draw.normal()).collect();
        let mean = values.iter().sum::<f64>() / 1e5;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 1e5;
        let beyond_2 = values.iter().filter(|x| x.abs() > 2.0).count();
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
        assert!((4350..4750).contains(&beyond_2), "{beyond_2}"); // 4.55 %
    }

    #[test]
    fn seed_purpose_and_number_each_give_another_stream() {
        let first = |seed, purpose, number| Draw::new(seed, purpose, number).unit();
        let all = [
            first(1, Purpose::Person, 0),
            first(2, Purpose::Person, 0),
            first(1, Purpose::Intent, 0),
            first(1, Purpose::Person, 1),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| (a - b).abs() > 1e-9));
        }
        assert_eq!(first(1, Purpose::Person, 0).to_bits(), all[0].to_bits());
    }

    #[test]
    fn draws_stay_in_their_range() {
        let mut draw = Draw::new(3, Purpose::Person, 0);
        for _ in 0..1000 {
            assert!((2.0..5.0).contains(&draw.between([2.0, 5.0])));
            assert!((100.0..=600.0).contains(&draw.scaled([100.0, 600.0])));
            assert!(draw.moderate().abs() <= 2.0);
        }
    }
}
