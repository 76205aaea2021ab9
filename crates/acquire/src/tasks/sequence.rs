//! One sequence of levels: of a task, a mode and a track. Which level is next follows from the plan and the answers before
//! it alone.

use zwidth_stats::StatsError;
use zwidth_stats::psychometric::adjustment::{self, Wish, Wished};
use zwidth_stats::psychometric::quest::Quest;
use zwidth_stats::psychometric::{AnsweredLevel, plans, staircase};
use zwidth_study::{Method, Task, TaskLevel};

/// A presentation that was answered and counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Answered {
    /// The level that was presented.
    pub(super) level: TaskLevel,
    /// The answer as it was given.
    pub(super) value: i16,
    /// Whether it was "more", right or "yes".
    pub(super) is_positive: bool,
}

/// How far a sequence is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Counted {
    /// Presentations.
    Presentations,
    /// Reversals of a staircase.
    Reversals,
    /// Settings.
    Settings,
}

/// How much of a sequence there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is counted.
    pub counted: Counted,
    /// So many so far.
    pub done: usize,
    /// So many until its end.
    pub of: usize,
}

/// What follows from the answers of a sequence so far.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    /// The next level; none where levels are planned, and after the end.
    pub(super) next: Option<f64>,
    /// Whether it is over before all that is planned for it.
    pub(super) is_over: bool,
    /// How far it is.
    pub(super) progress: Progress,
    /// What is to be told of it at its end.
    pub(super) remark: Option<String>,
}

/// How levels are chosen.
#[derive(Debug, Clone, PartialEq)]
enum Chooser {
    /// Levels are planned.
    Planned,
    Staircase(staircase::Staircase),
    /// With the answers that it has taken, each with the place of its level.
    Quest(Box<Quest>, Vec<(usize, bool)>),
    Adjustment(adjustment::Plan),
}

/// A sequence of levels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sequence {
    chooser: Chooser,
    /// Presentations that are planned for it.
    planned: usize,
    pub(super) state: State,
}

impl Sequence {
    /// A sequence before its first answer, of so many planned presentations; `start` is the level of the first one, where
    /// that is planned. One `like` it, of the same task, has computed already what they share.
    ///
    /// # Errors
    /// A plan that cannot be followed, in words.
    pub(super) fn new(
        task: &Task,
        track: u8,
        start: Option<TaskLevel>,
        planned: usize,
        like: Option<&Self>,
    ) -> Result<Self, String> {
        let chooser = match &task.method {
            Method::Constant { .. } => Chooser::Planned,
            Method::Staircase(plan) => {
                let one = plans::staircase(plan, track).ok_or("it has no start")?;
                Chooser::Staircase(one)
            }
            Method::QuestPlus { .. } if like.is_some_and(|like| like.quest().is_some()) => {
                let mut quest = like.and_then(Self::quest).cloned().ok_or("it has no grid")?;
                quest.restart();
                Chooser::Quest(Box::new(quest), Vec::new())
            }
            Method::QuestPlus { .. } => {
                let plan = plans::quest(task).ok_or("QUEST+ does not set levels")?;
                let quest = Quest::new(&plan).map_err(|error| error.to_string())?;
                Chooser::Quest(Box::new(quest), Vec::new())
            }
            Method::Adjustment { .. } => {
                let plan = plans::adjustment(task, track, start).ok_or("it has no starts")?;
                Chooser::Adjustment(plan)
            }
        };
        let progress = Progress { counted: Counted::Presentations, done: 0, of: planned };
        let state = State { next: None, is_over: false, progress, remark: None };
        let mut sequence = Self { chooser, planned, state };
        sequence.state = sequence.follow(&[]).map_err(|error| error.to_string())?;
        Ok(sequence)
    }

    fn quest(&self) -> Option<&Quest> {
        match &self.chooser {
            Chooser::Quest(quest, _) => Some(quest),
            Chooser::Planned | Chooser::Staircase(_) | Chooser::Adjustment(_) => None,
        }
    }

    /// Whether answers decide about its levels.
    pub(super) fn is_adaptive(&self) -> bool {
        self.chooser != Chooser::Planned
    }

