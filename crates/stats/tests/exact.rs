//! The same numbers by SciPy, statsmodels, pingouin, spm1d and psignifit, on random data with ties, zeros and
//! constants.
//!
//! `ZWIDTH_PYTHON=… cargo test -p zwidth-stats --test exact -- --ignored`, with the Python that has
//! what `tests/interop/requirements.txt` lists. `ZWIDTH_EXACT_CASES` sets how many data sets are
//! drawn at least (one round of 191), `ZWIDTH_EXACT_SEED` the seed they are drawn from.

// Helpers of tests stand outside of `#[test]` functions, where clippy.toml's exemption does not
// reach.
#![allow(clippy::unwrap_used, clippy::panic)]
#![allow(clippy::print_stdout, reason = "a test says what it counted")]

mod shared;

use serde_json::Value;
use shared::{note, setting};
use std::process::Command;
use zwidth_stats::agreement::agreement;
use zwidth_stats::heterogeneity::two_level;
use zwidth_stats::null::Sampling;
use zwidth_stats::psychometric::fit::{LAPSE, Model, Side, Verdict, fit};
use zwidth_stats::psychometric::grid::{Grid, posterior};
use zwidth_stats::psychometric::{Asks, LevelAnswers, Sigmoid};
use zwidth_stats::rm_anova::rm_anova;
use zwidth_stats::sharp_null::{Statistic, Trials};
use zwidth_stats::{
    bca, curve, effect, friedman, holm, paired, repeated_correlation, sign_flip, signed_rank,
};

const SAMPLING: Sampling = Sampling { draws: 999, seed: 1 };
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/stats/exact.py");

#[test]
#[ignore = "needs Python with SciPy, statsmodels, pingouin, spm1d, psignifit"]
fn every_number_is_that_of_scipy_statsmodels_pingouin_spm1d_and_psignifit() {
    let python = setting("ZWIDTH_PYTHON", "python3");
    let sets: usize = setting("ZWIDTH_EXACT_CASES", "1").parse().unwrap();
    let (rounds, seed) = (sets.div_ceil(ROUND), setting("ZWIDTH_EXACT_SEED", "20240601"));
    let output = Command::new(&python).arg(SCRIPT).args([&rounds.to_string(), &seed]).output();
    let output = output.unwrap_or_else(|why| {
        panic!("{python}, named by ZWIDTH_PYTHON: {why}: install Python with {PACKAGES}")
    });
    let why = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{python} needs {PACKAGES}: {why}");
    let cases: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut checked = 0;
    for (name, of_a_round, check) in KINDS {
        let cases = cases[name].as_array().unwrap();
        // What has all values equal, or is degenerate for SciPy, is left out there: one in a
        // hundred.
        let (most, least) = (rounds * of_a_round, (rounds * of_a_round * 9).div_ceil(10));
        assert!((least..=most).contains(&cases.len()), "{} cases of {name}", cases.len());
        cases.iter().for_each(check);
        checked += cases.len();
    }
    let words = format!(
        "SciPy, statsmodels, pingouin, spm1d and psignifit: {checked} data sets for the exact tests, Holm's p values, \
         the paired t, equivalence, orders, BCa intervals, repeated measures, agreement, whole curves, correlations, \
         psychometric functions, their posteriors and weighted means."
    );
    println!("{words}");
    note("r-3", &words);
}

const PACKAGES: &str = "what tests/interop/requirements.txt lists";

/// What checks a case of a kind.
type Check = fn(&Value);

/// The kinds of cases, and how many of each a round has.
const KINDS: [(&str, usize, Check); 14] = [
    ("differences", 61, differences),
    ("paired", 10, paired_t),
    ("friedman", 24, friedmans),
    ("holm", 10, holms),
    ("orders", 8, orders),
    ("bca", 9, bcas),
    ("repeated", 12, repeated),
    ("curves", 5, curves),
    ("correlations", 5, correlations),
    ("psychometric", 3, psychometric_fits),
    ("plans", 27, plans),
    ("without_lapses", 6, without_lapses),
    ("posteriors", 5, posteriors),
    ("weighted", 6, weighted),
];
/// Cases of a round.
const ROUND: usize = 191;

