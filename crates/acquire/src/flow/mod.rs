//! A session as a pure state machine: inputs in, actions out. No clock, no device, no file.
//!
//! ```text
//! Check → (AtStop →) Homing → Ready → Trial → Question → Pause → Ready → … → Done
//!                        ↑                                                       (Stop, Failed, a cut trial)
//!                        └──────────────── Start ─────────────── Stopped ←──── from every phase
//! ```
//!
//! The order is a row of *places*; each holds one trial. If a trial is repeated or was cut short, a
//! new trial takes its place **right away**. If it was the last one, the conditions that count
//! follow each other exactly as drawn, and blocks stay blocks. Numbers are never used twice: the
//! new trial takes the next free number after the order's last, and the event `superseded` names
//! both.
//!
//! An excluded trial is **missing**: its place counts as open, and is offered once all others are
//! done, unless somebody asks for the repeat earlier. Only then does a new trial take its place. A
//! familiarisation trial counts nowhere, so nothing is missing without it.
//!
//! A trial that did not meet the protocol is excluded by itself where the study says so, as many times a
//! place as it says.
//!
//! A presentation of a task with two intervals is two places. The second trial follows the first
//! after a short gap, and the question is the last one's. Whatever befalls one of them befalls both:
//! the presentation is done again, at the same level. Places of a sequence of levels that is over are
//! not needed any more.

mod about;
mod act;
mod start;
#[cfg(test)]
mod tests;

use crate::tasks::Tasks;
pub use start::Recorded;
use std::collections::BTreeSet;
use zwidth_study::{Event, Given, Kind, PlannedTrial, Question};

/// Between the two intervals of a presentation, s: the lever comes back, and what was felt is still
/// remembered.
pub(crate) const GAP_S: f64 = 1.0;

/// What a stop by key is called.
pub const EMERGENCY_STOP: &str = "emergency stop";

/// Why what would come between two intervals of a presentation is refused.
const UNDER_WAY: &str = "a presentation is under way: that can be asked for when it is over";

/// What happens to a session.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// The device passed its check.
    Checked,
    /// The device stands at its stop and knows its angle.
    Homed,
    /// The check, homing or the device failed, in words.
    Failed(String),
    /// The trial that ran to its end did not meet the protocol, and what was not met; [`Input::Ended`] follows.
    Unmet(String),
    /// The trial that ran has ended.
    Ended(End),
    /// Time went by, s.
    Elapsed(f64),
    /// Begin the next trial; after a stop: go on.
    Start,
    /// What will move the lever by itself may do so.
    Yes,
    /// The answer to the question, a number of its scale.
    Answer(i16),
    /// The same, given at the participant's own screen: the log says so.
    AnswerThere(i16),
    /// The question stays without an answer.
    Skip,
    /// Hold the pause until this comes again, or somebody starts.
    Hold,
    /// Do the last trial again.
    Repeat,
    /// The last trial does not count, and why.
    Exclude(String),
    /// A remark on the trial at hand.
    Note(String),
    /// Something about a trial of the session, by its number.
    Of(u32, About),
    /// Something to be told, which changes nothing.
    Tell(String),
    /// Emergency stop.
    Stop,
    /// End the session here; it can be resumed.
    Quit,
}

/// Requests about any trial of a session, at any time at which none runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum About {
    /// It does not count, and why.
    Exclude(String),
    /// A remark on it.
    Note(String),
    /// Do it again, right away.
    Repeat,
    /// Ask its questions again: what is answered now is what counts.
    Ask,
}

/// How a trial ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// As planned: its time was up, or the participant had moved and let go.
    Complete,
    /// Cut short, and why: by a stop, or by a safety trigger.
    Cut(String),
}

