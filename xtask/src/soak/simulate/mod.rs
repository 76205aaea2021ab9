//! Whole sessions under one seed each: the flow, a device, a disk in memory and a clock, and their
//! faults.
//!
//! A session of a few short trials is recorded in several lives. Each but the last is cut short by
//! what its seed draws: a kill, a power cut, a full disk, a pulled cable, a sensor that stops, a
//! late tick, a clock that jumps or steps, a person who leaves or presses stop, a participant's
//! screen that lies. (A power cut may leave any of the unsynced sectors.) After each life the
//! device is at 0 V, `recover` succeeds, `verify` finds nothing, and everything finished is there,
//! byte for byte. The last life ends the session in the drawn order, or is on a disk that
//! misdirects a sector (`astray`). One seed is one course of events, so a seed that fails can be
//! run again.

mod astray;
mod life;
mod participant;
mod person;
mod with;
mod world;

pub(crate) use with::With;

use crate::tried::note;
use anyhow::{bail, ensure};
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;
use with::Counts;

/// Failing seeds that are told one by one.
const TOLD: usize = 10;
/// Every so many seeds one is run twice and compared.
const TWICE: u64 = 100;

/// What happened how often, and the seeds that broke a promise, each with how.
type Tally = (Counts, Vec<(u64, String)>);

/// Simulates `seeds` sessions from seed `first` on; prints what happened, and fails if a promise
/// was broken.
pub(crate) fn simulate(with: With, seeds: u64, first: u64) -> anyhow::Result<()> {
    // What a device's own code does on purpose is caught by the guard, and told by nobody else.
    std::panic::set_hook(Box::new(|_| {}));
    let began = Instant::now();
    let tried = |(mut counts, mut broken): Tally, seed: u64| {
        if let Err(why) = one(with, seed, &mut counts) {
            broken.push((seed, format!("{why:#}")));
        }
        (counts, broken)
    };
    let both = |(mut counts, mut broken): Tally, (more, others): Tally| {
        more.into_iter().for_each(|(what, n)| *counts.entry(what).or_default() += n);
        broken.extend(others);
        (counts, broken)
    };
    let seeds_tried = (first..first.saturating_add(seeds)).into_par_iter();
    let (counts, mut broken) = seeds_tried.fold(Tally::default, tried).reduce(Tally::default, both);
    let took_s = began.elapsed().as_secs_f64();
    println!(
        "{seeds} seeds from {first}, {with:?}: {took_s:.0} s, {:.2} ms each",
        1e3 * took_s / seeds as f64
    );
    counts.iter().for_each(|(what, n)| println!("{n:>10}  {what}"));
    broken.sort();
    for (seed, why) in broken.iter().take(TOLD) {
        println!("seed {seed}: {why}");
    }
    println!("{} promises broken", broken.len());
    let what = match with {
        With::Mock => {
            "sessions of a device and a disk that fail, with sectors torn and astray and steps of the \
             time of day, each with faults drawn from its seed"
        }
        With::Twin => "sessions of the simulated device, each with faults drawn from its seed",
    };
    let command = format!("cargo xtask soak {} {seeds} {first}", with.chore());
    note(what, command, seeds, broken.len() as u64, began)?;
    if let Some((seed, _)) = broken.first() {
        bail!("look at one again with `cargo xtask soak simulate 1 {seed}`");
    }
    Ok(())
}

/// One seed; what broke, in words.
fn one(with: With, seed: u64, counts: &mut Counts) -> anyhow::Result<()> {
    let run = |counts: &mut Counts| {
        let caught = catch_unwind(AssertUnwindSafe(|| life::session(with, seed, counts)));
        caught.unwrap_or_else(|_| bail!("it panicked"))
    };
    let disk = run(counts)?;
    if seed.is_multiple_of(TWICE) {
        *counts.entry("seeds run twice, the same bytes").or_default() += 1;
        ensure!(run(&mut Counts::new())? == disk, "run twice it leaves other bytes");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_seeds_keep_every_promise_with_either_device() {
        let mut counts = Counts::new();
        for seed in 0..6 {
            one(With::Mock, seed, &mut counts).unwrap();
        }
        assert!(counts["answers heard from a participant's screen that lies"] > 0, "{counts:?}");
        one(With::Twin, 1, &mut Counts::new()).unwrap();
    }

    #[test]
    fn a_disk_that_loses_what_was_synced_is_found_out() {
        let found = (0..40).any(|seed| life::session_on_a_liar(seed).is_err());
        assert!(found, "the simulation sees nothing");
    }

    #[test]
    fn the_time_of_day_steps_back_within_a_session_whose_order_stays() {
        let stepped_back = (0..60).filter(|seed| life::steps_back(*seed).unwrap());
        // Who puts events in the order of their times would put these in another.
        assert!(stepped_back.count() > 5);
    }
}
