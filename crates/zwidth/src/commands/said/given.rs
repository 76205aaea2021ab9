//! Remarks on a trial of a session, and answers to its questions.

use anyhow::{Context as _, bail};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_import::{KnownTrial, SessionTrials};
use zwidth_store::{SessionLog, StudyData, TrialEntry};
use zwidth_study::{AnswerValue, Event, Kind, QuestionId, Score, SessionRecord};

/// An answer that may be added.
pub(super) struct NewAnswer {
    pub(super) event: Event,
    pub(super) question: QuestionId,
    /// The answer that counted so far.
    pub(super) before: Option<AnswerValue>,
    /// Why the trial itself does not count.
    pub(super) but: Option<String>,
}

/// A session, looked up by the numbers of its trials.
pub(super) struct NumberedSession<'a> {
    pub(super) log: &'a SessionLog,
    pub(super) trials: SessionTrials,
    /// Files that can be read.
    entries: BTreeMap<u32, &'a TrialEntry>,
    recorded: BTreeSet<u32>,
    /// The answers that count so far, by the log.
    answers: BTreeMap<(u32, &'a QuestionId), AnswerValue>,
}

impl<'a> NumberedSession<'a> {
    /// The session of this log, of whose trials these are the files.
    pub(super) fn new(log: &'a SessionLog, entries: &[&'a TrialEntry]) -> Self {
        let mut session = Self {
            log,
            trials: SessionTrials::of(log, entries),
            entries: entries.iter().map(|entry| (entry.meta.trial, *entry)).collect(),
            recorded: BTreeSet::new(),
            answers: BTreeMap::new(),
        };
        for event in &log.events {
            match event {
                Event::Recorded { trial, .. } => _ = session.recorded.insert(*trial),
                Event::Answer { trial, question, value, .. } => {
                    session.answers.insert((*trial, question), *value);
                }
                _ => {}
            }
        }
        session
    }

    /// A session of a study.
    pub(super) fn of(data: &'a StudyData, log: &'a SessionLog) -> Self {
        let SessionRecord { participant, session, .. } = &log.record;
        let trials = data.trials.iter();
        let own =
            trials.filter(|t| (&t.meta.participant, &t.meta.session) == (participant, session));
        Self::new(log, &own.collect::<Vec<_>>())
    }

    /// A trial that the session has.
    pub(super) fn planned(&self, trial: u32) -> anyhow::Result<&KnownTrial> {
        self.trials.trial(trial).map_err(anyhow::Error::msg)
    }

    /// A trial that was recorded, or answered without samples; its file, if it can be read.
    pub(super) fn recorded(&self, trial: u32) -> anyhow::Result<Option<&'a TrialEntry>> {
        self.planned(trial)?;
        let entry = self.entries.get(&trial).copied();
        // Without an order nothing was planned ahead: every trial of the log has ended.
        let ended = self.log.record.order.is_none() || self.recorded.contains(&trial);
        if entry.is_none() && !ended {
            bail!("trial {trial} is still to be done");
        }
        Ok(entry)
    }

    /// The answer to a question after a trial: the named one, else the only one that belongs there.
    pub(super) fn answer(
        &self,
        data: &StudyData,
        trial: u32,
        named: Option<&QuestionId>,
        value: AnswerValue,
    ) -> anyhow::Result<NewAnswer> {
        let entry = self.recorded(trial)?;
        let id = self.question(data, trial, named)?;
        let question =
            data.study.question(&id).with_context(|| format!("{id} is not in study.toml"))?;
        if !question.scale.has(value) {
            bail!("{value} is no answer to {id}: it must be {}", question.scale.must_be());
        }
        let logged = self.answers.get(&(trial, &id)).copied();
        Ok(NewAnswer {
            before: logged.or_else(|| entry?.meta.likert.map(AnswerValue::from)),
            but: entry.filter(|entry| entry.sealed.is_none()).and_then(TrialEntry::why_not),
            event: Event::Answer { trial, question: id.clone(), value, time_ms: None },
            question: id,
        })
    }

    /// Whether answers to the pairs of a score belong to a trial. A session in an order asks them once: they belong to the
    /// trial that has them, and if there is none to the last after which the score's questions are asked. By hand, one pair
    /// after another trial would leave that trial without a score.
    fn check_weighed(&self, data: &StudyData, trial: u32, score: &Score) -> anyhow::Result<()> {
        let pairs = score.weighing();
        let has = |trial: u32| pairs.iter().any(|pair| self.answers.contains_key(&(trial, pair)));
        if self.log.record.order.is_none() || has(trial) {
            return Ok(());
        }
        let superseded = |trial: u32| {
            let is_own = |event: &Event| matches!(event, Event::Superseded { trial: own, .. } if *own == trial);
            self.log.events.iter().any(is_own)
        };
        let is_asked = |number: u32, planned: &KnownTrial| {
            let environment = data.study.environment(&planned.environment);
            planned.kind == Kind::Trial
                && !superseded(number)
                && environment.is_some_and(|e| data.study.weighed_in(e).any(|own| own == score))
        };
        let asked = self.trials.all().filter(|(number, planned)| is_asked(*number, planned));
        let asked: Vec<u32> = asked.map(|(number, _)| number).collect();
        let of_pairs = asked.iter().rfind(|trial| has(**trial)).or(asked.last());
        match of_pairs {
            Some(own) if *own != trial => bail!(
                "the pairs of score {} are asked once in the session, and belong to trial {own}: name that one",
                score.id
            ),
            _ => Ok(()),
        }
    }

    /// The question that is answered: one of those after the trial.
    fn question(
        &self,
        data: &StudyData,
        trial: u32,
        named: Option<&QuestionId>,
    ) -> anyhow::Result<QuestionId> {
        let environment = data.study.environment(&self.planned(trial)?.environment);
        let mut questions: Vec<&QuestionId> =
            environment.iter().flat_map(|e| e.questions()).collect();
        let weighed = |pair: &QuestionId| {
            let mut scores = environment.iter().flat_map(|e| data.study.weighed_in(e));
            scores.find(|score| score.weighing().contains(pair))
        };
        if let Some(pair) = named
            && let Some(score) = weighed(pair)
        {
            self.check_weighed(data, trial, score)?;
            questions.push(pair);
        }
        match (named, questions.as_slice()) {
            (Some(id), questions) if questions.contains(&id) => return Ok(id.clone()),
            (None, [only]) => return Ok((*only).clone()),
            (_, []) => bail!(
                "nothing is asked after trial {trial}: name a question of [[questions]] in its environment of study.toml, question = \"…\""
            ),
            _ => {}
        }
        let list = questions.iter().map(|id| id.as_str()).collect::<Vec<_>>().join(", ");
        match named {
            Some(id) => bail!("{id} is not asked after trial {trial}: name one of {list}"),
            None => bail!("say which question is answered, with --question: {list}"),
        }
    }
}