fn differences(case: &Value) {
    let d = numbers(&case["d"]);
    match &case["signed_rank"] {
        Value::Null => assert!(signed_rank::test(&d).is_err(), "{d:?}"),
        expected => {
            let found = signed_rank::test(&d).unwrap();
            near(found.p_value, &expected["p"], 1e-9, case);
            near(found.statistic, &expected["statistic"], 1e-12, case);
            near(found.rank_biserial, &expected["rank_biserial"], 1e-12, case);
        }
    }
    match &case["sign_flip"] {
        Value::Null if d.len() < 13 => assert!(sign_flip::test(&d, SAMPLING).is_err(), "{d:?}"),
        Value::Null => {}
        p => near(sign_flip::test(&d, SAMPLING).unwrap().p_value, p, 1e-12, case),
    }
}

fn paired_t(case: &Value) {
    let (a, b) = (numbers(&case["a"]), numbers(&case["b"]));
    let pairs: Vec<[f64; 2]> = a.iter().zip(&b).map(|(a, b)| [*a, *b]).collect();
    let found = paired::mean_difference(&paired::differences(&pairs), 0.95).unwrap();
    near(found.statistic, &case["t"], 1e-9, case);
    near(found.p_value, &case["p"], 1e-8, case);
    near(found.ci_low, &case["ci"][0], 1e-6, case);
    near(found.ci_high, &case["ci"][1], 1e-6, case);
    let (d_z, d_av) = (effect::d_z(&pairs, 0.95).unwrap(), effect::d_av(&pairs, 0.95).unwrap());
    near(d_av.d, &case["d_av"]["d"], 1e-12, case);
    for (effect, expected) in [(d_z, &case["d_z"]), (d_av, &case["d_av"])] {
        let interval = effect.interval.unwrap();
        near(interval[0], &expected["ci"][0], 1e-6, case);
        near(interval[1], &expected["ci"][1], 1e-6, case);
        if let Some(g) = effect.g {
            near(g, &expected["g"], 1e-9, case);
        }
    }
    let (bound, expected) = (case["bound"].as_f64().unwrap(), &case["tost"]);
    let tost = paired::equivalence(&found, bound, 0.05).unwrap();
    near(tost.p_lower, &expected["lower"], 1e-8, case);
    near(tost.p_upper, &expected["upper"], 1e-8, case);
    near(tost.p_value(), &expected["p"], 1e-8, case);
    near(tost.ci_low, &expected["ci"][0], 1e-6, case);
    near(tost.ci_high, &expected["ci"][1], 1e-6, case);
}

fn friedmans(case: &Value) {
    let rows: Vec<Vec<f64>> = case["rows"].as_array().unwrap().iter().map(numbers).collect();
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let found = friedman::test(&rows, SAMPLING);
    if case["p"].is_null() {
        assert!(found.is_err(), "{case}");
        return;
    }
    let found = found.unwrap();
    near(found.p_value, &case["p"], 1e-12, case);
    near(found.statistic, &case["statistic"], 1e-12, case);
    near(found.concordance, &case["concordance"], 1e-12, case);
}

fn holms(case: &Value) {
    let found = holm::adjusted(&numbers(&case["p"])).unwrap();
    for (found, expected) in found.iter().zip(case["adjusted"].as_array().unwrap()) {
        near(*found, expected, 1e-12, case);
    }
}

