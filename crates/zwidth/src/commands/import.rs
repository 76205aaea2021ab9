//! `zwidth import`: recordings of other rigs, as a mapping file says.

use super::recover::lock;
use super::{join_findings, study};
use crate::args::Import;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::anyhow;
use std::path::Path;
use zwidth_import::{Mapping, import as import_files};
use zwidth_store::started::settle;
use zwidth_store::{Raw, RealFiles, read_study};

pub(crate) fn import(root: &Path, command: &Import, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let mapping = Mapping::read(&command.map).map_err(|findings| join_findings(&findings))?;
    let lock = lock(&layout, "zwidth import").map_err(|e| anyhow!("{e}; nothing was imported"))?;
    let study = read_study(&layout).map_err(|findings| join_findings(&findings))?;
    let raw = Raw::mends(&RealFiles, &layout, &lock);
    for left in settle(&raw, &layout) {
        screen.say(left.map_err(|e| anyhow!("{e}; nothing was imported"))?.to_string());
    }
    let utc = jiff::Timestamp::now().to_string();
    let software = concat!("zwidth ", env!("CARGO_PKG_VERSION"));
    let report = import_files(&layout, &study, &mapping, &command.files, &utc, software, &raw)
        .map_err(|findings| join_findings(&findings))?;
    if screen.json {
        screen.listing(&report)?;
    } else {
        screen.result(report.to_string());
    }
    Ok(Exit::Fine)
}
