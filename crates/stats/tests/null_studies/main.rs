//! Studies without an effect, in which people differ in how they take each mode: what is found in
//! them is found by chance, and no more often than was promised.
//!
//! `ZWIDTH_NULL_STUDIES` sets how many studies of each kind there are (300; of models of answers
//! half as many, of profile intervals 3 %, and of both a tenth of that where nothing is promised).
//! `cargo xtask soak null` runs 40,000, of which every promise is asked for in full; with
//! `ZWIDTH_TRIED` set to a folder, tables of it are written there.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test, and no part of the product")]
#![allow(clippy::print_stdout, reason = "a test says what it counted")]

mod answers;
mod curves;
mod doses;
mod drawn;
mod effects;
mod groups;
mod judged;
mod metric;
mod page;
mod practice;
mod predicted;
mod procedures;
mod thresholds;

use drawn::{Kind, Measured, differences, kinds};
use judged::Judged;
use rayon::prelude::*;

/// From so many studies on the limits themselves are asked for. A test whose level is 5 % has an
/// upper bound of 5.35 % then, of 5.5 % in half as many; in 10,000 it would break a limit of 6 % by
/// chance once in eleven kinds, and in 2,000 always.
const WHOLE: usize = 40_000;

/// Studies of each kind.
fn studies() -> usize {
    let number = |text: String| text.parse().unwrap();
    std::env::var("ZWIDTH_NULL_STUDIES").map_or(300, number)
}

/// Of a test that costs more, so many studies of ten thousand.
fn studies_of(ten_thousandths: usize) -> usize {
    (studies() * ten_thousandths).div_ceil(10_000)
}

/// As `studies_of`, for a model of answers: a tenth of them where modes scatter differently, for
/// there nothing is promised of a model that pools the scatters.
fn of_answers(kind: Kind, ten_thousandths: usize) -> usize {
    let whole = studies_of(ten_thousandths);
    if kind.is_even() { whole } else { whole.div_ceil(10) }
}

