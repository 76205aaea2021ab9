//! Answers to tasks: each answer that counts, with the level that was presented and what the answer says of it.

use crate::{SessionLog, StoreError, StudyData, TrialEntry};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{
    AnswerValue, Asks, Condition, Event, Kind, Method, ModeId, ParticipantId, QuestionId,
    SessionId, Source, Task, TaskLevel, TaskPlace,
};

/// One presentation of a task that was answered and counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TaskAnswer {
    /// The person who answered.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The environment that varied, and the mode.
    pub condition: Condition,
    /// The task.
    pub task: QuestionId,
    /// The presentation, counted from 1 for each task and mode of the session.
    pub presentation: u32,
    /// Which of several sequences that take turns, from 0.
    pub track: u8,
    /// The level that was compared with the standard, in the unit of what varies.
    pub level: TaskLevel,
    /// The trial before the answer: the last interval.
    pub trial: u32,
    /// Whether the answer says that the level was more than the standard, was the right one of two, was there, or is set
    /// right ([`zwidth_study::Asks::is_positive`]).
    pub is_positive: bool,
    /// The answer as given, a number of [`zwidth_study::Asks::answers`].
    pub value: AnswerValue,
    /// From the question to its answer, ms, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_ms: Option<u32>,
    /// Where it comes from.
    pub source: Source,
}

impl StudyData {
    /// Every answer to a task that counts, by participant, session and trial. None of a presentation of which an interval is
    /// superseded, excluded or incomplete, or practice; and none of a session that is still sealed.
    pub fn task_answers(&self) -> Vec<TaskAnswer> {
        if self.study.tasks.is_empty() {
            return Vec::new();
        }
        let entries = self.by_session();
        let mut all = Vec::new();
        for log in &self.sessions {
            let who = (&log.record.participant, &log.record.session);
            let of_session = entries.get(&who).map_or(&[][..], Vec::as_slice);
            let conditions = self.conditions(log, of_session);
            let counts =
                |trial: u32| conditions.get(&trial).is_some_and(|(_, why_not)| why_not.is_none());
            let presentations = Presentations::of(log);
            let from = self.answers.partition_point(|a| (&a.participant, &a.session) < who);
            let answers = self.answers[from..]
                .iter()
                .take_while(|answer| (&answer.participant, &answer.session) == who);
            for answer in answers {
                let Some(task) = self.study.task(&answer.question) else { continue };
                let Some(shown) = presentations.answered_after(answer.trial) else { continue };
                let place = shown.place;
                // Import has one trial for what others presented in two intervals.
                let is_whole = shown.intervals.len() == usize::from(task.asks.intervals())
                    || log.record.source.is_imported();
                if place.task != task.id
                    || !place.is_last(task.asks)
                    || !is_whole
                    || !shown.intervals.iter().all(|trial| counts(*trial))
                {
                    continue;
                }
                let positive = task.asks.is_positive(answer.value, place.is_standard);
                let (Some(level), Some(is_positive)) = (shown.level, positive) else { continue };
                all.push(TaskAnswer {
                    participant: answer.participant.clone(),
                    session: answer.session.clone(),
                    condition: answer.condition.clone(),
                    task: task.id.clone(),
                    presentation: place.presentation,
                    track: place.track,
                    level,
                    trial: answer.trial,
                    is_positive,
                    value: answer.value,
                    time_ms: answer.time_ms,
                    source: log.record.source,
                });
            }
        }
        all
    }
}

/// The most findings of a kind that a session's tasks give.
const MOST_TOLD: usize = 20;
/// Presentations of a level below which curves of right and wrong answers to two are mostly not found: of 7 levels with 10
/// each, 13 % of people have no finite JND in simulated studies, and 4 % with 20 each.
const FEW_OF_TWO: u32 = 20;

