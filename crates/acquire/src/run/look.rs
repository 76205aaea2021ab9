//! Turns the state of a session into what is shown.

use crate::course::Conditions;
use crate::flow::{self, Flow};
use crate::plan::Plan;
use crate::session::Session;
use crate::told::check_value;
use crate::view::{CheckLine, Current, Phase, Timing, View};
use zwidth_device::{Capabilities, Histogram};
use zwidth_study::{Check, Event, Source};

/// What stays the same while the session lasts.
pub(super) fn view(plan: &Plan, session: &Session, device: &Capabilities) -> View {
    View {
        study: plan.study.id.to_string(),
        participant: plan.participant.to_string(),
        session: plan.session.to_string(),
        device: device.name.clone(),
        simulated: device.source == Source::Twin,
        blinded: session.blinded,
        total: session.record.trials.len(),
        theta_range_rad: (
            plan.study.device.theta_min_rad.unwrap_or(0.0),
            plan.study.device.theta_max_rad.unwrap_or(0.0),
        ),
        timing: Timing { rate_hz: plan.rate_hz, ..Timing::default() },
        ..View::default()
    }
}

/// What the flow says now.
pub(super) fn refresh(
    view: &mut View,
    flow: &Flow,
    plan: &Plan,
    session: &Session,
    conditions: &Conditions,
) {
    refresh_trial(view, flow, plan, session, conditions);
    view.phase = phase(flow, plan, view);
}

/// The same but for the phase, whose time runs on.
pub(super) fn refresh_trial(
    view: &mut View,
    flow: &Flow,
    plan: &Plan,
    session: &Session,
    conditions: &Conditions,
) {
    let place = match flow.phase() {
        flow::Phase::Question { place, .. } => Some(*place),
        _ => flow.here(),
    };
    view.done = flow.done();
    view.total = flow.total();
    view.feedback = flow.feedback();
    view.task = place.and_then(|place| flow.tasks().now(place, session.blinded));
    view.held = flow.is_held();
    view.cells = conditions.counted(flow);
    view.trial = place.map(|place| current(place, flow, plan, session));
    // In the pause the trace still is that of the trial that ended.
    if matches!(flow.phase(), flow::Phase::Pause) {
        return;
    }
    let environment =
        place.and_then(|i| plan.study.environment(&flow.places()[i].trial.environment));
    view.wall_rad = environment.and_then(|e| e.scene.wall_rad());
}

fn current(place: usize, flow: &Flow, plan: &Plan, session: &Session) -> Current {
    let slot = &flow.places()[place];
    let mode = session.modes.get(place).filter(|_| !session.blinded);
    let environment = plan.study.environment(&slot.trial.environment);
    let (trial, repeats) = flow.number_at(place);
    Current {
        trial,
        // Those that are not needed any more are in no count.
        place: (0..=place).filter(|place| flow.is_needed(*place)).count(),
        kind: slot.trial.kind,
        environment: environment
            .map_or_else(|| slot.trial.environment.to_string(), |e| e.label.clone()),
        mode: mode.and_then(|id| plan.study.mode(id)).map(|mode| mode.label.clone()),
        repeats,
    }
}

fn phase(flow: &Flow, plan: &Plan, view: &View) -> Phase {
    match flow.phase() {
        flow::Phase::Check => Phase::Check,
        flow::Phase::AtStop => Phase::AtStop,
        flow::Phase::Homing => Phase::Homing,
        flow::Phase::Ready => Phase::Ready,
        flow::Phase::Trial { .. } => {
            let t_s = if let Phase::Trial { t_s, .. } = view.phase { t_s } else { 0.0 };
            Phase::Trial { t_s, limit_s: plan.study.design.trial_limit_s }
        }
        flow::Phase::Question { place, question: index, .. } => {
            let questions = &flow.places()[*place].questions;
            let question = questions.get(*index);
            let (text, scale) =
                question.map(|q| (q.text.clone(), q.scale.clone())).unwrap_or_default();
            let text = match questions.len() {
                0 | 1 => text,
                n => format!("({} of {n}) {text}", index + 1),
            };
            Phase::Question { text, scale }
        }
        flow::Phase::Pause => Phase::Pause { left_s: flow.rest_s(), pause_s: flow.whole_pause_s() },
        flow::Phase::Stopped { why } => Phase::Stopped { why: why.clone() },
        flow::Phase::Done => Phase::Done,
        flow::Phase::Left => Phase::Left,
    }
}

/// An event in words.
pub(super) fn event(event: &Event) -> String {
    match event {
        Event::LaidDown { .. } => "the session was laid down".to_owned(),
        Event::SweepRecorded { actuator, sweep, .. } => {
            format!("sweep {sweep} of {actuator} recorded")
        }
        Event::MetricGiven { metric, table, .. } => {
            format!("table {table} of the metric {metric} given")
        }
        Event::MetricWithdrawn { metric, .. } => format!("the metric {metric} withdrawn"),
        Event::StreamGiven { stream, table, .. } => {
            format!("table {table} of the stream {stream} given")
        }
        Event::StreamWithdrawn { stream, .. } => format!("the stream {stream} withdrawn"),
        Event::Recorded { trial, .. } => format!("trial {trial} recorded"),
        Event::Answer { trial, value, .. } => format!("trial {trial}: answered {value}"),
        Event::Level { trial, level } => {
            format!("trial {trial}: the level of its presentation is {}", level.value())
        }
        Event::Superseded { trial, by } => {
            format!("trial {trial} does not count: it is done again as trial {by}")
        }
        Event::Excluded { trial, reason } => format!("trial {trial} excluded: {reason}"),
        Event::Unmet { trial, what } => format!("trial {trial} did not meet the protocol: {what}"),
        Event::Note { trial: Some(trial), text } => format!("trial {trial}: note: {text}"),
        Event::Note { trial: None, text } => format!("note: {text}"),
        Event::Marker { trial, moment, .. } => format!("trial {trial}: marker {}", moment.as_str()),
        Event::Unsealed { .. } => "unsealed".to_owned(),
        Event::StudyAccepted { .. } => "the changed study.toml was accepted".to_owned(),
        Event::PersonAccepted { column, level: Some(level) } => {
            format!("accepted that {column} is {level} now")
        }
        Event::PersonAccepted { column, level: None } => {
            format!("accepted that {column} is not known now")
        }
    }
}

/// A line of the device check for the screen.
pub(super) fn check_line(check: &Check) -> CheckLine {
    CheckLine { name: check.name.clone(), value: check_value(check), ok: check.ok }
}

/// A line of the device check in words.
pub(super) fn check_words(check: &Check) -> String {
    let verdict = if check.ok { "ok" } else { "not good enough" };
    format!("{} {}, {verdict}", check.name, check_value(check))
}

/// How a trial's loop keeps its time, for the screen, with its missed deadlines and dropouts.
pub(super) fn timing(
    rate_hz: f64,
    measured_hz: f64,
    missed: u64,
    dropouts: u64,
    lateness: &Histogram,
) -> Timing {
    Timing {
        rate_hz,
        measured_hz,
        jitter_p50_s: lateness.percentile_s(50.0),
        jitter_p99_s: lateness.percentile_s(99.0),
        jitter_max_s: lateness.max_s(),
        missed,
        dropouts,
    }
}
