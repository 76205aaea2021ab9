//! What the tests of a metric, and those of the means of answers, say of studies without an effect.

use crate::drawn::{Kind, Measured, Study, complete, differences, tidy};
use crate::judged::{Asked, Judged, LEVEL, MOST, Said, judge};
use zwidth_stats::Tested;
use zwidth_stats::lmm::trials::{Trials, fit_trials};
use zwidth_stats::lmm::{Column, Criterion, Fit, Model, RandomTerm, fit};
use zwidth_stats::null::Sampling;
use zwidth_stats::{friedman, paired, sign_flip, signed_rank};

pub(crate) const SAMPLING: Sampling = Sampling { draws: 999, seed: 1 };
/// What is asked of t and Kenward–Roger.
const APPROXIMATE: Asked = Asked::Approximate { most: MOST, coverage: [0.94, 0.985] };
/// The contrast of the last of three modes with the first, by their means.
const CONTRAST: [f64; 3] = [-1.0, 0.0, 1.0];

/// The tests of participants' means, which are the defaults.
pub(crate) fn paired_tests(kind: Kind, studies: usize) -> Vec<Judged> {
    // Friedman's null is that a participant's values could stand in any order.
    let of_orders = if kind.is_even() { Asked::Exact } else { Asked::Nothing };
    let tests = [
        ("t", APPROXIMATE),
        ("sign-flip", Asked::Exact),
        ("signed-rank", Asked::Exact),
        ("Friedman", of_orders),
    ];
    judge(studies, tests, |study| {
        let study = kind.draw(study);
        let differences = differences(&study);
        let complete = complete(&study);
        let rows: Vec<&[f64]> = complete.iter().map(|row| row.as_slice()).collect();
        [
            Said::by_estimate(paired::mean_difference(&differences, LEVEL).ok()),
            Said::by_p(sign_flip::test(&differences, SAMPLING).ok().map(|found| found.p_value)),
            Said::by_p(signed_rank::test(&differences).ok().map(|found| found.p_value)),
            Said::by_p(friedman::test(&rows, SAMPLING).ok().map(|found| found.p_value)),
        ]
    })
}

/// The mixed models of all trials: Kenward & Roger, which pools the modes' scatters, and so
/// promises nothing where they differ; beside it what is no default anywhere.
pub(crate) fn mixed_models(kind: Kind, studies: usize) -> Vec<Judged> {
    let pooled = if kind.is_even() { APPROXIMATE } else { Asked::Nothing };
    let tests = [
        ("Kenward–Roger", pooled),
        ("Satterthwaite", Asked::Nothing),
        ("random intercept alone", Asked::Nothing),
    ];
    assert_eq!(kind.measured, Measured::Metric);
    judge(studies, tests, |study| {
        let study = kind.draw(study);
        let [kenward_roger, satterthwaite] = largest(&study);
        let alone = lone_intercept(&study).and_then(|fit| by_kenward_roger(&fit, &CONTRAST));
        [kenward_roger, satterthwaite, alone].map(Said::by_estimate)
    })
}

/// The largest model that the design supports, after Kenward & Roger and after Satterthwaite.
fn largest(study: &Study) -> [Option<Tested>; 2] {
    let (participant, mode, value) = tidy(study);
    let session = vec![0; value.len()];
    let trials =
        Trials { participant: &participant, session: &session, mode: &mode, value: &value };
    let Ok(found) = fit_trials(trials) else { return [None; 2] };
    let Ok(weights) = found.difference(2, 0) else { return [None; 2] };
    let satterthwaite = found.fit.satterthwaite().and_then(|sat| sat.test(&weights, LEVEL)).ok();
    [by_kenward_roger(&found.fit, &weights), satterthwaite]
}

fn by_kenward_roger(fit: &Fit, weights: &[f64]) -> Option<Tested> {
    fit.kenward_roger().ok()?.test(weights, LEVEL).ok()
}

/// The model that takes repeats for people.
fn lone_intercept(study: &Study) -> Option<Fit> {
    let (group, modes, response) = tidy(study);
    let column = |mode: usize| Column {
        name: format!("mode {mode}"),
        values: modes.iter().map(|at| f64::from(u8::from(*at == mode))).collect(),
    };
    let random = vec![RandomTerm::intercept("participant", vec![0; response.len()])];
    let model = Model { response, fixed: (0..3).map(column).collect(), group, random };
    fit(&model, Criterion::Reml).ok()
}
