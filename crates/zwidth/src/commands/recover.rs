//! `zwidth recover`: repairs what a kill or a power cut left.

use super::{join_findings, study};
use crate::exit::Exit;
use crate::screen::Screen;
use jiff::Timestamp;
use serde::Serialize;
use std::path::Path;
use std::time::SystemTime;
use zwidth_store::{
    Layout, Raw, RealFiles, StoreError, StudyLock, accept_study, owner, recover as recover_study,
};
use zwidth_study::{ParticipantId, SessionId, StudyId};

#[derive(Debug, clap::Args)]
pub(crate) struct RecoverArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Accept a study.toml that has changed since sessions began: `verify` notes it then, and
    /// warns no more
    #[arg(long)]
    pub(crate) accept_study_change: bool,
    /// Of this participant's session alone
    #[arg(long, short, value_name = "P01", requires_all = ["session", "accept_study_change"])]
    pub(crate) participant: Option<ParticipantId>,
    /// Of this session alone
    #[arg(long, short, value_name = "S01", requires_all = ["participant", "accept_study_change"])]
    pub(crate) session: Option<SessionId>,
}

#[derive(Serialize)]
struct Line {
    file: String,
    what: String,
    ok: bool,
}

pub(crate) fn recover(root: &Path, command: &RecoverArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth recover")?;
    let mut lines = put_in_order(&layout, &lock);
    if command.accept_study_change {
        lines.extend(accepted(&layout, &lock, command)?);
    }
    let exit = if lines.iter().all(|l| l.ok) { Exit::Fine } else { Exit::Partly };
    screen.give(&lines, || {
        for line in &lines {
            if line.ok { screen.result(&line.what) } else { screen.warn(&line.what) }
        }
        if lines.is_empty() {
            screen.result(format!("{}: nothing to recover", layout.study()));
        }
    })?;
    Ok(exit)
}

/// Accepts the present `study.toml`, for one session or for all to which a change of it matters.
fn accepted(layout: &Layout, lock: &StudyLock, command: &RecoverArgs) -> anyhow::Result<Vec<Line>> {
    let only = command.participant.as_ref().zip(command.session.as_ref());
    let raw = Raw::adds(&RealFiles, layout, lock);
    let accepted =
        accept_study(&raw, layout, &now(), only).map_err(|findings| join_findings(&findings))?;
    let file = layout.study_toml().display().to_string();
    let none = accepted.is_empty().then(|| "study.toml: no change waits to be accepted".to_owned());
    Ok(accepted
        .into_iter()
        .chain(none)
        .map(|what| Line { file: file.clone(), what, ok: true })
        .collect())
}

/// The right to write to a study.
pub(super) fn lock(layout: &Layout, command: &str) -> Result<StudyLock, StoreError> {
    StudyLock::take(layout, &owner(command, &now()))
}

/// The time of day, UTC. A clock that is set past the year 9999 has no date any more.
pub(super) fn now() -> String {
    Timestamp::try_from(SystemTime::now()).unwrap_or(Timestamp::MAX).to_string()
}

/// Recovers a study and tells what was done, for a command that is to write to it.
pub(super) fn put_in_order_and_tell(layout: &Layout, lock: &StudyLock, screen: &Screen) {
    for line in put_in_order(layout, lock) {
        if line.ok { screen.say(line.what) } else { screen.warn(line.what) }
    }
}

fn put_in_order(layout: &Layout, lock: &StudyLock) -> Vec<Line> {
    let line = |path: &Path, what: String, ok| Line { file: path.display().to_string(), what, ok };
    let repairs = recover_study(&Raw::mends(&RealFiles, layout, lock), layout, &now()).into_iter();
    let lines = repairs.map(|repair| match repair {
        Ok(done) => line(&done.path, done.to_string(), true),
        Err(error) => line(&error.path, error.to_string(), false),
    });
    lines.collect()
}