fn orders(case: &Value) {
    let (values, modes) = (numbers(&case["values"]), whole(&case["modes"]));
    let orders: Vec<Vec<usize>> = case["orders"].as_array().unwrap().iter().map(whole).collect();
    let kinds = 1 + modes.iter().max().unwrap();
    let trials = Trials::new(&values, &vec![0; values.len()], &modes, kinds).unwrap();
    let found = trials.against_all(Statistic::BetweenModes, &orders).unwrap();
    near(found.p_value, &case["p"], 1e-12, case);
    // A sum of squares between modes: where their means are equal, rounding of the whole is left.
    let whole: f64 = values.iter().map(|value| value * value).sum();
    let (expected, rounding) = (case["statistic"].as_f64().unwrap(), 1e-13 * whole);
    assert!((found.statistic - expected).abs() <= rounding, "{}: {case}", found.statistic);
}

fn bcas(case: &Value) {
    let (resampled, jackknife) = (numbers(&case["resampled"]), numbers(&case["jackknife"]));
    let estimate = case["estimate"].as_f64().unwrap();
    let found = bca::of_resamples(estimate, &resampled, &jackknife, 0.95).unwrap();
    assert!(matches!(found.kind, bca::Kind::Corrected { .. }), "{case}");
    // Levels are rounded to 9 digits, and an end lies between two of 999 resamples: it may move by
    // 1e-6 of their distance, which is a small part of the spread.
    let spread = resampled.iter().fold(f64::MIN, |most, value| most.max(*value))
        - resampled.iter().fold(f64::MAX, |least, value| least.min(*value));
    for (found, expected) in [found.ci_low, found.ci_high].into_iter().zip(numbers(&case["ci"])) {
        assert!((found - expected).abs() <= 1e-7 * spread, "{found} {expected}: {case}");
    }
}

fn repeated(case: &Value) {
    let rows: Vec<Vec<f64>> = case["rows"].as_array().unwrap().iter().map(numbers).collect();
    let found = agreement(&rows, 0.95).unwrap();
    let icc = case["icc"].as_array().unwrap();
    for (found, expected) in [found.a1, found.c1, found.ak, found.ck].iter().zip(icc) {
        near(found.estimate, &expected[0], 1e-9, case);
        // pingouin gives two digits of the ends.
        for (end, expected) in [(found.ci_low, &expected[1]), (found.ci_high, &expected[2])] {
            assert!((end - expected.as_f64().unwrap()).abs() < 0.005_001, "{end}: {case}");
        }
    }
    let (found, anova) = (rm_anova(&rows).unwrap(), &case["anova"]);
    near(found.test.statistic, &anova["F"], 1e-9, case);
    near(found.test.df_num, &anova["df"][0], 1e-15, case);
    near(found.test.df_den, &anova["df"][1], 1e-15, case);
    near(found.test.p_value, &anova["p"], 1e-8, case);
    near(found.p_greenhouse_geisser, &case["p_gg"], 1e-8, case);
    near(found.greenhouse_geisser, &case["gg"], 1e-9, case);
    near(found.huynh_feldt, &case["hf"], 1e-9, case);
    let slices: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let ranked = friedman::test(&slices, SAMPLING).unwrap();
    near(ranked.concordance, &case["concordance"], 1e-12, case);
    let pairs: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    near(effect::d_av(&pairs, 0.95).unwrap().d, &case["d_av"], 1e-12, case);
}