/// What of a study's tasks is to be read with care before anybody answered.
pub(crate) fn few_answers(data: &StudyData) -> Vec<StoreError> {
    let mut findings = Vec::new();
    for task in &data.study.tasks {
        let Method::Constant { trials, .. } = &task.method else { continue };
        if task.asks == Asks::OneOfTwo && *trials < FEW_OF_TWO {
            let what = format!(
                "task '{}' presents each level {trials} times in each mode: with fewer than {FEW_OF_TWO} many people have no JND, \
                 and those of the others are off by a factor of two",
                task.id
            );
            let remedy = "ask more often (trials), or take fewer levels";
            findings.push(StoreError::new(&data.layout.study_toml(), what, remedy));
        }
    }
    findings
}

/// Where record, files and log of a session do not agree on what its tasks presented, or with the plan.
pub(crate) fn task_findings(data: &StudyData, log: &SessionLog) -> Vec<StoreError> {
    let who = (&log.record.participant, &log.record.session);
    // Trials stand by participant, session and number.
    let name = |entry: &TrialEntry| (entry.meta.participant.clone(), entry.meta.session.clone());
    let own = (who.0.clone(), who.1.clone());
    let from = data.trials.partition_point(|entry| name(entry) < own);
    let to = data.trials.partition_point(|entry| name(entry) <= own);
    let entries = data.trials.get(from..to).unwrap_or_default();
    let shown = Presentations::of(log);
    let is_empty = log.trials.iter().all(|planned| planned.task.is_none())
        && entries.iter().all(|entry| entry.meta.presented.is_none())
        && !log.events.iter().any(|event| matches!(event, Event::Level { .. }));
    if is_empty {
        return answers_to_nothing(data, log, &shown);
    }
    let mut findings = off_plan(data, log);
    findings.extend(unlike_files(data, log, &shown, entries));
    findings.extend(logged_levels(data, log, &shown));
    findings.extend(halves(data, log, &shown, entries));
    findings.extend(answers_to_nothing(data, log, &shown));
    findings
}

/// Findings of a kind: the first ones, and how many more there are.
fn first_of(mut findings: Vec<StoreError>) -> Vec<StoreError> {
    let more = findings.len().saturating_sub(MOST_TOLD);
    findings.truncate(MOST_TOLD);
    if let Some(last) = findings.last_mut().filter(|_| more > 0) {
        last.what = format!("{}, and {more} more like this", last.what);
    }
    findings
}

/// Whether a task can present a level.
fn can_present(task: &Task, level: TaskLevel) -> bool {
    let is_within = |[lowest, highest]: &[TaskLevel; 2]| (*lowest..=*highest).contains(&level);
    Some(level) == task.standard
        || match &task.method {
            Method::Constant { levels, .. } | Method::QuestPlus { levels, .. } => {
                levels.contains(&level)
            }
            Method::Staircase(plan) => is_within(&plan.bounds),
            Method::Adjustment { bounds, .. } => is_within(bounds),
        }
}

/// Levels of the record that the study's tasks do not have, and tasks that it does not have. What others presented, no
/// plan of this study decided: any level will do there.
fn off_plan(data: &StudyData, log: &SessionLog) -> Vec<StoreError> {
    let is_imported = log.record.source.is_imported();
    let mut findings = Vec::new();
    for planned in &log.record.trials {
        let Some(place) = &planned.task else { continue };
        let what = match (data.study.task(&place.task), place.level) {
            (None, _) => format!(
                "trial {} is of the task '{}', which study.toml does not have",
                planned.trial, place.task
            ),
            (Some(task), Some(level)) if !is_imported && !can_present(task, level) => format!(
                "trial {} is to present {} {}, which is no level of the task '{}' in study.toml",
                planned.trial,
                level.value(),
                data.study.task_unit(task),
                task.id
            ),
            _ => continue,
        };
        let remedy = "put study.toml back, or exclude the trial";
        findings.push(StoreError::new(&log.path, what, remedy));
    }
    first_of(findings)
}

