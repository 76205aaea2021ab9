//! The replays as a table: SI units, one row per trial and causality.

use crate::{Comparison, ReplayError, TrialReplay, VelocityError};
use zwidth_study::Source;
use zwidth_tables::{Column, Table, TableError, identity, of_trials};

const NAME: &str = "replay";
const TITLE: &str = "Replay: recorded trials through the model";

/// Which comparisons a column is for.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// All.
    Any,
    /// Those of θ.
    Angle,
    /// Those of F_ex.
    Force,
}

type Get = fn(&Comparison) -> Option<f64>;
type Spec = (&'static str, &'static str, &'static str, Of, Get);

#[rustfmt::skip]
const COLUMNS: [Spec; 11] = [
    ("nrmse", "1", "root mean square error over the recording's range", Of::Any, |c| c.nrmse),
    ("vaf", "1", "variance accounted for: 1 - var(error) / var(recording)", Of::Any, |c| c.vaf),
    ("lag_s", "s", "by how much the model comes later, where the cross-correlation is highest", Of::Any, |c| c.lag_s),
    ("rmse_rad", "rad", "root mean square error of the angle", Of::Angle, |c| Some(c.rmse)),
    ("rmse_n", "N", "root mean square error of the force", Of::Force, |c| Some(c.rmse)),
    ("peak_recorded_rad", "rad", "largest recorded angle", Of::Angle, |c| Some(c.peak_recorded)),
    ("peak_error_rad", "rad", "the model's largest angle less it", Of::Angle, |c| Some(c.peak_error)),
    ("peak_recorded_n", "N", "largest recorded force", Of::Force, |c| Some(c.peak_recorded)),
    ("peak_error_n", "N", "the model's largest force less it", Of::Force, |c| Some(c.peak_error)),
    ("peak_time_recorded_s", "s", "first time of the recording's largest angle or force", Of::Any, |c| Some(c.peak_time_recorded_s)),
    ("peak_time_error_s", "s", "that of the model less it", Of::Any, |c| Some(c.peak_time_error_s)),
];

type GetVelocity = fn(&VelocityError) -> Option<f64>;

#[rustfmt::skip]
const VELOCITIES: [(&str, &str, &str, GetVelocity); 3] = [
    ("velocity_rmse_rad_s", "rad/s", "root mean square error of the velocity", |v| Some(v.rmse_rad_s)),
    ("velocity_nrmse", "1", "that over the recorded velocity's range", |v| v.nrmse),
    ("velocity_sd_ratio", "1", "SD of the model's velocity over that of the recorded one", |v| v.sd_ratio),
];

/// One row per trial and causality, in the order given: which trial, what went in, what came of it,
/// the plant, and how far the model departs. Null where it does not apply, and for a model that
/// diverged: the column `outcome` says which.
///
/// # Errors
/// A number that is not finite.
pub fn table(rows: &[TrialReplay]) -> Result<Table, ReplayError> {
    let mut columns = identity(&rows.iter().map(|r| &r.meta).collect::<Vec<_>>());
    let text = |name, description, get: fn(&TrialReplay) -> &'static str| {
        Column::text(name, description, rows.iter().map(|r| Some(get(r).to_owned())))
    };
    let number = |name, unit, description, get: fn(&TrialReplay) -> Option<f64>| {
        Column::float(name, unit, description, rows.iter().map(get))
    };
    columns.push(text("causality", "what went into the model and what came out", |r| {
        r.causality.as_str()
    }));
    columns.push(text("model", "whose plant: by_eye, the thesis'; fitted, this study's", |r| {
        r.which.as_str()
    }));
    columns.push(text("outcome", "replayed, diverged, or why it does not apply", |r| {
        r.outcome.as_str()
    }));
    columns.extend([
        number("mass_kg", "kg", "the model's mass at the lever's end", |r| {
            Some(r.parameters.mass_kg)
        }),
        number("damping_n_s_per_rad", "N·s/rad", "the model's viscous damping there", |r| {
            Some(r.parameters.damping_ns_per_rad)
        }),
        number("friction_n", "N", "the model's dry friction there", |r| {
            Some(r.parameters.friction_n)
        }),
    ]);
    for (name, unit, description, of, get) in COLUMNS {
        let value =
            |row: &TrialReplay| row.comparison.as_ref().filter(|_| applies(of, row)).and_then(get);
        columns.push(Column::float(name, unit, description, rows.iter().map(value)));
    }
    for (name, unit, description, get) in VELOCITIES {
        let value = |row: &TrialReplay| row.velocity.as_ref().and_then(get);
        columns.push(Column::float(name, unit, description, rows.iter().map(value)));
    }
    columns.extend([
        number(
            "reversal_recorded_s",
            "s",
            "first time of the recording's largest angle, onset to end",
            |r| r.reversal_recorded_s,
        ),
        number("reversal_error_s", "s", "that of the model less it", |r| r.reversal_error_s),
    ]);
    Ok(Table::new(NAME, TITLE, columns)?)
}

