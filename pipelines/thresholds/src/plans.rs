//! The plan of a task as statistics take it.

use zwidth_stats::psychometric::{Asks, Sigmoid, fit, quest, staircase};
use zwidth_study as study;
use zwidth_study::{Method, StaircasePlan, Task, TaskLevel, TaskSigmoid};

/// What was asked; `None` of one who sets the level.
pub(crate) fn asks(task: &Task) -> Option<Asks> {
    match task.asks {
        study::Asks::MoreOfTwo | study::Asks::MoreLess => Some(Asks::WhichWasMore),
        study::Asks::OneOfTwo => Some(Asks::RightOrWrong),
        study::Asks::YesNo => Some(Asks::YesNo),
        study::Asks::Set => None,
    }
}

pub(crate) fn sigmoid(task: &Task) -> Sigmoid {
    match task.fit.sigmoid {
        TaskSigmoid::Norm => Sigmoid::Norm,
        TaskSigmoid::Logistic => Sigmoid::Logistic,
        TaskSigmoid::Weibull => Sigmoid::Weibull,
    }
}

/// What is fitted to its answers.
pub(crate) fn model(task: &Task) -> Option<fit::Model> {
    Some(fit::Model {
        asks: asks(task)?,
        sigmoid: sigmoid(task),
        lapse: task.fit.lapse,
        is_constant: matches!(task.method, Method::Constant { .. }),
    })
}

/// One of its staircases; the last start is that of all further ones.
pub(crate) fn staircase(plan: &StaircasePlan, track: u8) -> Option<staircase::Staircase> {
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

/// The plan of QUEST+; `None` of other methods.
pub(crate) fn quest(task: &Task) -> Option<quest::Plan> {
    let Method::QuestPlus { levels, pse, sigma, lapse, .. } = &task.method else { return None };
    Some(quest::Plan {
        asks: asks(task)?,
        sigmoid: sigmoid(task),
        levels: levels.iter().map(|level| level.value()).collect(),
        thresholds: axis(pse),
        scales: axis(sigma),
        lapses: axis(lapse),
    })
}

/// The numbers from the first to the second, in steps of the third.
fn axis([from, to, step]: &[f64; 3]) -> Vec<f64> {
    // A step of 0 or below is one number.
    let steps = ((to - from) / step + 1e-9).floor();
    let steps = if steps.is_finite() && steps > 0.0 { steps as usize } else { 0 };
    (0..=steps).map(|i| from + step * i as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_both_ends_and_one_number_if_it_has_no_step() {
        assert_eq!(axis(&[1.0, 2.0, 0.25]), [1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(axis(&[0.0, 0.06, 0.02]).len(), 4);
        assert_eq!(axis(&[0.5, 0.5, 0.0]), [0.5]);
        assert_eq!(axis(&[1.0, 0.0, 0.5]), [1.0]);
    }
}
