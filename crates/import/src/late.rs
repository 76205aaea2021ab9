//! Answers that a study kept beside its recordings, for existing trials: a table with one row per
//! answer and fixed column names, without a mapping file.

use super::guess_read::{Looked, look};
use super::identity::{id, number, written};
use super::mapping::CellForm;
use super::recording::Recording;
use super::table::Cell;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{FirstErrors, StoreError};
use zwidth_study::{AnswerValue, EnvironmentId, ModeId, ParticipantId, QuestionId, SessionId};

/// The remedy for a wrong row.
const MEND: &str = "mend the row, or remove it; nothing was written";

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

/// One row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LateAnswer {
    /// Whose answer.
    pub participant: ParticipantId,
    /// In which session; `None` where the table has no such column.
    pub session: Option<SessionId>,
    /// After which trial.
    pub trial: TrialMeant,
    /// Claims of the row about the trial, besides its number.
    pub claims: Claims,
    /// To which question; `None` where the table has no such column.
    pub question: Option<QuestionId>,
    /// The answer.
    pub value: AnswerValue,
    row: usize,
}

impl LateAnswer {
    /// Whether the trial's number is all that says which one is meant.
    pub fn is_number_alone(&self) -> bool {
        matches!(self.trial, TrialMeant::Number(_)) && self.claims == Claims::default()
    }
}

/// A table of answers, read.
pub struct LateAnswers {
    recording: Recording,
    answer: usize,
    /// The rows, in the order of the table.
    pub rows: Vec<LateAnswer>,
}

impl LateAnswers {
    /// Reads a table with the columns participant, session, trial (or environment, mode and
    /// repeat), question and answer, in any order and among others.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing, and each row in which a cell is wrong.
    pub fn read(path: &Path) -> Result<Self, FirstErrors> {
        // There is no mapping: as for a guess, the text itself shows how it is written.
        let Looked { table, written, .. } = look(path)?;
        let decimal_comma = written.is_some_and(|written| written.decimal_comma);
        let cells = CellForm { decimal_comma, ..CellForm::default() };
        let recording = Recording::part(path, table, cells, BTreeMap::new());
        let columns = Columns::of(&recording)?;
        let mut rows = Vec::new();
        let mut errors = FirstErrors::default();
        let mut bad = recording.table.bad.iter().peekable();
        for row in 0..recording.table.columns[columns.answer].len() {
            // Bad rows are in order: each is looked at once.
            let read = match bad.next_if(|(bad, _)| *bad == row) {
                Some((_, why)) => Err(recording.cell_error(columns.answer, row, why, MEND)),
                None => columns.row(&recording, row),
            };
            match read {
                Ok(answer) => rows.push(answer),
                Err(error) => errors.push(error),
            }
        }
        if rows.is_empty() && errors.is_empty() {
            errors.push(recording.error("the table has no rows", "name the table of answers"));
        }
        errors.none()?;
        Ok(Self { recording, answer: columns.answer, rows })
    }

    /// An error about a row.
    pub fn error(&self, row: &LateAnswer, what: &str) -> StoreError {
        self.recording.cell_error(self.answer, row.row, what, MEND)
    }

    /// The place of a row, for people.
    pub fn place(&self, row: &LateAnswer) -> String {
        self.recording.row_name(row.row)
    }
}

/// The places of the columns.
struct Columns {
    participant: usize,
    session: Option<usize>,
    trial: TrialColumns,
    question: Option<usize>,
    answer: usize,
}

enum TrialColumns {
    Number { trial: usize, environment: Option<usize>, mode: Option<usize>, repeat: Option<usize> },
    Repeat { environment: usize, mode: usize, repeat: usize },
}

