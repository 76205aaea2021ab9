//! What speaks for or against a claim of the thesis: shared by its Table 1 and its statements.

use crate::people::simulated;
use zwidth_study::{Calibration, Environment, Setup};
use zwidth_tables::{Table, TableError};

/// Up to this share returned energy counts as none: a released lever moves on a little.
pub(crate) const NOTHING_RETURNED: f64 = 0.01;

/// What a study knows.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The study.
    pub study: &'a Setup,
    /// Forces for voltages.
    pub calibration: &'a Calibration,
    /// The metrics, one row per trial; `None` where there is no trial.
    pub metrics: Option<&'a Table>,
}

/// What a study's numbers say of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Supported,
    Contradicted,
    /// There are numbers, and they leave it open.
    Undecided,
    /// There are none.
    NotMeasured,
}

impl Verdict {
    /// The verdicts in the order in which they are counted.
    pub(crate) const ALL: [Self; 4] =
        [Self::Supported, Self::Contradicted, Self::Undecided, Self::NotMeasured];

    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Supported => "supported",
            Self::Contradicted => "contradicted",
            Self::Undecided => "undecided",
            Self::NotMeasured => "not measured",
        }
    }

    /// The verdict of what is known without an error.
    pub(crate) fn of(supported: bool) -> Self {
        if supported { Self::Supported } else { Self::Contradicted }
    }
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
pub(crate) fn notes(metrics: Option<&Table>) -> Result<Vec<String>, TableError> {
    let Some(metrics) = metrics else { return Ok(Vec::new()) };
    let mut notes = Vec::new();
    if simulated(metrics)? {
        notes.push("The trials were simulated: their metrics say what the model does.".to_owned());
    }
    let mut people = metrics.texts("participant")?;
    people.sort();
    people.dedup();
    if let [Some(one)] = people.as_slice() {
        notes.push(format!("All metrics of trials are those of one participant, {one}."));
    }
    Ok(notes)
}
