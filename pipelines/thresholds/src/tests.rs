//! The stage from answers to thresholds over people, held against the values that others computed.

use crate::{
    Answered, Found, Means, Parameters, Response, measured, notes, over_people, thresholds, values,
};
use zwidth_results::{
    FitVerdict, Mean, ModeDifference, PeopleThreshold, PsychometricFit, UnitOfAnalysis, Verdict,
};
use zwidth_stats::paired;
use zwidth_study::{
    Asks, Contrast, Method, ModeId, Source, StaircasePlan, Task, TaskEstimate, TaskFit, TaskLevel,
    TaskQuantity, TaskSigmoid,
};

/// The number (h³ mod 9941)/9941 − ½ with h = 1 + 131 a + 173 b + 197 c + 211 d, between −½ and ½.
fn scattered([a, b, c, d]: [u64; 4]) -> f64 {
    let h = 1 + 131 * a + 173 * b + 197 * c + 211 * d;
    (h.pow(3) % 9941) as f64 / 9941.0 - 0.5
}

fn level(value: f64) -> TaskLevel {
    TaskLevel::nearest(value).unwrap()
}

fn mode(place: u64) -> ModeId {
    ["active", "hybrid"][place as usize].parse().unwrap()
}

fn task(asks: Asks, varies: &str, standard: f64, method: Method) -> Task {
    Task {
        id: "stiffer".parse().unwrap(),
        text: "Which one was stiffer?".to_owned(),
        asks,
        environment: "spring".parse().unwrap(),
        varies: varies.to_owned(),
        standard: Some(level(standard)),
        method,
        catch: 0.0,
        feedback: false,
        fit: TaskFit::default(),
        estimate: TaskEstimate::Likelihood,
    }
}

fn parameters(task: Task) -> Parameters {
    Parameters { tasks: vec![task], modes: vec![mode(0), mode(1)], level: 0.95, draws: 199 }
}

/// An answer of a person in a mode; its number is that of presentation and trial.
fn answer(person: u64, in_mode: u64, number: u32, at: f64, response: Response) -> Answered {
    Answered {
        participant: format!("P{person:02}").parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: number,
        task: "stiffer".parse().unwrap(),
        environment: "spring".parse().unwrap(),
        mode: mode(in_mode),
        presentation: number,
        track: 0,
        level: level(at),
        response,
        source: Source::Imported,
    }
}

/// Answers by level, from counts.
fn answers(person: u64, in_mode: u64, counts: &[(f64, usize, usize)]) -> Vec<Answered> {
    let mut all = Vec::new();
    for (at, trials, positive) in counts {
        for number in 0..*trials {
            let response = if number < *positive { Response::Positive } else { Response::Negative };
            all.push(answer(person, in_mode, all.len() as u32 + 1, *at, response));
        }
    }
    all
}

/// A distribution function of the standard normal distribution, by its complementary error function.
fn normal(z: f64) -> f64 {
    0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
}

/// How often persons 1 to 8 called seven stiffnesses the stiffer one, of 20 times each.
fn counts(p: u64, m: u64) -> Vec<(f64, usize, usize)> {
    let pse =
        300.0 + 30.0 * scattered([p, 1, 0, 0]) + 12.0 * m as f64 + 20.0 * scattered([p, 2, m, 0]);
    let grown = 0.8 * scattered([p, 3, 0, 0]) + 0.25 * m as f64 + 0.5 * scattered([p, 4, m, 0]);
    let sigma = 1.4826 * 30.0 * libm::exp(grown);
    let of_level = |l: u64| {
        let x = 210.0 + 30.0 * l as f64;
        let share = 0.02 + 0.96 * normal((x - pse) / sigma);
        let stiffer = 20.0 * share + 0.5 + 2.0 * scattered([p, 10 + m, l, 0]);
        (x, 20, stiffer.floor().clamp(0.0, 20.0) as usize)
    };
    (0..7).map(of_level).collect()
}

/// Seven stiffnesses, which of two was stiffer than 300 N/m.
fn stiffer() -> Task {
    let levels = (0..7).map(|l| level(210.0 + 30.0 * f64::from(l))).collect();
    let method = Method::Constant { levels, trials: 20 };
    task(Asks::MoreOfTwo, "stiffness_n_per_m", 300.0, method)
}

fn eight_people() -> Found {
    let mut all = Vec::new();
    for person in 1..=8 {
        for in_mode in 0..2 {
            all.extend(answers(person, in_mode, &counts(person, in_mode)));
        }
    }
    thresholds(&all, &parameters(stiffer()))
}

