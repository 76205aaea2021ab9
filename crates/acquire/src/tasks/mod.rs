//! The tasks of a session: which of its places belong to which presentation and sequence of levels, and what was answered.
//!
//! A pure part of the flow, which tells it what happens; nothing here knows a trial that runs.

mod deliver;
mod replay;
mod sequence;

pub(crate) use deliver::refuse;
pub use sequence::{Counted, Progress};

use deliver::delivered;
use sequence::{Answered, Sequence};
use std::collections::BTreeMap;
use std::ops::Range;
use zwidth_study::{
    Asks, Event, Method, ModeId, PlannedTrial, Presented, QuestionId, Study, Task, TaskLevel,
    TaskPlace,
};

/// The tasks of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Tasks {
    tasks: Vec<Task>,
    presentations: Vec<Presentation>,
    /// The presentation of each place, for places of tasks.
    of_place: Vec<Option<usize>>,
    sequences: Vec<Sequence>,
    /// Ticks per second of the loop that renders levels, Hz.
    rate_hz: f64,
}

/// One presentation: one place of the order, or two that follow each other.
#[derive(Debug, Clone, PartialEq)]
struct Presentation {
    task: usize,
    sequence: usize,
    places: Range<usize>,
    /// The trial's place in its task, of each interval.
    intervals: Vec<TaskPlace>,
    mode: ModeId,
    /// The level that is compared with the standard: planned, or given when it was first presented.
    level: Option<TaskLevel>,
    /// Whether its level was planned.
    is_planned: bool,
    /// The trial for which the log has the level.
    logged: Option<u32>,
    /// The answer that counts.
    answer: Option<i16>,
}

impl Presentation {
    /// Whether its answer decides with those of its sequence: not one at the standard among a method's own, whose levels
    /// answers decide about.
    fn is_followed(&self, task: &Task) -> bool {
        match task.method {
            Method::Constant { .. } | Method::Adjustment { .. } => true,
            Method::Staircase(_) | Method::QuestPlus { .. } => !self.is_planned,
        }
    }

    fn last_is_standard(&self) -> Option<bool> {
        self.intervals.last().and_then(|place| place.is_standard)
    }
}

/// A presentation at hand, for who runs and shows it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AtHand<'t> {
    /// Its task.
    pub(crate) task: &'t Task,
    /// Its mode.
    pub(crate) mode: &'t ModeId,
    /// What this interval presents, as its file says it.
    pub(crate) presented: Presented,
    /// The level of this interval: the standard's, or the one that is compared with it.
    pub(crate) level: TaskLevel,
    /// The level that is compared with the standard.
    pub(crate) compared: TaskLevel,
    /// Whether the last of two intervals holds the standard.
    pub(crate) last_is_standard: bool,
    /// Which of several sequences, from 0.
    pub(crate) track: u8,
    /// The presentation of its task and mode, from 1.
    pub(crate) presentation: u32,
}

/// What the experimenter may know of a presentation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TaskNow {
    /// The task.
    pub task: QuestionId,
    /// The presentation, from 1.
    pub presentation: usize,
    /// Presentations there are, or may be.
    pub of: usize,
    /// Whether there may be fewer.
    pub is_most: bool,
    /// The interval, from 1, and how many there are.
    pub interval: [u8; 2],
    /// How far its sequence is, or all of its task together where modes are hidden.
    pub progress: Progress,
}

impl TaskNow {
    /// In words: `stiffer 3 of 40, interval 1 of 2, 3 of 12 reversals`.
    pub(crate) fn in_words(&self) -> String {
        let Self { task, presentation, of, is_most, interval: [interval, intervals], .. } = self;
        let most = if *is_most { "at most " } else { "" };
        let mut words = vec![format!("{task} {presentation} of {most}{of}")];
        if *intervals > 1 {
            words.push(format!("interval {interval} of {intervals}"));
        }
        let Progress { counted, done, of } = self.progress;
        match counted {
            // Said already.
            Counted::Presentations => {}
            Counted::Reversals => words.push(format!("{done} of {of} reversals")),
            Counted::Settings => words.push(format!("{done} of {of} settings")),
        }
        words.join(", ")
    }
}

