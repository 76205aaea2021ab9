//! The mapping file, checked: which part of a recording becomes which of our columns
//! (`docs/import.md`).

use super::convert::Linear;
use super::csv::{Dialect, WHITE_SPACE};
use super::format::Format;
use super::label::Label;
use super::shape::AnswerFrom;
pub(super) use super::shape::{At, Equal, Missing, Reduce, Resample, Side};
use super::spelling::plain;
use super::table::{Cell, ColumnRef};
use super::text::Encoding;
use super::unit::Unit;
use super::xdf::XdfClock;
use regex::Regex;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_store::{Quantity, Signal, StoreError};
use zwidth_study::{ChannelId, PersonColumnId, QuestionId, Source};

/// A mapping file, checked.
#[derive(Debug, Clone)]
pub struct Mapping {
    /// The mapping's own file, for errors.
    pub(super) path: PathBuf,
    /// BLAKE3 of its text, hexadecimal.
    pub(super) blake3: String,
    pub(super) file: FileForm,
    /// Whether the recordings were computed, not measured.
    pub(super) simulated: bool,
    /// Pattern on the path of every file.
    pub(super) name: Option<Regex>,
    /// Columns left out on purpose, and why.
    pub(super) drop: BTreeMap<String, String>,
    pub(super) content: Content,
}

/// The content of the files.
#[derive(Debug, Clone)]
pub(super) enum Content {
    Trials(Box<TrialsFrom>),
    Sweeps(Box<SweepFrom>),
    Likert(Questionnaire),
    Psychometric(Box<TaskFrom>),
    Exclusions(Exclusions),
    People(PeopleFrom),
}

/// Where the trials of recordings come from.
#[derive(Debug, Clone)]
pub(super) struct TrialsFrom {
    pub(super) who: Who,
    pub(super) time: Time,
    pub(super) columns: Vec<SignalFrom>,
    pub(super) channels: Vec<ChannelFrom>,
    pub(super) beside: Beside,
}

/// What belongs to recorded trials besides their samples: other files, answers, what a task presented.
#[derive(Debug, Clone, Default)]
pub(super) struct Beside {
    pub(super) log: Option<LogFrom>,
    pub(super) with: Vec<WithFrom>,
    pub(super) questions: Option<Questionnaire>,
    pub(super) task: Option<TaskFrom>,
}

impl Beside {
    /// The columns of answers and of what a task presented.
    pub(super) fn columns(&self) -> Vec<&ColumnRef> {
        let answers = self.questions.iter().flat_map(Questionnaire::columns);
        answers.chain(self.task.iter().flat_map(TaskFrom::columns)).collect()
    }
}

/// A file beside a recording: its path from the folder of the recording, in which `{group}` stands for a group of the
/// pattern on the recording's path, and how it is written.
#[derive(Debug, Clone)]
pub(super) struct FileBeside {
    pub(super) path: String,
    pub(super) form: FileForm,
}

/// A table of another program, a row of which belongs to each trial. Its columns are `NAME@log`.
#[derive(Debug, Clone)]
pub(super) struct LogFrom {
    pub(super) file: FileBeside,
    pub(super) by: RowBy,
    /// Rows with these words, which are labels of the recording.
    pub(super) only: Vec<(ColumnRef, Label)>,
    /// Rows with one of these words in each of the columns.
    pub(super) when: Vec<(ColumnRef, Vec<String>)>,
    /// Whether rows without a trial and trials without a row are left as they are.
    pub(super) drops_unmatched: bool,
}

/// By what a row of a log is that of a trial.
#[derive(Debug, Clone)]
pub(super) enum RowBy {
    /// The log's number of the trial and what is added to it; and the recording's, counted within a file where no label
    /// names it.
    Number {
        column: ColumnRef,
        add: i64,
        recording: Option<Label>,
    },
    Time {
        clock: ClockFrom,
        offset_s: f64,
        at: At,
        until: Option<ColumnRef>,
    },
}

