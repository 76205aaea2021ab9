//! What can be felt by the answers to tasks, in sentences.

use crate::findings::Finding;
use crate::gallery::Shown;
use crate::people::capital;
use zwidth_results::{PeopleThreshold, PsychometricFit};
use zwidth_study::{Contrast, MetricId, ModeId, Setup, Task, TaskQuantity, in_a_sentence};
use zwidth_tables::{number, p_value, shown_unit, with_unit};

/// Digits that a number of its own has besides its first, where no error sets them.
const DIGITS: f64 = 100.0;

/// Every difference between modes in a threshold or JND in a sentence, JNDs as ratios with the Weber fractions of both
/// modes; where modes are not compared the means; and who has no estimate. Those of `primary` metrics are answers.
pub fn felt_thresholds(
    study: &Setup,
    tasks: &[Task],
    fits: &[PsychometricFit],
    rows: &[PeopleThreshold],
    primary: &[MetricId],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for task in tasks {
        let shown = || Shown::Thresholds(task.id.to_string());
        for quantity in task.quantities() {
            let own = rows.iter().filter(|row| row.task == task.id && row.quantity == quantity);
            let own: Vec<&PeopleThreshold> = own.collect();
            let compared: Vec<String> =
                own.iter().filter_map(|row| difference(study, task, row, &own)).collect();
            let told = match compared.is_empty() {
                true => own.iter().filter_map(|row| mean(study, task, row)).collect(),
                false => compared,
            };
            let is_primary = own.first().is_some_and(|row| primary.contains(&row.metric));
            findings.extend(
                told.into_iter()
                    .map(|text| Finding { is_answer: is_primary, ..Finding::new(text, shown()) }),
            );
        }
        let missing = fits.iter().filter(|fit| fit.task == task.id);
        let missing: Vec<String> = missing
            .filter(|fit| !fit.verdict.is_estimated())
            .map(|fit| {
                let mode = mode_label(study, &fit.mode);
                format!(
                    "{} {} with {mode} ({})",
                    fit.participant,
                    fit.session,
                    fit.verdict.as_str()
                )
            })
            .collect();
        if !missing.is_empty() {
            let text = format!(
                "“{}”: no threshold is known of {}. Such people are not missing at random.",
                task.text,
                missing.join(", ")
            );
            findings.push(Finding::new(text, shown()));
        }
    }
    findings
}

fn mode_label(study: &Setup, id: &ModeId) -> String {
    let mode = study.modes.iter().find(|mode| mode.id == *id);
    mode.map_or_else(|| id.to_string(), |mode| in_a_sentence(&mode.label))
}

/// A number with its interval: `1.40 [1.24, 1.57]`; half of its length sets the digits.
fn with_interval(row: &PeopleThreshold, factor: f64, unit: &str) -> String {
    let error = row.ci_low.zip(row.ci_high).map(|(low, high)| factor * (high - low) / 4.0);
    let error = error.unwrap_or(row.estimate.abs() * factor / DIGITS);
    let shown = |value: f64| number(value * factor, Some(error));
    let amount = with_unit(&shown(row.estimate), unit);
    match (row.ci_low, row.ci_high) {
        (Some(low), Some(high)) => format!("{amount} [{}, {}]", shown(low), shown(high)),
        _ => amount,
    }
}

/// `“Which one was stiffer?”: the JND with hybrid is 1.40 times that with active [1.24, 1.57], t(7) = 6.7, p = 0.0003;
/// Weber fractions 0.13 and 0.09; 8 people.`
fn difference(
    study: &Setup,
    task: &Task,
    row: &PeopleThreshold,
    own: &[&PeopleThreshold],
) -> Option<String> {
    let Contrast { mode, against } = row.contrast.as_ref()?;
    let (unit, factor) = shown_unit(task.unit(), study.coordinate);
    let what = row.quantity.in_words();
    let [first, second] = [mode, against].map(|mode| mode_label(study, mode));
    let size = if row.quantity == TaskQuantity::Jnd {
        let interval = match (row.ci_low, row.ci_high) {
            (Some(low), Some(high)) => format!(" [{low:.2}, {high:.2}]"),
            _ => String::new(),
        };
        format!("the {what} with {first} is {:.2} times that with {second}{interval}", row.estimate)
    } else {
        let direction = if row.estimate < 0.0 { "lower" } else { "higher" };
        let turned = match row.estimate < 0.0 {
            true => PeopleThreshold {
                estimate: -row.estimate,
                ci_low: row.ci_high.map(|end| -end),
                ci_high: row.ci_low.map(|end| -end),
                ..row.clone()
            },
            false => row.clone(),
        };
        let amount = with_interval(&turned, factor, &unit);
        format!("the {what} with {first} is {amount} {direction} than that with {second}")
    };
    let test = row.statistic.zip(row.df).map(|(t, df)| {
        let p = row.p_adjusted.or(row.p_value);
        let p = p.map(|p| format!(", p {}", p_value(p))).unwrap_or_default();
        format!(", t({}) = {}{p}", number(df, None), number(t, Some(1.0)))
    });
    let weber = |wanted: &ModeId| {
        let mean = own.iter().find(|other| other.mode.as_ref() == Some(wanted))?;
        Some(format!("{:.2}", mean.weber_fraction?))
    };
    let fractions = weber(mode).zip(weber(against));
    let fractions = fractions.map(|(a, b)| format!("; Weber fractions {a} and {b}"));
    let people = zwidth_study::counted(row.n, "participants");
    let weighted =
        row.weighted.filter(|_| row.weighted_n == row.n && row.weighted_p_value.is_some());
    let beside = weighted.map(|weighted| {
        let amount = match row.quantity {
            TaskQuantity::Jnd => format!("{weighted:.2}"),
            _ => {
                let error = row.ci_low.zip(row.ci_high).map(|(low, high)| (high - low) / 4.0);
                let error = error.map(|error| error * factor);
                with_unit(&number(weighted * factor, error), &unit)
            }
        };
        format!("; weighed by everybody's own errors {amount}")
    });
    Some(format!(
        "“{}”: {size}{}{}{} ({people}).",
        task.text,
        test.unwrap_or_default(),
        fractions.unwrap_or_default(),
        beside.unwrap_or_default(),
    ))
}

/// `“Which one was stiffer?”: the JND with active is 27 N/m [23, 32], a Weber fraction of 0.09 (8 people).`
fn mean(study: &Setup, task: &Task, row: &PeopleThreshold) -> Option<String> {
    let mode = mode_label(study, row.mode.as_ref()?);
    let (unit, factor) = shown_unit(task.unit(), study.coordinate);
    let amount = with_interval(row, factor, &unit);
    let what = capital(&format!("the {} with {mode}", row.quantity.in_words()));
    let weber = row.weber_fraction.map(|weber| format!(", a Weber fraction of {weber:.2}"));
    let people = zwidth_study::counted(row.n, "participants");
    Some(format!(
        "“{}”: {} is {amount}{} ({people}).",
        task.text,
        what.replacen("The ", "the ", 1),
        weber.unwrap_or_default()
    ))
}
