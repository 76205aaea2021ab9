//! The rows as a table: SI units, one row a trial.

use crate::Row;
use zwidth_tables::{Column, Table, TableError, identity};

/// Name, unit, meaning, and where the number stands in a row.
type Float = (&'static str, &'static str, &'static str, fn(&Row) -> Option<f64>);
/// Name, meaning, and where the count stands in a row.
type Count = (&'static str, &'static str, fn(&Row) -> Option<i64>);

const MOVEMENT: [Float; 9] = [
    ("onset_s", "s", "first time above the onset's velocity", |r| r.movement.onset_s),
    ("reversal_s", "s", "first time of the largest angle between onset and end", |r| r.movement.reversal_s),
    ("end_s", "s", "first time below the offset's velocity after the last above the onset's", |r| {
        r.movement.end_s
    }),
    ("duration_s", "s", "end minus onset", |r| r.movement.duration_s),
    ("theta_max_rad", "rad", "largest angle", |r| r.movement.theta_max_rad),
    ("velocity_forward_mean_rad_s", "rad/s", "mean speed, onset to reversal", |r| {
        r.movement.velocity_forward_mean_rad_s
    }),
    ("velocity_forward_peak_rad_s", "rad/s", "largest speed, onset to reversal", |r| {
        r.movement.velocity_forward_peak_rad_s
    }),
    ("velocity_backward_mean_rad_s", "rad/s", "mean speed, reversal to end", |r| {
        r.movement.velocity_backward_mean_rad_s
    }),
    ("velocity_backward_peak_rad_s", "rad/s", "largest speed, reversal to end", |r| {
        r.movement.velocity_backward_peak_rad_s
    }),
];

const HITS: [Count; 2] = [
    ("work_space_hits_low", "arrivals at the work space's lower end", |r| r.movement.work_space_hits_low),
    ("work_space_hits_high", "arrivals at the work space's upper end", |r| r.movement.work_space_hits_high),
];

const DISCREPANCY: [Float; 4] = [
    ("discrepancy_mean_n", "N", "compression minus decompression force, mean over the angle", |r| {
        r.discrepancy.mean_n
    }),
    ("discrepancy_max_n", "N", "compression minus decompression force, largest", |r| r.discrepancy.max_n),
    ("discrepancy_step_n", "N", "compression minus decompression force at the reversal", |r| {
        r.discrepancy.step_n
    }),
    ("loop_area_j", "J", "energy left in the device from onset to end", |r| r.discrepancy.loop_area_j),
];

const SPRING: [Float; 9] = [
    ("stiffness_n_per_rad", "N/rad", "rendered stiffness: slope of force on angle in compression", |r| {
        r.spring.stiffness_n_per_rad
    }),
    (
        "stiffness_std_error_n_per_rad",
        "N/rad",
        "its standard error (Newey-West, a tenth of the samples)",
        |r| r.spring.stiffness_std_error_n_per_rad,
    ),
    ("stiffness_ci_low_n_per_rad", "N/rad", "lower end of its interval within this trial", |r| {
        r.spring.stiffness_ci_low_n_per_rad
    }),
    ("stiffness_ci_high_n_per_rad", "N/rad", "upper end of its interval within this trial", |r| {
        r.spring.stiffness_ci_high_n_per_rad
    }),
    ("stiffness_error_n_per_rad", "N/rad", "rendered minus commanded stiffness", |r| {
        r.spring.stiffness_error_n_per_rad
    }),
    ("force_at_rest_n", "N", "the line's force at the spring's rest", |r| r.spring.force_at_rest_n),
    ("stiffness_r2", "1", "R² of the line", |r| r.spring.r2),
    ("force_rms_error_n", "N", "RMS of user force minus commanded force in compression", |r| {
        r.spring.force_rms_error_n
    }),
    ("returned_energy_share", "1", "work given back over work put in", |r| r.spring.returned_energy_share),
];

const STIFFNESS_SAMPLES: [Count; 1] =
    [("stiffness_samples", "samples of the stiffness fit", |r| r.spring.samples)];

const WALL: [Float; 6] = [
    ("wall_past_max_rad", "rad", "largest angle past the wall", |r| r.wall.past_max_rad),
    ("wall_depth_m", "m", "largest depth past the wall, at the lever", |r| r.wall.past_max_m),
    ("wall_dwell_s", "s", "time past the wall", |r| r.wall.dwell_s),
    ("wall_impulse_n_s", "N·s", "impulse of the user's force past the wall", |r| r.wall.impulse_n_s),
    ("wall_energy_j", "J", "energy the wall takes from the user", |r| r.wall.energy_j),
    ("wall_impact_velocity_rad_s", "rad/s", "velocity where the wall is first passed", |r| {
        r.wall.impact_velocity_rad_s
    }),
];

const REBOUNDS: [Count; 1] =
    [("wall_rebounds", "passings of the wall after a retreat from it", |r| r.wall.rebounds)];

/// One row a trial, in the order given: which trial it is, then every metric. SI units; null where a metric does
/// not apply or the recording lacks what it needs. The columns' definitions stand at the fields of [`Row`]'s parts.
///
/// # Errors
/// A metric that is not finite.
pub fn table(rows: &[Row]) -> Result<Table, TableError> {
    let mut columns = identity(&rows.iter().map(|r| &r.meta).collect::<Vec<_>>());
    columns.extend(floats(rows, &MOVEMENT));
    columns.extend(counts(rows, &HITS));
    columns.extend(floats(rows, &DISCREPANCY));
    columns.extend(floats(rows, &SPRING));
    columns.extend(counts(rows, &STIFFNESS_SAMPLES));
    columns.push(Column::flag(
        "wall_reached",
        "whether the wall was passed",
        rows.iter().map(|r| r.wall.reached),
    ));
    columns.extend(floats(rows, &WALL));
    columns.extend(counts(rows, &REBOUNDS));
    Table::new("metrics", "Metrics, one row a trial", columns)
}

fn floats(rows: &[Row], specs: &[Float]) -> Vec<Column> {
    let column = |&(name, unit, description, get): &Float| {
        Column::float(name, unit, description, rows.iter().map(get))
    };
    specs.iter().map(column).collect()
}

fn counts(rows: &[Row], specs: &[Count]) -> Vec<Column> {
    let column =
        |&(name, description, get): &Count| Column::integer(name, "1", description, rows.iter().map(get));
    specs.iter().map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, stroke, trial, wall_study};
    use crate::trial_metrics;

    #[test]
    fn a_column_ends_in_its_unit() {
        let endings = [
            ("s", "_s"),
            ("rad", "_rad"),
            ("rad/s", "_rad_s"),
            ("N", "_n"),
            ("J", "_j"),
            ("m", "_m"),
            ("N·s", "_n_s"),
            ("N/rad", "_n_per_rad"),
        ];
        let table = table(&[]).unwrap();
        for field in table.fields().iter().filter(|f| f.unit != "1") {
            let (_, ending) = endings.iter().find(|(unit, _)| *unit == field.unit).unwrap();
            assert!(field.name.ends_with(ending), "{}: {}", field.name, field.unit);
        }
    }

    #[test]
    fn a_row_lands_in_its_columns_and_what_does_not_apply_is_null() {
        let trial = trial(&stroke(1.0, 2.0), |theta, _| 4.0 * (theta - REST_RAD));
        let row = trial_metrics(&trial, &wall_study(4.0, REST_RAD, 3.0)).unwrap();
        let table = table(std::slice::from_ref(&row)).unwrap();
        assert_eq!(table.floats("stiffness_n_per_rad").unwrap(), [row.spring.stiffness_n_per_rad]);
        assert_eq!(table.flags("wall_reached").unwrap(), [Some(false)]);
        assert_eq!(table.floats("wall_dwell_s").unwrap(), [None]);
        assert_eq!(table.texts("mode").unwrap(), [Some("hybrid".to_owned())]);
    }
}
