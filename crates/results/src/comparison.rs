//! What the stage `compare` finds: modes, participants, sessions and repeats compared, one metric
//! at a time. The numbers of a row are in the unit of its metric, which the row names.

use crate::column::UNIT_OF_ROW;
use crate::note::NoteKind;
use crate::row::{of_metric, rows};
use crate::sentence::Sentence;
use crate::value::{named, texts, words};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{
    Better, Contrast, EnvironmentId, IdError, MetricId, ModeId, ParticipantId, QuestionId,
    SessionId, TaskQuantity,
};

words! {
    /// What a study says of a metric that it compares.
    Role {
        /// The metric whose claims count.
        Primary = "primary",
        /// Any other.
        Exploratory = "exploratory",
        /// One that another program computed and that no study.toml named before the data.
        ChosenAfter = "exploratory, chosen after the data",
    }
    /// What the tests of a difference show.
    Verdict {
        /// There is a difference, and nothing says that it is too small to matter.
        Different = "different",
        /// There is a difference, and it is too small to matter.
        DifferentBelowBound = "different, within the bound",
        /// No difference was found, and if there is one it is too small to matter.
        Equivalent = "equivalent",
        /// Neither was shown.
        Undecided = "undecided",
        /// There is no test.
        NotTested = "not tested",
    }
    /// How it was tested whether any mode differs from another.
    AnswerTest {
        /// By draws from the model without modes.
        Bootstrap = "bootstrap",
        /// By the likelihood ratio over F.
        F = "F",
    }
    /// A program that compares modes, by the call that is usual.
    Program {
        /// The paired differences, on which claims rest.
        Zwidth = "zwidth",
        /// The mixed model beside them.
        ZwidthModel = "zwidth, mixed model",
        /// R's lmerTest with a random effect of participant.
        LmerTest = "lmerTest",
        /// The same with one of participant × mode.
        LmerTestModes = "lmerTest, with participant:mode",
        /// That model by R's pbkrtest.
        Pbkrtest = "pbkrtest, with participant:mode",
        /// That model by R's emmeans.
        Emmeans = "emmeans, with participant:mode",
        /// Python's statsmodels.
        Statsmodels = "statsmodels",
        /// Python's pingouin.
        Pingouin = "pingouin",
        /// Python's pyfixest.
        Pyfixest = "pyfixest",
        /// The same with errors clustered by participant.
        PyfixestClustered = "pyfixest, clustered",
    }
    /// What a statistic is referred to.
    Distribution {
        /// Student's t.
        T = "t",
        /// The normal distribution.
        Normal = "normal",
        /// The Studentised range.
        StudentisedRange = "Studentised range",
    }
    /// What an effect size is.
    EffectKind {
        /// g_av.
        GAv = "g_av",
        /// g_av with an approximation in the place of J.
        GAvApproximate = "g_av, J = 1 − 3 / (8 n − 9)",
        /// The difference in standard deviations of the residual.
        ResidualDeviations = "difference / residual SD",
    }
    /// What an interval says of whether a difference is felt: a description, no claim.
    Size {
        /// All of it is beyond one just noticeable difference.
        Felt = "felt",
        /// All of it is within one.
        BelowWhatIsFelt = "below what is felt",
        /// Neither.
        MayBeFelt = "may be felt",
    }
}

impl Role {
    /// How a sentence about findings begins that carry no claim.
    pub fn of_findings(self) -> &'static str {
        match self {
            Self::Primary | Self::Exploratory => "Exploratory",
            Self::ChosenAfter => "Chosen after the data",
        }
    }
}

/// What the two sides of a difference are. Of logarithms a difference of values is a ratio, and one of differences how
/// many times as large a ratio is as another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// Values of a metric, or means of them.
    Values,
    /// Differences themselves: of an interaction, or where groups are compared in a difference.
    Differences,
}

impl ModeDifference {
    /// The mode that is better, where a difference was shown and one way is better. Lower is nearer to
    /// zero: of means of two signs, whose magnitudes were not tested, neither is better. Of logarithms, which are below
    /// zero where what they are of is below 1, it is lower.
    pub fn best(&self, better: Better) -> Option<&ModeId> {
        let (first, second) = (self.mean_first, self.mean_second);
        let is_first = match better {
            _ if !self.verdict.is_different() => return None,
            Better::Lower if TaskQuantity::logarithm_of(&self.unit).is_some() => first < second,
            Better::Lower if first * second >= 0.0 => first.abs() < second.abs(),
            Better::Higher => first > second,
            Better::Lower | Better::Neither => return None,
        };
        Some(if is_first { &self.contrast.mode } else { &self.contrast.against })
    }
}