/// Runs tests on all kinds, writes the table, and fails where a promise is broken.
fn hold<K: Copy>(
    place: u8,
    title: &str,
    kinds: Vec<(String, K)>,
    judge: impl Fn(K) -> Vec<Judged>,
) {
    let all: Vec<(String, Vec<Judged>)> =
        kinds.into_iter().map(|(name, kind)| (name, judge(kind))).collect();
    page::write(place, title, &page::table(&all));
    let broken: Vec<String> = all
        .iter()
        .flat_map(|(kind, judged)| judged.iter().map(move |judged| (kind, judged)))
        .filter_map(|(kind, judged)| {
            let broken = judged.broken(studies() >= WHOLE)?;
            Some(format!("{kind}: {broken}"))
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Kinds with their names.
fn named(kinds: Vec<Kind>) -> Vec<(String, Kind)> {
    kinds.into_iter().map(|kind| (kind.name(), kind)).collect()
}

#[test]
fn tests_of_groups_find_nothing_more_often_than_they_promise() {
    let kinds = groups::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(7, "Groups of people", kinds, |kind| groups::tests(kind, studies()));
}

#[test]
fn tests_of_factors_find_nothing_more_often_than_they_promise() {
    let kinds = effects::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(8, "Factors: an interaction of 3 × 3 levels", kinds, |kind| {
        effects::tests(kind, studies())
    });
}

#[test]
fn tests_of_curves_find_nothing_more_often_than_they_promise() {
    let kinds = curves::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(9, "Whole curves", kinds, |kind| curves::tests(kind, studies_of(2500)));
}

#[test]
fn tests_of_one_persons_curves_find_nothing_more_often_than_they_promise() {
    let kinds = curves::kinds_of_one().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(12, "Whole curves of one person's trials", kinds, |kind| {
        curves::tests_of_one(kind, studies_of(2500))
    });
}

#[test]
fn lines_over_trials_find_nothing_more_often_than_they_promise() {
    let kinds = practice::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(10, "Practice: own lines over trials", kinds, |kind| practice::tests(kind, studies()));
}

#[test]
fn lines_over_doses_find_nothing_more_often_than_they_promise() {
    let kinds = doses::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(11, "Doses of which a fifth of the cells is missing", kinds, |kind| {
        doses::tests(kind, studies())
    });
}

#[test]
fn intervals_of_thresholds_hold_the_truth_as_often_as_they_promise() {
    let kinds = thresholds::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(13, "Thresholds: 7 levels, one person", kinds, |kind| {
        thresholds::tests(kind, studies_of(250))
    });
}

#[test]
fn intervals_of_thresholds_by_procedures_hold_the_truth_as_often_as_they_promise() {
    let kinds = procedures::kinds().into_iter().map(|kind| (kind.name(), kind)).collect();
    hold(14, "Thresholds: staircases, QUEST+ and settings, one person", kinds, |kind| {
        procedures::tests(kind, studies_of(250))
    });
}

#[test]
fn paired_tests_of_a_metric_find_nothing_more_often_than_they_promise() {
    hold(1, "A metric: participants' means", named(kinds(Measured::Metric)), |kind| {
        metric::paired_tests(kind, studies())
    });
}

#[test]
fn paired_tests_of_answers_find_nothing_more_often_than_they_promise() {
    hold(3, "Answers: participants' means", named(kinds(Measured::Answer)), |kind| {
        metric::paired_tests(kind, studies())
    });
}

#[test]
fn mixed_models_find_nothing_more_often_than_they_promise() {
    hold(2, "A metric: mixed models of all trials", named(kinds(Measured::Metric)), |kind| {
        let judged = metric::mixed_models(kind, studies());
        // What these studies are for: the mistake shows in them, in any number of studies.
        let alone = &judged[2];
        assert!(!kind.is_even() || alone.rejected.is_too_many(), "{}: {alone:?}", kind.name());
        judged
    });
}

/// The kinds that models of answers, which take longest, are put to.
fn answered() -> Vec<Kind> {
    let reaches_the_contrast = |kind: &Kind| kind.is_even() || kind.scatter[1] < kind.scatter[2];
    kinds(Measured::Answer).into_iter().filter(reaches_the_contrast).collect()
}

#[test]
fn models_of_answers_find_nothing_more_often_than_they_promise() {
    hold(
        4,
        "Answers: cumulative-link models, and the probability of superiority",
        named(answered()),
        |kind| {
            let studies = of_answers(kind, 5000);
            let mut judged = answers::tests(kind, studies);
            if kind.people < answers::FEW {
                judged.extend(answers::bootstraps(kind, studies));
            }
            judged
        },
    );
}

#[test]
fn profile_intervals_hold_the_truth_as_often_as_they_promise() {
    hold(5, "Answers: profile intervals", named(answered()), |kind| {
        answers::profiles(kind, of_answers(kind, 300))
    });
}

#[test]
fn power_is_observed_as_it_was_predicted() {
    let all: Vec<_> = predicted::plans()
        .into_iter()
        .map(|plan| predicted::compare(plan, studies_of(2500)))
        .collect();
    page::write(6, "Power of the paired t, as predicted and as observed", &page::powers(&all));
    assert!(all.iter().all(predicted::Compared::is_held));
}

/// What the tests above would let through if nothing were ever found: an effect is.
#[test]
fn an_effect_of_two_standard_deviations_is_found() {
    let kind =
        Kind { people: 12, measured: Measured::Metric, scatter: [0.5; 3], is_complete: true };
    let is_found = |study: &u64| {
        let shifted: Vec<f64> = differences(&kind.draw(*study)).iter().map(|d| d + 1.6).collect();
        let flip = zwidth_stats::sign_flip::test(&shifted, metric::SAMPLING);
        let rank = zwidth_stats::signed_rank::test(&shifted);
        flip.is_ok_and(|f| f.p_value <= 0.05) && rank.is_ok_and(|r| r.p_value <= 0.05)
    };
    let found = (0..1000).into_par_iter().filter(is_found).count();
    assert!(found > 950, "{found} of 1000");
}
