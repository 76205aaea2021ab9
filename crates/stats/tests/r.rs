//! The same data in R: lme4, lmerTest and pbkrtest, and base R.
//! `cargo test -p zwidth-stats --test r -- --ignored` with `Rscript` in the path; without it these
//! tests fail. `ZWIDTH_R_CASES` sets how many data sets are drawn beside those of R's packages
//! (60), `ZWIDTH_R_SEED` the seed they are drawn from.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "what reads R's JSON is part of the test"
)]

mod shared;

use serde_json::Value;
use shared::{note, setting};
use std::path::Path;
use std::process::Command;
use zwidth_stats::effect::{Effect, d_av, d_z};
use zwidth_stats::groups::{self, any_difference, group};
use zwidth_stats::line::common_slope;
use zwidth_stats::lmm::trials::{Dosed, Trials, fit_doses, fit_trials};
use zwidth_stats::lmm::{Column, Criterion, Fit, Model, RandomTerm, fit};
use zwidth_stats::null::Sampling;
use zwidth_stats::paired::mean_difference;
use zwidth_stats::reliability::{alpha, omega};
use zwidth_stats::rm_anova::{self, RmAnova};
use zwidth_stats::{FTest, Tested, Unestimable, holm, hotelling};

/// What `tests/interop/stats/<script>` prints, as JSON.
fn r(script: &str, arguments: &[String]) -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop/stats");
    let ran = Command::new("Rscript").arg(folder.join(script)).args(arguments).output();
    let ran =
        ran.expect("Rscript is needed: install R with lme4, lmerTest, pbkrtest, nlme, jsonlite");
    let why = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "R needs lme4, lmerTest, pbkrtest, nlme, jsonlite: {why}");
    serde_json::from_slice(&ran.stdout).unwrap()
}

/// The number in a field; R's one-element vectors are numbers.
fn number(value: &Value, field: &str) -> f64 {
    let found = &value[field];
    found.as_f64().or_else(|| found[0].as_f64()).unwrap_or_else(|| panic!("{field} in {value}"))
}

fn truth(value: &Value, field: &str) -> bool {
    value[field].as_bool().or_else(|| value[field][0].as_bool()).unwrap()
}

fn text<'a>(value: &'a Value, field: &str) -> &'a str {
    value[field].as_str().or_else(|| value[field][0].as_str()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

fn whole(value: &Value) -> Vec<usize> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as usize).collect()
}

fn model(case: &Value) -> Model {
    let fixed = rows(&case["fixed"]).into_iter().enumerate();
    let random = case["random"].as_array().unwrap().iter();
    Model {
        response: numbers(&case["response"]),
        fixed: fixed.map(|(j, values)| Column { name: format!("x{j}"), values }).collect(),
        group: whole(&case["group"]),
        random: random
            .map(|term| {
                let level = whole(&term["level"]);
                let whole_column = |column: &Vec<f64>| match column.as_slice() {
                    [one] => vec![*one; level.len()],
                    all => all.to_vec(),
                };
                let columns = rows(&term["columns"]).iter().map(whole_column).collect();
                RandomTerm { name: text(term, "name").to_owned(), columns, level }
            })
            .collect(),
    }
}

/// Differences that are larger than they may be, in words.
struct Differences {
    case: String,
    found: Vec<String>,
    looked: usize,
}

impl Differences {
    fn look(&mut self, what: &str, ours: f64, r: f64, tolerance: f64) {
        self.looked += 1;
        let scale = r.abs().max(1e-8);
        if (ours - r).abs() > tolerance * scale || ours.is_nan() {
            self.found.push(format!("{}: {what} {ours} against {r} in R", self.case));
        }
    }
}

/// lme4's optimum is good to its criterion's last digits, which leaves half of the digits of θ and
/// of all that follows from it; lmerTest differentiates numerically.
const CRITERION: f64 = 1e-8;
const ESTIMATE: f64 = 2e-5;
const SATTERTHWAITE: f64 = 1e-3;

