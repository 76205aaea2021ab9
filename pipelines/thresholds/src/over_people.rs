//! Thresholds over people: what the stage `compare` found of them, in units of the levels and as ratios, and beside it the
//! two-level model.
//!
//! The mean of everybody's differences has Student's t; the two-level model (`zwidth_stats::heterogeneity`) weighs people
//! by the errors of their own, where they answered unequally often. It stands beside, and no claim rests on it.

use crate::values::{std_error, value};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Mean, ModeDifference, PeopleThreshold, PsychometricFit, UnitOfAnalysis};
use zwidth_stats::heterogeneity::{TwoLevel, two_level};
use zwidth_stats::interval;
use zwidth_study::{
    Contrast, MeasuredJnd, MetricId, ModeId, ParticipantId, SessionId, Task, TaskQuantity,
};

/// What the stage `compare` found; nothing where modes are not compared, or of one person.
#[derive(Debug, Clone, Copy)]
pub struct Means<'a> {
    /// Differences between modes that the study asks for.
    pub asked: &'a [Contrast],
    /// Means by condition.
    pub means: &'a [Mean],
    /// Differences between modes.
    pub contrasts: &'a [ModeDifference],
}

/// A task, and the number of it that is compared as a metric.
struct Measured<'a> {
    task: &'a Task,
    quantity: TaskQuantity,
    metric: MetricId,
}

/// Means by mode and differences between modes of every number of a study's tasks.
pub fn over_people(
    tasks: &[Task],
    fits: &[PsychometricFit],
    found: Means,
    level: f64,
) -> Vec<PeopleThreshold> {
    let mut rows = Vec::new();
    for task in tasks {
        for quantity in task.quantities() {
            let Ok(metric) = task.metric(quantity) else { continue };
            let measured = Measured { task, quantity, metric };
            let own = fits.iter().filter(|fit| fit.task == task.id);
            let own: Vec<&PsychometricFit> = own.collect();
            let mut means: Vec<Mean> = found.means.to_vec();
            means.retain(|row| row.metric == measured.metric);
            if means.is_empty() {
                means = means_of(&measured, &own, level);
            }
            rows.extend(means.iter().map(|row| mean(&measured, row, &own, level)));
            let contrasts = found.contrasts.iter().filter(|row| row.metric == measured.metric);
            let before = rows.len();
            rows.extend(contrasts.map(|row| difference(&measured, row, &own, level)));
            if rows.len() == before {
                rows.extend(
                    found
                        .asked
                        .iter()
                        .filter_map(|own_contrast| described(&measured, own_contrast, &own)),
                );
            }
        }
    }
    rows
}

/// Means by mode where modes are not compared: of everybody's sessions with equal weight.
fn means_of(measured: &Measured, fits: &[&PsychometricFit], level: f64) -> Vec<Mean> {
    let mut modes: Vec<&ModeId> = Vec::new();
    for fit in fits {
        if !modes.contains(&&fit.mode) {
            modes.push(&fit.mode);
        }
    }
    let rows = modes.into_iter().filter_map(|mode| {
        let mut people: BTreeMap<&ParticipantId, Vec<f64>> = BTreeMap::new();
        for fit in fits.iter().filter(|fit| fit.mode == *mode) {
            people.entry(&fit.participant).or_default().extend(value(fit, measured.quantity));
        }
        people.retain(|_, sessions| !sessions.is_empty());
        let of_person = |own: &Vec<f64>| own.iter().sum::<f64>() / own.len() as f64;
        let values: Vec<f64> = people.values().map(of_person).collect();
        let found = interval::mean(&values, level).ok()?;
        let trials: usize = people.values().map(Vec::len).sum();
        Some(Mean {
            metric: measured.metric.clone(),
            unit: measured.task.metric_unit(measured.quantity).into(),
            environment: measured.task.environment.clone(),
            mode: mode.clone(),
            unit_of_analysis: UnitOfAnalysis::Participants,
            n: values.len(),
            trials,
            trials_with_value: trials,
            mean: found.estimate?,
            sd: found.sd,
            ci_low: found.interval.map(|interval| interval.ci_low),
            ci_high: found.interval.map(|interval| interval.ci_high),
        })
    });
    rows.collect()
}

