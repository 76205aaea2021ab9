//! Degraded recordings: fewer samples, fewer bits of angle, a slower force sensor, another filter
//! of the velocity. The effect on a metric shows what the better version of each is worth.

use serde::Serialize;
use std::f64::consts::TAU;
use zwidth_results::LessKind;
use zwidth_store::{Samples, Signal, Trial};

/// Shaft turns in a turn of the lever (§4.2: 75 mm over 11 mm): the angle sensor's bits are of a
/// turn of the shaft.
const SHAFT_TURNS: f64 = 75.0 / 11.0;

/// Samples of the longest recording that is degraded: 17 minutes at 1 kHz.
pub const LONGEST: usize = 1 << 20;

/// A degradation of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Less {
    /// One sample of so many.
    OneSampleOf(usize),
    /// An angle of so many bits in a turn of the shaft.
    AngleBits(u32),
    /// New values of the force so often, Hz, held between them.
    ForceRateHz(f64),
    /// A velocity of the angles through two poles at this frequency, Hz: its delay is 1/(π f).
    VelocityCutoffHz(f64),
    /// A velocity that is the difference of two angles.
    VelocityDifference,
}

impl Less {
    /// All that is tried, the mildest of a kind first.
    pub const ALL: [Self; 11] = [
        Self::OneSampleOf(2),
        Self::OneSampleOf(4),
        Self::OneSampleOf(8),
        Self::AngleBits(11),
        Self::AngleBits(10),
        Self::AngleBits(8),
        Self::ForceRateHz(10.0),
        Self::VelocityCutoffHz(20.0),
        Self::VelocityCutoffHz(10.0),
        Self::VelocityCutoffHz(5.0),
        Self::VelocityDifference,
    ];

    /// The kind of degradation that it is a degree of.
    pub fn kind(self) -> LessKind {
        match self {
            Self::OneSampleOf(_) => LessKind::Samples,
            Self::AngleBits(_) => LessKind::Angle,
            Self::ForceRateHz(_) => LessKind::Force,
            Self::VelocityCutoffHz(_) | Self::VelocityDifference => LessKind::Filter,
        }
    }

    /// In words, for a recording's own rate.
    pub fn words(self) -> String {
        match self {
            Self::OneSampleOf(n) => format!("one sample of {n}"),
            Self::AngleBits(bits) => format!("angle of {bits} bits"),
            Self::ForceRateHz(rate) => format!("force at {rate} Hz"),
            Self::VelocityCutoffHz(cutoff) => format!("velocity filtered at {cutoff} Hz"),
            Self::VelocityDifference => "velocity unfiltered".to_owned(),
        }
    }
}

/// A trial with less. What it lacks anyway stays as it is.
pub fn lessened(trial: &Trial, less: Less) -> Trial {
    let mut trial = trial.clone();
    match less {
        Less::OneSampleOf(n) => trial.samples = thinned(&trial.samples, n),
        Less::AngleBits(bits) => angle_bits(&mut trial.samples, bits),
        Less::ForceRateHz(rate_hz) => hold_force(&mut trial.samples, rate_hz),
        Less::VelocityCutoffHz(cutoff_hz) => velocity(&mut trial.samples, Some(cutoff_hz)),
        Less::VelocityDifference => velocity(&mut trial.samples, None),
    }
    trial
}

fn thinned(samples: &Samples, n: usize) -> Samples {
    let mut thin = Samples::default();
    for signal in Signal::all() {
        if let Some(values) = samples.get(signal) {
            thin.set(signal, values.iter().step_by(n.max(1)).copied().collect());
        }
    }
    thin
}

/// θ rounded down to a count, as the sensor gives it.
fn angle_bits(samples: &mut Samples, bits: u32) {
    let count_rad = TAU / SHAFT_TURNS / libm::pow(2.0, f64::from(bits));
    if let Some(theta) = samples.get(Signal::Theta) {
        let counts = theta.iter().map(|x| count_rad * (x / count_rad).floor()).collect();
        samples.set(Signal::Theta, counts);
    }
}

