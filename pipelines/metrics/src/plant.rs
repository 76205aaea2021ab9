//! The metrics of a trial once the plant is known: the actuators' own force discrepancy, and the
//! energy that the device gave without having received it.

use crate::actuator::{ActuatorDiscrepancy, actuator_discrepancy};
use crate::energy::{EnergyObserver, energy_observer};
use crate::signals::Signals;
use crate::{MetricsError, Parameters, Plant};
use zwidth_store::{Recorded, Signal};
use zwidth_study::TrialMeta;

/// The signals at which [`plant_metrics`] looks.
pub const PLANT_SIGNALS: [Signal; 5] =
    [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::ForceAge];

/// The metrics of a trial that depend on the plant.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantMetrics {
    /// Which trial.
    pub meta: TrialMeta,
    /// By how much the actuators differ; all null where the environment has no spring or the plant
    /// is not known.
    pub discrepancy: ActuatorDiscrepancy,
    /// What contacts with the wall and closed loops give or take.
    pub energy: EnergyObserver,
}

/// The metrics of `trial` that depend on the plant; `None` if it was not identified.
///
/// # Errors
/// As [`trial_metrics`](crate::trial_metrics).
pub fn plant_metrics<'a>(
    trial: impl Into<Recorded<'a>>,
    parameters: &Parameters,
    plant: Option<&Plant>,
) -> Result<PlantMetrics, MetricsError> {
    let Recorded { meta, columns } = trial.into();
    let signals = Signals::of_motion(columns, parameters)?;
    let in_spring = plant.filter(|_| parameters.scene.spring().is_some());
    let discrepancy =
        in_spring.map(|plant| actuator_discrepancy(&signals, plant, &parameters.analysis));
    Ok(PlantMetrics {
        meta: meta.clone(),
        discrepancy: discrepancy.transpose()?.unwrap_or_default(),
        energy: energy_observer(
            &signals,
            parameters.scene.wall_rad(),
            plant.map(|plant| plant.mass_kg),
        )?,
    })
}
