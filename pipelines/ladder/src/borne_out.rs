//! Whether recordings bear the choices of a study out, as tables.

use crate::held_out::{HeldOut, Knobs, Role, Tried};
use crate::terms::TermSet;
use zwidth_study::Perception;
use zwidth_tables::{Column, Table, TableError};

/// The table of one condition, and that of a study.
const NAME: &str = "ladder";
const TITLE: &str = "Ladder: the model each condition needs, on trials it was not fitted to";
const NOTES: [&str; 3] = [
    "Every second trial of a condition is fitted; the others are predicted from their recorded force, and their error is given.",
    "Without a term: the choice without it, fitted anew. The term is missed if that predicts worse.",
    "Confirmed: neither the fullest model nor the choice without a term has an error smaller by more than a tenth.",
];
/// An error is another one if it is smaller by more than this share. Assumed: half of a condition's
/// repeats do not tell finer ones apart.
const SMALLER: f64 = 0.1;

/// Models held against a condition's trials, one row a model.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn held_out_table(
    condition: &str,
    rows: &[Tried],
    trials: usize,
    bounds: &Perception,
) -> Result<Table, TableError> {
    let text = |name, about, get: &dyn Fn(&Tried) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let number = |name, unit, about, get: &dyn Fn(&HeldOut) -> f64| {
        let finite = |row: &Tried| Some(get(&row.held_out)).filter(|x| x.is_finite());
        Column::float(name, unit, about, rows.iter().map(finite))
    };
    let columns = vec![
        text("condition", "environment and mode", &|_| condition.to_owned()),
        text("model", "the choice of the ladder, it without a term, or the fullest", &|row| {
            row.role.words()
        }),
        text("terms", "its terms; rigid for none", &|row| row.held_out.set.words()),
        Column::integer(
            "trials",
            "1",
            "how many trials there are; every second one is fitted",
            rows.iter().map(|_| Some(trials as i64)),
        ),
        number("inertia_factor", "1", "fitted inertia over the simulated device's", &|r| {
            r.knobs.inertia
        }),
        number("dry_factor", "1", "fitted dry friction over its", &|r| r.knobs.dry),
        number("viscous_factor", "1", "fitted viscous friction over its", &|r| r.knobs.viscous),
        number("brake_lag_factor", "1", "fitted lags of the brake over its", &|r| {
            r.knobs.brake_lag
        }),
        number("weight_factor", "1", "fitted weight over the middle of its range", &|r| {
            r.knobs.weight
        }),
        number(
            "fitted_rmse_rad",
            "rad",
            "error of the angle on the trials it was fitted to; null where it does not run",
            &|r| r.fitted_rad,
        ),
        number("held_out_rmse_rad", "rad", "error of the angle on the others", &|r| r.held_out_rad),
        number("felt_share", "1", "that over the angle that is just felt", &|r| {
            r.held_out_rad / bounds.angle_rad
        }),
    ];
    noted(Table::new(NAME, TITLE, columns)?)
}

fn noted(table: Table) -> Result<Table, TableError> {
    Ok(NOTES.into_iter().fold(table, |table, note| table.with_note(note)))
}

