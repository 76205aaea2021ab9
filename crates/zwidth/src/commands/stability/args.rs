//! The arguments of `zwidth stability`.

use crate::limits::{MOST_CELLS, setting, span};
use std::path::PathBuf;
use zwidth_results::WallQuantity;
use zwidth_study::{ParticipantId, SessionId, StudyId};

#[derive(Debug, clap::Args)]
pub(crate) struct StabilityArgs {
    /// A scene, whose device, spring and step are taken [default: the simulated device of
    /// docs/twin.md]
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// Another value of a quantity, in SI units: delay=0.0083, wall_damping=2; each may be given.
    /// Quantities: step, mass, damping, wall_damping, stiffness, lever, finger, delay, rate
    #[arg(long, value_name = "QUANTITY=VALUE", value_parser = setting)]
    pub(crate) at: Vec<(WallQuantity, f64)>,
    /// What runs along x, with its ends in SI units; with --y one map in place of six
    #[arg(long, value_name = "QUANTITY[=FROM..TO]", value_parser = span, requires = "y")]
    pub(crate) x: Option<(WallQuantity, Option<[f64; 2]>)>,
    /// What runs along y
    #[arg(long, value_name = "QUANTITY[=FROM..TO]", value_parser = span, requires = "x")]
    pub(crate) y: Option<(WallQuantity, Option<[f64; 2]>)>,
    /// Cells a side of a map
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=MOST_CELLS))]
    pub(crate) cells: u32,
    /// Boundaries that others measured, drawn too: files with the columns K and B
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) beside: Vec<PathBuf>,
    /// Instead of maps: was what swings in this study's recorded trials real? Each trial's loop is
    /// run again
    #[arg(long, value_name = "STUDY", conflicts_with_all = ["scene", "at", "x", "y", "beside"])]
    pub(crate) study: Option<StudyId>,
    /// Of this participant's trials alone
    #[arg(long, short, value_name = "P01", requires = "study")]
    pub(crate) participant: Option<ParticipantId>,
    /// Of this session's trials alone
    #[arg(long, short, value_name = "S01", requires = "study")]
    pub(crate) session: Option<SessionId>,
    /// Of this trial alone
    #[arg(long, value_name = "N", requires_all = ["participant", "session"])]
    pub(crate) trial: Option<u32>,
    /// Folder to write to [default: reports/stability; of a study reports/STUDY/stability]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
