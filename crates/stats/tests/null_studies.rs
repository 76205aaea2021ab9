//! Studies without an effect, in which people differ in how they take each mode: what is found in
//! them is found by chance, and no more often than was promised.
//!
//! 10,000 studies of each kind: 6 and 12 participants, three modes, one value per participant and
//! mode (the mean of repeats); participant × mode scatter equal over modes or four times as large
//! in one; values as measured, or rounded to the five answers of a scale; complete, or with each
//! participant missing one mode in ten.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use zwidth_stats::null::Sampling;
use zwidth_stats::{friedman, paired, sign_flip, signed_rank};

const STUDIES: u64 = 10_000;
/// The largest share of 10,000 at 5 % that chance gives but once in a thousand: 5 % + 3.09 standard
/// errors of 0.218 %.
const NOT_ABOVE_NOMINAL: f64 = 0.0567;
/// A share whose upper 99.9 % bound is 6 %.
const AT_MOST_SIX: f64 = 0.0529;
const SAMPLING: Sampling = Sampling { draws: 999, seed: 1 };

/// How the studies of one kind are made.
#[derive(Debug, Clone, Copy)]
struct Null {
    people: usize,
    /// Participant × mode standard deviation of each mode.
    scatter: [f64; 3],
    is_scale: bool,
    is_complete: bool,
}

/// What was found in all studies of a kind, as shares.
#[derive(Debug, Default, Clone, Copy)]
struct Found {
    t: f64,
    covered: f64,
    sign_flip: f64,
    signed_rank: f64,
    friedman: f64,
}

impl Null {
    /// Rows of one study: a value per mode, without the modes that are missing.
    fn rows(self, study: u64) -> Vec<[Option<f64>; 3]> {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let row = |_| {
            let person = normal(&mut rng);
            self.scatter.map(|sd| {
                let value = 3.0 + 0.8 * person + sd * normal(&mut rng) + 0.3 * normal(&mut rng);
                let value = if self.is_scale { value.round().clamp(1.0, 5.0) } else { value };
                let is_there = self.is_complete || !rng.next_u64().is_multiple_of(10);
                is_there.then_some(value)
            })
        };
        (0..self.people).map(row).collect()
    }

    /// Whether all modes scatter alike: that a participant's values could stand in any order is what
    /// Friedman's test tests.
    fn is_even(self) -> bool {
        self.scatter.iter().all(|sd| (sd - self.scatter[0]).abs() < 1e-9)
    }

    /// The contrast of the last mode with the first, and Friedman's test of all three
    /// where they scatter alike.
    fn found(self, study: u64) -> Found {
        let rows = self.rows(study);
        let pairs: Vec<[f64; 2]> =
            rows.iter().filter_map(|[first, _, last]| Some([(*last)?, (*first)?])).collect();
        let complete: Vec<[f64; 3]> =
            rows.iter().filter_map(|[a, b, c]| Some([(*a)?, (*b)?, (*c)?])).collect();
        let complete: Vec<&[f64]> = complete.iter().map(|row| row.as_slice()).collect();
        let differences = paired::differences(&pairs);
        let share = |is: bool| f64::from(u8::from(is));
        let t = paired::mean_difference(&differences, 0.95).ok();
        let flip = sign_flip::test(&differences, SAMPLING).ok();
        let rank = signed_rank::test(&differences).ok();
        let order =
            self.is_even().then(|| friedman::test(&complete, SAMPLING)).and_then(Result::ok);
        // Differences that are all equal make no claim, and no interval either.
        Found {
            t: share(t.is_some_and(|t| t.p_value < 0.05)),
            covered: share(t.is_none_or(|t| t.ci_low <= 0.0 && 0.0 <= t.ci_high)),
            sign_flip: share(flip.is_some_and(|f| f.p_value <= 0.05)),
            signed_rank: share(rank.is_some_and(|r| r.p_value <= 0.05)),
            friedman: share(order.is_some_and(|f| f.p_value <= 0.05)),
        }
    }

    fn shares(self) -> Found {
        let all: Vec<Found> = (0..STUDIES).into_par_iter().map(|s| self.found(s)).collect();
        let share = |of: fn(&Found) -> f64| all.iter().map(of).sum::<f64>() / STUDIES as f64;
        Found {
            t: share(|f| f.t),
            covered: share(|f| f.covered),
            sign_flip: share(|f| f.sign_flip),
            signed_rank: share(|f| f.signed_rank),
            friedman: share(|f| f.friedman),
        }
    }
}

/// A number of the standard normal distribution (Box & Muller 1958, Ann. Math. Stat. 29:610).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let uniform = |rng: &mut ChaCha8Rng| ((rng.next_u64() >> 11) as f64 + 0.5) / 2_f64.powi(53);
    let radius = (-2.0 * libm::log(uniform(rng))).sqrt();
    radius * libm::cos(core::f64::consts::TAU * uniform(rng))
}

fn kinds() -> Vec<Null> {
    let mut kinds = Vec::new();
    for people in [6, 12] {
        for scatter in [[0.5; 3], [0.3, 1.2, 0.3], [0.3, 0.3, 1.2]] {
            for (is_scale, is_complete) in [(false, true), (false, false), (true, true)] {
                kinds.push(Null { people, scatter, is_scale, is_complete });
            }
        }
    }
    kinds
}

#[test]
fn nothing_is_found_more_often_than_was_promised() {
    for kind in kinds() {
        let found = kind.shares();
        println!("{kind:?}: {found:?}");
        assert!(found.sign_flip <= NOT_ABOVE_NOMINAL, "{kind:?}: {found:?}");
        assert!(found.signed_rank <= NOT_ABOVE_NOMINAL, "{kind:?}: {found:?}");
        if !kind.is_scale {
            assert!(found.t <= AT_MOST_SIX, "{kind:?}: {found:?}");
            assert!((0.94..=0.985).contains(&found.covered), "{kind:?}: {found:?}");
        }
        if kind.is_even() {
            assert!(found.friedman <= NOT_ABOVE_NOMINAL, "{kind:?}: {found:?}");
        }
    }
}

/// What the tests above would let through if nothing were ever found: an effect is.
#[test]
fn an_effect_of_two_standard_deviations_is_found() {
    let kind = Null { people: 12, scatter: [0.5; 3], is_scale: false, is_complete: true };
    let is_found = |study: &u64| {
        let shifted = |row: [Option<f64>; 3]| Some(row[2]? + 1.6 - row[0]?);
        let differences: Vec<f64> = kind.rows(*study).into_iter().filter_map(shifted).collect();
        let flip = sign_flip::test(&differences, SAMPLING).is_ok_and(|f| f.p_value <= 0.05);
        let rank = signed_rank::test(&differences).is_ok_and(|r| r.p_value <= 0.05);
        flip && rank
    };
    let found = (0..1000).into_par_iter().filter(is_found).count();
    assert!(found > 950, "{found} of 1000");
}
