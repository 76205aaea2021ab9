//! What is to be known below the tables.

use zwidth_results::{FitVerdict, PsychometricFit};
use zwidth_study::{Asks, Method, Task};

/// From so many answers a level on the JND of right and wrong answers is found.
const ENOUGH_ANSWERS: usize = 20;
/// Steps are equal if their ratio is off 1 by no more than this.
const EQUAL: f64 = 1e-9;

/// Notes below the table of fits: who is not estimated, and what a task's plan makes of its numbers.
pub fn notes(tasks: &[Task], fits: &[PsychometricFit]) -> Vec<String> {
    let mut notes = Vec::new();
    for task in tasks {
        let own: Vec<&PsychometricFit> = fits.iter().filter(|fit| fit.task == task.id).collect();
        if own.is_empty() {
            continue;
        }
        if let Method::Constant { levels, .. } = &task.method
            && task.asks == Asks::OneOfTwo
            && own.iter().any(|fit| fit.trials < ENOUGH_ANSWERS * levels.len())
        {
            notes.push(format!(
                "{}: with fewer than {ENOUGH_ANSWERS} right or wrong answers a level, JNDs are off by a factor of two, and \
                 some people have none.",
                task.id
            ));
        }
        if let Method::Staircase(plan) = &task.method
            && plan.down_after > 1
            && (plan.up - plan.down).abs() <= EQUAL * plan.up
        {
            notes.push(format!(
                "{}: steps down as large as steps up settle below the share of their rule: of a fifth of a decade and two \
                 down at 63.7 %, not at 70.7 %.",
                task.id
            ));
        }
        let named: Vec<String> = own
            .iter()
            .filter(|fit| !fit.verdict.is_estimated())
            .map(|fit| {
                format!("{} {} in {} ({})", fit.participant, fit.session, fit.mode, why(fit))
            })
            .collect();
        if !named.is_empty() {
            notes.push(format!(
                "{}: no estimate of {}. They are not missing at random.",
                task.id,
                named.join(", ")
            ));
        }
    }
    notes
}

/// A verdict in a few words, with the level that it is about.
fn why(fit: &PsychometricFit) -> String {
    match fit.verdict {
        FitVerdict::Below => format!("outside: below {} {}", fit.lowest_level, fit.unit),
        FitVerdict::Above => format!("outside: above {} {}", fit.highest_level, fit.unit),
        other => other.as_str().to_owned(),
    }
}