/// The replays of several conditions as one table in the order of participant, session and trial,
/// of a trial in that of the tables; `None` without tables.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_conditions(conditions: Vec<Table>) -> Result<Option<Table>, ReplayError> {
    let Some(all) = of_trials(NAME, TITLE, conditions)? else { return Ok(None) };
    Ok(Some(match own_model(&all)? {
        Some(note) => all.with_note(note),
        None => all,
    }))
}

/// What is to be said of trials that a model of the same equations made.
pub(crate) fn own_model(replays: &Table) -> Result<Option<String>, TableError> {
    let sources = replays.texts("source")?;
    let simulated = sources.iter().flatten().any(|source| source == Source::Twin.as_str());
    Ok(simulated.then(|| OWN_MODEL.to_owned()))
}

/// Of simulated trials and this model.
pub(crate) const OWN_MODEL: &str = "Simulated trials: the twin that made them and the model have the same \
    equations for lever, friction, actuators and lags (the twin has a hand, ticks and sensors besides). A fitted \
    model that lies on them says that identification works, not that the model is true to a prototype.";

fn applies(of: Of, row: &TrialReplay) -> bool {
    let force = row.causality == crate::Causality::PositionDriven;
    of == Of::Any || force == (of == Of::Force)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};
    use crate::{Parameters, Which, replay};
    use zwidth_study::Analysis;

    fn rows() -> Vec<TrialReplay> {
        let trial = simulated("hybrid", &Parameters::BY_EYE);
        replay(
            &trial,
            &rendering("hybrid"),
            &Analysis::default(),
            (Which::ByEye, &Parameters::BY_EYE),
        )
        .unwrap()
    }

    #[test]
    fn each_causality_has_its_row_and_the_units_of_what_came_out() {
        let table = table(&rows()).unwrap();
        let words: Vec<_> = table.texts("causality").unwrap().into_iter().flatten().collect();
        assert_eq!(words, ["force_driven", "position_driven", "closed_loop"]);
        let there =
            |column| table.floats(column).unwrap().iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(there("rmse_rad"), [true, false, true]);
        assert_eq!(there("peak_error_n"), [false, true, false]);
        assert_eq!(there("vaf"), [true; 3]);
        assert_eq!(there("velocity_rmse_rad_s"), [true, false, true]);
    }

    #[test]
    fn a_model_that_diverged_is_a_word_and_nulls() {
        let row =
            TrialReplay { outcome: crate::Outcome::Diverged, comparison: None, ..rows().remove(0) };
        let table = table(&[row]).unwrap();
        assert_eq!(table.texts("outcome").unwrap(), [Some("diverged".to_owned())]);
        assert_eq!(table.floats("vaf").unwrap(), [None]);
    }

    /// `docs/analysis.md` is the page on which a reader looks a column up.
    #[test]
    fn every_column_is_defined_on_the_page_about_the_analysis() {
        let page = include_str!("../../../docs/analysis.md");
        let identity = identity(&[]).len();
        for field in table(&[]).unwrap().fields().skip(identity) {
            assert!(page.contains(&format!("`{}`", field.name)), "{} is not defined", field.name);
        }
    }
}
