//! The fit as tables.

use crate::{Bracket, Estimate, Identified, Part, Point, TrialErrors};
use zwidth_study::Condition;
use zwidth_tables::{Column, Table, TableError, identity};

/// The parameters, one row each: by eye, fitted, interval, verdict. In the unit of the row.
///
/// # Errors
/// A number that is not finite.
pub fn estimates(found: &Identified) -> Result<Table, TableError> {
    let fitted = found.trials.iter().filter(|t| t.part == Part::Fitted).count();
    let held_out = found.trials.len() - fitted;
    let note = format!("Fitted to {fitted} trials; {held_out} others were held out.");
    let table = parameters(&found.estimates)?.with_note(note);
    Ok(match found.converged {
        true => table,
        false => table.with_note("The fit used up its steps before it met its stopping rule."),
    })
}

/// The same table without rows, and why.
///
/// # Errors
/// None.
pub fn nothing_fitted(why: &str) -> Result<Table, TableError> {
    Ok(parameters(&[])?.with_note(format!("Nothing was fitted: {why}.")))
}

fn parameters(rows: &[Estimate]) -> Result<Table, TableError> {
    let text = |name, description, get: fn(&Estimate) -> &str| {
        Column::text(name, description, rows.iter().map(|r| Some(get(r).to_owned())))
    };
    let number = |name, description, get: fn(&Estimate) -> Option<f64>| {
        Column::float(name, "1", description, rows.iter().map(get))
    };
    let columns = vec![
        text("parameter", "which parameter of the plant", |r| r.parameter.name),
        text("unit", "unit of the numbers in this row", |r| r.parameter.unit),
        number("by_eye", "chosen by eye in the thesis", |r| Some(r.parameter.by_eye)),
        number("fitted", "least squares", |r| Some(r.fitted)),
        number("std_error", "standard error, by leaving out each trial in turn", |r| r.std_error),
        number("df", "effective degrees of freedom of the standard error", |r| r.df),
        number("ci_low", "lower end of the interval", |r| r.interval.map(|i| i.0)),
        number("ci_high", "upper end of the interval", |r| r.interval.map(|i| i.1)),
        number("lower_bound", "smallest value allowed", |r| Some(r.parameter.lower)),
        number("upper_bound", "largest value allowed", |r| Some(r.parameter.upper)),
        number("variance_inflation", "variance over that with the others known", |r| r.inflation),
        text("verdict", "whether the trials say what it is", |r| r.verdict.as_str()),
    ];
    Table::new("identify", "The plant, by eye and fitted", columns)
}

/// The covariance of the parameters, one row per pair, each pair once and each with itself; none
/// where there is no covariance.
///
/// # Errors
/// A number that is not finite.
pub fn covariances(found: Option<&Identified>) -> Result<Table, TableError> {
    let known = found.and_then(|f| Some((&f.estimates, f.covariance.as_ref()?)));
    let pairs: Vec<(&Estimate, &Estimate, f64, f64)> = known
        .into_iter()
        .flat_map(|(estimates, v)| {
            let of = |j: usize, k: usize| {
                let most = (v[j][j] * v[k][k]).sqrt();
                (
                    &estimates[j],
                    &estimates[k],
                    v[j][k],
                    if most > 0.0 { v[j][k] / most } else { 0.0 },
                )
            };
            (0..v.len()).flat_map(move |j| (j..v.len()).map(move |k| of(j, k)))
        })
        .collect();
    let text = |name, about, get: fn(&(&Estimate, &Estimate, f64, f64)) -> String| {
        Column::text(name, about, pairs.iter().map(move |pair| Some(get(pair))))
    };
    let number = |name, about, get: fn(&(&Estimate, &Estimate, f64, f64)) -> f64| {
        Column::float(name, "1", about, pairs.iter().map(move |pair| Some(get(pair))))
    };
    let columns = vec![
        text("parameter", "which parameter of the plant", |p| p.0.parameter.name.to_owned()),
        text("other", "which other one, or the same", |p| p.1.parameter.name.to_owned()),
        text("unit", "unit of the covariance", |p| {
            format!("{} · {}", p.0.parameter.unit, p.1.parameter.unit)
        }),
        number("covariance", "by leaving out each trial in turn", |p| p.2),
        number("correlation", "over the product of both standard errors", |p| p.3),
    ];
    let title = "Covariance of the plant's parameters";
    Table::new("identify.covariance", title, columns)
}

