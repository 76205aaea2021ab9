#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test, and no part of the product"
)]
#![allow(clippy::print_stdout, reason = "a test says what it counted")]
//! Our cumulative-link models beside those of R's package ordinal, on the same answers: the wine
//! data of the package, and random studies with ties, missing cells, separated answers, people who
//! are alike, answers that are all equal, and one participant.
//!
//! `cargo test -p zwidth-stats --test ordinal -- --ignored` with `Rscript` in the path; without R,
//! or without its packages ordinal and jsonlite, the test fails. `ZWIDTH_R_CASES` sets how many
//! studies are drawn (50), `ZWIDTH_R_SEED` the first one's seed; the others' follow.

mod shared;

use serde_json::Value;
use shared::{note, setting};
use std::path::Path;
use std::process::Command;
use zwidth_stats::Unestimable;
use zwidth_stats::clm;
use zwidth_stats::clmm::{self, Column, Integral, Ratings, Terms};
use zwidth_stats::student_t::two_sided_p;

/// clm: both end Newton's method where rounding begins.
const PLAIN: f64 = 1e-9;
/// clmm: R's search, by differences, may end this much below the maximum.
const BELOW: f64 = 2e-8;
/// Our log-likelihood is nowhere lower than R's by more than rounding.
const ROUNDING: f64 = 1e-10;
/// A log-likelihood that is flat to `BELOW` leaves √(2 · 2e-8) standard errors of an estimate, and
/// twice that is allowed.
const OF_STD_ERROR: f64 = 4e-4;
/// An SD that is zero to the flatness of its likelihood, σ² · curvature ≈ `BELOW`.
const NO_SD: f64 = 2e-3;
/// How far R's log-likelihood may be from the definition's at its own end: its inner searches end
/// off the modes.
const OFF_MODES: f64 = 1e-7;
/// Standard errors come from second differences of the log-likelihood: those of the script, from
/// the approximation's definition, because R's are off by more at times.
const OF_DIFFERENCES: f64 = 2e-3;
/// R interpolates its profiles by splines.
const OF_SPLINES: f64 = 1e-3;

/// Answers, and what R's script says of them.
struct Case {
    name: String,
    answers: Vec<u8>,
    points: u8,
    columns: Vec<Column>,
    participants: Vec<usize>,
    modes: Vec<usize>,
    fits: Value,
}

/// What became of the studies.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    plain: usize,
    mixed: usize,
    singular: usize,
    separated: usize,
    constant: usize,
    one_participant: usize,
    profiles: usize,
    ends: usize,
    resumed: usize,
    dropped: usize,
}

#[test]
#[ignore = "needs R"]
fn the_estimates_are_those_of_ordinal() {
    let cases = cases();
    check_wine(&cases[0]);
    // A study that fails hides no other: each prints why.
    let checked = cases.iter().map(|case| std::panic::catch_unwind(|| check(case)));
    let tallies: Vec<Option<Tally>> = checked.map(Result::ok).collect();
    let failed: Vec<&str> = cases
        .iter()
        .zip(&tallies)
        .filter_map(|(case, tally)| tally.is_none().then_some(case.name.as_str()))
        .collect();
    let tally = tallies.into_iter().flatten().fold(Tally::default(), Tally::plus);
    println!("{} studies: {tally:?}", cases.len());
    assert!(failed.is_empty(), "{} of {}: {}", failed.len(), cases.len(), failed.join(", "));
    note("r-2", &tally.words(cases.len()));
    let Tally {
        plain, mixed, singular, separated, constant, one_participant, profiles, ends, ..
    } = tally;
    // The random studies hold some of everything.
    for count in [plain, mixed, singular, profiles] {
        assert!(5 * count >= 2 * (cases.len() - 1), "{count}");
    }
    // Two of each of a dozen small studies among the first 35 seeds.
    let least = if cases.len() > 36 { 24 } else { 12 };
    assert!(ends >= least || setting("ZWIDTH_R_SEED", "1") != "1", "{ends}");
    for count in [separated, constant, one_participant] {
        assert!(count >= 2 * (cases.len() - 1) / 25, "{count}");
    }
}

