//! Random motions of a shaft as a sensor sees them: with noise, with hysteresis, round and round.
//! Below the bound that [`Unwrap`] states, each is followed to the count; one step beyond it is
//! refused.

use super::super::*;
use crate::mock;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Samples of a motion.
const SAMPLES: usize = 60;
/// Most noise and most play between shaft and sensor, counts of 4096.
const NOISE: i64 = 20;
const PLAY: i64 = 40;

struct Draw(ChaCha8Rng);

impl Draw {
    /// A whole number from −most to most.
    fn around_0(&mut self, most: i64) -> i64 {
        self.between(-most, most)
    }

    fn between(&mut self, least: i64, most: i64) -> i64 {
        least + (self.0.next_u64() % (most - least + 1) as u64) as i64
    }
}

/// What a sensor counts of a motion, turns and all, and where the shaft really was, counts.
struct Motion {
    per_turn: i64,
    dt_s: f64,
    seen: Vec<i64>,
    real: Vec<i64>,
    /// How far apart the two may be.
    off: i64,
}

impl Motion {
    /// Steps below half a turn that change by less than a quarter, with all that noise and play add
    /// to them.
    fn draw(draw: &mut Draw) -> Self {
        let per_turn = [1024, 4096, 16_384][draw.between(0, 2) as usize];
        let share = per_turn / 1024;
        let (noise, play) = (draw.between(0, NOISE * share / 4), draw.between(0, PLAY * share / 4));
        let steepest = per_turn / 4 - 4 * noise - 4 * play - 1;
        let fastest = per_turn / 2 - 2 * noise - 2 * play - 1;
        let dt_s = 1.0 / draw.between(120, 1000) as f64;
        let start = draw.between(0, per_turn - 1);
        let (mut at, mut step, mut held) = (start, 0, start);
        let (mut seen, mut real) = (Vec::new(), Vec::new());
        // A motion is a few stretches of the same push.
        let mut push = 0;
        for i in 0..SAMPLES {
            if i % 8 == 0 {
                push = draw.around_0(steepest);
            }
            if i > 0 {
                step = (step + push).clamp(-fastest, fastest);
                at += step;
            }
            // The sensor's magnet is taken along once the play is used up.
            held = held.clamp(at - play, at + play);
            let noise = if i == 0 { 0 } else { draw.around_0(noise) };
            seen.push(held + noise);
            real.push(at);
        }
        Self { per_turn, dt_s, seen, real, off: noise + play }
    }

    fn raw(&self, count: i64) -> u16 {
        u16::try_from(count.rem_euclid(self.per_turn)).unwrap()
    }

    fn t_s(&self, i: usize) -> f64 {
        self.dt_s * i as f64
    }

    fn start(&self) -> Unwrap {
        Unwrap::start(self.per_turn as u32, 0.0, self.raw(self.seen[0])).unwrap()
    }
}

fn motions(of: u64, each: impl Fn(u64, &Motion, &mut Draw)) {
    for seed in 0..of {
        let mut draw = Draw(ChaCha8Rng::seed_from_u64(seed));
        let motion = Motion::draw(&mut draw);
        each(seed, &motion, &mut draw);
    }
}

/// Followed from its start to its end: each count, and each angle of the lever.
fn recovers(seed: u64, motion: &Motion) {
    let turns_before = motion.seen[0] - i64::from(motion.raw(motion.seen[0]));
    let mut unwrap = motion.start();
    let capabilities =
        Capabilities { counts_per_turn: Some(motion.per_turn as u32), ..mock::capabilities() };
    let at_stop = mock::reading(Angle::Counts(motion.raw(motion.seen[0])));
    let mut homed = Homed::at_stop(&capabilities, 0.25, 0.0, &at_stop).unwrap();
    let one_rad = rad_per_count(motion.per_turn as u32, capabilities.shaft_per_lever);
    for i in 1..SAMPLES {
        let (raw, t_s) = (motion.raw(motion.seen[i]), motion.t_s(i));
        let total = unwrap.follow(t_s, raw).map(|total| total + turns_before);
        assert_eq!(total, Ok(motion.seen[i]), "seed {seed}, sample {i}");
        let theta_rad = homed.follow(t_s, Angle::Counts(raw)).unwrap();
        let real_rad = 0.25 + (motion.real[i] - motion.real[0]) as f64 * one_rad;
        let off = (theta_rad - real_rad).abs() / one_rad;
        assert!(off <= (2 * motion.off) as f64 + 1e-6, "seed {seed}, sample {i}: {off} counts off");
    }
}

/// One step that is a quarter to three quarters of a turn from the expected one is refused, and
/// forgotten.
fn refuses(seed: u64, motion: &Motion, draw: &mut Draw) {
    let place = draw.between(2, SAMPLES as i64 - 1) as usize;
    let mut unwrap = motion.start();
    for i in 1..place {
        unwrap.follow(motion.t_s(i), motion.raw(motion.seen[i])).unwrap();
    }
    let expected = 2 * motion.seen[place - 1] - motion.seen[place - 2];
    let by = draw.between(motion.per_turn / 4 + 1, 3 * motion.per_turn / 4 - 1);
    let by = if draw.between(0, 1) == 0 { by } else { -by };
    let (before, t_s) = (unwrap.clone(), motion.t_s(place));
    let fault = unwrap.follow(t_s, motion.raw(expected + by));
    assert!(matches!(fault, Err(AngleFault::Jump { .. })), "seed {seed}: {by} counts, {fault:?}");
    assert_eq!(unwrap, before, "seed {seed}");
    assert!(unwrap.follow(t_s, motion.raw(motion.seen[place])).is_ok(), "seed {seed}");
}

#[test]
fn random_motions_below_the_bound_are_recovered_to_the_count() {
    motions(10_000, |seed, motion, _| recovers(seed, motion));
}

#[test]
fn random_steps_above_the_bound_are_refused() {
    motions(10_000, refuses);
}

#[test]
#[ignore = "a million motions: for .ci/long"]
fn a_million_motions_are_recovered_below_the_bound_and_refused_above() {
    motions(1_000_000, |seed, motion, draw| {
        recovers(seed, motion);
        refuses(seed, motion, draw);
    });
}