/// Times of a file beside a recording.
#[derive(Debug, Clone)]
pub(super) enum ClockFrom {
    Column { from: ColumnRef, unit: &'static Unit, from_first: bool },
    Rate { rate_hz: f64 },
}

/// A second file of the same trials. Its columns are `NAME@ID`.
#[derive(Debug, Clone)]
pub(super) struct WithFrom {
    pub(super) id: String,
    pub(super) file: FileBeside,
    pub(super) clock: ClockFrom,
    /// Added to its times, which then are those of the recording, s.
    pub(super) offset_s: f64,
    /// Values at other times than its own, if that is asked for.
    pub(super) resample: Option<Resample>,
}

/// How a questionnaire lies in its files, and what its cells mean.
#[derive(Debug, Clone)]
pub(super) struct Questionnaire {
    pub(super) form: AnswerForm,
    /// Their word → the number of the scale. What is no such word is a number.
    pub(super) translate: BTreeMap<String, i16>,
    /// Their number for the lowest answer, if they number the answers otherwise than the scale.
    pub(super) lowest: Option<i64>,
    /// The unit of the times that answers took.
    pub(super) time_unit: Option<&'static Unit>,
}

/// The places of answers.
#[derive(Debug, Clone)]
pub(super) enum AnswerForm {
    /// A column a question, and a row a trial, or a trial of each of several conditions.
    Wide(Vec<RowTrial>),
    /// A row an answer.
    Long(Box<(Who, LongForm)>),
}

/// The trial of a row.
#[derive(Debug, Clone)]
pub(super) struct RowTrial {
    pub(super) who: Who,
    /// No column listed: those whose header is a question's text.
    pub(super) columns: BTreeMap<QuestionId, AnswerFrom>,
    pub(super) times: BTreeMap<QuestionId, ColumnRef>,
}

/// Where the answers to tasks are: a row a presentation, or counts a level.
#[derive(Debug, Clone)]
pub(super) struct TaskFrom {
    /// Its environment is the task's, and is set where the study is known.
    pub(super) who: Who,
    pub(super) id: Label,
    pub(super) level: ColumnRef,
    /// The unit of the levels, as the mapping spells it.
    pub(super) unit: String,
    pub(super) line: Linear,
    pub(super) said: SaidFrom,
    pub(super) track: Option<Label>,
    pub(super) time: Option<ColumnRef>,
    pub(super) time_unit: Option<&'static Unit>,
    /// Rows with one of these words in each of the columns; all rows if there is none.
    pub(super) when: Vec<(ColumnRef, Vec<String>)>,
}

/// Where it is said what was answered.
#[derive(Debug, Clone)]
pub(super) enum SaidFrom {
    /// A row a presentation.
    Each(Box<EachFrom>),
    /// A row for many presentations of a level: how many there were, and how many answers were positive or right.
    Counts { presentations: ColumnRef, positive: Option<ColumnRef>, correct: Option<ColumnRef> },
}

/// Where it is said of one presentation.
#[derive(Debug, Clone)]
pub(super) struct EachFrom {
    /// What was answered.
    pub(super) answer: Option<Label>,
    /// Whether that was positive.
    pub(super) positive: Option<Label>,
    /// Whether it was right.
    pub(super) correct: Option<Label>,
    /// The interval with the standard.
    pub(super) standard: Option<Label>,
    /// That with the level.
    pub(super) comparison: Option<Label>,
}

impl SaidFrom {
    /// The columns that say what was answered, by what they say.
    pub(super) fn columns(&self) -> Vec<(&'static str, &ColumnRef)> {
        let columns = match self {
            Self::Each(each) => [
                ("answer", &each.answer),
                ("positive", &each.positive),
                ("correct", &each.correct),
                ("standard", &each.standard),
                ("comparison", &each.comparison),
            ]
            .map(|(what, label)| (what, label.as_ref().and_then(Label::column)))
            .to_vec(),
            Self::Counts { presentations, positive, correct } => vec![
                ("presentations", Some(presentations)),
                ("positive", positive.as_ref()),
                ("correct", correct.as_ref()),
            ],
        };
        columns.into_iter().filter_map(|(what, column)| Some((what, column?))).collect()
    }
}

impl TaskFrom {
    /// The columns without which nobody knows whose answer to what a row is.
    pub(super) fn labels(&self) -> Vec<&ColumnRef> {
        self.who.columns().into_iter().chain(self.id.column()).collect()
    }

