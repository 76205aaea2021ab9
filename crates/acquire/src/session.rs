//! A session as it is set up before its first trial, or found again on the disk.

use crate::flow::{Flow, Recorded};
use crate::number::{Numbers, numbers};
use crate::own::opening;
use crate::plan::Plan;
use crate::tasks::{self, Tasks};
use crate::{AcquireError, vault};
use std::path::Path;
use zwidth_device::Capabilities;
use zwidth_store::{
    Files, PersonChanges, SessionLog, TrialEntry, WholeSession, check_form, check_session_ids,
    hex_blake3, lay_down, read_people, read_records, read_session,
};
use zwidth_study::{
    AnswerScale, AskedPair, Channel, Event, Kind, ModeId, OrderRecord, PersonValue, PlannedTrial,
    Presented, Question, Scene, Score, Seal, SessionRecord, Status, Study, TaskPlace, TrialMeta,
    order,
};

/// A session, set up or found again.
#[derive(Debug, Clone)]
pub struct Session {
    /// Its record.
    pub record: SessionRecord,
    /// Whether the record is on the disk.
    pub laid_down: bool,
    /// Its seal, if it was sealed.
    pub seal: Option<Seal>,
    /// Whether modes and voltages are hidden.
    pub blinded: bool,
    /// The mode of each trial of the order.
    pub modes: Vec<ModeId>,
    /// Each trial's place in a task, with the standard where it is: by the trials of the order.
    pub places: Vec<Option<TaskPlace>>,
    /// Earlier recordings.
    pub recorded: Vec<Recorded>,
    /// The events of its log.
    pub events: Vec<Event>,
    /// Events to report and keep in its log as soon as it is set up or continued.
    pub opening: Vec<Event>,
}

impl Session {
    /// Finds the session, or draws its order. Nothing is written but the seed of a blinded study.
    ///
    /// # Errors
    /// A session on the disk that began with another device, calibration, rate or seed, or with
    /// another `study.toml` where that matters and is not accepted; one that is not whole, or
    /// whose seal is not there; a study with an environment that no device renders; seals that
    /// would lie in the data.
    pub fn open(
        plan: &Plan,
        device: &Capabilities,
        files: &dyn Files,
    ) -> Result<Self, AcquireError> {
        if let Some(environment) = plan.study.environments.iter().find(|e| e.scene == Scene::None) {
            return Err(AcquireError::refused(
                format!(
                    "environment {} has kind = \"none\", so no trial can be recorded in it",
                    environment.id
                ),
                "give it another kind in study.toml, for instance \"spring\"",
            ));
        }
        if plan.study.axes.is_some() {
            return Err(AcquireError::refused(
                "the study has [axes], and no device that can be driven here moves in more than one direction",
                "record with your own program and import the files (docs/import.md), or leave [axes] out",
            ));
        }
        // A channel of the study that the device gives in another unit would be recorded wrongly.
        for Channel { id, unit, .. } in &plan.study.channels {
            let other = device.channels.iter().find(|other| other.id == *id && other.unit != *unit);
            if let Some(other) = other {
                return Err(AcquireError::refused(
                    format!(
                        "channel '{}' is in '{unit}' in study.toml, and {} gives it in '{}'",
                        id.as_str(),
                        device.name,
                        other.unit
                    ),
                    "give it the device's unit in study.toml, or another id",
                ));
            }
        }
        let rate_hz = plan.rate_hz.min(device.rate_hz);
        if let Some(why) = tasks::refuse(&plan.study, rate_hz) {
            return Err(AcquireError::refused(why, "correct the task in study.toml"));
        }
        if plan.study.design.blinded {
            vault::check_apart(&plan.keys, &plan.layout)?;
        }
        match read_session(files, &plan.layout, &plan.participant, &plan.session) {
            Ok(Some(whole)) => resume_session(plan, device, files, whole),
            Ok(None) => {
                check_session_ids(files, &plan.layout, &plan.participant, &plan.session)?;
                check_form(files, &plan.layout, &plan.study)?;
                draw_session(plan, device, files)
            }
            Err(findings) => Err(AcquireError::NotWhole { session: plan.name(), findings }),
        }
    }

