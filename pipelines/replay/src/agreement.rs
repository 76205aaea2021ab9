//! Bland–Altman agreement of peaks and times, trial by trial.
//!
//! Bland & Altman (1986), Lancet 327:307; intervals of the limits: Bland & Altman (1999), Stat.
//! Methods Med. Res. 8:135.

use crate::ReplayError;
use crate::table::own_model;
use core::f64::consts::PI;
use zwidth_stats::interval::{Estimate, mean, t_interval};
use zwidth_tables::{Column, Table, UNIT_OF_ROW};

/// Standard deviations between bias and limits: 95 % of normal differences lie between the limits.
const LIMIT_SDS: f64 = 1.96;

/// Up to where a difference does not matter.
#[derive(Clone, Copy)]
enum Bound {
    /// As large in every trial.
    Given(f64),
    /// A share of the mean of a recorded column.
    ShareOf(&'static str, f64),
}

/// The smallest change of a finger joint's angle that can be told: 2.5° (Tan, Srinivasan, Eberman &
/// Cheng 1994, ASME DSC 55-1:353), taken for the lever's angle.
const ANGLE: Bound = Bound::Given(2.5 * PI / 180.0);
/// The smallest change of a force that a finger can tell, between 2.5 and 10 N: 7 % (Pang, Tan &
/// Durlach 1991, Percept. Psychophys. 49:531).
const FORCE: Bound = Bound::ShareOf("peak_recorded_n", 0.07);
/// A tenth of a second: assumed.
const TIME: Bound = Bound::Given(0.1);

/// Column of the differences, what they are of, their unit, and how large they may be.
const QUANTITIES: [(&str, &str, &str, Bound); 4] = [
    ("peak_error_rad", "peak angle", "rad", ANGLE),
    ("peak_error_n", "peak force", "N", FORCE),
    ("peak_time_error_s", "time of the peak", "s", TIME),
    ("reversal_error_s", "time of the reversal", "s", TIME),
];

const NOTES: [&str; 2] = [
    "Trials are taken for independent; repeats of one person are not, so intervals are too narrow for people in general.",
    "Verdict: alike, both limits within the bound; off, the bias beyond it; scattered, the bias within it and a limit \
     beyond. Bounds: 2.5 degrees, the just noticeable difference of a finger joint's angle (Tan 1994), 7 % of the mean \
     recorded peak force (Pang 1991), 0.1 s (assumed).",
];

/// Of closed loop.
const OPEN: &str = "Closed loop: given force and voltages, nothing in the model brings an error of the angle back, so \
    that what is wrong with its plant adds up along a trial.";

/// Whether model and recording agree within a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Agree {
    Alike,
    Off,
    Scattered,
    TooFew,
}

impl Agree {
    fn of([bias, low, high]: [Option<Estimate>; 3], bound: Option<f64>) -> Self {
        let (Some(bias), Some(low), Some(high), Some(bound)) = (bias, low, high, bound) else {
            return Self::TooFew;
        };
        let within = |value: Estimate| value.estimate.abs() <= bound;
        match (within(bias), within(low) && within(high)) {
            (true, true) => Self::Alike,
            (false, _) => Self::Off,
            (true, false) => Self::Scattered,
        }
    }

    fn as_str(self) -> &'static str {
        match self {
            Self::Alike => "alike",
            Self::Off => "off",
            Self::Scattered => "scattered",
            Self::TooFew => "too few",
        }
    }
}

/// One quantity of one model in one causality and mode.
struct Agreement {
    of: [String; 3],
    quantity: &'static str,
    unit: &'static str,
    n: usize,
    bound: Option<f64>,
    verdict: Agree,
    bias: Option<Estimate>,
    low: Option<Estimate>,
    high: Option<Estimate>,
}

/// For each causality, mode, model and quantity of the table of replays: n trials, the bias (mean
/// of model less recording), the limits of agreement (bias ± 1.96 SD) with their t intervals at
/// `level`, and a verdict; null below two trials. Trials of one person are taken for independent,
/// so with few people the intervals are too narrow. Numbers are in the unit of their row.
///
/// # Errors
/// A table that lacks a column, a level outside (0, 1).
pub fn agreement(replays: &Table, level: f64) -> Result<Table, ReplayError> {
    let mut found = Vec::new();
    let (groups, of_rows) = groups(replays)?;
    for (place, of) in groups.into_iter().enumerate() {
        let values = |column: &str| -> Result<Vec<f64>, ReplayError> {
            let rows = replays.floats(column)?.into_iter().zip(&of_rows);
            Ok(rows.filter_map(|(value, of)| value.filter(|_| *of == Some(place))).collect())
        };
        for (column, quantity, unit, bound) in QUANTITIES {
            let differences = values(column)?;
            if differences.is_empty() {
                continue;
            }
            let all = limits(&differences, level)?;
            let bound = match bound {
                Bound::Given(bound) => Some(bound),
                Bound::ShareOf(column, share) => {
                    mean(&values(column)?, level)?.estimate.map(|mean| share * mean.abs())
                }
            };
            let ([bias, low, high], n, of) = (all, differences.len(), of.clone());
            let verdict = Agree::of(all, bound);
            found.push(Agreement { of, quantity, unit, n, bound, verdict, bias, low, high });
        }
    }
    let open = found.iter().any(|row| row.of[0] == crate::Causality::ClosedLoop.as_str());
    let notes = NOTES.into_iter().chain(open.then_some(OPEN)).map(str::to_owned);
    Ok(notes.chain(own_model(replays)?).fold(table(&found)?, Table::with_note))
}

