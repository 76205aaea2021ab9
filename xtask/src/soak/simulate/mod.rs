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

use crate::tried::{Tried, note};
use anyhow::{bail, ensure};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::ScopedJoinHandle;
use std::time::Instant;
use with::Counts;

/// Failing seeds that are told one by one.
const TOLD: usize = 10;
/// Every so many seeds one is run twice and compared.
const TWICE: u64 = 100;
/// Seeds at once.
const AT_ONCE: usize = 2;

/// Simulates `seeds` sessions from seed `first` on; prints what happened, and fails if a promise
/// was broken.
pub(crate) fn simulate(with: With, seeds: u64, first: u64) -> anyhow::Result<()> {
    if cfg!(debug_assertions) {
        let numbers = [seeds, first].map(|number| number.to_string());
        return super::optimised(&[with.chore(), &numbers[0], &numbers[1]]);
    }
    // What a device's own code does on purpose is caught by the guard, and told by nobody else.
    std::panic::set_hook(Box::new(|_| {}));
    let next = AtomicU64::new(first);
    let began = Instant::now();
    let last = first.saturating_add(seeds);
    let counts = Mutex::new(Counts::new());
    let broken = Mutex::new(Vec::new());
    let work = || {
        let mut mine = Counts::new();
        let mut failed = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= last {
                break;
            }
            if let Err(why) = one(with, seed, &mut mine) {
                failed.push((seed, why));
            }
        }
        if let (Ok(mut counts), Ok(mut broken)) = (counts.lock(), broken.lock()) {
            mine.into_iter().for_each(|(what, n)| *counts.entry(what).or_default() += n);
            broken.extend(failed);
        }
    };
    std::thread::scope(|scope| -> anyhow::Result<()> {
        let threads: Vec<ScopedJoinHandle<'_, ()>> =
            (0..AT_ONCE).map(|_| scope.spawn(work)).collect();
        let ended = threads.into_iter().all(|thread| thread.join().is_ok());
        ensure!(ended, "a thread of the simulation panicked");
        Ok(())
    })?;
    let counts = counts.into_inner().unwrap_or_default();
    let mut broken = broken.into_inner().unwrap_or_default();
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
    note(&Tried {
        what: match with {
            With::Mock => {
                "sessions of a device and a disk that fail, with sectors torn and astray and steps of the \
                 time of day, each with faults drawn from its seed"
                    .to_owned()
            }
            With::Twin => {
                "sessions of the simulated device, each with faults drawn from its seed".to_owned()
            }
        },
        command: format!("cargo xtask soak {} {seeds} {first}", with.chore()),
        times: seeds,
        broken: broken.len() as u64,
        seconds: took_s,
    })?;
    if let Some((seed, _)) = broken.first() {
        bail!("look at one again with `cargo xtask soak simulate 1 {seed}`");
    }
    Ok(())
}

/// One seed; what broke, in words.
fn one(with: With, seed: u64, counts: &mut Counts) -> Result<(), String> {
    let run = |counts: &mut Counts| {
        let caught = catch_unwind(AssertUnwindSafe(|| life::session(with, seed, counts)));
        caught.unwrap_or_else(|_| Err("it panicked".to_owned()))
    };
    let disk = run(counts)?;
    if seed.is_multiple_of(TWICE) {
        *counts.entry("seeds run twice, the same bytes").or_default() += 1;
        if run(&mut Counts::new())? != disk {
            return Err("run twice it leaves other bytes".to_owned());
        }
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
