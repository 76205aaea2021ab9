//! `zwidth allow`: says what the study's own stages would run, and remembers that this person allows
//! it.

use super::consent::{keep, place, withdraw};
use super::why::short;
use super::{join_findings, study};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_plan::read_script;
use zwidth_store::read_study;
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct AllowArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Take back what was allowed
    #[arg(long)]
    pub(crate) withdraw: bool,
    /// Only say what would run; allow nothing
    #[arg(long, conflicts_with = "withdraw")]
    pub(crate) dry_run: bool,
}

/// A stage of the study's own, as it is shown before it is allowed.
#[derive(Serialize)]
struct Shown {
    stage: String,
    command: Vec<String>,
    files: BTreeMap<String, String>,
    digest: String,
}

pub(crate) fn allow(root: &Path, command: &AllowArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let id = layout.study();
    if command.withdraw {
        let what = match withdraw(&layout)? {
            true => "is allowed no more",
            false => "was not allowed",
        };
        screen.result(format!("{id}: what its stages run {what}"));
        return Ok(Exit::Fine);
    }
    let study = read_study(&layout).map_err(|findings| join_findings(&findings))?;
    if study.stages.is_empty() {
        bail!(
            "{id} has no stage of its own, so that there is nothing to allow; [[stage]] of study.toml names one"
        );
    }
    let mut shown = Vec::new();
    let mut digests = BTreeMap::new();
    for stage in &study.stages {
        let script = read_script(layout.root(), id, stage)?;
        let files = script.files.iter().map(|file| {
            let path = layout.analysis().join(&file.file);
            (layout.shown(&path).display().to_string(), file.blake3.clone())
        });
        shown.push(Shown {
            stage: stage.id.to_string(),
            command: stage.command.clone(),
            files: files.collect(),
            digest: script.digest.clone(),
        });
        digests.insert(stage.id.clone(), script.digest);
    }
    screen.give(&shown, || {
        for (own, stage) in shown.iter().zip(&study.stages) {
            screen.result(format!("{}: {}", own.stage, stage.command_line()));
            for (file, blake3) in &own.files {
                screen.result(format!("  {}  {file}", short(Some(blake3))));
            }
            if own.files.is_empty() {
                screen.result("  no files: a change of what it runs would not be noticed");
            }
        }
    })?;
    screen.say(
        "These programs run with your rights, and nothing keeps them in: they can read, change and send whatever \
         you can.",
    );
    if command.dry_run {
        screen.say("Nothing was allowed.");
        return Ok(Exit::Fine);
    }
    keep(&layout, digests)?;
    screen.say(format!(
        "Allowed in {}. Another command, another content of one of these files, or a copy of the study elsewhere \
         asks again; `zwidth allow {id} --withdraw` takes it back.",
        place(&layout)?.display()
    ));
    Ok(Exit::Fine)
}