fn mean(measured: &Measured, row: &Mean, fits: &[&PsychometricFit], level: f64) -> PeopleThreshold {
    let Measured { task, quantity, metric } = measured;
    let back = |value: f64| back(*quantity, value);
    let standard = task.standard.map(|standard| standard.value());
    let standard = standard.filter(|own| *own > 0.0 && *quantity == TaskQuantity::Jnd);
    let weighted = weighted(fits, *quantity, [Some(&row.mode), None], level);
    PeopleThreshold {
        task: task.id.clone(),
        quantity: *quantity,
        metric: metric.clone(),
        environment: row.environment.clone(),
        mode: Some(row.mode.clone()),
        contrast: None,
        unit: task.unit().into(),
        n: row.n,
        estimate: back(row.mean),
        ci_low: row.ci_low.map(back),
        ci_high: row.ci_high.map(back),
        statistic: None,
        df: None,
        p_value: None,
        p_adjusted: None,
        weber_fraction: standard.map(|standard| back(row.mean) / standard),
        weighted: weighted.found.map(|found| back(found.mean.estimate)),
        weighted_ci_low: weighted.found.map(|found| back(found.mean.ci_low)),
        weighted_ci_high: weighted.found.map(|found| back(found.mean.ci_high)),
        weighted_p_value: None,
        between_sd: weighted.found.map(|found| found.between.sqrt()),
        weighted_n: weighted.n,
    }
}

fn difference(
    measured: &Measured,
    row: &ModeDifference,
    fits: &[&PsychometricFit],
    level: f64,
) -> PeopleThreshold {
    let Measured { task, quantity, metric } = measured;
    let back = |value: f64| back(*quantity, value);
    let modes = [Some(&row.contrast.mode), Some(&row.contrast.against)];
    let weighted = weighted(fits, *quantity, modes, level);
    let is_ratio = *quantity == TaskQuantity::Jnd;
    PeopleThreshold {
        task: task.id.clone(),
        quantity: *quantity,
        metric: metric.clone(),
        environment: row.environment.clone(),
        mode: None,
        contrast: Some(row.contrast.clone()),
        unit: if is_ratio { "1".into() } else { task.unit().into() },
        n: row.n,
        estimate: back(row.difference),
        ci_low: row.difference_ci_low.map(back),
        ci_high: row.difference_ci_high.map(back),
        statistic: row.statistic,
        df: row.df.filter(|_| row.statistic.is_some()),
        p_value: row.p_value,
        p_adjusted: row.p_adjusted,
        weber_fraction: None,
        weighted: weighted.found.map(|found| back(found.mean.estimate)),
        weighted_ci_low: weighted.found.map(|found| back(found.mean.ci_low)),
        weighted_ci_high: weighted.found.map(|found| back(found.mean.ci_high)),
        weighted_p_value: weighted.found.map(|found| found.mean.p_value),
        between_sd: weighted.found.map(|found| found.between.sqrt()),
        weighted_n: weighted.n,
    }
}

/// What people just notice by each task that tells a JND: the geometric mean over people of everybody's over sessions and
/// modes, as a share of the standard, of an angle in rad. Of several tasks of one unit the first counts.
pub fn measured(tasks: &[Task], fits: &[PsychometricFit], level: f64) -> Vec<MeasuredJnd> {
    let mut all: Vec<MeasuredJnd> = Vec::new();
    for task in tasks {
        let Some(unit) = MeasuredJnd::unit_of(task.unit()) else { continue };
        let standard = task.standard.map_or(0.0, |standard| standard.value());
        let over = match task.unit() {
            "rad" => 1.0,
            "°" => 1_f64.to_degrees(),
            _ => standard,
        };
        if over <= 0.0 || all.iter().any(|own| own.unit == unit) {
            continue;
        }
        let mut people: BTreeMap<&ParticipantId, Vec<f64>> = BTreeMap::new();
        for fit in fits.iter().filter(|fit| fit.task == task.id) {
            people.entry(&fit.participant).or_default().extend(value(fit, TaskQuantity::Jnd));
        }
        people.retain(|_, own| !own.is_empty());
        let of_person = |own: &Vec<f64>| own.iter().sum::<f64>() / own.len() as f64;
        let values: Vec<f64> = people.values().map(of_person).collect();
        let Ok(found) = interval::mean(&values, level) else { continue };
        let back = |compared: f64| libm::exp(compared) / over;
        let Some(jnd) = found.estimate.map(back) else { continue };
        let ends = found.interval.map(|ends| [back(ends.ci_low), back(ends.ci_high)]);
        all.push(MeasuredJnd { unit: unit.to_owned(), jnd, ends, n: values.len() });
    }
    all
}