fn near(found: f64, expected: f64, share: f64) {
    assert!((found - expected).abs() <= share * expected.abs(), "{found} instead of {expected}");
}

/// What the stage `compare` finds of the values of a metric of two modes, by the same test.
fn compared(found: &Found, quantity: TaskQuantity) -> (Vec<Mean>, ModeDifference) {
    let (keys, all) = values(&found.fits, &"stiffer".parse().unwrap(), quantity);
    let in_mode = |wanted: u64| -> Vec<f64> {
        let own = keys.iter().zip(&all).filter(|(key, _)| key.mode == mode(wanted));
        own.filter_map(|(_, value)| *value).collect()
    };
    let both = [in_mode(0), in_mode(1)];
    let metric = stiffer().metric(quantity).unwrap();
    let unit = stiffer().metric_unit(quantity);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means = [0, 1].map(|place| Mean {
        metric: metric.clone(),
        unit: unit.as_str().into(),
        environment: "spring".parse().unwrap(),
        mode: mode(place),
        unit_of_analysis: UnitOfAnalysis::Participants,
        n: both[place as usize].len(),
        trials: 8,
        trials_with_value: 8,
        mean: mean(&both[place as usize]),
        sd: None,
        ci_low: None,
        ci_high: None,
    });
    let pairs: Vec<[f64; 2]> = both[1].iter().zip(&both[0]).map(|(b, a)| [*b, *a]).collect();
    let tested = paired::mean_difference(&paired::differences(&pairs), 0.95).unwrap();
    let difference = ModeDifference {
        metric,
        unit: unit.as_str().into(),
        environment: "spring".parse().unwrap(),
        contrast: "hybrid − active".parse::<Contrast>().unwrap(),
        unit_of_analysis: UnitOfAnalysis::Participants,
        n: pairs.len(),
        sessions: Some(1),
        mean_first: mean(&both[1]),
        mean_second: mean(&both[0]),
        difference: tested.estimate,
        difference_std_error: Some(tested.std_error),
        difference_ci_low: Some(tested.ci_low),
        difference_ci_high: Some(tested.ci_high),
        statistic: Some(tested.statistic),
        df: Some(tested.df),
        p_value: Some(tested.p_value),
        p_adjusted: Some(tested.p_value),
        smallest_p_adjusted: None,
        g_av: None,
        d_av: None,
        d_av_ci_low: None,
        d_av_ci_high: None,
        g_z: None,
        d_z: None,
        d_z_ci_low: None,
        d_z_ci_high: None,
        p_sign_flip: None,
        p_signed_rank: None,
        p_sharp_null: None,
        commanded: None,
        jnd: None,
        difference_jnd: None,
        difference_jnd_ci_low: None,
        difference_jnd_ci_high: None,
        size: None,
        bound: None,
        p_not_equivalent: None,
        verdict: Verdict::Different,
        remark: None,
    };
    (means.to_vec(), difference)
}

fn of_people(found: &Found, quantity: TaskQuantity) -> Vec<PeopleThreshold> {
    let (means, difference) = compared(found, quantity);
    let found_by = Means { asked: &[], means: &means, contrasts: &[difference] };
    let mut rows = over_people(&[stiffer()], &found.fits, found_by, 0.95);
    rows.retain(|row| row.quantity == quantity);
    rows
}

