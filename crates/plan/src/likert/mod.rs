//! Stage `likert`: tallies by question, and by group of questions; the answers themselves; the
//! blinding index if a question asked for the mode.

pub(crate) mod figures;

use crate::shared::handle::{Derived, Written};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_likert::{Blinding, Guess, Scheme};
use zwidth_results::{AnswerTally, BlindingIndex, GivenAnswer};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Answer, LeftOutAnswer, StudyData, TrialEntry};
use zwidth_study::{
    AnswerValue, EnvironmentId, Kind, ModeId, ParticipantId, Question, SessionId, Status, Study,
    TrialMeta,
};
use zwidth_tables::TableError;

const STAGE: Stage = Stage { name: "likert", version: zwidth_likert::VERSION };

/// Everything that a tally depends on: the answers are joined from several files, and are
/// not a file themselves.
#[derive(Serialize)]
struct Asked {
    scheme: Scheme,
    answers: Vec<Answer>,
    left_out: Vec<LeftOutAnswer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    blinding: Option<Blinding>,
}

/// The answers that rate what was felt.
pub(crate) fn ratings(data: &StudyData) -> impl Iterator<Item = &Answer> {
    let scheme = Scheme::of(&data.study);
    data.answers.iter().filter(move |answer| scheme.rates(answer))
}

/// The tallies of the study, if there is such an answer.
pub(crate) fn tally(data: &StudyData) -> Option<Derived<AnswerTally>> {
    ratings(data).next().map(|_| Derived::within(&data.layout.derived()))
}

/// The blinding index, if it was answered which mode it was.
pub(crate) fn blinding(data: &StudyData) -> Option<Derived<BlindingIndex>> {
    guessed(data).map(|_| Derived::within(&data.layout.derived()))
}

/// The tables of the stage that people read.
pub(crate) fn printed(data: &StudyData) -> Vec<PathBuf> {
    [tally(data).files(), blinding(data).files(), long(data).files()].concat()
}

/// Every answer of the study, one row each, if there is one.
fn long(data: &StudyData) -> Option<Derived<GivenAnswer>> {
    let is_any = !data.answers.is_empty() || !data.answers_left_out.is_empty();
    is_any.then(|| Derived::within(&data.layout.derived()))
}

/// The table of [`long`], if an answer in it counts: for [`read_counting`].
pub(crate) fn answers(data: &StudyData) -> Option<Derived<GivenAnswer>> {
    long(data).filter(|_| !data.answers.is_empty())
}

/// The answers that count, of the table with all of them.
pub(crate) fn read_counting(
    answers: &Derived<GivenAnswer>,
) -> Result<Vec<GivenAnswer>, TableError> {
    let mut all = answers.read()?;
    all.retain(|answer| answer.counts);
    Ok(all)
}

/// Files an answer can stand in: trials, session records, event logs.
fn origins(data: &StudyData) -> Vec<Arc<Path>> {
    let trials = data.trials.iter().map(|t| t.path.clone());
    let logs =
        data.sessions.iter().flat_map(|s| [&s.path, &s.events_path]).map(|p| p.as_path().into());
    trials.chain(logs).collect()
}

