//! How what can be felt was found from the answers to tasks, in words.

use super::recorded::{Recorded, plain};
use super::sources::Cited;
use zwidth_study::{Asks, Method, StaircasePlan, Study, Task, TaskSigmoid, counted};

pub(super) fn paragraphs(study: &Study, recorded: &Recorded, cited: &mut Cited) -> Vec<String> {
    let mut paragraphs: Vec<String> =
        study.tasks.iter().map(|task| of_task(study, task, cited)).collect();
    if !paragraphs.is_empty() && recorded.participants > 1 {
        paragraphs.push(format!(
            "Only estimates went on; participants without one are named. Thresholds and natural logarithms of JNDs were \
             compared as measures with one value of each participant, session and mode, so that differences of JNDs are \
             ratios. Beside stands a two-level model that weighs participants by the errors of their own {} {}.",
            cited.cite("paule"),
            cited.cite("hartung")
        ));
    }
    paragraphs
}

fn of_task(study: &Study, task: &Task, cited: &mut Cited) -> String {
    let environment = study.environments.iter().find(|own| own.id == task.environment);
    let label = environment.map_or_else(|| task.environment.to_string(), |own| own.label.clone());
    let intervals = match task.asks {
        Asks::MoreOfTwo | Asks::OneOfTwo => "after two intervals, one of which had the standard,",
        Asks::YesNo | Asks::MoreLess => "after one interval",
        Asks::Set => "after each level until it was right",
    };
    let unit = task.unit();
    let standard = task.standard.map(|standard| {
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        format!(" The standard was {}{unit}.", plain(standard.value()))
    });
    format!(
        "In {label}, `{}` varied, and {intervals} participants answered the question “{}”.{} {}",
        task.varies,
        task.text,
        standard.unwrap_or_default(),
        of_method(task, cited)
    )
}

fn of_method(task: &Task, cited: &mut Cited) -> String {
    match &task.method {
        Method::Constant { levels, trials } => {
            let sigmoid = match task.fit.sigmoid {
                TaskSigmoid::Norm => "the normal distribution function",
                TaskSigmoid::Logistic => "the logistic function",
                TaskSigmoid::Weibull => "Weibull's distribution function",
            };
            let [least, most] = task.fit.lapse;
            let at_nothing = match task.asks {
                Asks::OneOfTwo => "; at a level that nobody feels half of the answers are right",
                Asks::YesNo => "; the share of yes to nothing was free up to one half",
                Asks::MoreOfTwo | Asks::MoreLess | Asks::Set => ", as many at either end",
            };
            format!(
                "Levels were constant stimuli, {} with {} each in each mode. A psychometric function was fitted to the \
                 answers of each participant, session and mode by maximum likelihood {}: {sigmoid}, with a share of lapses \
                 free from {} to {}{at_nothing}. Intervals hold what the profiled likelihood ratio allows, divided by \
                 Pearson's X² over its degrees of freedom where that exceeds 1. The JND is half the distance from a \
                 quarter to three quarters of the function.",
                counted(levels.len(), "levels"),
                counted(*trials as usize, "presentations"),
                cited.cite("wichmann"),
                plain(least),
                plain(most),
            )
        }
        Method::Staircase(plan) => {
            let StaircasePlan { up_after, down_after, reversals, of_last, .. } = plan;
            format!(
                "Levels followed {} that went up after {} and down after {} in a row {}, until {reversals} reversals; the \
                 threshold is the mean of the last {of_last}. Staircases give no JND.",
                counted(plan.starts.len(), "staircases"),
                counted((*up_after).into(), "answers of less, wrong or no"),
                counted((*down_after).into(), "answers of more, right or yes"),
                cited.cite("garcia")
            )
        }
        Method::QuestPlus { trials, .. } => format!(
            "Levels were chosen by QUEST+ {}, {} in each mode; threshold and JND are means of its posterior.",
            cited.cite("watson"),
            counted(*trials as usize, "presentations")
        ),
        Method::Adjustment { settings, .. } => format!(
            "Participants set the level {settings} times in each mode, from starts that alternated below and above. The \
             point of subjective equality is the mean of their settings, and the JND 0.6745 of their standard deviation {}.",
            cited.cite("gescheider")
        ),
    }
}