/// What is to be done, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Check the device; [`Input::Checked`] or [`Input::Failed`] follows.
    Check,
    /// Bring the lever to its stop, actuators off; [`Input::Homed`] or [`Input::Failed`] follows.
    Home,
    /// Run and record a trial; [`Input::Ended`] follows.
    Run(PlannedTrial),
    /// End the running trial at 0 V, now.
    Halt,
    /// Both actuators to 0 V, while no trial runs.
    Off,
    /// Make the file of the trial that ended.
    Finish {
        /// Its number.
        trial: u32,
        /// Whether it ran to its end.
        complete: bool,
        /// The answer to its question, where given.
        likert: Option<Given>,
    },
    /// Append to the event log.
    Log(Event),
    /// Tell what follows from an input.
    Tell(String),
    /// Tell that an input was refused, and why; nothing changed.
    Refuse(String),
    /// The session is over for now.
    Leave,
}

/// Changes nothing, and tells why.
fn refuse(why: impl Into<String>) -> Vec<Action> {
    vec![Action::Refuse(why.into())]
}

/// The phase of the session.
#[derive(Debug, Clone, PartialEq)]
pub enum Phase {
    /// The device is being checked.
    Check,
    /// Somebody is to hold the lever against its stop; a start says that they do.
    AtStop,
    /// The lever goes to its stop.
    Homing,
    /// The next trial waits for its start.
    Ready,
    /// A trial runs.
    Trial {
        /// The stop or the quit that was requested meanwhile.
        halted: Option<Halt>,
    },
    /// A question of the trial at this place waits for an answer.
    Question {
        /// Index into the order.
        place: usize,
        /// Which of its questions, from 0.
        question: usize,
        /// Its file was finished before (by the answer to its first question, after a stop, or when
        /// resumed): the answer becomes an event.
        late: bool,
    },
    /// The pause after a trial.
    Pause,
    /// At 0 V until someone goes on or quits.
    Stopped {
        /// What stopped it.
        why: String,
    },
    /// Every trial of the order is done.
    Done,
    /// Nothing more happens.
    Left,
}

/// Why a running trial is ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Halt {
    /// Emergency stop.
    Stop,
    /// The session is to end.
    Quit,
}

/// One place of the order.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The trial that holds the place now.
    pub trial: PlannedTrial,
    /// The trial it took the place from.
    pub repeats: Option<u32>,
    /// The questions after it, in order.
    pub questions: Vec<Question>,
    /// Whether it ran to its end.
    pub done: bool,
    /// Whether it was excluded, and would count otherwise.
    pub excluded: bool,
    /// How many of its trials did not count by the rule for those that do not meet the protocol.
    pub unmet: u32,
}

impl Place {
    /// Whether it has a trial that was not excluded.
    pub(crate) fn is_settled(&self) -> bool {
        self.done && !self.excluded
    }

    /// Whether it would be missed if its trial were excluded.
    fn counts(&self) -> bool {
        self.trial.kind == Kind::Trial
    }

    /// The trial that ended here last: the one before the repeat that waits.
    fn ended(&self) -> u32 {
        self.repeats.filter(|_| !self.done).unwrap_or(self.trial.trial)
    }
}

/// A session.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    phase: Phase,
    places: Vec<Place>,
    /// What its places are in tasks.
    tasks: Tasks,
    /// Whether the last answer to a task was right, where the person is to be told.
    feedback: Option<bool>,
    /// The place whose trial ended last.
    last: Option<usize>,
    /// A place, and which of its questions is open although its trial's file is finished.
    open: Option<(usize, usize)>,
    /// Numbers of trials that ended, with whatever end.
    ended: BTreeSet<u32>,
    /// The number of the next repeat.
    next_number: u32,
    /// Shortest pause between trials, s.
    pause_s: f64,
    /// How many times a trial that did not meet the protocol is done again.
    redo_unmet: u32,
    /// What is left of the pause, s.
    rest_s: f64,
    /// Whether the pause goes on until somebody ends it.
    held: bool,
    /// For how long the open question has been shown, s; none until time went by.
    shown_s: Option<f64>,
    /// Whether the device passed its check.
    checked: bool,
    /// Whether the lever needs a hand to get to its stop.
    by_hand: bool,
}

