//! What the stage `trade` finds: the error and the work of every solver at every step on a scene,
//! what is recommended, and the effect of fewer recorded data or another setup on a study's
//! metrics.

use crate::row::rows;
use crate::value::{NoSuchText, texts, words, written};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

words! {
    /// What keeps a setting from being recommended: the first that holds, in this order.
    Gate {
        /// Nothing: a person could not tell the run from the right one.
        Passed = "passed",
        /// The verdict: it failed, is unstable, chatters, creeps, or is not known; or it does not
        /// show what the model does.
        Verdict = "verdict",
        /// The slow part of the force.
        Force = "force",
        /// The slow part of the angle.
        Angle = "angle",
        /// A vibration, or no stretch that is calm enough to compare it.
        Vibration = "vibration",
    }
    /// How far the right answer is proven.
    Proof {
        /// Two independent solvers agree to 1e-9 rad and 1e-9 s.
        Proven = "proven",
        /// They agree, but for times of events to 3.2e-5 s: something is grazed.
        Grazing = "proven, times to 3.2e-5 s (grazing)",
        /// They do not: nothing is recommended.
        Unproven = "unproven",
    }
    /// What is taken from a recording, or set otherwise on the simulated device.
    LessKind {
        /// Nothing.
        AsItIs = "as it is",
        /// Samples.
        Samples = "fewer samples",
        /// The rate of the loop.
        Rate = "another rate",
        /// Bits of the angle.
        Angle = "a coarser angle",
        /// Values of the force.
        Force = "a slower force",
        /// The velocity's filter.
        Filter = "another filter",
    }
}

/// Why a cheaper setting is not recommended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhyNot {
    /// It does not pass this gate.
    Breaks(Gate),
    /// It passes, but a finer one of its solver does not pass this gate: it passes by chance.
    FinerBreaks(Gate),
    /// It passes here, but only on so many neighbours of the scene.
    Neighbours(usize),
}

/// What stands before and behind the number of neighbours.
const NEIGHBOURS: [&str; 2] = ["it passes on ", " of the scene's neighbours only"];

impl fmt::Display for WhyNot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [before, behind] = NEIGHBOURS;
        match self {
            Self::Breaks(gate) => write!(f, "it breaks the bound of the {}", gate.as_str()),
            Self::FinerBreaks(gate) => write!(
                f,
                "a finer one breaks the bound of the {}, so that it meets it by chance",
                gate.as_str()
            ),
            Self::Neighbours(n) => write!(f, "{before}{n}{behind}"),
        }
    }
}

impl FromStr for WhyNot {
    type Err = NoSuchText;

    fn from_str(text: &str) -> Result<Self, NoSuchText> {
        let [before, behind] = NEIGHBOURS;
        let number = text.strip_prefix(before).and_then(|rest| rest.strip_suffix(behind));
        let neighbours = number.and_then(|number| number.parse().ok()).map(Self::Neighbours);
        let of_gates =
            Gate::ALL.iter().flat_map(|gate| [Self::Breaks(*gate), Self::FinerBreaks(*gate)]);
        written(text, "reason of a trade", neighbours.into_iter().chain(of_gates))
    }
}

texts!(WhyNot);

/// A run beside others: what chattering looks like. It has thousands of samples, and so it is no
/// row.
#[derive(Debug, Clone, PartialEq)]
pub struct TradeRun {
    /// The solver.
    pub solver: Arc<str>,
    /// Its step, s; none for one that finds events.
    pub step_s: Option<f64>,
    /// Changes of the way of moving.
    pub motion_changes: usize,
    /// Times, s.
    pub t_s: Vec<f64>,
    /// The lever's angle at each, rad.
    pub theta_rad: Vec<f64>,
}

