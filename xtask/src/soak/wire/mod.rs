//! Whole sessions over each link on a simulated clock, with a fault in each of their messages in
//! turn.
//!
//! A session of a few short trials is recorded once to count its messages: those of the host, of
//! the board, and of a load cell at a port of its own. Then it is recorded again for each message
//! and each fault: the message is dropped, sent twice, has a flipped bit, is cut in half, comes
//! late by more than the other port's next message (so that the two ports' messages change places)
//! or by much more, the board restarts, or the cable is pulled and plugged in again. After each
//! fault the session must have ended, every finished trial must be there whole, the board must be
//! at 0 V, and no sample may be one that the board never saw. [`Over::believes`] and docs/rig.md
//! say what links without a check may believe.

mod judge;
mod lever;
mod links;
mod session;
mod whole;

pub(crate) use whole::whole;

use crate::tried::note;
use anyhow::{Context as _, ensure};
use judge::judge;
use links::Over;
use rayon::prelude::*;
use session::record;
use std::collections::BTreeMap;
use std::time::Instant;
use zwidth_link::simulated::{Trouble, Way};

/// What happens to a message, and what it is called where it is counted.
const TROUBLES: [(&str, Trouble); 8] = [
    ("dropped", Trouble::Drop),
    ("twice", Trouble::Duplicate),
    ("a bit turned over", Trouble::Corrupt),
    ("half of it", Trouble::Half),
    ("late by 30 ms, behind the other port's", Trouble::Late(0.03)),
    ("late by 300 ms", Trouble::Late(0.3)),
    ("the board begins anew", Trouble::Reset),
    ("its cable pulled and plugged in again", Trouble::Unplug(1.0)),
];
/// Broken promises that are told one by one.
const TOLD: usize = 40;

/// One session with one message gone wrong.
#[derive(Debug, Clone, Copy)]
struct Case {
    over: Over,
    way: Way,
    nth: u64,
    name: &'static str,
    trouble: Trouble,
}

/// Every `every`th case of a link: each message, each trouble.
fn cases(over: Over, every: usize) -> anyhow::Result<Vec<Case>> {
    let clean = record(over, None)?;
    judge(over, None, &clean)?;
    let of = |way: Way| (0..clean.said[way as usize]).map(move |nth| (way, nth));
    let all = Way::ALL.into_iter().flat_map(of).flat_map(|(way, nth)| {
        TROUBLES.map(|(name, trouble)| Case { over, way, nth, name, trouble })
    });
    Ok(all.step_by(every).collect())
}

/// One case; how often the session was stopped, or what broke.
fn one(case: Case) -> Result<u32, String> {
    let Case { over, way, nth, name, trouble } = case;
    let ended = record(over, Some((way, nth, trouble)));
    let judged = ended.and_then(|ended| judge(over, Some(trouble), &ended).map(|()| ended.stops));
    judged.map_err(|why| format!("{}, {way:?} {nth} {name}: {why:#}", over.name))
}

/// Cases that are tried; how many, how often their sessions were stopped, and what broke.
fn tried(cases: &[Case]) -> (BTreeMap<&'static str, [u64; 2]>, Vec<String>) {
    let judged: Vec<Result<u32, String>> = cases.par_iter().map(|case| one(*case)).collect();
    let mut counts = BTreeMap::<&'static str, [u64; 2]>::new();
    let mut broken = Vec::new();
    for (case, judged) in cases.iter().zip(judged) {
        let [all, stopped] = counts.entry(case.name).or_default();
        *all += 1;
        match judged {
            Ok(stops) => *stopped += u64::from(stops > 0),
            Err(why) => broken.push(why),
        }
    }
    (counts, broken)
}

/// Every `every`th message of a session over each link gone wrong in every way.
pub(crate) fn wire(every: usize) -> anyhow::Result<()> {
    let began = Instant::now();
    let mut times = 0;
    let mut broken = Vec::new();
    for over in Over::all() {
        let cases = cases(over, every).context(over.name)?;
        let (counts, why) = tried(&cases);
        println!(
            "{}: {} sessions, {} promises broken, {:.0} s so far",
            over.name,
            cases.len(),
            why.len(),
            began.elapsed().as_secs_f64()
        );
        for (name, [all, stopped]) in counts {
            println!("{all:>10}  {name}; {stopped} of them stopped it, and it went on");
        }
        times += cases.len() as u64;
        broken.extend(why);
    }
    broken.iter().take(TOLD).for_each(|why| println!("{why}"));
    println!("{} promises broken", broken.len());
    let what = "sessions over a serial line, each with one message gone wrong";
    let command = format!("cargo xtask soak wire {every}");
    note(what, command, times, broken.len() as u64, began)?;
    ensure!(times > 0, "nothing was tried");
    ensure!(broken.is_empty(), "a message that goes wrong breaks a promise");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_messages_of_a_session_over_each_link_gone_wrong_break_no_promise() {
        for over in Over::all() {
            // No multiple of the number of troubles, so that each comes to its turn.
            let cases = cases(over, 101).unwrap();
            assert!(cases.len() > 20, "{}: {} cases", over.name, cases.len());
            let (counts, broken) = tried(&cases);
            assert_eq!(broken, Vec::<String>::new());
            assert_eq!(counts.len(), TROUBLES.len());
        }
    }

    #[test]
    fn a_wrong_sample_and_a_voltage_that_stays_are_found_out() {
        let over = Over::all().next().unwrap();
        let mut ended = record(over, None).unwrap();
        judge(over, None, &ended).unwrap();
        ended.drive.motor = 1;
        assert!(judge(over, None, &ended).unwrap_err().to_string().contains("voltage"));
        ended.drive.motor = 0;
        ended.told.remove(ended.told.len() / 2);
        ended.seen.clear();
        assert!(judge(over, None, &ended).unwrap_err().to_string().contains("never saw"));
    }

    #[test]
    #[ignore = "every message: minutes; .ci/long has the chore"]
    fn every_message_of_a_session_over_each_link_gone_wrong_breaks_no_promise() {
        wire(1).unwrap();
    }
}
