//! What the comparison of groups says, in sentences.

use crate::compared::{Brief, ComparedMetric, before, explored};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{GroupDifference, GroupEffect, Role, Verdict};
use zwidth_study::{Setup, contrast_label, in_a_sentence};
use zwidth_tables::{number, p_value, shown_unit, with_unit};

/// Every claim about groups in a sentence, with effect, interval, test and the people of either group. Where no
/// modes are compared they are the answer.
pub fn group_differences(study: &Setup, metric: &ComparedMetric) -> Vec<Finding> {
    let words = metric.words(study.coordinate);
    let claims = metric.groups.iter().filter_map(|row| sentence(study, metric, row, &words));
    let shown = Shown::Groups(metric.metric.metric.to_string());
    let is_answer = metric.contrasts.is_empty() && metric.metric.role == Role::Primary;
    claims.map(|text| Finding { is_answer, ..Finding::new(text, shown.clone()) }).collect()
}

/// The claims about groups in a metric that is not primary, in one sentence.
pub fn explored_groups(study: &Setup, metric: &ComparedMetric) -> Option<Finding> {
    let briefs = metric.groups.iter().filter_map(|row| {
        Some(Brief {
            place: place(study, row),
            difference: row.difference,
            error: row.difference_std_error,
            ends: row.difference_ci_low.zip(row.difference_ci_high),
            verdict: row.verdict?,
            size: row.size,
            remark: row.remark.as_ref(),
        })
    });
    explored(study, metric, briefs.collect(), Shown::Groups(metric.metric.metric.to_string()))
}

/// What of people is compared between groups: `the difference Hybrid − Active`.
pub(crate) fn compared_words(study: &Setup, effect: &GroupEffect) -> String {
    match effect {
        GroupEffect::OverModes => "the mean over modes".to_owned(),
        GroupEffect::In(id) => {
            let mode = study.modes.iter().find(|mode| mode.id == *id);
            mode.map_or_else(|| id.to_string(), |mode| in_a_sentence(&mode.label))
        }
        GroupEffect::OfFactors(effect) if effect.levels.is_none() => format!("the {effect}"),
        GroupEffect::OfFactors(effect) => format!("the effect {effect}"),
        GroupEffect::Of(contrast) => {
            format!("the difference {}", contrast_label(&study.modes, contrast))
        }
    }
}

/// `Spring, expert − novice in the difference Hybrid − Active`.
fn place(study: &Setup, row: &GroupDifference) -> String {
    let environment = before(study, row.environment.as_ref(), ", ");
    format!("{environment}{} in {}", row.groups, compared_words(study, &row.effect))
}

/// `Spring, expert − novice in the difference Hybrid − Active: the force differs by 0.02 N (…)`; nothing of what is no
/// claim.
fn sentence(
    study: &Setup,
    metric: &ComparedMetric,
    row: &GroupDifference,
    words: &str,
) -> Option<String> {
    let verdict = row.verdict?;
    let (unit, factor) = shown_unit(&metric.metric.unit, study.coordinate);
    let error = row.difference_std_error.map(|error| error * factor);
    let shown = |value: f64| number(value * factor, error);
    let place = place(study, row);
    let amount = match row.difference {
        Some(difference) => with_unit(&shown(difference), &unit),
        None => "not known".to_owned(),
    };
    let interval = row.difference_ci_low.zip(row.difference_ci_high);
    let interval =
        interval.map(|(low, high)| format!("interval {} to {}, ", shown(low), shown(high)));
    let test = row
        .statistic
        .zip(row.df)
        .map(|(t, df)| format!(", Welch's t({}) = {}", number(df, None), number(t, None)));
    let p = row.p_adjusted.map(|p| format!(", adjusted p {}", p_value(p)));
    let effect = [("g_av", row.g_av), ("d_av", row.d_av)].into_iter();
    let mut effect =
        effect.filter_map(|(name, value)| Some(format!(", {name} = {}", number(value?, None))));
    let more: String = [test, p, effect.next()].into_iter().flatten().collect();
    let is_open = verdict == Verdict::Undecided && row.remark.is_none();
    let why = match &row.remark {
        Some(remark) => format!(": {remark}"),
        None if is_open => ", neither a difference nor its absence was shown".to_owned(),
        None => String::new(),
    };
    let size = row.size.map(|size| {
        let jnds = row.difference_jnd.map(|jnds| format!(": {} JND", number(jnds, None)));
        format!("; {}{}", size.as_str(), jnds.unwrap_or_default())
    });
    Some(format!(
        "{place}: {words} differs by {amount} ({}{} and {} people{more}): {}{why}{}.",
        interval.unwrap_or_default(),
        row.n_first,
        row.n_second,
        verdict.as_str(),
        size.unwrap_or_default(),
    ))
}