/// One row per condition: the choice, how well it and the fullest model predict, the terms that are
/// least and most missed, and whether the recordings bear it out. `tables` are of
/// [`held_out_table`]; one without rows is left out.
///
/// # Errors
/// Tables that are not of it.
pub fn join_held_out(tables: &[Table]) -> Result<Table, TableError> {
    let mut rows = Vec::new();
    for table in tables {
        rows.extend(Condition::of(read(table)?));
    }
    let text = |name, about, get: &dyn Fn(&Condition) -> Option<String>| {
        Column::text(name, about, rows.iter().map(get))
    };
    let number = |name, unit, about, get: &dyn Fn(&Condition) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let term = |row: Option<&Row>| row.and_then(Row::term).map(str::to_owned);
    let error = |row: Option<&Row>| row.and_then(|row| row.held_out_rad);
    let columns = vec![
        text("condition", "environment and mode", &|c| Some(c.choice.condition.clone())),
        text("terms", "the terms of the choice; rigid for none", &|c| Some(c.choice.terms.clone())),
        Column::integer(
            "trials",
            "1",
            "how many trials there are; every second one is fitted",
            rows.iter().map(|c| c.choice.trials),
        ),
        number("fitted_rmse_rad", "rad", "its error on the trials it was fitted to", &|c| {
            c.choice.fitted_rad
        }),
        number("held_out_rmse_rad", "rad", "its error on the others", &|c| c.choice.held_out_rad),
        number("felt_share", "1", "that over the angle that is just felt", &|c| {
            c.choice.felt_share
        }),
        number("fullest_rmse_rad", "rad", "the fullest model's error on them", &|c| {
            error(c.fullest.as_ref())
        }),
        text("least_missed", "the term without which it predicts best", &|c| term(c.less.first())),
        number("least_missed_rmse_rad", "rad", "its error without that", &|c| {
            error(c.less.first())
        }),
        text("most_missed", "the term without which it predicts worst", &|c| term(c.less.last())),
        number("most_missed_rmse_rad", "rad", "its error without that", &|c| error(c.less.last())),
        text("recordings", "whether they bear the choice out", &|c| c.verdict()),
    ];
    noted(Table::new(NAME, TITLE, columns)?)
}

/// A row of [`held_out_table`].
#[derive(Debug, Clone)]
struct Row {
    condition: String,
    model: String,
    terms: String,
    trials: Option<i64>,
    fitted_rad: Option<f64>,
    held_out_rad: Option<f64>,
    felt_share: Option<f64>,
}

impl Row {
    /// The term that it is without.
    fn term(&self) -> Option<&str> {
        self.model.strip_prefix("without ")
    }

    /// Where nothing was predicted, or it does not run, it is the last.
    fn error(&self) -> f64 {
        self.held_out_rad.unwrap_or(f64::INFINITY)
    }
}

/// What was tried on a condition.
struct Condition {
    choice: Row,
    fullest: Option<Row>,
    /// Without a term, the best first.
    less: Vec<Row>,
}

impl Condition {
    fn of(rows: Vec<Row>) -> Option<Self> {
        let find = |role: Role| rows.iter().find(|row| row.model == role.words()).cloned();
        let mut less: Vec<Row> = rows.iter().filter(|row| row.term().is_some()).cloned().collect();
        less.sort_by(|a, b| a.error().total_cmp(&b.error()));
        Some(Self { choice: find(Role::Choice)?, fullest: find(Role::Fullest), less })
    }

    /// None where there was one trial, and nothing to predict.
    fn verdict(&self) -> Option<String> {
        let own = self.choice.held_out_rad?;
        let better = |row: &&Row| row.error() < (1.0 - SMALLER) * own;
        let less = self.less.first().filter(better).and_then(Row::term);
        let fuller = self.fullest.as_ref().filter(better);
        Some(match (less, fuller) {
            (Some(term), _) => format!("better without {}", term.replace('_', " ")),
            (None, Some(_)) => "the fullest is better".to_owned(),
            (None, None) => "confirmed".to_owned(),
        })
    }
}

fn read(table: &Table) -> Result<Vec<Row>, TableError> {
    let text = |name| -> Result<Vec<String>, TableError> {
        Ok(table.texts(name)?.into_iter().map(Option::unwrap_or_default).collect())
    };
    let (conditions, models, terms) = (text("condition")?, text("model")?, text("terms")?);
    let (trials, fitted) = (table.integers("trials")?, table.floats("fitted_rmse_rad")?);
    let (held_out, felt) = (table.floats("held_out_rmse_rad")?, table.floats("felt_share")?);
    let row = |i: usize| Row {
        condition: conditions[i].clone(),
        model: models[i].clone(),
        terms: terms[i].clone(),
        trials: trials[i],
        fitted_rad: fitted[i],
        held_out_rad: held_out[i],
        felt_share: felt[i],
    };
    Ok((0..table.height()).map(row).collect())
}

