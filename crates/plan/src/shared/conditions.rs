//! The sessions of a study, and the conditions of each, with their trials that count.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::{StudyData, TrialEntry};
use zwidth_study::{Calibration, Environment, Mode, ParticipantId, SessionId, Source, TrialMeta};

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

impl Repeats<'_> {
    /// Whether other repeats are of the same session.
    pub(crate) fn is_of_session_of(&self, other: &Self) -> bool {
        // Repeats without a trial are not made: see `Session::repeats`.
        self.trials[0].meta.is_of_session_of(&other.trials[0].meta)
    }
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

    /// The same with an environment's: `P01`, `S01`, `spring`.
    pub(crate) fn ids_with(&self, environment: &Environment) -> [String; 3] {
        let [participant, session] = self.ids();
        [participant, session, environment.id.to_string()]
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
        let who = ids.join(" ");
        let key = ids.join(".");
        (!trials.is_empty()).then_some(Repeats { who, key, environment, mode, trials })
    }
}

/// The sessions with trials that count, each trial in a known condition.
pub(crate) fn sessions(data: &StudyData) -> Vec<Session<'_>> {
    let mut sessions: BTreeMap<_, Vec<&TrialEntry>> = BTreeMap::new();
    let counting: Vec<&TrialEntry> = data.counting().collect();
    for trials in counting.chunk_by(|a, b| a.meta.is_of_session_of(&b.meta)) {
        let ids = (&trials[0].meta.participant, &trials[0].meta.session);
        // One look-up for all trials of a session that stand together: a study may have thousands.
        sessions.entry(ids).or_default().extend(trials);
    }
    sessions
        .into_iter()
        .map(|((participant, session), trials)| Session { participant, session, trials })
        .collect()
}

/// The conditions of every session that have trials, in the study's order.
pub(crate) fn repeats(data: &StudyData) -> Vec<Repeats<'_>> {
    let mut conditions = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let modes = data.study.modes.iter();
            conditions.extend(modes.filter_map(|mode| session.repeats(environment, mode)));
        }
    }
    conditions
}

/// The samples that stand for a large study where each more costs as much and a result gains little:
/// 1,000 trials of 4 s at 1 kHz. A plant has six parameters, and its error shrinks with the root of
/// the number of trials.
const MOST_SAMPLES: usize = 4_000_000;

/// The participants whose trials stand for all, given each trial's participant and samples: everybody,
/// or in a large study as many, evenly spread over the list, as keep within `MOST_SAMPLES`; at least
/// one.
pub(crate) fn spread<'p>(trials: &[(&'p ParticipantId, usize)]) -> BTreeSet<&'p ParticipantId> {
    spread_within(trials, MOST_SAMPLES)
}

pub(crate) fn spread_within<'p>(
    trials: &[(&'p ParticipantId, usize)],
    most: usize,
) -> BTreeSet<&'p ParticipantId> {
    let all: usize = trials.iter().map(|(_, rows)| rows).sum();
    let people: BTreeSet<_> = trials.iter().map(|(who, _)| *who).collect();
    if all <= most {
        return people;
    }
    let people: Vec<_> = people.into_iter().collect();
    // As if everybody had as many samples.
    let kept = (people.len() * most / all).max(1);
    (0..kept).map(|k| people[k * people.len() / kept]).collect()
}

/// Whether any trial that counts has a condition of the study.
pub(crate) fn is_any(data: &StudyData) -> bool {
    data.counting().any(|TrialEntry { meta, .. }| {
        data.study.environment(&meta.environment).is_some() && data.study.mode(&meta.mode).is_some()
    })
}

/// Where the trials that count come from, each source once.
pub(crate) fn trial_sources(data: &StudyData) -> Vec<Source> {
    let of_trials = data.counting().map(|trial| trial.meta.source);
    // A questionnaire has trials without samples.
    let asked = data.sessions.iter().filter(|log| log.record.trials.iter().any(|t| !t.samples));
    let sources: BTreeSet<Source> = of_trials.chain(asked.map(|log| log.record.source)).collect();
    sources.into_iter().collect()
}

/// The calibration in force in a trial's session.
pub(crate) fn calibration<'a>(data: &'a StudyData, meta: &TrialMeta) -> Option<&'a Calibration> {
    data.session(&meta.participant, &meta.session)?.record.calibration.as_ref()
}
