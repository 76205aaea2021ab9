//! `zwidth import`: recordings of other rigs, as a mapping file says.

use super::recover::{lock, now};
use super::{join_findings, study, sum_up};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use zwidth_import::{By, Guess, Mapping, Step, bytes_of, guess, import as import_files};
use zwidth_store::commit::settle;
use zwidth_store::{Raw, RealFiles, read_study};
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct ImportArgs {
    /// The study the recordings belong to; its study.toml must exist
    #[arg(required_unless_present = "guess")]
    pub(crate) study: Option<StudyId>,
    /// The mapping file: their columns to ours; with --guess, where the guess is written
    #[arg(long, value_name = "MAP.toml", required_unless_present = "guess")]
    pub(crate) map: Option<PathBuf>,
    /// The recordings
    #[arg(required_unless_present = "guess")]
    pub(crate) files: Vec<PathBuf>,
    /// Guess a mapping file from recordings (their columns from the first, whose they are from all
    /// names) and print it, to be edited; nothing is imported
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["study", "files"])]
    pub(crate) guess: Vec<PathBuf>,
}

/// Prints a guessed mapping, or writes it where no file is yet.
fn guessed(
    file: &Path,
    others: &[PathBuf],
    map: Option<&Path>,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let Guess { mapping: text, apart } = guess(file, others)?;
    let exit = if apart.is_empty() { Exit::Fine } else { Exit::Partly };
    for file in &apart {
        screen.warn(file.to_string());
    }
    let Some(map) = map else {
        screen.result(text.trim_end());
        return Ok(exit);
    };
    if map.exists() {
        bail!("{} exists already; name another file with --map", map.display());
    }
    // Another program may have made the file since: it is not overwritten.
    let mut new = std::fs::File::create_new(map)
        .with_context(|| format!("cannot write {}", map.display()))?;
    new.write_all(text.as_bytes()).with_context(|| format!("cannot write {}", map.display()))?;
    screen.result(format!(
        "{}: guessed; edit what stands at TODO, then import with it",
        map.display()
    ));
    Ok(exit)
}

pub(crate) fn import(root: &Path, command: &ImportArgs, screen: &Screen) -> anyhow::Result<Exit> {
    if let Some((file, others)) = command.guess.split_first() {
        return guessed(file, others, command.map.as_deref(), screen);
    }
    let (Some(id), Some(map)) = (&command.study, &command.map) else {
        bail!(
            "name the study, the mapping file (--map) and the recordings; `zwidth import --guess FILE --map map.toml` \
             writes a mapping file to edit"
        );
    };
    let layout = study(root, id.clone())?;
    let mapping = Mapping::read(map).map_err(|findings| sum_up(&findings))?;
    let lock = lock(&layout, "zwidth import").map_err(|e| anyhow!("{e}; nothing was imported"))?;
    let study = read_study(&layout).map_err(|findings| join_findings(&findings))?;
    let raw = Raw::mends(&RealFiles, &layout, &lock);
    for left in settle(&raw, &layout) {
        screen.say(left.map_err(|e| anyhow!("{e}; nothing was imported"))?.to_string());
    }
    let utc = now();
    let by = By { utc: &utc, software: concat!("zwidth ", env!("CARGO_PKG_VERSION")) };
    let read = screen.bytes(bytes_of(&command.files));
    let written = screen.bar(0);
    let progress = |step: Step| match step {
        Step::Read(bytes) => read.inc(bytes),
        Step::Written { all } => {
            if !read.is_finished() {
                read.finish_and_clear();
                written.set_length(all as u64);
                // Its time begins now.
                written.reset();
            }
            written.inc(1);
        }
    };
    let files = &command.files;
    let report = import_files(&layout, &study, &mapping, files, by, &raw, &progress);
    read.finish_and_clear();
    written.finish_and_clear();
    let report = report.map_err(|findings| sum_up(&findings))?;
    screen.give(&report, || screen.result(report.to_string()))?;
    Ok(if report.is_doubtful() { Exit::Partly } else { Exit::Fine })
}