/// Where pbkrtest divides zero by zero. With A₁ = q A₂ (always for a single contrast, q = 1, whose
/// Θ Φ Pᵣ Φ have rank one; and for F of a balanced design) Kenward & Roger's formula comes to
/// df = 2 q / A₂, λ = 1. On the way there stands (1 − A₂/q) / (1 − c₂ B), which is 1, but both
/// halves vanish at df = 2: pbkrtest (0.5.2) takes the quotient of what rounding has left once
/// either is above 1e-14, and then shows a df of 1.98 to 2.02 where 2 / A₂ of its own A₂ is 2 to
/// twelve digits. The formula evaluated with 60 digits from the same X, Z and variances says 2 as
/// well (`tests/interop/stats/kenward_roger.py`).
fn is_degenerate(df: f64) -> bool {
    (df - 2.0).abs() < 0.05
}

/// Degrees of freedom by 2 q / A₂, of pbkrtest's own A₂, where A₁ = q A₂.
fn closed_df(moments: &Value, q: f64) -> Option<f64> {
    let (a1, a2) = (number(moments, "a1"), number(moments, "a2"));
    ((a1 / (q * a2) - 1.0).abs() < 1e-9).then_some(2.0 * q / a2)
}

fn compare(differences: &mut Differences, ours: &Fit, case: &Value) {
    let theirs = &case["found"];
    differences.look("criterion", ours.deviance, number(theirs, "criterion"), CRITERION);
    let scale = number(theirs, "residual_variance");
    differences.look("residual variance", ours.residual_variance, scale, ESTIMATE);
    for (ours, theirs) in ours.terms.iter().zip(theirs["covariances"].as_array().unwrap()) {
        for (ours, theirs) in ours.covariance.iter().flatten().zip(rows(theirs).iter().flatten()) {
            differences.look("variance + residual", ours + scale, theirs + scale, 1e-3);
        }
    }
    let estimates = numbers(&theirs["coefficients"]);
    let errors = numbers(&theirs["se"]);
    for j in 0..estimates.len() {
        let unit = errors[j] + estimates[j].abs();
        differences.look("coefficient", ours.coefficients[j] + unit, estimates[j] + unit, ESTIMATE);
        differences.look("standard error", ours.covariance[j][j].sqrt(), errors[j], ESTIMATE);
    }
    let Some(contrasts) = theirs["contrasts"].as_array() else { return };
    let (kr, sat) = (ours.kenward_roger().unwrap(), ours.satterthwaite().unwrap());
    for contrast in contrasts {
        let weights = numbers(&contrast["weights"]);
        let adjusted = kr.test(&weights, 0.95).unwrap();
        differences.look("KR error", adjusted.std_error, number(contrast, "kr_se"), ESTIMATE);
        let df = number(contrast, "kr_df");
        let tolerance = if is_degenerate(df) { 2e-2 } else { 1e-4 };
        differences.look("KR df", adjusted.df, df, tolerance);
        let closed = closed_df(&contrast["kr"], 1.0).expect("A1 is A2 for a single contrast");
        differences.look("KR df as 2 / A", adjusted.df, closed, 1e-4);
        let plain = sat.test(&weights, 0.95).unwrap();
        differences.look("error", plain.std_error, number(contrast, "se"), ESTIMATE);
        differences.look("Satterthwaite df", plain.df, number(contrast, "df"), SATTERTHWAITE);
    }
    if !theirs["joint"].is_object() {
        return;
    }
    let joint = &theirs["joint"];
    let weights = rows(&joint["weights"]);
    let weights: Vec<&[f64]> = weights.iter().map(Vec::as_slice).collect();
    let adjusted = kr.test_all(&weights).unwrap();
    let closed = closed_df(&joint["kr"], weights.len() as f64);
    if let Some(df) = closed {
        let unscaled = number(joint, "kr_f_unscaled");
        differences.look("KR df of F as 2 q / A2", adjusted.df_den, df, 1e-4);
        differences.look("KR F unscaled", adjusted.statistic, unscaled, 1e-4);
    }
    if closed.is_none() || !is_degenerate(number(joint, "kr_df")) {
        differences.look("KR F", adjusted.statistic, number(joint, "kr_f"), 1e-4);
        differences.look("KR df of F", adjusted.df_den, number(joint, "kr_df"), 1e-4);
    }
    let plain = sat.test_all(&weights).unwrap();
    differences.look("F", plain.statistic, number(joint, "f"), 1e-4);
    differences.look("df of F", plain.df_den, number(joint, "df"), SATTERTHWAITE);
}