    /// All columns that the mapping names.
    pub(super) fn columns(&self) -> Vec<&ColumnRef> {
        let said = self.said.columns().into_iter().map(|(_, column)| column);
        let when = self.when.iter().map(|(column, _)| column);
        let track = self.track.as_ref().and_then(Label::column);
        let own = [&self.level].into_iter().chain(said).chain(track).chain(&self.time);
        self.labels().into_iter().chain(own).chain(when).collect()
    }
}

/// The columns of a table with a row an answer.
#[derive(Debug, Clone)]
pub(super) struct LongForm {
    pub(super) question: Label,
    pub(super) answer: ColumnRef,
    pub(super) time: Option<ColumnRef>,
}

impl RowTrial {
    fn columns(&self) -> Vec<&ColumnRef> {
        let answers = self.columns.values().map(AnswerFrom::column);
        self.who.columns().into_iter().chain(answers).chain(self.times.values()).collect()
    }
}

impl Questionnaire {
    /// The columns that the mapping names.
    pub(super) fn columns(&self) -> Vec<&ColumnRef> {
        match &self.form {
            AnswerForm::Wide(trials) => trials.iter().flat_map(RowTrial::columns).collect(),
            AnswerForm::Long(long) => {
                let (who, LongForm { question, answer, time }) = &**long;
                let labels = who.columns().into_iter().chain(question.column());
                labels.chain([answer]).chain(time).collect()
            }
        }
    }
}

/// How the files are written.
#[derive(Debug, Clone)]
pub(super) struct FileForm {
    pub(super) format: Option<Format>,
    pub(super) delimiter: Option<u8>,
    pub(super) cells: CellForm,
    pub(super) header: bool,
    pub(super) comment: Option<u8>,
    pub(super) skip: usize,
    pub(super) rows: Option<usize>,
    pub(super) part: Option<String>,
    /// Whether a matrix has its signals in its rows.
    pub(super) turned: bool,
    pub(super) encoding: Encoding,
    /// The number of unreadable rows that may be left out.
    pub(super) bad_lines: usize,
    /// Whether a time that starts over begins another trial.
    pub(super) splits_at_time: bool,
    /// Texts of more bytes are read block by block.
    pub(super) long_from: u64,
    /// Whether something is asked for that looks at a trial from its beginning to its end: then no text is
    /// read block by block.
    pub(super) whole: bool,
    pub(super) clock: XdfClock,
    /// Whether the times of a steady XDF stream are put on a straight line.
    pub(super) dejitter: bool,
}

/// How the cells of a file are written.
#[derive(Debug, Clone, Default)]
pub(super) struct CellForm {
    pub(super) decimal_comma: bool,
    /// The treatment of rows without a value.
    pub(super) missing: Missing,
    /// Words for a missing value besides the common ones.
    pub(super) missing_words: Vec<String>,
    /// Columns in which `true` and `false` stand for 1 and 0.
    pub(super) truths: Vec<ColumnRef>,
}

impl CellForm {
    /// Whether the mapping names what stands in a cell as a word for a missing value: `-99` is `-99.0`
    /// too.
    pub(super) fn is_missing(&self, cell: &Cell) -> bool {
        self.missing_words.iter().any(|word| match cell {
            Cell::Empty => false,
            Cell::Text(text) => plain(text) == plain(word) || is_number(text.parse().ok(), word),
            Cell::Number(number) => is_number(Some(*number), word),
        })
    }
}

/// Whether a number is that of a word, in whatever way it is written, or as a float of four bytes holds it.
fn is_number(number: Option<f64>, word: &str) -> bool {
    let meant: Option<f64> = word.parse().ok();
    #[allow(clippy::cast_possible_truncation)] // That is the question.
    // A program with floats of four bytes writes -99.9 as -99.9000015.
    let single = meant.map(|meant| f64::from(meant as f32));
    number.is_some() && (number == meant || number == single)
}

impl FileForm {
    /// The format named, or that of the file's extension.
    pub(super) fn format_of(&self, path: &Path) -> Result<Format, StoreError> {
        self.format.or_else(|| format_named(path)).ok_or_else(|| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            let what = format!("the extension '{extension}' names no known format");
            let words = Format::ALL.map(Format::word).join(", ");
            StoreError::new(path, what, format!("set format in [file] to one of {words}"))
        })
    }

    /// How delimited text of `format` is written. Where no delimiter is named: tabs in TSV; in CSV
    /// commas, or semicolons where the comma stands before decimals; elsewhere any white space.
    pub(super) fn dialect(&self, format: Format) -> Dialect {
        let usual = match (format, self.cells.decimal_comma) {
            (Format::Tsv, _) => b'\t',
            (Format::Txt, _) => WHITE_SPACE,
            (_, true) => b';',
            (_, false) => b',',
        };
        let delimiter = self.delimiter.unwrap_or(usual);
        Dialect {
            delimiter,
            header: self.header,
            comment: self.comment,
            skip: self.skip,
            encoding: self.encoding,
            bad_lines: self.bad_lines,
            before: 0,
        }
    }
}

