//! `zwidth import`: recordings of other rigs, as a mapping file says.

use super::recover::lock;
use super::{study, together};
use crate::args::Import;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow};
use std::path::Path;
use zwidth_store::import::{Mapping, import as import_files};
use zwidth_store::{RealFiles, read_study};

pub(crate) fn import(root: &Path, command: &Import, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let study = read_study(&layout).map_err(|findings| together(&findings))?;
    let text = read(&command.map)?;
    let mapping = Mapping::from_toml(&text, &command.map).map_err(|findings| together(&findings))?;
    let utc = jiff::Timestamp::now().to_string();
    let software = concat!("zwidth ", env!("CARGO_PKG_VERSION"));
    let _lock = lock(&layout, "zwidth import").map_err(|e| anyhow!("{e}; nothing was imported"))?;
    let report = import_files(&layout, &study, &mapping, &command.files, &utc, software, &RealFiles)
        .map_err(|findings| together(&findings))?;
    if screen.json {
        screen.listing(&report)?;
    } else {
        screen.result(report.to_string());
    }
    Ok(Exit::Fine)
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}
