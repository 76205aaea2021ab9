//! A study of any trials at all, written with the store: short recordings of one smooth movement.

use crate::folders::listing;
use std::collections::BTreeMap;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zwidth_store::{
    Layout, Quantity, RealFiles, Samples, Signal, Sweep, Trial, append_events, hex_blake3,
    lay_down, log_sweeps, read_study, sweep_bytes, trial_bytes, write_new,
};
use zwidth_study::{
    Event, Kind, ParticipantId, PlannedTrial, SessionId, SessionRecord, Source, Status, StudyId,
    TrialMeta, template,
};
use zwidth_tables::Table;

/// The time of every event.
pub(crate) const UTC: &str = "2026-01-01T00:00:00Z";
/// Samples per second, and how many there are.
const RATE_HZ: f64 = 80.0;
const SAMPLES: u32 = 160;
/// Where the movement starts, how far it goes (rad), and how long it takes (s).
const START_RAD: f64 = -std::f64::consts::FRAC_PI_4;
const STROKE_RAD: f64 = 1.2;
const STROKE_S: f64 = 2.0;
/// The spring's stiffness, N/rad, and the friction on top of it, N.
const STIFFNESS_N_PER_RAD: f64 = 4.0;
const FRICTION_N: f64 = 0.2;

/// A study in a temporary folder: the template's design, and free motion besides.
pub(crate) struct Study {
    folder: TempDir,
    layout: Layout,
}

/// A trial to be written.
#[derive(Debug, Clone)]
pub(crate) struct Draft {
    pub(crate) trial: u32,
    pub(crate) repeat: u32,
    pub(crate) kind: Kind,
    pub(crate) status: Status,
    pub(crate) environment: &'static str,
    pub(crate) mode: &'static str,
    pub(crate) source: Source,
    /// The answer in the trial's file.
    pub(crate) likert: Option<i16>,
    /// A force in place of the spring's, N.
    pub(crate) force_n: Option<f64>,
    /// Whether there is a file of samples.
    pub(crate) samples: bool,
    /// What is said of the trial besides that it was recorded.
    pub(crate) events: Vec<Event>,
}

/// A trial that counts.
pub(crate) fn draft(trial: u32, environment: &'static str, mode: &'static str) -> Draft {
    Draft {
        trial,
        repeat: trial,
        kind: Kind::Trial,
        status: Status::Complete,
        environment,
        mode,
        source: Source::Recorded,
        likert: None,
        force_n: None,
        samples: true,
        events: Vec::new(),
    }
}

/// Trials of one condition, numbered as given.
pub(crate) fn repeats(
    environment: &'static str,
    mode: &'static str,
    trials: RangeInclusive<u32>,
) -> Vec<Draft> {
    trials.map(|n| draft(n, environment, mode)).collect()
}