/// The profiles, one row a point: what becomes of the error when a parameter is held at a value and
/// the others are fitted anew.
///
/// # Errors
/// A number that is not finite.
pub fn profiles(estimates: &[Estimate]) -> Result<Table, TableError> {
    let rows: Vec<(&Estimate, &Point)> =
        estimates.iter().flat_map(|e| e.profile.iter().map(move |point| (e, point))).collect();
    let text = |name, description, get: fn(&Estimate) -> &str| {
        Column::text(name, description, rows.iter().map(|(e, _)| Some(get(e).to_owned())))
    };
    let number = |name, description, get: fn(&Point) -> f64| {
        Column::float(name, "1", description, rows.iter().map(|(_, point)| Some(get(point))))
    };
    let columns = vec![
        text("parameter", "which parameter of the plant", |e| e.parameter.name),
        text("unit", "unit of the value", |e| e.parameter.unit),
        number("value", "where the parameter is held", |p| p.value),
        number(
            "relative_error",
            "sum of squares with the others fitted anew, over that of the fit",
            |p| p.relative_error,
        ),
        number("likelihood_ratio", "how much less likely than the fit, -2 ln of the ratio", |p| {
            p.likelihood_ratio
        }),
    ];
    Table::new("identify.profile", "Profiles of the plant's parameters", columns)
}

/// Between which forces the brake's let-go threshold lies, one row, beside the one that was set;
/// none without a trial in which it could show.
///
/// # Errors
/// A number that is not finite.
pub fn threshold(found: &Bracket, set_n: f64) -> Result<Table, TableError> {
    let is_there = found.low_n.is_some() || found.high_n.is_some();
    let rows = || is_there.then_some(found).into_iter();
    let number = |name, description, get: &dyn Fn(&Bracket) -> Option<f64>| {
        Column::float(name, "N", description, rows().map(get).collect::<Vec<_>>())
    };
    let columns = vec![
        Column::text("threshold", "which threshold", rows().map(|_| Some("let_go".to_owned()))),
        number("low_n", "largest force at which the brake let go", &|b| b.low_n),
        number("high_n", "smallest at which it held a lever that did not move on", &|b| b.high_n),
        Column::integer(
            "releases",
            "1",
            "times it let go",
            rows().map(|b| Some(b.releases as i64)),
        ),
        number("set_n", "what the study set", &|_| Some(set_n)),
    ];
    Table::new("identify.threshold", "The brake's let-go threshold, bracketed", columns)
}

/// The errors, one row per trial.
///
/// # Errors
/// A number that is not finite.
pub fn trials(trials: &[TrialErrors]) -> Result<Table, TableError> {
    let mut columns = identity(&trials.iter().map(|t| &t.meta).collect::<Vec<_>>());
    let part = |t: &TrialErrors| Some(part_word(t.part).to_owned());
    columns.push(Column::text(
        "part",
        "fitted, or held out and only judged",
        trials.iter().map(part),
    ));
    let number = |name, description, get: fn(&TrialErrors) -> Option<f64>| {
        Column::float(name, "rad", description, trials.iter().map(get))
    };
    columns.extend([
        number("rmse_by_eye_rad", "root mean square error of the angle, by eye", |t| {
            t.rmse_by_eye_rad
        }),
        number("rmse_fitted_rad", "that of the fit", |t| t.rmse_fitted_rad),
        number("rmse_left_out_rad", "that of a fit without this trial", |t| t.rmse_left_out_rad),
    ]);
    Table::new(
        "identify.trials",
        "Errors of the plant, by eye and fitted, one row per trial",
        columns,
    )
}

