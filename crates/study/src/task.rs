//! Tasks: what can be felt, measured by answers (`[[tasks]]` of `study.toml`). One number of an environment varies; after
//! each presentation one question is asked, and thresholds are fitted to the answers by level.

use crate::words::words;
use crate::{AnswerValue, EnvironmentId, QuestionId};
use serde::{Deserialize, Serialize};

/// A level of what a task varies: a whole number of millionths of its unit, so that what is read is what was written, and
/// levels are equal or not.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct TaskLevel(i64);

impl TaskLevel {
    /// Nothing.
    pub const ZERO: Self = Self(0);

    /// Parts of the unit.
    const PARTS: f64 = 1e6;

    /// The level nearest to a value; `None` beyond ±10⁹ units, where parts of a unit are not told apart for sure.
    pub fn nearest(value: f64) -> Option<Self> {
        // Whole and within ±10¹⁵, which every f64 and i64 holds.
        (value.abs() <= 1e9).then(|| Self((value * Self::PARTS).round() as i64))
    }

    /// The level in its unit.
    pub fn value(self) -> f64 {
        self.0 as f64 / Self::PARTS
    }
}

words! {
    /// What a person is asked about what was presented.
    Asks {
        /// In which of two intervals there was more: one holds the standard. The point of subjective equality and the JND.
        #[serde(rename = "2ifc")]
        MoreOfTwo = "2ifc",
        /// Which of two intervals held the level: the other holds the standard, mostly nothing. A threshold of detection or
        /// of telling apart; answers are right or wrong.
        #[serde(rename = "2afc")]
        OneOfTwo = "2afc",
        /// Whether there was something, in one interval.
        YesNo = "yes_no",
        /// Whether it was more or less than the standard that is remembered, in one interval.
        MoreLess = "more_less",
        /// Whether it is to be more, less, or stays as it is now: the person sets the level until it is right.
        Set = "set",
    }
}

impl Asks {
    /// How many intervals a presentation has.
    pub fn intervals(self) -> u8 {
        match self {
            Self::MoreOfTwo | Self::OneOfTwo => 2,
            Self::YesNo | Self::MoreLess | Self::Set => 1,
        }
    }

    /// What may be answered, numbered from 1.
    pub fn answers(self) -> &'static [&'static str] {
        match self {
            Self::MoreOfTwo | Self::OneOfTwo => &["the first", "the second"],
            Self::YesNo => &["yes", "no"],
            Self::MoreLess => &["more", "less"],
            Self::Set => &["more", "less", "it is right"],
        }
    }

    /// Whether an answer says that there was more in the interval with the level (`2ifc`, `more_less`), is right (`2afc`),
    /// says that there was something (`yes_no`), or that the level is right (`set`). `last_is_standard`: whether the last
    /// of two intervals held the standard. `None` if that is not known, or for a number that is no answer.
    pub fn is_positive(self, value: AnswerValue, last_is_standard: Option<bool>) -> Option<bool> {
        let place = usize::try_from(value.whole()?).ok()?;
        if !(1..=self.answers().len()).contains(&place) {
            return None;
        }
        Some(match self {
            // The interval that was chosen is the one that does not hold the standard.
            Self::MoreOfTwo | Self::OneOfTwo => (place == 1) == last_is_standard?,
            Self::YesNo | Self::MoreLess => place == 1,
            Self::Set => place == 3,
        })
    }
}

/// Where a trial stands in a task. A trial is one interval; those of one presentation follow each other, and the answer
/// belongs to the last of them.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskPlace {
    /// The task, which is the question after each presentation.
    pub task: QuestionId,
    /// The presentation, counted from 1 for each task and mode.
    pub presentation: u32,
    /// Which of several sequences, from 0: interleaved staircases take turns, settings come one after the other.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub track: u8,
    /// Which interval of the presentation, from 1.
    pub interval: u8,
    /// The level that the presentation compares with the standard, where it is planned; else an event gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<TaskLevel>,
    /// Whether this interval of two holds the standard. Unknown while the session is sealed; of a presentation of one interval
    /// there is nothing to know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is_standard: Option<bool>,
}

impl TaskPlace {
    /// Whether the answer to the presentation belongs to this trial: it has the last of the intervals.
    pub fn is_last(&self, asks: Asks) -> bool {
        self.interval == asks.intervals()
    }

