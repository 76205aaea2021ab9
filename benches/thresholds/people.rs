//! Simulated people, by numbers that both sides compute alike.

use zwidth_stats::psychometric::{Curve, Sigmoid};

/// A number in [0, 1) by SplitMix64 (Steele, Lea & Flood 2014, OOPSLA): of a person, and of one of their trials.
pub(crate) fn uniform(person: u64, trial: u64) -> f64 {
    let mut mixed = (person << 32 | trial).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Trials of a person have the numbers from here on; those before are their curve's.
pub(crate) const FIRST_TRIAL: u64 = 10;
/// Lapses, in a share of trials.
pub(crate) const LAPSE: f64 = 0.02;
/// The slope β of everybody's Weibull curve.
pub(crate) const SLOPE: f64 = 2.0;

/// A person who tells in which of two intervals there was something: Weibull's curve, thresholds around 0.08 N.
pub(crate) fn detecting(person: u64) -> Curve {
    let alpha = 0.08 * libm::exp(0.8 * (uniform(person, 0) - 0.5));
    Curve {
        sigmoid: Sigmoid::Weibull,
        location: libm::log(alpha),
        scale: 1.0 / SLOPE,
        guess: 0.5,
        lapse: LAPSE,
    }
}

/// A person who tells which of two was more: a normal curve, thresholds around 300, JNDs around 30.
pub(crate) fn comparing(person: u64) -> Curve {
    let mut curve = Curve {
        sigmoid: Sigmoid::Norm,
        location: 300.0 + 30.0 * (uniform(person, 0) - 0.5),
        scale: 1.0,
        guess: LAPSE,
        lapse: LAPSE,
    };
    curve.scale = 30.0 * libm::exp(0.8 * (uniform(person, 1) - 0.5)) / curve.jnd();
    curve
}