/// Checks a study, and says what became of it.
fn check(case: &Case) -> Tally {
    let mut tally = Tally::default();
    check_plain(case, &mut tally);
    check_mixed(case, "participant", Terms::Participant, &mut tally);
    check_mixed(case, "participant_and_mode", Terms::ParticipantAndMode, &mut tally);
    check_ends(case, &mut tally);
    tally
}

impl Tally {
    fn plus(self, other: Self) -> Self {
        Self {
            plain: self.plain + other.plain,
            mixed: self.mixed + other.mixed,
            singular: self.singular + other.singular,
            separated: self.separated + other.separated,
            constant: self.constant + other.constant,
            one_participant: self.one_participant + other.one_participant,
            profiles: self.profiles + other.profiles,
            ends: self.ends + other.ends,
            resumed: self.resumed + other.resumed,
            dropped: self.dropped + other.dropped,
        }
    }

    fn words(self, studies: usize) -> String {
        let Self { plain, mixed, singular, separated, constant, one_participant, .. } = self;
        let Self { profiles, ends, resumed, dropped, .. } = self;
        format!(
            "ordinal: {studies} studies: {plain} models of answers and {profiles} profile intervals, \
             {mixed} models with random effects, {singular} of them singular, {resumed} compared with \
             the maximum by the definition because R had stopped early; refused: {separated} studies \
             with separated answers, {constant} with all answers equal, {dropped} with fewer answers \
             than parameters, {one_participant} models of one participant; {ends} ends of profiles by \
             the integral itself."
        )
    }
}

fn check_plain(case: &Case, tally: &mut Tally) {
    let name = &case.name;
    let theirs = &case.fits["clm"];
    let model = clm::Model::new(&case.answers, case.points, &case.columns);
    let fitted = model.and_then(|model| Ok((clm::fit(&model)?, model)));
    match (&fitted, theirs.get("refused")) {
        (Ok((fit, model)), None) => {
            tally.plain += 1;
            let difference = fit.log_likelihood - number(&theirs["log_likelihood"]);
            assert!(difference.abs() < PLAIN, "{name}: {difference}");
            close(name, &fit.thresholds, &numbers(&theirs["thresholds"]), |_| 1e-6);
            close(name, &fit.coefficients, &numbers(&theirs["coefficients"]), |_| 1e-6);
            let errors: Vec<f64> =
                (0..fit.coefficients.len()).map(|j| fit.wald(j, 0.95).unwrap().std_error).collect();
            close(name, &errors, &numbers(&theirs["std_errors"]), |e| 1e-6 * e);
            for (j, row) in theirs["profile"].as_array().into_iter().flatten().enumerate() {
                // R leaves out an end that it did not reach.
                let ends: Vec<f64> =
                    row.as_array().unwrap().iter().filter_map(Value::as_f64).collect();
                if let [low, high] = ends[..] {
                    tally.profiles += 1;
                    let found = clm::profile_interval(model, fit, j, 0.95).unwrap();
                    close(name, &[found.0, found.1], &[low, high], |_| OF_SPLINES * errors[j]);
                }
            }
        }
        (Err(Unestimable::Separated { .. }), Some(_)) => tally.separated += 1,
        (Err(Unestimable::Constant { .. }), Some(_)) => tally.constant += 1,
        (Err(why), None) if without_a_coefficient(case, why, theirs) => tally.dropped += 1,
        (ours, _) => panic!("{name}: {ours:?} against {theirs}"),
    }
}

/// Whether there are fewer answers than thresholds and coefficients need, and R fitted without a
/// coefficient. In seed 780 two answers are left, both of one mode: the other mode's column is zero
/// throughout, R drops it, has NA for its coefficient, and fits a threshold to the two; we estimate
/// all columns or none.
fn without_a_coefficient(case: &Case, why: &Unestimable, theirs: &Value) -> bool {
    let dropped = theirs["coefficients"].as_array().unwrap().iter().any(|c| c == "NA");
    dropped && too_few_answers(case, why)
}

fn too_few_answers(case: &Case, why: &Unestimable) -> bool {
    let (found, needed) = (case.answers.len(), case.columns.len() + 2);
    found < needed && *why == Unestimable::TooFew { units: "answers", found, needed }
}

