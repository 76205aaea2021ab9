//! Runs of the model in sentences: which is cheap and could not be told from the right one, and
//! which terms a condition requires.

use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_dynamics::solver_label;
use zwidth_results::{LadderChoice, LadderCondition, TermSet};
use zwidth_study::{Setup, in_a_sentence};
use zwidth_tables::{Table, TableError, quantity};

/// The cheapest run of each scene of a study that a person could not tell from the right one, from
/// the table `trade_summary`: one sentence per scene. They speak of the model, not of trials.
///
/// # Errors
/// A table that lacks a column.
pub fn traded(study: &Setup, table: &Table) -> Result<Vec<Finding>, TableError> {
    let (scenes, solvers) = (table.texts("scene")?, table.texts("solver")?);
    let (steps, tolerances) = (table.floats("step_s")?, table.floats("tolerance")?);
    let work = table.integers("work")?;
    let (cheaper, why) = (table.texts("next_cheaper")?, table.texts("why_not")?);
    let proofs = table.texts("yardstick")?;
    let mut found = Vec::new();
    for (row, scene) in scenes.iter().enumerate() {
        let Some(scene) = scene else { continue };
        let text = match (&solvers[row], work[row], &proofs[row]) {
            (Some(solver), Some(work), _) => {
                let setting = setting(solver, steps[row], tolerances[row]);
                let not = cheaper[row].as_ref().zip(why[row].as_ref());
                let not = not.map(|(next, why)| {
                    format!(" The next cheaper run ({next}) is no such run: {why}.")
                });
                format!(
                    "{setting} is the cheapest run of the model that a person could not tell from the right one \
                     ({work} evaluations).{}",
                    not.unwrap_or_default()
                )
            }
            (.., Some(proof)) if proof.as_str() == UNPROVEN => {
                "no run of the model is known to be right: two solvers differ.".to_owned()
            }
            _ => "a person could tell each run of the model that was tried from the right one."
                .to_owned(),
        };
        let text = format!("{}: {text}", condition(study, scene, '.'));
        found.push(Finding { text, shown: Shown::Trade(scene.replace('.', "_")) });
    }
    Ok(found)
}

/// Which terms of the model each condition requires, and whether its recordings bear that out: one
/// sentence per condition.
pub fn laddered(study: &Setup, choices: &[LadderChoice]) -> Vec<Finding> {
    let one = |choice: &LadderChoice| {
        let needs = match choice.terms {
            TermSet::NONE => "a rigid lever without further terms is enough".to_owned(),
            terms => format!("the model requires {}", terms.titles()),
        };
        let missed = choice.held_out_rmse_rad.zip(choice.felt_share).map(|(rad, share)| {
            format!(
                "; trials that it was not fitted to it misses by {}, {} of what is just felt",
                quantity(rad, "rad", study.coordinate),
                quantity(share, "1", study.coordinate)
            )
        });
        let borne_out = choice.recordings.map(|verdict| format!("; by the recordings: {verdict}"));
        let text = format!(
            "{}: {needs}{}{}.",
            rendered(study, &choice.condition),
            missed.unwrap_or_default(),
            borne_out.unwrap_or_default()
        );
        Finding { text, shown: Shown::Ladder }
    };
    choices.iter().map(one).collect()
}

/// A condition in people's words: `Spring, active`.
fn rendered(study: &Setup, condition: &LadderCondition) -> String {
    let environment = study.environments.iter().find(|e| e.id == condition.environment);
    let mode = study.modes.iter().find(|m| m.id == condition.mode);
    match environment.zip(mode) {
        Some((environment, mode)) => {
            format!("{}, {}", environment.label, in_a_sentence(&mode.label))
        }
        None => condition.to_string(),
    }
}

/// What the table of the trade says where two solvers do not agree on the right run.
const UNPROVEN: &str = "unproven";

