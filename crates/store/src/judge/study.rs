//! A whole study: all trials, sweeps and sessions, joined with the events.

use crate::disk::regular::text;
use crate::disk::walk::{below, parquet_below, strange};
use crate::form::entries::read_trials;
use crate::form::entry::{MOST_STUDY, SessionLog, SweepEntry, TrialEntry};
use crate::form::footer::from_path;
use crate::form::sweep::entry;
use crate::judge::alike::check_study_id;
use crate::judge::beside::{BesideEntry, beside_findings, beside_of};
use crate::judge::fit::unfit;
use crate::judge::laid::study_warning;
use crate::judge::logged_sweeps::logged_sweeps;
use crate::judge::one_form::other_forms;
use crate::judge::outside::{OutsideEntry, OutsideTables, outside_tables};
use crate::judge::people::{group_warning, read_people};
use crate::judge::sessions::{join, keep, read_sessions, unmet, why_sealed};
use crate::{Entry, Files, Layout, RealFiles, Seen, StoreError, hex_blake3};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_study::{
    AnswerValue, Condition, Event, Kind, ParticipantId, People, QuestionId, SessionId,
    SessionRecord, Study,
};

/// One answer that counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// The person who answered.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The trial before the answer.
    pub trial: u32,
    /// The trial's condition.
    pub condition: Condition,
    /// The question.
    pub question: QuestionId,
    /// The answer as given, a number of the question's scale.
    pub value: AnswerValue,
    /// From the question to its answer, ms, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_ms: Option<u32>,
}

/// One answer that was given and does not count.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOutAnswer {
    /// The answer. While a session is sealed, its condition has a code for a mode.
    pub answer: Answer,
    /// Why it does not count, in words: as its trial ([`TrialEntry::why_not`]), or another answer
    /// took its place.
    pub why_not: String,
}

/// A study as it is on the disk.
#[derive(Debug, Clone)]
pub struct StudyData {
    /// Where it is.
    pub layout: Layout,
    /// The plan.
    pub study: Study,
    /// What is known of its people.
    pub people: People,
    /// Every readable trial, by participant, session and number.
    pub trials: Vec<TrialEntry>,
    /// Every sweep, by actuator and number.
    pub sweeps: Vec<SweepEntry>,
    /// Every table of a metric that another program computed, in the order in which they were given.
    pub outside: Vec<OutsideEntry>,
    /// Every table of a stream that another program recorded beside a session.
    pub beside: Vec<BesideEntry>,
    /// Every session.
    pub sessions: Vec<SessionLog>,
    /// The files that could not be read and were left out.
    pub problems: Vec<StoreError>,
    /// Trials to be read with care that count nevertheless.
    pub warnings: Vec<StoreError>,
    /// Every answer that counts: from events, and from trial files for their environment's question
    /// (an event overrides the file). Sorted by participant, session, trial and question.
    pub answers: Vec<Answer>,
    /// Every answer that does not count, sorted likewise; those to one question in the order in which
    /// they were given.
    pub answers_left_out: Vec<LeftOutAnswer>,
}

/// What was given, in this order, as an answer to a question after a trial of a session, and why the
/// trial does not count.
type Answers =
    BTreeMap<((ParticipantId, SessionId, u32), QuestionId), Vec<(Answer, Option<String>)>>;

impl StudyData {
    /// Reads the study: its `study.toml`, all footers, sessions and events. Samples are not read.
    ///
    /// # Errors
    /// A missing or wrong `study.toml`, a wrong participants' file, one error per finding, and after
    /// them all other findings. If these are whole, unreadable files are left out and listed in `problems`.
    pub fn load(layout: &Layout) -> Result<Self, Vec<StoreError>> {
        Self::load_seen(&Seen::of(layout), layout)
    }

    /// [`StudyData::load`], if it is known what files were when they were last read.
    ///
    /// # Errors
    /// Those of [`StudyData::load`].
    pub fn load_seen(seen: &Seen, layout: &Layout) -> Result<Self, Vec<StoreError>> {
        Self::load_by(&RealFiles, Some(seen), layout)
    }

    /// [`StudyData::load`] from any file layer.
    ///
    /// # Errors
    /// Those of [`StudyData::load`].
    pub fn load_from(files: &dyn Files, layout: &Layout) -> Result<Self, Vec<StoreError>> {
        Self::load_by(files, None, layout)
    }