impl Flow {
    /// The same session on a device whose lever needs a hand to get to its stop.
    pub(crate) fn homed_by_hand(self, by_hand: bool) -> Self {
        Self { by_hand, ..self }
    }

    /// The same session in which a trial that did not meet the protocol is done again, so many times.
    pub(crate) fn redoing(self, redo_unmet: u32) -> Self {
        Self { redo_unmet, ..self }
    }

    /// The phase of the session.
    pub(crate) fn phase(&self) -> &Phase {
        &self.phase
    }

    /// The order's places.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// The first place that is to be done, the trial in progress or the next one; after all of them
    /// the first whose trial was excluded.
    pub(crate) fn here(&self) -> Option<usize> {
        let is_needed = |place: &usize| self.tasks.is_needed(*place);
        let mut all = 0..self.places.len();
        let open = all.clone().find(|place| !self.places[*place].done && is_needed(place));
        open.or_else(|| all.find(|place| !self.places[*place].is_settled() && is_needed(place)))
    }

    /// What its places are in tasks.
    pub(crate) fn tasks(&self) -> &Tasks {
        &self.tasks
    }

    /// Whether a place is done, or still to be done: not where the levels of its task are over.
    pub(crate) fn is_needed(&self, place: usize) -> bool {
        self.places[place].is_settled() || self.tasks.is_needed(place)
    }

    /// Places that are done or still to be done.
    pub(crate) fn total(&self) -> usize {
        (0..self.places.len()).filter(|place| self.is_needed(*place)).count()
    }

    /// Whether the last answer to a task was right, where the person is to be told so now.
    pub(crate) fn feedback(&self) -> Option<bool> {
        self.feedback
            .filter(|_| !matches!(self.phase, Phase::Trial { .. } | Phase::Question { .. }))
    }

    /// The length of the pause that goes on, s.
    pub(crate) fn whole_pause_s(&self) -> f64 {
        if self.has_begun() { GAP_S } else { self.pause_s }
    }

    /// Whether a presentation is under way, between two of its intervals.
    pub(super) fn is_between(&self) -> bool {
        self.has_begun() && !matches!(self.phase, Phase::Trial { .. } | Phase::Question { .. })
    }

    /// Whether the first interval of the presentation at hand is done, and the last is not.
    pub(super) fn has_begun(&self) -> bool {
        let before = self.here().filter(|place| self.tasks.is_later_interval(*place));
        before.is_some_and(|place| self.places[place - 1].done && !self.places[place].done)
    }

    /// Places that are done, with a trial that was not excluded.
    pub(crate) fn done(&self) -> usize {
        self.places.iter().filter(|p| p.is_settled()).count()
    }

    /// The number of the trial at hand or to come at a place, and the one that it repeats.
    pub(crate) fn number_at(&self, place: usize) -> (u32, Option<u32>) {
        let Place { trial, repeats, .. } = &self.places[place];
        let is_asked = matches!(self.phase, Phase::Question { place: open, .. } if open == place);
        // An excluded trial that is offered again keeps its place until the new one begins.
        match self.places[place].done && !is_asked && self.here() == Some(place) {
            true => (self.next_number, Some(trial.trial)),
            false => (trial.trial, *repeats),
        }
    }

    /// Whether the pause goes on until somebody ends it.
    pub(crate) fn is_held(&self) -> bool {
        self.held
    }

    /// What is left of the pause, s.
    pub(crate) fn rest_s(&self) -> f64 {
        self.rest_s
    }

    /// The trial that remarks and exclusions speak of: the one in progress, else the last one.
    pub(crate) fn subject(&self) -> Option<u32> {
        let at_hand = match self.phase {
            Phase::Trial { .. } => self.here(),
            Phase::Question { place, .. } => Some(place),
            _ => None,
        };
        at_hand
            .map(|i| self.places[i].trial.trial)
            .or_else(|| self.places.get(self.last?).map(Place::ended))
    }
}
