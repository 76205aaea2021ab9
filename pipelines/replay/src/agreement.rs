//! Bland–Altman agreement of peaks and times, trial by trial.
//!
//! Bland & Altman (1986), Lancet 327:307; intervals of the limits: Bland & Altman (1999), Stat.
//! Methods Med. Res. 8:135.

use crate::ReplayError;
use zwidth_stats::interval::{Estimate, mean, t_interval};
use zwidth_tables::{Column, Table};

/// Standard deviations between bias and limits: 95 % of normal differences lie between the limits.
const LIMIT_SDS: f64 = 1.96;

/// Column of the differences, what they are of, their unit.
const QUANTITIES: [(&str, &str, &str); 4] = [
    ("peak_error_rad", "peak angle", "rad"),
    ("peak_error_n", "peak force", "N"),
    ("peak_time_error_s", "time of the peak", "s"),
    ("reversal_error_s", "time of the reversal", "s"),
];

/// One quantity in one causality and mode.
struct Agreement {
    causality: String,
    mode: String,
    quantity: &'static str,
    unit: &'static str,
    n: usize,
    bias: Option<Estimate>,
    low: Option<Estimate>,
    high: Option<Estimate>,
}

/// For each causality, mode and quantity of the table of replays: n trials, the bias (mean of model
/// less recording) and the limits of agreement (bias ± 1.96 SD) with their t intervals at `level`;
/// null below two trials. Trials of one person are taken for independent, so with few people the
/// intervals are too narrow.
///
/// # Errors
/// A table that lacks a column, a level outside (0, 1).
pub fn agreement(replays: &Table, level: f64) -> Result<Table, ReplayError> {
    let mut found = Vec::new();
    for (causality, mode) in groups(replays)? {
        for (column, quantity, unit) in QUANTITIES {
            let differences = differences(replays, column, &causality, &mode)?;
            if differences.is_empty() {
                continue;
            }
            let [bias, low, high] = limits(&differences, level)?;
            let (causality, mode) = (causality.clone(), mode.clone());
            let n = differences.len();
            found.push(Agreement { causality, mode, quantity, unit, n, bias, low, high });
        }
    }
    table(&found)
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

/// Causality and mode of the rows, each pair once, in the order of the rows, by causality.
fn groups(replays: &Table) -> Result<Vec<(String, String)>, ReplayError> {
    let rows = replays.texts("causality")?.into_iter().zip(replays.texts("mode")?);
    let mut groups: Vec<(String, String)> = Vec::new();
    for group in rows.filter_map(|(causality, mode)| causality.zip(mode)) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups.sort_by_key(|(causality, _)| {
        crate::Causality::ALL.iter().position(|c| c.as_str() == causality)
    });
    Ok(groups)
}

fn differences(
    table: &Table,
    column: &str,
    causality: &str,
    mode: &str,
) -> Result<Vec<f64>, ReplayError> {
    let (causalities, modes) = (table.texts("causality")?, table.texts("mode")?);
    let mine = |i: &usize| {
        causalities[*i].as_deref() == Some(causality) && modes[*i].as_deref() == Some(mode)
    };
    let values = table.floats(column)?;
    Ok((0..values.len()).filter(mine).filter_map(|i| values[i]).collect())
}

fn table(rows: &[Agreement]) -> Result<Table, ReplayError> {
    let text = |name, description, get: fn(&Agreement) -> &str| {
        Column::text(name, description, rows.iter().map(|r| Some(get(r).to_owned())))
    };
    let mut columns = vec![
        text("causality", "what went into the model and what came out", |r| &r.causality),
        text("mode", "how it was rendered", |r| &r.mode),
        text("quantity", "what is compared, one value a trial", |r| r.quantity),
        text("unit", "unit of the numbers in this row", |r| r.unit),
        Column::integer("n", "1", "trials", rows.iter().map(|r| Some(r.n as i64))),
    ];
    let number = |name, description, get: fn(&Agreement) -> Option<f64>| {
        Column::float(name, "1", description, rows.iter().map(get))
    };
    columns.extend([
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
    let title = "Agreement of replay and recording (Bland and Altman), one value a trial";
    let note = "Trials are taken for independent; repeats of one person are not, so intervals are too narrow \
                for people in general.";
    Ok(Table::new("replay.agreement", title, columns)?.with_note(note))
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
        ];
        let values = [Some(1.0), Some(2.0), Some(4.0), None];
        columns.extend(QUANTITIES.map(|(column, _, _)| Column::float(column, "", "", values)));
        let table = agreement(&Table::new("replay", "", columns).unwrap(), 0.95).unwrap();
        assert_eq!(table.height(), 8);
        assert_eq!(table.texts("causality").unwrap()[0].as_deref(), Some("force_driven"));
        assert_eq!(table.integers("n").unwrap()[0], Some(2));
        assert_eq!(
            (table.floats("bias").unwrap()[0], table.floats("bias").unwrap()[4]),
            (Some(3.0), None)
        );
    }
}
