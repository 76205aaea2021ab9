//! Answers that a study kept beside its recordings, for existing trials: a table with one row per
//! answer and fixed column names, without a mapping file.

use super::guess_read::{Looked, look};
use super::identity::{id, written};
use super::mapping::CellForm;
use super::named_trial::{Header, NamedTrial, TrialColumns, parsed};
use super::recording::Recording;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{FirstErrors, StoreError};
use zwidth_study::{AnswerValue, QuestionId};

/// The remedy for a wrong row.
const MEND: &str = "mend the row, or remove it; nothing was written";
/// The remedy for a column that is missing.
const NAMES: &str = "name the columns participant, session, trial (or environment, mode and repeat), question and answer in \
                     its first line";

/// One row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LateAnswer {
    /// After which trial.
    pub of: NamedTrial,
    /// To which question; `None` where the table has no such column.
    pub question: Option<QuestionId>,
    /// The answer.
    pub value: AnswerValue,
    row: usize,
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
    trial: TrialColumns,
    question: Option<usize>,
    answer: usize,
}

impl Columns {
    fn of(recording: &Recording) -> Result<Self, StoreError> {
        let header = Header::of(recording, NAMES);
        Ok(Self {
            trial: TrialColumns::of(&header)?,
            question: header.find("question"),
            answer: header.needed("answer")?,
        })
    }

    fn row(&self, recording: &Recording, row: usize) -> Result<LateAnswer, StoreError> {
        let of = self.trial.row(recording, row, MEND)?;
        let question = self.question.map(|at| parsed(recording, at, row, MEND, id)).transpose();
        let decimal_comma = recording.has_decimal_comma(self.answer, row);
        let value = parsed(recording, self.answer, row, MEND, |text| {
            // Which numbers its scale has is not known here.
            written(text, decimal_comma)
                .ok_or_else(|| format!("the answer '{text}' must be a number"))
        })?;
        Ok(LateAnswer { of, question: question?, value, row })
    }
}

#[cfg(test)]
mod tests {
    use super::super::named_trial::{Claims, TrialMeant};
    use super::super::world::World;
    use super::*;
    use zwidth_study::SessionId;

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
        assert_eq!((first.of.participant.as_str(), first.value), ("P01", 4.into()));
        assert_eq!(first.of.session.as_ref().map(SessionId::as_str), Some("S02"));
        assert_eq!((&first.of.trial, &first.question), (&TrialMeant::Number(7), &None));
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
        let found: Vec<Claims> = found.rows.iter().map(|row| row.of.claims.clone()).collect();
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
        assert_eq!(found.rows[0].of.trial, meant);
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
