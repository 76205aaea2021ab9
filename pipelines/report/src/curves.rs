//! What the comparison of whole curves says, in sentences.

use crate::compared::{Primaries, environment_label};
use crate::findings::Finding;
use crate::gallery::Shown;
use crate::people::capital;
use zwidth_results::{CurveDifference, CurveRun, GroupEffect, LoopBranch, Role, Verdict};
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

/// What each primary curve says, in one sentence of all its comparisons of everybody.
pub fn curve_answers(
    study: &Setup,
    tests: &[CurveDifference],
    primaries: Primaries,
) -> Vec<Finding> {
    let the = if primaries == Primaries::Several { "a" } else { "the" };
    let primary = tests
        .iter()
        .filter(|test| test.role == Role::Primary && test.groups.is_none())
        .collect::<Vec<_>>();
    let answer = |own: &[&CurveDifference]| {
        let parts = own.iter().map(|test| {
            let p =
                test.p_adjusted.map_or(String::new(), |p| format!(" (adjusted p {})", p_value(p)));
            let verdict = match test.verdict {
                Some(Verdict::Different) => format!(
                    "differs somewhere{p}, most clearly at {}{}",
                    at(study, test.theta_rad, test.t_s),
                    on_way(test.branch)
                ),
                Some(Verdict::Undecided) => format!("was not shown to differ{p}"),
                _ => match &test.remark {
                    Some(why) => format!("was not tested ({why})"),
                    None => "was not tested".to_owned(),
                },
            };
            format!("{}, {} {verdict}", in_environment(study, test), effect(study, test))
        });
        let within = own[0].within.as_ref().map_or(String::new(), |who| format!("Within {who}: "));
        let label = capital(&curve_label(own[0].curve, study.coordinate));
        let parts = parts.collect::<Vec<_>>().join("; ");
        let text = format!("{within}{label} ({the} primary measure): {parts}.");
        let shown = Shown::Curves {
            curve: own[0].curve,
            environment: own[0].environment.clone(),
            of_groups: false,
        };
        Finding { is_answer: true, ..Finding::new(text, shown) }
    };
    primary.chunk_by(|a, b| a.curve == b.curve).map(answer).collect()
}

fn in_environment(study: &Setup, test: &CurveDifference) -> String {
    match &test.environment {
        Some(environment) => environment_label(study, environment),
        None => "Over several environments".to_owned(),
    }
}

fn effect(study: &Setup, test: &CurveDifference) -> String {
    match &test.effect {
        GroupEffect::Of(contrast) => contrast_label(&study.modes, contrast),
        other => other.to_string(),
    }
}

/// A place along a curve, as people of the study say it.
fn at(study: &Setup, theta_rad: Option<f64>, t_s: Option<f64>) -> String {
    let (unit, factor) = shown_unit("rad", study.coordinate);
    match (theta_rad, t_s) {
        (Some(theta), _) => with_unit(&number(theta * factor, Some(1.0)), &unit),
        (None, Some(t)) => with_unit(&number(t, Some(0.1)), "s"),
        (None, None) => String::new(),
    }
}

/// `Spring, user's force over the angle, Hybrid − Active: there is a difference somewhere (…)`; nothing of what was
/// not tested.
fn sentence(study: &Setup, test: &CurveDifference, runs: &[&CurveRun]) -> Option<String> {
    let (unit, factor) = shown_unit(&test.unit, study.coordinate);
    let effect = effect(study, test);
    let effect = match &test.groups {
        Some(groups) => format!("{groups} in {effect}"),
        None => effect,
    };
    let people = match (test.n_second, &test.within) {
        (Some(second), _) => format!("{} + {second} participants", test.n),
        (None, Some(who)) => format!("{} of {who}", counted(test.n, "trials")),
        (None, None) => counted(test.n, "participants"),
    };
    let test_by = match (&test.within, &test.groups) {
        (Some(_), _) => "redrawn orders",
        (None, Some(_)) => "permuted labels",
        (None, None) => "flipped signs",
    };
    let role = match test.role {
        Role::Primary => "",
        Role::Exploratory => "; exploratory",
        Role::ChosenAfter => "; exploratory, chosen after the data",
    };
    let place = format!(
        "{}, {}, {effect}",
        in_environment(study, test),
        curve_label(test.curve, study.coordinate)
    );
    let remark = test.remark.as_ref().map(|why| format!("; {why}")).unwrap_or_default();
    let (t, p, difference) = (test.largest_t?, test.p_value?, test.difference?);
    let verdict = match (&test.groups, test.verdict) {
        (None, Some(Verdict::Different)) => "there is a difference somewhere",
        (None, Some(Verdict::Undecided)) => "no difference was shown, nor that there is none",
        (None, _) => "not tested",
        (Some(_), _) => "described, not claimed",
    };
    let p = match test.p_adjusted {
        Some(adjusted) => format!("adjusted p {} by {test_by}", p_value(adjusted)),
        None => format!("p {} by {test_by}", p_value(p)),
    };
    let places: Vec<String> = runs
        .iter()
        .map(|run| {
            let [low, high] = [(run.theta_low_rad, run.begins_s), (run.theta_high_rad, run.ends_s)]
                .map(|(theta_rad, t_s)| at(study, theta_rad, t_s));
            format!("between {low} and {high}{}", on_way(run.branch))
        })
        .collect();
    let places = match places.as_slice() {
        [] => String::new(),
        places => format!(" Runs of large t: somewhere {}.", places.join(", and somewhere ")),
    };
    Some(format!(
        "{place}: {verdict} (largest |t| = {} at {}{}, where it is {}; {p}; {people}{role}){remark}.{places}",
        number(t.abs(), Some(0.1)),
        at(study, test.theta_rad, test.t_s),
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
