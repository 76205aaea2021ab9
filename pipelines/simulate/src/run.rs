//! Runs and judges a scene.

use crate::SimulateError;
use zwidth_dynamics::{Grid, Judgement, ModelScene, Solver, System, Trajectory, judge};

/// More samples than this are not kept: judging needs the run with a quarter of the step too.
pub const MOST_SAMPLES: usize = 500_000;

/// A finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The scene, checked.
    pub system: System,
    /// Name of the solver.
    pub solver: String,
    /// States, events, work and energy.
    pub trajectory: Trajectory,
    /// What the run is worth.
    pub judgement: Judgement,
}

/// Runs a scene over its own duration and step, and judges the run.
///
/// # Errors
/// A scene that makes no sense, one the solver cannot run, or more than [`MOST_SAMPLES`] samples.
pub fn simulate(scene: ModelScene, solver: &dyn Solver) -> Result<Run, SimulateError> {
    let (system, trajectory) = unjudged(scene, solver)?;
    let judgement = judge(solver, &system, system.scene().step_s);
    Ok(Run { system, solver: solver.name(), trajectory, judgement })
}

/// Runs a scene over its own duration and step. Nothing is said of what the run is worth, which takes
/// several more runs.
///
/// # Errors
/// Those of [`simulate`].
pub fn unjudged(
    scene: ModelScene,
    solver: &dyn Solver,
) -> Result<(System, Trajectory), SimulateError> {
    let system = System::new(scene)?;
    let grid = grid(&system, system.scene().step_s)?;
    let trajectory = solver.run(&system, &grid)?;
    Ok((system, trajectory))
}

/// The grid that fills the scene's duration, if it is not too long.
pub(crate) fn grid(system: &System, step_s: f64) -> Result<Grid, SimulateError> {
    let duration_s = system.scene().duration_s;
    if duration_s / step_s >= MOST_SAMPLES as f64 {
        return Err(SimulateError::TooManySamples { duration_s, step_s });
    }
    Ok(Grid::filling(duration_s, step_s))
}

/// The largest θ, rad, and when it was reached first, s: over samples and events, so that a peak
/// between samples is not missed.
pub fn highest(run: &Trajectory) -> (f64, f64) {
    let samples = run.theta_rad().zip(run.t_s.iter().copied());
    let all = samples.chain(run.events.iter().map(|event| (event.theta_rad, event.t_s)));
    // Times the other way round: of equal angles the earliest counts.
    let highest = all.max_by(|a, b| a.0.total_cmp(&b.0).then_with(|| b.1.total_cmp(&a.1)));
    highest.unwrap_or_default() // a run has at least its first sample
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{run, sticking};
    use crate::{DEFAULT_TOLERANCE, solver};

    #[test]
    fn a_step_that_would_fill_the_memory_is_refused_with_its_size() {
        let scene = ModelScene { step_s: 1e-9, ..sticking() };
        let error =
            simulate(scene, solver("exact", DEFAULT_TOLERANCE).unwrap().as_ref()).unwrap_err();
        assert!(error.to_string().contains("4 s in steps of 0.000000001 s"), "{error}");
    }

    #[test]
    fn a_run_that_is_not_judged_is_the_one_that_is_judged() {
        let solver = solver("exact", DEFAULT_TOLERANCE).unwrap();
        let (_, trajectory) = unjudged(sticking(), solver.as_ref()).unwrap();
        assert_eq!(trajectory, run(sticking(), "exact").trajectory);
    }

    #[test]
    fn the_largest_angle_and_its_time_do_not_depend_on_the_samples() {
        for step_s in [1e-3, 8.3e-3, 0.9] {
            let run = run(ModelScene { step_s, ..sticking() }, "exact");
            let (theta_rad, t_s) = highest(&run.trajectory);
            assert!((theta_rad.to_degrees() - 14.40784).abs() < 1e-5, "{step_s}: {theta_rad} rad");
            assert!((t_s - 1.246_306).abs() < 2e-5, "{step_s}: {t_s} s");
        }
    }
}