impl Tasks {
    /// The tasks of an order whose modes and standards are known.
    ///
    /// # Errors
    /// A plan that cannot be followed, in words.
    pub(crate) fn new(study: &Study, order: &[PlannedTrial], rate_hz: f64) -> Result<Self, String> {
        let mut all = Self { tasks: study.tasks.clone(), rate_hz, ..Self::default() };
        all.of_place = vec![None; order.len()];
        // By task, mode and track.
        let mut sequences: BTreeMap<(usize, &ModeId, u8), usize> = BTreeMap::new();
        let mut keys = Vec::new();
        for (place, trial) in order.iter().enumerate() {
            let Some(own) = &trial.task else { continue };
            let Some(task) = study.tasks.iter().position(|task| task.id == own.task) else {
                return Err(format!(
                    "trial {} is of the task {}, which study.toml does not have",
                    trial.trial, own.task
                ));
            };
            if own.interval > 1
                && let Some(before) = place.checked_sub(1).and_then(|i| all.of_place[i])
            {
                // The second interval follows the first.
                all.presentations[before].places.end = place + 1;
                all.presentations[before].intervals.push(own.clone());
                all.of_place[place] = Some(before);
                continue;
            }
            let next = sequences.len();
            let sequence = *sequences.entry((task, &trial.mode, own.track)).or_insert(next);
            if sequence == next {
                keys.push((task, own.track));
            }
            all.of_place[place] = Some(all.presentations.len());
            all.presentations.push(Presentation {
                task,
                sequence,
                places: place..place + 1,
                intervals: vec![own.clone()],
                mode: trial.mode.clone(),
                level: own.level,
                is_planned: own.level.is_some(),
                logged: None,
                answer: None,
            });
        }
        for (sequence, (number, track)) in keys.iter().copied().enumerate() {
            let task = &all.tasks[number];
            let like = keys[..sequence].iter().position(|(other, _)| *other == number);
            let like = like.map(|like| &all.sequences[like]);
            let own = |p: &&Presentation| p.sequence == sequence && p.is_followed(task);
            let planned = all.presentations.iter().filter(own).count();
            let start = all.presentations.iter().find(own).and_then(|p| p.level);
            let words = |why: String| format!("task {}: {why}", task.id);
            let one = Sequence::new(task, track, start, planned, like).map_err(words)?;
            all.sequences.push(one);
        }
        Ok(all)
    }

    fn at(&self, place: usize) -> Option<&Presentation> {
        self.presentations.get((*self.of_place.get(place)?)?)
    }

    /// The places of the presentation that a place is of; the place alone where it is of none.
    pub(crate) fn places(&self, place: usize) -> Range<usize> {
        self.at(place).map_or(place..place + 1, |p| p.places.clone())
    }

    /// Whether a place is of a task.
    pub(crate) fn is_presentation(&self, place: usize) -> bool {
        self.at(place).is_some()
    }

    /// Whether another interval of the same presentation comes before this place.
    pub(crate) fn is_later_interval(&self, place: usize) -> bool {
        self.places(place).start < place
    }

    /// Whether another interval of the same presentation comes after this place.
    pub(crate) fn is_followed(&self, place: usize) -> bool {
        place + 1 < self.places(place).end
    }

    /// Whether a place is still to be done: those of a sequence that is over are not.
    pub(crate) fn is_needed(&self, place: usize) -> bool {
        self.at(place).is_none_or(|p| !self.sequences[p.sequence].state.is_over)
    }

    /// Whether answers decide about the level at a place.
    fn is_adaptive(&self, presentation: &Presentation) -> bool {
        !presentation.is_planned && self.sequences[presentation.sequence].is_adaptive()
    }

    /// The level that a presentation compares with the standard: what it was, is planned, or follows now. None where nothing
    /// follows any more.
    fn level(&self, presentation: &Presentation) -> Option<TaskLevel> {
        presentation.level.or_else(|| {
            let wished = self.sequences[presentation.sequence].state.next?;
            delivered(&self.tasks[presentation.task], wished, self.rate_hz)
        })
    }

    /// A presentation begins at a place with a trial of that number: its level is fixed, and what the log is to have of it
    /// before the trial begins.
    pub(crate) fn begin(&mut self, place: usize, trial: u32) -> Option<Event> {
        let index = self.of_place.get(place).copied().flatten()?;
        let presentation = &self.presentations[index];
        let level = self.level(presentation)?;
        let is_told = presentation.places.start != place
            || !self.is_adaptive(presentation)
            || presentation.logged == Some(trial);
        let presentation = &mut self.presentations[index];
        presentation.level = Some(level);
        if is_told {
            return None;
        }
        presentation.logged = Some(trial);
        Some(Event::Level { trial, level })
    }