    /// The order, each trial with the questions that follow it. The pairs of a score follow those of the last trial
    /// after which all of the score's questions are asked: only then does a person know all that is to be weighed.
    pub(crate) fn order(&self, study: &Study) -> Vec<(PlannedTrial, Vec<Question>)> {
        let trials = &self.record.trials;
        let order = trials.iter().map(|trial| {
            let of_task = trial.task.as_ref().map(|place| {
                let task = study.task(&place.task).filter(|task| place.is_last(task.asks));
                task.map(|task| &task.id).into_iter().collect::<Vec<_>>()
            });
            let ids = of_task.unwrap_or_else(|| {
                let environment = study.environment(&trial.environment).into_iter();
                environment.flat_map(|environment| environment.questions()).collect()
            });
            (trial.clone(), ids.into_iter().filter_map(|id| study.question(id).cloned()).collect())
        });
        let mut order: Vec<(PlannedTrial, Vec<Question>)> = order.collect();
        for score in study.scores.iter().filter(|score| score.pairs.is_some()) {
            let is_weighed = |trial: &PlannedTrial| {
                let environment = study.environment(&trial.environment);
                trial.kind == Kind::Trial
                    && environment.is_some_and(|own| study.weighed_in(own).any(|own| own == score))
            };
            let Some(last) = trials.iter().rposition(is_weighed) else { continue };
            order[last].1.extend(self.pairs(score, study));
        }
        order
    }

    /// The questions about a score's pairs as this session asks them.
    fn pairs(&self, score: &Score, study: &Study) -> Vec<Question> {
        let ids = score.weighing();
        let own = self.record.pairs.iter().filter(|pair| ids.contains(&pair.question));
        let questions = own.filter_map(|AskedPair { question, is_turned }| {
            let mut question = study.question(question)?.clone();
            if let AnswerScale::Pair(labels) = &mut question.scale
                && *is_turned
            {
                labels.reverse();
                question.reversed = true;
            }
            Some(question)
        });
        questions.collect()
    }

    /// What the places of the order are in tasks, after what the log says of them.
    ///
    /// # Errors
    /// A plan of a task that cannot be followed; a level in the log that does not follow from it.
    pub(crate) fn tasks(&self, study: &Study, rate_hz: f64) -> Result<Tasks, AcquireError> {
        let SessionRecord { participant, session, trials, .. } = &self.record;
        let opened = trials.iter().zip(&self.modes).zip(&self.places);
        let opened: Vec<PlannedTrial> = opened
            .map(|((trial, mode), task)| PlannedTrial {
                mode: mode.clone(),
                task: task.clone(),
                ..trial.clone()
            })
            .collect();
        let numbers: Vec<u32> = trials.iter().map(|trial| trial.trial).collect();
        let mut tasks = Tasks::new(study, &opened, rate_hz)
            .map_err(|why| AcquireError::refused(why, "correct study.toml"))?;
        tasks.replay(&numbers, &self.events).map_err(|why| {
            let remedy = "restore the session's log and record from copies, or begin a new session";
            AcquireError::refused(format!("session {session} of {participant}: {why}"), remedy)
        })?;
        Ok(tasks)
    }

    /// What a trial's file says of it: in a sealed session its code in place of the mode, and of a task no
    /// level.
    pub(crate) fn meta(&self, trial: &PlannedTrial, presented: Option<Presented>) -> TrialMeta {
        let presented = presented
            .map(|shown| Presented { level: shown.level.filter(|_| !self.blinded), ..shown });
        let code = self.seal.as_ref().map(|seal| seal.code(trial.trial));
        TrialMeta {
            participant: self.record.participant.clone(),
            session: self.record.session.clone(),
            trial: trial.trial,
            repeat: trial.repeat,
            kind: trial.kind,
            status: Status::Complete,
            environment: trial.environment.clone(),
            mode: code.unwrap_or_else(|| trial.mode.clone()),
            likert: None,
            source: self.record.source,
            presented,
        }
    }

    /// Lays the session down, once, and before it keeps the seal of a blinded one. `utc` is the
    /// time of it.
    ///
    /// # Errors
    /// A write that failed.
    pub(crate) fn lay_down(
        &mut self,
        plan: &Plan,
        files: &dyn Files,
        utc: &str,
    ) -> Result<(), AcquireError> {
        // The seal first: a blinded session on the disk without one could never be unsealed.
        if let Some(seal) = &self.seal {
            vault::keep(files, &plan.keys, plan.layout.study(), &self.record, seal)?;
        }
        lay_down(files, &plan.layout, utc, &self.record, &plan.study_toml)?;
        self.laid_down = true;
        Ok(())
    }
}

