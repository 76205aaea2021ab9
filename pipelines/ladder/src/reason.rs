//! Why a term is in the model or not, in words.

use crate::ladder::{Ladder, Rung};
use zwidth_results::{LadderTerm, TermSet};

/// Whether a term is in the choice, and why: one sentence.
pub fn reason(ladder: &Ladder, choice: &Rung, term: LadderTerm) -> String {
    let name = term.title();
    // Sensors are spoken of in the plural.
    let [be, it, make] = match term {
        LadderTerm::Sensors => ["are", "them", "they make"],
        _ => ["is", "it", "it makes"],
    };
    let deciding = ladder.deciding(choice, term);
    if !choice.set.has(term) {
        return match deciding {
            Some(alone) if alone.set != choice.set => format!(
                "{name} {be} left out: the fullest model without {it} {}",
                off(ladder, alone)
            ),
            _ => format!(
                "{name} {be} left out, together with the others: the model {}",
                off(ladder, choice)
            ),
        };
    }
    let Some(without) = deciding else { return String::new() };
    // The choice is the cheapest model that is enough, so one that is enough without a term costs
    // more, or has more terms.
    if without.is_enough() {
        let more = without.evaluations;
        let less = choice.evaluations;
        return format!(
            "{name} {be} kept because {make} a run cheaper: without {it} {more:.0} evaluations instead of {less:.0}"
        );
    }
    let whose = match ladder.in_scene.has(term) {
        true => "",
        false => "; its numbers are the simulated device's, the scene gives none",
    };
    format!("{name} {be} kept: a model without {it} {}{whose}", off(ladder, without))
}

/// How far a model is off, at the quantity that is furthest off.
fn off(ladder: &Ladder, rung: &Rung) -> String {
    match rung.furthest() {
        Some((_, off)) if off.is_infinite() => {
            "does not run, or lacks a number that the fullest model has".to_owned()
        }
        Some((at, off)) => {
            let name = ladder.quantities.get(at).map_or("", |q| q.name.as_str());
            format!("is off by {off:.2} of what can be felt at most ({name})")
        }
        None => "is not compared by anything".to_owned(),
    }
}

/// The choice in a sentence. It lists as needed only terms whose numbers the scene gives.
pub fn told(ladder: &Ladder, choice: &Rung) -> String {
    let full = ladder.rung(ladder.offered).map_or(0.0, |rung| rung.evaluations);
    let share = if full > 0.0 { 100.0 * choice.evaluations / full } else { 100.0 };
    let added = choice.set.terms().filter(|term| !ladder.in_scene.has(*term));
    let added = added.fold(TermSet::NONE, TermSet::with);
    let on_device = match added {
        TermSet::NONE => String::new(),
        added => {
            format!(
                "; with numbers of the simulated device, as the scene gives none, also {}",
                added.titles()
            )
        }
    };
    format!(
        "{}: of {} terms it needs {}{on_device}; {:.0} evaluations a run, {share:.0} % of the fullest model's",
        ladder.scene,
        ladder.offered.len(),
        choice.set.both(ladder.in_scene).titles(),
        choice.evaluations
    )
}