    /// What is presented at a place of a presentation that has begun.
    pub(crate) fn at_hand(&self, place: usize) -> Option<AtHand<'_>> {
        let p = self.at(place)?;
        let own = p.intervals.get(place - p.places.start)?;
        let task = &self.tasks[p.task];
        let compared = self.level(p)?;
        let level = if own.is_standard == Some(true) { task.standard? } else { compared };
        Some(AtHand {
            task,
            mode: &p.mode,
            presented: own.presented(task, compared),
            level,
            compared,
            last_is_standard: p.last_is_standard() == Some(true),
            track: own.track,
            presentation: own.presentation,
        })
    }

    /// The presentation at a place was answered; what is to be told if its sequence has come to its end with it.
    pub(crate) fn answered(&mut self, place: usize, value: i16) -> Option<String> {
        let index = self.of_place.get(place).copied().flatten()?;
        self.presentations[index].answer = Some(value);
        let Presentation { task, sequence, .. } = self.presentations[index];
        let before = self.sequences[sequence].state.remark.clone();
        self.follow(sequence);
        let remark = self.sequences[sequence].state.remark.clone();
        let task = &self.tasks[task].id;
        // Told once, and again where an answer that was changed later says something else.
        remark.filter(|now| before.as_ref() != Some(now)).map(|now| format!("task {task}: {now}"))
    }

    /// Whether an answer to the presentation at a place is missing.
    pub(crate) fn awaits(&self, place: usize) -> bool {
        self.at(place).is_some_and(|p| p.answer.is_none()) && !self.is_followed(place)
    }

    /// The answer at a place does not count any more.
    pub(crate) fn forget(&mut self, place: usize) {
        if let Some(index) = self.of_place.get(place).copied().flatten()
            && self.presentations[index].answer.take().is_some()
        {
            self.follow(self.presentations[index].sequence);
        }
    }

    /// Has a sequence follow from the answers that count.
    fn follow(&mut self, sequence: usize) {
        let answers: Vec<Answered> = self
            .presentations
            .iter()
            .filter(|p| p.sequence == sequence)
            .filter(|p| p.is_followed(&self.tasks[p.task]))
            .filter_map(|p| {
                let value = p.answer?;
                let asks = self.tasks[p.task].asks;
                let is_positive = asks.is_positive(value.into(), p.last_is_standard())?;
                Some(Answered { level: p.level?, value, is_positive })
            })
            .collect();
        self.sequences[sequence].take(&answers);
    }

    /// Whether the answer at a place is right, where something is: of two of which one holds the standard, and of nothing.
    pub(crate) fn is_right(&self, place: usize) -> Option<bool> {
        let p = self.at(place)?;
        let task = &self.tasks[p.task];
        let is_positive = task.asks.is_positive(p.answer?.into(), p.last_is_standard())?;
        let is_standard = p.level == task.standard;
        let should_be = match task.asks {
            Asks::OneOfTwo => true,
            Asks::YesNo if task.catch > 0.0 => !is_standard,
            Asks::MoreOfTwo if !is_standard => p.level > task.standard,
            Asks::YesNo | Asks::MoreOfTwo | Asks::MoreLess | Asks::Set => return None,
        };
        Some(is_positive == should_be)
    }

    /// Whether the person is to be told so.
    pub(crate) fn has_feedback(&self, place: usize) -> bool {
        self.at(place).is_some_and(|p| self.tasks[p.task].feedback)
    }

    /// What the experimenter may know of the presentation at a place: where modes are hidden, of all modes together.
    pub(crate) fn now(&self, place: usize, is_hidden: bool) -> Option<TaskNow> {
        let p = self.at(place)?;
        let task = &self.tasks[p.task];
        let all = || {
            let own = self.presentations.iter().filter(|other| other.task == p.task);
            own.filter(|other| is_hidden || other.mode == p.mode)
        };
        let mut sequences: Vec<usize> = all().map(|other| other.sequence).collect();
        sequences.sort_unstable();
        sequences.dedup();
        // Settings come one after the other, and are counted together.
        let is_together = is_hidden || matches!(task.method, Method::Adjustment { .. });
        let own = sequences.iter().filter(|own| is_together || **own == p.sequence);
        let progress = own.map(|own| self.sequences[*own].state.progress);
        let progress = progress.reduce(|sum, own| Progress {
            done: sum.done + own.done,
            of: sum.of + own.of,
            ..sum
        });
        Some(TaskNow {
            task: task.id.clone(),
            presentation: all().filter(|other| other.places.start <= p.places.start).count(),
            of: all().count(),
            is_most: matches!(task.method, Method::Staircase(_) | Method::Adjustment { .. }),
            // Of two at most: the cast cannot lose anything.
            interval: [place + 1 - p.places.start, p.places.len()].map(|n| n as u8),
            progress: progress?,
        })
    }
}