fn check_mixed(case: &Case, fit: &str, terms: Terms, tally: &mut Tally) {
    let theirs = &case.fits[fit];
    let name = format!("{}, {fit}", case.name);
    let ours = case.fit(terms, Integral::Laplace);
    match (&ours, theirs.get("refused")) {
        (Ok(ours), None) => {
            tally.mixed += 1;
            tally.singular += usize::from(ours.singular);
            let end = end_to_compare(&name, ours, theirs);
            tally.resumed += usize::from(end != theirs);
            same(&name, ours, end);
        }
        // R fits separated answers: a coefficient far out, or no standard errors.
        (Err(Unestimable::Separated { .. }), None) => {
            let far = numbers(&theirs["coefficients"])
                .iter()
                .chain(&numbers(&theirs["sd"]))
                .any(|x| x.abs() > 15.0);
            assert!(far, "{name}: {theirs}");
        }
        (Err(Unestimable::Constant { .. } | Unestimable::Separated { .. }), Some(_)) => {}
        (Err(Unestimable::TooFew { units: "participants", found: 1, .. }), Some(_)) => {}
        (Err(why), Some(_)) if too_few_answers(case, why) => {}
        (ours, _) => panic!("{name}: {ours:?} against {theirs}"),
    }
    let alone = case.participants.iter().all(|p| *p == case.participants[0]);
    tally.one_participant += usize::from(alone && ours.is_err());
}

/// Where R, from the definition, has its log-likelihood with a coefficient held, our interval of
/// the level that this log-likelihood makes has to end.
fn check_ends(case: &Case, tally: &mut Tally) {
    let theirs = &case.fits["held"];
    if theirs.is_null() {
        return;
    }
    let name = &case.name;
    let model = clmm::Model::new(&case.ratings(), Terms::Participant).unwrap();
    let fit = clmm::fit(&model, Integral::Quadrature).unwrap();
    let top = number(&theirs["log_likelihood"]);
    assert!((fit.log_likelihood - top).abs() < BELOW, "{name}: {} {top}", fit.log_likelihood);
    for held in theirs["held"].as_array().unwrap() {
        let at = number(&held["coefficient"]);
        let fall = (2.0 * (top - number(&held["log_likelihood"]))).sqrt();
        let df = 10.0;
        let level = 1.0 - two_sided_p(fall, df).unwrap();
        let found =
            clmm::profile_interval(&model, Integral::Quadrature, &fit, 0, level, df).unwrap();
        let end = if at < fit.coefficients[0] { found.low } else { found.high };
        close(name, &[end.value().unwrap()], &[at], |_| OF_DIFFERENCES);
        tally.ends += 1;
    }
}

/// R's end; where our log-likelihood is higher, the one to which the script came from there by the
/// approximation's definition, which has to say of R's own end what R says.
fn end_to_compare<'a>(name: &str, ours: &clmm::Fit, theirs: &'a Value) -> &'a Value {
    let log_likelihood = number(&theirs["log_likelihood"]);
    if ours.log_likelihood - log_likelihood < BELOW {
        return theirs;
    }
    let further = &theirs["further"];
    assert!(further.is_object(), "{name}: {} above {log_likelihood}", ours.log_likelihood);
    close(name, &[number(&further["defined"])], &[log_likelihood], |_| OFF_MODES);
    further
}

fn same(name: &str, ours: &clmm::Fit, theirs: &Value) {
    let difference = ours.log_likelihood - number(&theirs["log_likelihood"]);
    assert!(difference > -ROUNDING && difference < BELOW, "{name}: {difference}");
    let errors = |place: usize| ours.covariance[place][place].sqrt();
    let thresholds = ours.thresholds.len();
    for (j, (a, b)) in ours.coefficients.iter().zip(numbers(&theirs["coefficients"])).enumerate() {
        let allowed = OF_STD_ERROR * errors(thresholds + j);
        assert!((a - b).abs() < allowed, "{name}: coefficient {a} against {b}");
    }
    for (j, (a, b)) in ours.thresholds.iter().zip(numbers(&theirs["thresholds"])).enumerate() {
        assert!((a - b).abs() < OF_STD_ERROR * errors(j), "{name}: threshold {a} against {b}");
    }
    let sds = [Some(ours.sd_participant), ours.sd_participant_mode];
    for (a, b) in sds.into_iter().flatten().zip(numbers(&theirs["sd"])) {
        // The smaller the SD, the flatter its likelihood.
        assert!((a * a - b * b).abs() < OF_STD_ERROR * a.max(NO_SD), "{name}: SD {a} against {b}");
    }
    // Where R's SD is almost zero its second differences are those of a cone.
    if theirs["std_errors"].is_array() && !ours.singular {
        let ours: Vec<f64> = (0..ours.coefficients.len()).map(|j| errors(thresholds + j)).collect();
        close(name, &ours, &numbers(&theirs["std_errors"]), |e| OF_DIFFERENCES * e);
    }
}