fn curves(case: &Value) {
    let rows: Vec<Vec<f64>> = case["d"].as_array().unwrap().iter().map(numbers).collect();
    let nodes = rows[0].len();
    let found = curve::differences(&rows, &[nodes], 0.95, SAMPLING).unwrap();
    for (node, (t, low)) in
        found.nodes.iter().zip(numbers(&case["t"]).iter().zip(numbers(&case["low"])))
    {
        near(node.statistic.unwrap(), &Value::from(*t), 1e-7, case);
        assert!((node.ends.unwrap()[0] - low).abs() < 1e-9 * (1.0 + low.abs()), "{low}");
    }
    near(found.flipped.p_value, &case["p"], 1e-12, case);
    near(found.critical, &case["critical"], 1e-9, case);
    near(found.band.unwrap(), &case["band"], 1e-9, case);
    near(found.p_unstudentised, &case["mean"], 1e-12, case);
    near(found.skewness, &case["skewness"], 1e-9, case);
    let expected = case["runs"].as_array().unwrap();
    assert_eq!(found.runs.len(), expected.len(), "{case}");
    for (run, expected) in found.runs.iter().zip(expected) {
        assert_eq!(Value::from(run.first), expected[0]);
        assert_eq!(Value::from(run.last), expected[1]);
        near(run.mass, &expected[2], 1e-9, case);
        near(run.p_value, &expected[3], 1e-12, case);
    }
    // The published example.
    if (rows.len(), nodes) == (10, 101) {
        assert_eq!((found.largest, found.runs.len()), (100, 2));
        near(found.critical, &Value::from(3.60834342), 1e-8, case);
        near(found.band.unwrap(), &Value::from(3.54480710), 1e-8, case);
    }
    let (a, b) = rows.split_at(rows.len() / 2);
    let blocks = [&vec![0; a.len()][..], &vec![0; b.len()][..]];
    let groups = curve::groups([a, b], blocks, &[nodes], 0.95, SAMPLING).unwrap();
    near(groups.permuted.p_value, &case["groups"], 1e-9, case);
}

fn correlations(case: &Value) {
    let [x, y]: [Vec<Vec<f64>>; 2] =
        ["x", "y"].map(|name| case[name].as_array().unwrap().iter().map(numbers).collect());
    let pairs = |(x, y): (&Vec<f64>, &Vec<f64>)| x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
    let people: Vec<Vec<[f64; 2]>> = x.iter().zip(&y).map(pairs).collect();
    let found = repeated_correlation::within_people(&people, 0.95).unwrap();
    near(found.r, &case["r"], 1e-9, case);
    near(found.df, &case["df"], 1e-12, case);
    near(found.p_value, &case["p"], 1e-7, case);
    // pingouin gives two digits of the ends.
    for (end, expected) in found.ends.iter().zip(numbers(&case["ci"])) {
        assert!((end - expected).abs() < 0.005_001, "{end} {expected}: {case}");
    }
}

/// The answers of a case: its levels, trials and positive answers.
fn answers(case: &Value) -> Vec<LevelAnswers> {
    let (trials, positive) = (whole(&case["n"]), whole(&case["k"]));
    let counts = trials.into_iter().zip(positive);
    numbers(&case["x"])
        .into_iter()
        .zip(counts)
        .map(|(level, (trials, positive))| LevelAnswers {
            level,
            trials: trials as u64,
            positive: positive as u64,
        })
        .collect()
}

fn sigmoid(case: &Value) -> Sigmoid {
    match case["sigmoid"].as_str().unwrap() {
        "norm" => Sigmoid::Norm,
        "logistic" => Sigmoid::Logistic,
        _ => Sigmoid::Weibull,
    }
}

fn asks(case: &Value) -> Asks {
    match case["asks"].as_str().unwrap() {
        "more" => Asks::WhichWasMore,
        "right" => Asks::RightOrWrong,
        _ => Asks::YesNo,
    }
}

fn psychometric_fits(case: &Value) {
    let is_constant = case["is_constant"].as_bool().unwrap();
    let model = Model { asks: asks(case), sigmoid: sigmoid(case), lapse: LAPSE, is_constant };
    let found = fit(&answers(case), &model, 0.95).unwrap();
    assert_eq!(found.verdict, Verdict::Estimated, "{case}");
    let fitted = found.fitted.unwrap();
    near(fitted.log_likelihood, &case["log_likelihood"], 1e-8, case);
    // A simplex ends where the likelihood is flat to half the digits.
    near(fitted.threshold.estimate, &case["threshold"], 1e-5, case);
    near(fitted.jnd.estimate, &case["jnd"], 1e-4, case);
    for (found, expected) in
        [(fitted.curve.guess, &case["guess"]), (fitted.curve.lapse, &case["lapse"])]
    {
        assert!((found - expected.as_f64().unwrap()).abs() < 1e-5, "{found}: {case}");
    }
    near(fitted.dispersion, &case["dispersion"], 1e-4, case);
    for (found, expected) in [
        (fitted.threshold.ci_low, &case["threshold_low"]),
        (fitted.threshold.ci_high, &case["threshold_high"]),
        (fitted.jnd.ci_low, &case["jnd_low"]),
        (fitted.jnd.ci_high, &case["jnd_high"]),
    ] {
        // What lies beyond where the other search ends is not compared.
        if !expected.is_null() {
            let found = found.unwrap_or_else(|| panic!("no end at {expected}: {case}"));
            near(found, expected, 1e-5, case);
        }
    }
}

