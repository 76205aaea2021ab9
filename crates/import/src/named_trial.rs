//! Which trial a row of a table means, of those that a study has: by its number, or by condition and repeat.

use super::identity::{id, number};
use super::recording::Recording;
use super::table::Cell;
use zwidth_store::StoreError;
use zwidth_study::{EnvironmentId, ModeId, ParticipantId, SessionId};

/// The trial of its session that a row means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TrialMeant {
    /// The trial of this number.
    Number(u32),
    /// This repeat of a condition.
    Repeat {
        /// The condition's environment.
        environment: EnvironmentId,
        /// The condition's mode.
        mode: ModeId,
        /// The repeat, from 1.
        repeat: u32,
    },
}

/// What a row says about a trial that it names by number, in the columns beside the number. It must
/// be true, because otherwise it is not known which of them is right.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Claims {
    /// The id of its environment, or the label.
    pub environment: Option<String>,
    /// The id of its mode, or the label.
    pub mode: Option<String>,
    /// Its repeat.
    pub repeat: Option<u32>,
}

/// The trial that a row names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedTrial {
    /// Whose.
    pub participant: ParticipantId,
    /// In which session; `None` where the table has no such column.
    pub session: Option<SessionId>,
    /// Which of its trials.
    pub trial: TrialMeant,
    /// Claims of the row about the trial, besides its number.
    pub claims: Claims,
}

impl NamedTrial {
    /// Whether the trial's number is all that says which one is meant.
    pub fn is_number_alone(&self) -> bool {
        matches!(self.trial, TrialMeant::Number(_)) && self.claims == Claims::default()
    }
}

/// The names of a table's columns, the same in any case.
pub(super) struct Header<'a> {
    recording: &'a Recording,
    pub(super) names: Vec<String>,
    remedy: &'static str,
}

impl<'a> Header<'a> {
    /// Those of a table; `remedy` tells which columns it should have.
    pub(super) fn of(recording: &'a Recording, remedy: &'static str) -> Self {
        let names = recording.table.names.iter().flatten();
        let names = names.map(|name| name.trim().to_lowercase()).collect();
        Self { recording, names, remedy }
    }

    /// The place of a column.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|other| other == name)
    }

    /// The place of a column that must be there.
    pub(super) fn needed(&self, name: &str) -> Result<usize, StoreError> {
        self.find(name).ok_or_else(|| {
            let all = match self.names.is_empty() {
                true => "no header".to_owned(),
                false => self.names.join(", "),
            };
            let what = format!("there is no column '{name}'; the table has {all}");
            self.recording.error(what, self.remedy)
        })
    }
}

/// The places of the columns that say which trial a row means.
pub(super) struct TrialColumns {
    participant: usize,
    session: Option<usize>,
    by: By,
}

enum By {
    Number { trial: usize, environment: Option<usize>, mode: Option<usize>, repeat: Option<usize> },
    Repeat { environment: usize, mode: usize, repeat: usize },
}

impl TrialColumns {
    /// How these columns are called.
    pub(super) const NAMES: [&str; 6] =
        ["participant", "session", "trial", "environment", "mode", "repeat"];

    /// Those of a table.
    ///
    /// # Errors
    /// A column that is missing.
    pub(super) fn of(header: &Header) -> Result<Self, StoreError> {
        let by = match (header.find("trial"), header.find("environment")) {
            (None, Some(environment)) => By::Repeat {
                environment,
                mode: header.needed("mode")?,
                repeat: header.needed("repeat")?,
            },
            _ => By::Number {
                trial: header.needed("trial")?,
                environment: header.find("environment"),
                mode: header.find("mode"),
                repeat: header.find("repeat"),
            },
        };
        Ok(Self { participant: header.needed("participant")?, session: header.find("session"), by })
    }

    /// The trial that a row names.
    ///
    /// # Errors
    /// A cell that is empty, or none of what it should be, with `mend` as the remedy.
    pub(super) fn row(
        &self,
        recording: &Recording,
        row: usize,
        mend: &str,
    ) -> Result<NamedTrial, StoreError> {
        let (trial, claims) = match self.by {
            By::Number { trial, environment, mode, repeat } => {
                // A cell that is empty claims nothing.
                let [environment, mode, repeat] = [environment, mode, repeat].map(|column| {
                    column
                        .filter(|column| recording.table.columns[*column].cell(row) != Cell::Empty)
                });
                let claims = Claims {
                    environment: environment
                        .map(|at| text(recording, at, row, mend))
                        .transpose()?,
                    mode: mode.map(|at| text(recording, at, row, mend)).transpose()?,
                    repeat: repeat
                        .map(|at| parsed(recording, at, row, mend, |text| number("repeat", text)))
                        .transpose()?,
                };
                let trial = parsed(recording, trial, row, mend, |text| number("trial", text))?;
                (TrialMeant::Number(trial), claims)
            }
            By::Repeat { environment, mode, repeat } => {
                let trial = TrialMeant::Repeat {
                    environment: parsed(recording, environment, row, mend, id)?,
                    mode: parsed(recording, mode, row, mend, id)?,
                    repeat: parsed(recording, repeat, row, mend, |text| number("repeat", text))?,
                };
                (trial, Claims::default())
            }
        };
        let session = self.session.map(|at| parsed(recording, at, row, mend, id)).transpose()?;
        let participant = parsed(recording, self.participant, row, mend, id)?;
        Ok(NamedTrial { participant, session, trial, claims })
    }
}

/// The text of a cell, which must not be empty.
fn text(
    recording: &Recording,
    column: usize,
    row: usize,
    mend: &str,
) -> Result<String, StoreError> {
    let text = recording.table.columns[column].cell(row).to_string().trim().to_owned();
    if text.is_empty() {
        return Err(recording.cell_error(column, row, "the cell is empty", mend));
    }
    Ok(text)
}

/// Parses the text of a cell.
pub(super) fn parsed<T>(
    recording: &Recording,
    column: usize,
    row: usize,
    mend: &str,
    parse: impl FnOnce(&str) -> Result<T, String>,
) -> Result<T, StoreError> {
    parse(&text(recording, column, row, mend)?)
        .map_err(|why| recording.cell_error(column, row, &why, mend))
}