impl Columns {
    /// Names are the same in any case.
    fn of(recording: &Recording) -> Result<Self, StoreError> {
        let names = recording.table.names.iter().flatten();
        let names: Vec<String> = names.map(|name| name.trim().to_lowercase()).collect();
        let find = |name: &str| names.iter().position(|other| other == name);
        let needed = |name: &str| {
            find(name).ok_or_else(|| {
                let what = format!(
                    "there is no column '{name}'; the table has {}",
                    if names.is_empty() { "no header".to_owned() } else { names.join(", ") }
                );
                let remedy = "name the columns participant, session, trial (or environment, mode and repeat), \
                              question and answer in its first line";
                recording.error(what, remedy)
            })
        };
        let trial = match (find("trial"), find("environment")) {
            (None, Some(environment)) => TrialColumns::Repeat {
                environment,
                mode: needed("mode")?,
                repeat: needed("repeat")?,
            },
            _ => TrialColumns::Number {
                trial: needed("trial")?,
                environment: find("environment"),
                mode: find("mode"),
                repeat: find("repeat"),
            },
        };
        Ok(Self {
            participant: needed("participant")?,
            session: find("session"),
            trial,
            question: find("question"),
            answer: needed("answer")?,
        })
    }

    fn row(&self, recording: &Recording, row: usize) -> Result<LateAnswer, StoreError> {
        let (trial, claims) = match self.trial {
            TrialColumns::Number { trial, environment, mode, repeat } => {
                // A cell that is empty claims nothing.
                let [environment, mode, repeat] = [environment, mode, repeat].map(|column| {
                    column
                        .filter(|column| recording.table.columns[*column].cell(row) != Cell::Empty)
                });
                let claims = Claims {
                    environment: environment.map(|at| text(recording, at, row)).transpose()?,
                    mode: mode.map(|at| text(recording, at, row)).transpose()?,
                    repeat: repeat
                        .map(|at| parsed(recording, at, row, |text| number("repeat", text)))
                        .transpose()?,
                };
                let trial = parsed(recording, trial, row, |text| number("trial", text))?;
                (TrialMeant::Number(trial), claims)
            }
            TrialColumns::Repeat { environment, mode, repeat } => {
                let trial = TrialMeant::Repeat {
                    environment: parsed(recording, environment, row, id)?,
                    mode: parsed(recording, mode, row, id)?,
                    repeat: parsed(recording, repeat, row, |text| number("repeat", text))?,
                };
                (trial, Claims::default())
            }
        };
        let code = text(recording, self.participant, row)?;
        let session = self.session.map(|at| parsed(recording, at, row, id)).transpose();
        let question = self.question.map(|at| parsed(recording, at, row, id)).transpose();
        let decimal_comma =
            recording.has_decimal_comma(&recording.table.columns[self.answer].cell(row));
        let value = parsed(recording, self.answer, row, |text| {
            // Which numbers its scale has is not known here.
            written(text, decimal_comma)
                .ok_or_else(|| format!("the answer '{text}' must be a number"))
        })?;
        Ok(LateAnswer {
            participant: id(&code).map_err(|why| at(recording, self.participant, row, &why))?,
            session: session?,
            trial,
            claims,
            question: question?,
            value,
            row,
        })
    }
}

/// The text of a cell, which must not be empty.
fn text(recording: &Recording, column: usize, row: usize) -> Result<String, StoreError> {
    let text = recording.table.columns[column].cell(row).to_string().trim().to_owned();
    if text.is_empty() {
        return Err(at(recording, column, row, "the cell is empty"));
    }
    Ok(text)
}

/// Parses the text of a cell.
fn parsed<T>(
    recording: &Recording,
    column: usize,
    row: usize,
    parse: impl FnOnce(&str) -> Result<T, String>,
) -> Result<T, StoreError> {
    parse(&text(recording, column, row)?).map_err(|why| at(recording, column, row, &why))
}