fn part_word(part: Part) -> &'static str {
    match part {
        Part::Fitted => "fitted",
        Part::HeldOut => "held_out",
    }
}

/// By eye against fitted on the trials held out, by condition and over all of them: root mean
/// square over the trials.
///
/// # Errors
/// A number that is not finite.
pub fn against_eye(trials: &[TrialErrors]) -> Result<Table, TableError> {
    let held: Vec<&TrialErrors> = trials.iter().filter(|t| t.part == Part::HeldOut).collect();
    let mut conditions: Vec<Condition> = held.iter().map(|t| t.meta.condition()).collect();
    conditions.sort();
    conditions.dedup();
    let of = |condition: &Condition| {
        held.iter().copied().filter(|t| t.meta.condition() == *condition).collect::<Vec<_>>()
    };
    let mut rows: Vec<(Option<&Condition>, Vec<&TrialErrors>)> =
        conditions.iter().map(|c| (Some(c), of(c))).collect();
    rows.push((None, held.clone()));
    let word = |name, description, get: fn(&Condition) -> &str| {
        let word = |condition: Option<&Condition>| Some(condition.map_or("all", get).to_owned());
        Column::text(name, description, rows.iter().map(|(c, _)| word(*c)))
    };
    let error = |get: fn(&TrialErrors) -> Option<f64>| {
        rows.iter().map(move |(_, trials)| pooled(trials, get)).collect::<Vec<_>>()
    };
    let (eye, fitted) = (error(|t| t.rmse_by_eye_rad), error(|t| t.rmse_fitted_rad));
    let ratio: Vec<_> = eye
        .iter()
        .zip(&fitted)
        .map(|(e, f)| e.zip(*f).filter(|p| p.0 > 0.0).map(|(e, f)| f / e))
        .collect();
    let columns = vec![
        word("environment", "what was rendered", |c| c.environment.as_str()),
        word("mode", "how it was rendered", |c| c.mode.as_str()),
        Column::integer(
            "n",
            "1",
            "trials held out",
            rows.iter().map(|(_, t)| Some(t.len() as i64)),
        ),
        Column::float("rmse_by_eye_rad", "rad", "root mean square error of the angle, by eye", eye),
        Column::float("rmse_fitted_rad", "rad", "that of the fit", fitted),
        Column::float(
            "fitted_over_by_eye",
            "1",
            "the second over the first: below 1 the fit is better",
            ratio,
        ),
    ];
    let title = "The plant by eye against fitted, on trials held out of the fit";
    Table::new("identify.held_out", title, columns)
}

/// √mean of the squared errors; `None` without trials or where one has no error.
fn pooled(trials: &[&TrialErrors], get: fn(&TrialErrors) -> Option<f64>) -> Option<f64> {
    let errors: Vec<f64> = trials.iter().map(|t| get(t)).collect::<Option<_>>()?;
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::metas;

    #[test]
    fn held_out_trials_are_pooled_by_condition_and_over_all() {
        let errors = [3.0, 4.0, 100.0];
        let row = |(meta, error): (zwidth_study::TrialMeta, f64)| TrialErrors {
            part: if error < 50.0 { Part::HeldOut } else { Part::Fitted },
            meta,
            rmse_by_eye_rad: Some(2.0 * error),
            rmse_fitted_rad: Some(error),
            rmse_left_out_rad: None,
        };
        let rows: Vec<TrialErrors> = metas(3).into_iter().zip(errors).map(row).collect();
        let table = against_eye(&rows).unwrap();
        assert_eq!(
            table.texts("mode").unwrap(),
            [Some("active".to_owned()), Some("all".to_owned())]
        );
        let pooled = table.floats("rmse_fitted_rad").unwrap()[1].unwrap();
        assert!((pooled - 12.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(table.floats("fitted_over_by_eye").unwrap(), [Some(0.5); 2]);
        assert_eq!(trials(&rows).unwrap().height(), 3);
    }
}
