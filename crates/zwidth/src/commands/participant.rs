//! `zwidth participant`: the participant's own screen, beside a session that is being recorded.

use super::device::{raised_by_signals, secret};
use super::study;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::io::{BufReader, stdin, stdout};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use zwidth_acquire::{Beside, Door, Front, Guest, Look, Secret, place_of, show_lines, show_screen};
use zwidth_store::{Layout, PortFile, StudyLock, read_port};
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct ParticipantArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Lines in and out instead of the screen
    #[arg(long)]
    pub(crate) plain: bool,
    /// The screen in ASCII alone
    #[arg(long)]
    pub(crate) ascii: bool,
}

/// A screen that a signal ends gives its terminal back within this time, or not at all.
const LAST: Duration = Duration::from_millis(500);

pub(crate) fn participant(
    root: &Path,
    command: &ParticipantArgs,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let text = read_port(&layout)?;
    let (port, secret) = text.as_deref().and_then(place_of).with_context(|| {
        format!(
            "no session of {} is being recorded; start it with `zwidth acquire` in another terminal, then open this screen",
            layout.study()
        )
    })?;
    let quit = raised_by_signals()?;
    let guest = Guest::enter(port, &secret)?
        .coming_back(move || place_of(&read_port(&layout).ok().flatten()?));
    let plain = command.plain;
    let look = Look::from_env(command.ascii);
    let raised = Arc::clone(&quit);
    let (sender, shown) = channel();
    // A terminal that takes nothing would hold up a signal's end as well.
    thread::spawn(move || {
        let is_over = if plain {
            show_lines(guest, BufReader::new(stdin()), stdout(), &raised)
        } else {
            show_screen(guest, look, &raised)
        };
        // Who waits for it may have gone.
        let _ = sender.send(is_over);
    });
    let is_over = loop {
        let is_ending = quit.load(Ordering::SeqCst);
        match shown.recv_timeout(LAST) {
            Ok(is_over) => break is_over?,
            Err(RecvTimeoutError::Timeout) if !is_ending => {}
            Err(RecvTimeoutError::Timeout) => break false,
            Err(RecvTimeoutError::Disconnected) => {
                bail!("zwidth has a defect, and the screen ended; please report it")
            }
        }
    };
    screen.say(match is_over {
        true => "the session is over",
        false => "the participant's screen is closed; the session goes on",
    });
    Ok(Exit::Fine)
}

/// The file that says where a participant's screen comes in, and where that is.
type Way = (PortFile, Door);

/// A way in for the participant's screen. A session goes on without one where there can be none.
pub(super) fn way(layout: &Layout, lock: &StudyLock, screen: &Screen) -> Option<Way> {
    opened(layout, lock).inspect_err(|error| {
        screen.warn(format!(
            "`zwidth participant` cannot be used with this session, which goes on without: {error:#}"
        ));
    }).ok()
}

/// A door for whoever can read the study's file of it.
fn opened(layout: &Layout, lock: &StudyLock) -> anyhow::Result<Way> {
    let door = Door::open(Secret::new(secret()?))
        .context("this machine gives no port for the participant's screen")?;
    let file = PortFile::write(layout, lock, &door.place())?;
    Ok((file, door))
}

/// That front end, with the participant's screen beside it where it has a way in.
pub(super) fn beside(front: Box<dyn Front>, way: Option<Way>) -> Box<dyn Front> {
    match way {
        Some((file, door)) => Box::new(Beside::new(front, door.reception(), Some((file, door)))),
        None => front,
    }
}