/// Trial files that say of their presentation what record and log do not.
fn unlike_files(
    data: &StudyData,
    log: &SessionLog,
    shown: &Presentations,
    entries: &[TrialEntry],
) -> Vec<StoreError> {
    let study = log.study.as_deref().unwrap_or(&data.study);
    let mut findings = Vec::new();
    // What contradicts the record was left out, and told, when the study was loaded.
    for entry in entries.iter().filter(|entry| entry.excluded.is_none()) {
        let trial = entry.meta.trial;
        let place = shown.places.get(&trial).map(|(_, place)| *place);
        let column = match (&entry.meta.presented, place) {
            (None, None) => continue,
            (None, Some(_)) | (Some(_), None) => "task",
            (Some(own), Some(place)) if own.task != place.task => "task",
            (Some(own), Some(place)) if own.interval != place.interval => "interval",
            (Some(own), Some(place)) => {
                // What a file of a sealed session does not say contradicts nothing.
                let expected = study
                    .task(&place.task)
                    .zip(shown.level_of(trial))
                    .and_then(|(task, level)| place.presented(task, level).level);
                match (own.level, expected) {
                    (Some(own), Some(expected)) if own != expected => "level",
                    _ => continue,
                }
            }
        };
        let what = "it is not what the session's record and log say that the trial presented";
        let remedy = "exclude the trial, or restore its file and the session's from a copy";
        findings.push(StoreError::new(&entry.path, what, remedy).column(column));
    }
    first_of(findings)
}

/// Levels in the log that no plan left open, or that the task cannot have.
fn logged_levels(data: &StudyData, log: &SessionLog, shown: &Presentations) -> Vec<StoreError> {
    let mut seen: BTreeMap<u32, TaskLevel> = BTreeMap::new();
    let mut findings = Vec::new();
    for (row, event) in log.events.iter().enumerate() {
        let Event::Level { trial, level } = event else { continue };
        let place = shown.places.get(trial).map(|(_, place)| *place);
        let task = place.and_then(|place| data.study.task(&place.task));
        let before = seen.insert(*trial, *level);
        let value = level.value();
        let what = match (place, task) {
            (None, _) => format!("trial {trial} is of no task, and gets the level {value}"),
            (Some(place), _) if place.level.is_some() => {
                format!("trial {trial} gets the level {value}, and has a planned one")
            }
            (Some(place), _) if place.interval > 1 => {
                format!("trial {trial} gets the level {value}, which belongs to the first interval")
            }
            _ if before.is_some_and(|before| before != *level) => {
                format!("trial {trial} gets the level {value} after another one")
            }
            (Some(_), Some(task)) if !can_present(task, *level) => format!(
                "trial {trial} gets the level {value}, which the task '{}' in study.toml cannot have",
                task.id
            ),
            _ => continue,
        };
        let remedy = "restore the log from a copy, or exclude the trial";
        findings.push(StoreError::new(&log.events_path, what, remedy).row0(row));
    }
    first_of(findings)
}

/// Presentations of which an interval was recorded and another was not, or twice. The one at which a session stands is
/// still to come.
fn halves(
    data: &StudyData,
    log: &SessionLog,
    shown: &Presentations,
    entries: &[TrialEntry],
) -> Vec<StoreError> {
    // Sealed or not: a trial that is there is there.
    let recorded: BTreeSet<u32> = entries
        .iter()
        .filter(|entry| entry.why_left_out().is_none())
        .map(|entry| entry.meta.trial)
        .collect();
    // What is done again has a higher number than what is still to come.
    let logged = log.events.iter().filter(|event| matches!(event, Event::Recorded { .. }));
    let mut latest = logged.rev().filter_map(Event::trial).filter(|trial| recorded.contains(trial));
    let Some(last) = latest.next().or_else(|| recorded.last().copied()) else { return Vec::new() };
    let mut findings = Vec::new();
    for ((task, _, presentation), trials) in &shown.intervals {
        let Some(task) = data.study.task(task) else { continue };
        let there: Vec<u32> =
            trials.iter().filter(|trial| recorded.contains(trial)).copied().collect();
        let is_whole = there.len() == usize::from(task.asks.intervals());
        // Left out as a whole, or never begun, or the last of the session.
        if is_whole || there.is_empty() || trials.contains(&last) {
            continue;
        }
        let words: Vec<String> = there.iter().map(u32::to_string).collect();
        let what = format!(
            "presentation {presentation} of the task '{}' has {} of {} intervals that count (trial {}): its answer does not count",
            task.id,
            there.len(),
            task.asks.intervals(),
            words.join(", ")
        );
        let remedy = "exclude its other trial, too, or restore what is missing from a copy";
        findings.push(StoreError::new(&log.path, what, remedy));
    }
    first_of(findings)
}

