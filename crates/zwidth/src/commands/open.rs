//! `zwidth open`: a study's page in the browser, or as one file.

use super::output::Output;
use super::study;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::io;
use std::path::{Path, PathBuf};
use zwidth_report::single_file;
use zwidth_runner::Results;
use zwidth_store::{Layout, MOST_BYTES, RealFiles, StoreError};
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct OpenArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Write the page with its figures and samples into this one file, to send or to keep, and open
    /// nothing
    #[arg(long, value_name = "FILE.html")]
    pub(crate) single_file: Option<PathBuf>,
}

pub(crate) fn open(root: &Path, command: &OpenArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let page = zwidth_plan::page_file(&layout);
    let shown = layout.shown(&page).display();
    if !page.is_file() {
        bail!("there is no {shown}; make it with `zwidth run {}`", command.study);
    }
    if let Some(file) = &command.single_file {
        write_single(&layout, file)?;
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
fn write_single(layout: &Layout, file: &Path) -> anyhow::Result<()> {
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let named = file.file_stem().and_then(|stem| stem.to_str());
    let is_html = file.extension().is_some_and(|extension| extension == "html");
    let Some(name) = named.filter(|_| is_html) else {
        bail!("{} must end in .html", file.display());
    };
    // Links resolved, so that none leads into raw/.
    let folder = folder.canonicalize();
    let folder = folder.with_context(|| {
        format!("the folder of {} does not exist; make it first", file.display())
    })?;
    if layout.raw().canonicalize().is_ok_and(|raw| folder.starts_with(raw)) {
        bail!("{} is inside raw/; choose another folder", file.display());
    }
    let study = layout.study();
    // How many bytes may still be read.
    let mut left = MOST_BYTES;
    // A regular file of the report by its path from the report's folder on, with `/`. The page
    // names them, and anybody may have edited it.
    let mut read = |path: &str| -> io::Result<Vec<u8>> {
        let named = Results::named(layout, &format!("reports/{study}/{path}")).map_err(|why| {
            io::Error::other(format!(
                "it names {path}, which is no file of this report: {why}; {AGAIN}"
            ))
        })?;
        let bytes = Results::new(layout, &RealFiles)
            .read(&named, left)
            .and_then(|content| {
                content.unwrap_or_else(|| Err(StoreError::new(&named, "it is missing", AGAIN)))
            })
            .map_err(io::Error::other)?;
        // `read` refuses more than what is left, so this cannot fall below zero.
        left -= bytes.len() as u64;
        Ok(bytes)
    };
    let page = zwidth_plan::page_file(layout);
    let html = String::from_utf8(read("index.html")?)
        .with_context(|| layout.shown(&page).display().to_string())?;
    let one =
        single_file(&html, read).with_context(|| layout.shown(&page).display().to_string())?;
    Output::new(&folder, []).text(name, "html", &one)
}

const AGAIN: &str = "make the report again with `zwidth run STUDY`";
