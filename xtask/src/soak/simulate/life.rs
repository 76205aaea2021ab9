//! The lives of a session, and what must hold after each.

use super::participant::Liar;
use super::person::Person;
use super::with::{Counts, With};
use super::world::{Draw, Late, Trouble, study};
use anyhow::{Context as _, anyhow, bail, ensure};
use jiff::{SignedDuration, Timestamp};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use zwidth_acquire::{Front, Options, Outcome, Parts, Session, Verdict, run};
use zwidth_device::mock::{Fault as DeviceFault, Mock};
use zwidth_device::{Device, Person as Hand, Twin, TwinParameters};
use zwidth_store::{
    Memory, StudyData, Survives, Trial, TrialEntry, hex_blake3, recover, verify_kept,
};
use zwidth_study::{Status, Voltages};

/// Lives that go wrong, at most, before the one that ends the session.
const MOST_LIVES: u64 = 4;
/// Lives that end a session once nothing goes wrong any more: a stop within one may send the person
/// home.
const LAST_LIVES: u64 = 3;
/// Of so many sessions one ends on a disk that leads a sector astray.
const ASTRAY_ONE_IN: u64 = 5;
/// The first day of the simulation.
pub(super) const BEGIN: &str = "2026-01-01T08:00:00Z";
/// The board's watchdog has run out by then, s.
const LATER_S: f64 = 1.0;

/// The files of a disk.
type Disk = BTreeMap<PathBuf, Vec<u8>>;

/// Records the session of a seed in several lives; the disk that it leaves. The error is what was
/// promised and did not hold.
pub(super) fn session(with: With, seed: u64, counts: &mut Counts) -> anyhow::Result<Disk> {
    let mut count = |what, n| *counts.entry(what).or_default() += n;
    let mut desk = Desk::new(with, seed)?;
    let lives = Draw::new(seed, 2).below(MOST_LIVES + 1);
    for life in 0..lives {
        let trouble = Trouble::draw(&mut Draw::new(seed, 10 + life));
        trouble.words().into_iter().for_each(|word| count(word, 1));
        let lies = u64::from(Liar::is_drawn(seed, life));
        count("lives beside a participant's screen that lies", lies);
        let left = desk.live(life, &trouble, false).with_context(|| format!("life {life}"))?;
        count(if left.is_ok() { "lives left in order" } else { "lives cut short" }, 1);
    }
    if Draw::new(seed, 3).one_in(ASTRAY_ONE_IN) {
        count(desk.astray(lives).context("a sector astray")?, 1);
        return Ok(desk.disk.below(Path::new("/")));
    }
    for life in lives..lives + LAST_LIVES {
        let outcome = desk.live(life, &Trouble::none(), true).context("last life")?;
        let outcome = outcome.context("the last life ended with")?;
        if outcome.done == outcome.total {
            count("trials that were finished and stayed", desk.finished.len() as u64);
            count("answers heard from a participant's screen that lies", desk.heard);
            return Ok(desk.disk.below(Path::new("/")));
        }
    }
    bail!("the session does not come to its end")
}

/// A session on a disk that loses everything once: what must be found out.
#[cfg(test)]
pub(super) fn session_on_a_liar(seed: u64) -> anyhow::Result<()> {
    let mut desk = Desk::new(With::Mock, seed)?;
    desk.live(0, &Trouble::none(), true)??;
    let lost = desk.finished.keys().next().cloned().context("no trial")?;
    let without: Disk =
        desk.disk.below(Path::new("/")).into_iter().filter(|(path, _)| *path != lost).collect();
    desk.disk = Memory::new();
    without.iter().for_each(|(path, bytes)| desk.disk.put(path, bytes));
    desk.settle().map(drop)
}

/// Whether the times in the log of a session go back at some line, on a disk that works and with a
/// time of day that steps.
#[cfg(test)]
pub(super) fn steps_back(seed: u64) -> anyhow::Result<bool> {
    let mut desk = Desk::new(With::Mock, seed)?;
    let steps = Trouble::draw(&mut Draw::new(seed, 10)).steps;
    desk.live(0, &Trouble { steps, ..Trouble::none() }, true)??;
    let log = desk.plan.layout.events(&desk.plan.participant, &desk.plan.session);
    let text = desk.disk.below(&log).remove(&log).unwrap_or_default();
    let times: Vec<Timestamp> = String::from_utf8_lossy(&text)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|line| line["utc"].as_str()?.parse().ok())
        .collect();
    Ok(!times.is_sorted())
}