/// A difference that nothing is compared for: one person's two values describe that person.
fn described(
    measured: &Measured,
    contrast: &Contrast,
    fits: &[&PsychometricFit],
) -> Option<PeopleThreshold> {
    let Measured { task, quantity, metric } = measured;
    let is_of = |fit: &&&PsychometricFit, mode: &ModeId| fit.mode == *mode;
    let mut differences = Vec::new();
    for fit in fits.iter().filter(|fit| is_of(fit, &contrast.mode)) {
        let mut others = fits.iter().filter(|fit| is_of(fit, &contrast.against));
        let key = (&fit.participant, &fit.session);
        let other = others.find(|other| (&other.participant, &other.session) == key);
        let pair = other.and_then(|other| value(fit, *quantity).zip(value(other, *quantity)));
        differences.extend(pair.map(|(own, other)| (key.0, own - other)));
    }
    let people: BTreeSet<&ParticipantId> = differences.iter().map(|(who, _)| *who).collect();
    if people.len() != 1 {
        return None;
    }
    let sum: f64 = differences.iter().map(|(_, difference)| difference).sum();
    let is_ratio = *quantity == TaskQuantity::Jnd;
    Some(PeopleThreshold {
        task: task.id.clone(),
        quantity: *quantity,
        metric: metric.clone(),
        environment: task.environment.clone(),
        mode: None,
        contrast: Some(contrast.clone()),
        unit: if is_ratio { "1".into() } else { task.unit().into() },
        n: 1,
        estimate: back(*quantity, sum / differences.len() as f64),
        ci_low: None,
        ci_high: None,
        statistic: None,
        df: None,
        p_value: None,
        p_adjusted: None,
        weber_fraction: None,
        weighted: None,
        weighted_ci_low: None,
        weighted_ci_high: None,
        weighted_p_value: None,
        between_sd: None,
        weighted_n: 0,
    })
}

/// A number as it is shown: of a JND no logarithm, so that a difference is a ratio.
fn back(quantity: TaskQuantity, compared: f64) -> f64 {
    if quantity == TaskQuantity::Jnd { libm::exp(compared) } else { compared }
}

/// The two-level model, and of how many people.
struct Weighted {
    found: Option<TwoLevel>,
    n: usize,
}

/// The two-level model of everybody's value in the first mode, or of its difference from that in the second: over their
/// sessions with equal weight, the variances of the errors added.
fn weighted(
    fits: &[&PsychometricFit],
    quantity: TaskQuantity,
    [mode, against]: [Option<&ModeId>; 2],
    level: f64,
) -> Weighted {
    let in_mode = |wanted: Option<&ModeId>| {
        let mut all: BTreeMap<(&ParticipantId, &SessionId), [f64; 2]> = BTreeMap::new();
        for fit in fits.iter().filter(|fit| Some(&fit.mode) == wanted) {
            if let (Some(own), Some(error)) = (value(fit, quantity), std_error(fit, quantity)) {
                all.insert((&fit.participant, &fit.session), [own, error * error]);
            }
        }
        all
    };
    let first = in_mode(mode);
    let second = in_mode(against);
    let mut people: BTreeMap<&ParticipantId, Vec<[f64; 2]>> = BTreeMap::new();
    for (key, [own, variance]) in &first {
        let of_session = match (against, second.get(key)) {
            (None, _) => [*own, *variance],
            (Some(_), Some([other, of_other])) => [own - other, variance + of_other],
            (Some(_), None) => continue,
        };
        people.entry(key.0).or_default().push(of_session);
    }
    let mut values = Vec::new();
    let mut variances = Vec::new();
    for sessions in people.values() {
        let n = sessions.len() as f64;
        values.push(sessions.iter().map(|own| own[0]).sum::<f64>() / n);
        variances.push(sessions.iter().map(|own| own[1]).sum::<f64>() / (n * n));
    }
    Weighted { found: two_level(&values, &variances, level).ok(), n: values.len() }
}
