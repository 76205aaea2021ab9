//! The thesis' Table 4: the parts of the device, as far as the study names them.

use zwidth_results::Component;
use zwidth_study::{Coordinate, Setup};

/// The parts of the device, one row per component, with its function and what `study.toml` says
/// about it.
pub fn components(study: &Setup) -> Vec<Component> {
    let part = |component: &str, function: &str| Component {
        component: component.to_owned(),
        function: function.to_owned(),
        voltage_max_v: None,
        mass_kg: None,
        resistance_ohm: None,
        rate_hz: None,
    };
    let motor = study.motor_max_v().map(|volts| Component {
        voltage_max_v: Some(volts),
        mass_kg: study.masses.map(|masses| masses.motor_kg),
        resistance_ohm: study.resistances.motor_ohm,
        ..part("motor", "drives and resists")
    });
    let brake = study.brake_max_v().map(|volts| Component {
        voltage_max_v: Some(volts),
        mass_kg: study.masses.map(|masses| masses.brake_kg),
        resistance_ohm: study.resistances.brake_ohm,
        ..part("brake", "resists")
    });
    let position = match study.coordinate {
        Coordinate::Rotational => part("angle sensor", "measures the lever's angle"),
        Coordinate::Linear { .. } => part("position sensor", "measures where the slide is"),
    };
    let force = Component {
        rate_hz: study.device.force_rate_hz,
        ..part("force sensor", "measures the user's force")
    };
    let control = Component {
        rate_hz: Some(study.control.rate_hz),
        ..part("control loop", "turns angle and force into voltages")
    };
    motor.into_iter().chain(brake).chain([position, force, control]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Resistances;

    #[test]
    fn every_component_has_what_the_study_knows_of_it() {
        let mut study = Setup::of(&zwidth_testing::study());
        study.resistances = Resistances { motor_ohm: Some(30.4), brake_ohm: None };
        let all = components(&study);
        let of = |name: &str| all.iter().find(|of| of.component == name).unwrap();
        assert_eq!(of("motor").voltage_max_v, Some(16.0));
        assert_eq!(of("brake").voltage_max_v, Some(8.0));
        assert_eq!(of("motor").resistance_ohm, Some(30.4));
        assert_eq!(of("brake").resistance_ohm, None);
        assert_eq!(of("control loop").rate_hz, Some(study.control.rate_hz));
    }

    #[test]
    fn what_is_known_of_no_component_has_no_column_and_what_no_mode_uses_no_row() {
        let mut study = Setup::of(&zwidth_testing::study());
        (study.masses, study.resistances) = (None, Resistances::default());
        for mode in &mut study.modes {
            mode.brake_max_v = None;
        }
        let all = components(&study);
        let table = zwidth_tables::Table::of_rows(&all).unwrap().without_empty_columns();
        let columns: Vec<String> = table.fields().map(|field| field.name.to_string()).collect();
        assert_eq!(columns, ["component", "function", "voltage_max_v", "rate_hz"]);
        assert_eq!(table.height(), 4, "motor, two sensors, control loop");
    }
}
