//! The ladder as tables.

use crate::held_out::{HeldOut, Knobs};
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

/// The set that a table of [`models`] marks as chosen; `None` where none is.
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

/// Of the models with one term less than a set, that which is least far off, by a table of
/// [`models`].
///
/// # Errors
/// A table that is not one of those.
pub fn next_smaller(models: &Table, set: TermSet) -> Result<Option<TermSet>, TableError> {
    let (terms, off) = (models.texts("terms")?, models.floats("furthest_off")?);
    let smaller: Vec<TermSet> = set.terms().map(|term| set.without(term)).collect();
    let found = terms.iter().zip(off).filter_map(|(words, off)| {
        let of = TermSet::of_words(words.as_deref()?).filter(|of| smaller.contains(of))?;
        Some((of, off.unwrap_or(f64::INFINITY)))
    });
    let least = |a: (TermSet, f64), b: (TermSet, f64)| if b.1 < a.1 { b } else { a };
    Ok(found.reduce(least).map(|(set, _)| set))
}

const HELD_OUT: &str = "ladder";

/// Models fitted to half of a condition's trials and judged on the others, one row a model with what
/// it is: the choice, the next smaller, the fullest.
///
/// # Errors
/// A number that is not finite where one must be.
pub fn held_out_table(
    condition: &str,
    rows: &[(&str, HeldOut)],
    trials: usize,
) -> Result<Table, TableError> {
    let number = |name, unit, about, get: fn(&HeldOut) -> f64| {
        let finite = |row: &(&str, HeldOut)| Some(get(&row.1)).filter(|x| x.is_finite());
        Column::float(name, unit, about, rows.iter().map(finite))
    };
    let columns = vec![
        Column::text(
            "condition",
            "environment and mode",
            rows.iter().map(|_| Some(condition.to_owned())),
        ),
        Column::text(
            "model",
            "choice of the ladder, the next smaller one, or the fullest",
            rows.iter().map(|(role, _)| Some((*role).to_owned())),
        ),
        Column::text(
            "terms",
            "its terms; rigid for none",
            rows.iter().map(|(_, row)| Some(row.set.words())),
        ),
        Column::integer(
            "trials",
            "1",
            "how many trials there are; every second one is fitted",
            rows.iter().map(|_| Some(trials as i64)),
        ),
        number(
            "inertia_factor",
            "1",
            "fitted moment of inertia over the simulated device's",
            |r| r.knobs.inertia,
        ),
        number("dry_factor", "1", "fitted dry friction over its", |r| r.knobs.dry),
        number("viscous_factor", "1", "fitted viscous friction over its", |r| r.knobs.viscous),
        number("brake_lag_factor", "1", "fitted lags of the brake over its", |r| r.knobs.brake_lag),
        number(
            "fitted_rmse_rad",
            "rad",
            "error of the angle on the trials it was fitted to; null where it does not run",
            |r| r.fitted_rad,
        ),
        number("held_out_rmse_rad", "rad", "error of the angle on the others", |r| r.held_out_rad),
    ];
    Ok(Table::new(HELD_OUT, HELD_OUT_TITLE, columns)?.with_note(HELD_OUT_NOTE))
}

const HELD_OUT_TITLE: &str =
    "Ladder: the model each condition needs, on trials it was not fitted to";
const HELD_OUT_NOTE: &str = "Every second trial of a condition is fitted, the others are predicted from their \
     recorded force. A choice is confirmed where neither the fullest model nor the next smaller one predicts better.";

/// The tables of all conditions as one.
///
/// # Errors
/// Tables that are not of [`held_out_table`].
pub fn join_held_out(tables: &[Table]) -> Result<Table, TableError> {
    let mut rows = Vec::new();
    for table in tables {
        rows.extend(read_held_out(table)?);
    }
    let conditions = |name: &'static str, about, get: fn(&Row) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let number = |name, unit, about, get: fn(&Row) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let columns = vec![
        conditions("condition", "environment and mode", |r| r.condition.clone()),
        conditions("model", "choice of the ladder, the next smaller one, or the fullest", |r| {
            r.model.clone()
        }),
        conditions("terms", "its terms; rigid for none", |r| r.terms.clone()),
        Column::integer(
            "trials",
            "1",
            "how many trials there are; every second one is fitted",
            rows.iter().map(|r| r.trials),
        ),
        number(
            "fitted_rmse_rad",
            "rad",
            "error of the angle on the trials it was fitted to; null where it does not run",
            |r| r.fitted,
        ),
        number("held_out_rmse_rad", "rad", "error of the angle on the others", |r| r.held_out),
    ];
    Ok(Table::new(HELD_OUT, HELD_OUT_TITLE, columns)?.with_note(HELD_OUT_NOTE))
}

struct Row {
    condition: String,
    model: String,
    terms: String,
    trials: Option<i64>,
    fitted: Option<f64>,
    held_out: Option<f64>,
}

fn read_held_out(table: &Table) -> Result<Vec<Row>, TableError> {
    let text = |name| -> Result<Vec<String>, TableError> {
        Ok(table.texts(name)?.into_iter().map(Option::unwrap_or_default).collect())
    };
    let (conditions, models, terms) = (text("condition")?, text("model")?, text("terms")?);
    let (trials, fitted) = (table.integers("trials")?, table.floats("fitted_rmse_rad")?);
    let held_out = table.floats("held_out_rmse_rad")?;
    let row = |i: usize| Row {
        condition: conditions[i].clone(),
        model: models[i].clone(),
        terms: terms[i].clone(),
        trials: trials[i],
        fitted: fitted[i],
        held_out: held_out[i],
    };
    Ok((0..table.height()).map(row).collect())
}

/// The choice of a table of held-out errors, and what was fitted; `None` where nothing was.
///
/// # Errors
/// A table that is not of [`held_out_table`].
pub fn fitted(table: &Table) -> Result<Option<(TermSet, Knobs)>, TableError> {
    let rows = read_held_out(table)?;
    let Some(at) = rows.iter().position(|row| row.model == "choice") else { return Ok(None) };
    let factor = |name| -> Result<f64, TableError> {
        Ok(table.floats(name)?.get(at).copied().flatten().unwrap_or(1.0))
    };
    let knobs = Knobs {
        inertia: factor("inertia_factor")?,
        dry: factor("dry_factor")?,
        viscous: factor("viscous_factor")?,
        brake_lag: factor("brake_lag_factor")?,
    };
    Ok(TermSet::of_words(&rows[at].terms).map(|set| (set, knobs)))
}
