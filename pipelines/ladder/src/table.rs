//! The ladder as tables.

use crate::ladder::{Ladder, Quantity, Rung};
use crate::reason::{reason, told};
use crate::terms::{LadderTerm, TermSet};
use zwidth_study::counted;
use zwidth_tables::{Column, Table, TableError};

/// Every model: its terms, what it costs, and how far it is off. The choice is marked.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn models(ladder: &Ladder) -> Result<Table, TableError> {
    let rungs = &ladder.rungs;
    let choice = ladder.choice().map(|rung| rung.set);
    let number = |name, about, get: &dyn Fn(&Rung) -> Option<f64>| {
        Column::float(name, "1", about, rungs.iter().map(get))
    };
    let furthest = |rung: &Rung| rung.furthest();
    let name = |rung: &Rung| {
        let (at, _) = furthest(rung)?;
        ladder.quantities.get(at).map(|quantity| quantity.name.clone())
    };
    let columns = vec![
        Column::text("scene", "the scene", rungs.iter().map(|_| Some(ladder.scene.clone()))),
        Column::text(
            "terms",
            "the model's terms; rigid for none",
            rungs.iter().map(|r| Some(r.set.words())),
        ),
        Column::integer(
            "number_of_terms",
            "1",
            "how many terms it has",
            rungs.iter().map(|r| Some(r.set.len() as i64)),
        ),
        number(
            "evaluations",
            "work of a run, mean over the points: products with a flow, n for an exponential of n entries, one a decision",
            &|r| Some(r.evaluations),
        ),
        number("steps", "steps of a run, mean over the points", &|r| Some(r.counts[0])),
        number("products", "products with a flow, mean over the points", &|r| Some(r.counts[1])),
        number("exponentials", "exponentials made, mean over the points", &|r| Some(r.counts[2])),
        number("decisions", "decisions of the controller, mean over the points", &|r| {
            Some(r.counts[3])
        }),
        number(
            "furthest_off",
            "largest difference to the fullest model over what can be felt, over all judged quantities and points; null where the model does not run or lacks a number",
            &|r| furthest(r).map(|(_, off)| off).filter(|off| off.is_finite()),
        ),
        Column::text(
            "furthest_quantity",
            "the quantity that is furthest off",
            rungs.iter().map(name),
        ),
        Column::flag(
            "is_enough",
            "whether no quantity is off by more than can be felt at any point",
            rungs.iter().map(|r| Some(r.is_enough())),
        ),
        Column::flag(
            "is_chosen",
            "the cheapest of those that are enough",
            rungs.iter().map(|r| Some(Some(r.set) == choice)),
        ),
    ];
    let table = Table::new("ladder.models", &format!("{}: models", ladder.scene), columns)?;
    let told = ladder.choice().map(|choice| told(ladder, choice)).unwrap_or_default();
    Ok(table.with_note(told).with_note(note(ladder)))
}

/// What each term does to each quantity, and why it is kept or not.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn effects(ladder: &Ladder) -> Result<Table, TableError> {
    let choice = ladder.choice();
    let rows: Vec<(usize, &Quantity, LadderTerm)> = ladder
        .quantities
        .iter()
        .enumerate()
        .flat_map(|(i, q)| ladder.offered.terms().map(move |term| (i, q, term)))
        .collect();
    let number = |name, about, get: &dyn Fn(usize, &Quantity, LadderTerm) -> Option<f64>| {
        Column::float(name, "1", about, rows.iter().map(|(i, q, term)| get(*i, q, *term)))
    };
    let text = |name, about, get: &dyn Fn(&Quantity, LadderTerm) -> Option<String>| {
        Column::text(name, about, rows.iter().map(|(_, q, term)| get(q, *term)))
    };
    let switch = |term| ladder.switch(term);
    let partner = |q: &Quantity, term| strongest(ladder, q, term);
    let alone = |i: usize, _: &Quantity, term| {
        let rung = ladder.rung(ladder.offered.without(term))?;
        rung.worst.get(i).copied().filter(|off| off.is_finite())
    };
    let deciding = |i: usize, _: &Quantity, term| {
        let off = *ladder.deciding(choice?, term)?.worst.get(i)?;
        Some(off).filter(|off| off.is_finite())
    };
    let columns = vec![
        text("scene", "the scene", &|_, _| Some(ladder.scene.clone())),
        text("quantity", "what is compared", &|q, _| Some(q.name.clone())),
        Column::flag(
            "is_judged",
            "whether a bound is known for it",
            rows.iter().map(|(_, q, _)| Some(q.is_judged)),
        ),
        text("term", "the term", &|_, term| Some(term.as_str().to_owned())),
        number(
            "total_effect",
            "share of the variance that switching terms makes which this one has a part in, S_T",
            &|_, q, term| q.variance.total(switch(term)?),
        ),
        number("first_order", "share that it makes alone, S", &|_, q, term| {
            q.variance.first(switch(term)?)
        }),
        text("strongest_partner", "the term with which it interacts most", &|q, term| {
            partner(q, term).map(|(t, _)| t.as_str().to_owned())
        }),
        number(
            "partner_second_order",
            "share that the two make together and neither alone",
            &|_, q, term| partner(q, term).map(|(_, share)| share),
        ),
        number(
            "off_without",
            "how far the fullest model without it is off, over what can be felt, at the worst point",
            &alone,
        ),
        number(
            "deciding_off",
            "the same of the model that decides: of a term that is kept the choice without it, of one that is left out the fullest model without it, or the choice",
            &deciding,
        ),
        Column::flag(
            "is_kept",
            "whether the choice has it",
            rows.iter().map(|(_, _, term)| choice.map(|c| c.set.has(*term))),
        ),
        text("reason", "why", &|_, term| choice.map(|choice| reason(ladder, choice, term))),
    ];
    let table =
        Table::new("ladder.effects", &format!("{}: what each term does", ladder.scene), columns)?;
    Ok(table.with_note(note(ladder)))
}

