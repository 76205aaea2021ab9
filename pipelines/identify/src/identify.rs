//! From recordings to parameters, and errors of trials that the fit has and has not seen.

use crate::IdentifyError;
use crate::estimate::{Estimate, estimates, free, stepped};
use crate::fit::{Block, Predict, Problem, sum};
use crate::slopes::Parameter;
use rayon::prelude::*;
use zwidth_study::TrialMeta;

/// A trial whose θ is to be predicted.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// Which trial.
    pub meta: &'a TrialMeta,
    /// θ of every sample, rad.
    pub theta_rad: &'a [f64],
}

/// What a trial was used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// It was fitted.
    Fitted,
    /// It was only judged.
    HeldOut,
}

/// Errors of the model's θ on one trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialErrors {
    /// Which trial.
    pub meta: TrialMeta,
    /// What it was used for.
    pub part: Part,
    /// Root mean square error by eye, rad; `None` where the model does not run.
    pub rmse_by_eye_rad: Option<f64>,
    /// That of the fit.
    pub rmse_fitted_rad: Option<f64>,
    /// That with the parameters that the other fitted trials give; `None` for trials held out.
    pub rmse_left_out_rad: Option<f64>,
}

/// Fitted parameters, and how good they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified<const P: usize> {
    /// The parameters.
    pub estimates: [Estimate; P],
    /// Errors, in the order of the recordings.
    pub trials: Vec<TrialErrors>,
    /// Whether the fit met its stopping rule.
    pub converged: bool,
}

impl<const P: usize> Identified<P> {
    /// The fitted values.
    pub fn fitted(&self) -> [f64; P] {
        self.estimates.map(|e| e.fitted)
    }
}

/// Fits `parameters` to half of the recordings and judges them on the other; intervals at `level`.
///
/// `predict(i, p)` gives θ (rad) of every sample of recording `i` at parameters `p`, or `None` where the model does not
/// run there. The fit begins at the choice by eye and at every one of `starts`.
///
/// # Errors
/// Fewer than two trials to fit, a model that runs from no start, a level outside (0, 1).
pub fn identify<const P: usize>(
    recordings: &[Recording],
    parameters: &[Parameter; P],
    starts: &[[f64; P]],
    level: f64,
    predict: impl Fn(usize, &[f64; P]) -> Option<Vec<f64>> + Sync,
) -> Result<Identified<P>, IdentifyError> {
    let parts = parts(recordings);
    let fitted: Vec<usize> = (0..parts.len()).filter(|i| parts[*i] == Part::Fitted).collect();
    if fitted.len() < 2 {
        return Err(IdentifyError::TooFew { trials: fitted.len() });
    }
    let observed: Vec<&[f64]> = recordings.iter().map(|r| r.theta_rad).collect();
    let problem = Problem { trials: &fitted, observed: &observed, parameters, predict: &predict };
    let by_eye = parameters.map(|p| p.by_eye);
    let starts: Vec<[f64; P]> = [by_eye].into_iter().chain(starts.iter().copied()).collect();
    let minimum = problem.fit(&starts)?;
    let blocks = problem.blocks(&minimum.parameters);
    let left_out = without_each(parameters, &minimum.parameters, &blocks);
    let one = |(i, recording): (usize, &Recording)| {
        let error = |p: &[f64; P]| rmse(&predict, i, p, recording.theta_rad);
        let place = fitted.binary_search(&i).ok();
        TrialErrors {
            meta: recording.meta.clone(),
            part: parts[i],
            rmse_by_eye_rad: error(&by_eye),
            rmse_fitted_rad: error(&minimum.parameters),
            rmse_left_out_rad: place.and_then(|k| left_out[k]).and_then(|p| error(&p)),
        }
    };
    Ok(Identified {
        estimates: estimates(&problem, &minimum, &blocks, level)?,
        trials: recordings.par_iter().enumerate().map(one).collect(),
        converged: minimum.converged,
    })
}

/// Every other repeat of a condition is held out, by participant and session.
fn parts(recordings: &[Recording]) -> Vec<Part> {
    let same = |a: &TrialMeta, b: &TrialMeta| {
        a.participant == b.participant && a.session == b.session && a.condition() == b.condition()
    };
    let part = |i: usize| {
        let before = recordings[..i].iter().filter(|r| same(r.meta, recordings[i].meta)).count();
        if before.is_multiple_of(2) { Part::Fitted } else { Part::HeldOut }
    };
    (0..recordings.len()).map(part).collect()
}

