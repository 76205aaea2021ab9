//! Tables of what was planned: the modes as used, the device.

use zwidth_results::{Fact, ModeForces};
use zwidth_study::{ActuatorKind, Calibration, ModeLaw, Resistances, Setup, VelocityFilter};
use zwidth_tables::shown_unit;

/// Motor and brake as each mode uses them, one row per mode: highest voltages, what acts while
/// compressing and while decompressing, and its largest force by `calibration`.
pub fn mode_forces(study: &Setup, calibration: &Calibration) -> Vec<ModeForces> {
    let rows = study.modes.iter().map(|mode| {
        // A mode of both has the brake on the way in and the motor on the way back (thesis §2.2).
        let drives = mode.law().map(ModeLaw::drives);
        let ways = [0, 1].map(|way| match drives?[way] {
            ActuatorKind::Motor => Some(("motor", calibration.motor.force_n(mode.motor_max_v?))),
            ActuatorKind::Brake => {
                // It acts against the motion alone: on the way back that is no force of a spring.
                let words = ["brake", "brake, against the return"][way];
                Some((words, calibration.brake.force_n(mode.brake_max_v?)))
            }
        });
        let [compressing, decompressing] = ways.map(|way| Some(way?.0.to_owned()));
        let [compressing_max_n, decompressing_max_n] = ways.map(|way| Some(way?.1));
        ModeForces {
            mode: mode.label.clone(),
            motor_max_v: mode.motor_max_v,
            brake_max_v: mode.brake_max_v,
            compressing,
            compressing_max_n,
            decompressing,
            decompressing_max_n,
        }
    });
    rows.collect()
}

/// The device and its control loop, as `study.toml` has them.
pub fn device_facts(study: &Setup) -> Vec<Fact> {
    let device = &study.device;
    let control = &study.control;
    let (unit, factor) = shown_unit("rad", study.coordinate);
    let [low, high] =
        [device.theta_min_rad, device.theta_max_rad].map(|angle| angle.map(|rad| factor * rad));
    let mut facts = vec![
        Fact::new("lever length, axis to finger", device.lever_m.map(|m| m * 1e3), "mm"),
        Fact::new("work space, lower end", low, &unit),
        Fact::new("work space, upper end", high, &unit),
        Fact::new("new values of the force sensor", device.force_rate_hz, "Hz"),
        Fact::new("tick of the control loop", Some(1e3 / control.rate_hz), "ms"),
        Fact::new("user force below which the brake lets go", Some(control.let_go_n), "N"),
        Fact::new("limit of the force on a finger", Some(control.force_limit_n), "N"),
        match control.velocity {
            VelocityFilter::Difference => Fact::new("velocity from angles", None, "")
                .remarked("difference of the last two angles"),
            VelocityFilter::SecondOrder { cutoff_hz } => {
                Fact::new("velocity from angles", Some(cutoff_hz), "Hz")
                    .remarked("differentiator with a second-order low-pass; its cut-off")
            }
        },
    ];
    if let Some(masses) = study.masses {
        facts.push(Fact::new("motor, mass", Some(masses.motor_kg * 1e3), "g"));
        facts.push(Fact::new("brake, mass", Some(masses.brake_kg * 1e3), "g"));
    }
    let Resistances { motor_ohm, brake_ohm } = study.resistances;
    for (what, ohm) in [("motor, resistance", motor_ohm), ("brake, resistance", brake_ohm)] {
        facts.extend(ohm.map(|ohm| Fact::new(what, Some(ohm), "Ω")));
    }
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    /// §5.1 and §5.2.2: 4.16 N at 16 V, 2.08 N at 8 V, 13 N of the brake at 8 V.
    #[test]
    fn each_mode_has_the_forces_of_what_acts_on_either_way() {
        let modes = mode_forces(&study(), &Calibration::thesis());
        let most = modes.iter().map(|mode| [mode.compressing_max_n, mode.decompressing_max_n]);
        let expect = [[4.16, 4.16], [13.0, 13.0], [13.0, 2.08]].map(|of| of.map(Some));
        assert_eq!(most.collect::<Vec<_>>(), expect);
        let back: Vec<_> = modes.iter().filter_map(|mode| mode.decompressing.as_deref()).collect();
        assert_eq!(back, ["motor", "brake, against the return", "motor"]);
    }

    #[test]
    fn the_device_stands_in_millimetres_degrees_and_grams_and_what_is_unknown_is_null() {
        let mut study = study();
        study.device.lever_m = None;
        study.device.theta_min_rad = Some(-std::f64::consts::FRAC_PI_4);
        let facts = device_facts(&study);
        assert_eq!((facts[0].value, facts[1].value), (None, Some(-45.0)));
        assert_eq!(facts[4].value, Some(1.0), "1 kHz, the default");
        study.masses = None;
        study.resistances = Resistances::default();
        assert_eq!(device_facts(&study).len(), 8);
    }
}
