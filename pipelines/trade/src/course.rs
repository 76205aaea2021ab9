//! Runs beside each other: what chattering looks like.

use crate::TradeError;
use crate::cells::grid;
use crate::setting::Setting;
use crate::story::Story;
use zwidth_dynamics::{ModelScene, System};
use zwidth_tables::{Column, Table};

/// One row per sample of each run: the setting's solver and step, time, angle. A run that fails has
/// none.
///
/// # Errors
/// A scene that makes no sense, or more samples than are kept.
pub fn courses_table(
    name: &str,
    scene: &ModelScene,
    settings: &[Setting],
) -> Result<Table, TradeError> {
    let system = System::new(scene.clone())?;
    let (mut solver, mut step, mut t, mut theta, mut changes) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for setting in settings {
        let grid = grid(scene, setting.step_s().unwrap_or(1e-3))?;
        let Ok(run) = setting.solver().run(&system, &grid) else { continue };
        let n = Story::of(&system, &run).motion_changes() as i64;
        solver.extend(std::iter::repeat_n(Some(setting.solver.to_owned()), run.len()));
        step.extend(std::iter::repeat_n(setting.step_s(), run.len()));
        changes.extend(std::iter::repeat_n(Some(n), run.len()));
        t.extend(run.t_s.iter().copied().map(Some));
        theta.extend(run.theta_rad().map(Some));
    }
    let columns = vec![
        Column::text("solver", "the solver", solver),
        Column::float("step_s", "s", "its step; none for one that finds events", step),
        Column::float("t_s", "s", "time", t),
        Column::float("theta_rad", "rad", "lever angle", theta),
        Column::integer("motion_changes", "1", "changes of the way of moving in the run", changes),
    ];
    let table = Table::new(name, &format!("{}: courses", scene.name), columns)?;
    Ok(table.with_note("Model runs, not measurements."))
}
