//! Solvers and steps side by side on one scene: which oscillation is the method's, and which the
//! model's.

use crate::run::{grid, highest};
use crate::summary::verdict_word;
use crate::{DEFAULT_TOLERANCE, SimulateError, solver};
use zwidth_dynamics::{Exact, Judgement, ModelScene, Reference, Solver, System};
use zwidth_tables::{Column, Table, TableError};

/// Steps for a table of chattering, s: from the thesis' 8.3 ms to 0.05 ms, about evenly spaced in
/// their logarithms.
pub const CHATTERING_STEPS_S: [f64; 12] =
    [8.3e-3, 5e-3, 3e-3, 2e-3, 1.3e-3, 0.83e-3, 0.5e-3, 0.3e-3, 0.2e-3, 0.13e-3, 0.083e-3, 0.05e-3];

/// One solver at one step. Empty where the run failed.
struct SolverRun {
    solver: String,
    step_s: f64,
    found: Option<Found>,
    judgement: Judgement,
}

struct Found {
    reversals: usize,
    theta_max_rad: f64,
}

/// For each solver and step (s): reversals, the largest θ and its excess over the exact solver's,
/// swings with their median amplitude, and the verdict. A run that fails has a row with its
/// verdict and nothing else. `progress` is called after each row.
///
/// # Errors
/// An unknown solver, a scene that makes no sense or that the exact solver cannot run (it is the
/// reference), or too many samples.
pub fn chattering_table(
    scene: &ModelScene,
    solvers: &[&str],
    steps_s: &[f64],
    progress: &dyn Fn(),
) -> Result<Table, SimulateError> {
    let system = System::new(scene.clone())?;
    let exact = Exact::default().run(&system, &grid(&system, scene.step_s)?)?;
    let reference_rad = highest(&exact).0;
    let reference = Reference::of(&system);
    let mut rows = Vec::new();
    for name in solvers {
        let solver = solver(name, DEFAULT_TOLERANCE)?;
        for &step_s in steps_s {
            rows.push(row(solver.as_ref(), &system, &reference, step_s)?);
            progress();
        }
    }
    Ok(table(&scene.name, &rows, reference_rad)?)
}

fn row(
    solver: &dyn Solver,
    system: &System,
    reference: &Reference,
    step_s: f64,
) -> Result<SolverRun, SimulateError> {
    let run = solver.run(system, &grid(system, step_s)?).ok();
    let found = run.map(|run| Found { reversals: run.reversals(), theta_max_rad: highest(&run).0 });
    Ok(SolverRun {
        solver: solver.name(),
        step_s,
        found,
        judgement: reference.judge(solver, step_s),
    })
}

fn table(scene: &str, rows: &[SolverRun], reference_rad: f64) -> Result<Table, TableError> {
    let float = |name, unit, about, get: &dyn Fn(&SolverRun) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let count = |name, about, get: fn(&SolverRun) -> Option<usize>| {
        Column::integer(name, "1", about, rows.iter().map(|row| get(row).map(|n| n as i64)))
    };
    let text = |name, about, get: fn(&SolverRun) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let largest = |row: &SolverRun| row.found.as_ref().map(|found| found.theta_max_rad);
    let columns = vec![
        text("solver", "the solver", |row| row.solver.clone()),
        float("step_s", "s", "its step; adaptive solvers sample by it", &|row| Some(row.step_s)),
        count("reversals", "sign changes of the velocity between samples, zeros skipped", |row| {
            row.found.as_ref().map(|found| found.reversals)
        }),
        float("theta_max_rad", "rad", "largest angle", &largest),
        float("theta_excess_rad", "rad", "largest angle less the exact solver's", &|row| {
            largest(row).map(|theta| theta - reference_rad)
        }),
        count(
            "swings",
            "of an oscillation: ways from one end of a motion to the next, 0 for fewer than six",
            |row| row.found.as_ref().map(|_| row.judgement.swings[0].count),
        ),
        float(
            "swing_amplitude_rad",
            "rad",
            "median of half a swing's angle; 0 without any",
            &|row| row.found.as_ref().map(|_| row.judgement.swings[0].amplitude_rad),
        ),
        text("verdict", "what the run is worth", |row| {
            verdict_word(row.judgement.verdict).to_owned()
        }),
    ];
    let table = Table::new("chattering", &format!("{scene}: chattering"), columns)?;
    Ok(table.with_note("Model runs, not measurements. The exact solver is the reference."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use zwidth_dynamics::{DriveMode, Finger, FingerLaw, Input, table3};

    fn check(solver: &str, step_s: f64, reversals: i64, max_deg: f64) {
        let scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        let table = chattering_table(&scene, &[solver], &[step_s], &|| {}).unwrap();
        let found = table.floats("theta_max_rad").unwrap()[0].unwrap().to_degrees();
        assert_eq!(table.integers("reversals").unwrap(), [Some(reversals)], "{solver} {step_s}");
        assert!((found - max_deg).abs() < 5e-4, "{solver} {step_s}: {found} instead of {max_deg}");
        let excess = table.floats("theta_excess_rad").unwrap()[0].unwrap().to_degrees();
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
        let scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        let solvers = ["exact", "dormand_prince", "tr_bdf2", "moreau_jean"];
        let runs = Cell::new(0);
        let progress = || runs.set(runs.get() + 1);
        let table = chattering_table(&scene, &solvers, &[8.3e-3, 0.83e-3], &progress).unwrap();
        assert!(table.texts("verdict").unwrap().iter().all(|v| v.as_deref() == Some("smooth")));
        assert!(table.integers("reversals").unwrap().iter().all(|n| *n == Some(2)));
        assert!(table.integers("swings").unwrap().iter().all(|n| *n == Some(0)));
        assert_eq!(runs.get(), solvers.len() * 2, "progress counts each run");
    }

    #[test]
    fn a_run_that_fails_is_a_row_that_says_so() {
        let mut scene = table3::scene(DriveMode::Active, Input::sine(2.15));
        scene.plant.stops_rad = None;
        // Each step is so long for tissue so stiff that it grows by many powers of ten, and nothing
        // bounds it.
        let finger = table3::finger(FingerLaw::Consistent);
        scene.finger = Some(Finger { stiffness_n_per_m: 1e12, length_m: None, ..finger });
        let table = chattering_table(&scene, &["rk4_per_step"], &[8.3e-3], &|| {}).unwrap();
        assert_eq!(table.texts("verdict").unwrap()[0].as_deref(), Some("failed"));
        assert_eq!(table.integers("reversals").unwrap(), [None]);
    }
}
