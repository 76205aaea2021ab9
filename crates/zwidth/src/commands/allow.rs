//! `zwidth allow`: says what the study's own stages and its device would run, and remembers that this
//! person allows it.

use super::consent::{keep, place, withdraw};
use super::device::{device_program, rig};
use super::why::short;
use super::{join_findings, study};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_plan::{ReadScript, read_script};
use zwidth_store::read_study;
use zwidth_study::{StudyId, command_line};

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

/// A program of the study, as it is shown before it is allowed.
#[derive(Serialize)]
struct Shown {
    /// The stage that it is, or "device".
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
        screen.result(format!("{id}: what it runs {what}"));
        return Ok(Exit::Fine);
    }
    let study = read_study(&layout).map_err(|findings| join_findings(&findings))?;
    let rig = rig(&layout)?;
    let device = device_program(&layout, rig.as_ref())?;
    if study.stages.is_empty() && device.is_none() {
        bail!(
            "{id} has no stage of its own, and no device that is a program, so that there is nothing to allow; \
             [[stage]] of study.toml names a stage, [process] of rig.toml a device"
        );
    }
    let show = |name: String, command: &[String], script: &ReadScript| {
        let files = script.files.iter().map(|file| {
            let path = layout.analysis().join(&file.file);
            (layout.shown(&path).display().to_string(), file.blake3.clone())
        });
        Shown {
            stage: name,
            command: command.to_vec(),
            files: files.collect(),
            digest: script.digest.clone(),
        }
    };
    let mut shown = Vec::new();
    let mut digests = BTreeMap::new();
    for stage in &study.stages {
        let script = read_script(layout.root(), id, stage)?;
        shown.push(show(stage.id.to_string(), &stage.command, &script));
        digests.insert(stage.id.clone(), script.digest);
    }
    if let Some((program, script)) = &device {
        shown.push(show("device".to_owned(), &program.command, script));
    }
    screen.give(&shown, || {
        for own in &shown {
            screen.result(format!("{}: {}", own.stage, command_line(&own.command)));
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
    keep(&layout, digests, device.map(|(_, script)| script.digest))?;
    screen.say(format!(
        "Allowed in {}. Another command, another content of one of these files, or a copy of the study elsewhere \
         asks again; `zwidth allow {id} --withdraw` takes it back.",
        place(&layout)?.display()
    ));
    Ok(Exit::Fine)
}