/// Python and R: fits of every person in every mode by maximum likelihood, λ from 0 to 0.06.
#[test]
fn people_have_the_curves_of_others() {
    let found = eight_people();
    assert_eq!((found.fits.len(), found.by_level.len()), (16, 112));
    assert_eq!((found.presentations.len(), found.curves.len()), (16 * 140, 16 * 81));
    assert!(found.curves.windows(2).all(|two| {
        two[0].participant != two[1].participant
            || two[0].mode != two[1].mode
            || two[0].share < two[1].share
    }));
    let row = |who: &str, in_mode: u64| -> &PsychometricFit {
        let mut all = found.fits.iter();
        all.find(|fit| fit.participant.as_str() == who && fit.mode == mode(in_mode)).unwrap()
    };
    for (who, in_mode, pse, pse_ci, jnd, jnd_ci, lapse, deviance) in [
        ("P01", 0, 285.354, [273.505, 296.869], 27.262, [18.717, 36.571], 0.0, 1.93391),
        ("P01", 1, 290.047, [274.598, 305.256], 37.552, [21.209, 54.880], 0.0159, 0.14133),
        ("P02", 0, 303.420, [285.444, 321.711], 39.762, [26.894, 70.029], 0.06, 0.47570),
        ("P05", 0, 291.487, [280.454, 302.614], 17.302, [9.632, 29.950], 0.0455, 0.19218),
        ("P08", 1, 306.526, [293.579, 319.614], 32.818, [19.936, 44.096], 0.0, 1.14424),
    ] {
        let fit = row(who, in_mode);
        assert_eq!(fit.verdict, FitVerdict::Estimated);
        near(fit.threshold.unwrap(), pse, 1e-5);
        near(fit.threshold_ci_low.unwrap(), pse_ci[0], 1e-5);
        near(fit.threshold_ci_high.unwrap(), pse_ci[1], 1e-5);
        near(fit.jnd.unwrap(), jnd, 1e-4);
        near(fit.jnd_ci_low.unwrap(), jnd_ci[0], 1e-4);
        near(fit.jnd_ci_high.unwrap(), jnd_ci[1], 1e-4);
        assert!((fit.lapse.unwrap() - lapse).abs() < 1e-4);
        near(fit.deviance.unwrap(), deviance, 1e-4);
        near(fit.weber_fraction.unwrap(), jnd / 300.0, 1e-4);
        let p = fit.deviance_p_value.unwrap();
        assert!(p > 0.05 && p <= 1.0, "{p}");
    }
}

/// Python and R: paired t of the PSE and of ln JND, shown as a ratio; Python: Paule–Mandel with Hartung–Knapp.
#[test]
fn over_people_jnds_are_compared_as_ratios_and_weighed_beside() {
    let found = eight_people();
    let jnds = of_people(&found, TaskQuantity::Jnd);
    let [active, hybrid, ratio] = &jnds[..] else { panic!("{jnds:?}") };
    near(active.weber_fraction.unwrap(), 0.0901216351, 1e-5);
    near(hybrid.weber_fraction.unwrap(), 0.125999272, 1e-5);
    near(ratio.estimate, 1.39810238, 1e-5);
    near(ratio.ci_low.unwrap(), 1.24289606, 1e-5);
    near(ratio.ci_high.unwrap(), 1.57269005, 1e-5);
    near(ratio.statistic.unwrap(), 6.73418676, 1e-4);
    near(ratio.p_value.unwrap(), 2.68872414e-4, 1e-3);
    assert_eq!((ratio.n, ratio.df, &*ratio.unit), (8, Some(7.0), "1"));
    let pses = of_people(&found, TaskQuantity::Pse);
    let difference = &pses[2];
    near(difference.estimate, 11.1253307, 1e-5);
    near(difference.statistic.unwrap(), 3.39392973, 1e-5);
    near(difference.ci_low.unwrap(), 3.37406989, 1e-5);
    near(difference.ci_high.unwrap(), 18.8765915, 1e-5);
    near(difference.weighted.unwrap(), 11.620334, 1e-4);
    near(difference.weighted_p_value.unwrap(), 0.0075530821, 1e-3);
    assert_eq!((difference.between_sd, difference.weighted_n), (Some(0.0), 8));
    assert_eq!((&*difference.unit, difference.weber_fraction), ("N/m", None));
}

#[test]
fn one_person_is_described_without_a_test() {
    let both = [0, 1].map(|in_mode| answers(1, in_mode, &counts(1, in_mode))).concat();
    let found = thresholds(&both, &parameters(stiffer()));
    let asked = ["hybrid − active".parse().unwrap()];
    let nothing = Means { asked: &asked, means: &[], contrasts: &[] };
    let rows = over_people(&[stiffer()], &found.fits, nothing, 0.95);
    assert_eq!(rows.len(), 2 * 3);
    let ratio = rows.iter().find(|row| &*row.unit == "1").unwrap();
    near(ratio.estimate, 37.552 / 27.262, 1e-4);
    assert!(rows.iter().all(|row| row.n == 1 && row.p_value.is_none() && row.ci_low.is_none()));
}

/// The geometric mean over people of their geometric means over modes, of which Python has each.
#[test]
fn what_people_notice_is_a_share_of_the_standard_over_people_and_modes() {
    let found = eight_people();
    let [own] = &measured(&[stiffer()], &found.fits, 0.95)[..] else { panic!("one task") };
    near(own.jnd, (0.0901216351_f64 * 0.125999272).sqrt(), 1e-5);
    assert_eq!((own.unit.as_str(), own.n), ("N/rad", 8));
    let [low, high] = own.ends.unwrap();
    assert!(low < own.jnd && own.jnd < high, "{own:?}");
    assert!(measured(&[stiffer()], &[], 0.95).is_empty());
}