rows! {
    /// A setting on a scene: a solver with its step or tolerance, how far its run is from the right
    /// one, and what it costs. Counts and errors are null where the run failed.
    TradeSetting = "trade", "Speed against accuracy" {
        /// the scene
        scene: Arc<str>,
        /// which actuators render
        mode: Arc<str>,
        /// what stands between the user's force and the lever
        model: Arc<str>,
        /// the solver
        solver: Arc<str>,
        /// its step
        step_s: Option<f64> = "s",
        /// its relative error per step
        tolerance: Option<f64>,
        /// what the run is worth
        verdict: Arc<str>,
        /// the first bound that it breaks, or passed
        gate: Gate,
        /// largest error of the angle
        theta_error_max_rad: Option<f64> = "rad",
        /// root mean square of it
        theta_error_rms_rad: Option<f64> = "rad",
        /// largest error of the velocity
        theta_dot_error_max_rad_s: Option<f64> = "rad/s",
        /// root mean square of it
        theta_dot_error_rms_rad_s: Option<f64> = "rad/s",
        /// largest error of the device's force
        force_error_max_n: Option<f64> = "N",
        /// root mean square of it
        force_error_rms_n: Option<f64> = "N",
        /// error of its integral over the run
        impulse_error_ns: Option<f64> = "N s",
        /// largest error of the times of events
        event_error_s: Option<f64> = "s",
        /// error of the largest angle
        peak_error_rad: Option<f64> = "rad",
        /// slow force: error over what is felt
        felt_force_share: Option<f64>,
        /// slow angle: error over what is felt
        felt_angle_share: Option<f64>,
        /// vibration above the right one, over what is felt
        felt_vibration_share: Option<f64>,
        /// centre of that third octave
        vibration_hz: Option<f64> = "Hz",
        /// its amplitude at the lever's end
        vibration_m: Option<f64> = "m",
        /// sign changes of the velocity between samples
        reversals: Option<usize>,
        /// of an oscillation, 0 for fewer than six
        swings: Option<usize>,
        /// median of half a swing's angle
        swing_amplitude_rad: Option<f64> = "rad",
        /// longest way in a stretch in which the lever should stand
        creep_rad: Option<f64> = "rad",
        /// steps, or exact pieces
        steps: Option<u64>,
        /// steps rejected
        rejected: Option<u64>,
        /// of the right-hand side
        evaluations: Option<u64>,
        /// or exponentials
        factorisations: Option<u64>,
        /// all of it in evaluations
        work: Option<u64>,
        /// no other setting has less work and less error of the angle
        on_front: bool,
        /// the study's metric that changes most, over what is just felt
        metric: Option<Arc<str>>,
        /// its change over what is just felt
        metric_share: Option<f64>,
        /// metrics that change by more than is just felt
        metrics_felt: Option<usize>,
        /// metrics that this run or the right one lacks
        metrics_lost: Option<usize>,
    }

    /// A scene: how far its yardstick is proven, and what is recommended and why.
    TradeChoice = "trade_summary", "Speed against accuracy" {
        /// the scene
        scene: Arc<str>,
        /// which actuators render
        mode: Arc<str>,
        /// what stands between the user's force and the lever
        model: Arc<str>,
        /// whether two solvers agree to 1e-9 rad and 1e-9 s
        yardstick: Proof,
        /// the solver of the yardstick
        by: Arc<str>,
        /// the one that it is compared with
        against: Arc<str>,
        /// largest difference of their angles
        apart_rad: Option<f64> = "rad",
        /// that of their events
        apart_s: Option<f64> = "s",
        /// how often the lever changes its way of moving
        motion_changes: usize,
        /// the solver that is recommended
        solver: Option<Arc<str>>,
        /// its step
        step_s: Option<f64> = "s",
        /// its tolerance
        tolerance: Option<f64>,
        /// its work in evaluations
        work: Option<u64>,
        /// neighbours of the scene it was tried on
        neighbours: Option<usize>,
        /// those of them that it passes on
        passed: Option<usize>,
        /// the next cheaper setting
        next_cheaper: Option<String>,
        /// why it is not recommended
        why_not: Option<WhyNot>,
    }

    /// A metric of a setting's run, beside that of the right one.
    TradeMetric = "trade_metrics", "Speed against accuracy" {
        /// the scene
        scene: Arc<str>,
        /// the solver
        solver: Arc<str>,
        /// its step
        step_s: Option<f64> = "s",
        /// its relative error per step
        tolerance: Option<f64>,
        /// the metric
        metric: Arc<str>,
        /// the unit of right, found and change
        unit: Arc<str>,
        /// of the right run
        right: Option<f64>,
        /// of this one
        found: Option<f64>,
        /// found less right
        change: Option<f64>,
        /// its size over that of right
        relative_change: Option<f64>,
        /// its size over what is just felt, where that is known
        felt_share: Option<f64>,
    }

    /// How fast a lever moves under half of its dry friction by a setting; it should stand.
    SolverCreep = "trade_creep", "Creep under half the friction" {
        /// the scene that the lever is of
        scene: Arc<str>,
        /// the solver
        solver: Arc<str>,
        /// its step
        step_s: Option<f64> = "s",
        /// its relative error per step
        tolerance: Option<f64>,
        /// mean speed of the lever
        creep_rad_s: f64 = "rad/s",
    }

    /// How long the runs of a setting take on the machine that made them.
    RunTime = "timing", "time of runs" {
        /// the solver
        solver: Arc<str>,
        /// its step
        step_s: Option<f64> = "s",
        /// its tolerance
        tolerance: Option<f64>,
        /// its work in evaluations
        work: u64,
        /// median time of a run
        time_s: f64 = "s",
        /// lower end of its interval
        time_low_s: f64 = "s",
        /// upper end of it
        time_high_s: f64 = "s",
        /// time of a run over the time that it simulates
        time_share: f64,
    }

    /// A metric of a condition with less of its recordings, or with another setup of the simulated
    /// device.
    MetricShift = "trade_data", "What coarser recordings do to the metrics" {
        /// participant, session, environment and mode
        condition: Arc<str>,
        /// what that is a degree of
        kind: LessKind,
        /// what is taken away or set otherwise
        less: Arc<str>,
        /// the metric
        metric: Arc<str>,
        /// the unit of mean, changes and bound
        unit: Arc<str>,
        /// trials that have it as they are
        trials: usize,
        /// those of them that have it no longer
        lost: usize,
        /// mean of the trials as they are
        mean: f64,
        /// mean of its changes
        change: f64,
        /// median of the changes' sizes
        median_change: f64,
        /// their 90th percentile
        p90_change: f64,
        /// the largest of them
        largest_change: f64,
        /// change that is just felt
        bound: Option<f64>,
        /// median change over that
        median_share: Option<f64>,
        /// 90th percentile over that
        p90_share: Option<f64>,
    }

    /// What another setup of the simulated device does to the metrics of all conditions.
    SetupSummary = "trade_twin_summary", "What another setup of the simulated device does to the metrics, in short" {
        /// the setup
        setup: Arc<str>,
        /// metrics of which a change is known to be felt
        metrics: usize,
        /// those that the median trial of a condition has changed by more
        felt: usize,
        /// the one that changes most
        metric: Option<Arc<str>>,
        /// where it does
        condition: Option<Arc<str>>,
        /// its change in the median trial over what is just felt
        median_share: Option<f64>,
        /// the 90th percentile of that
        p90_share: Option<f64>,
        /// values of metrics that trials lose
        lost: usize,
        /// trials that safety refused or ended
        stopped: usize,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_survives_its_text_and_another_text_is_none() {
        let gates = Gate::ALL.iter().flat_map(|g| [WhyNot::Breaks(*g), WhyNot::FinerBreaks(*g)]);
        for why in gates.chain([0, 99].map(WhyNot::Neighbours)) {
            assert_eq!(why.to_string().parse(), Ok(why));
        }
        let none = "it passes on 07 of the scene's neighbours only".parse::<WhyNot>();
        assert!(none.unwrap_err().to_string().contains("07 of the scene's"));
    }
}
