//! `cargo xtask board`: a board with the twin behind it, at the end of a line that looks like a
//! serial port. `zwidth acquire STUDY … --device rig:PORT` records from it.

use anyhow::{Context as _, bail};
use std::io::ErrorKind;
use std::path::Path;
use std::time::{Duration, Instant};
use zwidth_device::{Device as _, Person, Priority, Twin, TwinParameters};
use zwidth_link::{AngleAt, Board, LINKS, Link, Pair, Settings, Wire as _};
use zwidth_study::Study;

/// How long it waits for bytes before it looks whether its watchdog is due.
const TURN: Duration = Duration::from_millis(1);
/// Readings a second of a link that streams.
const STREAM_HZ: f64 = 200.0;

/// Firmata with the 10 bits of an Arduino Uno's analog input: some hosts know no others.
const UNO: &str = "firmata-uno";
const UNO_BITS: u8 = 10;

/// Runs until it is stopped. The study says which environments its participant meets.
pub(crate) fn run(study: &Path, link: &str, seed: u64) -> anyhow::Result<()> {
    let board = Plugged::new(study, link, seed)?;
    println!("a board is at {}", board.port().display());
    println!("rig.toml for it:\n\n{}", toml::to_string(&board.settings)?);
    board.serve()
}

/// A board and its load cell, each at the end of a line.
pub(crate) struct Plugged {
    board: Board,
    line: Pair,
    cell: Pair,
    /// What rig.toml must say.
    pub(crate) settings: Settings,
}

impl Plugged {
    pub(crate) fn new(study: &Path, link: &str, seed: u64) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(study).with_context(|| study.display().to_string())?;
        let study = Study::from_toml(&text).map_err(|faults| anyhow::anyhow!("{faults:?}"))?;
        let mut links = [&LINKS[..], &[(UNO, Link::Firmata, AngleAt::Analog(0))]].concat();
        // A program is no board, and has no line: examples/device/lever.py is one.
        links.retain(|(_, link, _)| *link != Link::Process);
        let Some((word, link, angle)) = links.iter().find(|(word, _, _)| *word == link) else {
            let words: Vec<&str> = links.iter().map(|(word, _, _)| *word).collect();
            bail!("a board speaks {}", words.join(", "));
        };
        let twin = Twin::new(TwinParameters::default(), Person::draw(seed), seed)?;
        let line = Pair::open()?;
        let cell = Pair::open()?;
        let settings =
            Settings::of_board(*link, *angle, STREAM_HZ, twin.capabilities(), cell.port());
        let board = match &settings.firmata {
            Some(pins) if *word == UNO => {
                Board::firmata(twin, study.environments, pins.clone(), UNO_BITS)
            }
            _ => Board::by(&settings, twin, study.environments)?,
        };
        Ok(Self { board, line, cell, settings })
    }

    /// Where a host finds it.
    pub(crate) fn port(&self) -> &Path {
        self.line.port()
    }

    /// Until the process ends.
    pub(crate) fn serve(mut self) -> anyhow::Result<()> {
        // What runs at a host does not slow a board.
        let _ = Priority::raise();
        let began = Instant::now();
        loop {
            let mut bytes = [0; 256];
            let mut out = Vec::new();
            let came = self.line.receive(&mut bytes, TURN)?;
            self.board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out)?;
            send(&mut self.line, &out)?;
            send(&mut self.cell, &self.board.load_cell())?;
        }
    }
}

/// What nobody reads is gone, as on a real line.
fn send(line: &mut Pair, bytes: &[u8]) -> anyhow::Result<()> {
    match line.send(bytes) {
        Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => Ok(()),
        sent => Ok(sent?),
    }
}
