//! A judged statement, and the basis of its verdict.

use crate::evidence::{Derived, Known, Place, Stop, Verdict, with_law};
use crate::thesis::estimate::{Estimated, Spread};
use crate::thesis::rule::{Case, From, Quantity, Range};
use crate::trials::{People, Trials};
use zwidth_results::JudgedStatement;
use zwidth_study::{Coordinate, Environment, Mode, ModeLaw, in_a_sentence};
use zwidth_tables::{number, shown_unit, with_unit};

/// A statement of which nothing is known yet.
pub(crate) fn unjudged() -> JudgedStatement {
    JudgedStatement {
        key: String::new(),
        source: String::new(),
        statement: String::new(),
        verdict: Verdict::NotMeasured,
        metric: None,
        value: None,
        ci_low: None,
        ci_high: None,
        unit: None,
        n: None,
        unit_of_analysis: None,
        asked: None,
        shown: None,
        remark: None,
    }
}

pub(crate) fn not_measured<T>(why: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::NotMeasured(why.into()))
}

/// The study's first mode of that law, and its first environment of that kind.
pub(crate) fn condition<'a>(
    known: Known<'a>,
    (law, place): Case,
) -> Result<(&'a Environment, &'a Mode), Stop> {
    let Some(environment) = known.study.environments.iter().find(|e| place.fits(e)) else {
        return not_measured(match place {
            Place::Spring => "the study has no environment with a spring and without a wall",
            Place::Wall => "the study has no environment with a wall",
        });
    };
    let Some(mode) = with_law(known.study, law) else {
        return not_measured(match law {
            ModeLaw::Active => "the study has no mode with a motor alone",
            ModeLaw::Passive => "the study has no mode with a brake alone",
            ModeLaw::Hybrid => "the study has no mode in which a motor takes over from a brake",
        });
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
) -> JudgedStatement {
    let (unit, factor) = match quantity.unit {
        "1" => ("%".to_owned(), 100.0),
        unit => shown_unit(unit, coordinate),
    };
    let (interval, remark) = match &estimated.spread {
        Spread::Interval(ends) => (Some(ends.map(|end| factor * end)), None),
        Spread::Equal => (None, Some("no interval: all values are alike".into())),
        Spread::Unknown(why) => (None, Some(format!("no interval: {why}").into())),
    };
    JudgedStatement {
        verdict: range.judge(estimated.value, &estimated.spread),
        metric: Some(quantity.words.to_owned()),
        value: Some(factor * estimated.value),
        ci_low: interval.map(|ends| ends[0]),
        ci_high: interval.map(|ends| ends[1]),
        n: Some(estimated.n),
        unit_of_analysis: Some(estimated.over.clone()),
        asked: Some(requirement(range, &unit, factor).into()),
        unit: Some(unit),
        remark,
        ..unjudged()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_said_with_its_unit_and_why() {
        let of = |low, high| requirement(&Range { low, high, why: "so" }, "°", 1.0);
        assert_eq!(of(1.5, 20.0), "1.5 to 20°: so");
        assert!(of(2.5, f64::INFINITY).starts_with("above 2.5"));
        assert!(of(f64::NEG_INFINITY, 2.5).starts_with("below 2.5"));
    }
}
