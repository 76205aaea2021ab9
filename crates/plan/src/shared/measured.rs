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
    let table = row.ok().and_then(|row| zwidth_metrics::table(&[row]).ok());
    table.map_or_else(Vec::new, |table| table.columns().iter().filter_map(number).collect())
}

/// A trial of samples that a model made, known as `like` is.
pub(crate) fn model_trial(samples: Samples, like: &Trial) -> Trial {
    Trial { meta: like.meta.clone(), file: like.file.clone(), samples }
}

fn number(column: &Column) -> Option<Measured> {
    let Values::Float(values) = &column.values else { return None };
    let name = column.field.name.to_string();
    let unit = column.field.unit.to_string();
    is_felt(&name).then(|| Measured { name, unit, value: values.first().copied().flatten() })
}