impl Plan {
    /// Participant and session, in words.
    pub(crate) fn name(&self) -> String {
        format!("{} {}", self.participant, self.session)
    }
}

/// A record without its trials: what must stay the same while the session lasts.
fn bare_record(plan: &Plan, device: &Capabilities) -> Result<SessionRecord, AcquireError> {
    let mut record = SessionRecord::new(
        plan.participant.clone(),
        plan.session.clone(),
        device.source,
        plan.software.clone(),
        hex_blake3(&plan.study_toml),
        Vec::new(),
    );
    record.device = Some(device.name.clone());
    record.calibration = Some(plan.calibration.clone());
    let calibration = plan.calibration.to_toml().map_err(|e| {
        AcquireError::refused(e.to_string(), "correct calibration.toml beside study.toml")
    })?;
    record.calibration_blake3 = Some(hex_blake3(calibration.as_bytes()));
    record.rate_hz = Some(plan.rate_hz);
    Ok(record)
}

fn draw_session(
    plan: &Plan,
    device: &Capabilities,
    files: &dyn Files,
) -> Result<Session, AcquireError> {
    let mut record = bare_record(plan, device)?;
    let seed = match plan.seed {
        Some(seed) => seed,
        None if plan.study.design.blinded => {
            // From outside the data: any reader can find what `seed_of` gives.
            vault::seed(files, &plan.keys, plan.layout.study(), || {
                first_u64(&derived(plan, "seed"))
            })?
        }
        None => seed_of(&plan.study),
    };
    let Numbers { participant: participant_number, session: session_number, remarks } =
        numbers(files, &plan.layout, &plan.participant, &plan.session)?;
    let scheme = plan.study.design.order;
    record.order = Some(OrderRecord { scheme, participant_number, session_number });
    let people = read_people(files, &plan.layout, &plan.study).map_err(|findings| {
        let words: Vec<String> = findings.iter().map(ToString::to_string).collect();
        AcquireError::refused(words.join("; "), "correct it")
    })?;
    record.person = people.row(&plan.participant).cloned().unwrap_or_default();
    let mut opening: Vec<String> = remarks;
    let mut lacking = plan.study.people.clone();
    lacking.retain(|column| !record.person.contains_key(&column.id) && column.is_drawn());
    let earlier = if lacking.is_empty() { Vec::new() } else { own_records(plan, files)? };
    for column in &lacking {
        let Some((level, block)) = column.drawn(participant_number, seed) else { continue };
        // What chance gave once it gave for all sessions.
        let before = earlier.iter().find_map(|record| {
            Some((record.person.get(&column.id)?.clone(), *record.drawn.get(&column.id)?))
        });
        let (level, block) = before.unwrap_or_else(|| {
            opening.push(format!("{} was drawn: {level}", column.id));
            (PersonValue::Level(level), block)
        });
        record.person.insert(column.id.clone(), level);
        record.drawn.insert(column.id.clone(), block);
    }
    let trials = order::draw(&plan.study, participant_number, session_number, seed);
    // A blinded session keeps its seed to itself, and the order of pairs is no secret: it comes from elsewhere.
    let seed_of_pairs =
        if plan.study.design.blinded { first_u64(&derived(plan, "pairs")) } else { seed };
    record.pairs =
        order::draw_pairs(&plan.study, participant_number, session_number, seed_of_pairs);
    let modes = trials.iter().map(|t| t.mode.clone()).collect();
    let places = trials.iter().map(|t| t.task.clone()).collect();
    let seal = if plan.study.design.blinded {
        let seal = Seal::new(derived(plan, "nonce"), &trials);
        record.commitment = Some(seal.commitment());
        // The record has codes in place of modes, and no seed, from which the modes would follow.
        record.trials = seal.masked(&trials);
        Some(seal)
    } else {
        record.seed = Some(seed);
        record.trials = trials;
        None
    };
    let blinded = seal.is_some();
    let recorded = Vec::new();
    let events = Vec::new();
    let opening = opening.into_iter().map(|text| Event::Note { trial: None, text }).collect();
    Ok(Session {
        record,
        laid_down: false,
        seal,
        blinded,
        modes,
        places,
        recorded,
        events,
        opening,
    })
}