/// Plans with few levels or answers, thresholds beyond the levels, curves that fall.
fn plans(case: &Value) {
    let lapse = [0.0, case["most_lapses"].as_f64().unwrap()];
    let model = Model { asks: asks(case), sigmoid: sigmoid(case), lapse, is_constant: true };
    let answers = answers(case);
    let found = fit(&answers, &model, 0.95).unwrap();
    let word = match found.verdict {
        Verdict::Estimated => "estimated",
        Verdict::Outside(Side::Below) => "below",
        Verdict::Outside(Side::Above) => "above",
        Verdict::Steep => "steep",
        Verdict::Falling => "falling",
        Verdict::Flat => "flat",
        Verdict::TooFew => "too few",
    };
    // No verdict stands where rounding decides about it.
    if let Some(expected) = case["verdict"].as_str() {
        assert_eq!(word, expected, "{case}");
    }
    let Some(fitted) = found.fitted else { return };
    let of_level = |answer: &LevelAnswers| {
        let (share, k) = (fitted.curve.share(answer.level), answer.positive as f64);
        let no = answer.trials as f64 - k;
        let part = |count: f64, share: f64| if count > 0.0 { count * share.ln() } else { 0.0 };
        part(k, share) + part(no, 1.0 - share)
    };
    let own: f64 = answers.iter().map(of_level).sum();
    assert!((fitted.log_likelihood - own).abs() < 1e-9, "{own} {fitted:?}: {case}");
    let above = own - case["log_likelihood"].as_f64().unwrap();
    assert!(above > -1e-6, "{above}: {case}");
    if above.abs() < 1e-6 {
        let unit = fitted.jnd.estimate;
        for (found, expected) in
            [(fitted.threshold.estimate, &case["threshold"]), (unit, &case["jnd"])]
        {
            assert!((found - expected.as_f64().unwrap()).abs() < 1e-4 * unit, "{found}: {case}");
        }
        for (found, expected) in
            [(fitted.curve.guess, &case["guess"]), (fitted.curve.lapse, &case["lapse"])]
        {
            assert!((found - expected.as_f64().unwrap()).abs() < 1e-4, "{found}: {case}");
        }
    }
}

/// Curves without lapses are generalised linear models.
fn without_lapses(case: &Value) {
    let is_constant = case["is_constant"].as_bool().unwrap();
    let model = Model { asks: asks(case), sigmoid: sigmoid(case), lapse: [0.0; 2], is_constant };
    let found = fit(&answers(case), &model, 0.95).unwrap();
    let fitted = found.fitted.unwrap_or_else(|| panic!("{:?}: {case}", found.verdict));
    near(fitted.curve.location, &case["location"], 1e-6, case);
    near(fitted.curve.scale, &case["scale"], 1e-6, case);
    near(fitted.deviance, &case["deviance"], 1e-6, case);
    near(fitted.dispersion, &case["dispersion"], 1e-6, case);
    for (profiled, expected) in
        [(fitted.threshold, &case["threshold_ci"]), (fitted.jnd, &case["jnd_ci"])]
    {
        for (found, expected) in [profiled.ci_low, profiled.ci_high].into_iter().zip(list(expected))
        {
            // What lies beyond where the other search ends is not compared.
            if !expected.is_null() {
                near(found.unwrap(), expected, 1e-6, case);
            }
        }
    }
    // Wald's errors are those of a parabola, which the likelihood of 20,000 answers a level is.
    if case["many"].as_bool().unwrap() {
        near(fitted.threshold_error.unwrap(), &case["threshold_error"], 0.01, case);
        near(fitted.ln_jnd_error.unwrap(), &case["ln_jnd_error"], 0.01, case);
    }
}

