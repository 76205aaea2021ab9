//! `raw/demo`: a small study in closed form, so that the main job runs on a fresh clone.
//!
//! It is no model of a device or a person: each trial is a minimum-jerk movement there and back
//! (Flash & Hogan 1985), pressed through a spring, with the three modes' textbook behaviour (thesis
//! §5.3) written down directly. Everything in it is marked `source = twin`.

use anyhow::Context as _;
use std::path::Path;
use zwidth_store::{
    Layout, Quantity, RealFiles, Samples, Signal, Sweep, Trial, append_events, hex_blake3, sweep_bytes,
    trial_bytes, write_new,
};
use zwidth_study::{
    ActuatorId, Environment, Event, Kind, ParticipantId, PlannedTrial, SCHEMA_VERSION, SessionId,
    SessionRecord, Source, Spring, Status, Study, StudyId, TrialMeta, template,
};

/// Samples per second: the rate of the force sensor.
const RATE_HZ: f64 = 80.0;
/// Length of a trial, s.
const TRIAL_S: f64 = 4.0;
/// When the movement starts, s.
const START_S: f64 = 0.35;
/// Force of friction that the user feels, N.
const FRICTION_N: f64 = 0.2;
/// Stiffness of hand and finger at the lever, N/rad.
const HAND_N_PER_RAD: f64 = 30.0;
/// Motor force at the lever, N/V (thesis §4.1.2: 4.16 N at 16 V).
const MOTOR_N_PER_V: f64 = 0.26;
/// Brake dead zone, V, and slope above it, N/V (thesis §5.1: about 1 V; taken as 13 N at 8 V).
const BRAKE_DEAD_V: f64 = 1.0;
const BRAKE_N_PER_V: f64 = 13.0 / 7.0;
/// Resolution of the noisy force, N.
const FORCE_STEP_N: f64 = 1e-3;
/// The time every file claims: the study is the same on every day.
const START_UTC: &str = "2026-01-01T00:00:00Z";
/// Who wrote it.
const SOFTWARE: &str = "zwidth xtask demo 1";

/// Writes `raw/demo` under `root`, replacing what stands there.
pub(crate) fn write(root: &Path) -> anyhow::Result<()> {
    let layout = Layout::new(root, StudyId::new("demo")?);
    if layout.raw().exists() {
        std::fs::remove_dir_all(layout.raw()).context("cannot remove the old raw/demo")?;
    }
    let text = template(layout.study()).replace(
        "title = \"Coupling a motor and a brake: demo\"",
        "title = \"Demonstration: a closed-form study\"",
    );
    write_new(&RealFiles, &layout.study_toml(), text.as_bytes())?;
    let study = Study::from_toml(&text).map_err(|e| anyhow::anyhow!("{e:?}"))?;
    session(&layout, &study, &hex_blake3(text.as_bytes()))?;
    sweeps(&layout)?;
    println!("wrote {}", layout.raw().display());
    Ok(())
}

/// What a trial of the demonstration is: planned trial, and how its repeat varies.
struct Draft {
    meta: TrialMeta,
    variation: f64,
}

fn session(layout: &Layout, study: &Study, study_blake3: &str) -> anyhow::Result<()> {
    let (participant, session) = (ParticipantId::new("P01")?, SessionId::new("S01")?);
    let drafts = drafts(study, &participant, &session);
    let mut events = Vec::new();
    for draft in &drafts {
        let path = layout.trial(&participant, &session, draft.meta.trial);
        let bytes = trial_bytes(&trial(study, draft, study_blake3)?, &path)?;
        write_new(&RealFiles, &path, &bytes)?;
        events.push(Event::Recorded { trial: draft.meta.trial, blake3: hex_blake3(&bytes) });
    }
    let last = drafts.len() as u32;
    events.push(Event::Superseded { trial: 20, by: last });
    events
        .push(Event::Note { trial: Some(20), text: "an example of a trial that was done again".to_owned() });
    let record = SessionRecord {
        schema_version: SCHEMA_VERSION,
        participant: participant.clone(),
        session: session.clone(),
        source: Source::Twin,
        software: SOFTWARE.to_owned(),
        study_blake3: study_blake3.to_owned(),
        trials: drafts.iter().map(|d| planned(&d.meta)).collect(),
    };
    write_new(&RealFiles, &layout.session(&participant, &session), record.to_json()?.as_bytes())?;
    Ok(append_events(&RealFiles, &layout.events(&participant, &session), START_UTC, &events)?)
}