/// A session, its disk, and what was promised of it so far.
pub(super) struct Desk {
    pub(super) seed: u64,
    with: With,
    pub(super) disk: Memory,
    pub(super) plan: zwidth_acquire::Plan,
    /// The session's record, once it lies there: its hash.
    record: Option<String>,
    /// The files of finished trials, and their hashes.
    pub(super) finished: BTreeMap<PathBuf, String>,
    /// Answers that a participant's screen that lies gave to an open question.
    heard: u64,
}

impl Desk {
    pub(super) fn new(with: With, seed: u64) -> anyhow::Result<Self> {
        let (disk, plan) = study(seed)?;
        Ok(Self { seed, with, disk, plan, record: None, finished: BTreeMap::new(), heard: 0 })
    }

    /// One life, and what must hold after it; how it was left.
    pub(super) fn live(
        &mut self,
        life: u64,
        trouble: &Trouble,
        diligent: bool,
    ) -> anyhow::Result<anyhow::Result<Outcome>> {
        let (outcome, shown) = self.life(life, trouble, diligent)?;
        let done = self.settle()?;
        // A person who asked for a trial again, or a life that never saw the session, promises
        // nothing.
        let may_lack = trouble.survives != Survives::Everything;
        ensure!(done >= shown || may_lack, "{shown} trials were shown as done, and {done} are");
        Ok(outcome)
    }

    /// One life: how it was left, and the trials that were shown as done.
    pub(super) fn life(
        &mut self,
        life: u64,
        trouble: &Trouble,
        diligent: bool,
    ) -> anyhow::Result<(anyhow::Result<Outcome>, usize)> {
        if let Some((steps, fault)) = trouble.disk {
            self.disk.fail_in(steps, fault);
        }
        let mut draw = Draw::new(self.seed, 20 + life);
        let mut person = Person::new(&mut draw, diligent);
        let mut liar = Liar::beside(&mut person, self.seed, life);
        let mut mock = Mock::default();
        mock.faults.extend(trouble.device);
        let mut clock = Late::new(
            self.seed,
            trouble.late.then(|| Draw::new(self.seed, 30 + life)),
            self.with.nap_s(),
        );
        let utc = time_of_day(life, trouble)?;
        let outcome = match self.with {
            With::Mock => {
                // A device whose code fails takes the program with it, on a simulated clock: nobody
                // stands between.
                let recorded = || self.record(&mut mock, &mut clock, &mut liar, &utc);
                let caught = catch_unwind(AssertUnwindSafe(recorded));
                let asked = matches!(trouble.device, Some((_, DeviceFault::Panic)));
                match caught {
                    Ok(outcome) => outcome,
                    Err(_) if asked => Err(anyhow!("the device's code failed")),
                    Err(panic) => resume_unwind(panic),
                }
            }
            With::Twin => {
                let hand = Hand::draw(self.seed);
                let mut twin = Twin::new(TwinParameters::default(), hand, self.seed)?;
                self.record(&mut twin, &mut clock, &mut liar, &utc)
            }
        };
        if let Some(broken) = liar.broken.take() {
            bail!(broken);
        }
        self.heard += liar.heard;
        drop(liar);
        let shown = person.done;
        if self.with == With::Mock {
            is_at_0_v(&mock, trouble)?;
        }
        self.disk.restart(trouble.survives);
        Ok((outcome, shown))
    }

    fn record(
        &self,
        device: &mut dyn Device,
        clock: &mut Late,
        front: &mut dyn Front,
        utc: &(dyn Fn(f64) -> String + Sync),
    ) -> anyhow::Result<Outcome> {
        let options = Options { answers: self.with == With::Twin, ..Options::default() };
        let session = Session::open(&self.plan, device.capabilities(), &self.disk)?;
        let judge = |trial: &Trial| {
            let trial = trial.meta.trial;
            let is_unmet = Draw::new(self.seed, 100 + u64::from(trial)).one_in(4);
            Some(Verdict { trial, unmet: is_unmet.then(|| "no movement".to_owned()) })
        };
        let parts = Parts { device, clock, files: &self.disk, front, utc, judge: &judge };
        Ok(run(&self.plan, session, &options, parts)?)
    }

