//! Runs side by side: what chattering looks like.

use crate::TradeError;
use crate::cells::grid;
use crate::setting::Setting;
use crate::table::MODEL;
use std::iter::repeat_n;
use zwidth_dynamics::{ModelScene, System};
use zwidth_judge::Story;
use zwidth_results::TradeRun;
use zwidth_tables::{Column, Table, TableError};

/// The run of each setting; one that fails has none.
///
/// # Errors
/// A scene that makes no sense, or more samples than are kept.
pub fn courses(scene: &ModelScene, settings: &[Setting]) -> Result<Vec<TradeRun>, TradeError> {
    let system = System::new(scene.clone())?;
    let mut runs = Vec::new();
    for setting in settings {
        // A solver without a step of its own is drawn from a sample every millisecond.
        let grid = grid(scene, setting.step_s().unwrap_or(1e-3))?;
        let Ok(run) = setting.solver().run(&system, &grid) else { continue };
        runs.push(TradeRun {
            solver: setting.solver.into(),
            step_s: setting.step_s(),
            motion_changes: Story::of(&system, &run).motion_changes(),
            theta_rad: run.theta_rad().collect(),
            t_s: run.t_s,
        });
    }
    Ok(runs)
}

/// One row per sample of each run. There are too many for typed rows.
///
/// # Errors
/// None that finished runs can cause.
pub fn courses_table(scene: &ModelScene, runs: &[TradeRun]) -> Result<Table, TableError> {
    let solvers = runs.iter().flat_map(|run| repeat_n(Some(run.solver.clone()), run.t_s.len()));
    let steps = runs.iter().flat_map(|run| repeat_n(run.step_s, run.t_s.len()));
    let changes =
        runs.iter().flat_map(|run| repeat_n(Some(run.motion_changes as i64), run.t_s.len()));
    let columns = vec![
        Column::text("solver", "the solver", solvers),
        Column::float("step_s", "s", "its step; none for one that finds events", steps),
        Column::float("t_s", "s", "time", runs.iter().flat_map(|run| &run.t_s).copied().map(Some)),
        Column::float(
            "theta_rad",
            "rad",
            "lever angle",
            runs.iter().flat_map(|run| &run.theta_rad).copied().map(Some),
        ),
        Column::integer("motion_changes", "1", "changes of the way of moving in the run", changes),
    ];
    let table = Table::new("courses", &format!("{}: courses", scene.name), columns)?;
    Ok(table.with_note(MODEL))
}