fn planned(meta: &TrialMeta) -> PlannedTrial {
    PlannedTrial {
        trial: meta.trial,
        repeat: meta.repeat,
        kind: meta.kind,
        environment: meta.environment.clone(),
        mode: meta.mode.clone(),
        samples: true,
    }
}

/// Familiarisation, then every condition's repeats, then one trial done again.
fn drafts(study: &Study, participant: &ParticipantId, session: &SessionId) -> Vec<Draft> {
    let mut plan = Vec::new();
    for repeat in 1..=study.design.familiarisation {
        plan.push((Kind::Familiarisation, repeat, 0, 0));
    }
    for e in 0..study.environments.len() {
        for repeat in 1..=study.design.repeats {
            (0..study.modes.len())
                .for_each(|m| plan.push((Kind::Trial, repeat, e, (m + repeat as usize) % 3)));
        }
    }
    let again = plan[19];
    plan.push(again);
    let draft = |(i, (kind, repeat, e, m)): (usize, (Kind, u32, usize, usize))| {
        let variation = vary(i);
        let meta = TrialMeta {
            participant: participant.clone(),
            session: session.clone(),
            trial: i as u32 + 1,
            repeat,
            kind,
            status: Status::Complete,
            environment: study.environments[e].id.clone(),
            mode: study.modes[m].id.clone(),
            likert: (kind == Kind::Trial).then(|| answer(e, m, variation)),
            source: Source::Twin,
        };
        Draft { meta, variation }
    };
    plan.into_iter().enumerate().map(draft).collect()
}

/// A number in −1…1 that differs from trial to trial: the golden-ratio sequence.
fn vary(i: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    2.0 * (i as f64 * GOLDEN).fract() - 1.0
}

/// Answers in the spirit of thesis Fig. 30: the motor alone convinces as a spring, the hybrid in both.
fn answer(environment: usize, mode: usize, variation: f64) -> u8 {
    let usual = [[4, 2, 4], [2, 2, 4]][environment][mode];
    if variation > 0.3 {
        usual + 1
    } else if variation < -0.7 {
        usual - 1
    } else {
        usual
    }
}

fn trial(study: &Study, draft: &Draft, study_blake3: &str) -> anyhow::Result<Trial> {
    let environment = study.environment(&draft.meta.environment).context("environment")?;
    let spring = environment.scene.spring().context("the demonstration's environments are springs")?;
    let scene = Scene { environment, spring, mode: draft.meta.mode.as_str(), variation: draft.variation };
    let n = (TRIAL_S * RATE_HZ) as usize;
    let mut columns: [Vec<f64>; 7] = Default::default();
    let mut theta_before = spring.rest_rad;
    for i in 0..n {
        let t = i as f64 / RATE_HZ;
        let now = scene.at(t);
        let noise = FORCE_STEP_N * (4.0 * vary(i * 7 + draft.meta.trial as usize * 1000)).round();
        let force = ((now.force_n + noise) / FORCE_STEP_N).round() * FORCE_STEP_N;
        let row = [
            t,
            now.theta_rad,
            (now.theta_rad - theta_before) * RATE_HZ,
            force.max(0.0),
            now.motor_n / MOTOR_N_PER_V,
            if now.brake_n > 0.0 { BRAKE_DEAD_V + now.brake_n / BRAKE_N_PER_V } else { 0.0 },
            now.motor_n + now.brake_n,
        ];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        theta_before = now.theta_rad;
    }
    let signals = [
        Signal::Time,
        Signal::Theta,
        Signal::ThetaDot,
        Signal::ForceEx,
        Signal::VoltageMotor,
        Signal::VoltageBrake,
        Signal::ForceCmd,
    ];
    let mut samples = Samples::default();
    signals.into_iter().zip(columns).for_each(|(signal, column)| samples.set(signal, column));
    let file = [
        ("software", SOFTWARE),
        ("start_utc", START_UTC),
        ("study_blake3", study_blake3),
        ("device", "closed form, no device"),
    ];
    let file = file.map(|(k, v)| (k.to_owned(), v.to_owned())).into();
    Ok(Trial { meta: draft.meta.clone(), file, samples })
}

/// One trial's movement and forces as functions of time.
struct Scene<'a> {
    environment: &'a Environment,
    spring: Spring,
    mode: &'a str,
    variation: f64,
}

/// Angle and forces at one instant.
struct Instant {
    theta_rad: f64,
    force_n: f64,
    motor_n: f64,
    brake_n: f64,
}