    /// Recovers what the life left, and checks what was promised; trials of the order that are
    /// done.
    pub(super) fn settle(&mut self) -> anyhow::Result<usize> {
        let layout = self.plan.layout.clone();
        for found in recover(&self.disk, &layout, BEGIN) {
            found.context("recover")?;
        }
        let findings = verify_kept(&self.disk, &layout);
        if let Some(finding) = findings.first() {
            bail!("verify finds {} after recover, first: {finding}", findings.len());
        }
        let files = self.disk.below(&layout.raw());
        for (path, hash) in &self.finished {
            let bytes = files.get(path);
            let bytes =
                bytes.with_context(|| format!("{} was finished and is gone", path.display()))?;
            let is_same = hex_blake3(bytes) == *hash;
            ensure!(is_same, "{} was finished and has changed", path.display());
        }
        let record = layout.session(&self.plan.participant, &self.plan.session);
        let found = files.get(&record).map(|bytes| hex_blake3(bytes));
        let is_kept = self.record.is_none() || self.record == found;
        ensure!(is_kept, "the session's record is gone or has changed");
        self.record = found;
        if self.record.is_none() {
            return Ok(0);
        }
        let data = StudyData::load_from(&self.disk, &layout).map_err(|e| anyhow!("{e:?}"))?;
        let log = data.sessions.first().context("the session is not in its study")?;
        for trial in &data.trials {
            let drawn = log.record.trials.iter().find(|planned| planned.trial == trial.meta.trial);
            let same = |p: &zwidth_study::PlannedTrial| {
                (&p.environment, &p.mode, p.repeat)
                    == (&trial.meta.environment, &trial.meta.mode, trial.meta.repeat)
            };
            let as_drawn = drawn.is_none_or(same);
            ensure!(as_drawn, "trial {} is another than was drawn", trial.meta.trial);
            if trial.meta.status == Status::Complete {
                self.finished.insert(trial.path.to_path_buf(), trial.blake3.clone());
            }
        }
        let holds =
            |t: &&TrialEntry| t.meta.status == Status::Complete && t.superseded_by.is_none();
        Ok(data.trials.iter().filter(holds).count())
    }
}

/// The voltages that a life leaves behind: none, at once by its own hand, or by the board's
/// watchdog.
fn is_at_0_v(mock: &Mock, trouble: &Trouble) -> anyhow::Result<()> {
    let (last_s, last) = mock.writes.last().copied().unwrap_or((0.0, Voltages::OFF));
    let unplugged = matches!(trouble.device, Some((_, DeviceFault::Unplugged)));
    ensure!(unplugged || last == Voltages::OFF, "the last write is {last:?}");
    let is_off = mock.output(last_s + LATER_S) == Voltages::OFF;
    ensure!(is_off, "the board still gives a voltage");
    Ok(())
}

/// The time of day at a time of the loop's clock: from a day of its own for each life on, or from
/// any other, with the steps that it takes on its way.
fn time_of_day(life: u64, trouble: &Trouble) -> anyhow::Result<impl Fn(f64) -> String + Sync> {
    let begin: Timestamp = BEGIN.parse()?;
    let days = if trouble.jumps { 400 * (1 - 2 * (life as i64 % 2)) } else { life as i64 };
    let begin = begin.checked_add(SignedDuration::from_hours(24 * days))?;
    let steps = trouble.steps.clone();
    Ok(move |now_s: f64| {
        let taken = steps.iter().filter(|(at_s, _)| *at_s <= now_s);
        let stepped_ms: i64 = taken.map(|(_, by_s)| 1000 * by_s).sum();
        let since = SignedDuration::from_millis((now_s * 1e3) as i64 + stepped_ms);
        begin.checked_add(since).unwrap_or(begin).to_string()
    })
}