/// Answers to tasks after trials that are not the last of a presentation of them.
fn answers_to_nothing(
    data: &StudyData,
    log: &SessionLog,
    shown: &Presentations,
) -> Vec<StoreError> {
    let mut findings = Vec::new();
    // Practice is in no presentation that counts, and its answers are kept.
    let practice = log.trials.iter().filter(|planned| planned.kind != Kind::Trial);
    let practice = practice.filter(|planned| planned.task.is_some());
    let practice: BTreeSet<u32> = practice.map(|planned| planned.trial).collect();
    for (row, event) in log.events.iter().enumerate() {
        let Event::Answer { trial, question, .. } = event else { continue };
        let Some(task) = data.study.task(question).filter(|_| !practice.contains(trial)) else {
            continue;
        };
        let place = shown.places.get(trial).map(|(_, place)| *place);
        if place.is_some_and(|place| place.task == task.id && place.is_last(task.asks)) {
            continue;
        }
        let what = format!(
            "the answer to the task '{question}' belongs to trial {trial}, with which no presentation of it ends: it does not count"
        );
        let remedy = "the log only grows: add an event with the answer to the right trial";
        findings.push(StoreError::new(&log.events_path, what, remedy).row0(row));
    }
    first_of(findings)
}

/// The presentations of a session, without practice.
pub(crate) struct Presentations<'l> {
    /// By trial.
    places: BTreeMap<u32, (Option<&'l ModeId>, &'l TaskPlace)>,
    /// The trials of each task, mode and presentation, without those that were done again. Without a mode while it is
    /// sealed: presentations are then counted through.
    intervals: BTreeMap<(&'l QuestionId, Option<&'l ModeId>, u32), Vec<u32>>,
    /// The levels that the log has, by trial.
    levels: BTreeMap<u32, TaskLevel>,
    /// The trial in whose place another came, by that other.
    again: BTreeMap<u32, u32>,
}

/// A presentation that ends with a trial.
pub(crate) struct Shown<'l> {
    /// The place of that trial.
    pub(crate) place: &'l TaskPlace,
    /// The trials of its intervals, without those that were done again.
    pub(crate) intervals: &'l [u32],
    /// The level that was compared with the standard; none where nothing says it.
    pub(crate) level: Option<TaskLevel>,
}

impl<'l> Presentations<'l> {
    pub(crate) fn of(log: &'l SessionLog) -> Self {
        let mut levels = BTreeMap::new();
        let mut again = BTreeMap::new();
        for event in &log.events {
            match event {
                Event::Level { trial, level } => _ = levels.insert(*trial, *level),
                Event::Superseded { trial, by } => _ = again.insert(*by, *trial),
                _ => {}
            }
        }
        let replaced: BTreeSet<u32> = again.values().copied().collect();
        let mut places = BTreeMap::new();
        let mut intervals: BTreeMap<_, Vec<u32>> = BTreeMap::new();
        for planned in log.trials.iter().filter(|planned| planned.kind == Kind::Trial) {
            let Some(place) = &planned.task else { continue };
            let mode = (!log.is_sealed()).then_some(&planned.mode);
            places.insert(planned.trial, (mode, place));
            if !replaced.contains(&planned.trial) {
                let presentation = (&place.task, mode, place.presentation);
                intervals.entry(presentation).or_default().push(planned.trial);
            }
        }
        intervals.values_mut().for_each(|trials| trials.sort_unstable());
        Self { places, intervals, levels, again }
    }