impl Study {
    /// A study without trials.
    pub(crate) fn new(id: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), StudyId::new(id).unwrap());
        let free = "\n[[environments]]\nid = \"free\"\nlabel = \"Free motion\"\nkind = \"free\"\n";
        let text = template(layout.study()) + free;
        write_new(&RealFiles, &layout.study_toml(), text.as_bytes()).unwrap();
        Self { folder, layout }
    }

    pub(crate) fn root(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The file of a trial of session S01.
    pub(crate) fn trial(&self, participant: &str, trial: u32) -> PathBuf {
        self.layout.trial(&participant.parse().unwrap(), &session_id(), trial)
    }

    /// The event log of session S01.
    pub(crate) fn events(&self, participant: &str) -> PathBuf {
        self.layout.events(&participant.parse().unwrap(), &session_id())
    }

    /// The record of session S01.
    pub(crate) fn record(&self, participant: &str) -> PathBuf {
        self.layout.session(&participant.parse().unwrap(), &session_id())
    }

    /// A table below `derived/`.
    pub(crate) fn derived(&self, name: &str) -> Table {
        Table::from_parquet(&self.layout.derived().join(format!("{name}.parquet"))).unwrap()
    }

    /// The text of the summary, without what protects signs of Markdown.
    pub(crate) fn summary(&self) -> String {
        let path = self.layout.reports().join("summary.md");
        fs::read_to_string(path).unwrap().replace('\\', "")
    }

    /// The file of the sweep that [`Study::sweep`] writes.
    pub(crate) fn sweep_file(&self) -> PathBuf {
        self.layout.sweep(&"motor".parse().unwrap(), 1)
    }

    /// Everything under `raw/`, by content.
    pub(crate) fn raw(&self) -> BTreeMap<String, String> {
        listing(&self.root().join("raw"))
    }

    /// Writes session S01 of a participant: its trials, its record, its log.
    pub(crate) fn session(&self, participant: &str, drafts: &[Draft]) {
        let participant: ParticipantId = participant.parse().unwrap();
        let mut events = Vec::new();
        let study = read_study(&self.layout).unwrap();
        for draft in drafts {
            if draft.samples {
                let path = self.layout.trial(&participant, &session_id(), draft.trial);
                let trial = trial(draft, &participant);
                let bytes = trial_bytes(&trial, &study.trial_form(), &path).unwrap();
                write_new(&RealFiles, &path, &bytes).unwrap();
                events.push(Event::Recorded { trial: draft.trial, blake3: hex_blake3(&bytes) });
                let question = |e: &zwidth_study::Environment| e.question.clone();
                let question = study.environment(&trial.meta.environment).and_then(question);
                let answer = question.zip(draft.likert);
                events.extend(answer.map(|(question, value)| Event::Answer {
                    trial: draft.trial,
                    question,
                    value: value.into(),
                    time_ms: None,
                }));
            }
            events.extend(draft.events.iter().cloned());
        }
        let study_toml = fs::read(self.layout.study_toml()).unwrap();
        let record = SessionRecord::new(
            participant.clone(),
            session_id(),
            drafts[0].source,
            "zwidth tests",
            hex_blake3(&study_toml),
            drafts.iter().map(planned).collect(),
        );
        lay_down(&RealFiles, &self.layout, UTC, &record, &study_toml).unwrap();
        append_events(&RealFiles, &self.layout.events(&participant, &session_id()), UTC, &events)
            .unwrap();
    }

    /// Writes one up-and-down sweep of the motor, and gives its file.
    pub(crate) fn sweep(&self) -> PathBuf {
        let ramp = (0..=80).map(f64::from).map(|i| 0.2 * if i > 40.0 { 80.0 - i } else { i });
        let volts: Vec<f64> = ramp.collect();
        let sweep = Sweep {
            actuator: "motor".parse().unwrap(),
            sweep: 1,
            source: Source::Recorded,
            command: Quantity { name: "voltage".to_owned(), unit: "V".to_owned() },
            response: Quantity { name: "force".to_owned(), unit: "N".to_owned() },
            t_s: Some((0..volts.len()).map(|i| i as f64 / RATE_HZ).collect()),
            response_values: volts
                .iter()
                .enumerate()
                .map(|(i, v)| 0.26 * v + ripple(i as f64))
                .collect(),
            command_values: volts,
            file: BTreeMap::new(),
        };
        let path = self.layout.sweep(&sweep.actuator, sweep.sweep);
        let bytes = sweep_bytes(&sweep, &path).unwrap();
        write_new(&RealFiles, &path, &bytes).unwrap();
        log_sweeps(
            &RealFiles,
            &self.layout,
            UTC,
            &[(sweep.actuator, sweep.sweep, hex_blake3(&bytes))],
        )
        .unwrap();
        path
    }
}

fn session_id() -> SessionId {
    SessionId::new("S01").unwrap()
}

fn planned(draft: &Draft) -> PlannedTrial {
    PlannedTrial {
        trial: draft.trial,
        repeat: draft.repeat,
        kind: draft.kind,
        environment: draft.environment.parse().unwrap(),
        mode: draft.mode.parse().unwrap(),
        samples: draft.samples,
        task: None,
    }
}

/// A stand-in for noise that is the same in every run, N.
fn ripple(i: f64) -> f64 {
    0.01 * (37.0 * i).sin()
}

/// Press and release, θ = start + stroke · sin²(π t / T), through a spring with friction.
fn trial(draft: &Draft, participant: &ParticipantId) -> Trial {
    let omega = std::f64::consts::TAU / STROKE_S;
    let t: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i) / RATE_HZ).collect();
    let column = |value: &dyn Fn(f64) -> f64| t.iter().map(|t| value(*t)).collect::<Vec<f64>>();
    let theta = |t: f64| START_RAD + 0.5 * STROKE_RAD * (1.0 - (omega * t).cos());
    let theta_dot = |t: f64| 0.5 * STROKE_RAD * omega * (omega * t).sin();
    let spring = |t: f64| STIFFNESS_N_PER_RAD * (theta(t) - START_RAD);
    let felt = |t: f64| {
        spring(t) + FRICTION_N * theta_dot(t).signum() + ripple(t + f64::from(draft.trial))
    };
    let mut samples = Samples::default();
    samples.set(Signal::Theta, column(&theta));
    samples.set(Signal::ThetaDot, column(&theta_dot));
    samples
        .set(Signal::ThetaDdot, column(&|t| 0.5 * STROKE_RAD * omega * omega * (omega * t).cos()));
    samples.set(Signal::ForceEx, column(&|t| draft.force_n.unwrap_or_else(|| felt(t))));
    samples.set(Signal::ForceCmd, column(&|t| draft.force_n.unwrap_or_else(|| spring(t))));
    samples.set(Signal::Time, t);
    let meta = TrialMeta {
        participant: participant.clone(),
        session: session_id(),
        trial: draft.trial,
        repeat: draft.repeat,
        kind: draft.kind,
        status: draft.status,
        environment: draft.environment.parse().unwrap(),
        mode: draft.mode.parse().unwrap(),
        likert: draft.likert,
        source: draft.source,
        presented: None,
    };
    Trial { meta, file: BTreeMap::new(), samples }
}
