//! `cargo xtask board`: a board with the twin behind it, at the end of a line that looks like a
//! serial port: `zwidth acquire STUDY … --device rig:PORT` records from it.

use anyhow::Context as _;
use std::path::Path;
use std::time::{Duration, Instant};
use zwidth_device::{Person, Twin, TwinParameters};
use zwidth_link::board::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use zwidth_link::{Board, Pair, Wire as _};
use zwidth_study::Study;

/// How long it waits for bytes before it looks whether its watchdog is due.
const TURN: Duration = Duration::from_millis(1);

/// Runs until it is stopped. The study says which environments its participant meets.
pub(crate) fn run(study: &Path, seed: u64) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(study).with_context(|| study.display().to_string())?;
    let study = Study::from_toml(&text).map_err(|faults| anyhow::anyhow!("{faults:?}"))?;
    let twin = Twin::new(TwinParameters::default(), Person::draw(seed), seed)?;
    let (mut board, mut line) = (Board::new(twin, study.environments), Pair::open()?);
    println!("a board is at {}", line.port().display());
    println!(
        "rig.toml for it: newtons_per_count = {NEWTONS_PER_COUNT}, zero_counts = {ZERO_COUNTS:?}"
    );
    let began = Instant::now();
    loop {
        let (mut bytes, mut out) = ([0; 256], Vec::new());
        let came = line.receive(&mut bytes, TURN)?;
        board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out)?;
        line.send(&out)?;
    }
}
