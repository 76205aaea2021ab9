//! The weight calculation of the thesis' Appendix A, with the study's own masses.

use crate::evidence::with_law;
use zwidth_results::Fact;
use zwidth_study::{Calibration, ModeLaw, Setup};

/// Rated voltage of the thesis' motor, V: Faulhaber 2342S048C (§2.1). A study's file does not hold
/// its motor's.
pub(crate) const RATED_V: f64 = 48.0;

/// What a motor and a brake would weigh if the motor were only as large as the hybrid mode needs
/// it: the force of a motor goes with its volume (Hancock, the thesis' reference 23) and with its
/// voltage, so that a motor used at the share s of its rated voltage could have the share s of its
/// mass. None without masses or without a mode of both actuators.
///
/// Two slips of Appendix A and §6.3 are corrected and noted: at stall the power goes with the
/// square of the voltage, and the weight saved is the motor's less the hybrid's.
pub fn weight_facts(study: &Setup, calibration: &Calibration) -> Option<Vec<Fact>> {
    let masses = study.masses?;
    let used_v = hybrid_v(study)?;
    let motor_g = masses.motor_kg * 1e3;
    let brake_g = masses.brake_kg * 1e3;
    let share = used_v / RATED_V;
    let force_n = calibration.motor.force_n(used_v);
    let small_g = motor_g * share;
    let hybrid_g = small_g + brake_g;
    Some(vec![
        Fact::new("motor, mass", Some(motor_g), "g").printed(88.0),
        Fact::new("brake, mass", Some(brake_g), "g").printed(27.0),
        Fact::new("motor voltage in the hybrid mode", Some(used_v), "V").printed(8.0),
        Fact::new("motor force there", Some(force_n), "N").printed(2.0),
        Fact::new("motor force at its rated 48 V", Some(force_n / share), "N")
            .printed(12.0)
            .remarked("force goes with the voltage"),
        Fact::new("motor of that size, mass", Some(small_g), "g")
            .printed(15.0)
            .remarked("force goes with the volume (Hancock)"),
        Fact::new("hybrid: brake and small motor, mass", Some(hybrid_g), "g").printed(42.0),
        Fact::new("saved against the whole motor", Some(motor_g - hybrid_g), "g")
            .printed(35.0)
            .remarked("the thesis' own masses give 88 − 42 = 46"),
        Fact::new("share of the motor's power at stall", Some(share * share), "1")
            .printed(1.0 / 6.0)
            .remarked("power goes with the voltage squared: 1/36, not 1/6"),
    ])
}

/// Highest motor voltage of the mode in which the motor takes over from the brake, V.
fn hybrid_v(study: &Setup) -> Option<f64> {
    with_law(study, ModeLaw::Hybrid)?.motor_max_v
}

/// Whether masses and modes allow a table of weights.
pub fn is_weighed(study: &Setup) -> bool {
    study.masses.is_some() && hybrid_v(study).is_some()
}

/// Masses, g: of brake and a motor as large as the hybrid mode needs it, and of the motor. None
/// without masses or without a mode of both actuators.
pub(crate) fn masses_g(study: &Setup) -> Option<[f64; 2]> {
    let masses = study.masses?;
    let share = hybrid_v(study)? / RATED_V;
    Some([(masses.motor_kg * share + masses.brake_kg) * 1e3, masses.motor_kg * 1e3])
}

/// The notes below the table of weights.
pub const WEIGHT_NOTES: [&str; 2] = [
    "Two slips of the thesis are corrected: at stall the power goes with the square of the voltage, so that 8 of \
     48 V are 1/36 of it and not 1/6 (the force, on which the masses rest, is 1/6); and 88 g less 42 g are \
     46 g, not 35 g.",
    "The rated 48 V are those of the thesis' motor. Transmission, housing and the air gap are left out, as in \
     the thesis: an indication, not a design.",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    #[test]
    fn the_thesis_masses_give_46_g_saved_and_a_thirty_sixth_of_the_power() {
        let facts = weight_facts(&study(), &Calibration::thesis()).unwrap();
        let values: Vec<f64> = facts.iter().filter_map(|fact| fact.value).collect();
        let expect = [
            88.0,
            27.0,
            8.0,
            2.08,
            12.48,
            88.0 / 6.0,
            27.0 + 88.0 / 6.0,
            61.0 - 88.0 / 6.0,
            1.0 / 36.0,
        ];
        for (found, expect) in values.iter().zip(expect) {
            assert!((found - expect).abs() < 1e-12, "{found} instead of {expect}");
        }
        assert!((values[7] - 46.0).abs() < 0.5 && values.len() == expect.len());
    }

    #[test]
    fn without_masses_or_a_mode_of_both_there_is_nothing_to_weigh() {
        let mut light = study();
        light.masses = None;
        assert!(weight_facts(&light, &Calibration::thesis()).is_none());
        let mut single = study();
        single.modes.retain(|m| m.motor_max_v.is_none() || m.brake_max_v.is_none());
        assert!(weight_facts(&single, &Calibration::thesis()).is_none());
    }
}
