//! What the comparison of whole curves says, in sentences.

use crate::compared::environment_label;
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{CurveDifference, CurveRun, GroupEffect, LoopBranch, Verdict};
use zwidth_study::{Setup, contrast_label, counted, curve_label};
use zwidth_tables::{number, p_value, shown_unit, with_unit};

/// Every whole curve that was tested in a sentence: whether there is a difference somewhere, where it is largest for its
/// scatter, and if there is one within which runs below `alpha` it lies somewhere. Of groups only those of differences and of
/// the mean over modes.
pub fn curve_differences(
    study: &Setup,
    tests: &[CurveDifference],
    runs: &[CurveRun],
    alpha: f64,
) -> Vec<Finding> {
    let is_told = |test: &&CurveDifference| {
        test.groups.is_none() || !matches!(test.effect, GroupEffect::In(_))
    };
    let told = tests.iter().filter(is_told).filter_map(|test| {
        let is_own = |run: &&CurveRun| {
            (run.curve, &run.environment, &run.effect)
                == (test.curve, &test.environment, &test.effect)
                && test.verdict == Some(Verdict::Different)
                && run.p_value < alpha
        };
        let runs: Vec<&CurveRun> = runs.iter().filter(is_own).collect();
        let shown = Shown::Curves {
            curve: test.curve,
            environment: test.environment.clone(),
            of_groups: test.groups.is_some(),
        };
        Some(Finding::new(sentence(study, test, &runs)?, shown))
    });
    told.collect()
}

/// `Spring, user's force over the angle, Hybrid − Active: there is a difference somewhere (…)`; nothing of what was
/// not tested.
fn sentence(study: &Setup, test: &CurveDifference, runs: &[&CurveRun]) -> Option<String> {
    let (unit, factor) = shown_unit(&test.unit, study.coordinate);
    let effect = match &test.effect {
        GroupEffect::Of(contrast) => contrast_label(&study.modes, contrast),
        other => other.to_string(),
    };
    let effect = match &test.groups {
        Some(groups) => format!("{groups} in {effect}"),
        None => effect,
    };
    let (position, position_factor) = shown_unit("rad", study.coordinate);
    let at = |theta_rad: Option<f64>, t_s: Option<f64>| match (theta_rad, t_s) {
        (Some(theta), _) => with_unit(&number(theta * position_factor, Some(1.0)), &position),
        (None, Some(t)) => with_unit(&number(t, Some(0.1)), "s"),
        (None, None) => String::new(),
    };
    let people = match test.n_second {
        Some(second) => format!("{} + {second} participants", test.n),
        None => counted(test.n, "participants"),
    };
    let environment = match &test.environment {
        Some(environment) => environment_label(study, environment),
        None => "Over several environments".to_owned(),
    };
    let place = format!("{environment}, {}, {effect}", curve_label(test.curve, study.coordinate));
    let remark = test.remark.as_ref().map(|why| format!("; {why}")).unwrap_or_default();
    let (t, p, difference) = (test.largest_t?, test.p_value?, test.difference?);
    let verdict = match (&test.groups, test.verdict) {
        (None, Some(Verdict::Different)) => "there is a difference somewhere",
        (None, Some(Verdict::Undecided)) => "no difference was shown, nor that there is none",
        (None, _) => "not tested",
        (Some(_), _) => "described, not claimed",
    };
    let p = match (test.p_adjusted, &test.groups) {
        (Some(adjusted), _) => format!("adjusted p {} by flipped signs", p_value(adjusted)),
        (None, Some(_)) => format!("p {} by permuted labels", p_value(p)),
        (None, None) => format!("p {} by flipped signs", p_value(p)),
    };
    let places: Vec<String> = runs
        .iter()
        .map(|run| {
            let [low, high] =
                [at(run.theta_low_rad, run.begins_s), at(run.theta_high_rad, run.ends_s)];
            format!("between {low} and {high}{}", on_way(run.branch))
        })
        .collect();
    let places = match places.as_slice() {
        [] => String::new(),
        places => format!(" Runs of large t: somewhere {}.", places.join(", and somewhere ")),
    };
    Some(format!(
        "{place}: {verdict} (largest |t| = {} at {}{}, where it is {}; {p}; {people}; exploratory){remark}.{places}",
        number(t.abs(), Some(0.1)),
        at(test.theta_rad, test.t_s),
        on_way(test.branch),
        with_unit(&number(difference * factor, Some((difference / t * factor).abs())), &unit),
    ))
}

fn on_way(branch: Option<LoopBranch>) -> &'static str {
    match branch {
        Some(LoopBranch::In) => " on the way there",
        Some(LoopBranch::Out) => " on the way back",
        Some(LoopBranch::Held) | None => "",
    }
}
