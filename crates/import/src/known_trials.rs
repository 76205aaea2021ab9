//! The trials that a study has, and the one of them that a row of a table names.

use super::named_trial::{Claims, NamedTrial, TrialMeant};
use std::collections::BTreeMap;
use zwidth_results::TrialKey;
use zwidth_store::{SessionLog, StudyData, TrialEntry};
use zwidth_study::{EnvironmentId, Kind, ModeId, ParticipantId, SessionId, SessionRecord, Study};

/// A trial that a session has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KnownTrial {
    /// What was rendered.
    pub environment: EnvironmentId,
    /// How; a code while the session is sealed.
    pub mode: ModeId,
    /// The repeat of the condition.
    pub repeat: u32,
    /// Whether it is one of the experiment.
    pub kind: Kind,
    /// Whether it has a recording that can be read.
    pub is_recorded: bool,
    /// Whether another trial took its place.
    is_superseded: bool,
}

/// The trials of a session, by number.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SessionTrials {
    is_sealed: bool,
    counted_from_zero: bool,
    trials: BTreeMap<u32, KnownTrial>,
    /// Trials of the experiment by their condition and repeat.
    repeats: BTreeMap<(EnvironmentId, ModeId, u32), Vec<u32>>,
}

impl SessionTrials {
    /// Those of a log, of whose trials these are the files.
    pub fn of(log: &SessionLog, entries: &[&TrialEntry]) -> Self {
        let entries: BTreeMap<u32, &TrialEntry> =
            entries.iter().map(|entry| (entry.meta.trial, *entry)).collect();
        let mut session = Self {
            is_sealed: log.is_sealed(),
            counted_from_zero: log.record.counted_from_zero,
            ..Self::default()
        };
        for planned in &log.trials {
            let entry = entries.get(&planned.trial);
            let trial = KnownTrial {
                environment: planned.environment.clone(),
                mode: planned.mode.clone(),
                repeat: planned.repeat,
                kind: planned.kind,
                is_recorded: entry.is_some(),
                is_superseded: entry.is_some_and(|entry| entry.superseded_by.is_some()),
            };
            session.add(planned.trial, trial);
        }
        session
    }

    fn add(&mut self, number: u32, trial: KnownTrial) {
        if trial.kind == Kind::Trial {
            let condition = (trial.environment.clone(), trial.mode.clone(), trial.repeat);
            self.repeats.entry(condition).or_default().push(number);
        }
        self.trials.insert(number, trial);
    }

    /// All of them, by number.
    pub fn all(&self) -> impl Iterator<Item = (u32, &KnownTrial)> {
        self.trials.iter().map(|(number, trial)| (*number, trial))
    }

    /// Whether the session's modes are sealed.
    pub fn is_sealed(&self) -> bool {
        self.is_sealed
    }

    /// The trial of that number.
    ///
    /// # Errors
    /// The session has none; in words.
    pub fn trial(&self, number: u32) -> Result<&KnownTrial, String> {
        self.trials.get(&number).ok_or_else(|| {
            format!(
                "the session has no trial {number}: they are {} to {}",
                self.trials.keys().next().unwrap_or(&0),
                self.trials.keys().next_back().unwrap_or(&0)
            )
        })
    }

    /// The number of the trial that a row names: of a condition's repeat, the one that no other took the place of.
    ///
    /// # Errors
    /// There is none, or it is not known which; in words.
    pub fn number(&self, named: &NamedTrial) -> Result<u32, String> {
        let (environment, mode, repeat) = match &named.trial {
            TrialMeant::Number(_) if self.counted_from_zero && named.is_number_alone() => {
                return Err(
                    "the recordings of this session count trials from 0, and the study from 1: say which trial is \
                     meant in columns environment, mode and repeat, beside its number or in its place"
                        .to_owned(),
                );
            }
            TrialMeant::Number(trial) => return self.trial(*trial).map(|_| *trial),
            TrialMeant::Repeat { environment, mode, repeat } => (environment, mode, *repeat),
        };
        if self.is_sealed {
            return Err(
                "the session's modes are sealed: name its trials by number, in a column 'trial'"
                    .to_owned(),
            );
        }
        let own = self.repeats.get(&(environment.clone(), mode.clone(), repeat));
        let own = own.into_iter().flatten().copied();
        let is_last = |trial: &u32| self.trials.get(trial).is_some_and(|own| !own.is_superseded);
        match own.filter(is_last).collect::<Vec<_>>()[..] {
            [only] => Ok(only),
            [] => {
                Err(format!("the session has no trial of {environment}, {mode}, repeat {repeat}"))
            }
            _ => Err(format!(
                "the session has several trials of {environment}, {mode}, repeat {repeat}: name the one by number, in a \
                 column 'trial'"
            )),
        }
    }

