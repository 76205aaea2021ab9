//! Doubts about a trial from its samples, and from the findings of its import.

use crate::judge::plausible::implausible;
use crate::{Asked, Columns, DOUBTS, LOST, Signal, StoreError, TrialFile};
use std::path::Path;
use zwidth_study::Coordinate;

/// How far past the work space an angle may be measured before it is a finding, rad (2°: the limit
/// at which the safety layer cuts the voltage).
const WORK_SPACE_SLACK_RAD: f64 = 0.034_906_585_039_886_59;

/// A check of a trial's samples against the study's requirements.
pub(crate) type Check = fn(&Asked, &Path, &dyn Columns) -> Vec<StoreError>;

/// What an import found that a trial's samples do not show, as its footer says: the trial counts, and is to be
/// read with care.
pub(crate) fn import_findings(path: &Path, file: &TrialFile) -> Vec<StoreError> {
    let lost = "import a whole copy of the recording as another session, or exclude the trial if what is lost matters";
    let doubts =
        "mend the mapping or the recording and import it as another session, or exclude the trial";
    let findings = [(LOST, lost), (DOUBTS, doubts)]
        .map(|(key, remedy)| file.get(key).map(|what| StoreError::new(path, what, remedy)));
    findings.into_iter().flatten().collect()
}

/// The signals that [`check_samples`] looks at. Of the device's clock it asks [`Columns::reach`] alone,
/// which a trial's file says without it.
pub const CHECKED: [Signal; 11] = [
    Signal::Time,
    Signal::Theta,
    Signal::ThetaDot,
    Signal::ForceEx,
    Signal::TorqueEx,
    Signal::X,
    Signal::Y,
    Signal::Z,
    Signal::ForceX,
    Signal::ForceY,
    Signal::ForceZ,
];

/// What the samples of a trial, which are whole, say against it: it counts, and is to be read with
/// care.
pub fn check_samples(expected: &Asked, path: &Path, samples: &dyn Columns) -> Vec<StoreError> {
    [within_limits(expected, path, samples), implausible(expected, path, samples)].concat()
}

/// Checks samples against the limits in study.toml.
pub(crate) fn within_limits(
    expected: &Asked,
    path: &Path,
    samples: &dyn Columns,
) -> Vec<StoreError> {
    let findings = [work_space(expected, path, samples), too_long(expected, path, samples)];
    findings.into_iter().flatten().collect()
}

/// A trial longer than the design allows: usually milliseconds taken for seconds.
fn too_long(expected: &Asked, path: &Path, samples: &dyn Columns) -> Option<StoreError> {
    let t = samples.column(Signal::Time)?;
    let length = t.last()? - t.first()?;
    let limit = expected.trial_limit_s;
    let is_too_long = length > limit;
    if !is_too_long {
        return None;
    }
    let what = format!("it lasts {length} s, longer than design.trial_limit_s = {limit} s");
    let remedy = "check the unit of its time, or raise the limit in study.toml";
    Some(StoreError::new(path, what, remedy).column(Signal::Time.name()))
}

fn work_space(expected: &Asked, path: &Path, samples: &dyn Columns) -> Option<StoreError> {
    let theta = samples.column(Signal::Theta)?;
    let low = expected.theta_min_rad.unwrap_or(f64::NEG_INFINITY) - WORK_SPACE_SLACK_RAD;
    let high = expected.theta_max_rad.unwrap_or(f64::INFINITY) + WORK_SPACE_SLACK_RAD;
    let row = theta.iter().position(|v| !(low..=high).contains(v))?;
    let what = format!(
        "{} is more than {} outside of the work space",
        expected.place(theta[row]),
        match expected.coordinate {
            Coordinate::Rotational => "2°".to_owned(),
            Coordinate::Linear { .. } => expected.place(WORK_SPACE_SLACK_RAD),
        }
    );
    let remedy = "exclude the trial if the angle was lost, or mend theta_min_deg and theta_max_deg in study.toml";
    Some(StoreError::new(path, what, remedy).column(Signal::Theta.name()).row0(row))
}