    /// Whether another place is of the same presentation; both of one mode.
    pub fn is_of_presentation_of(&self, other: &Self) -> bool {
        (&self.task, self.presentation) == (&other.task, other.presentation)
    }

    /// What its trial presents where `level` is compared with the standard. While the session is sealed it is not known which
    /// of two intervals holds which.
    pub fn presented(&self, task: &Task, level: TaskLevel) -> Presented {
        let level = match self.is_standard {
            Some(true) => task.standard,
            None if task.asks.intervals() > 1 => None,
            Some(false) | None => Some(level),
        };
        Presented { task: self.task.clone(), interval: self.interval, level }
    }
}

fn is_zero(track: &u8) -> bool {
    *track == 0
}

/// What a trial of a task presented, as its file has it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Presented {
    /// The task.
    pub task: QuestionId,
    /// Which interval of the presentation, from 1.
    pub interval: u8,
    /// The level in this interval, the standard's where it holds that; none in a sealed session, whose files do not tell
    /// which one it is.
    pub level: Option<TaskLevel>,
}

/// A task: an entry of `[[tasks]]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Task {
    /// Its id, and that of its question.
    pub id: QuestionId,
    /// What is asked.
    pub text: String,
    /// Which kind of question it is.
    pub asks: Asks,
    /// The environment that varies. Its trials are those of its tasks; it has no repeats besides.
    pub environment: EnvironmentId,
    /// The key of the number that varies, one of that environment: `stiffness_n_per_rad`.
    pub varies: String,
    /// The standard, in the unit of that key. Of "2afc" and "yes_no" it is what nothing is, mostly 0.
    pub standard: Option<TaskLevel>,
    /// How levels follow each other.
    pub method: Method,
    /// The share of presentations at the standard that are added to the method's: whoever says yes to nothing guesses. They
    /// have a planned level even where the method is adaptive, which does not count their answers.
    pub catch: f64,
    /// Whether the person is told what was right.
    pub feedback: bool,
    /// The function that is fitted.
    pub fit: TaskFit,
    /// How it is estimated.
    pub estimate: TaskEstimate,
}

impl Task {
    /// Presentations in each mode that are planned, without those at the standard that [`Task::catches`] adds. Where
    /// answers decide when it ends, more may be planned than are needed.
    pub fn presentations(&self) -> u64 {
        let (n, each) = match &self.method {
            Method::Constant { levels, trials } => (levels.len(), *trials),
            Method::Staircase(plan) => (plan.starts.len(), plan.most_trials),
            Method::QuestPlus { trials, .. } => (1, *trials),
            Method::Adjustment { settings, most_trials, .. } => (*settings as usize, *most_trials),
        };
        (n as u64).saturating_mul(each.into())
    }

    /// Presentations at the standard that are added in each mode: [`Task::catch`] of all.
    pub fn catches(&self) -> u64 {
        (self.presentations() as f64 * self.catch / (1.0 - self.catch)).round() as u64
    }
}

words! {
    /// How the function of a task is estimated.
    TaskEstimate {
        /// By maximum likelihood.
        Likelihood = "likelihood",
        /// The posterior on a grid, with the priors of psignifit 4, beside it.
        Grid = "grid",
    }
}

/// No axis has more values.
pub(crate) const MOST_AXIS: usize = 10_000;

/// The values of a grid's axis, from its first value, its last and its step.
pub fn axis([from, to, step]: [f64; 3]) -> Vec<f64> {
    /// Of a step: how far the last value may lie beyond the end by rounding alone.
    const ROUNDING: f64 = 1e-6;
    let steps = ((to - from) / step + ROUNDING).floor();
    // A range that is none has no steps.
    let n = if steps >= 0.0 { (steps as usize).saturating_add(1).min(MOST_AXIS) } else { 0 };
    (0..n).map(|i| from + i as f64 * step).collect()
}

