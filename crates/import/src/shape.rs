//! The mapping file as it stands: its tables and keys, unchecked.

use super::format::Format;
use super::label::LabelShape;
use super::table::ColumnRef;
use super::text::Encoding;
use super::xdf::XdfClock;
use serde::Deserialize;
use std::collections::BTreeMap;
use zwidth_study::PersonColumnId;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum KindShape {
    Trials,
    Sweeps,
    Likert,
    Psychometric,
    Exclusions,
    Participants,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Shape {
    pub(super) kind: KindShape,
    #[serde(default)]
    pub(super) simulated: bool,
    #[serde(default)]
    pub(super) file: FileShape,
    pub(super) name: Option<NameShape>,
    #[serde(default)]
    pub(super) drop: BTreeMap<String, String>,
    pub(super) trial: Option<TrialShape>,
    pub(super) time: Option<TimeShape>,
    #[serde(default)]
    pub(super) column: Vec<ColumnShape>,
    #[serde(default)]
    pub(super) channel: Vec<ChannelShape>,
    pub(super) sweep: Option<SweepShape>,
    pub(super) command: Option<QuantityShape>,
    pub(super) response: Option<QuantityShape>,
    pub(super) wide: Option<WideShape>,
    pub(super) questions: Option<QuestionsShape>,
    #[serde(default)]
    pub(super) condition: Vec<ConditionShape>,
    pub(super) task: Option<TaskShape>,
    pub(super) log: Option<LogShape>,
    #[serde(default)]
    pub(super) with: Vec<WithShape>,
    pub(super) exclude: Option<ExcludeShape>,
    pub(super) people: Option<PeopleShape>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PeopleShape {
    pub(super) participant: LabelShape,
    pub(super) columns: BTreeMap<PersonColumnId, LabelShape>,
    #[serde(default)]
    pub(super) units: BTreeMap<PersonColumnId, String>,
}

/// The treatment of rows in which a mapped cell is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Missing {
    #[default]
    Error,
    Drop,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FileShape {
    pub(super) format: Option<Format>,
    pub(super) delimiter: Option<char>,
    pub(super) decimal: char,
    pub(super) header: bool,
    pub(super) comment: Option<char>,
    pub(super) skip: usize,
    pub(super) rows: Option<usize>,
    pub(super) missing: Missing,
    pub(super) missing_words: Vec<String>,
    #[serde(alias = "sheet", alias = "stream", alias = "group", alias = "topic")]
    pub(super) matrix: Option<String>,
    pub(super) signals: SignalsIn,
    pub(super) encoding: Encoding,
    pub(super) bad_lines: usize,
    pub(super) split: Option<Split>,
}

/// Where a matrix has its signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SignalsIn {
    Columns,
    /// As Simulink writes them.
    Rows,
}

/// Where one file's rows are parted into trials besides by their labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Split {
    /// Where the time starts over.
    Time,
}

impl Default for FileShape {
    fn default() -> Self {
        Self {
            format: None,
            delimiter: None,
            decimal: '.',
            header: true,
            comment: None,
            skip: 0,
            rows: None,
            missing: Missing::Error,
            missing_words: Vec::new(),
            matrix: None,
            signals: SignalsIn::Columns,
            encoding: Encoding::Utf8,
            bad_lines: 0,
            split: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NameShape {
    pub(super) pattern: String,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrialShape {
    pub(super) participant: LabelShape,
    pub(super) session: LabelShape,
    pub(super) environment: Option<LabelShape>,
    pub(super) mode: Option<LabelShape>,
    pub(super) kind: Option<LabelShape>,
    pub(super) repeat: Option<LabelShape>,
    pub(super) trial: Option<LabelShape>,
    pub(super) likert: Option<LabelShape>,
}

/// The values of `zero` for a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum ZeroWord {
    First,
}

/// The values of `zero` for another column.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"first\", or a stretch at rest, { from_s = 0.0, to_s = 0.5 }"
)]
pub(super) enum ZeroShape {
    Word(ZeroWord),
    Rest(RestShape),
}

/// A stretch of a trial, in seconds from its first sample.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RestShape {
    #[serde(default)]
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

/// The treatment of samples with the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Equal {
    /// The first of them stays.
    Drop,
    /// Their mean takes their place.
    Mean,
}

/// The meaning of a time that runs backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Backwards {
    Refuse,
    Split,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeShape {
    pub(super) from: Option<ColumnRef>,
    pub(super) unit: Option<String>,
    pub(super) offset: Option<f64>,
    pub(super) zero: Option<ZeroWord>,
    pub(super) rate_hz: Option<f64>,
    pub(super) counter: Option<ColumnRef>,
    pub(super) wrap: Option<f64>,
    pub(super) equal: Option<Equal>,
    pub(super) backwards: Option<Backwards>,
    pub(super) clock: Option<XdfClock>,
    pub(super) dejitter: Option<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ColumnShape {
    pub(super) to: String,
    pub(super) from: Option<ColumnRef>,
    pub(super) unit: Option<String>,
    pub(super) sign: Option<f64>,
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<f64>,
    pub(super) zero: Option<ZeroShape>,
    pub(super) wrap: Option<f64>,
    pub(super) derive: Option<String>,
    pub(super) origin: Option<OriginShape>,
}

/// Where the coordinate along the push is 0.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected \"first\", or a place in metres such as [0.0, 0.12, 0.0]")]
pub(super) enum OriginShape {
    Word(ZeroWord),
    Place([f64; 3]),
}

/// A column of theirs that becomes a channel of the study's own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChannelShape {
    pub(super) to: String,
    pub(super) from: ColumnRef,
    pub(super) unit: String,
    pub(super) sign: Option<f64>,
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<f64>,
    pub(super) zero: Option<ZeroShape>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepShape {
    pub(super) actuator: LabelShape,
    pub(super) sweep: Option<LabelShape>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuantityShape {
    pub(super) from: Option<ColumnRef>,
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) sign: Option<f64>,
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<f64>,
    pub(super) zero: Option<ZeroShape>,
}

/// Which quantity of a wide sweep stands in the headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Side {
    Command,
    Response,
}