/// The format that a file's extension names.
pub(super) fn format_named(path: &Path) -> Option<Format> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    Format::ALL.into_iter().find(|format| format.extensions().contains(&extension.as_str()))
}

/// Where the labels of a trial come from.
#[derive(Debug, Clone)]
pub(super) struct Who {
    pub(super) participant: Label,
    pub(super) session: Label,
    pub(super) environment: Label,
    pub(super) mode: Label,
    pub(super) kind: Option<Label>,
    pub(super) repeat: Option<Label>,
    pub(super) trial: Option<Label>,
    pub(super) likert: Option<Label>,
}

impl Who {
    /// The columns that labels come from.
    pub(super) fn columns(&self) -> Vec<&ColumnRef> {
        let answer = self.likert.as_ref().and_then(Label::column);
        self.needed_columns().into_iter().chain(answer).collect()
    }

    /// Those of them without which nobody knows which trial it is; an answer may be missing.
    pub(super) fn needed_columns(&self) -> Vec<&ColumnRef> {
        let fixed = [&self.participant, &self.session, &self.environment, &self.mode];
        let optional = [&self.kind, &self.repeat, &self.trial];
        fixed.into_iter().chain(optional.into_iter().flatten()).filter_map(Label::column).collect()
    }
}

/// A column of theirs, and how its numbers become ours.
#[derive(Debug, Clone)]
pub(super) struct ColumnFrom {
    pub(super) from: ColumnRef,
    pub(super) unit: &'static Unit,
    /// As the mapping spells it.
    pub(super) unit_text: String,
    pub(super) line: Linear,
}

/// Where the time of a sample comes from.
#[derive(Debug, Clone)]
pub(super) enum Time {
    Column {
        column: ColumnFrom,
        mend: Mend,
    },
    /// The n-th row, from 0, lies at n / rate.
    Rate {
        rate_hz: f64,
    },
}

/// Repairs of a column of times before it is converted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mend {
    /// Where it starts over, in their unit.
    pub(super) wrap: Option<f64>,
    pub(super) equal: Option<Equal>,
    /// The rate of a column that counts samples, Hz.
    pub(super) counts_at_hz: Option<f64>,
}

/// Where a signal comes from.
#[derive(Debug, Clone)]
pub(super) struct SignalFrom {
    pub(super) to: Signal,
    pub(super) origin: Origin,
}

/// Where a channel of the study's own comes from.
#[derive(Debug, Clone)]
pub(super) struct ChannelFrom {
    pub(super) to: ChannelId,
    pub(super) from: ColumnRef,
    /// The study's unit of it.
    pub(super) unit: String,
    pub(super) line: Linear,
}

/// A column of theirs, or a rule.
#[derive(Debug, Clone)]
pub(super) enum Origin {
    /// With the value at which it starts over, in their unit.
    Column {
        column: ColumnFrom,
        wrap: Option<f64>,
    },
    Derived(Rule),
}

/// How a signal is computed from others.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rule {
    DerivativeOf(Signal),
    IntegralOf(Signal),
    /// The projection of position or force on the push of the study's axes.
    AlongPush(PushOrigin),
}

/// Where the coordinate along the push is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PushOrigin {
    /// At the trial's first sample.
    First,
    /// At a place in the frame of the axes, m.
    Place([f64; 3]),
}

/// Where a sweep comes from: its labels, its quantities, and how it lies in its file.
#[derive(Debug, Clone)]
pub(super) struct SweepFrom {
    pub(super) actuator: Label,
    pub(super) number: Option<Label>,
    pub(super) command: QuantityFrom,
    pub(super) response: QuantityFrom,
    pub(super) form: SweepForm,
}

/// How a sweep lies in its file.
#[derive(Debug, Clone)]
pub(super) enum SweepForm {
    /// A row a sample.
    Pairs(Pairs),
    /// A column a value of one quantity.
    Wide(Wide),
}

/// A quantity of a sweep, and how its values are converted.
#[derive(Debug, Clone)]
pub(super) struct QuantityFrom {
    pub(super) quantity: Quantity,
    pub(super) line: Linear,
}

impl Mapping {
    /// The source of the imported numbers.
    pub(super) fn source(&self) -> Source {
        if self.simulated { Source::Simulated } else { Source::Imported }
    }
}

/// Which rows of a table exclude a trial, which trial, and why.
#[derive(Debug, Clone)]
pub(super) struct Exclusions {
    pub(super) trial: TrialFrom,
    /// Rows with one of these words in each of the columns; all rows if there is none.
    pub(super) when: Vec<(ColumnRef, Vec<String>)>,
    pub(super) reason: Label,
}