/// The records of the participant's sessions; of one that is set up those before it.
fn own_records(plan: &Plan, files: &dyn Files) -> Result<Vec<SessionRecord>, AcquireError> {
    let own = format!("{}_", plan.participant);
    let is_own =
        |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&own));
    let mut records = read_records(files, &plan.layout, &is_own)?;
    // An id may hold a `_`, too.
    records.retain(|record| record.participant == plan.participant);
    Ok(records)
}

/// What the participants' file says of the person now and did not when the session began: another group, where groups are
/// compared, has to be accepted; one where none was known is kept in the log. A file that cannot be read is none of this
/// session's concern: `verify` tells it.
fn person_changed(
    plan: &Plan,
    log: &SessionLog,
    files: &dyn Files,
) -> Result<Vec<Event>, AcquireError> {
    // The session goes on by its own copy of study.toml; the file belongs to the present one.
    let Ok(study) = Study::from_toml(&String::from_utf8_lossy(&plan.study_toml)) else {
        return Ok(Vec::new());
    };
    let Ok(people) = read_people(files, &plan.layout, &study) else { return Ok(Vec::new()) };
    // What chance gave in another session holds for this one too, unless a record there is damaged: `verify` tells that.
    let records = own_records(plan, files).unwrap_or_else(|_| vec![log.record.clone()]);
    let people = people.with_drawn(&study.people, records.iter());
    let PersonChanges { group, filled_in, rest } = PersonChanges::of(log, &people, &study);
    if let Some(group) = group.as_ref().filter(|_| !plan.accept_study_change) {
        return Err(AcquireError::refused(
            format!("{}: {}, by the participants' file", log.path.display(), group.words),
            "correct the file, or go on with --accept-study-change",
        ));
    }
    let text = format!("the participants' file has changed: {}", rest.join("; "));
    let note = Event::Note { trial: None, text };
    // Noted once, however often the session is gone on with.
    let note = (!rest.is_empty() && !log.events.contains(&note)).then_some(note);
    // A group that was not known is kept with the session, so that nobody can change it unseen from here on.
    let groups = group.into_iter().chain(filled_in).map(|group| group.accepted);
    Ok(groups.chain(note).collect())
}

fn resume_session(
    plan: &Plan,
    device: &Capabilities,
    files: &dyn Files,
    whole: WholeSession,
) -> Result<Session, AcquireError> {
    let WholeSession { log, trials } = whole;
    let differences = differences(&log.record, &bare_record(plan, device)?, plan.seed);
    if !differences.is_empty() {
        let what = format!("cannot go on with {}: {}", log.path.display(), differences.join("; "));
        let remedy = "begin a new session, or restore what this one began with";
        return Err(AcquireError::refused(what, remedy));
    }
    let mut opening = opening(plan, &log)?;
    opening.extend(person_changed(plan, &log, files)?);
    let seal = match (&log.seal, &log.record.commitment) {
        (Some(seal), _) => Some(seal.clone()),
        // Not unsealed yet: the log has no seal.
        (None, Some(_)) => Some(vault::find(files, &plan.keys, plan.layout.study(), &log.record)?),
        (None, None) => None,
    };
    let opened = match &seal {
        Some(seal) => seal.opened(&log.record.trials).map_err(|e| {
            AcquireError::refused(
                format!("session {} of {}: {e}", log.record.session, log.record.participant),
                "restore the session's record and its seal from copies",
            )
        })?,
        None => log.record.trials.clone(),
    };
    Ok(Session {
        recorded: recorded(&trials, &log),
        record: log.record.clone(),
        laid_down: true,
        blinded: log.is_sealed(),
        seal,
        places: opened.iter().map(|trial| trial.task.clone()).collect(),
        modes: opened.into_iter().map(|trial| trial.mode).collect(),
        events: log.events,
        opening,
    })
}

