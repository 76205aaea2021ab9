//! The plan of a task as statistics take it.

use zwidth_stats::psychometric::{Asks, Sigmoid, adjustment, quest, staircase};
use zwidth_study::{self as study, Method, StaircasePlan, Task, TaskLevel, TaskSigmoid, axis};

/// One of the staircases of a task that take turns; the last start is that of all further ones.
pub(super) fn staircase(plan: &StaircasePlan, track: u8) -> Option<staircase::Staircase> {
    let start = plan.starts.get(usize::from(track)).or(plan.starts.last())?;
    let (scale, [up, down]) = match plan.is_factor {
        true => (staircase::Scale::Logarithmic, [plan.up, plan.down].map(libm::log)),
        false => (staircase::Scale::Linear, [plan.up, plan.down]),
    };
    Some(staircase::Staircase {
        up_after: plan.up_after.into(),
        down_after: plan.down_after.into(),
        scale,
        up,
        down,
        start: start.value(),
        bounds: plan.bounds.map(TaskLevel::value),
        reversals: plan.reversals as usize,
        most_trials: plan.most_trials as usize,
        of_last: plan.of_last as usize,
    })
}

/// The plan of QUEST+; `None` of other methods, and of tasks for which there is none.
pub(super) fn quest(task: &Task) -> Option<quest::Plan> {
    let Method::QuestPlus { levels, pse, sigma, lapse, .. } = &task.method else { return None };
    let asks = match task.asks {
        study::Asks::MoreOfTwo | study::Asks::MoreLess => Asks::WhichWasMore,
        study::Asks::OneOfTwo => Asks::RightOrWrong,
        study::Asks::YesNo => Asks::YesNo,
        study::Asks::Set => return None,
    };
    let sigmoid = match task.fit.sigmoid {
        TaskSigmoid::Norm => Sigmoid::Norm,
        TaskSigmoid::Logistic => Sigmoid::Logistic,
        TaskSigmoid::Weibull => Sigmoid::Weibull,
    };
    Some(quest::Plan {
        asks,
        sigmoid,
        levels: levels.iter().map(|level| level.value()).collect(),
        thresholds: axis(*pse),
        scales: axis(*sigma),
        lapses: axis(*lapse),
    })
}

/// One setting of a person who sets levels, from its planned start, else from those of the task in turn. `None` of other
/// methods.
pub(super) fn adjustment(
    task: &Task,
    track: u8,
    start: Option<TaskLevel>,
) -> Option<adjustment::Plan> {
    let Method::Adjustment { starts, step, bounds, .. } = &task.method else { return None };
    Some(adjustment::Plan {
        starts: [start.unwrap_or(starts[usize::from(track) % 2]).value(); 2],
        step: step.value(),
        bounds: bounds.map(TaskLevel::value),
        settings: 1,
    })
}