/// Bias, lower and upper limit. The variance of a limit is s² / n + z² s² / (2 (n − 1)).
fn limits(differences: &[f64], level: f64) -> Result<[Option<Estimate>; 3], ReplayError> {
    let found = mean(differences, level)?;
    let Some((sd, bias)) = found.sd.zip(found.interval) else { return Ok([None; 3]) };
    let (n, df) = (found.n as f64, found.n as f64 - 1.0);
    let std_error = sd * (1.0 / n + LIMIT_SDS * LIMIT_SDS / (2.0 * df)).sqrt();
    let limit = |sds: f64| t_interval(bias.estimate + sds * sd, std_error, df, level);
    Ok([Some(bias), Some(limit(-LIMIT_SDS)?), Some(limit(LIMIT_SDS)?)])
}

/// What tells rows of the table apart.
const GROUP: [&str; 3] = ["causality", "mode", "model"];

/// The columns that [`agreement`] looks at.
pub fn agreement_columns() -> Vec<&'static str> {
    let compared = QUANTITIES.iter().flat_map(|(column, _, _, bound)| match bound {
        Bound::Given(_) => vec![*column],
        Bound::ShareOf(of, _) => vec![*column, *of],
    });
    GROUP.into_iter().chain(compared).chain(["source"]).collect()
}

/// A place among the groups, for each row.
type Places = Vec<Option<usize>>;

/// Causality, mode and model of the rows, each once, in the order of the rows, by causality; and
/// which of them each row is of.
fn groups(replays: &Table) -> Result<(Vec<[String; 3]>, Places), ReplayError> {
    let [causalities, modes, models] = GROUP.map(|name| replays.words(name));
    let rows = causalities?.zip(modes?).zip(models?);
    let mut groups: Vec<[String; 3]> = Vec::new();
    let mut numbers = Vec::new();
    for row in rows {
        let ((Some(causality), Some(mode)), Some(model)) = row else {
            numbers.push(None);
            continue;
        };
        let group = [causality, mode, model];
        let known = groups.iter().position(|known| *known == group);
        numbers.push(Some(known.unwrap_or(groups.len())));
        if known.is_none() {
            groups.push(group.map(str::to_owned));
        }
    }
    let place = |of: &[String; 3]| {
        let modes = groups.iter().position(|group| group[1] == of[1]);
        (crate::Causality::ALL.iter().position(|c| c.as_str() == of[0]), modes, of[2].clone())
    };
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|number| place(&groups[*number]));
    let mut places = vec![0; groups.len()];
    order.iter().enumerate().for_each(|(place, number)| places[*number] = place);
    let of_rows = numbers.into_iter().map(|number| number.map(|number| places[number]));
    let sorted = order.iter().map(|number| groups[*number].clone()).collect();
    Ok((sorted, of_rows.collect()))
}

