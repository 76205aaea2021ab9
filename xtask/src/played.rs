//! A session on a disk in memory and a simulated clock, by somebody who starts each trial.

use jiff::{SignedDuration, Timestamp};
use std::path::{Path, PathBuf};
use std::sync::Arc;
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

/// Plays a session to its end; `answers` where the device has a participant.
///
/// # Errors
/// What ended it before.
pub(crate) fn play<W: Fn(f64)>(
    plan: &Plan,
    disk: &Memory,
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    person: &mut Person<W>,
    answers: bool,
) -> Result<Outcome, String> {
    let begin = BEGIN.parse::<Timestamp>().map_err(told)?;
    let utc = move |now_s: f64| {
        let since = SignedDuration::from_millis((now_s * 1e3) as i64);
        begin.checked_add(since).unwrap_or(begin).to_string()
    };
    let options = Options {
        live: false,
        answers,
        by_hand: false,
        steps: Vec::new(),
        ask: false,
        no_watchdog: device.capabilities().watchdog_s.is_none(),
        markers: device.capabilities().shows_moments.then_some(Target::Board).into_iter().collect(),
        by: None,
        stop: Arc::default(),
        quit: Arc::default(),
    };
    let session = Session::open(plan, device.capabilities(), disk).map_err(told)?;
    let parts = Parts { device, clock, files: disk, front: person, utc: &utc };
    run(plan, session, &options, parts).map_err(told)
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
pub(crate) fn short_study(rate_hz: f64, limit_s: f64) -> Result<String, String> {
    let mut table: toml::Table = template(&id()?).parse().map_err(told)?;
    let environments = table.get_mut("environments").and_then(toml::Value::as_array_mut);
    environments.ok_or("the template lost its environments")?.truncate(1);
    for (of, key, value) in [
        ("design", "repeats", toml::Value::from(1)),
        ("design", "familiarisation", 0.into()),
        ("design", "trial_limit_s", limit_s.into()),
        ("design", "pause_s", 0.4.into()),
        ("control", "rate_hz", rate_hz.into()),
    ] {
        let of = table.get_mut(of).and_then(toml::Value::as_table_mut);
        of.map(|of| of.insert(key.to_owned(), value)).ok_or("the template lost a table")?;
    }
    toml::to_string(&table).map_err(told)
}

pub(crate) fn id() -> Result<zwidth_study::StudyId, String> {
    "wire".parse().map_err(told)
}

/// A study on a disk of its own.
pub(crate) fn plan(study_toml: &str) -> Result<(Memory, Plan), String> {
    let disk = Memory::new();
    let layout = Layout::new(Path::new("/simulated"), id()?);
    let study = Study::from_toml(study_toml).map_err(|e| format!("{e:?}"))?;
    disk.put(&layout.study_toml(), study_toml.as_bytes());
    let plan = Plan {
        layout,
        study_toml: study_toml.as_bytes().to_vec(),
        participant: "P01".parse().map_err(told)?,
        session: "S01".parse().map_err(told)?,
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

pub(crate) fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}
