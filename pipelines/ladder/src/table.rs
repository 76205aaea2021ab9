//! The ladder as rows, and its tables.

use crate::ladder::{Ladder, Quantity, Rung};
use crate::reason::{reason, told};
use std::sync::Arc;
use zwidth_results::{LadderModel, LadderTerm, Row, TermEffect, TermPair, TermSet};
use zwidth_study::counted;
use zwidth_tables::{Table, TableError};

/// Every model: its terms, what it costs, and how far it is off. The choice is marked.
pub fn models(ladder: &Ladder) -> Vec<LadderModel> {
    let scene = Arc::<str>::from(ladder.scene.as_str());
    let choice = ladder.choice().map(|rung| rung.set);
    let models = ladder.rungs.iter().map(|rung| {
        let furthest = rung.furthest();
        let [steps, products, exponentials, decisions] = rung.counts;
        LadderModel {
            scene: scene.clone(),
            terms: rung.set,
            number_of_terms: rung.set.len(),
            evaluations: rung.evaluations,
            steps,
            products,
            exponentials,
            decisions,
            furthest_off: furthest.map(|(_, off)| off).filter(|off| off.is_finite()),
            furthest_quantity: furthest
                .and_then(|(at, _)| Some(ladder.quantities.get(at)?.name.as_str().into())),
            is_enough: rung.is_enough(),
            is_chosen: Some(rung.set) == choice,
        }
    });
    models.collect()
}

/// The effect of each term on each quantity, and why the term is kept or not.
pub fn effects(ladder: &Ladder) -> Vec<TermEffect> {
    let scene = Arc::<str>::from(ladder.scene.as_str());
    let choice = ladder.choice();
    let mut effects = Vec::new();
    for (at, quantity) in ladder.quantities.iter().enumerate() {
        // How far a model is off at this quantity.
        let off = |rung: &Rung| rung.worst.get(at).copied().filter(|off| off.is_finite());
        for term in ladder.offered.terms() {
            let switch = ladder.switch(term);
            let partner = strongest(ladder, quantity, term);
            effects.push(TermEffect {
                scene: scene.clone(),
                quantity: quantity.name.as_str().into(),
                is_judged: quantity.is_judged,
                term,
                total_effect: switch.and_then(|switch| quantity.variance.total(switch)),
                first_order: switch.and_then(|switch| quantity.variance.first(switch)),
                strongest_partner: partner.map(|(other, _)| other),
                partner_second_order: partner.map(|(_, share)| share),
                off_without: ladder.rung(ladder.offered.without(term)).and_then(off),
                deciding_off: choice.and_then(|c| ladder.deciding(c, term)).and_then(off),
                is_kept: choice.map(|choice| choice.set.has(term)),
                reason: choice.map(|choice| reason(ladder, choice, term).into()),
            });
        }
    }
    effects
}

/// Second-order indices of every pair of terms.
pub fn interactions(ladder: &Ladder) -> Vec<TermPair> {
    let scene = Arc::<str>::from(ladder.scene.as_str());
    let mut pairs = Vec::new();
    for quantity in &ladder.quantities {
        for term in ladder.offered.terms() {
            for other_term in ladder.offered.terms().filter(|other| term < *other) {
                let switches = ladder.switch(term).zip(ladder.switch(other_term));
                pairs.push(TermPair {
                    scene: scene.clone(),
                    quantity: quantity.name.as_str().into(),
                    term,
                    other_term,
                    second_order: switches.and_then(|(a, b)| quantity.variance.second(a, b)),
                });
            }
        }
    }
    pairs
}

/// The table of [`models`], with the choice in a sentence.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn models_table(ladder: &Ladder) -> Result<Table, TableError> {
    let table = of_scene(ladder, &models(ladder))?;
    let choice = ladder.choice().map(|choice| told(ladder, choice)).unwrap_or_default();
    Ok(table.with_note(choice).with_note(note(ladder)))
}

/// The table of [`effects`].
///
/// # Errors
/// Those of [`models_table`].
pub fn effects_table(ladder: &Ladder) -> Result<Table, TableError> {
    Ok(of_scene(ladder, &effects(ladder))?.with_note(note(ladder)))
}

/// The table of [`interactions`].
///
/// # Errors
/// Those of [`models_table`].
pub fn interactions_table(ladder: &Ladder) -> Result<Table, TableError> {
    Ok(of_scene(ladder, &interactions(ladder))?.with_note(note(ladder)))
}

fn of_scene<R: Row>(ladder: &Ladder, rows: &[R]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.called(R::NAME, format!("{}: {}", ladder.scene, R::TITLE)))
}

/// The set that is marked as chosen; `None` if none is.
pub fn chosen(models: &[LadderModel]) -> Option<TermSet> {
    models.iter().find(|model| model.is_chosen).map(|model| model.terms)
}

/// The term with the largest second-order index together with `term`, and this index; of equal
/// ones the first.
fn strongest(ladder: &Ladder, q: &Quantity, term: LadderTerm) -> Option<(LadderTerm, f64)> {
    let own = ladder.switch(term)?;
    let others = ladder.offered.terms().filter(|other| *other != term);
    let indices =
        others.filter_map(|other| Some((other, q.variance.second(own, ladder.switch(other)?)?)));
    indices.reduce(|most, next| if next.1 > most.1 { next } else { most })
}

fn note(ladder: &Ladder) -> String {
    format!(
        "Model runs, not measurements: {} at {} of Sobol's sequence over the ranges of the \
         simulated device's parameters, each against the fullest model at the same point.",
        counted(ladder.rungs.len(), "models"),
        counted(ladder.points, "points")
    )
}
