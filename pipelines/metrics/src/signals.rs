//! A trial's samples as the metrics see them: slices of one length, and where the movement's phases lie.

use crate::MetricsError;
use zwidth_numerics::activity::{Activity, activity};
use zwidth_store::{Signal, Trial};
use zwidth_study::{Analysis, Study};

/// Where the phases of a movement lie: sample indices, each inclusive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Phases {
    pub(crate) onset: usize,
    pub(crate) reversal: usize,
    pub(crate) end: usize,
}

/// The samples of a trial. All slices are as long as `t`, which has at least one sample.
pub(crate) struct Signals<'a> {
    pub(crate) t: &'a [f64],
    pub(crate) theta: Option<&'a [f64]>,
    pub(crate) theta_dot: Option<&'a [f64]>,
    pub(crate) force: Option<&'a [f64]>,
    pub(crate) force_cmd: Option<&'a [f64]>,
    pub(crate) lever_m: Option<f64>,
    /// When the lever moves; `None` without θ̇ or without movement.
    pub(crate) activity: Option<Activity>,
    /// `None` without θ, or where θ̇ shows no movement.
    pub(crate) phases: Option<Phases>,
}

impl<'a> Signals<'a> {
    pub(crate) fn of(trial: &'a Trial, study: &Study) -> Result<Self, MetricsError> {
        let t = trial.samples.get(Signal::Time).filter(|t| !t.is_empty()).ok_or(MetricsError::NoTime)?;
        let column = |signal: Signal| match trial.samples.get(signal) {
            Some(values) if values.len() != t.len() => {
                let (expected, found) = (t.len(), values.len());
                Err(MetricsError::Ragged { column: signal.name(), expected, found })
            }
            values => Ok(values),
        };
        let theta = column(Signal::Theta)?;
        let theta_dot = column(Signal::ThetaDot)?;
        let Analysis { onset_rad_s, offset_rad_s, .. } = study.analysis;
        let active = theta_dot.and_then(|v| activity(v, onset_rad_s, offset_rad_s));
        let phases = match (theta, theta_dot, active) {
            (Some(theta), Some(_), Some(a)) => Some(phases(theta, a.onset, a.end.unwrap_or(t.len() - 1))),
            (Some(theta), None, _) => Some(phases(theta, 0, t.len() - 1)),
            _ => None,
        };
        Ok(Self {
            t,
            theta,
            theta_dot,
            force: column(Signal::ForceEx)?,
            force_cmd: column(Signal::ForceCmd)?,
            lever_m: study.device.lever_m,
            activity: active,
            phases,
        })
    }

    /// θ, F and the phases, where all three are there.
    pub(crate) fn force_over_angle(&self) -> Option<(&'a [f64], &'a [f64], Phases)> {
        Some((self.theta?, self.force?, self.phases?))
    }
}

fn phases(theta: &[f64], onset: usize, end: usize) -> Phases {
    let mut reversal = onset;
    for i in onset..=end {
        if theta[i] > theta[reversal] {
            reversal = i;
        }
    }
    Phases { onset, reversal, end }
}