/// The parameters that the other trials give, for each; `None` where they do not determine them.
fn without_each<const P: usize>(
    parameters: &[Parameter; P],
    at: &[f64; P],
    blocks: &[Block<P>],
) -> Vec<Option<[f64; P]>> {
    let free = free(parameters, at, &sum(blocks));
    let without = |k: usize| {
        let others = blocks.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, block)| block);
        stepped(parameters, at, &free, &sum(others))
    };
    (0..blocks.len()).map(without).collect()
}

fn rmse<const P: usize>(predict: Predict<P>, trial: usize, p: &[f64; P], observed: &[f64]) -> Option<f64> {
    let predicted = predict(trial, p).filter(|found| found.len() == observed.len() && !found.is_empty())?;
    let squares: f64 = predicted.iter().zip(observed).map(|(p, o)| (p - o) * (p - o)).sum();
    Some((squares / observed.len() as f64).sqrt()).filter(|rmse| rmse.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Verdict;
    use crate::testing::{PARAMETERS, STARTS, TRUE, metas, pushed};

    #[test]
    fn what_was_simulated_is_recovered_and_beats_the_eye_on_trials_it_has_not_seen() {
        let metas = metas(8);
        let theta: Vec<Vec<f64>> = (0..8).map(|i| pushed(i, &TRUE).unwrap()).collect();
        let recordings: Vec<_> =
            metas.iter().zip(&theta).map(|(meta, theta_rad)| Recording { meta, theta_rad }).collect();
        let found = identify(&recordings, &PARAMETERS, &STARTS, 0.95, pushed).unwrap();
        for (fitted, expect) in found.fitted().iter().zip(TRUE) {
            assert!((fitted / expect - 1.0).abs() < 1e-6, "{fitted} instead of {expect}");
        }
        assert!(found.estimates.iter().all(|e| e.verdict == Verdict::Identifiable), "{found:?}");
        for Estimate { profile, .. } in found.estimates {
            assert!(
                profile.fitted < 1e-7 && profile.halved.unwrap() > 1e-4 && profile.doubled.unwrap() > 1e-4
            );
        }
        let held: Vec<_> = found.trials.iter().filter(|t| t.part == Part::HeldOut).collect();
        assert_eq!(held.len(), 4);
        for trial in held {
            assert!(
                trial.rmse_fitted_rad.unwrap() < 1e-7 && trial.rmse_by_eye_rad.unwrap() > 1e-3,
                "{trial:?}"
            );
            assert_eq!(trial.rmse_left_out_rad, None);
        }
    }

    #[test]
    fn a_parameter_that_nothing_depends_on_is_insensitive_and_one_that_is_another_s_double_confounded() {
        let metas = metas(6);
        let x = |i: usize| (0..20).map(move |k| f64::from(k) + i as f64);
        let theta: Vec<Vec<f64>> =
            (0..6).map(|i| x(i).map(|x| 2.0 * x + libm::sin(x * (i + 1) as f64)).collect()).collect();
        let recordings: Vec<_> =
            metas.iter().zip(&theta).map(|(meta, theta_rad)| Recording { meta, theta_rad }).collect();
        let line = |i: usize, p: &[f64; 3]| Some(x(i).map(|x| p[0] * x).collect());
        let found = identify(&recordings, &PARAMETERS, &[], 0.95, line).unwrap();
        let verdicts = found.estimates.map(|e| e.verdict);
        assert_eq!(verdicts[..2], [Verdict::Identifiable, Verdict::Insensitive]);
        let (low, high) = found.estimates[0].interval.unwrap();
        assert!(low < found.fitted()[0] && found.fitted()[0] < high);
        let double = |i: usize, p: &[f64; 3]| Some(x(i).map(|x| (p[0] + p[1]) * x).collect());
        let found = identify(&recordings, &PARAMETERS, &[], 0.95, double).unwrap();
        assert_eq!(found.estimates[0].verdict, Verdict::Confounded);
    }

    #[test]
    fn one_trial_is_too_few() {
        let metas = metas(2);
        let recordings: Vec<_> =
            metas.iter().map(|meta| Recording { meta, theta_rad: &[0.0, 1.0] }).collect();
        let error = identify(&recordings, &PARAMETERS, &[], 0.95, |_, _| None).unwrap_err();
        assert_eq!(error, IdentifyError::TooFew { trials: 1 });
    }
}
