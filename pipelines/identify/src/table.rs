//! The results of the stage as rows.

use crate::{Bracket, Estimate, Identified};
use std::collections::BTreeMap;
use zwidth_results::{
    FitPart, HeldOutError, OneOrAll, PlantCovariance, PlantEstimate, PlantProfile, PlantTrialError,
    Threshold, ThresholdBracket, UnitProduct,
};
use zwidth_study::Condition;
use zwidth_tables::{Table, TableError};

/// The table of the parameters, with what they rest on below.
///
/// # Errors
/// A number that is not finite.
pub fn estimates_table(identified: &Identified) -> Result<Table, TableError> {
    let rows: Vec<PlantEstimate> = identified.estimates.iter().map(PlantEstimate::from).collect();
    let fitted = identified.trials.iter().filter(|t| t.part == FitPart::Fitted).count();
    let held_out = identified.trials.len() - fitted;
    let note = format!("Fitted to {fitted} trials; {held_out} others were held out.");
    let table = Table::of_rows(&rows)?.with_note(note);
    Ok(match identified.converged {
        true => table,
        false => table.with_note("The fit used up its steps before it met its stopping rule."),
    })
}

/// The table of the parameters without rows, with the reason.
///
/// # Errors
/// None.
pub fn nothing_fitted(why: &str) -> Result<Table, TableError> {
    let table = Table::of_rows::<PlantEstimate>(&[])?;
    Ok(table.with_note(format!("Nothing was fitted: {why}.")))
}

impl From<&Estimate> for PlantEstimate {
    fn from(estimate: &Estimate) -> Self {
        let parameter = estimate.parameter;
        Self {
            parameter: parameter.name,
            unit: parameter.unit.into(),
            by_eye: parameter.by_eye,
            fitted: estimate.fitted,
            std_error: estimate.std_error,
            df: estimate.df,
            ci_low: estimate.interval.map(|(low, _)| low),
            ci_high: estimate.interval.map(|(_, high)| high),
            lower_bound: parameter.lower,
            upper_bound: parameter.upper,
            variance_inflation: estimate.inflation,
            verdict: estimate.verdict,
        }
    }
}

/// The covariance of the parameters, each pair once and each with itself; none if there is no
/// covariance.
pub fn covariances(identified: &Identified) -> Vec<PlantCovariance> {
    let Some(v) = &identified.covariance else { return Vec::new() };
    let mut rows = Vec::new();
    for (j, one) in identified.estimates.iter().enumerate() {
        for (k, other) in identified.estimates.iter().enumerate().skip(j) {
            // 0 with a parameter on its bound, which has no correlation.
            let most = (v[j][j] * v[k][k]).sqrt();
            rows.push(PlantCovariance {
                parameter: one.parameter.name,
                other: other.parameter.name,
                unit: UnitProduct(one.parameter.unit.into(), other.parameter.unit.into()),
                covariance: v[j][k],
                correlation: if most > 0.0 { v[j][k] / most } else { 0.0 },
            });
        }
    }
    rows
}

/// The profiles: how the error changes if a parameter is held at a value and the others are fitted
/// again.
pub fn profiles(estimates: &[Estimate]) -> Vec<PlantProfile> {
    estimates.iter().flat_map(|estimate| estimate.profile.clone()).collect()
}

/// The forces between which the brake's let-go threshold lies, beside the one that was set; none
/// without a trial that could show it.
pub fn threshold(bracket: &Bracket, set_n: f64) -> Option<ThresholdBracket> {
    let Bracket { low_n, high_n, releases } = *bracket;
    let is_shown = low_n.is_some() || high_n.is_some();
    let threshold = Threshold::LetGo;
    is_shown.then_some(ThresholdBracket { threshold, low_n, high_n, releases, set_n })
}

/// By eye against fitted on the trials held out, by condition and over all of them: root mean
/// square over the trials.
pub fn held_out(trials: &[PlantTrialError]) -> Vec<HeldOutError> {
    let held: Vec<&PlantTrialError> =
        trials.iter().filter(|trial| trial.part == FitPart::HeldOut).collect();
    let mut conditions: BTreeMap<Condition, Vec<&PlantTrialError>> = BTreeMap::new();
    for &trial in &held {
        let environment = trial.environment.clone();
        let condition = Condition { environment, mode: trial.mode.clone() };
        conditions.entry(condition).or_default().push(trial);
    }
    let mut rows = Vec::new();
    for (Condition { environment, mode }, own) in conditions {
        rows.push(pooled(OneOrAll::One(environment), OneOrAll::One(mode), &own));
    }
    rows.push(pooled(OneOrAll::All, OneOrAll::All, &held));
    rows
}

/// The errors of some trials together.
fn pooled(
    environment: OneOrAll<zwidth_study::EnvironmentId>,
    mode: OneOrAll<zwidth_study::ModeId>,
    trials: &[&PlantTrialError],
) -> HeldOutError {
    let rmse_by_eye_rad = root_mean_square(trials.iter().map(|trial| trial.rmse_by_eye_rad));
    let rmse_fitted_rad = root_mean_square(trials.iter().map(|trial| trial.rmse_fitted_rad));
    let both = rmse_by_eye_rad.zip(rmse_fitted_rad).filter(|(by_eye, _)| *by_eye > 0.0);
    HeldOutError {
        environment,
        mode,
        n: trials.len(),
        rmse_by_eye_rad,
        rmse_fitted_rad,
        fitted_over_by_eye: both.map(|(by_eye, fitted)| fitted / by_eye),
    }
}

/// √mean of the squared errors; `None` without trials or where one has no error.
fn root_mean_square(errors: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let errors: Vec<f64> = errors.collect::<Option<_>>()?;
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::metas;
    use zwidth_results::Row;

    #[test]
    fn held_out_trials_are_pooled_by_condition_and_over_all() {
        let errors = [3.0, 4.0, 100.0];
        let row = |(meta, error): (zwidth_study::TrialMeta, f64)| PlantTrialError {
            participant: meta.participant,
            session: meta.session,
            trial: meta.trial,
            repeat: meta.repeat,
            environment: meta.environment,
            mode: meta.mode,
            source: meta.source,
            part: if error < 50.0 { FitPart::HeldOut } else { FitPart::Fitted },
            rmse_by_eye_rad: Some(2.0 * error),
            rmse_fitted_rad: Some(error),
            rmse_left_out_rad: None,
        };
        let trials: Vec<PlantTrialError> = metas(3).into_iter().zip(errors).map(row).collect();
        let rows = held_out(&trials);
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[0].mode.to_string().as_str(), &rows[1].mode), ("active", &OneOrAll::All));
        assert!((rows[1].rmse_fitted_rad.unwrap() - 12.5_f64.sqrt()).abs() < 1e-15);
        assert!(rows.iter().all(|row| row.fitted_over_by_eye == Some(0.5)));
        assert_eq!(HeldOutError::read(&HeldOutError::columns(&rows)).unwrap(), rows);
        assert_eq!(PlantTrialError::read(&PlantTrialError::columns(&trials)).unwrap(), trials);
    }
}