    /// The presentation whose answer belongs to a trial.
    pub(crate) fn answered_after(&self, trial: u32) -> Option<Shown<'_>> {
        let (mode, place) = *self.places.get(&trial)?;
        let intervals = self.intervals.get(&(&place.task, mode, place.presentation));
        let intervals = intervals.map_or(&[][..], Vec::as_slice);
        Some(Shown { place, level: self.level_of(trial), intervals })
    }

    /// The level that is compared with the standard in a trial's presentation.
    fn level_of(&self, trial: u32) -> Option<TaskLevel> {
        let (mode, place) = *self.places.get(&trial)?;
        // The log has it with the first interval: that of these trials, or of those that were done in their place.
        let before = trial.checked_sub(u32::from(place.interval.saturating_sub(1)))?;
        let intervals = self.intervals.get(&(&place.task, mode, place.presentation));
        let now = intervals.and_then(|trials| trials.first().copied());
        let logged = || self.level(before).or_else(|| self.level(now?));
        place.level.or_else(logged)
    }

    /// The level that the log has for a trial, or for the one in whose place it came.
    fn level(&self, mut trial: u32) -> Option<TaskLevel> {
        loop {
            if let Some(level) = self.levels.get(&trial) {
                return Some(*level);
            }
            let before = *self.again.get(&trial)?;
            // A trial comes in the place of an earlier one; a log that says otherwise ends here.
            if before >= trial {
                return None;
            }
            trial = before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{UTC, meta, protocol, record, rows, study_alone};
    use crate::{
        Layout, Protocol, RealFiles, Samples, Signal, TrialFile, append_events, hex_blake3,
        lay_down, read_footer, read_parquet, read_trial, verify,
    };
    use zwidth_study::{PlannedTrial, Seal, SessionRecord, Study, TrialMeta, order, template};

    const TASK: &str = "[[tasks]]\nid = \"stiffer\"\ntext = \"Which one was stiffer?\"\nasks = \"2ifc\"\n\
                        environment = \"spring\"\nvaries = \"stiffness_n_per_rad\"\nstandard = 4.0\n";
    const CONSTANT: &str = "method = \"constant\"\nlevels = [3.0, 4.0, 5.0]\ntrials = 1\n";
    const STAIRCASE: &str = "method = \"staircase\"\nrule = \"1up2down\"\nstart = 6.0\nup = 0.4\nlowest = 4.1\nhighest = 8.0\n\
                             reversals = 2\nmost_trials = 2\n";

    /// A session of a study with a task; nothing is recorded yet.
    struct World {
        _folder: tempfile::TempDir,
        layout: Layout,
        study: Study,
        seal: Option<Seal>,
        trials: Vec<PlannedTrial>,
    }

    impl World {
        fn new(method: &str, is_sealed: bool) -> Self {
            let folder = tempfile::tempdir().unwrap();
            let layout = study_alone(folder.path());
            let text = template(layout.study())
                .replacen("schema = 2", "schema = 3", 1)
                .replacen("question = \"felt_spring\"\n", "", 1)
                .replacen("familiarisation = 3", "familiarisation = 0", 1);
            let text = format!("{text}\n{TASK}{method}");
            std::fs::write(layout.study_toml(), &text).unwrap();
            let study = Study::from_toml(&text).unwrap();
            // Those of the task alone, counted from 1.
            let all = order::draw(&study, 1, 1, 3).into_iter().filter(|t| t.task.is_some());
            let trials: Vec<PlannedTrial> =
                (1..).zip(all).map(|(trial, t)| PlannedTrial { trial, ..t }).collect();
            let seal = is_sealed.then(|| Seal::new([9; 32], &trials));
            let shown = match &seal {
                Some(seal) => seal.masked(&trials),
                None => trials.clone(),
            };
            let record = SessionRecord {
                commitment: seal.as_ref().map(Seal::commitment),
                study_blake3: hex_blake3(text.as_bytes()),
                ..record(&layout, shown.clone())
            };
            lay_down(&RealFiles, &layout, UTC, &record, text.as_bytes()).unwrap();
            Self { _folder: folder, layout, study, seal, trials: shown }
        }

        fn append(&self, event: Event) {
            let log = self.layout.events(&meta(1).participant, &meta(1).session);
            append_events(&RealFiles, &log, UTC, &[event]).unwrap();
        }

        /// Records a planned trial at a level of its presentation.
        fn run(&self, planned: &PlannedTrial, level: f64) {
            let place = planned.task.as_ref().unwrap();
            let level = TaskLevel::nearest(level).unwrap();
            let presented = place.presented(&self.study.tasks[0], level);
            self.run_as(planned, TrialMeta { presented: Some(presented), ..meta(planned.trial) });
        }

        fn run_as(&self, planned: &PlannedTrial, meta: TrialMeta) {
            let PlannedTrial { repeat, environment, mode, .. } = planned.clone();
            let meta = TrialMeta { repeat, environment, mode, ..meta };
            let protocol = Protocol { form: self.study.trial_form(), question: None, ..protocol() };
            let rows = rows(0, 3);
            let journal = crate::tests::crashes::ended_as(
                &RealFiles,
                &self.layout,
                &meta,
                &TrialFile::new(),
                &protocol,
                &rows,
            );
            journal.finish(&RealFiles, &self.layout, None, UTC).unwrap();
        }

        fn answer(&self, trial: u32, value: i16) {
            let question = self.study.tasks[0].id.clone();
            self.append(Event::Answer { trial, question, value: value.into(), time_ms: Some(700) });
        }

        /// Records the first presentations, and answers each with "the second".
        fn run_first(&self, presentations: usize) {
            for pair in self.trials.chunks(2).take(presentations) {
                let level = pair[0].task.as_ref().unwrap().level.unwrap().value();
                pair.iter().for_each(|planned| self.run(planned, level));
                self.answer(pair[1].trial, 2);
            }
        }

        fn load(&self) -> StudyData {
            StudyData::load(&self.layout).unwrap()
        }

        fn words(&self) -> Vec<String> {
            verify(&self.layout).iter().map(ToString::to_string).collect()
        }

        #[track_caller]
        fn check_found(&self, words: &str) {
            let found = self.words();
            assert!(found.iter().any(|finding| finding.contains(words)), "{found:?}");
        }
    }

    #[test]
    fn a_presentation_is_one_answer_with_its_level_and_what_was_chosen() {
        let world = World::new(CONSTANT, false);
        world.run_first(9);
        assert_eq!(world.words(), [""; 0]);
        let answers = world.load().task_answers();
        assert_eq!(answers.len(), 9);
        for (answer, pair) in answers.iter().zip(world.trials.chunks(2)) {
            let place = pair[1].task.as_ref().unwrap();
            assert_eq!((answer.trial, Some(answer.level)), (pair[1].trial, place.level));
            assert_eq!(
                (&answer.condition.mode, answer.presentation),
                (&pair[1].mode, place.presentation)
            );
            // "The second" is positive where the first held the standard.
            assert_eq!(Some(answer.is_positive), place.is_standard.map(|holds| !holds));
            assert_eq!(answer.time_ms, Some(700));
        }
        let data = world.load();
        assert_eq!(data.study.questions.iter().filter(|q| q.is_rating()).count(), 2);
        assert!(data.answers.iter().all(|answer| answer.question == world.study.tasks[0].id));
    }

    #[test]
    fn a_presentation_counts_as_a_whole_or_not_at_all() {
        let world = World::new(CONSTANT, false);
        world.run_first(3);
        // Its first interval is excluded.
        world.append(Event::Excluded { trial: 1, reason: "a noise".to_owned() });
        world.check_found("has 1 of 2 intervals that count (trial 2)");
        world.append(Event::Excluded { trial: 2, reason: "a noise".to_owned() });
        assert_eq!(world.words(), [""; 0]);
        let trials = |world: &World| {
            world.load().task_answers().iter().map(|answer| answer.trial).collect::<Vec<_>>()
        };
        assert_eq!(trials(&world), [4, 6]);
        // The second presentation is done again.
        let level = world.trials[2].task.as_ref().unwrap().level.unwrap().value();
        for (trial, by) in [(3, 101), (4, 102)] {
            world.append(Event::Superseded { trial, by });
            let again = PlannedTrial { trial: by, ..world.trials[trial as usize - 1].clone() };
            world.run(&again, level);
        }
        assert_eq!(trials(&world), [6]);
        world.answer(102, 1);
        assert_eq!(trials(&world), [6, 102]);
        assert_eq!(world.words(), [""; 0]);
        // The session stands in its fourth presentation, although trial 102 was recorded before.
        world.run(&world.trials[6], world.trials[6].task.as_ref().unwrap().level.unwrap().value());
        assert_eq!(world.words(), [""; 0]);
    }

    #[test]
    fn an_adaptive_level_is_that_of_the_log_also_for_what_is_done_again() {
        let world = World::new(STAIRCASE, false);
        let level = |trial, value| {
            let level = TaskLevel::nearest(value).unwrap();
            world.append(Event::Level { trial, level });
        };
        level(1, 6.0);
        world.trials[..2].iter().for_each(|planned| world.run(planned, 6.0));
        world.answer(2, 1);
        for (trial, by) in [(1, 101), (2, 102)] {
            world.append(Event::Superseded { trial, by });
            world.run(&PlannedTrial { trial: by, ..world.trials[trial as usize - 1].clone() }, 6.0);
        }
        world.answer(102, 1);
        let answers = world.load().task_answers();
        assert_eq!((answers.len(), answers[0].trial, answers[0].level.value()), (1, 102, 6.0));
        assert_eq!(world.words(), [""; 0]);
        // Without a level nothing can be counted.
        world.trials[2..4].iter().for_each(|planned| world.run(planned, 6.0));
        world.answer(4, 1);
        assert_eq!(world.load().task_answers().len(), 1);
        level(3, 9.0);
        world.check_found("which the task 'stiffer' in study.toml cannot have");
        world.check_found("it is not what the session's record and log say");
        level(4, 6.0);
        world.check_found("which belongs to the first interval");
        level(1, 6.4);
        world.check_found("after another one");
    }

    #[test]
    fn what_does_not_fit_is_found() {
        let world = World::new(CONSTANT, false);
        world.run_first(1);
        world.answer(1, 2);
        world.check_found("with which no presentation of it ends");
        let level = TaskLevel::nearest(3.0).unwrap();
        world.append(Event::Level { trial: 3, level });
        world.check_found("has a planned one");
        // A file of another interval, or at another level, than the record says is left out.
        let place = world.trials[2].task.clone().unwrap();
        let presented = place.presented(&world.study.tasks[0], place.level.unwrap());
        let other = zwidth_study::Presented { interval: 2, ..presented };
        world.run_as(&world.trials[2], TrialMeta { presented: Some(other), ..meta(3) });
        world.check_found("its interval is '2' and '1' in its session's record");
        world.run(
            &world.trials[3],
            if world.trials[3].task.as_ref().unwrap().is_standard == Some(true) {
                3.0
            } else {
                8.0
            },
        );
        let text = std::fs::read_to_string(world.layout.study_toml()).unwrap();
        let fewer = text.replace("levels = [3.0, 4.0, 5.0]", "levels = [4.0, 4.5, 5.0]");
        std::fs::write(world.layout.study_toml(), fewer).unwrap();
        world.check_found("to present 3 N/rad, which is no level of the task 'stiffer'");
    }

    #[test]
    fn few_answers_to_one_of_two_are_told_before_anybody_answers() {
        let of_two = CONSTANT.replace("[3.0, 4.0, 5.0]", "[4.2, 4.5, 5.0]");
        let world = World::new(&of_two, false);
        assert_eq!(world.words(), [""; 0]);
        let text = std::fs::read_to_string(world.layout.study_toml()).unwrap();
        std::fs::write(world.layout.study_toml(), text.replace("2ifc", "2afc")).unwrap();
        world.check_found("presents each level 1 times in each mode: with fewer than 20");
    }

    #[test]
    fn a_sealed_session_says_nothing_of_the_standard_until_it_is_opened() {
        let world = World::new(CONSTANT, true);
        world.run_first(4);
        assert_eq!(world.words(), [""; 0]);
        let data = world.load();
        assert!(data.task_answers().is_empty());
        let presented = data.trials.iter().filter_map(|entry| entry.meta.presented.as_ref());
        assert!(presented.clone().count() == 8 && presented.clone().all(|own| own.level.is_none()));
        world.append(world.seal.as_ref().unwrap().event());
        let answers = world.load().task_answers();
        assert_eq!((answers.len(), world.words()), (4, vec![]));
        for (answer, pair) in answers.iter().zip(world.trials.chunks(2)) {
            assert_eq!(Some(answer.level), pair[0].task.as_ref().unwrap().level);
        }
    }

    #[test]
    fn files_of_schema_3_have_columns_for_presentations_and_space_and_those_of_schema_2_do_not() {
        let world = World::new(CONSTANT, false);
        world.run_first(1);
        let path = world.layout.trial(&meta(1).participant, &meta(1).session, 1);
        let footer = read_footer(&path).unwrap();
        let presented = footer.meta.presented.clone().unwrap();
        assert_eq!((presented.interval, presented.task.as_str()), (1, "stiffer"));
        assert_eq!(footer.form, world.study.trial_form());
        let (batch, _) = read_parquet(&path).unwrap();
        let nulls = |name: &str| batch.column_by_name(name).map(|column| column.null_count());
        assert_eq!(["interval", "level", "task"].map(nulls), [Some(0); 3]);
        assert_eq!(["x_m", "z_m", "force_y_n"].map(nulls), [Some(3); 3]);
        // Outside of tasks they are null, and the columns are the same.
        let mut trial = read_trial(&path, Signal::all()).unwrap();
        assert_eq!(trial.meta.presented.as_ref(), Some(&presented));
        trial.meta.presented = None;
        trial.samples.set(Signal::ForceY, vec![0.5, -0.5, 0.0]);
        let form = world.study.trial_form();
        let beside = path.with_file_name("trial-009.parquet");
        std::fs::write(&beside, crate::trial_bytes(&trial, &form, &beside).unwrap()).unwrap();
        let again = read_trial(&beside, Signal::all()).unwrap();
        assert_eq!(
            (again.meta.presented, again.samples.get(Signal::ForceY)),
            (None, Some([0.5, -0.5, 0.0].as_slice()))
        );
        let (other, _) = read_parquet(&beside).unwrap();
        assert_eq!(other.schema(), batch.schema());
        assert_eq!(other.column_by_name("task").unwrap().logical_null_count(), 3);
        let two = zwidth_study::TrialForm::default();
        let error = crate::trial_bytes(&trial, &two, &beside).unwrap_err();
        assert!(
            error.to_string().contains("force_y_n: trial files of schema 2 have no such column"),
            "{error}"
        );
        trial.samples = Samples::from_rows(&rows(0, 3));
        std::fs::write(&beside, crate::trial_bytes(&trial, &two, &beside).unwrap()).unwrap();
        let (two, _) = read_parquet(&beside).unwrap();
        assert!(
            ["interval", "x_m", "force_z_n"].iter().all(|name| two.column_by_name(name).is_none())
        );
        assert!(read_trial(&beside, Signal::all()).unwrap().samples.get(Signal::X).is_none());
    }
}