/// The numbers that a reader of the package's vignettes knows, to the digits that hold.
fn check_wine(wine: &Case) {
    assert_eq!(wine.name, "wine");
    let model = clm::Model::new(&wine.answers, wine.points, &wine.columns).unwrap();
    let plain = clm::fit(&model).unwrap();
    close("clm", &[plain.log_likelihood], &[-86.4919233656], |_| 1e-10);
    close("clm", &plain.coefficients, &[2.5031020, 1.5277977], |_| 5e-8);
    let laplace = wine.fit(Terms::Participant, Integral::Laplace).unwrap();
    // From the approximation's definition, maximised by another method.
    let defined = number(&wine.fits["definition"]["log_likelihood"]);
    close("Laplace", &[laplace.log_likelihood], &[defined], |_| 1e-9);
    // The quick implementation of one term, which is not at the modes: it is off by 3.5e-6.
    let quick = &wine.fits["quick"];
    close("quick", &[number(&quick["log_likelihood"])], &[-81.5654092921], |_| 1e-9);
    close("quick", &[laplace.log_likelihood], &[-81.5654092921], |_| 4e-6);
    close("quick", &[laplace.sd_participant], &[1.1311326], |_| 1e-5);
    close("quick", &laplace.coefficients, &numbers(&quick["coefficients"]), |_| 2e-5);
    let exact = wine.fit(Terms::Participant, Integral::Quadrature).unwrap();
    close("AGQ", &[exact.log_likelihood], &[-81.532460711], |_| 1e-9);
    // R's search ends 1.5e-10 below the maximum, which is a hundred-thousandth of a standard error.
    let given = [1.1347833, 3.0618910];
    close("AGQ", &[exact.sd_participant, exact.coefficients[0]], &given, |_| 1e-5);
    same("AGQ", &exact, &wine.fits["quadrature"]);
}

impl Case {
    fn ratings(&self) -> Ratings<'_> {
        Ratings {
            answers: &self.answers,
            points: self.points,
            columns: &self.columns,
            participants: &self.participants,
            modes: &self.modes,
        }
    }

    fn fit(&self, terms: Terms, integral: Integral) -> Result<clmm::Fit, Unestimable> {
        clmm::fit(&clmm::Model::new(&self.ratings(), terms)?, integral)
    }
}

fn close(what: &str, ours: &[f64], theirs: &[f64], allowed: impl Fn(f64) -> f64) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() < allowed(*b), "{what}: {a} against {b}");
    }
}

fn cases() -> Vec<Case> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop/stats/ordinal.R");
    let given = [setting("ZWIDTH_R_CASES", "50"), setting("ZWIDTH_R_SEED", "1")];
    let run = Command::new("Rscript").arg(&script).args(given).output();
    let run = run.expect("Rscript is needed: install R with ordinal, jsonlite");
    let why = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "R needs ordinal, jsonlite: {why}");
    let all: Value = serde_json::from_slice(&run.stdout).unwrap();
    all.as_array().unwrap().iter().map(case).collect()
}

fn case(value: &Value) -> Case {
    let whole = |key: &str| numbers(&value[key]).into_iter().map(|x| x as usize).collect();
    let answers: Vec<usize> = whole("answers");
    let column = |column: &Value| Column {
        name: column["name"].as_str().unwrap().to_owned(),
        values: numbers(&column["values"]),
    };
    Case {
        name: value["name"].as_str().unwrap().to_owned(),
        answers: answers.iter().map(|&answer| answer as u8).collect(),
        points: value["points"].as_u64().unwrap() as u8,
        columns: value["columns"].as_array().unwrap().iter().map(column).collect(),
        participants: whole("participants"),
        modes: whole("modes"),
        fits: value["fits"].clone(),
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}