/// Counts of right answers of 40 at seven forces, and what a Weibull function makes of them.
#[test]
fn a_detection_task_has_a_threshold_of_its_right_answers() {
    let right = |l: u64, x: f64| {
        let share = 0.5 + 0.48 * (1.0 - libm::exp(-(x / 0.08).powi(2)));
        (40.0 * share + 0.5 + 3.0 * scattered([77, l, 0, 0])).floor().clamp(0.0, 40.0) as usize
    };
    let forces = [0.02, 0.04, 0.06, 0.08, 0.12, 0.16, 0.24];
    let counts: Vec<(f64, usize, usize)> =
        (0..7).zip(forces).map(|(l, x)| (x, 40, right(l, x))).collect();
    let positive: Vec<usize> = counts.iter().map(|(_, _, positive)| *positive).collect();
    assert_eq!(positive, [21, 23, 28, 31, 37, 39, 38]);
    let levels = forces.iter().map(|force| level(*force)).collect();
    let mut task = task(Asks::OneOfTwo, "force_n", 0.0, Method::Constant { levels, trials: 40 });
    task.fit.sigmoid = TaskSigmoid::Weibull;
    let found = thresholds(&answers(1, 0, &counts), &parameters(task));
    let fit = &found.fits[0];
    assert_eq!((fit.verdict, fit.quantity), (FitVerdict::Estimated, TaskQuantity::Threshold));
    // F = ½ of the curve that made the counts: 0.08 √ln 2.
    near(fit.threshold.unwrap(), 0.08 * core::f64::consts::LN_2.sqrt(), 0.2);
    assert_eq!((fit.weber_fraction, fit.guess), (None, Some(0.5)));
}

#[test]
fn who_has_no_threshold_is_named_and_does_not_go_on() {
    let flat = [(210.0, 20, 9), (270.0, 20, 11), (330.0, 20, 10), (390.0, 20, 10)];
    let above = [(210.0, 20, 0), (270.0, 20, 0), (330.0, 20, 1), (390.0, 20, 4)];
    let falling = [(210.0, 20, 19), (270.0, 20, 15), (330.0, 20, 5), (390.0, 20, 1)];
    let steep = [(210.0, 20, 0), (270.0, 20, 0), (330.0, 20, 20), (390.0, 20, 20)];
    let few = [(210.0, 5, 0), (270.0, 5, 3), (330.0, 5, 5)];
    let all: Vec<Answered> = [&flat[..], &above, &falling, &steep, &few]
        .into_iter()
        .zip(1..)
        .flat_map(|(counts, person)| answers(person, 0, counts))
        .collect();
    let found = thresholds(&all, &parameters(stiffer()));
    let verdicts: Vec<FitVerdict> = found.fits.iter().map(|fit| fit.verdict).collect();
    use FitVerdict::{Above, Falling, Flat, Steep, TooFew};
    assert_eq!(verdicts, [Flat, Above, Falling, Steep, TooFew]);
    let (_, of_pse) = values(&found.fits, &"stiffer".parse().unwrap(), TaskQuantity::Pse);
    assert_eq!(of_pse, [None; 5]);
    let told = notes(&[stiffer()], &found.fits);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("P02 S01 in active (outside: above 390 N/m)"), "{told:?}");
    assert!(told[0].contains("P05 S01 in active (too few)"), "{told:?}");
}

#[test]
fn psignifits_posterior_stands_beside_where_a_task_asks_for_it() {
    let asked = Task { estimate: TaskEstimate::Grid, ..stiffer() };
    let own = answers(1, 0, &counts(1, 0));
    let [beside, alone] =
        [asked, stiffer()].map(|task| thresholds(&own, &parameters(task)).fits[0].clone());
    assert_eq!((alone.grid_threshold, alone.grid_jnd_ci_low), (None, None));
    // Few answers leave the priors some weight: nearer to each other than their standard errors.
    let off = (beside.grid_threshold.unwrap() - beside.threshold.unwrap()).abs();
    assert!(off < beside.threshold_std_error.unwrap(), "{beside:?}");
    let ends = [beside.grid_jnd_ci_low, beside.grid_jnd, beside.grid_jnd_ci_high];
    assert!(ends.is_sorted() && ends[0] > Some(0.0), "{beside:?}");
    let ends = [beside.grid_threshold_ci_low, beside.grid_threshold, beside.grid_threshold_ci_high];
    assert!(ends.is_sorted() && ends[0] < ends[2], "{beside:?}");
    assert_eq!((beside.threshold, beside.jnd), (alone.threshold, alone.jnd));
}

