//! From recordings to parameters, and errors of trials that the fit has and has not seen.

use crate::IdentifyError;
use crate::estimate::{Estimate, estimates, free, jackknife, moved};
use crate::fit::{Problem, sum};
use crate::slopes::Parameter;
use rayon::prelude::*;
use zwidth_results::{FitPart, PlantTrialError};
use zwidth_study::TrialMeta;

/// A trial to be explained.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// The trial.
    pub meta: &'a TrialMeta,
    /// The observations to be explained, with all of their noise.
    pub observed: &'a [f64],
}

/// The parameters to be fitted, and the starts.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a, const P: usize> {
    /// The parameters.
    pub parameters: &'a [Parameter; P],
    /// Points at which the fit begins, besides the choice by eye.
    pub starts: &'a [[f64; P]],
    /// Level of the intervals, such as 0.95.
    pub level: f64,
}

/// Fitted parameters, and how good they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The parameters, in their order.
    pub estimates: Vec<Estimate>,
    /// Errors, in the order of the recordings.
    pub trials: Vec<PlantTrialError>,
    /// Covariance of the parameters by leaving out each trial in turn, a row each, in the product
    /// of their units; 0 for one on its bound. `None` where the trials do not determine them, or
    /// not without one of them.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Whether the fit met its stopping rule.
    pub converged: bool,
}

