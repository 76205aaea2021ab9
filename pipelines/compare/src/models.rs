//! The mixed model beside the paired differences: one row per environment and contrast.
//!
//! Trials are the rows; participants and their combinations with mode and session are random, as
//! many as the design can separate. A participant who lacks a mode stays in the model (missing at
//! random).

use crate::Parameters;
use crate::measure::Measure;
use crate::trials::Trials;
use zwidth_results::{Model, UnitOfAnalysis};
use zwidth_stats::lmm::trials::{self as lmm, Term, TrialFit, fit_trials};

/// The trials of one environment that have the metric, by the places of their names.
#[derive(Debug, Clone, PartialEq, Default)]
struct Rows {
    participant: Vec<usize>,
    session: Vec<usize>,
    mode: Vec<usize>,
    value: Vec<f64>,
}

/// Every contrast by the mixed model of its environment; no row with one participant.
pub(crate) fn models(
    trials: &Trials,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<Model> {
    if *unit != UnitOfAnalysis::Participants {
        return Vec::new();
    }
    let mut environments = vec![Rows::default(); parameters.environments.len()];
    for trial in &trials.trials {
        let Some(value) = trial.value else { continue };
        let rows = &mut environments[trial.environment];
        rows.participant.push(trial.participant);
        rows.session.push(trial.session);
        rows.mode.push(trial.mode);
        rows.value.push(value);
    }
    let mut models = Vec::new();
    for (environment, rows) in environments.iter().enumerate() {
        let fit = fit_trials(lmm::Trials {
            participant: &rows.participant,
            session: &rows.session,
            mode: &rows.mode,
            value: &rows.value,
        });
        for contrast in &parameters.contrasts {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            if !modes.iter().all(|mode| rows.mode.contains(mode)) {
                continue;
            }
            let kenward_roger = fit.as_ref().map_err(Clone::clone).and_then(|fit| {
                let weights = fit.difference(modes[0], modes[1]);
                fit.fit.kenward_roger()?.test(&weights?, parameters.level)
            });
            let fitted = fit.as_ref().ok();
            // Only beside Kenward and Roger's, so its failure leaves no remark.
            let satterthwaite = fitted.and_then(|fit| {
                let weights = fit.difference(modes[0], modes[1]).ok()?;
                fit.fit.satterthwaite().ok()?.test(&weights, parameters.level).ok()
            });
            let tested = kenward_roger.as_ref().ok();
            models.push(Model {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments[environment].clone(),
                contrast: contrast.clone(),
                n: fitted.map(|fit| fit.fit.groups),
                trials: rows.value.len(),
                difference: tested.map(|t| t.estimate),
                difference_std_error: tested.map(|t| t.std_error),
                difference_ci_low: tested.map(|t| t.ci_low),
                difference_ci_high: tested.map(|t| t.ci_high),
                df: tested.map(|t| t.df),
                p_value: tested.map(|t| t.p_value),
                df_satterthwaite: satterthwaite.as_ref().map(|t| t.df),
                p_satterthwaite: satterthwaite.as_ref().map(|t| t.p_value),
                participant_sd: fitted.and_then(|fit| deviation(fit, Term::Participant)),
                participant_mode_sd: fitted.and_then(|fit| deviation(fit, Term::ParticipantMode)),
                residual_sd: fitted.map(|fit| fit.fit.residual_variance.sqrt()),
                random_terms: fitted.map(|fit| {
                    fit.structure.iter().map(|term| term.as_str()).collect::<Vec<_>>().join(", ")
                }),
                singular: fitted.map(|fit| fit.fit.singular),
                remark: kenward_roger.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    models
}

/// The standard deviation of a term; `None` for one that the model does not have.
fn deviation(fit: &TrialFit, term: Term) -> Option<f64> {
    let place = fit.structure.iter().position(|t| *t == term)?;
    let variance = *fit.fit.terms.get(place)?.covariance.first()?.first()?;
    Some(variance.max(0.0).sqrt())
}