fn posteriors(case: &Value) {
    let is_overdispersed = case["scatters"].as_bool().unwrap();
    let grid = Grid { asks: asks(case), sigmoid: sigmoid(case), is_overdispersed };
    let found = posterior(&answers(case), &grid, 0.95).unwrap();
    let (mode, mean) = (numbers(&case["mode"]), numbers(&case["mean"]));
    let within = |what: &str, found: f64, expected: f64, room: f64| {
        assert!((found - expected).abs() < room, "{what} {found} {expected}: {case}");
    };
    let spreads = [found.threshold, found.jnd].map(|marginal| marginal.ci_high - marginal.ci_low);
    // psignifit climbs to the mode until 1e-4 are left. Grids over η too are coarse, its and ours.
    let [of_mode, of_mean] = if is_overdispersed { [0.1, 0.03] } else { [0.005, 0.01] };
    let found_modes = [found.mode.threshold(), found.mode.jnd()];
    let found_means = [found.threshold.mean, found.jnd.mean];
    for i in 0..2 {
        within("mode", found_modes[i], mode[i], of_mode * spreads[i]);
        within("mean", found_means[i], mean[i], of_mean * spreads[i]);
    }
    within("mode", found.mode.lapse, mode[2], if is_overdispersed { 5e-3 } else { 5e-4 });
    within("mean", found.lapse.mean, mean[2], 2e-3);
    within("mean", found.overdispersion, case["eta"].as_f64().unwrap(), 0.01);
    // Its quantiles put all of a cell's mass below the middle of the cell, and so lie half a cell too low.
    let is_weibull = grid.sigmoid == Sigmoid::Weibull;
    let coordinate = |level: f64| if is_weibull { level.ln() } else { level };
    let [low, high] = [found.threshold.ci_low, found.threshold.ci_high].map(coordinate);
    let of_jnd = [found.jnd.ci_low, found.jnd.ci_high];
    for ([low, high], ends, cell) in [
        ([low, high], &case["threshold_ci"], &case["threshold_cell"]),
        (of_jnd, &case["jnd_ci"], &case["jnd_cell"]),
    ] {
        // Weibull's JND has none.
        let Some(cell) = cell.as_f64() else { continue };
        let room = if is_overdispersed { 0.08 * (high - low) } else { 0.2 * cell };
        for (end, expected) in [low, high].into_iter().zip(numbers(ends)) {
            within("half a cell below the end", end, expected + cell / 2.0, room);
        }
    }
}

fn weighted(case: &Value) {
    let found = two_level(&numbers(&case["y"]), &numbers(&case["v"]), 0.95).unwrap();
    let tau2 = case["tau2"].as_f64().unwrap();
    assert!((found.between - tau2).abs() < 1e-7 * (1.0 + tau2), "{}: {case}", found.between);
    near(found.mean.estimate, &case["mean"], 1e-7, case);
    near(found.mean.std_error, &case["se"], 1e-7, case);
}

/// Checks a number to a share of its size.
fn near(found: f64, expected: &Value, share: f64, case: &Value) {
    let expected = expected.as_f64().unwrap();
    assert!((found - expected).abs() <= share * expected.abs(), "{found} {expected}: {case}");
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn list(list: &Value) -> &[Value] {
    list.as_array().unwrap()
}

fn whole(list: &Value) -> Vec<usize> {
    list.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as usize).collect()
}