/// The reduction of the rows of a wide sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Reduce {
    Mean,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WideShape {
    pub(super) pattern: String,
    pub(super) header: Side,
    pub(super) reduce: Option<Reduce>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct QuestionsShape {
    pub(super) columns: BTreeMap<String, AnswerFrom>,
    pub(super) times: BTreeMap<String, ColumnRef>,
    pub(super) question: Option<LabelShape>,
    pub(super) answer: Option<ColumnRef>,
    pub(super) time: Option<ColumnRef>,
    pub(super) time_unit: Option<String>,
    pub(super) lowest: Option<i64>,
    pub(super) translate: BTreeMap<String, i16>,
}

/// One of the conditions that a row of a questionnaire has answers about.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConditionShape {
    pub(super) environment: Option<LabelShape>,
    pub(super) mode: Option<LabelShape>,
    pub(super) repeat: Option<LabelShape>,
    pub(super) trial: Option<LabelShape>,
    pub(super) columns: BTreeMap<String, AnswerFrom>,
    #[serde(default)]
    pub(super) times: BTreeMap<String, ColumnRef>,
}

/// Where an answer stands.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a column, or { column = …, key = … } for JSON in its cells"
)]
pub(super) enum AnswerFrom {
    Cell(ColumnRef),
    Json(JsonKey),
}

/// A key of the JSON object in each cell of a column.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonKey {
    pub(super) column: ColumnRef,
    pub(super) key: String,
}

impl AnswerFrom {
    /// The column that it is in.
    pub(super) fn column(&self) -> &ColumnRef {
        match self {
            Self::Cell(column) | Self::Json(JsonKey { column, .. }) => column,
        }
    }
}

/// Where the answers to a task are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskShape {
    pub(super) id: LabelShape,
    pub(super) level: ColumnRef,
    pub(super) unit: Option<String>,
    pub(super) sign: Option<f64>,
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<f64>,
    pub(super) answer: Option<LabelShape>,
    pub(super) positive: Option<LabelShape>,
    pub(super) correct: Option<LabelShape>,
    pub(super) presentations: Option<ColumnRef>,
    pub(super) standard: Option<LabelShape>,
    pub(super) comparison: Option<LabelShape>,
    pub(super) track: Option<LabelShape>,
    pub(super) time: Option<ColumnRef>,
    pub(super) time_unit: Option<String>,
    #[serde(default)]
    pub(super) when: BTreeMap<String, Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExcludeShape {
    pub(super) recording: Option<ColumnRef>,
    pub(super) folder: Option<String>,
    pub(super) participant: Option<LabelShape>,
    pub(super) session: Option<LabelShape>,
    pub(super) trial: Option<LabelShape>,
    #[serde(default)]
    pub(super) when: BTreeMap<String, Vec<String>>,
    pub(super) reason: LabelShape,
}

/// A table that another program wrote beside the recordings, with a row per trial.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LogShape {
    pub(super) path: String,
    #[serde(default)]
    pub(super) file: FileShape,
    pub(super) trial: Option<ColumnRef>,
    pub(super) number: Option<LabelShape>,
    pub(super) add: Option<i64>,
    pub(super) time: Option<ColumnRef>,
    pub(super) unit: Option<String>,
    pub(super) zero: Option<ZeroWord>,
    pub(super) offset_s: Option<f64>,
    pub(super) at: Option<At>,
    pub(super) until: Option<ColumnRef>,
    #[serde(default, rename = "where")]
    pub(super) only: BTreeMap<String, LabelShape>,
    #[serde(default)]
    pub(super) when: BTreeMap<String, Vec<String>>,
    pub(super) unmatched: Option<Unmatched>,
}

/// Which samples belong to a row of a log, by the row's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum At {
    /// A trial begins with its row.
    #[default]
    Begin,
    /// It ends with its row.
    End,
    /// A recording is a trial, within which its row lies.
    Within,
}

/// The treatment of rows of a log without a trial, and of trials without a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Unmatched {
    Error,
    Drop,
}

/// A second file of the same trials, whose samples are put on the times of the recording.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WithShape {
    pub(super) id: String,
    pub(super) path: String,
    #[serde(default)]
    pub(super) file: FileShape,
    pub(super) time: Option<ColumnRef>,
    pub(super) unit: Option<String>,
    pub(super) zero: Option<ZeroWord>,
    pub(super) rate_hz: Option<f64>,
    pub(super) offset_s: Option<f64>,
    pub(super) resample: Option<Resample>,
}

/// How values come to stand between the samples of a second file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Resample {
    /// The last sample before.
    Previous,
    /// On the line between the samples on both sides.
    Linear,
}
