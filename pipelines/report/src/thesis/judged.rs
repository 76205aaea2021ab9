//! A judged statement, and the basis of its verdict.

use crate::actuation::with_law;
use crate::evidence::{Evidence, Known, Verdict};
use crate::gallery::{Gallery, Shown};
use crate::thesis::estimate::{Estimated, Spread, trials_of};
use crate::thesis::rule::{Case, From, Place, Quantity, Range};
use crate::trials::{People, Trials};
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_study::{Basis, Coordinate, Environment, Mode, ModeLaw, in_a_sentence};
use zwidth_tables::{Measured, TableError, number, shown_unit, with_unit};

/// The tables of a study by which the thesis' statements are judged.
#[derive(Debug, Clone, Copy)]
pub struct Derived<'a> {
    /// The study, its calibration and its metrics.
    pub known: Known<'a>,
    /// Where the calibration comes from.
    pub basis: Basis,
    /// The replays that are used ([`crate::replayed`]), one row per trial.
    pub replays: Option<&'a Measured>,
    /// The answers as given, one row each.
    pub answers: Option<&'a [GivenAnswer]>,
    /// Their tally.
    pub tally: Option<&'a [AnswerTally]>,
    /// The figures that there are.
    pub gallery: &'a Gallery,
    /// Confidence level of intervals.
    pub level: f64,
}

/// A statement as judged.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Judged {
    pub(crate) evidence: Evidence,
    /// The range or condition that the value must meet.
    pub(crate) required: String,
    pub(crate) interval: Option<[f64; 2]>,
    pub(crate) n: Option<usize>,
    /// The unit of analysis; empty where nothing was counted.
    pub(crate) over: String,
    pub(crate) shown: Shown,
}

/// Why a statement has no verdict from numbers.
pub(crate) enum Stop {
    /// Nothing that was measured tells, in words.
    NotMeasured(String),
    Table(TableError),
}

impl std::convert::From<TableError> for Stop {
    fn from(error: TableError) -> Self {
        Self::Table(error)
    }
}

/// The study's first mode of that law, and its first environment of that kind.
pub(crate) fn condition<'a>(
    known: Known<'a>,
    (law, place): Case,
) -> Result<(&'a Environment, &'a Mode), Stop> {
    let environment = known.study.environments.iter().find(|e| place.fits(e));
    let Some(environment) = environment else {
        let kind = match place {
            Place::Spring => "environment with a spring and without a wall",
            Place::Wall => "environment with a wall",
        };
        return Err(Stop::NotMeasured(format!("the study has no {kind}")));
    };
    let Some(mode) = with_law(known.study, law) else {
        let kind = match law {
            ModeLaw::Active => "mode with a motor alone",
            ModeLaw::Passive => "mode with a brake alone",
            ModeLaw::Hybrid => "mode in which a motor takes over from a brake",
        };
        return Err(Stop::NotMeasured(format!("the study has no {kind}")));
    };
    Ok((environment, mode))
}

/// The trials of a case in the table that the numbers are in.
pub(crate) fn trials<'a>(
    derived: &Derived<'a>,
    case: Case,
    from: From,
) -> Result<Trials<'a>, Stop> {
    let (environment, mode) = condition(derived.known, case)?;
    let table = match from {
        From::Metrics => derived.known.metrics,
        From::Replays => derived.replays,
    };
    let trials = table.map(|table| Trials::of(table, Some(&environment.id), &mode.id));
    trials.filter(|trials| trials.len() > 0).ok_or_else(|| {
        let names = [in_a_sentence(&mode.label), in_a_sentence(&environment.label)].join(", ");
        Stop::NotMeasured(format!("there is no trial of {names}"))
    })
}

/// The values of a case.
pub(crate) fn people(derived: &Derived, case: Case, quantity: Quantity) -> Result<People, Stop> {
    Ok(trials(derived, case, quantity.from)?.people(quantity.column, quantity.less)?)
}

/// An estimate against a range, in the units in which people read it.
pub(crate) fn judged(
    quantity: Quantity,
    estimated: &Estimated,
    range: &Range,
    coordinate: Coordinate,
    shown: Shown,
) -> Judged {
    let (unit, factor) = match quantity.unit {
        "1" => ("%".to_owned(), 100.0),
        unit => shown_unit(unit, coordinate),
    };
    let (interval, remark) = match &estimated.spread {
        Spread::Interval(ends) => (Some(ends.map(|end| factor * end)), String::new()),
        Spread::Equal => (None, "no interval: all values are alike".to_owned()),
        Spread::Unknown(why) => (None, format!("no interval: {why}")),
    };
    Judged {
        evidence: Evidence {
            metric: quantity.words.to_owned(),
            value: Some(factor * estimated.value),
            unit: unit.clone(),
            remark,
            verdict: range.judge(estimated.value, &estimated.spread),
        },
        required: requirement(range, &unit, factor),
        interval,
        n: Some(estimated.n),
        over: estimated.over.clone(),
        shown,
    }
}

/// `above 2.5°: why`, `3.7 to 4.35 N/rad: why`.
fn requirement(range: &Range, unit: &str, factor: f64) -> String {
    let [low, high] = [range.low, range.high].map(|end| {
        let text = number(factor * end, None);
        let shorter = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        // Zeros of a whole number are no decimals.
        if text.contains('.') { shorter } else { text }
    });
    let ends = match (range.low.is_finite(), range.high.is_finite()) {
        (true, true) => format!("{low} to {}", with_unit(&high, unit)),
        (true, false) => format!("above {}", with_unit(&low, unit)),
        _ => format!("below {}", with_unit(&high, unit)),
    };
    format!("{ends}: {}", range.why)
}

/// Some of all trials.
pub(crate) fn counted(
    metric: &str,
    some: usize,
    all: usize,
    verdict: Verdict,
    required: &str,
    trials: &Trials,
) -> Result<Judged, Stop> {
    let people = trials.participants();
    let over = match people.first() {
        Some(who) if people.len() == 1 => trials_of(who),
        _ => format!("trials of {} participants", people.len()),
    };
    Ok(Judged {
        evidence: Evidence {
            metric: metric.to_owned(),
            value: Some(100.0 * some as f64 / all as f64),
            unit: "%".to_owned(),
            remark: format!("{some} of {all} trials"),
            verdict,
        },
        required: required.to_owned(),
        interval: None,
        n: Some(all),
        over,
        shown: Shown::Metrics,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_said_with_its_unit_and_why() {
        let of = |low, high| requirement(&Range { low, high, why: "so".to_owned() }, "°", 1.0);
        assert_eq!(of(1.5, 20.0), "1.5 to 20°: so");
        assert!(of(2.5, f64::INFINITY).starts_with("above 2.5"));
        assert!(of(f64::NEG_INFINITY, 2.5).starts_with("below 2.5"));
    }
}