/// Fits parameters to half of the recordings and judges them on all.
///
/// `explain(i, points)` gives what recording `i` should have observed at each of some parameters
/// (several at a time, because a model may share work between them), and `judge(i, p)` the model's
/// error of θ (rad, root mean square) on it; either `None` where the model does not run there. The fit begins at the choice by eye and at every one of the task's starts.
///
/// # Errors
/// Fewer than two trials to fit, a model that runs from no start, a level outside (0, 1).
pub fn identify<const P: usize>(
    recordings: &[Recording],
    task: &Task<P>,
    explain: impl Fn(usize, &[[f64; P]]) -> Vec<Option<Vec<f64>>> + Sync,
    judge: impl Fn(usize, &[f64; P]) -> Option<f64> + Sync,
) -> Result<Identified, IdentifyError> {
    let parts: Vec<FitPart> = (0..recordings.len())
        .map(|i| {
            let meta = recordings[i].meta;
            let earlier = recordings[..i].iter().map(|earlier| earlier.meta);
            let repeats = earlier
                .filter(|m| m.is_of_session_of(meta) && m.condition() == meta.condition())
                .count();
            if repeats.is_multiple_of(2) { FitPart::Fitted } else { FitPart::HeldOut }
        })
        .collect();
    let fitted: Vec<usize> = (0..parts.len()).filter(|i| parts[*i] == FitPart::Fitted).collect();
    if fitted.len() < 2 {
        return Err(IdentifyError::TooFew { trials: fitted.len() });
    }
    let parameters = task.parameters;
    let observed: Vec<&[f64]> = recordings.iter().map(|r| r.observed).collect();
    let problem = Problem { trials: &fitted, observed: &observed, parameters, predict: &explain };
    let by_eye = parameters.map(|p| p.by_eye);
    let starts: Vec<[f64; P]> = [by_eye].into_iter().chain(task.starts.iter().copied()).collect();
    let minimum = problem.fit(&starts)?;
    let slopes = problem.slopes(&minimum.parameters);
    let blocks = problem.blocks(&minimum.parameters, &slopes);
    let free = free(parameters, &minimum.parameters, &sum(&blocks));
    let moved = moved(&blocks, &free);
    let at = &minimum.parameters;
    let left_out = |step: [f64; P]| -> [f64; P] {
        core::array::from_fn(|j| match free[j] {
            true => (at[j] + step[j]).clamp(parameters[j].lower, parameters[j].upper),
            false => at[j],
        })
    };
    let errors = recordings.par_iter().enumerate().map(|(i, recording)| {
        let error = |p: &[f64; P]| judge(i, p).filter(|error| error.is_finite());
        // Blocks are of the fitted trials alone, in the order of their numbers.
        let place = fitted.binary_search(&i).ok();
        let meta = recording.meta;
        PlantTrialError {
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            trial: meta.trial,
            repeat: meta.repeat,
            environment: meta.environment.clone(),
            mode: meta.mode.clone(),
            source: meta.source,
            part: parts[i],
            rmse_by_eye_rad: error(&by_eye),
            rmse_fitted_rad: error(at),
            rmse_left_out_rad: place.and_then(|k| moved[k]).and_then(|p| error(&left_out(p))),
        }
    });
    Ok(Identified {
        estimates: estimates(&problem, &minimum, &blocks, &slopes, task.level)?,
        trials: errors.collect(),
        covariance: moved.iter().copied().collect::<Option<Vec<_>>>().map(|moved| {
            (0..P).map(|j| (0..P).map(|k| jackknife(&moved, j, k)).collect()).collect()
        }),
        converged: minimum.converged,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{PARAMETERS, STARTS, TRUE, each, metas, pushed};
    use zwidth_results::Identifiability;

    fn recordings<'a>(metas: &'a [TrialMeta], observed: &'a [Vec<f64>]) -> Vec<Recording<'a>> {
        metas.iter().zip(observed).map(|(meta, observed)| Recording { meta, observed }).collect()
    }

    fn task<const P: usize>(parameters: &[Parameter; P]) -> Task<'_, P> {
        Task { parameters, starts: &[], level: 0.95 }
    }

    #[test]
    fn what_was_simulated_is_recovered_and_beats_the_eye_on_trials_it_has_not_seen() {
        let metas = metas(8);
        let theta: Vec<Vec<f64>> = (0..8).map(|i| pushed(i, &TRUE).unwrap()).collect();
        let judge = |i: usize, p: &[f64; 3]| {
            let squares: f64 =
                pushed(i, p)?.iter().zip(&theta[i]).map(|(p, o)| (p - o) * (p - o)).sum();
            Some((squares / theta[i].len() as f64).sqrt())
        };
        let task = Task { starts: &STARTS, ..task(&PARAMETERS) };
        let found = identify(&recordings(&metas, &theta), &task, each(pushed), judge).unwrap();
        for (estimate, expect) in found.estimates.iter().zip(TRUE) {
            let fitted = estimate.fitted;
            assert!((fitted / expect - 1.0).abs() < 1e-6, "{fitted} instead of {expect}");
            assert_eq!(estimate.verdict, Identifiability::Identifiable, "{estimate:?}");
        }
        let covariance = found.covariance.unwrap();
        for (j, estimate) in found.estimates.iter().enumerate() {
            let std_error = estimate.std_error.unwrap();
            assert!((covariance[j][j].sqrt() / std_error - 1.0).abs() < 1e-12, "{covariance:?}");
            for (k, row) in covariance.iter().enumerate() {
                assert_eq!(covariance[j][k].to_bits(), row[j].to_bits());
                let most = (covariance[j][j] * covariance[k][k]).sqrt();
                assert!(covariance[j][k].abs() <= most * (1.0 + 1e-12), "{covariance:?}");
            }
        }
        let held: Vec<_> = found.trials.iter().filter(|t| t.part == FitPart::HeldOut).collect();
        assert_eq!(held.len(), 4);
        for trial in held {
            let errors = (trial.rmse_fitted_rad.unwrap(), trial.rmse_by_eye_rad.unwrap());
            assert!(errors.0 < 1e-7 && errors.1 > 1e-3, "{trial:?}");
            assert_eq!(trial.rmse_left_out_rad, None);
        }
    }

    #[test]
    fn a_parameter_that_nothing_depends_on_is_insensitive_and_one_that_is_another_s_double_confounded()
     {
        let metas = metas(6);
        let x = |i: usize| (0..20).map(move |k| f64::from(k) + i as f64);
        let observed: Vec<Vec<f64>> = (0..6)
            .map(|i| x(i).map(|x| 2.0 * x + libm::sin(x * (i + 1) as f64)).collect())
            .collect();
        let recordings = recordings(&metas, &observed);
        let line = |i: usize, p: &[f64; 3]| Some(x(i).map(|x| p[0] * x).collect());
        let found =
            identify(&recordings, &task(&PARAMETERS), each(line), |_, _| None).unwrap().estimates;
        assert_eq!(
            [found[0].verdict, found[1].verdict],
            [Identifiability::Identifiable, Identifiability::Insensitive]
        );
        let (low, high) = found[0].interval.unwrap();
        assert!(low < found[0].fitted && found[0].fitted < high);
        let double = |i: usize, p: &[f64; 3]| Some(x(i).map(|x| (p[0] + p[1]) * x).collect());
        let found = identify(&recordings, &task(&PARAMETERS), each(double), |_, _| None).unwrap();
        assert_eq!(found.estimates[0].verdict, Identifiability::Confounded);
    }

    #[test]
    fn one_trial_is_too_few() {
        let (metas, observed) = (metas(2), vec![vec![0.0, 1.0]; 2]);
        let error = identify(
            &recordings(&metas, &observed),
            &task(&PARAMETERS),
            each(|_, _| None),
            |_, _| None,
        );
        assert_eq!(error.unwrap_err(), IdentifyError::TooFew { trials: 1 });
    }
}
