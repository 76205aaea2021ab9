//! What the stage `thresholds` finds: the answers of tasks by presentation and by level, the curve of everybody's
//! answers, and thresholds over people. The numbers of a row are in the unit of what its task varies, which the row
//! names.

use crate::column::UNIT_OF_ROW;
use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::{named, words};
use std::sync::Arc;
use zwidth_study::{
    Contrast, EnvironmentId, MetricId, ModeId, ParticipantId, QuestionId, SessionId, Source,
    TaskQuantity,
};

words! {
    /// How the levels of a task followed each other.
    LevelMethod {
        /// Constant stimuli.
        Constant = "constant",
        /// Staircases.
        Staircase = "staircase",
        /// QUEST+.
        QuestPlus = "quest_plus",
        /// The person set the level.
        Adjustment = "adjustment",
    }
    /// Whether the answers of a person tell a threshold.
    FitVerdict {
        /// They do.
        Estimated = "estimated",
        /// It lies below the lowest level.
        Below = "outside: below the lowest level",
        /// It lies above the highest level.
        Above = "outside: above the highest level",
        /// The curve rises within less than the step between levels.
        Steep = "steep",
        /// The share of answers falls with the level.
        Falling = "falling",
        /// It does not change with the level.
        Flat = "flat",
        /// There are too few answers or levels.
        TooFew = "too few",
        /// They cannot be answers to this task.
        Refused = "refused",
    }
}

named!(TaskQuantity);

rows! {
    /// A presentation that was answered.
    Presentation = "presentations", "Presentations of tasks and their answers" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// trial after which it was answered
        trial: u32,
        /// the task
        task: QuestionId,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// presentation, counted from 1 for each task and mode
        presentation: u32,
        /// which of several sequences that take turns, from 1
        sequence: usize,
        /// unit of the level
        unit: Arc<str>,
        /// what was compared with the standard
        level: f64 = UNIT_OF_ROW,
        /// whether the answer was more, right or yes; null where a person set the level and it was right
        positive: Option<bool>,
        /// whether the sequence of levels turned there
        is_reversal: bool,
    }

    /// The answers at one level.
    LevelTally = "answers_by_level", "Answers to tasks by level" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// the task
        task: QuestionId,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// unit of the level
        unit: Arc<str>,
        /// what was compared with the standard
        level: f64 = UNIT_OF_ROW,
        /// presentations that were answered
        trials: usize,
        /// of these, more, right or yes
        positive: usize,
        /// their share
        share: f64,
    }

    /// A point of the curve that is fitted to the answers.
    FittedShare = "psychometric_curves", "Curves fitted to answers" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// the task
        task: QuestionId,
        /// how it was rendered
        mode: ModeId,
        /// unit of the level
        unit: Arc<str>,
        /// what was compared with the standard
        level: f64 = UNIT_OF_ROW,
        /// share of positive answers there
        share: f64,
    }

    /// What the answers of a person tell in one session and mode.
    PsychometricFit = "psychometric", "Psychometric functions" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// the task
        task: QuestionId,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// first trial that was answered
        trial: u32,
        /// recorded, twin or imported
        source: Source,
        /// unit of the levels
        unit: Arc<str>,
        /// how levels followed each other
        method: LevelMethod,
        /// what the threshold is: the point of subjective equality or a threshold
        quantity: TaskQuantity,
        /// whether there is one
        verdict: FitVerdict,
        /// levels that were answered
        levels: usize,
        /// the lowest of them
        lowest_level: f64 = UNIT_OF_ROW,
        /// the highest of them
        highest_level: f64 = UNIT_OF_ROW,
        /// presentations that were answered
        trials: usize,
        /// point of subjective equality, or threshold
        threshold: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        threshold_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        threshold_ci_high: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        threshold_std_error: Option<f64> = UNIT_OF_ROW,
        /// just noticeable difference
        jnd: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        jnd_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        jnd_ci_high: Option<f64> = UNIT_OF_ROW,
        /// standard error of its natural logarithm
        ln_jnd_std_error: Option<f64>,
        /// just noticeable difference over the standard
        weber_fraction: Option<f64>,
        /// m of the curve; of Weibull's the logarithm of its scale
        location: Option<f64>,
        /// σ of the curve, in the unit of the level; of Weibull's 1 over its exponent
        sigma: Option<f64>,
        /// γ, the share of positive answers far below
        guess: Option<f64>,
        /// λ, the share that is missing far above
        lapse: Option<f64>,
        /// φ, by which answers scatter more than binomial ones
        dispersion: Option<f64>,
        /// deviance of the curve
        deviance: Option<f64>,
        /// share of answers drawn from the curve that deviate as much
        deviance_p_value: Option<f64>,
        /// threshold by the posterior on psignifit's grid, where the task asks for it
        grid_threshold: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        grid_threshold_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        grid_threshold_ci_high: Option<f64> = UNIT_OF_ROW,
        /// just noticeable difference by that posterior
        grid_jnd: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        grid_jnd_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        grid_jnd_ci_high: Option<f64> = UNIT_OF_ROW,
        /// share of positive answers at which a staircase settles
        target: Option<f64>,
        /// reversals of staircases, or settings of the person
        turns: Option<usize>,
        /// whether the truth may lie beyond the bounds of the levels
        is_at_bound: bool,
        /// what is to be known of it
        remark: Option<Sentence>,
    }

    /// A threshold over people: its mean in a mode, or the difference of two modes.
    PeopleThreshold = "thresholds", "Thresholds over people" {
        /// the task
        task: QuestionId,
        /// which number of it
        quantity: TaskQuantity,
        /// the metric as which it is compared
        metric: MetricId,
        /// what was rendered
        environment: EnvironmentId,
        /// the mode, where it is a mean
        mode: Option<ModeId>,
        /// the modes compared: the one minus the other, of a JND the one over the other
        contrast: Option<Contrast>,
        /// unit; 1 of a ratio
        unit: Arc<str>,
        /// participants with it
        n: usize,
        /// mean over them; of a JND the geometric mean or the ratio
        estimate: f64 = UNIT_OF_ROW,
        /// lower end of its interval
        ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic
        statistic: Option<f64>,
        /// its degrees of freedom
        df: Option<f64>,
        /// p value of no difference
        p_value: Option<f64>,
        /// the same, adjusted over its family by Holm
        p_adjusted: Option<f64>,
        /// mean JND over the standard
        weber_fraction: Option<f64>,
        /// estimate that weighs everybody by the error of their own, in the two-level model
        weighted: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval, after Hartung and Knapp
        weighted_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        weighted_ci_high: Option<f64> = UNIT_OF_ROW,
        /// its p value
        weighted_p_value: Option<f64>,
        /// τ, by which people differ besides these errors, after Paule and Mandel; of a JND of its natural logarithm
        between_sd: Option<f64>,
        /// participants that it weighs
        weighted_n: usize,
    }
}

impl FitVerdict {
    /// Whether there is an estimate that goes on to others.
    pub fn is_estimated(self) -> bool {
        self == Self::Estimated
    }
}