    fn load_by(
        files: &dyn Files,
        seen: Option<&Seen>,
        layout: &Layout,
    ) -> Result<Self, Vec<StoreError>> {
        // Before anything is read: it would be read from behind a link.
        check_folders(files, layout).map_err(|error| vec![error])?;
        let study = read_study_from(files, layout);
        let (listed, trials) = rayon::join(
            || below(files, &layout.raw()),
            || read_trials(files, seen, layout, &layout.trials()),
        );
        let mut problems = listed.map_or_else(|error| vec![error], |below| below.strange);
        let mut trials = keep(&mut problems, trials);
        let sweeps = keep(&mut problems, list_sweeps(files, layout));
        let (sweeps, unsure) = logged_sweeps(files, layout, sweeps);
        problems.extend(unsure);
        let (sessions, unreadable) = read_sessions(files, layout, &mut problems);
        problems.extend(join(files, layout, &mut trials, &sessions, &unreadable));
        // Only now: without a study.toml that can be read, the other findings are told too.
        let (mut study, study_blake3) = match study {
            Ok(read) => read,
            Err(findings) => return Err([findings, problems].concat()),
        };
        let people = match read_people(files, layout, &study) {
            Ok(people) => people.with_drawn(&study.people, sessions.iter().map(|log| &log.record)),
            Err(findings) => return Err([findings, problems].concat()),
        };
        // After `join`: the modes of sealed trials are codes, which study.toml does not have.
        problems.extend(trials.iter_mut().filter_map(|trial| unfit(&study, trial)));
        let changed =
            sessions.iter().filter_map(|log| study_warning(layout, log, &study, &study_blake3));
        let alike = check_study_id(files, layout).err();
        let forms = other_forms(layout, &study, &trials);
        let regrouped =
            sessions.iter().filter_map(|log| group_warning(layout, log, &people, &study));
        let warnings: Vec<StoreError> =
            changed.chain(regrouped).chain(alike).chain(forms).collect();
        let OutsideTables { entries: outside, problems: unsure, warnings: outdated } =
            outside_tables(files, layout, &trials);
        problems.extend(unsure);
        let counting = outside.iter().filter(|entry| entry.counts());
        study.from_tables = counting.map(|entry| entry.metric.clone()).collect();
        let warnings = [warnings, outdated].concat();
        let beside: Vec<BesideEntry> =
            sessions.iter().flat_map(|log| beside_of(layout, log)).collect();
        problems.extend(beside_findings(files, layout, &beside, unreadable.is_empty()));
        let layout = layout.clone();
        let data = Self {
            layout,
            study,
            people,
            trials,
            sweeps,
            outside,
            beside,
            sessions,
            problems,
            warnings,
            answers: Vec::new(),
            answers_left_out: Vec::new(),
        };
        let (answers, answers_left_out) = data.collect_answers();
        Ok(Self { answers, answers_left_out, ..data })
    }

    /// The trials that may enter a mean, a metric table or a tally.
    pub fn counting(&self) -> impl Iterator<Item = &TrialEntry> {
        self.trials.iter().filter(|t| t.counts())
    }

    /// One session.
    pub fn session(&self, participant: &ParticipantId, session: &SessionId) -> Option<&SessionLog> {
        let by_name = self.sessions.binary_search_by(|log| {
            let SessionRecord { participant: p, session: s, .. } = &log.record;
            name(p.as_str(), s.as_str()).cmp(name(participant.as_str(), session.as_str()))
        });
        let by_name = by_name.ok().and_then(|place| self.sessions.get(place));
        // They come in the order of their files' names, unless somebody put them otherwise.
        by_name
            .into_iter()
            .chain(&self.sessions)
            .find(|log| (&log.record.participant, &log.record.session) == (participant, session))
    }

    /// The trials of each session, whether or not they count.
    pub fn by_session(&self) -> BTreeMap<(&ParticipantId, &SessionId), Vec<&TrialEntry>> {
        let mut sessions: BTreeMap<_, Vec<&TrialEntry>> = BTreeMap::new();
        // One after the other, as a rule: a session is looked up once.
        for trials in self.trials.chunk_by(|a, b| a.meta.is_of_session_of(&b.meta)) {
            let key = (&trials[0].meta.participant, &trials[0].meta.session);
            sessions.entry(key).or_default().extend(trials);
        }
        sessions
    }

    /// Every answer: those that count, and the others.
    fn collect_answers(&self) -> (Vec<Answer>, Vec<LeftOutAnswer>) {
        let mut all = Answers::new();
        for t in &self.trials {
            let question =
                self.study.environment(&t.meta.environment).and_then(|e| e.question.clone());
            if let (Some(question), Some(value)) = (question, t.meta.likert) {
                let m = &t.meta;
                let who = (m.participant.clone(), m.session.clone(), m.trial);
                let answer = new_answer(&who, m.condition(), &question, value.into(), None);
                all.entry((who, question)).or_default().push((answer, t.why_not()));
            }
        }
        // Behind the files, each log in its order: what is put in later takes the place of an
        // earlier answer.
        let trials = self.by_session();
        for log in &self.sessions {
            let of_session = trials.get(&(&log.record.participant, &log.record.session));
            let conditions = self.conditions(log, of_session.map_or(&[], Vec::as_slice));
            for event in &log.events {
                let Event::Answer { trial, question, value, time_ms } = event else { continue };
                let Some((condition, why_not)) = conditions.get(trial) else { continue };
                let who = (log.record.participant.clone(), log.record.session.clone(), *trial);
                let answer = new_answer(&who, condition.clone(), question, *value, *time_ms);
                all.entry((who, question.clone())).or_default().push((answer, why_not.clone()));
            }
        }
        let mut counting = Vec::new();
        let mut left_out = Vec::new();
        for mut answers in all.into_values() {
            let Some((last, why_not)) = answers.pop() else { continue };
            for i in 0..answers.len() {
                let later = answers.get(i + 1).map_or(&last, |(later, _)| later);
                // What stands in the trial's file and in the log too is one answer.
                if answers[i].0.value == later.value {
                    continue;
                }
                let (answer, why_not) = answers[i].clone();
                let why_not = why_not.unwrap_or_else(|| "a later answer took its place".to_owned());
                left_out.push(LeftOutAnswer { answer, why_not });
            }
            match why_not {
                Some(why_not) => left_out.push(LeftOutAnswer { answer: last, why_not }),
                None => counting.push(last),
            }
        }
        (counting, left_out)
    }