/// One up, one down, in steps of 1 from 5: answers say yes from 4 on.
#[test]
fn staircases_turn_at_the_threshold_and_have_no_jnd() {
    let plan = StaircasePlan {
        up_after: 1,
        down_after: 1,
        starts: vec![level(5.0)],
        up: 1.0,
        down: 1.0,
        is_factor: false,
        bounds: [level(1.0), level(8.0)],
        reversals: 6,
        of_last: 4,
        most_trials: 40,
    };
    let task = task(Asks::MoreLess, "force_n", 4.0, Method::Staircase(plan));
    // Three that take turns, of one whose threshold lies at 3.5 twice and then at 4.5: SciPy's `t.interval(0.95, 2, …)`.
    let mut three = Vec::new();
    for (track, limit) in [3.5, 3.5, 4.5].into_iter().enumerate() {
        let mut at = 5.0;
        while three.iter().filter(|own: &&Answered| usize::from(own.track) == track).count()
            < 8 - track / 2
        {
            let response = if at > limit { Response::Positive } else { Response::Negative };
            let number = three.len() as u32 + 1;
            three.push(Answered { track: track as u8, ..answer(1, 0, number, at, response) });
            at += if at > limit { -1.0 } else { 1.0 };
        }
    }
    let of_three = &thresholds(&three, &parameters(task.clone())).fits[0];
    near(of_three.threshold.unwrap(), 3.833_333_333_333_333, 1e-12);
    near(of_three.threshold_std_error.unwrap(), 0.333_333_333_333_333, 1e-12);
    near(of_three.threshold_ci_low.unwrap(), 2.399_115_756_750_18, 1e-9);
    near(of_three.threshold_ci_high.unwrap(), 5.267_550_909_916_487, 1e-9);
    let alike = |track| {
        three.iter().filter(|own| own.track == 0).map(move |own| Answered { track, ..own.clone() })
    };
    let alike: Vec<Answered> = (0..3).flat_map(alike).collect();
    let of_alike = &thresholds(&alike, &parameters(task.clone())).fits[0];
    assert_eq!((of_alike.threshold, of_alike.threshold_ci_low), (Some(3.5), None));
    let mut at = 5.0;
    let mut all = Vec::new();
    for number in 1..=8 {
        let response = if at > 3.5 { Response::Positive } else { Response::Negative };
        all.push(answer(1, 0, number, at, response));
        at += if at > 3.5 { -1.0 } else { 1.0 };
    }
    let found = thresholds(&all, &parameters(task.clone()));
    let fit = &found.fits[0];
    let levels: Vec<f64> = found.presentations.iter().map(|row| row.level).collect();
    assert_eq!(levels, [5.0, 4.0, 3.0, 4.0, 3.0, 4.0, 3.0, 4.0]);
    assert_eq!((fit.verdict, fit.threshold), (FitVerdict::Estimated, Some(3.5)));
    assert_eq!((fit.quantity, fit.jnd, fit.turns), (TaskQuantity::Pse, None, Some(6)));
    assert_eq!((fit.threshold_ci_low, fit.threshold_std_error), (None, None));
    near(fit.target.unwrap(), 0.5, 1e-9);
    let turned: Vec<bool> = found.presentations.iter().map(|row| row.is_reversal).collect();
    assert_eq!(turned, [false, false, true, true, true, true, true, true]);
    // Cut off before its reversals it has no threshold, and says so.
    let short = &thresholds(&all[..5], &parameters(task.clone())).fits[0];
    assert_eq!((short.verdict, short.threshold), (FitVerdict::TooFew, None));
    assert_eq!(
        short.remark.as_ref().unwrap().to_string(),
        "1 of 1 staircases ended before 6 reversals"
    );
    // Of levels that a device gave instead, steps go on from what was presented.
    for own in &mut all {
        own.level = level(own.level.value() + 0.5);
        own.source = Source::Recorded;
    }
    let given = &thresholds(&all, &parameters(task.clone())).fits[0];
    assert_eq!((given.verdict, &given.remark), (FitVerdict::Estimated, &None));
    // Another program may follow another rule: that is told, and they turn where they turned.
    for own in &mut all {
        own.source = Source::Imported;
    }
    let other = &thresholds(&all, &parameters(task)).fits[0];
    assert_eq!((other.verdict, other.threshold), (FitVerdict::Estimated, Some(4.0)));
    assert!(other.remark.as_ref().unwrap().to_string().contains("not those that plan"));
}

