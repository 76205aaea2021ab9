//! `cargo xtask bench`: every bench beside its peers, in one table, and whether a ratio became
//! worse than the committed one. The ratio says how many times as long the peer takes. Both run on
//! the same machine at nearly the same time, so ratios from different machines can be compared.

mod benches;
mod case;
mod table;

use crate::shell::{files, target};
use anyhow::{Context as _, ensure};
use benches::{ALONE, BENCHES, Bench, PRELUDE};
use case::{Case, listed, read_back};
use std::fs;
use std::path::Path;
use std::process::Command;

const RESULTS: &str = "benches/RESULTS.md";
/// A ratio that is a tenth smaller than the committed one is a regression.
const REGRESSION: f64 = 0.9;

/// Runs these benches, or all of them; or, with `read` as the first word, takes what each of them
/// measured the last time. Writes the table and compares it with the committed one.
pub(crate) fn bench(words: &[&str]) -> anyhow::Result<()> {
    let (runs, names) = match words {
        ["short", names @ ..] => return short(names),
        ["read", names @ ..] => (false, names),
        names => (true, names),
    };
    let names_of_all = BENCHES.map(|bench| bench.name).join(", ");
    for name in names {
        let is_one = BENCHES.iter().any(|bench| bench.name == *name);
        ensure!(is_one, "there is no bench {name:?}; there are {names_of_all}");
    }
    let chosen = |bench: &Bench| names.is_empty() || names.contains(&bench.name);
    let page = fs::read_to_string(RESULTS);
    let (before, told) = page.map_or_else(|_| Default::default(), |text| read_back(&text));
    let mut cases = Vec::new();
    let mut machines = Vec::new();
    let mut wrong = Vec::new();
    for bench in &BENCHES {
        let measured = if chosen(bench) { measured(bench, runs) } else { Ok(None) };
        let found = measured.unwrap_or_else(|error| {
            wrong.push(format!("{error:#}"));
            None
        });
        // Those that are not run stay as they are.
        let stays = || (of(bench.name, &before), told.get(bench.name).cloned());
        let (found, machine) = found.unwrap_or_else(stays);
        machines.extend(machine.map(|machine| (bench.name, machine)));
        cases.extend(found);
    }
    fs::write(RESULTS, case::page(&cases, &machines))?;
    println!("{RESULTS} has {} cases", cases.len());
    match committed() {
        Some(committed) => {
            let held: Vec<&Bench> = BENCHES.iter().filter(|b| b.is_held && chosen(b)).collect();
            wrong.extend(
                held.iter().flat_map(|b| worse(&of(b.name, &committed), &of(b.name, &cases))),
            );
        }
        None => println!("no table is committed: nothing is compared"),
    }
    ensure!(wrong.is_empty(), "{} benches or ratios:\n{}", wrong.len(), wrong.join("\n"));
    println!("no ratio is more than a tenth below the committed one, where there is one");
    Ok(())
}

/// Runs these benches, or all, once on little: so that none breaks unseen. What they measure means nothing, and every page
/// of results is put back.
fn short(names: &[&str]) -> anyhow::Result<()> {
    let all: Vec<(&str, &str)> =
        BENCHES.iter().map(|bench| (bench.name, bench.short)).chain(ALONE).collect();
    for name in names {
        ensure!(all.iter().any(|(own, _)| own == name), "there is no bench {name:?}");
    }
    let pages =
        files(Path::new("benches"))?.into_iter().filter(|page| page.ends_with("RESULTS.md"));
    let kept =
        pages.map(|page| Ok((fs::read(&page)?, page))).collect::<anyhow::Result<Vec<_>>>()?;
    let chosen = all.iter().filter(|(name, _)| names.is_empty() || names.contains(name));
    let wrong: Vec<String> = chosen
        .filter_map(|(name, line)| run(name, line).err().map(|error| format!("{error:#}")))
        .collect();
    for (bytes, page) in kept {
        fs::write(&page, bytes)?;
    }
    ensure!(wrong.is_empty(), "{} benches:\n{}", wrong.len(), wrong.join("\n"));
    println!("every bench runs");
    Ok(())
}

