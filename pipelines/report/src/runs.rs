//! Runs of the model in sentences: which cheap run could not be told apart from the right one, and
//! which terms a condition requires.

use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_dynamics::solver_label;
use zwidth_results::{LadderChoice, LadderCondition, Proof, TermSet, TradeChoice};
use zwidth_study::{Environment, Mode, Setup, in_a_sentence};
use zwidth_tables::quantity;

/// The cheapest run of each scene of a study that a person could not tell from the right one: one
/// sentence per scene. They are about the model, not about trials.
pub fn traded(study: &Setup, choices: &[TradeChoice]) -> Vec<Finding> {
    let findings = choices.iter().map(|choice| {
        let text = match (choice.solver.as_deref(), choice.work) {
            (Some(solver), Some(work)) => {
                let label = solver_label(solver);
                let setting = match (choice.step_s, choice.tolerance) {
                    // In whole microseconds: more digits are rounding.
                    (Some(step_s), _) => {
                        format!("{label} with steps of {} ms", (step_s * 1e6).round() / 1e3)
                    }
                    (None, Some(tolerance)) => format!("{label} with a tolerance of {tolerance:e}"),
                    (None, None) => label.to_owned(),
                };
                let not = choice.next_cheaper.as_ref().zip(choice.why_not);
                let not = not.map(|(next, why)| {
                    format!(" The next cheaper run ({next}) is no such run: {why}.")
                });
                format!(
                    "{setting} is the cheapest run of the model that a person could not tell from the right one \
                     ({work} evaluations).{}",
                    not.unwrap_or_default()
                )
            }
            _ if choice.yardstick == Proof::Unproven => {
                "no run of the model is known to be right: two solvers differ.".to_owned()
            }
            _ => "a person could tell each run of the model that was tried from the right one."
                .to_owned(),
        };
        let own = condition(study, |e, mode| format!("{}.{}", e.id, mode.id) == *choice.scene);
        let scene = own.as_deref().unwrap_or(&choice.scene);
        let text = format!("{scene}: {text}");
        Finding::new(text, Shown::Trade(choice.scene.replace('.', "_")))
    });
    findings.collect()
}

/// The first condition that fits, in people's words: `Spring, active`.
fn condition(study: &Setup, fits: impl Fn(&Environment, &Mode) -> bool) -> Option<String> {
    let environments = study.environments.iter();
    let mut all = environments.flat_map(|e| study.modes.iter().map(move |mode| (e, mode)));
    let (environment, mode) = all.find(|(e, mode)| fits(e, mode))?;
    Some(format!("{}, {}", environment.label, in_a_sentence(&mode.label)))
}

/// Which terms of the model each condition requires, and whether its recordings confirm that: one
/// sentence per condition.
pub fn laddered(study: &Setup, choices: &[LadderChoice]) -> Vec<Finding> {
    let findings = choices.iter().map(|choice| {
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
        let LadderCondition { environment, mode } = &choice.condition;
        let own = condition(study, |e, m| e.id == *environment && m.id == *mode);
        let text = format!(
            "{}: {needs}{}{}.",
            own.unwrap_or_else(|| choice.condition.to_string()),
            missed.unwrap_or_default(),
            borne_out.unwrap_or_default()
        );
        Finding::new(text, Shown::Ladder)
    });
    findings.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::{BorneOut, Gate, LadderTerm, WhyNot};

    fn planned() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    #[test]
    fn the_trade_is_told_by_what_is_cheap_and_right_and_what_is_not() {
        let scene = |scene: &str, yardstick| TradeChoice {
            scene: scene.into(),
            mode: "active".into(),
            model: "no finger".into(),
            yardstick,
            by: "exact".into(),
            against: "dormand_prince".into(),
            apart_rad: None,
            apart_s: None,
            motion_changes: 3,
            solver: None,
            step_s: None,
            tolerance: None,
            work: None,
            neighbours: None,
            passed: None,
            next_cheaper: None,
            why_not: None,
        };
        let active = TradeChoice {
            solver: Some("moreau_jean".into()),
            step_s: Some(0.001_024),
            work: Some(480),
            next_cheaper: Some("symplectic Euler, 2.048 ms".to_owned()),
            why_not: Some(WhyNot::Breaks(Gate::Angle)),
            ..scene("spring.active", Proof::Proven)
        };
        let hybrid = scene("spring_wall.hybrid", Proof::Unproven);
        let found = traded(&planned(), &[active, hybrid, scene("other", Proof::Proven)]);
        let told: Vec<String> = found.iter().map(|finding| finding.text.to_string()).collect();
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
        let told: Vec<String> = found.iter().map(|finding| finding.text.to_string()).collect();
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