    /// Whether what a row says of a trial besides its number is so. Of a sealed session mode and repeat
    /// are not known, and whether a row is right about them must not come out: then `false`, whatever
    /// it says.
    ///
    /// # Errors
    /// What it says is not so; in words.
    pub fn check_claims(
        &self,
        labels: &Labels,
        number: u32,
        claims: &Claims,
    ) -> Result<bool, String> {
        let Claims { environment, mode, repeat } = claims;
        let trial = self.trial(number)?;
        let mut wrong = Vec::new();
        if let Some(claim) = environment {
            let label = labels.environments.get(&trial.environment);
            if !is_called(claim, trial.environment.as_str(), label) {
                wrong.push(format!("environment {claim}"));
            }
        }
        if let Some(claim) = mode.as_ref().filter(|_| !self.is_sealed)
            && !is_called(claim, trial.mode.as_str(), labels.modes.get(&trial.mode))
        {
            wrong.push(format!("mode {claim}"));
        }
        if let Some(claim) = repeat.filter(|claim| !self.is_sealed && *claim != trial.repeat) {
            wrong.push(format!("repeat {claim}"));
        }
        if wrong.is_empty() {
            return Ok(!self.is_sealed || (mode.is_none() && repeat.is_none()));
        }
        let KnownTrial { environment, mode, repeat, .. } = trial;
        let actual = match self.is_sealed {
            true => format!("is of {environment}"),
            false => format!("is of {environment}, {mode}, repeat {repeat}"),
        };
        Err(format!("the table says {}, but trial {number} {actual}", wrong.join(", ")))
    }
}

/// Whether a table's word is an id, or its label for people, in any case.
fn is_called(word: &str, id: &str, label: Option<&String>) -> bool {
    word.eq_ignore_ascii_case(id) || label.is_some_and(|label| word.eq_ignore_ascii_case(label))
}

/// What people call environments and modes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Labels {
    environments: BTreeMap<EnvironmentId, String>,
    modes: BTreeMap<ModeId, String>,
}

impl Labels {
    /// Those of a study.
    pub fn of(study: &Study) -> Self {
        let environments = study.environments.iter().map(|own| (own.id.clone(), own.label.clone()));
        let modes = study.modes.iter().map(|own| (own.id.clone(), own.label.clone()));
        Self { environments: environments.collect(), modes: modes.collect() }
    }
}

/// Every trial of a study.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct StudyTrials {
    labels: Labels,
    sessions: BTreeMap<(ParticipantId, SessionId), SessionTrials>,
}

impl StudyTrials {
    /// Those of a study as it is on the disk.
    pub fn of(data: &StudyData) -> Self {
        let entries = data.by_session();
        let sessions = data.sessions.iter().map(|log| {
            let SessionRecord { participant, session, .. } = &log.record;
            let own = entries.get(&(participant, session)).map_or(&[][..], Vec::as_slice);
            ((participant.clone(), session.clone()), SessionTrials::of(log, own))
        });
        Self { labels: Labels::of(&data.study), sessions: sessions.collect() }
    }

    /// Trials that are known by their keys alone: those that a program was given. Each has a recording.
    pub fn of_keys<'k>(keys: impl IntoIterator<Item = &'k TrialKey>) -> Self {
        let mut trials = Self::default();
        for key in keys {
            let session = (key.participant.clone(), key.session.clone());
            let trial = KnownTrial {
                environment: key.environment.clone(),
                mode: key.mode.clone(),
                repeat: key.repeat,
                kind: Kind::Trial,
                is_recorded: true,
                is_superseded: false,
            };
            trials.sessions.entry(session).or_default().add(key.trial, trial);
        }
        trials
    }

    /// The recorded trial that a row names, in the session that it names or else in `session`.
    ///
    /// # Errors
    /// There is none, or the row says something else of it than is so, or what nobody may know yet; in words.
    pub(super) fn find(
        &self,
        named: &NamedTrial,
        session: Option<&SessionId>,
    ) -> Result<(SessionId, u32), String> {
        let id = named.session.as_ref().or(session);
        let id = id.ok_or("the table has no column 'session': add it, or name one with -s")?;
        let own = self.sessions.get(&(named.participant.clone(), id.clone()));
        let own = own.ok_or_else(|| {
            format!("there is no session {id} of {} that can be read", named.participant)
        })?;
        let number = own.number(named)?;
        if !own.check_claims(&self.labels, number, &named.claims)? {
            return Err(
                "the session's modes are sealed: name its trials by number alone, without columns mode and repeat"
                    .to_owned(),
            );
        }
        match own.trial(number)?.is_recorded {
            true => Ok((id.clone(), number)),
            false => Err(format!("trial {number} has no recording that can be read")),
        }
    }
}