    /// Takes the answers that count, in the order of their presentations. One that no plan explains ends the sequence, with
    /// a remark that says why.
    pub(super) fn take(&mut self, answers: &[Answered]) {
        self.state = self.follow(answers).unwrap_or_else(|error| State {
            next: None,
            is_over: true,
            remark: Some(error.to_string()),
            ..self.state.clone()
        });
    }

    fn follow(&mut self, answers: &[Answered]) -> Result<State, StatsError> {
        let is_all = answers.len() >= self.planned;
        let of = self.planned;
        let presented = Progress { counted: Counted::Presentations, done: answers.len(), of };
        Ok(match &mut self.chooser {
            Chooser::Planned => {
                State { next: None, is_over: false, progress: presented, remark: None }
            }
            Chooser::Staircase(plan) => {
                let track = walked(plan, answers)?;
                let (done, of) = (track.reversals.len(), plan.reversals);
                let progress = Progress { counted: Counted::Reversals, done, of };
                let no_threshold = track.threshold.is_none().then(|| {
                    format!(
                        "it ends after {} presentations with {done} of {of} reversals, without a threshold",
                        track.levels.len()
                    )
                });
                let bound = track
                    .is_at_bound
                    .then(|| "it came to a bound: the threshold may lie beyond".to_owned());
                let is_over = track.next.is_none();
                let remarks: Vec<String> = no_threshold.into_iter().chain(bound).collect();
                let remark = joined(remarks, is_over || is_all);
                State { next: track.next, is_over, progress, remark }
            }
            Chooser::Quest(quest, taken) => {
                let all: Vec<(usize, bool)> = answers
                    .iter()
                    .filter_map(|a| Some((quest.place_of(a.level.value())?, a.is_positive)))
                    .collect();
                if !all.starts_with(taken) {
                    quest.restart();
                    taken.clear();
                }
                for (place, is_positive) in &all[taken.len()..] {
                    quest.answer(*place, *is_positive)?;
                }
                *taken = all;
                let edge = is_all && quest.track().is_at_edge;
                let remark = edge.then(|| {
                    "the posterior is at an end of its grid: the truth may lie beyond".to_owned()
                });
                let next = Some(quest.next_level());
                State { next, is_over: false, progress: presented, remark }
            }
            Chooser::Adjustment(plan) => {
                let wishes: Vec<Wished> = answers.iter().map(wished).collect();
                let settings = adjustment::settings(plan, &wishes)?;
                let is_over = settings.next.is_none();
                let never = (!is_over).then(|| {
                    format!("it ends after {} presentations, and none was right", answers.len())
                });
                let bound = settings
                    .is_at_bound
                    .then(|| "it came to a bound: what is right may lie beyond".to_owned());
                let remark = joined(never.into_iter().chain(bound).collect(), is_over || is_all);
                let progress = Progress { counted: Counted::Settings, done: is_over.into(), of: 1 };
                State { next: settings.next, is_over, progress, remark }
            }
        })
    }
}

/// A staircase after answers. Where one of them was excluded, it may have ended before the last: those beyond its end were
/// given, and change nothing.
fn walked(
    plan: &staircase::Staircase,
    answers: &[Answered],
) -> Result<staircase::Track, StatsError> {
    let answers: Vec<AnsweredLevel> = answers
        .iter()
        .map(|a| AnsweredLevel { level: a.level.value(), is_positive: a.is_positive })
        .collect();
    match staircase::track_presented(plan, &answers) {
        Err(StatsError::StaircaseEnded { trials, .. }) => {
            staircase::track_presented(plan, &answers[..trials.min(answers.len())])
        }
        found => found,
    }
}

/// Remarks as one, at the end of a sequence.
fn joined(remarks: Vec<String>, is_end: bool) -> Option<String> {
    (is_end && !remarks.is_empty()).then(|| remarks.join("; "))
}

fn wished(answer: &Answered) -> Wished {
    let wish = match answer.value {
        1 => Wish::More,
        2 => Wish::Less,
        _ => Wish::Right,
    };
    Wished { level: answer.level.value(), wish }
}