impl Verdict {
    /// Whether a difference was shown.
    pub fn is_different(self) -> bool {
        matches!(self, Self::Different | Self::DifferentBelowBound)
    }
}

/// What n counts, and whom a sentence may speak of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnitOfAnalysis {
    /// Participants: repeats and sessions are averaged within each.
    Participants,
    /// The trials of the only participant: nothing is said of anybody else.
    TrialsOf(ParticipantId),
}

/// How the trials of one participant are named, before the participant.
const TRIALS_OF: &str = "trials of ";

impl fmt::Display for UnitOfAnalysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Participants => f.pad("participants"),
            Self::TrialsOf(who) => write!(f, "{TRIALS_OF}{who}"),
        }
    }
}

impl FromStr for UnitOfAnalysis {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        match text.strip_prefix(TRIALS_OF) {
            Some(who) => Ok(Self::TrialsOf(who.parse()?)),
            None => Ok(Self::Participants),
        }
    }
}

/// Two sessions of one participant: `later` − `earlier`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SessionPair {
    /// The one that is compared.
    pub later: SessionId,
    /// The one that it is compared with.
    pub earlier: SessionId,
}

impl fmt::Display for SessionPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.later, Contrast::MINUS, self.earlier)
    }
}

impl FromStr for SessionPair {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let (later, earlier) = text.split_once(Contrast::MINUS).unwrap_or((text, ""));
        Ok(Self { later: later.parse()?, earlier: earlier.parse()? })
    }
}

/// An effect to which a test over orders is sensitive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Any difference between modes.
    Any,
    /// The difference of two.
    Of(Contrast),
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.pad("any effect"),
            Self::Of(contrast) => contrast.fmt(f),
        }
    }
}

impl FromStr for Effect {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        match text == Self::Any.to_string() {
            true => Ok(Self::Any),
            false => text.parse().map(Self::Of),
        }
    }
}

texts!(UnitOfAnalysis, SessionPair, Effect);
named!(Better);

