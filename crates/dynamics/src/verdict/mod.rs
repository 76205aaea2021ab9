//! The verdict on a run: smooth, an oscillation that its model has, or one that its method made.
//!
//! A run is judged by a [`Reference`]: the motion by `exact` or, if `exact` cannot run the model,
//! the motion on which two independent methods agree. The method also runs the scene with half and
//! a quarter of the step, because a step may be too long to show how the method chatters. The order
//! of judgement:
//!
//! 1. **failed**: the run ended in an error.
//! 2. **smooth**: neither the run, at any of the three steps, nor the reference oscillates, and the
//!    run does not creep. A *swing* is the way from one end of a motion to the next; it exists where half of its angle is
//!    above 1e-9 rad and 100 times the reference's error; six existing swings are an oscillation. A
//!    run that grows away from the reference without a turn is not smooth; the next verdict
//!    applies.
//! 3. **unstable step**: |R(hλ)| > 1 in a region in which the run moved, curved terms linearised
//!    along the run, where the exact flow does not grow.
//! 4. **depends on the rule at rest**: a lagging actuator may follow either side's command while
//!    θ̇ = 0, and the two give different motions.
//! 5. **cannot tell**: the motion is not known.
//! 6. **numerical chattering**: the run swings in a way that is absent in the reference.
//! 7. **numerical creep**: the run's lever moves on where the reference's stands still.
//! 8. What the reference itself does: **forced** (it repeats with the input's period or 2 to 4 of
//!    them), **transient** or **growing** (the amplitude of the last third over that of the first
//!    is below 0.9 or above 1.1), **free, undamped** (a conservative model), or else a **limit
//!    cycle**.
//!
//! [`felt`] says beside it whether a person feels the motion.

mod bands;
mod creep;
mod felt;
mod model;
mod path;
mod perceived;
mod reference;
mod run_verdict;
mod sampled;
mod stability;
mod swings;
#[cfg(test)]
mod tests;
mod ticked;

pub use felt::{Felt, VibrationThreshold, felt};
pub use model::Model;
pub use perceived::{FeltDifference, FeltMotion, FeltReference};
pub use reference::Reference;
pub use run_verdict::RunVerdict;
pub use sampled::{Controller, SampledLoop};
pub use swings::{FEW as FEWEST_SWINGS, Swings};
pub use ticked::{HeldForces, TickController, TickedLoop};

use path::Path;
use reference::KnownMotion;
pub(crate) use stability::Growth;
use swings::{FEW, Swing, existing, has_its_own, sampled, without_rests};

use crate::error::DynamicsError;
use crate::solve::Solver;
use crate::trajectory::Trajectory;

/// The summary of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Motions {
    /// By which method it is known.
    pub method: String,
    /// What it is.
    pub nature: RunVerdict,
    /// Its existing swings.
    pub swings: Swings,
    /// The largest θ of its samples, rad.
    pub theta_max_rad: f64,
}

/// A verdict and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: RunVerdict,
    /// The existing swings with the step, half of it, and a quarter; none where the shorter ones
    /// could not be run.
    pub swings: [Swings; 3],
    /// The reference; none if the motion is not known, or the run failed.
    pub reference: Option<Motions>,
    /// The reference with the other rule for the command at rest, where there is one.
    pub other_rest_rule: Option<Motions>,
    /// Whether the run oscillates if the reference does: a coarse step may lose it.
    pub shows_the_reference: bool,
    /// Half the peak-to-peak angle from which on a swing exists, rad.
    pub bound_rad: f64,
    /// The longest distance that the lever creeps in a stretch in which the reference's lever
    /// stands still, rad; 0 if it stands still too.
    pub creep_rad: f64,
    /// Largest growth of a step in the regions in which the run moved, over the exact flow's own;
    /// above 1 the step is unstable. 1 for methods without a limit.
    pub amplification: f64,
    /// What went wrong, if the run failed.
    pub error: Option<DynamicsError>,
}

/// The swings of a run that exist, for [`Reference::judge_with`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExistingSwings(Vec<Swing>);

/// The swings of a run that the right run, at the same times, has not, and that are larger than
/// `bound_rad` (half their peak-to-peak angle); none if it has no oscillation of its own. Both are
/// read at their samples, whatever events the right run knows, so that the sampling hides or makes
/// nothing in one of them alone.
pub fn own_swings(run: &Trajectory, right: &Trajectory, bound_rad: f64) -> Option<Swings> {
    let [own, others] = [run, right].map(|run| sampled(run, bound_rad));
    let end_s = run.t_s.last().copied().unwrap_or(0.0);
    let [moving, others] = [without_rests(run, &own), without_rests(right, &others)];
    has_its_own(&moving, &others, end_s).then(|| Swings::of(&own))
}

/// Runs a model with a step and judges the run. For several runs of a model make its [`Reference`]
/// once.
pub fn judge(solver: &dyn Solver, model: &dyn Model, step_s: f64) -> Judgement {
    Reference::of(model).judge(solver, step_s)
}

