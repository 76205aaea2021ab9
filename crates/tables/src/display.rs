//! From the units of files to the units of screens.

use crate::unit::{self, Conversion};
use crate::{Column, Field, Table, TableError, UNIT_OF_ROW, Values};
use zwidth_study::Coordinate;

/// A table whose every torque is smaller than this, N·m, speaks of mN·m.
const SMALL_TORQUE_NM: f64 = 0.1;
const TORQUE: &str = "N·m";

/// The table as people read it: other units, and names that follow them; descriptions, title and
/// notes stay.
///
/// | in the table | lever ([`Coordinate::Rotational`]) | slide ([`Coordinate::Linear`], x = L θ) |
/// |---|---|---|
/// | `theta_max_rad` rad | `theta_max_deg` ° | `x_max_mm` mm, × 1000 L |
/// | `theta_dot_rad_s` rad/s | `theta_dot_deg_s` °/s | `x_dot_mm_s` mm/s, × 1000 L |
/// | `slope_n_per_rad` N/rad | as it is | `slope_n_per_mm` N/mm, ÷ 1000 L |
/// | N·s/rad, N·s²/rad | as they are | N·s/mm, N·s²/mm, ÷ 1000 L |
/// | `torque_nm` N·m | mN·m if every torque of the table is below 0.1 N·m | likewise |
///
/// A column whose rows have units of their own ([`UNIT_OF_ROW`]) is converted row by row, and what
/// the column `unit` says with it.
///
/// Everything else is left alone: pure numbers, texts, yes and no, whole numbers, and all other
/// units. The torques of a table are decided on together, so that an estimate and its standard
/// error keep one unit.
///
/// # Errors
/// A lever length that makes a value infinite, or two columns that would get one name.
pub fn for_people(table: &Table, coordinate: Coordinate) -> Result<Table, TableError> {
    let columns = rows_converted(table, coordinate);
    let mut torques = columns.iter().filter(|c| c.field.unit == TORQUE);
    let torques_small = torques.all(|c| match &c.values {
        Values::Float(values) => values.iter().flatten().all(|v| v.abs() < SMALL_TORQUE_NM),
        _ => true,
    });
    let columns = columns.into_iter().map(|c| converted(c, coordinate, torques_small)).collect();
    let shown = Table::new(table.name(), &in_coordinate(table.title(), coordinate), columns)?;
    let notes = table.notes_by_kind();
    Ok(shown.with_notes(notes.map(|(kind, note)| (kind, in_coordinate(note, coordinate)))))
}

/// Words about an angle as those of a slide's displacement, in a linear study.
pub fn in_coordinate(text: &str, coordinate: Coordinate) -> String {
    match coordinate {
        Coordinate::Rotational => text.to_owned(),
        Coordinate::Linear { .. } => text.replace("angle", "displacement").replace('θ', "x"),
    }
}

/// Columns whose every row has its own unit, in the units for people: the column `unit` names them.
fn rows_converted(table: &Table, coordinate: Coordinate) -> Vec<Column> {
    let mut columns = table.columns().to_vec();
    let is_of_rows =
        |c: &Column| c.field.unit == UNIT_OF_ROW && matches!(c.values, Values::Float(_));
    let Some(units) = table.texts("unit").ok().filter(|_| columns.iter().any(is_of_rows)) else {
        return columns;
    };
    let conversions: Vec<Option<Conversion>> =
        units.iter().map(|unit| unit::for_people(unit.as_deref()?, coordinate)).collect();
    for Column { field, values } in &mut columns {
        match values {
            Values::Float(values) if field.unit == UNIT_OF_ROW => {
                for (value, conversion) in values.iter_mut().zip(&conversions) {
                    let factor = conversion.as_ref().map_or(1.0, |(_, factor)| *factor);
                    *value = value.map(|value| value * factor);
                }
            }
            Values::Text(texts) if field.name == "unit" => {
                for (text, conversion) in texts.iter_mut().zip(&conversions) {
                    if let Some((unit, _)) = conversion {
                        *text = Some(unit.clone().into());
                    }
                }
            }
            _ => {}
        }
    }
    columns
}

fn converted(column: Column, coordinate: Coordinate, torques_small: bool) -> Column {
    let conversion = match column.field.unit == TORQUE && torques_small {
        true => Some(unit::small_torque()),
        false => unit::for_people(&column.field.unit, coordinate),
    };
    let Some((unit, factor)) = conversion else { return column };
    let Values::Float(values) = column.values else { return column };
    let values = values.into_iter().map(|v| v.map(|v| v * factor)).collect();
    let field = column.field;
    let (stem, suffix) = unit::stem(&field.name, &field.unit);
    let linear = field.unit.starts_with("rad") && unit.starts_with("mm");
    let stem = if linear { theta_to_x(stem) } else { stem.to_owned() };
    // The lists of both units are made alike: `_per_s` stays `_per_s`, and does not become `_s`.
    let suffix = suffix.map(|i| unit::suffixes(&unit).swap_remove(i)).unwrap_or_default();
    let field = Field { name: (stem + &suffix).into(), unit: unit.into(), ..field };
    Column { field, values: Values::Float(values) }
}

