//! A run in a few numbers.

use crate::Run;
use crate::run::highest;
use serde::Serialize;
use zwidth_dynamics::{Motions, RunVerdict};

/// The numbers that a person wants to know first about a run. SI units and radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The scene's name.
    pub scene: String,
    /// Name of the rendered environment.
    pub environment: String,
    /// Which actuators rendered it: active, passive or hybrid.
    pub mode: &'static str,
    /// The solver.
    pub solver: String,
    /// Time between samples, s.
    pub step_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// The largest θ, rad.
    pub theta_max_rad: f64,
    /// When it was reached first, s.
    pub theta_max_s: f64,
    /// Changes between forward, rest and backward; `None` where the solver met no event.
    pub motion_changes: Option<usize>,
    /// Sign changes of θ̇ between samples, zeros skipped.
    pub reversals: usize,
    /// What the run is worth: see [`RunVerdict`].
    pub verdict: &'static str,
    /// What the verdict rests on: swings at the step, at half of it, and at a quarter.
    pub swings: [StepSwings; 3],
    /// The other basis of the verdict: the known motion; `None` if it is not known.
    pub reference: Option<KnownMotion>,
    /// The same with the other rule for the command at rest, where the verdict says that it
    /// matters.
    pub other_rest_rule: Option<KnownMotion>,
    /// Whether the run oscillates if the reference does.
    pub shows_the_reference: bool,
    /// The longest distance that the lever creeps while the known motion stands still, rad.
    pub creep_rad: f64,
    /// Largest growth per step in the regions met, over the exact flow's; above 1 the step is
    /// unstable.
    pub amplification: f64,
    /// The law of the finger, if there is one: thesis or consistent.
    pub finger: Option<&'static str>,
    /// The energy balance, where the solver integrates it.
    pub energy: Option<Energy>,
    /// What it took.
    pub work: Work,
}

/// The motion that a run is judged by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KnownMotion {
    /// The method, or the two that agree.
    pub method: String,
    /// What the motion is.
    pub nature: &'static str,
    /// How many swings it has.
    pub count: usize,
    /// Median of half their peak-to-peak angle, rad; 0 without any.
    pub amplitude_rad: f64,
    /// The largest θ, rad.
    pub theta_max_rad: f64,
}

impl KnownMotion {
    fn of(motion: &Motions) -> Self {
        Self {
            method: motion.method.clone(),
            nature: motion.nature.as_str(),
            count: motion.swings.count,
            amplitude_rad: motion.swings.amplitude_rad,
            theta_max_rad: motion.theta_max_rad,
        }
    }
}

/// Swings of an oscillation: ways of the lever from one end of a motion to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepSwings {
    /// The step, s.
    pub step_s: f64,
    /// How many.
    pub count: usize,
    /// Median of half their peak-to-peak angle, rad; 0 without any.
    pub amplitude_rad: f64,
}

/// How well the energy adds up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Energy {
    /// Work that is not accounted for, J. The finger law `thesis` leaves out a force, and its work
    /// shows here.
    pub residual_j: f64,
    /// Sum of the sizes of all works, J.
    pub summed_j: f64,
}

/// Work counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Steps taken, or exact pieces.
    pub steps: u64,
    /// Steps rejected by an error estimate.
    pub rejected: u64,
    /// Evaluations of the right-hand side, or products with a flow matrix.
    pub evaluations: u64,
    /// Matrix exponentials or factorisations.
    pub factorisations: u64,
}

impl Summary {
    /// The summary of a run.
    pub fn of(run: &Run) -> Self {
        let scene = run.system.scene();
        let trajectory = &run.trajectory;
        let (theta_max_rad, theta_max_s) = highest(trajectory);
        let work = trajectory.work;
        // A judged run is repeated with half and a quarter of its step.
        let shares = [1.0, 0.5, 0.25];
        let swings = std::array::from_fn(|i| {
            let swings = run.judgement.swings[i];
            let step_s = shares[i] * scene.step_s;
            StepSwings { step_s, count: swings.count, amplitude_rad: swings.amplitude_rad }
        });
        let rule_matters = run.judgement.verdict == RunVerdict::DependsOnRestRule;
        let other_rest_rule = run.judgement.other_rest_rule.as_ref().filter(|_| rule_matters);
        Self {
            scene: scene.name.clone(),
            environment: scene.environment.name.clone(),
            mode: scene.mode.as_str(),
            solver: run.solver.clone(),
            step_s: scene.step_s,
            samples: trajectory.len(),
            theta_max_rad,
            theta_max_s,
            motion_changes: (!trajectory.events.is_empty()).then(|| trajectory.motion_changes()),
            reversals: trajectory.reversals(),
            verdict: run.judgement.verdict.as_str(),
            swings,
            reference: run.judgement.reference.as_ref().map(KnownMotion::of),
            other_rest_rule: other_rest_rule.map(KnownMotion::of),
            shows_the_reference: run.judgement.shows_the_reference,
            creep_rad: run.judgement.creep_rad,
            amplification: run.judgement.amplification,
            finger: scene.finger.map(|finger| finger.law.as_str()),
            energy: trajectory
                .energy
                .map(|e| Energy { residual_j: e.residual_j(), summed_j: e.summed_j() }),
            work: Work {
                steps: work.steps,
                rejected: work.rejected,
                evaluations: work.evaluations,
                factorisations: work.factorisations,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{run, sticking};

    #[test]
    fn the_exact_run_of_the_sticking_scene_has_three_motion_changes_and_its_energy_adds_up() {
        let found = Summary::of(&run(sticking(), "exact"));
        assert!((found.theta_max_rad.to_degrees() - 14.40784).abs() < 1e-5);
        assert_eq!((found.motion_changes, found.verdict), (Some(3), "smooth"));
        let energy = found.energy.unwrap();
        assert!(energy.residual_j.abs() < 1e-10 * energy.summed_j, "{energy:?}");
    }

    #[test]
    fn the_thesis_method_chatters_and_its_swings_shrink_with_the_step() {
        let found = Summary::of(&run(sticking(), "rk4_per_step"));
        assert_eq!((found.verdict, found.reversals), ("numerical chattering", 38));
        let [coarse, _, fine] = found.swings;
        assert!(fine.amplitude_rad < 0.5 * coarse.amplitude_rad && fine.count > coarse.count);
        assert!(found.motion_changes.is_none() && found.energy.is_none());
    }
}