/// Runs a bench's line.
fn run(name: &str, line: &str) -> anyhow::Result<()> {
    println!("== {name}");
    let status = Command::new("sh").args(["-euc", &format!("{PRELUDE}{line}")]).status();
    let status = status.with_context(|| format!("cannot run `{line}`"))?;
    ensure!(status.success(), "the bench {name} failed ({status}): `{line}`");
    Ok(())
}

/// Cases, and the machine that they were measured on.
type Measured = (Vec<Case>, Option<String>);

/// What a bench measured, and on which machine; nothing where it was never run.
fn measured(bench: &Bench, runs: bool) -> anyhow::Result<Option<Measured>> {
    if runs {
        run(bench.name, bench.line)?;
    }
    let mut found = (bench.read)(&target())?;
    if found.is_empty() {
        ensure!(!runs, "the bench {} ran, and what it measured was not found", bench.name);
        println!("{}: never run here", bench.name);
        return Ok(None);
    }
    found.iter_mut().for_each(|case| case.bench = bench.name.to_owned());
    let machine = match bench.machine {
        Some((page, part)) => table::machines(&fs::read_to_string(page)?).into_iter().nth(part),
        None => Some(this_machine()),
    };
    Ok(Some((found, machine)))
}

/// The cases of one bench.
fn of(bench: &str, cases: &[Case]) -> Vec<Case> {
    cases.iter().filter(|case| case.bench == bench).cloned().collect()
}

/// The table as it is committed; none if there is none.
fn committed() -> Option<Vec<Case>> {
    let output = Command::new("git").args(["show", &format!("HEAD:{RESULTS}")]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(read_back(&text).0)
}

/// Which of the committed ratios of a bench became worse, in words.
fn worse(committed: &[Case], now: &[Case]) -> Vec<String> {
    let one = |before: &Case| {
        let Some(after) =
            now.iter().find(|now| (&now.case, &now.beside) == (&before.case, &before.beside))
        else {
            return Some(format!(
                "{}: {} beside {} is no longer measured",
                before.bench, before.case, before.beside
            ));
        };
        (after.ratio() < REGRESSION * before.ratio()).then(|| {
            let was = listed(before.ratio());
            let is = listed(after.ratio());
            format!(
                "{}: {}: {} took {was} times as long, now {is}",
                before.bench, before.case, before.beside
            )
        })
    };
    committed.iter().filter_map(one).collect()
}

/// Processor, cores and compiler of this machine.
fn this_machine() -> String {
    let rustc = Command::new("rustc").arg("--version").output();
    let rustc =
        rustc.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned()).unwrap_or_default();
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load: Vec<&str> = load.split(' ').take(3).collect();
    let arch = std::env::consts::ARCH;
    format!("{arch}, {cores} cores, {rustc}; load average at the end {}", load.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(name: &str, peer_s: f64) -> Case {
        let (bench, case, beside) = ("b".to_owned(), name.to_owned(), "R".to_owned());
        Case { bench, case, beside, ours_s: 1.0, peer_s }
    }

    #[test]
    fn a_ratio_more_than_a_tenth_below_the_committed_one_is_worse_and_so_is_one_that_is_gone() {
        let committed = [case("a", 10.0), case("b", 10.0), case("c", 10.0)];
        let worse = worse(&committed, &[case("a", 9.1), case("b", 8.9), case("d", 1.0)]);
        assert_eq!(worse.len(), 2, "{worse:?}");
        assert!(worse[0].contains("b: b: R took 10.0 times as long, now 8.90"), "{worse:?}");
        assert!(worse[1].contains("c beside R is no longer measured"), "{worse:?}");
    }
}
