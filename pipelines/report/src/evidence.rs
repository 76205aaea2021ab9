//! Evidence for or against a claim of the thesis: shared by its Table 1 and its statements.

use crate::people::simulated;
use std::collections::BTreeSet;
pub(crate) use zwidth_results::ClaimVerdict as Verdict;
use zwidth_study::{Calibration, Environment, Setup};
use zwidth_tables::Measured;

/// Up to this share returned energy counts as none: a released lever moves on a little.
pub(crate) const NOTHING_RETURNED: f64 = 0.01;

/// What a study knows.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The study.
    pub study: &'a Setup,
    /// Forces for voltages.
    pub calibration: &'a Calibration,
    /// The metrics, one row per trial; `None` if there is no trial.
    pub metrics: Option<&'a Measured>,
}

/// What speaks for or against a claim.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Evidence {
    pub(crate) metric: String,
    /// None where the claim is made of others, and where there is no single number.
    pub(crate) value: Option<f64>,
    pub(crate) unit: String,
    pub(crate) remark: String,
    pub(crate) verdict: Verdict,
}

/// An environment that has a spring and nothing else.
pub(crate) fn a_spring(environment: &Environment) -> bool {
    environment.scene.spring().is_some() && environment.scene.wall_rad().is_none()
}

/// An environment that has a wall.
pub(crate) fn a_wall(environment: &Environment) -> bool {
    environment.scene.wall_rad().is_some()
}

/// Whether trials are simulated, and whether they are all one person's.
pub fn notes(metrics: Option<&Measured>) -> Vec<String> {
    let Some(metrics) = metrics else { return Vec::new() };
    let mut notes = Vec::new();
    if simulated(metrics) {
        notes.push("The trials were simulated: their metrics say what the model does.".to_owned());
    }
    let people: BTreeSet<_> = metrics.trials().iter().map(|trial| &trial.participant).collect();
    if let (Some(one), 1) = (people.first(), people.len()) {
        notes.push(format!("All metrics of trials are those of one participant, {one}."));
    }
    notes
}
