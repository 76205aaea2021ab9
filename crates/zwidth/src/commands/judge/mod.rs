//! `zwidth judge`: a trajectory that another program computed for a scene, beside the right answer.

mod advice;
pub(super) mod trajectory;
pub(super) mod words;

use super::compare::listing;
use super::simulate::scene_file::SceneFile;
use crate::exit::Exit;
use crate::limits::positive;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow};
use serde_json::json;
use std::path::{Path, PathBuf};
use zwidth_import::Mapping;
use zwidth_judge::{Allowed, Yardstick, judge as judge_one};
use zwidth_results::{JudgedTrajectory, Row as _, TrajectoryFault, TrajectoryVerdict};
use zwidth_study::Perception;
use zwidth_tables::Table;

/// What stands with every table of judged trajectories.
pub(super) const NOTE: &str = "Trajectories of models, not measurements.";

#[derive(Debug, clap::Args)]
pub(crate) struct JudgeArgs {
    /// The scene that the program simulated, as for `zwidth simulate`
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: PathBuf,
    /// The trajectory: time, angle and, if there is one, velocity, in any file that `zwidth import`
    /// reads; columns are recognised by names such as t_s, theta_rad, theta_dot_rad_s, angle_deg
    #[arg(long, value_name = "FILE")]
    pub(crate) trajectory: PathBuf,
    /// A mapping that says which columns they are, as for `zwidth import`
    #[arg(long, value_name = "MAP.toml")]
    pub(crate) map: Option<PathBuf>,
    /// Error of the angle that is allowed, in degrees
    #[arg(long, value_name = "DEG", value_parser = positive, default_value_t = Allowed::default().theta_rad.to_degrees())]
    pub(crate) tolerance_deg: f64,
    /// Error of an event's time that is allowed, in ms
    #[arg(long, value_name = "MS", value_parser = positive, default_value_t = 1e3 * Allowed::default().event_s)]
    pub(crate) tolerance_ms: f64,
    /// The program that computed it, such as mujoco or diffrax: what to change is then said in its
    /// words, where they are known
    #[arg(long, value_name = "NAME")]
    pub(crate) engine: Option<String>,
}

pub(crate) fn judge(command: &JudgeArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let scene = SceneFile::read(&command.scene)?;
    let mapping = command.map.as_deref().map(Mapping::read).transpose();
    let mapping = mapping.map_err(|findings| super::sum_up(&findings))?;
    let lever_m = scene.scene.plant.lever_m;
    let read = trajectory::read(&command.trajectory, mapping.as_ref(), lever_m)?;
    let perception = Perception::default();
    let yardstick = Yardstick::of(&scene.scene, &perception).map_err(|e| scene.error(&e.into()))?;
    let allowed = Allowed {
        theta_rad: command.tolerance_deg.to_radians(),
        event_s: 1e-3 * command.tolerance_ms,
        ..Allowed::default()
    };
    let judged = judge_one(&yardstick, &read.candidate, &allowed, &perception)
        .map_err(|e| anyhow!("{e}"))
        .with_context(|| command.trajectory.display().to_string())?;
    let name = file_name(&command.trajectory);
    let judged = judged.named(&name, command.engine.as_deref(), None, None);
    let tables = [table(std::slice::from_ref(&judged.trajectory))?, faults_table(&judged.faults)?];
    if screen.json {
        let tables = tables.iter().map(listing).collect::<Result<Vec<_>, _>>()?;
        screen.listing(&json!({ "columns": read.converted, "tables": tables }))?;
    } else {
        let lines = words::lines(&judged, &yardstick, &allowed, &read.converted, screen.verbose);
        lines.iter().for_each(|line| screen.result(line));
    }
    let passes = [TrajectoryVerdict::Right, TrajectoryVerdict::Stands];
    let is_right = passes.contains(&judged.trajectory.verdict);
    Ok(if is_right { Exit::Fine } else { Exit::Partly })
}

/// The name of a trajectory: its file's.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Judged trajectories as a table.
pub(super) fn table(rows: &[JudgedTrajectory]) -> anyhow::Result<Table> {
    let table = Table::of_rows(rows)?.called(JudgedTrajectory::NAME, JudgedTrajectory::TITLE);
    Ok(table.with_note(NOTE))
}

/// Their faults as a table.
pub(super) fn faults_table(rows: &[TrajectoryFault]) -> anyhow::Result<Table> {
    let table = Table::of_rows(rows)?.called(TrajectoryFault::NAME, TrajectoryFault::TITLE);
    Ok(table.with_note(NOTE))
}
