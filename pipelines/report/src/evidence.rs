//! What a study's claims of the thesis are judged by: shared by its Table 1 and its statements.

use crate::gallery::Gallery;
use crate::people::simulated;
use std::collections::BTreeSet;
pub(crate) use zwidth_results::ClaimVerdict as Verdict;
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_study::{Basis, Calibration, Environment, Mode, ModeLaw, Setup};
use zwidth_tables::{Measured, TableError};

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

/// The tables of a study by which the thesis' statements are judged.
#[derive(Debug, Clone, Copy)]
pub struct Derived<'a> {
    /// The study, its calibration and its metrics.
    pub known: Known<'a>,
    /// Where the calibration comes from.
    pub basis: Basis,
    /// The replays that are used ([`crate::replayed`]), one row per trial.
    pub replays: Option<&'a Measured>,
    /// The answers as given, one row each.
    pub answers: Option<&'a [GivenAnswer]>,
    /// Their tally.
    pub tally: Option<&'a [AnswerTally]>,
    /// The figures that there are.
    pub gallery: &'a Gallery,
    /// Confidence level of intervals.
    pub level: f64,
}

/// Why a statement has no verdict from numbers.
pub(crate) enum Stop {
    /// Nothing that was measured tells, in words.
    NotMeasured(String),
    Table(TableError),
}

impl From<TableError> for Stop {
    fn from(error: TableError) -> Self {
        Self::Table(error)
    }
}

/// Which environment a claim is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// A spring without a wall.
    Spring,
    /// With a wall.
    Wall,
}

impl Place {
    pub(crate) fn fits(self, environment: &Environment) -> bool {
        let has_wall = environment.scene.wall_rad().is_some();
        match self {
            Self::Spring => environment.scene.spring().is_some() && !has_wall,
            Self::Wall => has_wall,
        }
    }
}

/// The study's first mode of that law.
pub(crate) fn with_law(study: &Setup, law: ModeLaw) -> Option<&Mode> {
    study.modes.iter().find(|mode| mode.law() == Some(law))
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
