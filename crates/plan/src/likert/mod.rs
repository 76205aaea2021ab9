//! Stage `likert`: tallies by question, and by group of questions; the answers themselves; the
//! blinding index if a question asked for the mode.

pub(crate) mod figures;

use crate::shared::handle::{Derived, write_named};
use crate::shared::trials::origins;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use zwidth_likert::{AnsweredTrial, Blinding, Guess, Scheme, Scoring};
use zwidth_results::{AnswerTally, BlindingIndex, GivenAnswer, Reliability, TrialScore};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Answer, LeftOutAnswer, StudyData};
use zwidth_study::{AnswerValue, Kind, ModeId, ParticipantId, SessionId, Status, Study, TrialMeta};
use zwidth_tables::{NoteKind, Table, TableError};

const STAGE: Stage = Stage { name: "likert", version: zwidth_likert::VERSION };

/// Everything that a tally depends on. The answers are joined from several files, and are not a file
/// themselves.
#[derive(Serialize)]
struct TallyParameters {
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

/// The blinding index, if a participant guessed a mode.
pub(crate) fn blinding(data: &StudyData) -> Option<Derived<BlindingIndex>> {
    guesses(data).map(|_| Derived::within(&data.layout.derived()))
}

/// The tables of the stage that people read.
pub(crate) fn printed(data: &StudyData) -> Vec<PathBuf> {
    let scores = scores(data);
    [tally(data).files(), blinding(data).files(), long(data).files(), scores.files()].concat()
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

/// The guesses of modes after trials that count, if there is one. The session's own copy of the study
/// tells which modes were offered, and under which numbers.
fn guesses(data: &StudyData) -> Option<Blinding> {
    // There is one at most: a study.toml with two is refused.
    let question = data.study.questions.iter().find(|question| question.asks_mode())?;
    let studies: BTreeMap<(&ParticipantId, &SessionId), &Study> = data
        .sessions
        .iter()
        .filter_map(|log| {
            Some(((&log.record.participant, &log.record.session), log.study.as_deref()?))
        })
        .collect();
    // Whether the trial's study asks the question for the mode after trials of its environment.
    let is_guessed = |meta: &TrialMeta| {
        let study = studies.get(&(&meta.participant, &meta.session)).copied();
        let study = study.unwrap_or(&data.study);
        study.environment(&meta.environment).is_some_and(|e| {
            let mut asked = e.questions().filter(|id| **id == question.id);
            asked.any(|id| study.question(id).is_some_and(|own| own.asks_mode()))
        })
    };
    // By participant, session and trial. Trials first, so that an answer replaces their `None`.
    let mut answers: BTreeMap<(ParticipantId, SessionId, u32), (ModeId, Option<AnswerValue>)> =
        BTreeMap::new();
    for entry in data.counting().filter(|entry| is_guessed(&entry.meta)) {
        let TrialMeta { participant, session, trial, mode, .. } = entry.meta.clone();
        answers.insert((participant, session, trial), (mode, None));
    }
    for answer in data.answers.iter().filter(|answer| answer.question == question.id) {
        let Answer { participant, session, trial, condition, value, .. } = answer.clone();
        answers.insert((participant, session, trial), (condition.mode, Some(value)));
    }
    let guesses = answers.into_iter().filter_map(|((participant, session, _), (mode, answer))| {
        let study = studies.get(&(&participant, &session)).copied().unwrap_or(&data.study);
        // A mode that the session's own study lacks was not among its answers.
        let place = study.modes.iter().position(|m| m.id == mode)?;
        let number = u8::try_from(place + 1).ok()?;
        let choices = u8::try_from(study.modes.len()).ok()?;
        Some(Guess { participant, mode, number, choices, answer })
    });
    let guesses: Vec<Guess> = guesses.collect();
    let is_answered = guesses.iter().any(|guess| guess.answer.is_some());
    let sealed = data.trials.iter().filter(|entry| {
        let is_left_out = entry.superseded_by.is_some() || entry.excluded.is_some();
        let TrialMeta { kind, status, .. } = entry.meta;
        let is_whole = (kind, status) == (Kind::Trial, Status::Complete);
        entry.sealed.is_some() && is_whole && !is_left_out && is_guessed(&entry.meta)
    });
    let sealed = sealed.count();
    let modes = data.study.modes.iter().map(|mode| mode.id.clone()).collect();
    let level = data.study.analysis.confidence;
    is_answered.then_some(Blinding { modes, guesses, sealed, level })
}

/// The scores of a study and how far their answers hang together, if one of their questions was answered.
pub(crate) fn scores(data: &StudyData) -> Option<(Derived<TrialScore>, Derived<Reliability>)> {
    let taken = Scoring::of(&data.study).taken();
    let folder = data.layout.derived();
    let is_any = data.answers.iter().any(|answer| taken.contains(&answer.question));
    is_any.then(|| (Derived::within(&folder), Derived::within(&folder)))
}

/// The trials after which something was answered.
fn answered(data: &StudyData) -> Vec<AnsweredTrial> {
    let planned = data.sessions.iter().flat_map(|log| {
        let record = &log.record;
        record.trials.iter().map(move |trial| AnsweredTrial {
            participant: record.participant.clone(),
            session: record.session.clone(),
            trial: trial.trial,
            repeat: trial.repeat,
            source: record.source,
        })
    });
    // Trials done again have files, and no place in the plan.
    let recorded = data.counting().map(|entry| AnsweredTrial {
        participant: entry.meta.participant.clone(),
        session: entry.meta.session.clone(),
        trial: entry.meta.trial,
        repeat: entry.meta.repeat,
        source: entry.meta.source,
    });
    let key = |own: &AnsweredTrial| (own.participant.clone(), own.session.clone(), own.trial);
    let all: BTreeMap<_, AnsweredTrial> =
        planned.chain(recorded).map(|own| (key(&own), own)).collect();
    let given: BTreeSet<_> = data
        .answers
        .iter()
        .map(|answer| (answer.participant.clone(), answer.session.clone(), answer.trial))
        .collect();
    all.into_iter().filter(|(key, _)| given.contains(key)).map(|(_, own)| own).collect()
}

/// What scores depend on.
#[derive(Serialize)]
struct ScoreParameters {
    scoring: Scoring,
    answers: Vec<Answer>,
    /// Pairs after trials that do not count.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    left_out: Vec<Answer>,
    trials: Vec<AnsweredTrial>,
    simulated: bool,
}

fn make_scores(parameters: &ScoreParameters, (): &(), making: &Making) -> Result<Made, JobError> {
    let ScoreParameters { scoring, answers, left_out, trials, simulated } = parameters;
    let scores = Table::of_rows(&zwidth_likert::scores(answers, left_out, trials, scoring))?;
    let mut reliability = Table::of_rows(&zwidth_likert::reliability(answers, scoring))?.with_note(
        "Cronbach's α of participants' mean answers in a condition and session; its interval after Feldt, Woodruff and Salih \
         1987. Conditions are never taken for people.",
    );
    if scoring.scores.iter().all(|score| score.questions.len() < 2) {
        let why = "Every score is of one question: how far answers hang together is for scores of several.";
        reliability = reliability.with_note_of(NoteKind::LeftOut, why);
    }
    write_named(vec![scores, reliability], making, *simulated)
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some(long) = long(data) else { return Vec::new() };
    let mut jobs = Vec::new();
    if let Some(results) = scores(data) {
        let scoring = Scoring::of(&data.study);
        let taken = scoring.taken();
        let answers = data.answers.iter().filter(|answer| taken.contains(&answer.question));
        let left_out = data.answers_left_out.iter().map(|other| &other.answer);
        let parameters = ScoreParameters {
            answers: answers.cloned().collect(),
            left_out: left_out.filter(|answer| scoring.weighs_session(answer)).cloned().collect(),
            trials: answered(data),
            simulated: data.sessions.iter().any(|log| log.record.source.is_simulated()),
            scoring,
        };
        let outputs = results.files();
        let job = Job::new(STAGE, "likert scores", parameters, (), outputs, make_scores);
        jobs.push(job.told_by(origins(data)));
    }
    let parameters = TallyParameters {
        scheme: Scheme::of(&data.study),
        answers: data.answers.clone(),
        left_out: data.answers_left_out.clone(),
        blinding: guesses(data),
    };
    let outputs = [tally(data).files(), long.files(), blinding(data).files()].concat();
    // Where answers stand. No inputs: the job is made again when an answer changes, and not when anything
    // else in these files does.
    jobs.push(
        Job::new(STAGE, "likert tallies", parameters, (), outputs, make).told_by(origins(data)),
    );
    jobs
}

fn make(parameters: &TallyParameters, (): &(), making: &Making) -> Result<Made, JobError> {
    let TallyParameters { scheme, answers, left_out, blinding } = parameters;
    let mut tables = Vec::new();
    if answers.iter().any(|answer| scheme.rates(answer)) {
        let rows = zwidth_likert::tally(answers, scheme)?;
        tables.push(zwidth_likert::tally_table(&rows, scheme)?);
    }
    let rows = zwidth_likert::long(answers, left_out);
    tables.push(zwidth_likert::long_table(&rows, scheme)?);
    if let Some(blinding) = blinding {
        let rows = zwidth_likert::blinding(blinding)?;
        tables.push(zwidth_likert::blinding_table(&rows, blinding)?);
    }
    // Answers of simulated sessions are marked where they are printed.
    write_named(tables, making, false)
}
