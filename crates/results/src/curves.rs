//! What the stage `compare` finds about whole curves. The values of a row are in the unit of its curve, which
//! the row names.

use crate::average::LoopBranch;
use crate::column::UNIT_OF_ROW;
use crate::comparison::{Role, Verdict};
use crate::groups::GroupEffect;
use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::named;
use std::sync::Arc;
use zwidth_study::{Curve, EnvironmentId, GroupContrast, ParticipantId};

named!(Curve);

/// How files name what is over several environments, in place of an environment: no id has a dot.
pub const OVER_SEVERAL: &str = "several.environments";

rows! {
    /// A node of a compared curve.
    CurveNode = "curves", "Curves compared" {
        /// what is compared
        curve: Curve,
        /// unit of its values
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what is compared of people: a difference between modes, an effect; between groups also a mode or
        /// the mean over modes
        effect: GroupEffect,
        /// the groups compared: the one minus the other; null of everybody
        groups: Option<GroupContrast>,
        /// in: onset to reversal; out: return to end; null over time
        branch: Option<LoopBranch>,
        /// angle of the node
        theta_rad: Option<f64> = "rad",
        /// its time since movement onset
        t_s: Option<f64> = "s",
        /// mean in the first mode or group; of an effect the sum of positive weight
        mean_first: f64 = UNIT_OF_ROW,
        /// mean in the second, which is taken from it
        mean_second: f64 = UNIT_OF_ROW,
        /// mean difference over participants
        difference: f64 = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: f64 = UNIT_OF_ROW,
        /// t statistic; null where participants do not scatter
        statistic: Option<f64>,
        /// lower end of the band, or of the pointwise interval where there is no band
        band_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of the band, or of the pointwise interval where there is no band
        band_high: Option<f64> = UNIT_OF_ROW,
    }

    /// The test of a whole curve.
    CurveDifference = "curve_tests", "Tests of whole curves" {
        /// what is compared
        curve: Curve,
        /// unit of its values
        unit: Arc<str>,
        /// whether its claims count
        role: Role,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what is compared of people: a difference between modes, an effect; between groups also a mode or
        /// the mean over modes
        effect: GroupEffect,
        /// the groups compared: the one minus the other; null of everybody
        groups: Option<GroupContrast>,
        /// the one participant whose trials are compared; null of several
        within: Option<ParticipantId>,
        /// participants, of the first group; trials of the one participant
        n: usize,
        /// participants of the second group
        n_second: Option<usize>,
        /// nodes tested, of all branches
        nodes: usize,
        /// nodes left out, at which participants do not scatter
        left_out: usize,
        /// the t of largest magnitude
        largest_t: Option<f64>,
        /// the branch on which it is
        branch: Option<LoopBranch>,
        /// the angle at which it is
        theta_rad: Option<f64> = "rad",
        /// the time at which it is
        t_s: Option<f64> = "s",
        /// the difference there
        difference: Option<f64> = UNIT_OF_ROW,
        /// what the largest |t| of a curve exceeds by chance as often as the level of intervals allows
        critical_t: Option<f64>,
        /// half the width of the band in standard errors; null where intervals are pointwise
        band_t: Option<f64>,
        /// p value of no difference anywhere: signs flipped, of groups labels permuted, of one participant orders redrawn
        p_value: Option<f64>,
        /// the smallest that it can be
        smallest_p: Option<f64>,
        /// p value adjusted after Holm within its family
        p_adjusted: Option<f64>,
        /// p value by the largest mean, not divided by its standard error
        p_unstudentised: Option<f64>,
        /// median over nodes of the |skewness| of participants' differences
        skewness: Option<f64>,
        /// whether there is a difference somewhere
        verdict: Option<Verdict>,
        /// why something is missing or not claimed
        remark: Option<Sentence>,
    }

    /// Neighbouring nodes of a curve whose |t| exceeds the pointwise critical value.
    CurveRun = "curve_runs", "Runs of large t on curves" {
        /// what is compared
        curve: Curve,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what is compared of people
        effect: GroupEffect,
        /// in: onset to reversal; out: return to end; null over time
        branch: Option<LoopBranch>,
        /// smallest angle of its nodes
        theta_low_rad: Option<f64> = "rad",
        /// largest angle of its nodes
        theta_high_rad: Option<f64> = "rad",
        /// earliest time of its nodes
        begins_s: Option<f64> = "s",
        /// latest time of its nodes
        ends_s: Option<f64> = "s",
        /// how many nodes
        nodes: usize,
        /// sum of |t| over them
        mass: f64,
        /// share of flips of signs whose largest run has that mass or more
        p_value: f64,
    }
}
