//! `zwidth open`: a study's page in the browser, or as one file.

use super::output::Output;
use super::study;
use crate::args::Open;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_report::single_file;
use zwidth_store::Layout;

pub(crate) fn open(root: &Path, command: &Open, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let page = zwidth_plan::page_file(&layout);
    let shown = layout.shown(&page).display();
    if !page.is_file() {
        bail!("there is no {shown}; make it with `zwidth run {}`", command.study);
    }
    if let Some(file) = &command.single_file {
        write_single(&layout, &page, file)?;
        screen.result(format!("{}", file.display()));
        return Ok(Exit::Fine);
    }
    screen.result(format!("{shown}"));
    open::that_detached(&page).with_context(|| {
        format!("no browser could be started; open {} yourself", page.display())
    })?;
    Ok(Exit::Fine)
}

/// Writes the page as one file, which may not lie among recordings.
fn write_single(layout: &Layout, page: &Path, file: &Path) -> anyhow::Result<()> {
    let beside = page.parent().unwrap_or(Path::new(""));
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let named = file.file_stem().and_then(|stem| stem.to_str());
    let is_html = file.extension().is_some_and(|extension| extension == "html");
    let Some(name) = named.filter(|_| is_html) else {
        bail!("{} must end in .html", file.display());
    };
    let folder = folder.canonicalize();
    let folder = folder.with_context(|| {
        format!("the folder of {} does not exist; make it first", file.display())
    })?;
    if layout.raw().canonicalize().is_ok_and(|raw| folder.starts_with(raw)) {
        bail!("{} is inside raw/; choose another folder", file.display());
    }
    let html = std::fs::read_to_string(page).with_context(|| page.display().to_string())?;
    let read = |path: &str| {
        let path = beside.join(path);
        std::fs::read(&path).map_err(|error| {
            std::io::Error::new(error.kind(), format!("{}: {error}", path.display()))
        })
    };
    let one = single_file(&html, read).context("the page as one file")?;
    Output::new(&folder, BTreeMap::new()).text(name, "html", &one)
}