/// How a row names its trial.
#[derive(Debug, Clone)]
pub(super) enum TrialFrom {
    /// By the recording that it was imported from: a path from this folder, which lies beside the table.
    Recording { column: ColumnRef, folder: PathBuf },
    /// By its participant, its session and its number.
    Labels(Box<[Label; 3]>),
}

/// Where the rows of the participants' file come from.
#[derive(Debug, Clone)]
pub(super) struct PeopleFrom {
    pub(super) participant: Label,
    pub(super) columns: BTreeMap<PersonColumnId, Label>,
    /// The units of their numbers, where they are not those of the study.
    pub(super) units: BTreeMap<PersonColumnId, String>,
}

impl PeopleFrom {
    pub(super) fn columns(&self) -> impl Iterator<Item = &ColumnRef> {
        self.columns.values().chain([&self.participant]).filter_map(Label::column)
    }
}

impl Exclusions {
    pub(super) fn columns(&self) -> impl Iterator<Item = &ColumnRef> {
        let named = match &self.trial {
            TrialFrom::Recording { column, .. } => vec![column],
            TrialFrom::Labels(labels) => labels.iter().filter_map(Label::column).collect(),
        };
        let when = self.when.iter().map(|(column, _)| column);
        named.into_iter().chain(when).chain(self.reason.column())
    }
}

/// How a wide file is mapped.
#[derive(Debug, Clone)]
pub(super) struct Wide {
    /// Matches the headers in use; its group `value` is the number.
    pub(super) pattern: Regex,
    /// Which quantity stands in the headers.
    pub(super) header: Side,
    pub(super) reduce: Option<Reduce>,
}

/// How a file of pairs is mapped.
#[derive(Debug, Clone)]
pub(super) struct Pairs {
    pub(super) time: Option<Time>,
    pub(super) command: ColumnRef,
    pub(super) response: ColumnRef,
}

impl Pairs {
    /// The columns of command, response and, where it has one, time.
    pub(super) fn columns(&self) -> Vec<&ColumnRef> {
        let time = match &self.time {
            Some(Time::Column { column, .. }) => Some(&column.from),
            _ => None,
        };
        [&self.command, &self.response].into_iter().chain(time).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use super::*;
    use zwidth_store::Signal;
    use zwidth_study::Study;

    fn workspace(path: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
    }

    /// The mappings and the tables in the code blocks of the documentation.
    fn examples() -> Vec<String> {
        let text = std::fs::read_to_string(workspace("docs/import.md")).unwrap();
        let blocks = text.split("```toml\n").skip(1).filter_map(|t| t.split("```").next());
        blocks.filter(|b| b.starts_with("kind = ")).map(str::to_owned).collect()
    }

    #[test]
    fn every_mapping_in_the_documentation_is_valid() {
        let examples = examples();
        assert_eq!(examples.len(), 10);
        for text in examples {
            Mapping::from_toml(&text, Path::new("docs/import.md")).unwrap();
        }
    }

    #[test]
    fn the_first_mapping_in_the_documentation_does_what_it_says() {
        let world = World::new();
        let csv = "time_ms;angle_deg;F_N;status\n0;-45,0;0,02;ok\n1;-44,9;-0,05;ok\n";
        world.import(&examples()[0], &[world.file("results/P03/2_active.csv", csv)]).unwrap();
        let trial = world.trial("P03", "S02", 1);
        assert_eq!(trial.samples.get(Signal::ForceEx).unwrap(), [-0.02, 0.05]);
        let velocity = trial.samples.get(Signal::ThetaDot).unwrap()[0];
        assert!((velocity - 100_f64.to_radians()).abs() < 1e-9, "{velocity}");
    }

    #[test]
    fn every_study_and_mapping_that_comes_with_the_program_is_valid() {
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        let mut mappings = 0;
        for folder in std::fs::read_dir(workspace("studies")).unwrap() {
            let folder = folder.unwrap().path();
            let study = Study::from_toml(&read(&folder.join("study.toml"))).unwrap();
            assert_eq!(Some(study.id.as_str()), folder.file_name().unwrap().to_str());
            for file in std::fs::read_dir(folder).unwrap() {
                let path = file.unwrap().path();
                if path.file_name().unwrap().to_str().unwrap().starts_with("map") {
                    Mapping::from_toml(&read(&path), &path).unwrap();
                    mappings += 1;
                }
            }
        }
        assert!(mappings >= 6, "{mappings}");
    }
}
