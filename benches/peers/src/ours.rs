//! zwidth's own solvers on the scene: exact, and its general adaptive methods.

use zwidth_dynamics::{
    DriveMode, Environment, Exact, Grid, Input, Prepared, Solver, System, Trajectory, table3,
};

use crate::scene::{Numbers, SAMPLES, STEP_S, STICKING, Samples};

pub(crate) fn grid() -> Grid {
    Grid::Even { step_s: STEP_S, steps: SAMPLES - 1 }
}

pub(crate) fn system(numbers: &Numbers) -> Result<System, String> {
    let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(numbers.magnitude));
    scene.environment =
        Environment::spring(numbers.stiffness, numbers.damping, -table3::HALF_STROKE_RAD);
    System::new(scene).map_err(|error| error.to_string())
}

/// θ of the exact solution at every sample, rad.
pub(crate) fn reference() -> Result<Vec<f64>, String> {
    let run =
        Exact::default().run(&system(&STICKING)?, &grid()).map_err(|error| error.to_string())?;
    Ok(run.theta_rad().collect())
}

/// The system made ready for many runs.
pub(crate) fn prepare(system: &System) -> Result<Box<dyn Prepared + '_>, String> {
    Exact::default().prepare(system, &grid()).map_err(|error| error.to_string())
}

/// A trajectory that runs are written into: θ and θ̇ of every sample, and the rest of its state.
pub(crate) fn room(grid: &Grid) -> Result<Trajectory, String> {
    Exact::default().run(&system(&STICKING)?, grid).map_err(|error| error.to_string())
}

/// An exact run of a system that is ready; returns the number of products with a flow matrix.
pub(crate) fn exact(
    prepared: &mut dyn Prepared,
    grid: &Grid,
    out: &mut Trajectory,
) -> Result<u64, String> {
    prepared.run_into(grid, out).map_err(|error| error.to_string())?;
    Ok(out.work.evaluations)
}

/// A run of a general solver; returns the number of evaluations.
pub(crate) fn general(
    solver: &dyn Solver,
    system: &System,
    out: &mut Samples,
) -> Result<u64, String> {
    out.clear();
    let run = solver.run(system, &grid()).map_err(|error| error.to_string())?;
    out.theta.extend(run.theta_rad());
    out.theta_dot.extend(run.theta_dot_rad_s());
    Ok(run.work.evaluations)
}
