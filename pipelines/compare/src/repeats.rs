//! The mean at each repeat of a condition, over the units of analysis: what learning looks like.

use crate::measure::Measure;
use crate::trials::Trials;
use crate::{CompareError, Parameters};
use std::collections::BTreeMap;
use zwidth_results::RepeatMean;
use zwidth_stats::interval::mean;

/// One row per environment, mode and repeat: the mean over participants of each one's mean over
/// sessions, with its interval; of one participant, the mean over sessions.
pub(crate) fn means(
    trials: &Trials,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<RepeatMean>, CompareError> {
    // Everybody's values at each repeat of each condition, over their sessions.
    let mut repeats: BTreeMap<_, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
    for trial in &trials.trials {
        if let Some(value) = trial.value {
            let people = repeats.entry((trial.environment, trial.mode, trial.repeat)).or_default();
            people.entry(trial.participant).or_default().push(value);
        }
    }
    let mut rows = Vec::new();
    for ((environment, mode, repeat), people) in repeats {
        let own = people.values().map(|values| values.iter().sum::<f64>() / values.len() as f64);
        let over = mean(&own.collect::<Vec<_>>(), parameters.level)?;
        rows.push(RepeatMean {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: parameters.environments[environment].clone(),
            mode: parameters.modes[mode].clone(),
            repeat,
            n: over.n,
            mean: over.estimate,
            ci_low: over.interval.as_ref().map(|ends| ends.ci_low),
            ci_high: over.interval.as_ref().map(|ends| ends.ci_high),
        });
    }
    Ok(rows)
}
