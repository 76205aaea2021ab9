//! The arguments of `zwidth trade`.

use std::path::PathBuf;
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct TradeArgs {
    /// Scenes, files that end in .toml, or studies, of which every condition is one, and whose
    /// trials are simulated with another loop and other sensors [default: all studies under raw/]
    #[arg(value_name = "SCENE.toml|STUDY")]
    pub(crate) scenes: Vec<PathBuf>,
    /// A study, as above
    #[arg(long, value_name = "STUDY")]
    pub(crate) study: Vec<StudyId>,
    /// Folder to write to [default: reports/trade; for a study reports/STUDY/timing]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Do everything again, whether it changed or not
    #[arg(long)]
    pub(crate) fresh: bool,
}