fn table(rows: &[Agreement]) -> Result<Table, ReplayError> {
    let text = |name, description, get: fn(&Agreement) -> &str| {
        Column::text(name, description, rows.iter().map(|r| Some(get(r).to_owned())))
    };
    let mut columns = vec![
        text("causality", "what went into the model and what came out", |r| &r.of[0]),
        text("mode", "how it was rendered", |r| &r.of[1]),
        text("model", "whose plant: by_eye, the thesis'; fitted, this study's", |r| &r.of[2]),
        text("quantity", "what is compared, one value per trial", |r| r.quantity),
        text("unit", "unit of the numbers in this row", |r| r.unit),
        Column::integer("n", "1", "trials", rows.iter().map(|r| Some(r.n as i64))),
    ];
    let number = |name, description, get: fn(&Agreement) -> Option<f64>| {
        Column::float(name, UNIT_OF_ROW, description, rows.iter().map(get))
    };
    columns.push(Column::text(
        "verdict",
        "alike, off, scattered or too few: bias and limits against the bound",
        rows.iter().map(|r| Some(r.verdict.as_str().to_owned())),
    ));
    columns.extend([
        number("bound", "up to here a difference does not matter", |r| r.bound),
        number("bias", "mean of model less recording", |r| r.bias.map(|e| e.estimate)),
        number("bias_ci_low", "lower end of its interval", |r| r.bias.map(|e| e.ci_low)),
        number("bias_ci_high", "upper end of its interval", |r| r.bias.map(|e| e.ci_high)),
        number("limit_low", "lower limit of agreement, bias - 1.96 SD", |r| {
            r.low.map(|e| e.estimate)
        }),
        number("limit_low_ci_low", "lower end of its interval", |r| r.low.map(|e| e.ci_low)),
        number("limit_low_ci_high", "upper end of its interval", |r| r.low.map(|e| e.ci_high)),
        number("limit_high", "upper limit of agreement, bias + 1.96 SD", |r| {
            r.high.map(|e| e.estimate)
        }),
        number("limit_high_ci_low", "lower end of its interval", |r| r.high.map(|e| e.ci_low)),
        number("limit_high_ci_high", "upper end of its interval", |r| r.high.map(|e| e.ci_high)),
    ]);
    let title = "Agreement of replay and recording (Bland and Altman), one value per trial";
    Ok(Table::new("replay.agreement", title, columns)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plain Python with d = [0.1, 0.3, -0.2, 0.4, 0.15], m and s its mean and sample SD, t =
    /// 2.7764451051977987 (the tables' t for 4 degrees of freedom): m, m - t s / sqrt(5), m -
    /// 1.96 s, that ± t s sqrt(1/5 + 1.96² / 8), m + 1.96 s.
    #[test]
    fn bias_and_limits_are_those_of_the_formulas() {
        let [bias, low, high] =
            limits(&[0.1, 0.3, -0.2, 0.4, 0.15], 0.95).unwrap().map(Option::unwrap);
        let found =
            [bias.estimate, bias.ci_low, low.estimate, low.ci_low, low.ci_high, high.estimate];
        for (found, python) in found.iter().zip(PYTHON) {
            assert!((found - python).abs() < 1e-12, "{found} instead of {python}");
        }
    }

    const PYTHON: [f64; 6] = [
        0.15,
        -0.1345009634655928,
        -0.29909241810567233,
        -0.8237634147520515,
        0.22557857854070684,
        0.5990924181056723,
    ];

    #[test]
    fn one_trial_has_no_limits() {
        assert_eq!(limits(&[0.1], 0.95).unwrap(), [None; 3]);
    }

    #[test]
    fn rows_are_by_causality_and_mode_and_null_differences_do_not_count() {
        let text =
            |name, values: [&str; 4]| Column::text(name, "", values.map(|v| Some(v.to_owned())));
        let mut columns = vec![
            text("causality", ["closed_loop", "force_driven", "force_driven", "force_driven"]),
            text("mode", ["active"; 4]),
            text("model", ["by_eye"; 4]),
            text("source", ["recorded"; 4]),
        ];
        let values = [Some(1.0), Some(2.0), Some(4.0), None];
        columns.extend(QUANTITIES.map(|(column, ..)| Column::float(column, "", "", values)));
        columns.push(Column::float("peak_recorded_n", "", "", [Some(40.0); 4]));
        let table = agreement(&Table::new("replay", "", columns).unwrap(), 0.95).unwrap();
        assert_eq!(table.height(), 8);
        assert_eq!(table.texts("causality").unwrap()[0].as_deref(), Some("force_driven"));
        assert_eq!(table.integers("n").unwrap()[0], Some(2));
        assert_eq!(
            (table.floats("bias").unwrap()[0], table.floats("bias").unwrap()[4]),
            (Some(3.0), None)
        );
    }

    /// Differences of peak angles in degrees, and what is said of them.
    #[test]
    fn a_bias_or_a_scatter_beyond_what_can_be_told_is_said() {
        let verdict = |degrees: [f64; 4], source: &str| {
            let text = |name, value: &str| Column::text(name, "", vec![Some(value.to_owned()); 4]);
            let columns = vec![
                text("causality", "closed_loop"),
                text("mode", "active"),
                text("model", "fitted"),
                text("source", source),
                Column::float("peak_error_rad", "", "", degrees.map(|d| Some(d.to_radians()))),
                Column::float("peak_error_n", "", "", [None; 4]),
                Column::float("peak_time_error_s", "", "", [None; 4]),
                Column::float("reversal_error_s", "", "", [None; 4]),
                Column::float("peak_recorded_n", "", "", [None; 4]),
            ];
            let found = agreement(&Table::new("replay", "", columns).unwrap(), 0.95).unwrap();
            let word = found.texts("verdict").unwrap().remove(0).unwrap();
            (word, found.notes().join(" "))
        };
        assert_eq!(verdict([0.1, -0.1, 0.2, 0.0], "recorded").0, "alike");
        assert_eq!(verdict([-59.0, -58.0, -60.0, -59.0], "recorded").0, "off");
        assert_eq!(verdict([4.0, -4.0, 3.0, -3.0], "recorded").0, "scattered");
        assert!(verdict([0.0; 4], "recorded").1.contains("adds up along a trial"));
        assert!(!verdict([0.0; 4], "recorded").1.contains("Simulated"));
        assert!(verdict([0.0; 4], "twin").1.contains("Simulated trials"));
    }
}
