//! What must hold after a session, whatever happened to one of its messages.

use super::lever::{Counted, force_counts};
use super::links::Over;
use super::session::Ended;
use anyhow::{Context as _, anyhow, bail, ensure};
use std::collections::BTreeSet;
use std::path::Path;
use zwidth_link::simulated::Trouble;
use zwidth_link::{Drive, Link};
use zwidth_store::{Signal, StudyData, read_trial_from, verify_kept};
use zwidth_study::Status;

/// Judges what a session left; the error is the promise that was broken.
pub(super) fn judge(over: Over, trouble: Option<Trouble>, ended: &Ended) -> anyhow::Result<()> {
    let Ended { done, total, .. } = ended;
    ensure!(done == total, "{done} of {total} trials are done");
    // Without a watchdog and without a cable nobody takes a voltage away, but it is said. Without a
    // check a bit of the very last word may turn 0 V into another voltage, and nobody knows.
    let unheard = ended.warned && !over.link.is_asked();
    let misheard =
        ended.was_last && over.believes(Trouble::Corrupt) > 0 && trouble == Some(Trouble::Corrupt);
    ensure!(
        ended.drive == Drive::default() || unheard || misheard,
        "the board still gives a voltage: {:?}",
        ended.drive
    );
    let is_left_on = ended.left_on && over.link.is_asked();
    ensure!(!is_left_on, "a voltage stayed on without its cable");
    if let Some(finding) = verify_kept(&ended.disk, &ended.layout).first() {
        bail!("verify finds: {finding}");
    }
    let data = StudyData::load_from(&ended.disk, &ended.layout).map_err(|e| anyhow!("{e:?}"))?;
    let whole = data.trials.iter().filter(|trial| trial.meta.status == Status::Complete);
    ensure!(whole.count() >= *total, "a finished trial is gone");
    let may = trouble.map_or(0, |trouble| over.believes(trouble));
    let mut wrong = Vec::new();
    for trial in &data.trials {
        wrong.extend(wrong_readings(over, trouble, ended, &trial.path)?);
    }
    ensure!(wrong.len() <= may, "recorded is what the board never saw, {may} may be: {wrong:?}");
    Ok(())
}

/// The readings of a trial as they came over the wire, without those that repeat the one before.
pub(super) fn readings(ended: &Ended, path: &Path) -> anyhow::Result<Vec<Recorded>> {
    let trial = read_trial_from(&ended.disk, path, Signal::all())?;
    let column = |signal| trial.samples.get(signal).with_context(|| format!("no {signal:?}"));
    let raw = column(Signal::ThetaRaw)?;
    let forces = column(Signal::ForceEx)?;
    let times = trial.samples.get(Signal::DeviceTime);
    let mut readings: Vec<_> = (0..raw.len())
        .map(|i| {
            let t_us = times.map(|times| (times[i] * 1e6).round() as u64);
            (t_us, raw[i] as u16, force_counts(forces[i]))
        })
        .collect();
    readings.dedup();
    Ok(readings)
}

/// A reading of a trial: the board's clock, µs, where it has one, and the counts of angle and
/// force.
pub(super) type Recorded = (Option<u64>, u16, i32);

/// The readings of a trial that the board never saw: over frames and lines, of text or of a program, by its clock, angle and
/// force together; over Firmata, which has no clock and brings the force by another way, by each of
/// the two, and by the angle's way forward.
fn wrong_readings(
    over: Over,
    trouble: Option<Trouble>,
    ended: &Ended,
    path: &Path,
) -> anyhow::Result<Vec<Recorded>> {
    let readings = readings(ended, path)?;
    let seen: BTreeSet<Counted> = ended.seen.iter().copied().collect();
    if over.link == Link::Firmata {
        // Behind a late marker the lever goes its way at another time than its trial.
        let forwards = !matches!(trouble, Some(Trouble::Late(_)));
        return Ok(wrong_apart(&seen, &readings, forwards));
    }
    // A sketch that begins anew begins its clock anew.
    let by_clock = over.link.is_asked() || trouble != Some(Trouble::Reset);
    let pairs: BTreeSet<(u16, i32)> = seen.iter().map(|(_, a, f)| (*a, *f)).collect();
    let wrong = readings.into_iter().filter(|(t_us, angle, force)| match t_us {
        Some(t_us) if by_clock => !seen.contains(&(*t_us, *angle, *force)),
        _ => !pairs.contains(&(*angle, *force)),
    });
    Ok(wrong.collect())
}

/// Those whose angle or whose force is none that was seen, or whose angle goes back; each once.
fn wrong_apart(seen: &BTreeSet<Counted>, readings: &[Recorded], forwards: bool) -> Vec<Recorded> {
    let angles: BTreeSet<u16> = seen.iter().map(|(_, angle, _)| *angle).collect();
    let forces: BTreeSet<i32> = seen.iter().map(|(_, _, force)| *force).collect();
    let mut wrong = Vec::new();
    let mut strange_angle = None;
    let mut strange_force = None;
    let mut last = readings.first().map(|(_, angle, _)| *angle);
    let mut before = last;
    for reading in readings {
        let (_, angle, force) = *reading;
        let goes_back = |from: Option<u16>| from.is_some_and(|from| !forward(from, angle));
        let back = forwards && goes_back(last);
        if back && angles.contains(&angle) && last != before && !goes_back(before) {
            // The one before was too far, at an angle that came later: it is the one that is wrong.
            wrong.push(*reading);
            last = Some(angle);
        } else if (back || !angles.contains(&angle)) && strange_angle != Some(angle) {
            strange_angle = Some(angle);
            wrong.push(*reading);
        }
        if !forces.contains(&force) && strange_force != Some(force) {
            strange_force = Some(force);
            wrong.push(*reading);
        }
        // What follows a wrong angle is judged by the right one before it.
        if strange_angle != Some(angle) && last != Some(angle) {
            (before, last) = (last, Some(angle));
        }
    }
    wrong
}

/// Whether one count follows another on the lever's way forward, round and round.
fn forward(from: u16, to: u16) -> bool {
    const PER_TURN: u16 = 4096;
    to.wrapping_sub(from) % PER_TURN < PER_TURN / 2
}