/// The force as it was when the sensor last gave a value, and how old that is. A force that is
/// older already stays what it is, and is as much older.
fn hold_force(samples: &mut Samples, rate_hz: f64) {
    let (Some(t), Some(force)) = (samples.get(Signal::Time), samples.get(Signal::ForceEx)) else {
        return;
    };
    let age = samples.get(Signal::ForceAge);
    let mut held = Vec::new();
    let mut ages = Vec::new();
    let mut at = 0;
    for i in 0..t.len() {
        // A time that is a whole number of periods but for rounding is one: a new value comes then.
        let [now, last] = [i, at].map(|i| (t[i] * rate_hz * (1.0 + 1e-12)).floor());
        if now > last {
            at = i;
        }
        held.push(force[at]);
        ages.push(t[i] - t[at] + age.map_or(0.0, |age| age[at]));
    }
    samples.set(Signal::ForceEx, held);
    samples.set(Signal::ForceAge, ages);
}

/// θ̇ as the difference of angles, through two poles y' = (x − y)/τ, τ = 1/(2π f), where a cutoff
/// is given.
fn velocity(samples: &mut Samples, cutoff_hz: Option<f64>) {
    let (Some(t), Some(theta)) = (samples.get(Signal::Time), samples.get(Signal::Theta)) else {
        return;
    };
    let mut poles = [0.0; 2];
    let mut velocity = vec![0.0];
    for i in 1..t.len() {
        let step_s = t[i] - t[i - 1];
        let raw = if step_s > 0.0 { (theta[i] - theta[i - 1]) / step_s } else { 0.0 };
        // Exact for an input that is held over the step, so that uneven steps do no harm.
        let follow = cutoff_hz.map_or(1.0, |f| 1.0 - libm::exp(-TAU * f * step_s));
        let mut input = raw;
        for pole in &mut poles {
            *pole += follow * (input - *pole);
            input = *pole;
        }
        velocity.push(input);
    }
    // A recording without samples has no first velocity either.
    velocity.truncate(t.len());
    samples.set(Signal::ThetaDot, velocity);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// θ(t) and F(t) at 100 Hz for two seconds.
    fn samples(theta: impl Fn(f64) -> f64, force: impl Fn(f64) -> f64) -> Samples {
        let t: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
        let mut samples = Samples::default();
        samples.set(Signal::Theta, t.iter().copied().map(theta).collect());
        samples.set(Signal::ForceEx, t.iter().copied().map(force).collect());
        samples.set(Signal::Time, t);
        samples
    }

    #[test]
    fn a_held_force_is_the_one_of_the_last_update_and_says_how_old_it_is() {
        let mut samples = samples(|t| t, |t| 10.0 * t);
        hold_force(&mut samples, 10.0);
        let (force, age) =
            (samples.get(Signal::ForceEx).unwrap(), samples.get(Signal::ForceAge).unwrap());
        assert!((force[19] - 1.0).abs() < 1e-12 && (age[19] - 0.09).abs() < 1e-12);
        assert!((force[20] - 2.0).abs() < 1e-12 && age[20].abs() < 1e-12);
    }

    #[test]
    fn an_angle_of_fewer_bits_is_off_by_less_than_a_count() {
        let mut few = samples(|t| 0.3 * t, |_| 0.0);
        angle_bits(&mut few, 8);
        let count = TAU / SHAFT_TURNS / 256.0;
        let theta = few.get(Signal::Theta).unwrap();
        let off = (0..200).map(|i| 0.3 * f64::from(i) * 0.01 - theta[i as usize]);
        let largest = off.fold(0.0, f64::max);
        assert!(largest < count && largest > 0.8 * count, "{largest}");
    }

    #[test]
    fn two_poles_follow_a_ramp_late_by_the_inverse_of_pi_times_their_frequency() {
        // θ = t²/2, so that θ̇ = t; late by 1/(π f) = 31.8 ms at 10 Hz, and a half step by the
        // difference.
        let mut filtered = samples(|t| 0.5 * t * t, |_| 0.0);
        velocity(&mut filtered, Some(10.0));
        let late = 1.99 - filtered.get(Signal::ThetaDot).unwrap()[199];
        let expect = 2.0 * (0.01 / (1.0 - (-TAU * 0.1_f64).exp()) - 0.01) + 0.005;
        assert!((late - expect).abs() < 1e-6, "{late} {expect}");
    }

    #[test]
    fn one_sample_of_four_keeps_every_fourth_of_every_column() {
        let thin = thinned(&samples(|t| t, |t| t), 4);
        assert_eq!(thin.get(Signal::Time).unwrap().len(), 50);
        assert!((thin.get(Signal::Theta).unwrap()[1] - 0.04).abs() < 1e-15);
    }
}