    /// The condition of each trial of a session, with or without samples, and why it does not count.
    pub(crate) fn conditions(
        &self,
        log: &SessionLog,
        of_session: &[&TrialEntry],
    ) -> BTreeMap<u32, (Condition, Option<String>)> {
        let mut left_out = BTreeMap::new();
        for event in &log.events {
            match event {
                Event::Superseded { trial, by } => {
                    left_out.insert(*trial, format!("superseded by trial {by}"));
                }
                Event::Excluded { trial, reason } => {
                    left_out.entry(*trial).or_insert_with(|| format!("excluded: {reason}"));
                }
                Event::Unmet { trial, what } => {
                    let why_not = || format!("excluded: {}", unmet(what));
                    left_out.entry(*trial).or_insert_with(why_not);
                }
                _ => {}
            }
        }
        let mut conditions = BTreeMap::new();
        for p in &log.trials {
            let condition = Condition { environment: p.environment.clone(), mode: p.mode.clone() };
            let is_known = self.study.environment(&p.environment).is_some()
                && self.study.mode(&p.mode).is_some();
            let why_not = match left_out.remove(&p.trial) {
                _ if p.kind == Kind::Familiarisation => Some("familiarisation".to_owned()),
                Some(why_not) => Some(why_not),
                None if p.samples => Some("its recording is missing or cannot be read".to_owned()),
                None if is_known => None,
                None if log.is_sealed() => Some(why_sealed(&self.layout, &log.record)),
                None => Some("study.toml has no such environment or mode".to_owned()),
            };
            conditions.insert(p.trial, (condition, why_not));
        }
        // What is known of a recording comes before what was planned.
        conditions
            .extend(of_session.iter().map(|t| (t.meta.trial, (t.meta.condition(), t.why_not()))));
        conditions
    }
}

/// The name of a session's file, byte by byte.
fn name<'a>(participant: &'a str, session: &'a str) -> impl Iterator<Item = u8> + 'a {
    participant.bytes().chain(*b"_").chain(session.bytes())
}

fn new_answer(
    (participant, session, trial): &(ParticipantId, SessionId, u32),
    condition: Condition,
    question: &QuestionId,
    value: AnswerValue,
    time_ms: Option<u32>,
) -> Answer {
    Answer {
        participant: participant.clone(),
        session: session.clone(),
        trial: *trial,
        condition,
        question: question.clone(),
        value,
        time_ms,
    }
}

/// Reads a study's `study.toml`.
///
/// # Errors
/// A missing file; every problem in it, with key and line; an id that is not the folder's.
pub fn read_study(layout: &Layout) -> Result<Study, Vec<StoreError>> {
    read_study_from(&RealFiles, layout).map(|(study, _)| study)
}

/// Whether the study's folder is one, and not a link to one.
pub(crate) fn check_folders(files: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
    for folder in [layout.root().join("raw"), layout.raw()] {
        if let Some(kind @ (Entry::Link | Entry::Special)) = files.kind(&folder) {
            return Err(strange(&folder, kind));
        }
    }
    Ok(())
}

/// The study and the hash of its file.
pub(crate) fn read_study_from(
    files: &dyn Files,
    layout: &Layout,
) -> Result<(Study, String), Vec<StoreError>> {
    check_folders(files, layout).map_err(|error| vec![error])?;
    let path = layout.study_toml();
    let text = text(files, &path, MOST_STUDY).map_err(|e| vec![e])?;
    let study = Study::from_toml(&text).map_err(|errors| {
        errors
            .iter()
            .map(|e| {
                let remedy = "docs/data.md has every table and key of a study.toml";
                StoreError::new(&path, e.to_string(), remedy)
            })
            .collect::<Vec<_>>()
    })?;
    if study.id != *layout.study() {
        let what = format!("study.id is '{}' in the folder '{}'", study.id, layout.study());
        return Err(vec![StoreError::new(&path, what, "make the id and the folder's name equal")]);
    }
    Ok((study, hex_blake3(text.as_bytes())))
}

fn list_sweeps(files: &dyn Files, layout: &Layout) -> Vec<Result<SweepEntry, StoreError>> {
    let paths = match parquet_below(files, &layout.sweeps()) {
        Ok(paths) => paths,
        Err(error) => return vec![Err(error)],
    };
    paths
        .into_par_iter()
        .map(|path| {
            let actuator = from_path(&path, "actuator")?;
            entry(files, layout, path, actuator)
        })
        .collect()
}