/// The trials that count after which it was asked which mode it was, if one was answered. What was
/// offered, and under which numbers, is told by the session's own copy of the study.
fn guessed(data: &StudyData) -> Option<Blinding> {
    let question = data.study.questions.iter().find(|question| !question.is_rating())?;
    let mut asked: BTreeMap<Key, (ModeId, Option<AnswerValue>)> = BTreeMap::new();
    let studies = studies(data);
    let is_asked = |meta: &TrialMeta| {
        let of = study_of(data, &studies, (&meta.participant, &meta.session));
        asks(of, &meta.environment, question)
    };
    for entry in data.counting().filter(|entry| is_asked(&entry.meta)) {
        let TrialMeta { participant, session, trial, mode, .. } = entry.meta.clone();
        asked.insert((participant, session, trial), (mode, None));
    }
    for answer in data.answers.iter().filter(|answer| answer.question == question.id) {
        let Answer { participant, session, trial, condition, value, .. } = answer.clone();
        asked.insert((participant, session, trial), (condition.mode, Some(value)));
    }
    let is_sealed = |entry: &&TrialEntry| {
        let is_left_out = entry.superseded_by.is_some() || entry.excluded.is_some();
        let TrialMeta { kind, status, .. } = entry.meta;
        let is_whole = (kind, status) == (Kind::Trial, Status::Complete);
        entry.sealed.is_some() && is_whole && !is_left_out && is_asked(&entry.meta)
    };
    let guess =
        |((participant, session, _), (mode, answer)): (Key, (ModeId, Option<AnswerValue>))| {
            let of = study_of(data, &studies, (&participant, &session));
            // A mode that the session's own study lacks was not among its answers.
            let place = of.modes.iter().position(|m| m.id == mode)?;
            let number = u8::try_from(place + 1).ok()?;
            let choices = u8::try_from(of.modes.len()).ok()?;
            Some(Guess { participant, mode, number, choices, answer })
        };
    let sealed = data.trials.iter().filter(is_sealed).count();
    let guesses: Vec<Guess> = asked.into_iter().filter_map(guess).collect();
    let is_answered = guesses.iter().any(|guess| guess.answer.is_some());
    let modes = data.study.modes.iter().map(|mode| mode.id.clone()).collect();
    let level = data.study.analysis.confidence;
    is_answered.then_some(Blinding { modes, guesses, sealed, level })
}

/// Participant, session, trial.
type Key = (ParticipantId, SessionId, u32);

type Studies<'d> = BTreeMap<(&'d ParticipantId, &'d SessionId), &'d Study>;

/// The copies of the study that sessions have.
fn studies(data: &StudyData) -> Studies<'_> {
    let own = data.sessions.iter().filter_map(|log| {
        Some(((&log.record.participant, &log.record.session), log.study.as_deref()?))
    });
    own.collect()
}

/// The study as it was for a session.
fn study_of<'d>(
    data: &'d StudyData,
    studies: &Studies<'d>,
    of: (&ParticipantId, &SessionId),
) -> &'d Study {
    studies.get(&of).copied().unwrap_or(&data.study)
}

/// Whether a question for the mode is asked after an environment's trials.
fn asks(study: &Study, environment: &EnvironmentId, question: &Question) -> bool {
    study.environment(environment).is_some_and(|e| {
        e.questions().any(|id| {
            *id == question.id && study.question(id).is_some_and(|known| !known.is_rating())
        })
    })
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let job = |long: Derived<GivenAnswer>| {
        let scheme = Scheme::of(&data.study);
        let answers = data.answers.clone();
        let left_out = data.answers_left_out.clone();
        let asked = Asked { scheme, answers, left_out, blinding: guessed(data) };
        let outputs = [tally(data).files(), long.files(), blinding(data).files()].concat();
        let job = Job::new(STAGE, "likert tallies", asked, (), outputs, make);
        job.told_by(origins(data))
    };
    long(data).map(job).into_iter().collect()
}

fn make(asked: &Asked, (): &(), making: &Making) -> Result<Made, JobError> {
    let Asked { scheme, answers, left_out, blinding } = asked;
    // Answers of simulated sessions are marked where they are printed.
    let mut written = Written::begin(making, false);
    if answers.iter().any(|answer| scheme.rates(answer)) {
        let rows = zwidth_likert::tally(answers, scheme)?;
        written = written.table(zwidth_likert::tally_table(&rows, scheme)?)?;
    }
    let rows = zwidth_likert::long(answers, left_out);
    written = written.table(zwidth_likert::long_table(&rows, scheme)?)?;
    if let Some(blinding) = blinding {
        let rows = zwidth_likert::blinding(blinding)?;
        written = written.table(zwidth_likert::blinding_table(&rows, blinding)?)?;
    }
    written.end()
}
