//! `zwidth methods`: what was done, in words.

use crate::args::Methods;
use crate::exit::Exit;
use crate::screen::Screen;
use std::path::Path;
use zwidth_plan as plan;
use zwidth_report::methods as parts;
use zwidth_store::StudyData;

pub(crate) fn methods(root: &Path, asked: &Methods, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = super::study(root, asked.study.clone())?;
    let data = StudyData::load(&layout).map_err(|findings| super::join_findings(&findings))?;
    let parts = parts(&data.study, &plan::recorded(&data), env!("CARGO_PKG_VERSION"));
    screen.file(&asked.format.written(&parts));
    Ok(Exit::Fine)
}
