//! `zwidth participant`: the participant's own screen, beside a session that is being recorded.

use super::device::{raised_by_signals, secret};
use super::study;
use crate::args::Participant;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::Context as _;
use std::io::{BufReader, stdin, stdout};
use std::path::Path;
use zwidth_acquire::{Beside, Door, Front, Guest, Look, place_of, show_lines, show_screen};
use zwidth_store::{Layout, PortFile, StudyLock, hex_blake3, read_port};

pub(crate) fn participant(
    root: &Path,
    command: &Participant,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let text = read_port(&layout)?;
    let (port, word) = text.as_deref().and_then(place_of).with_context(|| {
        format!(
            "no session of {} is being recorded; start it with `zwidth acquire` in another terminal, then open this screen",
            layout.study()
        )
    })?;
    let quit = raised_by_signals()?;
    let guest = Guest::enter(port, word)?;
    let is_over = if command.plain {
        show_lines(guest, BufReader::new(stdin()), stdout(), &quit)?
    } else {
        show_screen(guest, Look::from_env(command.ascii), &quit)?
    };
    screen.say(match is_over {
        true => "the session is over",
        false => "the participant's screen is closed; the session goes on",
    });
    Ok(Exit::Fine)
}

/// Where a participant's screen comes in, and the file that says where that is.
type Way = (Door, PortFile);

/// A way in for the participant's screen. A session goes on without one where there can be none.
pub(super) fn way(layout: &Layout, lock: &StudyLock, screen: &Screen) -> Option<Way> {
    let told = |error: &anyhow::Error| {
        screen.warn(format!(
            "`zwidth participant` cannot be used with this session, which goes on without: {error:#}"
        ));
    };
    opened(layout, lock).inspect_err(told).ok()
}

/// A door for whoever can read the study's file of it.
fn opened(layout: &Layout, lock: &StudyLock) -> anyhow::Result<Way> {
    let door = Door::open(&hex_blake3(&secret()?))
        .context("this machine gives no port for the participant's screen")?;
    let file = PortFile::write(layout, lock, &door.place())?;
    Ok((door, file))
}

/// That front end, with the participant's screen beside it where it has a way in.
pub(super) fn beside(front: Box<dyn Front>, way: Option<Way>) -> Box<dyn Front> {
    match way {
        Some((door, file)) => Box::new(Beside::new(front, door, Some(file))),
        None => front,
    }
}
