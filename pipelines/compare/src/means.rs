//! Means by condition over the units of analysis: one row per environment and mode.

use crate::cells::{Cell, Cells};
use crate::measure::Measure;
use crate::split::Split;
use crate::{CompareError, Parameters};
use zwidth_results::{Mean, UnitOfAnalysis};
use zwidth_stats::groups;
use zwidth_stats::interval;
use zwidth_stats::welch::{self, Group};

/// A mean over units of analysis.
struct OverUnits {
    n: usize,
    mean: f64,
    /// Standard deviation of the units; of one participant's trials, that within sessions.
    sd: Option<f64>,
    interval: Option<[f64; 2]>,
}

/// The mean of every condition in which somebody has the metric.
pub(crate) fn means(
    cells: &Cells,
    split: Option<&Split>,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Mean>, CompareError> {
    let mut rows = Vec::new();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for (m, mode) in parameters.modes.iter().enumerate() {
            // Of groups nobody speaks who has none.
            let has_group =
                |c: &&Cell| split.is_none_or(|split| split.level(c.participant).is_some());
            let all: Vec<&Cell> = cells.of_condition(e, m).filter(has_group).collect();
            let with: Vec<&Cell> = all.iter().copied().filter(|c| c.mean.is_some()).collect();
            if with.is_empty() {
                continue;
            }
            let over = match unit {
                UnitOfAnalysis::Participants => match split {
                    None => {
                        let people = cells.people_in(e, m).map(|(_, mean)| mean);
                        over_people(&people.collect::<Vec<_>>(), parameters.level)?
                    }
                    Some(split) => {
                        over_groups(&split.by_level(cells.people_in(e, m)), parameters.level)
                    }
                },
                UnitOfAnalysis::TrialsOf(_) => within_one(&with, parameters.level),
            };
            rows.push(Mean {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: environment.clone(),
                mode: mode.clone(),
                unit_of_analysis: unit.clone(),
                n: over.n,
                trials: all.iter().map(|c| c.trials).sum(),
                trials_with_value: with.iter().map(|c| c.n).sum(),
                mean: over.mean,
                sd: over.sd,
                ci_low: over.interval.map(|ends| ends[0]),
                ci_high: over.interval.map(|ends| ends[1]),
            });
        }
    }
    Ok(rows)
}

/// Over participants, each the mean of their sessions.
fn over_people(people: &[f64], level: f64) -> Result<OverUnits, CompareError> {
    let mean = interval::mean(people, level)?;
    Ok(OverUnits {
        n: mean.n,
        // There is an estimate: some cell has a mean.
        mean: mean.estimate.unwrap_or_default(),
        sd: mean.sd,
        interval: mean.interval.map(|i| [i.ci_low, i.ci_high]),
    })
}

/// Over groups of people, each group with the same weight.
fn over_groups(levels: &[Vec<f64>], level: f64) -> OverUnits {
    let with = levels.iter().filter(|values| !values.is_empty());
    let groups: Vec<Group> = with.map(|values| groups::group(values)).collect();
    let number = groups.len() as f64;
    // Within groups: how far they lie apart is no scatter.
    let squares = groups.iter().map(|group| group.sd * group.sd).sum::<f64>();
    OverUnits {
        n: groups.iter().map(|group| group.n).sum(),
        mean: groups.iter().map(|group| group.mean).sum::<f64>() / number,
        sd: groups.iter().all(|group| group.n > 1).then(|| (squares / number).sqrt()),
        interval: groups::mean(&groups, level).ok().map(|t| [t.ci_low, t.ci_high]),
    }
}

/// Over one participant's trials, sessions with equal weight.
fn within_one(with: &[&Cell], level: f64) -> OverUnits {
    let groups: Vec<Group> = with.iter().map(|cell| cell.group()).collect();
    let squares: f64 = groups.iter().map(|g| (g.n - 1) as f64 * g.sd * g.sd).sum();
    // Every cell here has a mean, so its n is 1 at least.
    let spare: usize = groups.iter().map(|g| g.n - 1).sum();
    OverUnits {
        n: groups.iter().map(|g| g.n).sum(),
        mean: groups.iter().map(|g| g.mean).sum::<f64>() / groups.len() as f64,
        sd: (spare > 0).then(|| (squares / spare as f64).sqrt()),
        interval: welch::mean(&groups, level).ok().map(|t| [t.ci_low, t.ci_high]),
    }
}