/// Second-order indices of every pair of terms.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn interactions(ladder: &Ladder) -> Result<Table, TableError> {
    let pairs: Vec<(LadderTerm, LadderTerm)> = ladder
        .offered
        .terms()
        .flat_map(|a| ladder.offered.terms().filter(move |b| a < *b).map(move |b| (a, b)))
        .collect();
    let rows: Vec<(&Quantity, (LadderTerm, LadderTerm))> =
        ladder.quantities.iter().flat_map(|q| pairs.iter().map(move |pair| (q, *pair))).collect();
    let text = |name, about, get: &dyn Fn(&Quantity, LadderTerm, LadderTerm) -> String| {
        Column::text(name, about, rows.iter().map(|(q, (a, b))| Some(get(q, *a, *b))))
    };
    let share = |(q, (a, b)): &(&Quantity, (LadderTerm, LadderTerm))| {
        q.variance.second(ladder.switch(*a)?, ladder.switch(*b)?)
    };
    let columns = vec![
        text("scene", "the scene", &|_, _, _| ladder.scene.clone()),
        text("quantity", "what is compared", &|q, _, _| q.name.clone()),
        text("term", "one term", &|_, a, _| a.as_str().to_owned()),
        text("other_term", "the other", &|_, _, b| b.as_str().to_owned()),
        Column::float(
            "second_order",
            "1",
            "share of the variance that the two make together and neither alone",
            rows.iter().map(share),
        ),
    ];
    let title = format!("{}: which terms work together", ladder.scene);
    Ok(Table::new("ladder.interactions", &title, columns)?.with_note(note(ladder)))
}

/// The set that a table of [`models`] marks as chosen; `None` if no set is marked.
///
/// # Errors
/// A table that is not one of those.
pub fn chosen(models: &Table) -> Result<Option<TermSet>, TableError> {
    let (terms, flags) = (models.texts("terms")?, models.flags("is_chosen")?);
    let at = flags.iter().position(|flag| *flag == Some(true));
    Ok(at.and_then(|at| terms[at].as_deref()).and_then(TermSet::of_words))
}

fn strongest(ladder: &Ladder, q: &Quantity, term: LadderTerm) -> Option<(LadderTerm, f64)> {
    let own = ladder.switch(term)?;
    let others = ladder.offered.terms().filter(|other| *other != term);
    let shares = others.filter_map(|o| Some((o, q.variance.second(own, ladder.switch(o)?)?)));
    shares.fold(None, |most, next| {
        if most.is_none_or(|m: (LadderTerm, f64)| next.1 > m.1) { Some(next) } else { most }
    })
}

fn note(ladder: &Ladder) -> String {
    format!(
        "Model runs, not measurements: {} at {} of Sobol's sequence over the ranges of the \
         simulated device's parameters, each against the fullest model at the same point.",
        counted(ladder.rungs.len(), "models"),
        counted(ladder.points, "points")
    )
}
