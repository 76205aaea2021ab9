//! Which trial a row is about, what happened in it, and the remarks on it.

use crate::column::UNIT_OF_ROW;
use crate::note::NoteKind;
use crate::row::{of_condition, of_trial, rows};
use crate::sentence::Sentence;
use crate::value::{named, words};
use zwidth_study::{EnvironmentId, Kind, ModeId, ParticipantId, SessionId, Source, Status};

named!(Source, Kind, Status);

words! {
    /// Something that happens in a trial.
    EventKind {
        /// The movement begins.
        Onset = "onset",
        /// A contact with the wall begins: the first sample with θ > θ_wall after a retreat of more
        /// than 1 % of the angles travelled.
        Contact = "contact",
        /// The lever turns.
        Reversal = "reversal",
        /// The brake goes off from one sample to the next, wherever the lever is.
        LetGo = "let_go",
        /// The movement ends.
        End = "end",
    }

    /// What can be said of a recording's stability. A recording cannot be run again with half the
    /// step, so that chattering of a method and a limit cycle of the device, which a model run tells
    /// apart, are one here.
    RecordedStability {
        /// Fewer than six fast swings.
        Smooth = "smooth",
        /// Six fast swings or more.
        Oscillating = "oscillating",
    }
}

rows! {
    /// The first columns of every table with a row for each trial.
    TrialKey = "trials", "Trials" {
        ..of_trial,
    }

    /// What the repeats of a condition share: a participant in a session.
    ConditionKey = "conditions", "Conditions" {
        ..of_condition,
    }

    /// The first columns of the table with a row for each condition.
    ConditionTrials = "conditions", "Metrics by condition: mean and SD of each participant's repeats" {
        ..of_condition,
        /// trials
        n: usize,
    }

    /// Something that happened in a trial, and when.
    TrialEvent = "events", "What happened in each trial, one row per event" {
        ..of_trial,
        /// onset, contact, reversal, let_go or end
        event: EventKind,
        /// when, as the trial's samples count time
        t_s: f64 = "s",
    }

    /// A value of a metric that another program computed.
    OutsideValue = "values", "Values from outside of zwidth, one row per trial" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// its number in the session
        trial: u32,
        /// the value, in the unit of the metric; null where there is none
        value: Option<f64> = UNIT_OF_ROW,
    }

    /// A trial that has no metrics, or whose metrics are to be read with care.
    TrialRemark = "remarks", "Trials that are left out, or to be read with care" {
        /// the trial's file, from the folder that holds raw/
        path: String,
        /// left_out, or care
        kind: NoteKind,
        /// the trial or its file, with column and row
        what: String,
        /// why it is left out, or what was found in it; what to do
        why: Sentence,
    }

    /// A trial, and whether it counts.
    CountedTrial = "trials", "Every trial, and whether it counts" {
        /// the trial's file, from the folder that holds raw/
        path: String,
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// its number in the session
        trial: u32,
        /// of its condition
        repeat: u32,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered; a code while the session is sealed
        mode: ModeId,
        /// trial or familiarisation
        kind: Kind,
        /// complete or incomplete
        status: Status,
        /// where its numbers come from
        source: Source,
        /// whether it enters any mean, metric or test
        counts: bool,
        /// why it does not count; null if it does
        why_not: Option<String>,
        /// whether it counts and something was found in it
        read_with_care: bool,
    }
}

impl TrialKey {
    /// The condition that the trial is a repeat of.
    pub fn condition(&self) -> ConditionKey {
        ConditionKey {
            participant: self.participant.clone(),
            session: self.session.clone(),
            environment: self.environment.clone(),
            mode: self.mode.clone(),
        }
    }
}

impl From<&zwidth_study::TrialMeta> for TrialKey {
    fn from(meta: &zwidth_study::TrialMeta) -> Self {
        Self {
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            trial: meta.trial,
            repeat: meta.repeat,
            environment: meta.environment.clone(),
            mode: meta.mode.clone(),
            source: meta.source,
        }
    }
}