rows! {
    /// A metric that is compared.
    Compared = "compared", "Metrics that are compared" {
        /// the metric
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what it is, in words
        words: String,
        /// whether claims rest on it
        role: Role,
        /// which values of it are better
        better: Better,
        /// what n counts
        unit_of_analysis: UnitOfAnalysis,
    }

    /// The repeats of one participant in one session, environment and mode.
    Cell = "cells", "By participant, session and condition" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// trials that count
        trials: usize,
        /// trials that have the metric
        n: usize,
        /// mean of these trials
        mean: Option<f64> = UNIT_OF_ROW,
        /// standard deviation of these trials
        sd: Option<f64> = UNIT_OF_ROW,
    }

    /// A condition's mean over the units of analysis.
    Mean = "means", "Means by condition" {
        ..of_metric,
        /// how it was rendered
        mode: ModeId,
        /// what n counts
        unit_of_analysis: UnitOfAnalysis,
        /// units of analysis
        n: usize,
        /// trials that count
        trials: usize,
        /// trials that have the metric
        trials_with_value: usize,
        /// mean over the units
        mean: f64 = UNIT_OF_ROW,
        /// standard deviation of the units
        sd: Option<f64> = UNIT_OF_ROW,
        /// lower end of the mean's interval
        ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of the mean's interval
        ci_high: Option<f64> = UNIT_OF_ROW,
    }

    /// The difference of two modes in one environment, tested.
    ModeDifference = "contrasts", "Modes compared" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// what n counts
        unit_of_analysis: UnitOfAnalysis,
        /// units of analysis
        n: usize,
        /// sessions per participant, at most
        sessions: Option<usize>,
        /// mean in the contrast's first mode
        mean_first: f64 = UNIT_OF_ROW,
        /// mean in the contrast's second mode
        mean_second: f64 = UNIT_OF_ROW,
        /// mean difference
        difference: f64 = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic; none of one participant's trials
        statistic: Option<f64>,
        /// degrees of freedom of the interval
        df: Option<f64>,
        /// p value of no difference, by t; none of one participant's trials
        p_value: Option<f64>,
        /// p value of the claim (by t over participants, by orders of one participant's trials), adjusted over its family by Holm
        p_adjusted: Option<f64>,
        /// the smallest adjusted p value that the design's orders reach, where the claim rests on them
        smallest_p_adjusted: Option<f64>,
        /// d_av without its bias where people are few
        g_av: Option<f64>,
        /// difference over the root mean of the modes' variances between participants
        d_av: Option<f64>,
        /// lower end of the interval of d_av
        d_av_ci_low: Option<f64>,
        /// upper end of the interval of d_av
        d_av_ci_high: Option<f64>,
        /// d_z without its bias where people are few
        g_z: Option<f64>,
        /// difference over the standard deviation of participants' differences
        d_z: Option<f64>,
        /// lower end of the interval of d_z
        d_z_ci_low: Option<f64>,
        /// upper end of the interval of d_z
        d_z_ci_high: Option<f64>,
        /// p value of the sign-flip test, not adjusted
        p_sign_flip: Option<f64>,
        /// p value of the signed-rank test, not adjusted
        p_signed_rank: Option<f64>,
        /// p value of no trial depending on mode (randomisation over orders), not adjusted
        p_sharp_null: Option<f64>,
        /// value that the environment commands
        commanded: Option<f64> = UNIT_OF_ROW,
        /// difference that is just noticed
        jnd: Option<f64> = UNIT_OF_ROW,
        /// difference over the one that is just noticed
        difference_jnd: Option<f64>,
        /// lower end of its interval
        difference_jnd_ci_low: Option<f64>,
        /// upper end of its interval
        difference_jnd_ci_high: Option<f64>,
        /// whether the interval is of differences that are felt, no claim
        size: Option<Size>,
        /// differences up to this size are equivalent
        bound: Option<f64> = UNIT_OF_ROW,
        /// p value of a difference beyond the bound (TOST)
        p_not_equivalent: Option<f64>,
        /// what the tests show
        verdict: Verdict,
        /// why there is no test, or no claim
        remark: Option<Sentence>,
    }

    /// The difference of two modes as a paper prints it.
    PrintedDifference = "comparison", "Modes compared in every metric" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// what n counts
        unit_of_analysis: UnitOfAnalysis,
        /// units of analysis
        n: usize,
        /// mean in the contrast's first mode
        mean_first: f64 = UNIT_OF_ROW,
        /// mean in the contrast's second mode
        mean_second: f64 = UNIT_OF_ROW,
        /// mean difference
        difference: f64 = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic
        statistic: Option<f64>,
        /// degrees of freedom
        df: Option<f64>,
        /// p value, adjusted by Holm over the metric's family
        p_adjusted: Option<f64>,
        /// d_av without its bias where people are few
        g_av: Option<f64>,
        /// d_z without its bias where people are few
        g_z: Option<f64>,
        /// difference over the root mean of the modes' variances between participants
        d_av: Option<f64>,
        /// difference over the standard deviation of participants' differences
        d_z: Option<f64>,
        /// difference over the one that is just noticed
        difference_jnd: Option<f64>,
        /// what the tests show
        verdict: Verdict,
        /// why there is no test, or no claim
        remark: Option<Sentence>,
        /// whether the interval is of differences that are felt, no claim
        size: Option<Size>,
    }

    /// Whether any mode differs from another, over complete participants.
    Omnibus = "omnibus", "Any difference between modes" {
        /// what is compared
        metric: MetricId,
        /// what was rendered
        environment: EnvironmentId,
        /// modes in which the metric is there
        modes: usize,
        /// participants who have it in all of these
        n: usize,
        /// Friedman's χ², ties corrected
        friedman: Option<f64>,
        /// Kendall's W: 0 no common order, 1 all alike
        kendall_w: Option<f64>,
        /// p value of no common order
        p_friedman: Option<f64>,
        /// F of the repeated-measures analysis of variance
        f: Option<f64>,
        /// its degrees of freedom
        df_modes: Option<f64>,
        /// its degrees of freedom for error
        df_error: Option<f64>,
        /// its p value, where differences of all pairs scatter alike
        p_f: Option<f64>,
        /// Greenhouse–Geisser ε
        epsilon_gg: Option<f64>,
        /// p value with it
        p_gg: Option<f64>,
        /// Huynh–Feldt ε
        epsilon_hf: Option<f64>,
        /// p value with it
        p_hf: Option<f64>,
        /// how p was found, and why a test is missing
        remark: Option<Sentence>,
    }

    /// The difference of two modes by the mixed model of its environment.
    Model = "models", "Mixed model (for comparison)" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// participants
        n: Option<usize>,
        /// trials
        trials: usize,
        /// mean difference
        difference: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// degrees of freedom (Kenward–Roger)
        df: Option<f64>,
        /// p value of no difference, not adjusted
        p_value: Option<f64>,
        /// degrees of freedom (Satterthwaite)
        df_satterthwaite: Option<f64>,
        /// p value with those
        p_satterthwaite: Option<f64>,
        /// standard deviation of participants
        participant_sd: Option<f64> = UNIT_OF_ROW,
        /// standard deviation of participants' own effects of a mode
        participant_mode_sd: Option<f64> = UNIT_OF_ROW,
        /// standard deviation of repeats
        residual_sd: Option<f64> = UNIT_OF_ROW,
        /// what is random beside the residual
        random_terms: Option<String>,
        /// whether a variance was estimated as zero (pooled at the bound)
        singular: Option<bool>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// The difference of two modes as a program prints it.
    ProgramDifference = "peers", "The same differences by other programs" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// the program
        program: Program,
        /// participants whose trials it uses
        n: Option<usize>,
        /// trials
        trials: Option<usize>,
        /// participants with a value who are left out
        left_out: Option<String>,
        /// mean difference
        difference: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// the difference divided by its standard error
        statistic: Option<f64>,
        /// what the statistic is referred to
        distribution: Option<Distribution>,
        /// degrees of freedom; none of the normal distribution, which are infinite
        df: Option<f64>,
        /// p value of no difference
        p_value: Option<f64>,
        /// the effect size that is printed beside
        effect_size: Option<f64>,
        /// what that is
        effect: Option<EffectKind>,
        /// why it differs, or why there is no number
        why: Sentence,
    }

    /// One participant's own difference between two modes.
    PersonDifference = "participants", "Participants compared" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// who
        participant: ParticipantId,
        /// sessions that have both modes
        sessions: usize,
        /// trials of the contrast's first mode
        trials_first: usize,
        /// trials of its second mode
        trials_second: usize,
        /// this participant's mean difference
        difference: f64 = UNIT_OF_ROW,
        /// its standard error within this participant, repeats as units (Welch)
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval within this participant
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval within this participant
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
    }

    /// How participants changed from one session to a later one in a condition.
    SessionChange = "sessions", "Sessions compared" {
        ..of_metric,
        /// how it was rendered
        mode: ModeId,
        /// the sessions compared: the later minus the earlier
        sessions: SessionPair,
        /// participants with both sessions
        n: usize,
        /// mean in the later session
        mean_later: f64 = UNIT_OF_ROW,
        /// mean in the earlier session
        mean_earlier: f64 = UNIT_OF_ROW,
        /// mean change
        change: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        change_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        change_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        change_ci_high: Option<f64> = UNIT_OF_ROW,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no change, not adjusted
        p_value: Option<f64>,
        /// lower limit of agreement of single changes (Bland–Altman)
        limit_low: Option<f64> = UNIT_OF_ROW,
        /// upper limit of agreement
        limit_high: Option<f64> = UNIT_OF_ROW,
        /// ICC(A,1) [ICC(2,1)]: absolute agreement of single sessions
        icc_a1: Option<f64>,
        /// lower end of its interval
        icc_a1_ci_low: Option<f64>,
        /// upper end of its interval
        icc_a1_ci_high: Option<f64>,
        /// ICC(C,1) [ICC(3,1)]: consistency of single sessions
        icc_c1: Option<f64>,
        /// ICC(A,k) [ICC(2,k)]: absolute agreement of their means
        icc_ak: Option<f64>,
        /// ICC(C,k) [ICC(3,k)]: consistency of their means
        icc_ck: Option<f64>,
        /// standard error of measurement
        sem: Option<f64> = UNIT_OF_ROW,
        /// minimal detectable change, 95 %
        mdc: Option<f64> = UNIT_OF_ROW,
        /// ICC(A,1) [ICC(2,1)] of all sessions of the condition together
        icc_a1_all: Option<f64>,
        /// lower end of its interval
        icc_a1_all_ci_low: Option<f64>,
        /// upper end of its interval
        icc_a1_all_ci_high: Option<f64>,
        /// standard error of measurement of all sessions together
        sem_all: Option<f64> = UNIT_OF_ROW,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// How a metric changes from one repeat of a condition to the next.
    Learning = "learning", "Learning per repeat" {
        ..of_metric,
        /// how it was rendered
        mode: ModeId,
        /// what n counts
        unit_of_analysis: UnitOfAnalysis,
        /// units of analysis
        n: usize,
        /// mean change from one repeat to the next
        change: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        change_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        change_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        change_ci_high: Option<f64> = UNIT_OF_ROW,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no change, not adjusted
        p_value: Option<f64>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// The mean at a repeat of a condition, over participants.
    RepeatMean = "repeats", "By repeat" {
        ..of_metric,
        /// how it was rendered
        mode: ModeId,
        /// repeat of the condition
        repeat: u32,
        /// participants
        n: usize,
        /// mean over participants
        mean: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        ci_high: Option<f64> = UNIT_OF_ROW,
    }

    /// A difference between modes against other orders of the trials.
    OrderTest = "orders", "Randomised orders" {
        /// what is compared
        metric: MetricId,
        /// what was rendered
        environment: EnvironmentId,
        /// the effect to which the test is sensitive
        effect: Effect,
        /// sessions whose orders are redrawn
        sessions: usize,
        /// trials that have the metric
        trials: usize,
        /// p value of the sharp null, not adjusted
        p_value: Option<f64>,
        /// the smallest that the design's orders reach
        smallest_p: Option<f64>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// A difference of two modes' means in redrawn orders: each row is a hundredth of them.
    RedrawnDifference = "redrawn", "Differences in redrawn orders" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// difference of the modes' means in redrawn orders: each row is a hundredth of them
        difference: f64 = UNIT_OF_ROW,
    }

    /// The answers to a question after trials in two modes of an environment, compared.
    AnswerDifference =
        "answers_compared",
        "Answers compared: effects over participants, odds ratios for one person"
    {
        /// the question
        question: QuestionId,
        /// what was rendered
        environment: EnvironmentId,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// participants with both modes
        n: Option<usize>,
        /// answers
        answers: usize,
        /// P(A > B) + ½ P(A = B), mean over participants: ½ where neither is above the other
        superiority: Option<f64>,
        /// lower end of its interval over participants
        superiority_ci_low: Option<f64>,
        /// upper end of its interval over participants
        superiority_ci_high: Option<f64>,
        /// odds of a higher answer, for one person
        odds_ratio: Option<f64>,
        /// lower end of its profile interval; none: see remark
        odds_ratio_ci_low: Option<f64>,
        /// upper end; none: see remark
        odds_ratio_ci_high: Option<f64>,
        /// p value of an odds ratio of one (likelihood ratio over F)
        p_value: Option<f64>,
        /// the same, adjusted over the question by Holm
        p_adjusted: Option<f64>,
        /// p value of no difference between any modes
        p_any: Option<f64>,
        /// how that was found
        test_any: Option<AnswerTest>,
        /// why there is no model or odds ratio, or an end of its interval is missing
        remark: Option<Sentence>,
        /// what the contrast is tested by
        model: Option<String>,
        /// mean difference, points of the scale
        difference: Option<f64>,
        /// lower end of its interval
        difference_ci_low: Option<f64>,
        /// upper end of its interval
        difference_ci_high: Option<f64>,
    }

    /// One participant's answers after trials in two modes, compared.
    PersonSuperiority = "answers_participants", "Answers compared: each participant's effect" {
        /// the question
        question: QuestionId,
        /// what was rendered
        environment: EnvironmentId,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// who
        participant: ParticipantId,
        /// P(A > B) + ½ P(A = B) over the pairs of this participant's answers
        superiority: f64,
    }

    /// What is said below the rows of a metric.
    MetricNote = "notes", "What is said below the rows of a metric" {
        /// the metric
        metric: MetricId,
        /// the table below which it stands
        table: String,
        /// what it is about
        kind: NoteKind,
        /// the note
        note: Sentence,
    }
}
