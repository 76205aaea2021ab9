//! The thesis' session of 36 trials over each link at its rate: every reading arrives.

use super::judge::{Recorded, readings};
use super::lever::Counted;
use super::links::Over;
use super::session::{Ended, played, settings};
use crate::played::WIRE;
use crate::tried::held;
use anyhow::{Context as _, anyhow, bail, ensure};
use std::time::Instant;
use zwidth_device::{Device as _, Person, Twin, TwinParameters};
use zwidth_link::Link;
use zwidth_store::StudyData;
use zwidth_study::{Status, template};

/// Trials of a session (thesis §5.2).
const TRIALS: usize = 36;
/// Ticks a second over frames, at a line that answers each in its tick, baud; and readings a second
/// of the others, each near to the most that its usual line carries.
const FRAMED: (f64, u32) = (1000.0, 1_000_000);
const FIRMATA_HZ: f64 = 333.0;
const TEXT_HZ: f64 = 400.0;

/// Sessions over every link; of the board's readings in each trial none is missing, none changed.
pub(crate) fn whole() -> anyhow::Result<()> {
    let began = Instant::now();
    let mut samples = 0;
    for over in Over::all() {
        samples += session(over, 6).context(over.name)?;
        println!("{}: {TRIALS} trials, {:.0} s so far", over.name, began.elapsed().as_secs_f64());
    }
    println!("{samples} readings, none lost");
    ensure!(samples > 0, "nothing was recorded");
    let what = "readings of sessions of 36 trials over each link at its rate, none lost";
    held(what, "cargo xtask soak wire-sessions".to_owned(), samples as u64, began)
}

/// A session with so many repeats of each condition; how many readings its trials have.
fn session(over: Over, repeats: u32) -> anyhow::Result<usize> {
    let (stream_hz, rate_hz, baud) = match over.link {
        Link::Framed => (100.0, FRAMED.0, Some(FRAMED.1)),
        Link::Process => (100.0, FRAMED.0, None),
        Link::Firmata => (FIRMATA_HZ, 1.25 * FIRMATA_HZ, None),
        _ => (TEXT_HZ, 1.25 * TEXT_HZ, None),
    };
    let twin = Twin::new(TwinParameters::default(), Person::draw(3), 5)?;
    let rig = settings(over, stream_hz, twin.capabilities(), baud);
    let study_toml = template(&WIRE.parse()?)
        .replace("\nfamiliarisation = 3\n", "\nfamiliarisation = 0\n")
        .replace("\nrepeats = 6\n", &format!("\nrepeats = {repeats}\n"))
        .replace("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {rate_hz:?}\n"));
    let ended = played(&study_toml, &rig, rig.baud(), twin, None, true)?;
    let data = StudyData::load_from(&ended.disk, &ended.layout).map_err(|e| anyhow!("{e:?}"))?;
    let done = data.trials.iter().filter(|trial| trial.meta.status == Status::Complete).count();
    let is_whole = (done, ended.stops) == (6 * repeats as usize, 0);
    ensure!(is_whole, "{done} trials are whole, stopped {} times", ended.stops);
    data.trials.iter().map(|trial| arrived(over, &ended, &trial.path)).sum()
}

/// Readings of a trial: what the board sent meanwhile, each of it once.
fn arrived(over: Over, ended: &Ended, path: &std::path::Path) -> anyhow::Result<usize> {
    let mut own = readings(ended, path)?;
    let alike = |(t_us, angle, force): &Recorded, told: &Counted| match over.link {
        Link::Firmata => *angle == told.1,
        _ => *t_us == Some(told.0) && (*angle, *force) == (told.1, told.2),
    };
    let mut told = ended.told.clone();
    if over.link.is_asked() {
        // The markers of its begin hold the first question back, and of two answers in one look the
        // newer counts.
        own.drain(..own.len().min(3));
    }
    if over.link == Link::Firmata {
        // No clock tells two readings of one angle apart.
        told.dedup_by_key(|told| told.1);
        own.dedup_by_key(|own| own.1);
    }
    let same = |window: &[Counted]| own.iter().zip(window).all(|(own, told)| alike(own, told));
    if told.windows(own.len()).any(same) {
        return Ok(own.len());
    }
    let begins = told.iter().position(|told| alike(&own[0], told));
    let same =
        begins.map(|at| own.iter().zip(&told[at..]).take_while(|(o, t)| alike(o, t)).count());
    bail!("{}: {same:?} of {} are what the board sent", path.display(), own.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_over_each_link_at_its_rate_has_every_reading_that_its_board_sent() {
        for over in Over::all() {
            assert!(session(over, 1).unwrap() > 1000, "{}", over.name);
        }
    }

    #[test]
    #[ignore = "36 trials over each link; .ci/long has the chore"]
    fn sessions_of_36_trials_have_every_reading() {
        for over in Over::all() {
            assert!(session(over, 6).unwrap() > 10_000, "{}", over.name);
        }
    }
}