/// What was recorded of a session.
fn recorded<'t>(
    trials: impl IntoIterator<Item = &'t TrialEntry>,
    log: &SessionLog,
) -> Vec<Recorded> {
    let own = trials.into_iter().filter(|trial| {
        let TrialMeta { participant, session, .. } = &trial.meta;
        *participant == log.record.participant && *session == log.record.session
    });
    let recorded = own.map(|trial| Recorded {
        trial: trial.meta.trial,
        complete: trial.meta.status == Status::Complete,
        settled: trial.meta.likert.is_some() || trial.excluded.is_some(),
    });
    recorded.collect()
}

/// How many trials of a session's order are still to be done, its own among `trials`; 0 for an
/// imported session, which has no order. Of tasks those count that may be needed: of a session that is
/// sealed, whose modes and standards only its `seal` knows, without that all that are planned.
pub fn left_to_do<'t>(
    trials: impl IntoIterator<Item = &'t TrialEntry>,
    log: &SessionLog,
    study: &Study,
    seal: Option<&Seal>,
) -> usize {
    if log.record.order.is_none() {
        return 0;
    }
    // Without questions: one that is open is no trial to be done.
    let order = log.record.trials.iter().map(|t| (t.clone(), Vec::new())).collect();
    let mut tasks = Tasks::default();
    let opened = match (seal.or(log.seal.as_ref()), &log.record.commitment) {
        (Some(seal), _) => seal.opened(&log.record.trials).ok(),
        (None, Some(_)) => None,
        (None, None) => Some(log.record.trials.clone()),
    };
    if let Some(opened) = opened.filter(|_| !study.tasks.is_empty()) {
        // A log that does not follow from the plan is told by whoever goes on with the session.
        let numbers: Vec<u32> = opened.iter().map(|trial| trial.trial).collect();
        let rate_hz = log.record.rate_hz.unwrap_or(study.control.rate_hz);
        let found = Tasks::new(study, &opened, rate_hz).ok();
        let found = found.and_then(|mut tasks| {
            tasks.replay(&numbers, &log.events).ok()?;
            Some(tasks)
        });
        tasks = found.unwrap_or_default();
    }
    let (flow, _) = Flow::begin(order, tasks, 0.0, &recorded(trials, log), &log.events);
    flow.total() - flow.done()
}

/// What a session on the disk began with that is not at hand now, in words.
fn differences(record: &SessionRecord, now: &SessionRecord, seed: Option<u64>) -> Vec<String> {
    let [rate_then, rate_now] =
        [record, now].map(|record| record.rate_hz.map(|hz| format!("{hz} Hz")));
    // Enough digits of a hash to see that two differ.
    let [calibration_then, calibration_now] = [record, now].map(|record| {
        record.calibration_blake3.as_ref().map(|hash| hash.chars().take(12).collect::<String>())
    });
    // Only where both have one: a seed need not be named again, and a blinded record has none.
    let seeds = [record.seed.filter(|_| seed.is_some()), seed.filter(|_| record.seed.is_some())];
    let [seed_then, seed_now] = seeds.map(|s| s.map(|s| s.to_string()));
    [
        ("the device is", record.device.clone(), now.device.clone()),
        ("the calibration is", calibration_then, calibration_now),
        ("the rate is", rate_then, rate_now),
        ("the seed is", seed_then, seed_now),
    ]
    .into_iter()
    .filter(|(_, then, now)| then != now)
    .map(|(what, then, now)| {
        let [then, now] = [then, now].map(|value| value.unwrap_or_else(|| "none".to_owned()));
        format!("{what} {now}, and was {then}")
    })
    .collect()
}

/// The order's seed of an open study: from its id, the same for every participant.
pub fn seed_of(study: &Study) -> u64 {
    // 32 bits, which every reader of JSON keeps.
    first_u64(blake3::hash(study.id.as_str().as_bytes()).as_bytes()) >> u32::BITS
}

/// 32 bytes from the secret. Of two for different purposes neither tells the other: a nonce is
/// shown in the end, the seed never.
fn derived(plan: &Plan, purpose: &str) -> [u8; 32] {
    *blake3::keyed_hash(&plan.secret, purpose.as_bytes()).as_bytes()
}

fn first_u64(bytes: &[u8; 32]) -> u64 {
    bytes.first_chunk().map_or(0, |first| u64::from_le_bytes(*first))
}
