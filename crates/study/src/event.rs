//! Events: what happened to a session after, or besides, its samples. They are append-only.

use crate::words::words;
use crate::{
    ActuatorId, AnswerValue, Better, LevelId, MetricId, ModeId, PersonColumnId, QuestionId,
    StreamId, TaskLevel,
};
use serde::{Deserialize, Serialize};

/// One line of `sessions/<participant>_<session>.events.jsonl`, of `sweeps.events.jsonl`, or of
/// `own.events.jsonl`.
///
/// Files under `trials/` never change; whatever comes later is an event, joined to the trials by
/// the store when it reads.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// The session was laid down: the first line of its log.
    LaidDown {
        /// BLAKE3 of the session's record, hexadecimal.
        record_blake3: String,
    },
    /// A sweep's file was finished.
    SweepRecorded {
        /// What was characterised.
        actuator: ActuatorId,
        /// The sweep's number.
        sweep: u32,
        /// BLAKE3 of the whole file, hexadecimal.
        blake3: String,
    },
    /// A table of values of a metric was given that another program computed.
    MetricGiven {
        /// The metric, without prefix and unit.
        metric: MetricId,
        /// The number of its table, from 1; the last one counts.
        table: u32,
        /// Its unit.
        unit: String,
        /// What people call it.
        label: String,
        /// Which values are better.
        better: Better,
        /// Who computed it, where that was said.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        program: Option<String>,
        /// The name of the file that was given, without its folder.
        file: String,
        /// BLAKE3 of the file that was given, hexadecimal.
        file_blake3: String,
        /// BLAKE3 of the table as it is kept, hexadecimal. The table names the hash of each recording.
        blake3: String,
    },
    /// No table of a metric that was given counts, up to here.
    MetricWithdrawn {
        /// The metric, without prefix and unit.
        metric: MetricId,
        /// Why, in words.
        reason: String,
    },
    /// A trial's file was finished.
    Recorded {
        /// Trial number.
        trial: u32,
        /// BLAKE3 of the whole file, in hexadecimal.
        blake3: String,
    },
    /// A question was answered.
    Answer {
        /// Trial number.
        trial: u32,
        /// Which question.
        question: QuestionId,
        /// The answer as given (not reversed), a number of the question's scale.
        value: AnswerValue,
        /// From the question to its answer, ms, where it was measured. Whole, so that what is read
        /// is what was written, to the last bit.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        time_ms: Option<u32>,
    },
    /// The level of a presentation that answers before it decide, kept before its trial begins.
    Level {
        /// Trial number, of the presentation's first interval.
        trial: u32,
        /// The level that is compared with the standard.
        level: TaskLevel,
    },
    /// The trial was done again, or is to be; this one no longer counts. The one that takes its
    /// place has its environment, mode, repeat and kind.
    Superseded {
        /// Trial number that no longer counts.
        trial: u32,
        /// Trial number that takes its place.
        by: u32,
    },
    /// The trial does not count, for a stated reason.
    Excluded {
        /// Trial number.
        trial: u32,
        /// Why, in words.
        reason: String,
    },
    /// The trial did not meet the protocol, and does not count: the study's rule (`design.redo_unmet`) has it done again.
    Unmet {
        /// Trial number.
        trial: u32,
        /// What was not met, in words.
        what: String,
    },
    /// A remark.
    Note {
        /// Trial number, where it belongs to one.
        trial: Option<u32>,
        /// The remark.
        text: String,
    },
    /// A moment of the trial was told to other programs, or was to be.
    Marker {
        /// Trial number.
        trial: u32,
        /// Which moment.
        moment: Moment,
        /// Since the trial's start by the host's clock, as in the trial's file, µs.
        t_us: u64,
        /// The device's own clock, µs, where it has one and the moment is a sample's.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        device_us: Option<u64>,
        /// The machine's monotonic clock, µs, in real time where it has one that others can read.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        monotonic_us: Option<u64>,
    },
    /// A stream was given that another program recorded beside the session.
    StreamGiven {
        /// The stream.
        stream: StreamId,
        /// The number of its table, from 1; the last one counts.
        table: u32,
        /// The name of the file that was given, without its folder.
        file: String,
        /// BLAKE3 of the file that was given, hexadecimal.
        file_blake3: String,
        /// BLAKE3 of the table as it is kept, hexadecimal.
        blake3: String,
    },
    /// No table of a stream that was given counts, up to here.
    StreamWithdrawn {
        /// The stream.
        stream: StreamId,
        /// Why, in words.
        reason: String,
    },
    /// The sealed order of modes was opened. It is true only if it verifies against the session's
    /// commitment ([`crate::Seal`]).
    Unsealed {
        /// The nonce of the seal, hexadecimal.
        nonce: String,
        /// The mode of each planned trial, by number.
        order: Vec<SealedTrial>,
    },
    /// A changed `study.toml` was accepted: the session's trials are read under the one of this
    /// hash. The session itself goes on by its own copy.
    StudyAccepted {
        /// BLAKE3 of that `study.toml`, hexadecimal.
        study_blake3: String,
    },
    /// Another group of the person than the session began with was accepted; where it began with none, the first is what the
    /// participants' file said later, and others are compared with that.
    PersonAccepted {
        /// The column of people whose groups are compared.
        column: PersonColumnId,
        /// The group that the participants' file says now; none if it says none.
        level: Option<LevelId>,
    },
}

words! {
    /// A moment of a trial that others may want to know of; all of them in a trial's order.
    Moment {
        /// Its first sample.
        Start = "start",
        /// Its first sample past the wall.
        Contact = "contact",
        /// Its last sample.
        End = "end",
        /// An answer to one of its questions.
        Answer = "answer",
    }
}

/// An answer as it was given (not reversed) at a screen of this program, which offers whole numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Given {
    /// A number of the question's scale.
    pub value: i16,
    /// From the question to its answer, ms, where it was measured.
    pub time_ms: Option<u32>,
}

/// A trial, and what was sealed of it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SealedTrial {
    /// Trial number.
    pub trial: u32,
    /// Its mode.
    pub mode: ModeId,
    /// Whether it holds the standard, if it is an interval of two of a task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is_standard: Option<bool>,
}

impl Event {
    /// The trial that the event is about, if it is about one.
    pub fn trial(&self) -> Option<u32> {
        match self {
            Self::Recorded { trial, .. }
            | Self::Answer { trial, .. }
            | Self::Level { trial, .. }
            | Self::Superseded { trial, .. }
            | Self::Marker { trial, .. }
            | Self::Excluded { trial, .. }
            | Self::Unmet { trial, .. } => Some(*trial),
            Self::Note { trial, .. } => *trial,
            // Listed, so that whoever adds an event decides here.
            Self::LaidDown { .. }
            | Self::SweepRecorded { .. }
            | Self::MetricGiven { .. }
            | Self::MetricWithdrawn { .. }
            | Self::StreamGiven { .. }
            | Self::StreamWithdrawn { .. }
            | Self::Unsealed { .. }
            | Self::StudyAccepted { .. }
            | Self::PersonAccepted { .. } => None,
        }
    }
}