impl Scene<'_> {
    /// How far the hand means to go, rad.
    fn stroke_rad(&self) -> f64 {
        (77.0 + 5.0 * self.variation).to_radians()
    }

    /// Where the hand wants to be: forward and back along minimum-jerk paths.
    fn intent_rad(&self, t: f64) -> (f64, bool) {
        let forward_s = 1.5 + 0.15 * self.variation;
        let hold_s = 0.15;
        let back_s = 1.5 - 0.1 * self.variation;
        let s = t - START_S;
        let forward = s < forward_s + hold_s;
        let there = minimum_jerk(s / forward_s);
        let back = minimum_jerk((s - forward_s - hold_s) / back_s);
        (self.spring.rest_rad + self.stroke_rad() * (there - back), forward)
    }

    fn at(&self, t: f64) -> Instant {
        let (intent, forward) = self.intent_rad(t);
        let furthest = self.spring.rest_rad + self.stroke_rad();
        let wall = self.environment.scene.wall_rad();
        let stops_at = wall.filter(|_| self.mode != "active").map(|w| w + 0.2_f64.to_radians());
        let limit = |theta: f64| stops_at.map_or(theta, |stop| theta.min(stop));
        let theta_rad = match self.mode {
            "passive" if !forward => limit(furthest),
            _ => limit(intent),
        };
        let spring_n = self.spring.stiffness_n_per_rad * (theta_rad - self.spring.rest_rad);
        let demanded = if wall.is_some_and(|w| theta_rad >= w) { f64::MAX } else { spring_n.max(0.0) };
        let (motor_n, brake_n) = match self.mode {
            "active" => (demanded.min(16.0 * MOTOR_N_PER_V), 0.0),
            "passive" => (0.0, demanded.min(13.0)),
            _ if forward || stops_at == Some(theta_rad) => (0.0, demanded.min(13.0)),
            _ => (demanded.min(8.0 * MOTOR_N_PER_V), 0.0),
        };
        let resisted = if brake_n > 0.0 { brake_n.min(spring_n) } else { motor_n };
        let pressed = HAND_N_PER_RAD * (intent - theta_rad);
        let friction = if forward { FRICTION_N } else { -FRICTION_N };
        let moving = t > START_S && spring_n > FRICTION_N;
        let force_n = resisted + pressed + if moving { friction } else { 0.0 };
        Instant { theta_rad, force_n: force_n.max(0.0), motor_n, brake_n }
    }
}

/// 10 s³ − 15 s⁴ + 6 s⁵ on 0…1: the smoothest way from rest to rest (Flash & Hogan 1985, (A4)).
fn minimum_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (-15.0 + 6.0 * s))
}

fn sweeps(layout: &Layout) -> anyhow::Result<()> {
    let motor = |v: f64| MOTOR_N_PER_V * v;
    let brake = |v: f64| BRAKE_N_PER_V * (v - BRAKE_DEAD_V).max(0.0);
    for number in 1..=3 {
        sweep(layout, "motor", number, 16.0, &motor)?;
        sweep(layout, "brake", number, 8.0, &brake)?;
    }
    Ok(())
}

/// One ramp up and down again.
fn sweep(
    layout: &Layout,
    actuator: &str,
    number: u32,
    top_v: f64,
    force: &dyn Fn(f64) -> f64,
) -> anyhow::Result<()> {
    const POINTS: usize = 240;
    let phase = |i: usize| 2.0 * i as f64 / (POINTS - 1) as f64;
    let volts: Vec<f64> = (0..POINTS).map(|i| top_v * (1.0 - (1.0 - phase(i)).abs())).collect();
    let noisy = |(i, v): (usize, &f64)| {
        let noise = 20.0 * vary(i * 13 + number as usize * 777) + 10.0 * vary(i * 5 + number as usize);
        ((force(*v) / FORCE_STEP_N + noise).round()) * FORCE_STEP_N
    };
    let sweep = Sweep {
        actuator: ActuatorId::new(actuator)?,
        sweep: number,
        source: Source::Twin,
        command: Quantity { name: format!("{actuator} voltage"), unit: "V".to_owned() },
        response: Quantity { name: "force at the lever".to_owned(), unit: "N".to_owned() },
        t_s: Some((0..POINTS).map(|i| i as f64 / RATE_HZ).collect()),
        response_values: volts.iter().enumerate().map(noisy).collect(),
        command_values: volts,
        file: [("software".to_owned(), SOFTWARE.to_owned())].into(),
    };
    let path = layout.sweep(&sweep.actuator, number);
    Ok(write_new(&RealFiles, &path, &sweep_bytes(&sweep, &path)?)?)
}
