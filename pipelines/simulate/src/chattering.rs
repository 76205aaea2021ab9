//! Solvers and steps side by side on one scene: which oscillation is the method's, and which the
//! model's.

use crate::run::{grid, highest};
use crate::{DEFAULT_TOLERANCE, SimulateError, solver};
use zwidth_dynamics::{Exact, Judgement, ModelScene, Reference, Solver as _, System, Trajectory};
use zwidth_results::ChatteringRun;

/// Steps for a table of chattering, s: from the thesis' 8.3 ms to 0.05 ms, about evenly spaced in
/// their logarithms.
pub const CHATTERING_STEPS_S: [f64; 12] =
    [8.3e-3, 5e-3, 3e-3, 2e-3, 1.3e-3, 0.83e-3, 0.5e-3, 0.3e-3, 0.2e-3, 0.13e-3, 0.083e-3, 0.05e-3];

/// For each solver and step (s): reversals, the largest θ and its excess over the exact solver's,
/// swings with their median amplitude, and the verdict. A run that fails has a row with its
/// verdict and nothing else. `progress` is called after each row.
///
/// # Errors
/// An unknown solver, a scene that makes no sense or that the exact solver cannot run (it is the
/// reference), or too many samples.
pub fn chattering(
    scene: &ModelScene,
    solvers: &[&str],
    steps_s: &[f64],
    progress: &dyn Fn(),
) -> Result<Vec<ChatteringRun>, SimulateError> {
    let system = System::new(scene.clone())?;
    let exact = Exact::default().run(&system, &grid(&system, scene.step_s)?)?;
    let reference_rad = highest(&exact).0;
    let reference = Reference::of(&system);
    let mut rows = Vec::new();
    for name in solvers {
        let solver = solver(name, DEFAULT_TOLERANCE)?;
        for &step_s in steps_s {
            // A failure is a row of its own: `judge` runs the scene again, and says that it failed.
            let run = solver.run(&system, &grid(&system, step_s)?).ok();
            let judgement = reference.judge(solver.as_ref(), step_s);
            rows.push(row(solver.name(), step_s, run.as_ref(), &judgement, reference_rad));
            progress();
        }
    }
    Ok(rows)
}

/// The note below a table of chattering.
pub const CHATTERING_NOTE: &str =
    "Model runs, not measurements. The exact solver is the reference.";

fn row(
    solver: String,
    step_s: f64,
    run: Option<&Trajectory>,
    judgement: &Judgement,
    reference_rad: f64,
) -> ChatteringRun {
    let largest_rad = run.map(|run| highest(run).0);
    let swings = run.map(|_| judgement.swings[0]);
    ChatteringRun {
        solver,
        step_s,
        reversals: run.map(Trajectory::reversals),
        theta_max_rad: largest_rad,
        theta_excess_rad: largest_rad.map(|theta| theta - reference_rad),
        swings: swings.map(|swings| swings.count),
        swing_amplitude_rad: swings.map(|swings| swings.amplitude_rad),
        verdict: judgement.verdict.as_str().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::sticking;
    use std::cell::Cell;
    use zwidth_dynamics::{DriveMode, Finger, FingerLaw, Input, table3};

    fn check(solver: &str, step_s: f64, reversals: usize, max_deg: f64) {
        let runs = chattering(&sticking(), &[solver], &[step_s], &|| {}).unwrap();
        let found = runs[0].theta_max_rad.unwrap().to_degrees();
        assert_eq!(runs[0].reversals, Some(reversals), "{solver} {step_s}");
        assert!((found - max_deg).abs() < 5e-4, "{solver} {step_s}: {found} instead of {max_deg}");
        let excess = runs[0].theta_excess_rad.unwrap().to_degrees();
        assert!((excess - (max_deg - 14.40784)).abs() < 6e-4, "{solver} {step_s}: {excess}");
    }

    // Counted and measured independently of this code, with a hand-written RK4 loop.
    #[test]
    fn rk4_that_switches_per_stage_overshoots_less_and_turns_more_often_as_the_step_shrinks() {
        check("rk4_per_stage", 8.3e-3, 2, 15.171);
        check("rk4_per_stage", 0.83e-3, 22, 14.629);
        check("rk4_per_stage", 0.05e-3, 436, 14.423);
    }

    #[test]
    fn rk4_that_switches_once_a_step_does_so_much_more() {
        check("rk4_per_step", 8.3e-3, 38, 17.937);
        check("rk4_per_step", 0.83e-3, 268, 14.926);
        check("rk4_per_step", 0.05e-3, 4014, 14.441);
    }

    #[test]
    fn solvers_that_know_sticking_turn_twice_at_every_step_and_are_smooth() {
        let solvers = ["exact", "dormand_prince", "tr_bdf2", "moreau_jean"];
        let done = Cell::new(0);
        let progress = || done.set(done.get() + 1);
        let runs = chattering(&sticking(), &solvers, &[8.3e-3, 0.83e-3], &progress).unwrap();
        assert!(runs.iter().all(|run| run.verdict == "smooth"));
        assert!(runs.iter().all(|run| (run.reversals, run.swings) == (Some(2), Some(0))));
        assert_eq!(done.get(), solvers.len() * 2, "progress counts each run");
    }

    #[test]
    fn a_run_that_fails_is_a_row_that_says_so() {
        let mut scene = table3::scene(DriveMode::Active, Input::sine(2.15));
        scene.plant.stops_rad = None;
        // Each step is so long for tissue so stiff that it grows by many powers of ten, and nothing
        // bounds it.
        let finger = table3::finger(FingerLaw::Consistent);
        scene.finger = Some(Finger { stiffness_n_per_m: 1e12, length_m: None, ..finger });
        let runs = chattering(&scene, &["rk4_per_step"], &[8.3e-3], &|| {}).unwrap();
        assert_eq!((runs[0].verdict.as_str(), runs[0].reversals), ("failed", None));
    }
}
