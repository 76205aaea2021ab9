//! What the comparison of groups says, in sentences.

use crate::compared::{Brief, ComparedMetric, before, explored};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{GroupDifference, GroupEffect, Role, Sides, Verdict};
use zwidth_study::{Setup, contrast_label, in_a_sentence, ratio_label};
use zwidth_tables::{Amount, Amounts, number, p_value};

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
            place: place(study, metric, row),
            difference: row.difference,
            error: row.difference_std_error,
            ends: row.difference_ci_low.zip(row.difference_ci_high),
            sides: row.sides(),
            verdict: row.verdict?,
            size: row.size,
            remark: row.remark.as_ref(),
        })
    });
    explored(study, metric, briefs.collect(), Shown::Groups(metric.metric.metric.to_string()))
}

/// Two groups and what of their people is compared: `expert − novice in the difference Hybrid − Active`; of logarithms
/// `expert / novice in the ratio Hybrid / Active`.
pub(crate) fn compared_words(study: &Setup, amounts: &Amounts, row: &GroupDifference) -> String {
    let effect = effect_words(study, amounts, &row.effect);
    format!("{} in {effect}", amounts.compared(&row.groups.to_string()))
}

fn effect_words(study: &Setup, amounts: &Amounts, effect: &GroupEffect) -> String {
    match effect {
        GroupEffect::OverModes if amounts.are_logarithms() => {
            "the geometric mean over modes".to_owned()
        }
        GroupEffect::OverModes => "the mean over modes".to_owned(),
        GroupEffect::In(id) => {
            let mode = study.modes.iter().find(|mode| mode.id == *id);
            mode.map_or_else(|| id.to_string(), |mode| in_a_sentence(&mode.label))
        }
        GroupEffect::OfFactors(effect) if effect.levels.is_none() => format!("the {effect}"),
        GroupEffect::OfFactors(effect) => {
            format!("the effect {}", amounts.compared(&effect.to_string()))
        }
        GroupEffect::Of(contrast) if amounts.are_logarithms() => {
            format!("the ratio {}", ratio_label(&study.modes, contrast))
        }
        GroupEffect::Of(contrast) => {
            format!("the difference {}", contrast_label(&study.modes, contrast))
        }
    }
}

/// `Spring, expert − novice in the difference Hybrid − Active`.
fn place(study: &Setup, metric: &ComparedMetric, row: &GroupDifference) -> String {
    let environment = before(study, row.environment.as_ref(), ", ");
    environment + &compared_words(study, &metric.amounts(study), row)
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
    let amounts = metric.amounts(study);
    let place = place(study, metric, row);
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    let amount = row
        .difference
        .map(|difference| amounts.told(difference, ends, row.difference_std_error, row.sides()));
    let differs = match (amount.as_ref(), amounts.are_logarithms(), row.sides()) {
        (None, ..) => format!("{words} differs by not known"),
        (Some(Amount { text, .. }), false, _) => format!("{words} differs by {text}"),
        (Some(Amount { text, .. }), true, Sides::Values) => {
            format!("the {words} is {text} as large")
        }
        (Some(Amount { text, .. }), true, Sides::Differences) => format!("the {words} has {text}"),
    };
    let interval = amount.and_then(|amount| amount.ends).map(|ends| format!("interval {ends}, "));
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
        "{place}: {differs} ({}{} and {} people{more}): {}{why}{}.",
        interval.unwrap_or_default(),
        row.n_first,
        row.n_second,
        verdict.as_str(),
        size.unwrap_or_default(),
    ))
}