#[test]
#[ignore = "needs R"]
fn mixed_models_agree_with_lme4_lmertest_and_pbkrtest() {
    let arguments = [setting("ZWIDTH_R_CASES", "60"), setting("ZWIDTH_R_SEED", "20240501")];
    let cases = r("mixed_models.R", &arguments);
    let (mut singular, mut refused, mut tested, mut looked) = (0, 0, 0, 0);
    let (mut constant, mut alone) = (0, 0);
    let mut differences = Vec::new();
    for case in &cases {
        let criterion = if truth(case, "reml") { Criterion::Reml } else { Criterion::Ml };
        let mut here =
            Differences { case: text(case, "name").to_owned(), found: Vec::new(), looked: 0 };
        let is_alone = truth(&case["found"], "alone");
        let is_constant = truth(&case["found"], "constant");
        let identified = !is_alone && !is_constant && truth(&case["found"], "identified");
        match fit(&model(case), criterion) {
            Err(Unestimable::TooFew { units: "participants", found: 1, .. }) if is_alone => {
                alone += 1;
            }
            Err(Unestimable::Constant { .. }) if is_constant => constant += 1,
            Ok(ours) if identified => {
                compare(&mut here, &ours, case);
                singular += usize::from(ours.singular);
                tested += 1;
            }
            Err(Unestimable::Confounded { .. }) if !identified && !is_alone => refused += 1,
            other => here.found.push(format!(
                "{}: identified {identified} in R, here {:?}",
                here.case,
                other.map(|fit| fit.deviance)
            )),
        }
        looked += here.looked;
        differences.extend(here.found);
    }
    let words = format!(
        "lme4, lmerTest and pbkrtest: {} models: {tested} compared by {looked} numbers, {singular} of \
         them singular; refused: {refused} whose design cannot tell the variances apart, {constant} \
         with all values equal, {alone} of one participant.",
        cases.len()
    );
    println!("{words}");
    assert!(differences.is_empty(), "{}\n{}", differences.len(), differences.join("\n"));
    note("r-1", &words);
}

/// Criterion, and of one coefficient its standard error and Kenward–Roger degrees of freedom, as
/// lme4 and pbkrtest have them when they converge tightly.
const KNOWN: [(&str, f64, usize, f64, f64); 8] = [
    ("sleepstudy (Days | Subject)", 1_743.628_271_960, 1, 1.545_788_9, 17.0),
    ("sleepstudy (Days | Subject) ML", 1_751.939_344_460, 1, 1.545_788_9, 17.0),
    ("sleepstudy (1 | Subject)", 1_786.465_085_390, 1, 0.804_221_429, 161.0),
    ("Orthodont (1 | Subject)", 433.757_249_201, 3, 0.121_420_896, 79.0),
    // lme4's default stops at 432.581667 with 0.134705844
    ("Orthodont (age | Subject)", 432.581_661_503, 3, 0.134_735_34, 25.0),
    ("Machines", 215.687_568_008, 1, 2.176_975_476, 10.0),
    ("Dyestuff", 319.654_276_842, 0, 19.383_412_15, 5.0),
    ("Dyestuff2", 161.828_277_812, 0, 0.678_388_031, 5.0),
];

#[test]
#[ignore = "needs R"]
fn known_data_sets_have_their_known_fits() {
    let cases = r("mixed_models.R", &["0".to_owned()]);
    for (name, deviance, coefficient, std_error, df) in KNOWN {
        let case = cases.iter().find(|case| text(case, "name") == name).unwrap();
        let criterion = if truth(case, "reml") { Criterion::Reml } else { Criterion::Ml };
        let ours = fit(&model(case), criterion).unwrap();
        let mut weights = vec![0.0; ours.coefficients.len()];
        weights[coefficient] = 1.0;
        let test = ours.kenward_roger().unwrap().test(&weights, 0.95).unwrap();
        assert!((ours.deviance / deviance - 1.0).abs() < 5e-12, "{name}: {}", ours.deviance);
        assert!((test.std_error / std_error - 1.0).abs() < 5e-8, "{name}: {}", test.std_error);
        assert!((test.df / df - 1.0).abs() < 1e-9, "{name}: {}", test.df);
    }
}

