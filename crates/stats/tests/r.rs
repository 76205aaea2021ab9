//! The same data in R: lme4, lmerTest and pbkrtest.
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
use zwidth_stats::Unestimable;
use zwidth_stats::lmm::{Column, Criterion, Fit, Model, RandomTerm, fit};

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
