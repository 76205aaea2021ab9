//! The study's own metrics of a model run: here the stages that run models meet the one that
//! measures.

use zwidth_metrics::Parameters;
use zwidth_store::{Samples, Trial};
use zwidth_study::{Measured, is_felt};
use zwidth_tables::{Column, Values};

/// The study's metrics that are numbers and say what somebody could feel; empty where they cannot
/// be computed.
pub(crate) fn measured(trial: &Trial, parameters: &Parameters) -> Vec<Measured> {
    let row = zwidth_metrics::trial_metrics(trial, parameters);
    let Some(table) = row.ok().and_then(|row| zwidth_metrics::table(&[row]).ok()) else {
        return Vec::new();
    };
    let mut numbers = Vec::new();
    for Column { field, values, .. } in table.columns() {
        let Values::Float(values) = values else { continue };
        if is_felt(&field.name) {
            let value = values.first().copied().flatten();
            numbers.push(Measured {
                name: field.name.to_string(),
                unit: field.unit.to_string(),
                value,
            });
        }
    }
    numbers
}

/// A trial of samples that a model made, with the identity of `like`.
pub(crate) fn model_trial(samples: Samples, like: &Trial) -> Trial {
    Trial { meta: like.meta.clone(), file: like.file.clone(), samples }
}