/// A value of `reference.R` by its study and its name, and what it is known to be: found by R 4.2 and, without R, by NumPy and
/// SciPy (mixed models by R alone).
type Reference = (&'static str, &'static str, &'static [f64]);

const REFERENCE: &[Reference] = &[
    (
        "groups",
        "expert_minus_novice_of_c",
        &[
            0.0245571429,
            0.408888294,
            0.0600583172,
            4.33041842,
            0.954780048,
            -1.07733935,
            1.12645364,
        ],
    ),
    (
        "groups",
        "expert_minus_novice_in_hybrid",
        &[
            0.161135714,
            0.317231867,
            0.507943026,
            5.33019637,
            0.631813917,
            -0.639372133,
            0.961643561,
        ],
    ),
    (
        "groups",
        "expert_minus_novice_of_mean_over_modes",
        &[
            0.00707857143,
            0.227658336,
            0.0310929595,
            5.98639374,
            0.976206109,
            -0.550288365,
            0.564445508,
        ],
    ),
    (
        "groups",
        "c_groups_with_equal_weight",
        &[0.667921429, 0.204444147, 3.26701174, 4.33041842, 0.0274871718],
    ),
    ("groups", "c_in_novice", &[0.655642857, 0.0812110503, 8.07332074, 6.0, 1.93413820e-4]),
    ("groups", "c_in_expert", &[0.6802, 0.400742314, 1.69735008, 4.0, 0.164866159]),
    (
        "groups",
        "c_one_t_over_all_people",
        &[0.665875, 0.162617016, 4.09474368, 11.0, 1.77516675e-3],
    ),
    ("groups", "permutations_of_c", &[792.0, 742.0]),
    ("groups", "permutations_in_hybrid", &[792.0, 531.0]),
    ("groups", "welch_f_of_c_over_band", &[1.58017655, 2.0, 4.52137704, 0.301728201]),
    (
        "groups",
        "c_per_year_of_age",
        &[-0.0400901549, 0.0247294347, 10.0, 0.136052006, 0.665875, 0.151772394],
    ),
    ("groups", "kr", &[-64.6760928, 0.367984657, 0.283013434, 0.114736586]),
    ("groups", "kr_group_difference_of_c", &[0.0245571429, 0.308401035, 20.0]),
    ("groups", "kr_c_equal_weight", &[0.667921429, 0.154200517, 20.0]),
    ("groups", "kr_group_over_modes", &[0.00707857143, 0.208119097, 10.0]),
    ("groups", "kr_f_group_by_mode", &[1.27123, 2.0, 20.0, 0.302193894]),
    ("groups", "d_z", &[1.18205068, 1.09925963, 0.419908837, 1.91392995]),
    ("groups", "d_av", &[1.44314294, 1.38996880, 0.512658620, 2.33668025]),
    ("groups", "between_c", &[0.0376880380, 0.0309151729, -1.19457246, 1.26575650]),
    (
        "factorial",
        "spring_motor",
        &[0.449375, 0.0484558049, 9.27391467, 7.0, 3.50853872e-5, 0.334795229, 0.563954771],
    ),
    (
        "factorial",
        "spring_brake",
        &[0.324458333, 0.0534009314, 6.07589278, 7.0, 5.02904728e-4, 0.198185196, 0.450731471],
    ),
    (
        "factorial",
        "spring_motor_brake",
        &[0.118916667, 0.0541652655, 2.1954414, 7.0, 0.0641613136, -0.00916383385, 0.246997167],
    ),
    (
        "factorial",
        "wall_motor",
        &[0.367333333, 0.061609763, 5.9622585, 7.0, 5.63103835e-4, 0.221649394, 0.513017273],
    ),
    (
        "factorial",
        "wall_brake",
        &[0.1965, 0.0518914178, 3.78675334, 7.0, 0.00683177888, 0.0737962949, 0.319203705],
    ),
    (
        "factorial",
        "wall_motor_brake",
        &[0.0168333333, 0.100066565, 0.168221357, 7.0, 0.871166399, -0.219786493, 0.25345316],
    ),
    (
        "factorial",
        "wall_minus_spring_motor",
        &[-0.0820416667, 0.0682969179, -1.20124991, 7.0, 0.268716871, -0.243538215, 0.0794548818],
    ),
    (
        "factorial",
        "wall_minus_spring_motor_brake",
        &[-0.102083333, 0.103192045, -0.989255839, 7.0, 0.355492112, -0.346093746, 0.14192708],
    ),
    (
        "factorial",
        "holm_of_the_six",
        &[2.10512e-4, 0.00251452, 0.128323, 0.00251452, 0.0204953, 0.871166],
    ),
    // Everybody's own line over trials: our own is in the stage that compares, which its tests hold against these.
    (
        "factorial",
        "spring_motor_brake_by_trial",
        &[0.14443999, 0.0546080023, 2.6450334, 7.0, 0.0331800679, 0.0153125832, 0.273567396],
    ),
    (
        "factorial",
        "wall_motor_by_trial",
        &[0.369108272, 0.0576589951, 6.4015731, 7.0, 3.66732648e-4, 0.232766414, 0.50545013],
    ),
    (
        "factorial",
        "spring_slope_per_trial",
        &[
            -0.0219326312,
            0.00377492312,
            -5.81008685,
            7.0,
            6.56743528e-4,
            -0.0308589059,
            -0.0130063564,
        ],
    ),
    (
        "dose",
        "contrasts",
        &[
            -0.545544726,
            -0.327326835,
            0.109108945,
            0.763762616,
            0.512822594,
            -0.170940865,
            -0.740743747,
            0.398862018,
            -0.43519414,
            0.783349452,
            -0.43519414,
            0.087038828,
        ],
    ),
    (
        "dose",
        "slope_per_n_per_m",
        &[
            0.00265515873,
            2.91889763e-4,
            9.09644347,
            7.0,
            3.97978153e-5,
            0.00196494912,
            0.00334536834,
        ],
    ),
    (
        "dose",
        "quadratic_coefficient",
        &[
            -2.91212121e-6,
            1.77948185e-6,
            -1.63649953,
            7.0,
            0.145748125,
            -7.11992716e-6,
            1.29568474e-6,
        ],
    ),
    (
        "dose",
        "per_doubling",
        &[0.403832306, 0.0431339221, 9.36229044, 7.0, 3.29767885e-5, 0.301836788, 0.505827825],
    ),
    (
        "dose",
        "quadratic_curve_at_300",
        &[1.414125, 0.0866365604, 16.322497, 7.0, 7.89257028e-7, 1.20926209, 1.61898791],
    ),
    ("dose", "greenhouse_geisser", &[57.8715542, 0.606297844, 5.58186273e-7, 2.52648464e-10]),
    ("dose", "lack_of_fit_of_the_line", &[1.25454713, 2.0, 6.0, 0.350593408]),
    ("dose", "hotelling_all", &[23.2154895, 3.0, 5.0, 0.00230820166]),
    ("dose", "kr_random_slope_and_level", &[0.265515873, 0.0291889759, 7.0, -117.67382]),
    ("dose", "random_intercept_alone", &[0.0123689614, 87.0]),
    // Scores are of the stage that makes them, whose tests hold them against these.
    ("scales", "sus", &[49.0, 63.0, 14.0, 3.6930866, 0.0042769536]),
    ("scales", "tlx_raw", &[51.6666667, 43.3333333, -8.33333333, 2.4876237, 0.0085246659]),
    ("scales", "tlx_weighted", &[52.7, 44.1333333, -8.56666667, 2.7826846, 0.013170526]),
    ("scales", "p01_active", &[30.0, 61.6666667, 63.6666667]),
    ("scales", "alpha_sus_active", &[0.920056348, 0.818096844, 0.976622338]),
    ("scales", "alpha_sus_hybrid", &[0.936924494, 0.856478490, 0.981555030]),
    ("scales", "odd_items_hybrid", &[0.918703008, 0.917815110]),
    ("scales", "odd_items_active", &[0.895833333]),
];

/// Of what is known, and of R beside us: lme4 finds variances to half of the digits of its criterion.
const BY_FORMULA: f64 = 1e-5;

fn tested(found: Tested) -> Vec<f64> {
    let Tested { estimate, std_error, ci_low, ci_high, statistic, df, p_value } = found;
    vec![estimate, std_error, statistic, df, p_value, ci_low, ci_high]
}

fn f_tested(found: FTest) -> Vec<f64> {
    vec![found.statistic, found.df_num, found.df_den, found.p_value]
}

fn sized(found: Effect) -> Vec<f64> {
    [vec![found.d, found.g.unwrap()], found.interval.unwrap().to_vec()].concat()
}

/// Estimate, standard error and degrees of freedom of a combination of coefficients after Kenward & Roger.
fn kenward_roger(fit: &Fit, weights: &[f64]) -> Vec<f64> {
    tested(fit.kenward_roger().unwrap().test(weights, 0.95).unwrap())
        .into_iter()
        .enumerate()
        .filter_map(|(place, value)| [0, 1, 3].contains(&place).then_some(value))
        .collect()
}

fn sum(values: &[f64], weights: &[f64]) -> f64 {
    values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
}

type Named = Vec<(&'static str, Vec<f64>)>;

fn of_groups(study: &Value) -> Named {
    let (participant, mode) = (whole(&study["participant"]), whole(&study["mode"]));
    let (expert, value) = (whole(&study["expert"]), numbers(&study["value"]));
    let mean = |person: usize, own: usize| {
        let trials = (0..value.len()).filter(|t| (participant[*t], mode[*t]) == (person, own));
        let trials: Vec<f64> = trials.map(|t| value[t]).collect();
        trials.iter().sum::<f64>() / trials.len() as f64
    };
    let means: Vec<[f64; 3]> = (1..=12).map(|p| [0, 1, 2].map(|m| mean(p, m))).collect();
    let differences: Vec<f64> = means.iter().map(|[active, _, hybrid]| hybrid - active).collect();
    let hybrid: Vec<f64> = means.iter().map(|means| means[2]).collect();
    let over: Vec<f64> = means.iter().map(|means| means.iter().sum::<f64>() / 3.0).collect();
    let welch = |all: &[f64]| {
        let (novices, experts) = all.split_at(7);
        tested(groups::difference([group(experts), group(novices)], 0.95).unwrap())
    };
    let permuted = |all: &[f64]| {
        let (novices, experts) = all.split_at(7);
        let none = Sampling { draws: 1, seed: 1 };
        vec![792.0, 792.0 * groups::permuted(experts, novices, none).unwrap().p_value]
    };
    let (novices, experts) = differences.split_at(7);
    let equal = groups::mean(&[group(novices), group(experts)], 0.95).unwrap();
    let bands: Vec<_> = (0..3)
        .map(|band| {
            let of_band = (1..=12).filter(|person| person % 3 == band);
            group(&of_band.map(|person| differences[person - 1]).collect::<Vec<f64>>())
        })
        .collect();
    let age = numbers(&study["age"]);
    let points: Vec<[f64; 2]> = age.iter().zip(&differences).map(|(a, c)| [*a, *c]).collect();
    let slope = common_slope(&[points], 0.95).unwrap();
    // A mean for each group and mode: active, passive and hybrid of novices, then of experts.
    let cells: Vec<usize> = expert.iter().zip(&mode).map(|(e, m)| 3 * e + m).collect();
    let session = vec![0; value.len()];
    let trials =
        Trials { participant: &participant, session: &session, mode: &cells, value: &value };
    let fitted = fit_trials(trials).unwrap().fit;
    let sd = |term: usize| fitted.terms[term].covariance[0][0].sqrt();
    let interaction: [&[f64]; 2] =
        [&[1.0, -1.0, 0.0, -1.0, 1.0, 0.0], &[1.0, 0.0, -1.0, -1.0, 0.0, 1.0]];
    let joint = fitted.kenward_roger().unwrap().test_all(&interaction).unwrap();
    let third = 1.0 / 3.0;
    let pairs: Vec<[f64; 2]> = means.iter().map(|[active, _, hybrid]| [*hybrid, *active]).collect();
    vec![
        ("expert_minus_novice_of_c", welch(&differences)),
        ("expert_minus_novice_in_hybrid", welch(&hybrid)),
        ("expert_minus_novice_of_mean_over_modes", welch(&over)),
        ("c_groups_with_equal_weight", tested(equal)[..5].to_vec()),
        ("c_in_novice", tested(mean_difference(novices, 0.95).unwrap())),
        ("c_in_expert", tested(mean_difference(experts, 0.95).unwrap())),
        ("c_one_t_over_all_people", tested(mean_difference(&differences, 0.95).unwrap())),
        ("permutations_of_c", permuted(&differences)),
        ("permutations_in_hybrid", permuted(&hybrid)),
        ("welch_f_of_c_over_band", f_tested(any_difference(&bands).unwrap())),
        ("c_per_year_of_age", vec![slope.estimate, slope.std_error, slope.df, slope.p_value]),
        ("kr", vec![fitted.deviance, sd(1), sd(0), fitted.residual_variance.sqrt()]),
        ("kr_group_difference_of_c", kenward_roger(&fitted, &[1.0, 0.0, -1.0, -1.0, 0.0, 1.0])),
        ("kr_c_equal_weight", kenward_roger(&fitted, &[-0.5, 0.0, 0.5, -0.5, 0.0, 0.5])),
        (
            "kr_group_over_modes",
            kenward_roger(&fitted, &[-third, -third, -third, third, third, third]),
        ),
        ("kr_f_group_by_mode", f_tested(joint)),
        ("d_z", sized(d_z(&pairs, 0.95).unwrap())),
        ("d_av", sized(d_av(&pairs, 0.95).unwrap())),
        ("between_c", sized(groups::effect([group(experts), group(novices)], 0.95).unwrap())),
    ]
}

fn of_factors(study: &Value) -> Named {
    const EFFECTS: [(&str, [f64; 4]); 3] = [
        ("motor", [-0.5, -0.5, 0.5, 0.5]),
        ("brake", [-0.5, 0.5, -0.5, 0.5]),
        ("motor_brake", [1.0, -1.0, -1.0, 1.0]),
    ];
    const NAMES: [[&str; 3]; 2] = [
        ["spring_motor", "spring_brake", "spring_motor_brake"],
        ["wall_motor", "wall_brake", "wall_motor_brake"],
    ];
    let tables = [rows(&study["spring"]), rows(&study["wall"])];
    let of = |table: &[Vec<f64>], weights: &[f64]| -> Vec<f64> {
        table.iter().map(|means| sum(means, weights)).collect()
    };
    let (mut found, mut p, mut f) = (Named::new(), Vec::new(), Vec::new());
    for (table, names) in tables.iter().zip(NAMES) {
        for ((_, weights), name) in EFFECTS.iter().zip(names) {
            let test = mean_difference(&of(table, weights), 0.95).unwrap();
            f.push(rm_anova::effect(table, &[weights.to_vec()]).unwrap().test.statistic);
            p.push(test.p_value);
            found.push((name, tested(test)));
        }
    }
    for (name, (_, weights)) in
        [("wall_minus_spring_motor", EFFECTS[0]), ("wall_minus_spring_motor_brake", EFFECTS[2])]
    {
        let [spring, wall] = tables.each_ref().map(|table| of(table, &weights));
        let each: Vec<f64> = wall.iter().zip(&spring).map(|(wall, spring)| wall - spring).collect();
        found.push((name, tested(mean_difference(&each, 0.95).unwrap())));
    }
    found.push(("holm_of_the_six", holm::adjusted(&p).unwrap()));
    found.push(("f_of_the_six", f));
    found
}

fn of_doses(study: &Value) -> Named {
    let means = rows(&study["means"]);
    let polynomials = rows(&study["polynomials"]);
    let along = |which: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let each = |means: &Vec<f64>| which.iter().map(|weights| sum(means, weights)).collect();
        means.iter().map(each).collect()
    };
    let RmAnova { test, greenhouse_geisser, p_greenhouse_geisser, .. } =
        rm_anova::rm_anova(&means).unwrap();
    let (participant, level) = (whole(&study["participant"]), whole(&study["level"]));
    let (dose, value) = (numbers(&study["dose"]), numbers(&study["value"]));
    let dosed = Dosed { participant: &participant, level: &level, dose: &dose, value: &value };
    let own = fit_doses(dosed).unwrap();
    let ones = vec![1.0; value.len()];
    let alone = Model {
        fixed: vec![
            Column { name: "level".to_owned(), values: ones },
            Column { name: "slope".to_owned(), values: dose },
        ],
        random: vec![RandomTerm::intercept("participant", vec![0; value.len()])],
        response: value,
        group: participant,
    };
    let alone = fit(&alone, Criterion::Reml).unwrap();
    vec![
        (
            "greenhouse_geisser",
            vec![test.statistic, greenhouse_geisser, p_greenhouse_geisser, test.p_value],
        ),
        ("lack_of_fit_of_the_line", f_tested(hotelling::test(&along(&polynomials[1..])).unwrap())),
        ("hotelling_all", f_tested(hotelling::test(&along(&polynomials)).unwrap())),
        (
            "kr_random_slope_and_level",
            [kenward_roger(&own, &[0.0, 1.0]), vec![own.deviance]].concat(),
        ),
        ("random_intercept_alone", kenward_roger(&alone, &[0.0, 1.0])[1..].to_vec()),
    ]
}

fn of_scales(study: &Value) -> Named {
    let alpha_of = |items: &str| {
        let found = alpha(&rows(&study[items]), 0.95).unwrap();
        vec![found.alpha, found.ends[0], found.ends[1]]
    };
    let odd = rows(&study["odd"]);
    vec![
        ("alpha_sus_active", alpha_of("active")),
        ("alpha_sus_hybrid", alpha_of("hybrid")),
        ("odd_items_hybrid", vec![alpha(&odd, 0.95).unwrap().alpha, omega(&odd).unwrap()]),
    ]
}

#[test]
#[ignore = "needs R"]
fn studies_made_by_formula_have_the_values_of_r() {
    let studies = r("reference.R", &[]);
    let (mut known, mut looked, mut broken) = (0, 0, Vec::new());
    for study in &studies {
        let name = text(study, "name");
        let ours = match name {
            "groups" => of_groups(study),
            "factorial" => of_factors(study),
            "dose" => of_doses(study),
            "scales" => of_scales(study),
            other => panic!("what is {other}?"),
        };
        let of_r = |value: &str| numbers(&study["values"][value]);
        let mut differences = Differences { case: name.to_owned(), found: Vec::new(), looked: 0 };
        for (_, value, expected) in REFERENCE.iter().filter(|(own, ..)| *own == name) {
            let of_r = of_r(value);
            assert!(of_r.len() >= expected.len(), "{name}, {value}: {of_r:?}");
            for (of_r, expected) in of_r.iter().zip(*expected) {
                differences.look(&format!("{value}, known as"), *expected, *of_r, BY_FORMULA);
            }
        }
        known += differences.looked;
        for (value, ours) in ours {
            let of_r = of_r(value);
            assert!(of_r.len() >= ours.len(), "{name}, {value}: {of_r:?}");
            for (ours, of_r) in ours.iter().zip(&of_r) {
                differences.look(value, *ours, *of_r, BY_FORMULA);
            }
        }
        looked += differences.looked;
        broken.extend(differences.found);
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    let words = format!(
        "Base R, lme4 and pbkrtest: {} studies made by formula: {known} numbers known beforehand, {} of ours.",
        studies.len(),
        looked - known
    );
    println!("{words}");
    note("r-4", &words);
}
