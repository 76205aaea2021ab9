//! The sessions of a study, and the conditions of each, with their trials that count.

use std::collections::BTreeMap;
use zwidth_store::{StudyData, TrialEntry};
use zwidth_study::{Calibration, Environment, Mode, ParticipantId, SessionId, TrialMeta};

/// One session's trials that count.
pub(crate) struct Session<'a> {
    participant: &'a ParticipantId,
    session: &'a SessionId,
    trials: Vec<&'a TrialEntry>,
}

/// The trials of one condition in one session.
#[derive(Clone)]
pub(crate) struct Repeats<'a> {
    /// `P01 S01 spring hybrid`, for people.
    pub(crate) who: String,
    /// `P01.S01.spring.hybrid`.
    pub(crate) key: String,
    pub(crate) environment: &'a Environment,
    pub(crate) mode: &'a Mode,
    pub(crate) trials: Vec<&'a TrialEntry>,
}

impl<'a> Session<'a> {
    /// `P01 S01`, for people.
    pub(crate) fn who(&self) -> String {
        format!("{} {}", self.participant, self.session)
    }

    /// `P01`, `S01`: ids have no dots, so names made from them cannot collide.
    pub(crate) fn ids(&self) -> [String; 2] {
        [self.participant.to_string(), self.session.to_string()]
    }

    /// The trials of one environment.
    pub(crate) fn of(&self, environment: &Environment) -> Vec<&'a TrialEntry> {
        self.trials.iter().copied().filter(|t| t.meta.environment == environment.id).collect()
    }

    /// The repeats of one condition; `None` if it has none.
    pub(crate) fn repeats(
        &self,
        environment: &'a Environment,
        mode: &'a Mode,
    ) -> Option<Repeats<'a>> {
        let mut trials = self.of(environment);
        trials.retain(|t| t.meta.mode == mode.id);
        let [participant, session] = self.ids();
        let ids = [&participant, &session, environment.id.as_str(), mode.id.as_str()];
        let (who, key) = (ids.join(" "), ids.join("."));
        (!trials.is_empty()).then_some(Repeats { who, key, environment, mode, trials })
    }
}

/// The sessions with trials that count, each trial in a known condition.
pub(crate) fn sessions(data: &StudyData) -> Vec<Session<'_>> {
    let mut sessions: BTreeMap<_, Vec<&TrialEntry>> = BTreeMap::new();
    for trial in data.counting() {
        sessions.entry((&trial.meta.participant, &trial.meta.session)).or_default().push(trial);
    }
    let session = |((participant, session), trials)| Session { participant, session, trials };
    sessions.into_iter().map(session).collect()
}

/// The conditions of every session that have trials, in the study's order.
pub(crate) fn repeats(data: &StudyData) -> Vec<Repeats<'_>> {
    let mut found = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let modes = data.study.modes.iter();
            found.extend(modes.filter_map(|mode| session.repeats(environment, mode)));
        }
    }
    found
}

/// The calibration in force in a trial's session.
pub(crate) fn calibration<'a>(data: &'a StudyData, meta: &TrialMeta) -> Option<&'a Calibration> {
    let mut records = data.sessions.iter().map(|session| &session.record);
    records
        .find(|r| r.participant == meta.participant && r.session == meta.session)?
        .calibration
        .as_ref()
}
