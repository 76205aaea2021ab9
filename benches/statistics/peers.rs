//! Both sides in turns on the same data: first whether they find the same, then how long they take.

use crate::cases::{CASES, Case, Data, Kind};
use crate::ours::{Found, fit};
use anyhow::{Context as _, bail, ensure};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use zwidth_numerics::order::upper_median;

/// Rounds, each with both sides one after the other.
const ROUNDS: usize = 3;
/// Of ours a round takes at least so long and so many fits.
const LEAST: (Duration, usize) = (Duration::from_millis(500), 5);
/// The two stop their searches at different slopes. A difference of estimates may be this share of
/// a standard error, which says nothing to anybody; one of standard errors and degrees of freedom
/// that share of them.
const OF_STD_ERROR: f64 = 2e-3;
const RELATIVE: f64 = 5e-3;
/// The criterion is flat where the search stops.
const CRITERION: f64 = 1e-5;
/// The peer takes at least so many times as long.
const AIM: f64 = 20.0;

/// What R said in one round: case, then what, then values in their order.
type Said = BTreeMap<String, BTreeMap<String, Vec<f64>>>;

pub(crate) fn measure(script: &Path, folder: &Path) -> anyhow::Result<()> {
    let cases: Vec<(Case, Data)> = CASES.into_iter().map(|case| (case, case.data())).collect();
    let files: Vec<PathBuf> =
        CASES.iter().map(|case| case.write(folder)).collect::<Result<_, _>>()?;
    let mut seconds: Vec<Vec<[f64; 2]>> = vec![Vec::new(); cases.len()];
    let mut apart: Vec<Apart> = Vec::new();
    let mut versions = String::new();
    for round in 0..ROUNDS {
        let ours: Vec<f64> =
            cases.iter().map(|(case, data)| time(case, data)).collect::<Result<_, _>>()?;
        let said = ask(script, &files)?;
        if round == 0 {
            apart = cases.iter().map(|of| compare(of, &said)).collect::<Result<_, _>>()?;
            let names = said.get("version").map(|versions| versions.keys().cloned().collect());
            versions = names.unwrap_or_else(Vec::new).join(", ");
        }
        for ((case, _), (of_case, ours)) in cases.iter().zip(seconds.iter_mut().zip(ours)) {
            of_case.push([ours, one(&said, &case.name(), "seconds")?]);
        }
    }
    tell(&cases, &seconds, &apart, &versions);
    Ok(())
}

/// The median time of a fit of ours, s.
fn time(case: &Case, data: &Data) -> anyhow::Result<f64> {
    let mut all = Vec::new();
    let began = Instant::now();
    while all.len() < LEAST.1 || began.elapsed() < LEAST.0 {
        let start = Instant::now();
        std::hint::black_box(fit(case, std::hint::black_box(data))?);
        all.push(start.elapsed().as_secs_f64());
    }
    upper_median(all).context("a fit was timed")
}

fn ask(script: &Path, files: &[PathBuf]) -> anyhow::Result<Said> {
    let output = Command::new("Rscript").arg(script).args(files).output();
    let output = output.context("R is needed, with lme4, pbkrtest and ordinal")?;
    if !output.status.success() {
        bail!("{}: {}", script.display(), String::from_utf8_lossy(&output.stderr));
    }
    let mut said = Said::new();
    for line in String::from_utf8(output.stdout)?.lines() {
        let [case, what, value] = line.split('\t').collect::<Vec<_>>()[..] else {
            bail!("R said '{line}'");
        };
        let of_case = said.entry(case.to_owned()).or_default();
        of_case.entry(what.to_owned()).or_default().push(value.parse()?);
    }
    Ok(said)
}

fn values<'a>(said: &'a Said, case: &str, what: &str) -> anyhow::Result<&'a [f64]> {
    let found = said.get(case).and_then(|of| of.get(what));
    Ok(found.with_context(|| format!("R did not say {what} of {case}"))?)
}

fn one(said: &Said, case: &str, what: &str) -> anyhow::Result<f64> {
    let [value] = values(said, case, what)? else { bail!("{case}: not one {what}") };
    Ok(*value)
}

/// The largest differences of a case.
#[derive(Debug, Clone, Copy, Default)]
struct Apart {
    /// Of estimates, in standard errors.
    estimate: f64,
    /// Of standard errors and of degrees of freedom, relative.
    relative: f64,
}

fn compare((case, data): &(Case, Data), said: &Said) -> anyhow::Result<Apart> {
    let name = &case.name();
    let Found { criterion, estimates, std_errors, df } = fit(case, data)?;
    let theirs = one(said, name, "criterion")?;
    ensure!((criterion - theirs).abs() < CRITERION, "{name}: criterion {criterion}, R {theirs}");
    let (errors, theirs) = (values(said, name, "se")?, values(said, name, "estimate")?);
    ensure!(theirs.len() == estimates.len(), "{name}: another number of estimates");
    let mut apart = Apart::default();
    for ((ours, theirs), error) in estimates.iter().zip(theirs).zip(errors) {
        apart.estimate = apart.estimate.max((ours - theirs).abs() / error);
    }
    let dfs = if df.is_empty() { &[] } else { values(said, name, "df")? };
    ensure!(dfs.len() == df.len(), "{name}: another number of degrees of freedom");
    for (ours, theirs) in std_errors.iter().chain(&df).zip(errors.iter().chain(dfs)) {
        apart.relative = apart.relative.max((ours / theirs - 1.0).abs());
    }
    ensure!(apart.estimate < OF_STD_ERROR && apart.relative < RELATIVE, "{name}: {apart:?}");
    Ok(apart)
}

fn tell(cases: &[(Case, Data)], seconds: &[Vec<[f64; 2]>], apart: &[Apart], versions: &str) {
    println!("{versions}; {ROUNDS} rounds.\n");
    println!(
        "| model | participants × sessions × modes × repeats | zwidth, ms | R, ms | R / zwidth | least \
         and most of the rounds | estimates differ by, of a standard error | standard errors and df \
         differ by |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut least = f64::INFINITY;
    for (((case, _), seconds), apart) in cases.iter().zip(seconds).zip(apart) {
        let ratios: Vec<f64> = seconds.iter().map(|[ours, r]| r / ours).collect();
        let lowest = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = ratios.iter().copied().fold(0.0, f64::max);
        let ratio = upper_median(ratios.iter().copied()).unwrap_or(f64::NAN);
        let [ours_s, theirs_s] = [0, 1]
            .map(|side| upper_median(seconds.iter().map(|both| both[side])).unwrap_or(f64::NAN));
        least = least.min(ratio);
        println!(
            "| {} | {} × {} × 3 × {} | {:.3} | {:.1} | **{:.0}** | {lowest:.0} to {highest:.0} | {:.0e} | {:.0e} |",
            about(case.kind),
            case.participants,
            case.sessions,
            case.repeats,
            1e3 * ours_s,
            1e3 * theirs_s,
            ratio,
            apart.estimate,
            apart.relative,
        );
    }
    let reached = if least >= AIM { "reached" } else { "missed" };
    println!("\nThe aim, {AIM:.0} times in every row: {reached} (least {least:.0}).");
}

fn about(kind: Kind) -> &'static str {
    match kind {
        Kind::Mixed => "mixed model, two contrasts after Kenward–Roger (lme4, pbkrtest)",
        Kind::Ordinal => "cumulative-link mixed model by Laplace (clmm)",
    }
}