#[test]
fn settings_have_their_mean_and_the_spread_of_the_probable_error() {
    let method = Method::Adjustment {
        starts: [level(200.0), level(400.0)],
        step: level(1.0),
        bounds: [level(100.0), level(500.0)],
        settings: 6,
        most_trials: 40,
    };
    let task = task(Asks::Set, "stiffness_n_per_m", 300.0, method);
    let mut all = Vec::new();
    for (number, at) in [305.0, 290.0, 310.0, 298.0, 301.0, 294.0].into_iter().enumerate() {
        let number = 2 * number as u32 + 1;
        all.push(answer(1, 0, number, at - 1.0, Response::Negative));
        all.push(answer(1, 0, number + 1, at, Response::Set));
    }
    let found = thresholds(&all, &parameters(task.clone()));
    let fit = &found.fits[0];
    assert!(found.by_level.is_empty());
    // SciPy, as in the tests of `zwidth_stats`.
    near(fit.threshold.unwrap(), 299.666_666_666_666_7, 1e-9);
    near(fit.jnd.unwrap(), 4.913_446_806_490_53, 1e-9);
    near(fit.jnd_ci_low.unwrap(), 3.067_012_815_285_231_4, 1e-9);
    near(fit.jnd_ci_high.unwrap(), 12.050_788_369_586_632, 1e-9);
    assert_eq!((fit.turns, fit.quantity), (Some(6), TaskQuantity::Pse));
    let alike: Vec<Answered> = (1..=3).map(|n| answer(1, 0, n, 300.0, Response::Set)).collect();
    let fit = &thresholds(&alike, &parameters(task)).fits[0];
    assert_eq!((fit.verdict, fit.threshold, fit.jnd), (FitVerdict::Estimated, Some(300.0), None));
    assert_eq!((fit.jnd_ci_low, fit.ln_jnd_std_error), (None, None));
}

#[test]
fn quest_plus_gives_its_posterior_means_and_says_where_its_grid_ends() {
    let levels: Vec<TaskLevel> = (0..13).map(|l| level(210.0 + 15.0 * f64::from(l))).collect();
    let method = Method::QuestPlus {
        levels,
        trials: 60,
        pse: [210.0, 390.0, 5.0],
        sigma: [10.0, 90.0, 5.0],
        lapse: [0.0, 0.04, 0.02],
    };
    let task = task(Asks::MoreOfTwo, "stiffness_n_per_m", 300.0, method);
    let counts = [(270.0, 20, 4), (300.0, 20, 10), (330.0, 20, 16)];
    let fit = &thresholds(&answers(1, 0, &counts), &parameters(task.clone())).fits[0];
    assert_eq!((fit.verdict, fit.is_at_bound), (FitVerdict::Estimated, false));
    // The answers are symmetrical about 300.
    near(fit.threshold.unwrap(), 300.0, 1e-3);
    near(fit.jnd.unwrap(), 0.6745 * fit.sigma.unwrap(), 1e-4);
    assert!(fit.threshold_std_error.unwrap() > 2.0 && fit.ln_jnd_std_error.unwrap() > 0.05);
    // So is the interval, and of a posterior near a normal one it ends about 1.96 deviations off.
    let half = fit.threshold_ci_high.unwrap() - 300.0;
    near(300.0 - fit.threshold_ci_low.unwrap(), half, 1e-3);
    near(half, 1.96 * fit.threshold_std_error.unwrap(), 0.1);
    assert!(fit.jnd_ci_low < fit.jnd && fit.jnd < fit.jnd_ci_high && fit.remark.is_none());
    let many: Vec<_> = counts.iter().map(|(at, n, more)| (*at, 100 * n, 100 * more)).collect();
    let fit = &thresholds(&answers(1, 0, &many), &parameters(task.clone())).fits[0];
    assert!(fit.remark.as_ref().unwrap().to_string().contains("narrower than a step"));
    let low = [(210.0, 20, 14), (225.0, 20, 18), (240.0, 20, 19)];
    let fit = &thresholds(&answers(1, 0, &low), &parameters(task)).fits[0];
    assert!(fit.is_at_bound && fit.remark.is_some());
}
