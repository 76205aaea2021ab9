//! Every verdict on scenes whose behaviour is known in closed form, and the page that shows them.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod cases;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use cases::Case;
use rayon::prelude::*;
use zwidth_dynamics::{NAMED_SOLVERS, Reference, RunVerdict};

/// Relative error a step of the adaptive methods.
const TOLERANCE: f64 = 1e-6;

/// A scene, a solver and a step.
struct Cell {
    case: usize,
    solver: &'static str,
    step_s: f64,
    truth: RunVerdict,
    verdict: RunVerdict,
    amplification: f64,
}

fn cells(cases: &[Case]) -> Vec<Cell> {
    let of = |(number, case): (usize, &Case)| {
        let reference = Reference::of(case.model.as_ref());
        let mut cells = Vec::new();
        for named in &NAMED_SOLVERS {
            let solver = (named.make)(TOLERANCE);
            for step_s in case.steps_s {
                let judgement = reference.judge(solver.as_ref(), step_s);
                cells.push(Cell {
                    case: number,
                    solver: named.name,
                    step_s,
                    truth: case.truth(named.name, step_s),
                    verdict: judgement.verdict,
                    amplification: judgement.amplification,
                });
            }
        }
        cells
    };
    cases.par_iter().enumerate().flat_map_iter(of).collect()
}

/// Counts by a truth or a solver, and verdict.
fn counts<'a, K: Ord + Copy>(
    cells: &'a [Cell],
    key: impl Fn(&'a Cell) -> K,
) -> BTreeMap<K, BTreeMap<RunVerdict, usize>> {
    let mut counts: BTreeMap<K, BTreeMap<RunVerdict, usize>> = BTreeMap::new();
    for cell in cells {
        *counts.entry(key(cell)).or_default().entry(cell.verdict).or_default() += 1;
    }
    counts
}

fn table<K: Ord>(
    head: &str,
    rows: &BTreeMap<K, BTreeMap<RunVerdict, usize>>,
    name: impl Fn(&K) -> String,
) -> String {
    let mut text = format!("| {head} |");
    for verdict in RunVerdict::ALL {
        let _ = write!(text, " {} |", verdict.as_str());
    }
    text += "\n|---|";
    text += &"--:|".repeat(RunVerdict::ALL.len());
    for (key, counts) in rows {
        let _ = write!(text, "\n| {} |", name(key));
        for verdict in RunVerdict::ALL {
            match counts.get(&verdict) {
                Some(count) => {
                    let _ = write!(text, " {count} |");
                }
                None => text += " |",
            }
        }
    }
    text + "\n"
}

fn page(cases: &[Case], cells: &[Cell]) -> String {
    let mut text = include_str!("page.md").to_owned();
    let wrong = cells.iter().filter(|cell| cell.verdict != cell.truth).count();
    let _ = write!(
        text,
        "{} scenes × {} solvers × 4 steps = {} runs; {wrong} wrong verdicts, {} times \"cannot \
         tell\".\n\n",
        cases.len(),
        NAMED_SOLVERS.len(),
        cells.len(),
        cells.iter().filter(|cell| cell.verdict == RunVerdict::CannotTell).count(),
    );
    let by_truth = counts(cells, |cell| cell.truth);
    text += &table("truth ↓, verdict →", &by_truth, |truth| truth.as_str().to_owned());
    text += "\nBy solver:\n\n";
    let by_solver = counts(cells, |cell| cell.solver);
    text += &table("solver", &by_solver, |solver| format!("`{solver}`"));
    text +=
        "\n## The scenes\n\n| scene | what the motion is | why | steps, ms |\n|---|---|---|---|\n";
    for case in cases {
        let steps = case.steps_s.map(|h| format!("{:.3}", 1e3 * h)).join(", ");
        let nature = case.nature.as_str();
        let _ = writeln!(text, "| {} | {nature} | {} | {steps} |", case.name, case.reason);
    }
    text
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/verdict.md")
}

#[test]
fn no_verdict_on_a_scene_with_a_known_answer_is_wrong_and_the_page_says_so() {
    let cases = cases::all();
    assert!(cases.len() >= 60, "{}", cases.len());
    let cells = cells(&cases);
    let wrong: Vec<String> = cells
        .iter()
        .filter(|cell| cell.verdict != cell.truth)
        .map(|cell| {
            let case = &cases[cell.case];
            let (step_s, solver) = (cell.step_s, cell.solver);
            let (verdict, truth) = (cell.verdict, cell.truth);
            let name = &case.name;
            format!(
                "{name}: {solver} at {step_s:.3e}: {verdict:?} instead of {truth:?} (|R| {:.4})",
                cell.amplification
            )
        })
        .collect();
    assert!(wrong.is_empty(), "{} wrong of {}:\n{}", wrong.len(), cells.len(), wrong.join("\n"));
    let unknown = cells.iter().filter(|cell| cell.verdict == RunVerdict::CannotTell);
    assert!(20 * unknown.count() <= cells.len());
    let written = std::fs::read_to_string(path()).unwrap_or_default();
    assert!(
        written == page(&cases, &cells),
        "docs/verdict.md is not what a fresh run gives: \
         cargo test -p zwidth-dynamics --test verdict -- --ignored"
    );
}

#[test]
#[ignore = "writes docs/verdict.md anew"]
fn write_the_page() {
    let cases = cases::all();
    std::fs::write(path(), page(&cases, &cells(&cases))).unwrap();
}
