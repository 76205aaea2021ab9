//! Tables of what was planned: the modes as used, the device.

use crate::actuation::{acting, force_n};
use crate::facts::{self, Fact};
use zwidth_study::{
    ActuatorKind, Calibration, Coordinate, Mode, Resistances, Setup, VelocityFilter,
};
use zwidth_tables::{Column, Table, TableError, shown_unit};

/// Motor and brake as each mode uses them, one row per mode: highest voltages, what acts while
/// compressing and while decompressing, and its largest force by `calibration`. `footnote` says
/// where the calibration is from.
///
/// # Errors
/// A force that is not finite.
pub fn modes_table(
    study: &Setup,
    calibration: &Calibration,
    footnote: &str,
) -> Result<Table, TableError> {
    let modes = &study.modes;
    let volts = |name, about, get: fn(&Mode) -> Option<f64>| {
        Column::float(name, "V", about, modes.iter().map(get))
    };
    let word = |way: usize| {
        modes
            .iter()
            .map(move |m| acting(m)[way].map(|(actuator, _)| on_way(actuator, way).to_owned()))
    };
    let most =
        |way: usize| modes.iter().map(move |m| acting(m)[way].map(|a| force_n(calibration, a)));
    let columns = vec![
        Column::text("mode", "how it is rendered", modes.iter().map(|m| Some(m.label.clone()))),
        volts("motor_max_v", "highest motor voltage used", |m| m.motor_max_v),
        volts("brake_max_v", "highest brake voltage used", |m| m.brake_max_v),
        Column::text("compressing", "what acts while compressing", word(0)),
        Column::float("compressing_max_n", "N", "its largest force against the push", most(0)),
        Column::text("decompressing", "what acts while holding or decompressing", word(1)),
        Column::float("decompressing_max_n", "N", "its largest force", most(1)),
    ];
    Ok(Table::new("modes", "Motor and brake as each mode uses them", columns)?.with_note(footnote))
}

/// A brake acts against the motion alone: on the way back that is not the force of a spring.
fn on_way(drive: ActuatorKind, way: usize) -> &'static str {
    if drive == ActuatorKind::Brake && way == 1 {
        "brake, against the return"
    } else {
        drive.as_str()
    }
}

/// The device and its control loop, as `study.toml` has them.
///
/// # Errors
/// A number that is not finite.
pub fn device_table(study: &Setup) -> Result<Table, TableError> {
    let (device, control) = (&study.device, &study.control);
    let factor = shown_unit("rad", study.coordinate).1;
    let unit = match study.coordinate {
        Coordinate::Rotational => "°",
        Coordinate::Linear { .. } => "mm",
    };
    let end = |what, angle: Option<f64>| Fact::new(what, angle.map(|angle| factor * angle), unit);
    let mut facts = vec![
        Fact::new("lever length, axis to finger", device.lever_m.map(|m| m * 1e3), "mm"),
        end("work space, lower end", device.theta_min_rad),
        end("work space, upper end", device.theta_max_rad),
        Fact::new("new values of the force sensor", device.force_rate_hz, "Hz"),
        Fact::new("tick of the control loop", Some(1e3 / control.rate_hz), "ms"),
        Fact::new("user force below which the brake lets go", Some(control.let_go_n), "N"),
        Fact::new("limit of the force on a finger", Some(control.force_limit_n), "N"),
        velocity(control.velocity),
    ];
    if let Some(masses) = study.masses {
        facts.push(Fact::new("motor, mass", Some(masses.motor_kg * 1e3), "g"));
        facts.push(Fact::new("brake, mass", Some(masses.brake_kg * 1e3), "g"));
    }
    let Resistances { motor_ohm, brake_ohm } = study.resistances;
    let ohms = [("motor, resistance", motor_ohm), ("brake, resistance", brake_ohm)];
    facts.extend(
        ohms.into_iter().filter(|o| o.1.is_some()).map(|(what, r)| Fact::new(what, r, "Ω")),
    );
    facts::table("device", &format!("Device: {}", study.device.name), &facts)
}

fn velocity(filter: VelocityFilter) -> Fact {
    match filter {
        VelocityFilter::Difference => Fact::new("velocity from angles", None, "")
            .remarked("difference of the last two angles"),
        VelocityFilter::SecondOrder { cutoff_hz } => {
            Fact::new("velocity from angles", Some(cutoff_hz), "Hz")
                .remarked("differentiator with a second-order low-pass; its cut-off")
        }
    }
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
        let table = modes_table(&study(), &Calibration::thesis(), "from the thesis").unwrap();
        assert_eq!(table.floats("compressing_max_n").unwrap(), [4.16, 13.0, 13.0].map(Some));
        assert_eq!(table.floats("decompressing_max_n").unwrap(), [4.16, 13.0, 2.08].map(Some));
        let back = table.texts("decompressing").unwrap();
        assert_eq!(
            back,
            ["motor", "brake, against the return", "motor"].map(|w| Some(w.to_owned()))
        );
        assert_eq!(table.notes(), ["from the thesis"]);
    }

    #[test]
    fn the_device_stands_in_millimetres_degrees_and_grams_and_what_is_unknown_is_null() {
        let mut study = study();
        study.device.lever_m = None;
        study.device.theta_min_rad = Some(-std::f64::consts::FRAC_PI_4);
        let table = device_table(&study).unwrap();
        let values = table.floats("value").unwrap();
        assert_eq!((values[0], values[1]), (None, Some(-45.0)));
        assert_eq!(values[4], Some(1.0), "1 kHz, the default");
        study.masses = None;
        study.resistances = Resistances::default();
        assert_eq!(device_table(&study).unwrap().height(), 8);
    }
}
