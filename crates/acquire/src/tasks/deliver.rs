//! What a device can give of the levels that are wished for.

use zwidth_study::{Method, Study, Task, TaskLevel};

/// The key of the one number that a loop renders in steps: whole ticks.
const DELAY: &str = "delay_ms";
/// Milliseconds of a second.
const MILLI: f64 = 1e-3;

/// The level that a loop of that rate, Hz, gives of a wished one; none of one beyond all levels.
pub(super) fn delivered(task: &Task, wished: f64, rate_hz: f64) -> Option<TaskLevel> {
    let given = match task.varies == DELAY {
        true => (wished * MILLI * rate_hz).round() / rate_hz / MILLI,
        false => wished,
    };
    TaskLevel::nearest(given)
}

/// Why the levels of a study's tasks cannot be presented at a rate, Hz; none if they can.
pub(crate) fn refuse(study: &Study, rate_hz: f64) -> Option<String> {
    study.tasks.iter().find_map(|task| refuse_task(study, task, rate_hz))
}

fn refuse_task(study: &Study, task: &Task, rate_hz: f64) -> Option<String> {
    let Task { id, varies, standard, .. } = task;
    // Those that are planned must be given as they are; between bounds any may follow.
    let (planned, rough): (Vec<TaskLevel>, Vec<TaskLevel>) = match &task.method {
        Method::Constant { levels, .. } | Method::QuestPlus { levels, .. } => {
            (levels.clone(), Vec::new())
        }
        Method::Staircase(plan) => {
            (Vec::new(), plan.starts.iter().chain(&plan.bounds).copied().collect())
        }
        Method::Adjustment { starts, bounds, .. } => {
            (Vec::new(), starts.iter().chain(bounds).copied().collect())
        }
    };
    // A standard that is remembered is rendered nowhere.
    let is_rendered = task.asks.intervals() > 1 || task.catch > 0.0;
    let planned: Vec<TaskLevel> =
        planned.into_iter().chain(standard.filter(|_| is_rendered)).collect();
    for level in planned.iter().chain(&rough) {
        if study.environment_at(task, *level).is_none() {
            return Some(format!(
                "task {id}: {varies} = {} is no level of environment {}",
                level.value(),
                task.environment
            ));
        }
    }
    for level in &planned {
        let given = delivered(task, level.value(), rate_hz);
        if given != Some(*level) {
            return Some(format!(
                "task {id}: at {rate_hz} Hz {varies} = {} would be {}: give a whole number of ticks of {} ms",
                level.value(),
                given.map_or(f64::NAN, TaskLevel::value),
                1.0 / rate_hz / MILLI
            ));
        }
    }
    let from_start = |start: &TaskLevel, step: f64| {
        delivered(task, start.value() + step, rate_hz) == delivered(task, start.value(), rate_hz)
    };
    let stands_still = match &task.method {
        Method::Staircase(plan) => plan.starts.iter().chain(&plan.bounds[..1]).any(|start| {
            let [up, down] = match plan.is_factor {
                true => [plan.up - 1.0, 1.0 / plan.down - 1.0].map(|part| part * start.value()),
                false => [plan.up, -plan.down],
            };
            start.value() != 0.0 && (from_start(start, up) || from_start(start, down))
        }),
        Method::Adjustment { starts, step, .. } => {
            starts.iter().any(|start| from_start(start, step.value()))
        }
        Method::Constant { .. } | Method::QuestPlus { .. } => false,
    };
    stands_still.then(|| {
        format!(
            "task {id}: at {rate_hz} Hz a step of {varies} is less than a tick of {} ms, so that the level would stand still",
            1.0 / rate_hz / MILLI
        )
    })
}