/// The choice of a table of held-out errors, and what was fitted; `None` where nothing was.
///
/// # Errors
/// A table that is not of [`held_out_table`].
pub fn fitted(table: &Table) -> Result<Option<(TermSet, Knobs)>, TableError> {
    let rows = read(table)?;
    let choice = Role::Choice.words();
    let Some(at) = rows.iter().position(|row| row.model == choice) else { return Ok(None) };
    let factor = |name| -> Result<f64, TableError> {
        Ok(table.floats(name)?.get(at).copied().flatten().unwrap_or(1.0))
    };
    let knobs = Knobs {
        inertia: factor("inertia_factor")?,
        dry: factor("dry_factor")?,
        viscous: factor("viscous_factor")?,
        brake_lag: factor("brake_lag_factor")?,
        weight: factor("weight_factor")?,
    };
    Ok(TermSet::of_words(&rows[at].terms).map(|set| (set, knobs)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::LadderTerm;

    const CHOICE: TermSet = TermSet::NONE.with(LadderTerm::Friction).with(LadderTerm::BrakeLag);

    fn row(role: Role, set: TermSet, held_out_rad: f64) -> Tried {
        let knobs = Knobs { weight: 0.5, ..Knobs::USUAL };
        Tried { role, held_out: HeldOut { set, knobs, fitted_rad: 0.01, held_out_rad } }
    }

    /// Held-out errors of the choice, without friction, without the brake's lag, of the fullest.
    fn of(errors: [f64; 4]) -> Table {
        let [friction, lag] = [LadderTerm::Friction, LadderTerm::BrakeLag];
        let rows = [
            row(Role::Choice, CHOICE, errors[0]),
            row(Role::Without(friction), CHOICE.without(friction), errors[1]),
            row(Role::Without(lag), CHOICE.without(lag), errors[2]),
            row(Role::Fullest, TermSet::ALL, errors[3]),
        ];
        held_out_table("spring hybrid", &rows, 6, &Perception::default()).unwrap()
    }

    fn joined(errors: [f64; 4], column: &str) -> Option<String> {
        join_held_out(&[of(errors)]).unwrap().texts(column).unwrap()[0].clone()
    }

    #[test]
    fn a_choice_that_nothing_betters_by_a_tenth_is_confirmed() {
        let errors = [0.02, 0.09, 0.019, 0.0185];
        assert_eq!(joined(errors, "recordings").as_deref(), Some("confirmed"));
        assert_eq!(joined(errors, "least_missed").as_deref(), Some("brake_lag"));
        assert_eq!(joined(errors, "most_missed").as_deref(), Some("friction"));
    }

    #[test]
    fn a_term_that_the_recordings_do_not_want_is_named_before_the_fullest() {
        let verdict = |errors| joined(errors, "recordings");
        assert_eq!(verdict([0.02, 0.09, 0.01, 0.01]).as_deref(), Some("better without brake lag"));
        assert_eq!(verdict([0.02, 0.09, 0.03, 0.01]).as_deref(), Some("the fullest is better"));
        assert_eq!(verdict([f64::INFINITY; 4]), None);
    }

    #[test]
    fn what_was_fitted_is_read_back_for_the_replays() {
        let (set, knobs) = fitted(&of([0.02; 4])).unwrap().unwrap();
        assert_eq!((set, knobs), (CHOICE, Knobs { weight: 0.5, ..Knobs::USUAL }));
        let share = of([0.02; 4]).floats("felt_share").unwrap()[0].unwrap();
        assert!((share - 0.02_f64.to_degrees() / 2.0).abs() < 1e-12);
    }
}
