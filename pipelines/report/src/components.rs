//! The thesis' Table 4: what the device is made of, as far as the study knows it.

use zwidth_study::{Coordinate, Mode, Setup};
use zwidth_tables::{Column, Table, TableError, Values};

/// One component and what is known of it.
#[derive(Debug, Clone, Copy, Default)]
struct Component {
    name: &'static str,
    function: &'static str,
    voltage_max_v: Option<f64>,
    mass_kg: Option<f64>,
    resistance_ohm: Option<f64>,
    rate_hz: Option<f64>,
}

/// What the device is made of, one row a component, with its function and what `study.toml` says of
/// it. A number that is not known of any of them has no column.
///
/// # Errors
/// A number that is not finite.
pub fn components_table(study: &Setup) -> Result<Table, TableError> {
    let rows = components(study);
    let text = |name, about, get: fn(&Component) -> &'static str| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let number = |name, unit, about, get: fn(&Component) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let known = |column: &Column| match &column.values {
        Values::Float(values) => values.iter().any(Option::is_some),
        _ => true,
    };
    let columns = vec![
        text("component", "what it is", |c| c.name),
        text("function", "what it does", |c| c.function),
        number("voltage_max_v", "V", "highest voltage that a mode uses", |c| c.voltage_max_v),
        number("mass_kg", "kg", "its mass", |c| c.mass_kg),
        number("resistance_ohm", "Ω", "resistance of its winding", |c| c.resistance_ohm),
        number("rate_hz", "Hz", "new values per second", |c| c.rate_hz),
    ];
    let columns = columns.into_iter().filter(known).collect();
    let title = format!("Components: {}", study.device.name);
    Ok(Table::new("components", &title, columns)?.with_note(
        "Boards, amplifier, driver and supply are left out, and so are makers and types: the study does \
         not know them.",
    ))
}

fn components(study: &Setup) -> Vec<Component> {
    let most = |of: fn(&Mode) -> Option<f64>| study.modes.iter().filter_map(of).reduce(f64::max);
    let motor = most(|mode| mode.motor_max_v).map(|volts| Component {
        name: "motor",
        function: "drives and resists",
        voltage_max_v: Some(volts),
        mass_kg: study.masses.map(|masses| masses.motor_kg),
        resistance_ohm: study.resistances.motor_ohm,
        rate_hz: None,
    });
    let brake = most(|mode| mode.brake_max_v).map(|volts| Component {
        name: "brake",
        function: "resists",
        voltage_max_v: Some(volts),
        mass_kg: study.masses.map(|masses| masses.brake_kg),
        resistance_ohm: study.resistances.brake_ohm,
        rate_hz: None,
    });
    motor.into_iter().chain(brake).chain(sensors(study)).collect()
}

fn sensors(study: &Setup) -> [Component; 3] {
    let position = match study.coordinate {
        Coordinate::Rotational => ("angle sensor", "measures the lever's angle"),
        Coordinate::Linear { .. } => ("position sensor", "measures where the slide is"),
    };
    let sensor =
        |(name, function), rate_hz| Component { name, function, rate_hz, ..Component::default() };
    [
        sensor(position, None),
        sensor(("force sensor", "measures the user's force"), study.device.force_rate_hz),
        sensor(
            ("control loop", "turns angle and force into voltages"),
            Some(study.control.rate_hz),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Resistances;

    #[test]
    fn every_component_has_what_the_study_knows_of_it() {
        let mut study = Setup::of(&zwidth_testing::study());
        study.resistances = Resistances { motor_ohm: Some(30.4), brake_ohm: None };
        let table = components_table(&study).unwrap();
        let names = table.texts("component").unwrap();
        let row = |name: &str| names.iter().position(|n| n.as_deref() == Some(name)).unwrap();
        let of = |column: &str, name: &str| table.floats(column).unwrap()[row(name)];
        assert_eq!(of("voltage_max_v", "motor"), Some(16.0));
        assert_eq!(of("voltage_max_v", "brake"), Some(8.0));
        assert_eq!(of("resistance_ohm", "motor"), Some(30.4));
        assert_eq!(of("resistance_ohm", "brake"), None);
        assert_eq!(of("rate_hz", "control loop"), Some(study.control.rate_hz));
    }

    #[test]
    fn what_is_known_of_no_component_has_no_column_and_what_no_mode_uses_no_row() {
        let mut study = Setup::of(&zwidth_testing::study());
        (study.masses, study.resistances) = (None, Resistances::default());
        for mode in &mut study.modes {
            mode.brake_max_v = None;
        }
        let table = components_table(&study).unwrap();
        let columns: Vec<String> = table.fields().map(|field| field.name.to_string()).collect();
        assert_eq!(columns, ["component", "function", "voltage_max_v", "rate_hz"]);
        assert_eq!(table.height(), 4, "motor, two sensors, control loop");
    }
}
