//! A session on a disk in memory and a simulated clock, by somebody who starts each trial.

use anyhow::{Context as _, anyhow};
use jiff::{SignedDuration, Timestamp};
use std::path::{Path, PathBuf};
use std::time::Duration;
use zwidth_acquire::{
    AcquireError, Front, Input, Options, Outcome, Parts, Phase, Plan, Session, Target, View, run,
};
use zwidth_device::{Clock, Device};
use zwidth_store::{Layout, Memory};
use zwidth_study::{Calibration, Study, template};

/// After a stop somebody looks at the rig for so long, s.
const LOOKS_S: f64 = 2.0;
/// Stops after which even the most patient person leaves.
const MOST_STOPS: u32 = 6;
const BEGIN: &str = "2026-01-01T08:00:00Z";

/// Plays a session to its end, or to what ends it before; `answers` where the device has a
/// participant.
pub(crate) fn play<W: Fn(f64)>(
    plan: &Plan,
    disk: &Memory,
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    person: &mut Person<W>,
    answers: bool,
) -> anyhow::Result<Outcome> {
    let begin: Timestamp = BEGIN.parse()?;
    let utc = move |now_s: f64| {
        let since = SignedDuration::from_millis((now_s * 1e3) as i64);
        begin.checked_add(since).unwrap_or(begin).to_string()
    };
    let options = Options {
        answers,
        no_watchdog: device.capabilities().watchdog_s.is_none(),
        markers: device.capabilities().shows_moments.then_some(Target::Board).into_iter().collect(),
        ..Options::default()
    };
    let session = Session::open(plan, device.capabilities(), disk)?;
    let parts = Parts { device, clock, files: disk, front: person, utc: &utc, judge: &|_| None };
    Ok(run(plan, session, &options, parts)?)
}

/// Somebody who starts each trial, answers, and after a stop looks at the rig and goes on.
pub(crate) struct Person<W> {
    /// Lets so much time pass, s.
    wait: W,
    phase: Phase,
    /// How often the session was stopped.
    pub(crate) stops: u32,
}

impl<W: Fn(f64)> Person<W> {
    pub(crate) fn new(wait: W) -> Self {
        Self { wait, phase: Phase::Check, stops: 0 }
    }
}

impl<W: Fn(f64)> Front for Person<W> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        self.phase.clone_from(&view.phase);
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        Ok(match self.phase {
            Phase::Ready | Phase::AtStop => Some(Input::Start),
            Phase::Question { .. } => Some(Input::Answer(3)),
            Phase::Done => Some(Input::Quit),
            Phase::Stopped { .. } => {
                self.stops += 1;
                (self.wait)(LOOKS_S);
                Some(if self.stops > MOST_STOPS { Input::Quit } else { Input::Start })
            }
            _ => {
                (self.wait)(wait.as_secs_f64());
                None
            }
        })
    }
}

/// The template's study with one environment and short trials.
pub(crate) fn short_study(rate_hz: f64, limit_s: f64) -> anyhow::Result<String> {
    let fields = [
        ("design", "repeats", toml::Value::from(1)),
        ("design", "familiarisation", 0.into()),
        ("design", "trial_limit_s", limit_s.into()),
        ("design", "pause_s", 0.4.into()),
        ("control", "rate_hz", rate_hz.into()),
    ];
    changed_template(WIRE, &[("environments", 1)], fields)
}

/// The template's study with the first of some lists alone, and with these fields of its tables.
pub(crate) fn changed_template<const N: usize>(
    id: &str,
    lists: &[(&str, usize)],
    fields: [(&str, &str, toml::Value); N],
) -> anyhow::Result<String> {
    let mut table: toml::Table = template(&id.parse()?).parse()?;
    for (list, length) in lists {
        let list = table.get_mut(*list).and_then(toml::Value::as_array_mut);
        list.context("the template lost a list")?.truncate(*length);
    }
    for (of, key, value) in fields {
        let of = table.get_mut(of).and_then(toml::Value::as_table_mut);
        of.context("the template lost a table")?.insert(key.to_owned(), value);
    }
    Ok(toml::to_string(&table)?)
}

/// The study of the sessions over a wire.
pub(crate) const WIRE: &str = "wire";

/// A study on a disk of its own.
pub(crate) fn plan(id: &str, study_toml: &str) -> anyhow::Result<(Memory, Plan)> {
    let disk = Memory::new();
    let layout = Layout::new(Path::new("/simulated"), id.parse()?);
    let study = Study::from_toml(study_toml).map_err(|e| anyhow!("{e:?}"))?;
    disk.put(&layout.study_toml(), study_toml.as_bytes());
    let plan = Plan {
        layout,
        study_toml: study_toml.as_bytes().to_vec(),
        participant: "P01".parse()?,
        session: "S01".parse()?,
        calibration: Calibration::thesis(),
        software: "simulation 1".to_owned(),
        rate_hz: study.control.rate_hz,
        study,
        seed: None,
        keys: PathBuf::from("/simulated/keys"),
        secret: [9; 32],
        accept_study_change: false,
    };
    Ok((disk, plan))
}
