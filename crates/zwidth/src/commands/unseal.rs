//! `zwidth unseal`: opens a blinded session's seal. This is an event of the session, visible to
//! every reader of its log.

use super::device::keys;
use super::recover::{lock, now, put_in_order_and_tell};
use super::{join_findings, session, study};
use crate::commands::device::Keys;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use std::path::Path;
use zwidth_acquire::{left_to_do, vault};
use zwidth_store::{Raw, RealFiles, StudyData, commit_events};
use zwidth_study::{ParticipantId, SessionId, StudyId};

#[derive(Debug, clap::Args)]
pub(crate) struct UnsealArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// Even if trials are still to come, which are not blind then
    #[arg(long)]
    pub(crate) unfinished: bool,
    #[command(flatten)]
    pub(crate) keys: Keys,
}

pub(crate) fn unseal(root: &Path, command: &UnsealArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth unseal")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let log = session(&data, &command.participant, &command.session)?;
    let name = format!("session {} of {}", command.session, command.participant);
    if log.seal.is_some() {
        screen.say(format!("{name} is unsealed already"));
        return Ok(Exit::Fine);
    }
    let seal = vault::find(&RealFiles, &keys(&command.keys, true)?, layout.study(), &log.record);
    let open = left_to_do(&data.trials, log, &data.study, seal.as_ref().ok());
    if open > 0 && !command.unfinished {
        bail!(
            "{name} has {open} trials to go, which would not be blind: finish it with `zwidth acquire {} -p {} -s {}`, \
             or say --unfinished",
            command.study,
            command.participant,
            command.session
        );
    }
    let seal = seal?;
    // Before anything is written: a seal that does not fit the order must not open it.
    seal.opened(&log.record.trials)?;
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    commit_events(&raw, &layout, &now(), &[(&log.events_path, &[seal.event()])])?;
    screen.result(format!(
        "{name} is unsealed: its order is the one that was committed to before the first trial"
    ));
    Ok(Exit::Fine)
}
