//! The plan of a task of a study as it is taken here.

use super::{Asks, Sigmoid, adjustment, fit, quest, staircase};
use zwidth_study as study;
use zwidth_study::{Method, StaircasePlan, Task, TaskLevel, TaskSigmoid, axis};

/// What was asked; `None` of one who sets the level.
pub fn asks(task: &Task) -> Option<Asks> {
    match task.asks {
        study::Asks::MoreOfTwo | study::Asks::MoreLess => Some(Asks::WhichWasMore),
        study::Asks::OneOfTwo => Some(Asks::RightOrWrong),
        study::Asks::YesNo => Some(Asks::YesNo),
        study::Asks::Set => None,
    }
}

/// The shape of what is fitted.
pub fn sigmoid(task: &Task) -> Sigmoid {
    match task.fit.sigmoid {
        TaskSigmoid::Norm => Sigmoid::Norm,
        TaskSigmoid::Logistic => Sigmoid::Logistic,
        TaskSigmoid::Weibull => Sigmoid::Weibull,
    }
}

/// What is fitted to its answers; `None` of one who sets the level.
pub fn model(task: &Task) -> Option<fit::Model> {
    Some(fit::Model {
        asks: asks(task)?,
        sigmoid: sigmoid(task),
        lapse: task.fit.lapse,
        is_constant: matches!(task.method, Method::Constant { .. }),
    })
}

/// One of its staircases; the last start is that of all further ones.
pub fn staircase(plan: &StaircasePlan, track: u8) -> Option<staircase::Staircase> {
    let start = plan.starts.get(usize::from(track)).or(plan.starts.last())?;
    let (scale, steps) = match plan.is_factor {
        true => (staircase::Scale::Logarithmic, [plan.up, plan.down].map(libm::log)),
        false => (staircase::Scale::Linear, [plan.up, plan.down]),
    };
    Some(staircase::Staircase {
        up_after: plan.up_after.into(),
        down_after: plan.down_after.into(),
        scale,
        up: steps[0],
        down: steps[1],
        start: start.value(),
        bounds: plan.bounds.map(TaskLevel::value),
        reversals: plan.reversals as usize,
        most_trials: plan.most_trials as usize,
        of_last: plan.of_last as usize,
    })
}

/// The plan of QUEST+; `None` of other methods, and of one who sets the level.
pub fn quest(task: &Task) -> Option<quest::Plan> {
    let Method::QuestPlus { levels, pse, sigma, lapse, .. } = &task.method else { return None };
    Some(quest::Plan {
        asks: asks(task)?,
        sigmoid: sigmoid(task),
        levels: levels.iter().map(|level| level.value()).collect(),
        thresholds: axis(*pse),
        scales: axis(*sigma),
        lapses: axis(*lapse),
    })
}

/// One setting of a person who sets levels, from its planned start, else from those of the task in turn. `None` of other
/// methods.
pub fn adjustment(task: &Task, track: u8, start: Option<TaskLevel>) -> Option<adjustment::Plan> {
    let Method::Adjustment { starts, step, bounds, .. } = &task.method else { return None };
    Some(adjustment::Plan {
        starts: [start.unwrap_or(starts[usize::from(track) % 2]).value(); 2],
        step: step.value(),
        bounds: bounds.map(TaskLevel::value),
        settings: 1,
    })
}
