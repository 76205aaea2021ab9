//! Thresholds as values of metrics.

use zwidth_results::{PsychometricFit, TrialKey};
use zwidth_study::{QuestionId, TaskQuantity};

/// The number of a fit as people are compared by it: of the JND its natural logarithm. `None` unless it is estimated.
pub fn value(fit: &PsychometricFit, quantity: TaskQuantity) -> Option<f64> {
    if !fit.verdict.is_estimated() {
        return None;
    }
    match quantity {
        TaskQuantity::Jnd => fit.jnd.filter(|jnd| *jnd > 0.0).map(libm::log),
        own => fit.threshold.filter(|_| own == fit.quantity),
    }
}

/// The standard error of [`value`].
pub(crate) fn std_error(fit: &PsychometricFit, quantity: TaskQuantity) -> Option<f64> {
    match quantity {
        TaskQuantity::Jnd => fit.ln_jnd_std_error,
        _ => fit.threshold_std_error,
    }
}

/// Everybody's values of a metric in each session and mode, as metrics of trials are keyed: by the first trial.
pub fn values(
    fits: &[PsychometricFit],
    task: &QuestionId,
    quantity: TaskQuantity,
) -> (Vec<TrialKey>, Vec<Option<f64>>) {
    let own = fits.iter().filter(|fit| fit.task == *task);
    own.map(|fit| {
        let key = TrialKey {
            participant: fit.participant.clone(),
            session: fit.session.clone(),
            trial: fit.trial,
            repeat: 1,
            environment: fit.environment.clone(),
            mode: fit.mode.clone(),
            source: fit.source,
        };
        (key, value(fit, quantity))
    })
    .unzip()
}