/// A solver and its step or tolerance.
fn setting(solver: &str, step_s: Option<f64>, tolerance: Option<f64>) -> String {
    let label = solver_label(solver);
    match (step_s, tolerance) {
        (Some(step_s), _) => format!("{label} with steps of {} ms", (step_s * 1e6).round() / 1e3),
        (None, Some(tolerance)) => format!("{label} with a tolerance of {tolerance:e}"),
        (None, None) => label.to_owned(),
    }
}

/// A condition by its ids, in people's words: `Spring, active`.
fn condition(study: &Setup, name: &str, between: char) -> String {
    let of = |environment: &zwidth_study::Environment| {
        let mode = name.strip_prefix(environment.id.as_str())?.strip_prefix(between)?;
        let mode = study.modes.iter().find(|m| m.id.as_str() == mode)?;
        Some(format!("{}, {}", environment.label, in_a_sentence(&mode.label)))
    };
    study.environments.iter().find_map(of).unwrap_or_else(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::{BorneOut, LadderTerm};
    use zwidth_tables::Column;

    fn planned() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    fn text<const N: usize>(name: &'static str, values: [Option<&str>; N]) -> Column {
        Column::text(name, name, values.map(|value| value.map(str::to_owned)))
    }

    #[test]
    fn the_trade_is_told_by_what_is_cheap_and_right_and_what_is_not() {
        let columns = vec![
            text("scene", [Some("spring.active"), Some("spring_wall.hybrid"), Some("other")]),
            text("yardstick", [Some("proven"), Some("unproven"), Some("proven")]),
            text("solver", [Some("moreau_jean"), None, None]),
            Column::float("step_s", "s", "", [Some(0.001_024), None, None]),
            Column::float("tolerance", "1", "", [None, None, None]),
            Column::integer("work", "1", "", [Some(480), None, None]),
            text("next_cheaper", [Some("symplectic Euler, 2.048 ms"), None, None]),
            text("why_not", [Some("it breaks the bound of the angle"), None, None]),
        ];
        let table = Table::new("trade_summary", "", columns).unwrap();
        let found = traded(&planned(), &table).unwrap();
        let told: Vec<&str> = found.iter().map(|finding| finding.text.as_str()).collect();
        assert_eq!(
            told,
            [
                "Spring, active: Moreau–Jean with steps of 1.024 ms is the cheapest run of the model that a person \
                 could not tell from the right one (480 evaluations). The next cheaper run (symplectic Euler, \
                 2.048 ms) is no such run: it breaks the bound of the angle.",
                "Spring + wall, hybrid: no run of the model is known to be right: two solvers differ.",
                "other: a person could tell each run of the model that was tried from the right one.",
            ]
        );
        assert_eq!(found[0].shown, Shown::Trade("spring_active".to_owned()));
    }

    #[test]
    fn the_ladder_is_told_by_the_terms_that_a_condition_requires() {
        let choice = |mode: &str, terms, recordings| LadderChoice {
            condition: format!("spring {mode}").parse().unwrap(),
            terms,
            trials: 6,
            fitted_rmse_rad: None,
            held_out_rmse_rad: None,
            felt_share: None,
            fullest_rmse_rad: None,
            least_missed: None,
            least_missed_rmse_rad: None,
            most_missed: None,
            most_missed_rmse_rad: None,
            recordings,
        };
        let terms = TermSet::NONE.with(LadderTerm::Friction).with(LadderTerm::BrakeLag);
        let verdict = Some(BorneOut::BetterWithout(LadderTerm::Gravity));
        let passive = LadderChoice {
            held_out_rmse_rad: Some(0.01),
            felt_share: Some(0.25),
            ..choice("passive", terms, verdict)
        };
        let rows = [choice("active", TermSet::NONE, None), passive, choice("other", terms, None)];
        let found = laddered(&planned(), &rows);
        let told: Vec<&str> = found.iter().map(|finding| finding.text.as_str()).collect();
        assert_eq!(
            told,
            [
                "Spring, active: a rigid lever without further terms is enough.",
                "Spring, passive: the model requires friction, brake lag; trials that it was not fitted to it misses by \
                 0.573°, 0.250 of what is just felt; by the recordings: better without gravity.",
                "spring other: the model requires friction, brake lag.",
            ]
        );
    }
}