pub(crate) fn theta_to_x(stem: &str) -> String {
    stem.split('_')
        .map(|word| if word == "theta" { "x" } else { word })
        .collect::<Vec<_>>()
        .join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: Coordinate = Coordinate::Linear { lever_m: 0.05 };

    fn check(
        column: (&'static str, &'static str, f64),
        coordinate: Coordinate,
        expect: (&str, &str, f64),
    ) {
        let (name, unit, value) = column;
        let column = Column::float(name, unit, "what it is", [Some(value), None]);
        let table = Table::new("t", "T", vec![column]).unwrap();
        let shown = for_people(&table.with_note("a note"), coordinate).unwrap();
        let field = shown.fields().next().unwrap();
        assert_eq!((field.name.as_ref(), field.unit.as_ref()), (expect.0, expect.1));
        assert_eq!(
            (field.description.as_ref(), shown.notes()),
            ("what it is", ["a note".to_owned()].as_slice())
        );
        let values = shown.floats(expect.0).unwrap();
        assert!((values[0].unwrap() - expect.2).abs() < 1e-12 * expect.2.abs(), "{values:?}");
        assert_eq!(values[1], None);
    }

    #[test]
    fn rows_with_units_of_their_own_are_read_each_in_its_own() {
        let columns = vec![
            Column::text("unit", "", ["rad", "N"].map(Some)),
            Column::float("bias", UNIT_OF_ROW, "", [Some(std::f64::consts::PI), Some(2.0)]),
            Column::float("share", "1", "", [Some(0.5), None]),
        ];
        let table = Table::new("t", "", columns).unwrap();
        let of = |coordinate| {
            let shown = for_people(&table, coordinate).unwrap();
            let units: Vec<_> = shown.texts("unit").unwrap().into_iter().flatten().collect();
            assert_eq!(shown.floats("share").unwrap(), [Some(0.5), None]);
            (units, shown.floats("bias").unwrap())
        };
        assert_eq!(
            of(Coordinate::Rotational),
            (vec!["°".to_owned(), "N".to_owned()], vec![Some(180.0), Some(2.0)])
        );
        let (units, values) = of(Coordinate::Linear { lever_m: 0.05 });
        assert_eq!(units, ["mm", "N"]);
        assert!((values[0].unwrap() - 50.0 * std::f64::consts::PI).abs() < 1e-12, "{values:?}");
    }

    #[test]
    fn a_lever_is_read_in_degrees_and_its_stiffness_in_newtons_per_radian() {
        let turn = Coordinate::Rotational;
        check(("theta_max_rad", "rad", std::f64::consts::PI), turn, ("theta_max_deg", "°", 180.0));
        check(
            ("theta_dot_rad_s", "rad/s", 1.0),
            turn,
            ("theta_dot_deg_s", "°/s", 57.295_779_513_082_32),
        );
        check(
            ("theta_ddot_rad_s2", "rad/s²", 1.0),
            turn,
            ("theta_ddot_deg_s2", "°/s²", 57.295_779_513_082_32),
        );
        check(("slope_n_per_rad", "N/rad", 4.0), turn, ("slope_n_per_rad", "N/rad", 4.0));
    }

    #[test]
    fn a_slide_is_read_in_millimetres() {
        check(("theta_max_rad", "rad", 0.2), LINEAR, ("x_max_mm", "mm", 10.0));
        check(("theta_dot_peak_rad_s", "rad/s", 2.0), LINEAR, ("x_dot_peak_mm_s", "mm/s", 100.0));
        check(
            ("slope_ci_low_n_per_rad", "N/rad", 100.0),
            LINEAR,
            ("slope_ci_low_n_per_mm", "N/mm", 2.0),
        );
        check(("damping_ns_per_rad", "N·s/rad", 5.0), LINEAR, ("damping_ns_per_mm", "N·s/mm", 0.1));
        check(("onset_rad", "rad", 0.2), LINEAR, ("onset_mm", "mm", 10.0));
        check(("loop_area_j", "J", 0.3), LINEAR, ("loop_area_j", "J", 0.3));
    }

    #[test]
    fn the_name_follows_its_unit_only_where_it_carried_one() {
        check(("angle", "rad", 1.0), LINEAR, ("angle", "mm", 50.0));
    }

    #[test]
    fn torques_are_milli_only_if_all_of_the_table_are_small() {
        check(("torque_nm", "N·m", -0.04), LINEAR, ("torque_mnm", "mN·m", -40.0));
        check(("torque_nm", "N·m", 0.1), LINEAR, ("torque_nm", "N·m", 0.1));
        let columns = vec![
            Column::float("torque_nm", "N·m", "", [Some(0.2)]),
            Column::float("torque_std_error_nm", "N·m", "", [Some(0.001)]),
        ];
        let shown = for_people(&Table::new("t", "T", columns).unwrap(), LINEAR).unwrap();
        assert_eq!(shown.floats("torque_std_error_nm").unwrap(), [Some(0.001)]);
    }

    #[test]
    fn numbers_and_texts_are_untouched() {
        let columns = vec![
            Column::text("mode", "", [Some("rad".to_owned())]),
            Column::integer("trial", "1", "", [Some(3)]),
            Column::flag("wall_reached", "", [Some(true)]),
            Column::float("r2", "1", "", [Some(0.5)]),
        ];
        let table = Table::new("t", "T", columns).unwrap();
        assert_eq!(for_people(&table, LINEAR).unwrap().columns(), table.columns());
    }

    #[test]
    fn a_lever_without_length_is_an_error_and_no_infinity() {
        let column = Column::float("k_n_per_rad", "N/rad", "", [Some(1.0)]);
        let table = Table::new("t", "T", vec![column]).unwrap();
        assert!(for_people(&table, Coordinate::Linear { lever_m: 0.0 }).is_err());
    }
}