/// How the levels of a task follow each other, for each mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "method", rename_all = "snake_case")]
pub enum Method {
    /// Constant stimuli: each level so many times, in an order drawn at random.
    Constant {
        /// Rising.
        levels: Vec<TaskLevel>,
        /// Presentations of each level in each mode.
        trials: u32,
    },
    /// Staircases.
    Staircase(StaircasePlan),
    /// QUEST+ (Watson 2017).
    QuestPlus {
        /// Levels that can be presented, rising.
        levels: Vec<TaskLevel>,
        /// Presentations in each mode.
        trials: u32,
        /// From, to and step of the threshold, in the unit of the level.
        pse: [f64; 3],
        /// From, to and step of σ.
        sigma: [f64; 3],
        /// From, to and step of λ.
        lapse: [f64; 3],
    },
    /// The person sets the level, from starts that alternate below and above.
    Adjustment {
        /// The lowest and the highest start.
        starts: [TaskLevel; 2],
        /// From a level to the next.
        step: TaskLevel,
        /// The lowest and the highest level.
        bounds: [TaskLevel; 2],
        /// Settings in each mode: the tracks, one after the other.
        settings: u32,
        /// Presentations after which a setting ends without having been right.
        most_trials: u32,
    },
}

/// Staircases of a task, in steps of the level's unit or of its logarithm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaircasePlan {
    /// Wrong answers in a row before a step up.
    pub up_after: u8,
    /// Right answers in a row before a step down.
    pub down_after: u8,
    /// Where it starts: one level for each of the staircases that take turns.
    pub starts: Vec<TaskLevel>,
    /// The step up: in the unit of the level, or a factor above 1 where `is_factor`.
    pub up: f64,
    /// The step down, as `up`.
    pub down: f64,
    /// Whether steps are factors.
    pub is_factor: bool,
    /// The lowest and the highest level.
    pub bounds: [TaskLevel; 2],
    /// Reversals after which one ends.
    pub reversals: u32,
    /// The threshold is the mean of so many of the last ones.
    pub of_last: u32,
    /// Presentations after which one ends without them.
    pub most_trials: u32,
}

words! {
    /// The shape of a psychometric function.
    TaskSigmoid {
        /// The normal distribution function.
        Norm = "norm",
        /// The logistic function.
        Logistic = "logistic",
        /// Weibull's distribution function, of levels above 0.
        Weibull = "weibull",
    }
}

/// What is fitted to a task's answers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TaskFit {
    /// The shape.
    pub sigmoid: TaskSigmoid,
    /// Within what the share of lapses lies.
    pub lapse: [f64; 2],
}

impl Default for TaskFit {
    fn default() -> Self {
        Self { sigmoid: TaskSigmoid::Norm, lapse: [0.0, 0.06] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_has_both_of_its_ends_where_steps_reach_them() {
        assert_eq!(axis([0.0, 0.06, 0.02]).len(), 4);
        assert_eq!(axis([1.0, 1.0, 1.0]), [1.0]);
        assert_eq!(axis([1.0, 2.9, 1.0]), [1.0, 2.0]);
        assert_eq!([axis([2.0, 1.0, 1.0]).len(), axis([0.0, f64::NAN, 1.0]).len()], [0, 0]);
        assert_eq!(axis([0.0, 1.0, 0.0]).len(), MOST_AXIS);
    }

    #[test]
    fn an_answer_is_positive_by_the_interval_that_it_chooses() {
        let of = |asks: Asks, value: i16, last| asks.is_positive(value.into(), last);
        for asks in [Asks::MoreOfTwo, Asks::OneOfTwo] {
            assert_eq!(of(asks, 1, Some(true)), Some(true));
            assert_eq!(of(asks, 2, Some(true)), Some(false));
            assert_eq!(of(asks, 1, Some(false)), Some(false));
            assert_eq!(of(asks, 2, Some(false)), Some(true));
            assert_eq!(of(asks, 1, None), None);
        }
        for asks in [Asks::YesNo, Asks::MoreLess] {
            assert_eq!([1, 2].map(|value| of(asks, value, None)), [Some(true), Some(false)]);
        }
        let set = [1, 2, 3].map(|value| of(Asks::Set, value, None));
        assert_eq!(set, [Some(false), Some(false), Some(true)]);
        assert_eq!([of(Asks::Set, 0, None), of(Asks::YesNo, 3, None)], [None; 2]);
    }

    #[test]
    fn a_level_is_the_nearest_millionth_and_nothing_else() {
        let of = |value: f64| TaskLevel::nearest(value);
        assert_eq!(of(0.1 + 0.2), of(0.3));
        assert_eq!(of(4.000_000_4).map(TaskLevel::value), Some(4.0));
        assert_eq!(of(-2.5).map(TaskLevel::value), Some(-2.5));
        assert_eq!([of(f64::NAN), of(f64::INFINITY), of(2e9)], [None; 3]);
    }
}
