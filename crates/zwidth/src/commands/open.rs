//! `zwidth open`: a study's page in the browser, or as one file.

use super::study;
use crate::args::Open;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::path::Path;
use zwidth_report::single_file;
use zwidth_store::{RealFiles, replace};

pub(crate) fn open(root: &Path, command: &Open, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let page = zwidth_plan::page_file(&layout);
    let shown = layout.shown(&page).display();
    if !page.is_file() {
        bail!("there is no {shown}; make it with `zwidth run {}`", command.study);
    }
    if let Some(file) = &command.single_file {
        write_single(&page, file)?;
        screen.result(format!("{}", file.display()));
        return Ok(Exit::Fine);
    }
    screen.result(format!("{shown}"));
    open::that_detached(&page).with_context(|| {
        format!("no browser could be started; open {} yourself", page.display())
    })?;
    Ok(Exit::Fine)
}

fn write_single(page: &Path, file: &Path) -> anyhow::Result<()> {
    let folder = page.parent().unwrap_or(Path::new(""));
    let html = std::fs::read_to_string(page).with_context(|| page.display().to_string())?;
    let read = |path: &str| {
        let path = folder.join(path);
        let named = |error: std::io::Error| {
            std::io::Error::new(error.kind(), format!("{}: {error}", path.display()))
        };
        std::fs::read(&path).map_err(named)
    };
    let one = single_file(&html, read).context("the page as one file")?;
    if file.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        bail!("the folder of {} is not there", file.display());
    }
    replace(&RealFiles, file, one.as_bytes())?;
    Ok(())
}
