//! The study's own metrics of a model run: here the stages that run models meet the one that
//! measures.

use zwidth_metrics::Parameters;
use zwidth_store::{Samples, Signal, Trial};
use zwidth_study::Measured;
use zwidth_tables::{Column, Values};

/// The study's metrics that are numbers and say what somebody could feel; empty where they cannot
/// be computed.
pub(crate) fn measured(trial: &Trial, parameters: &Parameters) -> Vec<Measured> {
    let row = zwidth_metrics::trial_metrics(trial, parameters);
    let Some(table) = row.ok().and_then(|row| {
        zwidth_metrics::table(&[row], &parameters.own, parameters.axes.is_some()).ok()
    }) else {
        return Vec::new();
    };
    let mut numbers = Vec::new();
    for Column { field, values, .. } in table.columns() {
        let Values::Float(values) = values else { continue };
        if zwidth_metrics::is_felt(&parameters.own, &field.name) {
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

/// The samples of a model's course: time, angle, velocity, the user's force, and that of the actuators.
pub(crate) fn model_samples(columns: [&Vec<f64>; 5]) -> Samples {
    let signals =
        [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::ForceCmd];
    let mut samples = Samples::default();
    for (signal, column) in signals.into_iter().zip(columns) {
        samples.set(signal, column.clone());
    }
    samples
}