fn at(recording: &Recording, column: usize, row: usize, what: &str) -> StoreError {
    recording.cell_error(column, row, what, MEND)
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use super::*;

    fn read(text: &str) -> Result<LateAnswers, FirstErrors> {
        LateAnswers::read(&World::new().file("ratings.csv", text))
    }

    /// The rows of a table that can be read.
    fn rows(text: &str) -> LateAnswers {
        read(text).unwrap_or_else(|e| panic!("{e:#?}"))
    }

    /// The first error about a table.
    fn told(text: &str) -> String {
        read(text).err().unwrap()[0].to_string()
    }

    #[test]
    fn columns_are_found_in_any_order_and_case_and_others_are_left_alone() {
        let found =
            rows("Answer;remark;Participant;TRIAL;session\n4;ok;P01;7;S02\n-1.0;;P02;8;S01\n");
        let [first, second] = &found.rows[..] else { panic!("{:?}", found.rows) };
        assert_eq!((first.participant.as_str(), first.value), ("P01", 4.into()));
        assert_eq!(first.session.as_ref().map(SessionId::as_str), Some("S02"));
        assert_eq!((&first.trial, &first.question), (&TrialMeant::Number(7), &None));
        assert_eq!((second.value, found.place(second)), ((-1).into(), "line 3".to_owned()));
    }

    #[test]
    fn answers_may_have_decimals_behind_the_sign_of_the_table() {
        for text in [
            "participant,trial,answer\nP01,1,47.273\nP01,2,0.5\n",
            "participant;trial;answer\nP01;1;47,273\nP01;2;0,5\n",
        ] {
            let values: Vec<f64> = rows(text).rows.iter().map(|row| row.value.get()).collect();
            assert_eq!(values, [47.273, 0.5]);
        }
    }

    #[test]
    fn what_a_row_says_of_a_trial_besides_its_number_is_kept_to_be_checked() {
        let text = "participant,trial,mode,environment,repeat,answer\nP01,7,active,,2,4\nP01,8,Soft,spring,,4\n";
        let found = rows(text);
        let claims = |mode: &str, environment: Option<&str>, repeat| Claims {
            environment: environment.map(str::to_owned),
            mode: Some(mode.to_owned()),
            repeat,
        };
        let found: Vec<Claims> = found.rows.iter().map(|row| row.claims.clone()).collect();
        assert_eq!(found, [claims("active", None, Some(2)), claims("Soft", Some("spring"), None)]);
        let error = told("participant,trial,repeat,answer\nP01,7,x,4\n");
        assert!(error.contains("column repeat, row 1: repeat 'x' must be"), "{error}");
    }

    #[test]
    fn a_table_that_is_wrong_in_every_row_is_read_in_one_walk_and_told_by_its_first_rows() {
        // Most rows have a cell too many.
        let rows: String = (0..20_000).map(|i| format!("P01,{i},4,{i}\n")).collect();
        let errors = read(&format!("participant,trial,answer\nP01,1,4\n{rows}")).err().unwrap();
        assert_eq!(errors.len() + errors.more(), 20_000);
        assert!(errors.len() <= 1_000);
    }

    #[test]
    fn a_trial_may_be_named_by_its_condition_and_repeat() {
        let text =
            "participant,environment,mode,repeat,question,answer\nP01,spring,active,2,q1,3\n";
        let found = rows(text);
        let environment = "spring".parse().unwrap();
        let mode = "active".parse().unwrap();
        let meant = TrialMeant::Repeat { environment, mode, repeat: 2 };
        assert_eq!(found.rows[0].trial, meant);
        assert_eq!(found.rows[0].question.as_ref().map(QuestionId::as_str), Some("q1"));
    }

    #[test]
    fn every_bad_line_is_told_with_its_number_and_the_rest_is_read_on() {
        let text = "participant,trial,answer\nP01,1,4\nP 1,1,4\nP01,0,4\nP01,1,agree\nP01,1,\n";
        let told: Vec<String> = read(text).err().unwrap().iter().map(ToString::to_string).collect();
        let expect = [
            ("participant", "(line 3)"),
            ("trial", "trial '0' must be a whole number from 1 to 1000000 (line 4)"),
            ("answer", "the answer 'agree' must be a number (line 5)"),
            ("answer", "the cell is empty (line 6)"),
        ];
        assert_eq!(told.len(), expect.len(), "{told:#?}");
        for (told, (column, words)) in told.iter().zip(expect) {
            assert!(told.contains(&format!("column {column}, ")) && told.contains(words), "{told}");
        }
    }

    #[test]
    fn a_column_that_is_missing_is_told_with_what_there_is() {
        for (text, words) in [
            ("who,trial,answer\nP01,1,4\n", "no column 'participant'; the table has who,"),
            ("participant,environment,mode,answer\nP01,a,b,4\n", "no column 'repeat'"),
        ] {
            assert!(told(text).contains(words), "{}", told(text));
        }
    }
}