impl Reference<'_> {
    /// Runs the model with a step, half of it and a quarter, and judges the first run.
    pub fn judge(&self, solver: &dyn Solver, step_s: f64) -> Judgement {
        match self.model.run(solver, step_s) {
            Ok(run) => {
                let [half, quarter] = [0.5, 0.25].map(|share| {
                    let run = self.model.run(solver, share * step_s);
                    run.map(|run| self.swings(&run)).unwrap_or_default()
                });
                self.judge_with(solver, step_s, &run, [&half, &quarter])
            }
            Err(error) => Judgement {
                verdict: RunVerdict::Failed,
                swings: Default::default(),
                reference: self.motion.as_ref().map(motions),
                other_rest_rule: self.other_rule.as_ref().map(motions),
                shows_the_reference: false,
                bound_rad: self.bound_rad(),
                creep_rad: 0.0,
                amplification: 1.0,
                error: Some(error),
            },
        }
    }

    /// The existing swings of a run of the model.
    pub fn swings(&self, run: &Trajectory) -> ExistingSwings {
        ExistingSwings(existing(run, self.bound_rad()))
    }

    /// Judges a run that was made with a step, by the swings of runs with half of it and a quarter
    /// that were made too; empty ones stand for none.
    pub fn judge_with(
        &self,
        solver: &dyn Solver,
        step_s: f64,
        run: &Trajectory,
        finer: [&ExistingSwings; 2],
    ) -> Judgement {
        let h = self.model.method_step_s(step_s);
        let growth = stability::worst(solver, self.model.plant(), run, h);
        let [half, quarter] = finer.map(|swings| swings.0.clone());
        let swings = [existing(run, self.bound_rad()), half, quarter];
        let reference_swings = self.motion.as_ref().map_or(0, |motion| motion.swings.len());
        let creep_rad =
            self.motion.as_ref().map_or(0.0, |motion| creep::creep_rad(&Path::of(run), motion, h));
        Judgement {
            verdict: self.verdict(run, &swings, growth, creep_rad),
            swings: swings.each_ref().map(|swings| Swings::of(swings)),
            reference: self.motion.as_ref().map(motions),
            other_rest_rule: self.other_rule.as_ref().map(motions),
            shows_the_reference: swings[0].len() >= FEW || reference_swings < FEW,
            bound_rad: self.bound_rad(),
            creep_rad,
            amplification: growth.map_or(1.0, Growth::excess).max(1.0),
            error: None,
        }
    }

    fn bound_rad(&self) -> f64 {
        self.motion.as_ref().map_or(0.0, |motion| motion.bound_rad)
    }

    /// The order of judgement.
    fn verdict(
        &self,
        run: &Trajectory,
        swings: &[Vec<Swing>; 3],
        growth: Option<Growth>,
        creep_rad: f64,
    ) -> RunVerdict {
        let unstable = growth.is_some_and(Growth::is_unstable);
        let Some(reference) = &self.motion else {
            return if unstable { RunVerdict::UnstableStep } else { RunVerdict::CannotTell };
        };
        let oscillates = swings.iter().chain([&reference.swings]).any(|swings| swings.len() >= FEW);
        // An unstable step counts only where the run shows it: it may never have been excited.
        if unstable && (oscillates || runs_away(run, reference)) {
            RunVerdict::UnstableStep
        } else if oscillates && self.depends_on_rest_rule() {
            RunVerdict::DependsOnRestRule
        } else if oscillates
            && swings
                .iter()
                .any(|swings| has_its_own(swings, &reference.swings, reference.path.end_s()))
        {
            RunVerdict::NumericalChattering
        } else if creep_rad > 0.0 {
            RunVerdict::NumericalCreep
        } else {
            reference.nature
        }
    }

    /// Whether the two rules give motions of another nature, or another largest angle by more than
    /// a hundredth of the range.
    fn depends_on_rest_rule(&self) -> bool {
        const SHARE: f64 = 0.01;
        let (Some(a), Some(b)) = (&self.motion, &self.other_rule) else { return false };
        let apart = (a.path.highest_rad() - b.path.highest_rad()).abs();
        a.nature != b.nature || apart > a.bound_rad.max(SHARE * a.path.range_rad())
    }
}

/// Whether a run without swings leaves the reference by more than half its range: growth without a
/// turn.
fn runs_away(run: &Trajectory, reference: &KnownMotion) -> bool {
    let apart_rad = reference.path.distance_rad(&Path::of(run));
    apart_rad > 0.5 * reference.path.range_rad() + reference.bound_rad
}

fn motions(motion: &KnownMotion) -> Motions {
    Motions {
        method: motion.method.clone(),
        nature: motion.nature,
        swings: Swings::of(&motion.swings),
        theta_max_rad: motion.path.highest_rad(),
    }
}
