//! zwidth's own solvers on the scene: exact, and its general adaptive methods.

use zwidth_dynamics::{Exact, Grid, Input, DriveMode, Prepared, Solver, System, table3};

use crate::scene::{SAMPLES, STEP_S, Samples};

/// The sine's magnitude, N.
const MAGNITUDE_N: f64 = 2.15;

pub(crate) fn grid() -> Grid {
    Grid::Even { step_s: STEP_S, steps: SAMPLES - 1 }
}

pub(crate) fn system() -> Result<System, String> {
    System::new(table3::scene(DriveMode::Hybrid, Input::sine(MAGNITUDE_N)))
        .map_err(|error| error.to_string())
}

/// θ of the exact solution at every sample, rad.
pub(crate) fn reference() -> Result<Vec<f64>, String> {
    let run = Exact::default().run(&system()?, &grid()).map_err(|error| error.to_string())?;
    Ok(run.theta_rad().collect())
}

/// The system made ready for many runs.
pub(crate) fn prepare(system: &System) -> Result<Box<dyn Prepared + '_>, String> {
    Exact::default().prepare(system, &grid()).map_err(|error| error.to_string())
}

/// An exact run of a system that is ready; returns the number of products with a flow matrix.
pub(crate) fn exact(
    prepared: &mut dyn Prepared,
    grid: &Grid,
    out: &mut Samples,
) -> Result<u64, String> {
    out.clear();
    let run = prepared
        .visit(grid, &mut |_, z| out.push([z[0], z[1]]))
        .map_err(|error| error.to_string())?;
    Ok(run.work.evaluations)
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
