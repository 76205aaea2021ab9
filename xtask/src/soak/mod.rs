//! `cargo xtask soak`: checks that take too long for the tests; CI runs a short version of them.

#[cfg(unix)]
mod cable;
pub(crate) mod compared;
pub(crate) mod coverage;
pub(crate) mod extremes;
pub(crate) mod faults;
pub(crate) mod judge;
pub(crate) mod kill;
pub(crate) mod kill_tasks;
pub(crate) mod live;
pub(crate) mod loops;
pub(crate) mod mistakes;
pub(crate) mod properties;
pub(crate) mod simulate;
pub(crate) mod statistics;
#[cfg(unix)]
pub(crate) mod terminals;
pub(crate) mod thesis;
#[cfg(unix)]
pub(crate) mod watchdog;
pub(crate) mod wire;

use crate::shell::{remove, words};
use anyhow::{Context as _, bail, ensure};
use rayon::prelude::*;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use zwidth_store::{Layout, RealFiles, hex_blake3, write_new};
use zwidth_study::{StudyId, template};

/// The study of every soak, and its one session.
const STUDY: &str = "soak";
const SESSION: &str = "-p P01 -s S01";
/// The rate of the study that comes along, Hz: as slow as a movement can be read from, so that many
/// sessions take little time.
const RATE: &str = "120";

/// A fresh root with a study: the template with these replacements.
fn fresh(root: &Path, changes: &[(&str, &str)]) -> anyhow::Result<Layout> {
    remove(root)?;
    let id = StudyId::new(STUDY)?;
    let text = changed(template(&id), changes)?;
    let layout = Layout::new(root, id);
    write_new(&RealFiles, &layout.study_toml(), text.as_bytes())?;
    Ok(layout)
}

/// The text of a study with these replacements.
pub(crate) fn changed(text: String, changes: &[(&str, &str)]) -> anyhow::Result<String> {
    changes.iter().try_fold(text, |text, (from, to)| {
        ensure!(text.contains(from), "the template of a study lost '{from}'");
        Ok(text.replace(from, to))
    })
}

/// Simulates one session of one person of a seed.
fn twin(program: &Path, root: &Path, seed: u32) -> anyhow::Result<()> {
    let people = "--participants 1 --sessions 1";
    let line = format!("--quiet twin {STUDY} {people} --seed {seed} --rate {RATE}");
    run(program, root, &words(&line), &[0]).map(drop)
}

/// What each of so many seeds, from 1 on, gives in a folder of its own; two of them at once: one
/// writes while another computes.
fn of_seeds<T: Send>(
    folder: &Path,
    seeds: u32,
    one: impl Fn(&Path, u32) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let whole = |before: u32| -> anyhow::Result<T> {
        let seed = before + 1;
        let root = folder.join(format!("seed-{seed}"));
        let found = one(&root, seed).with_context(|| format!("seed {seed}"))?;
        remove(&root)?;
        Ok(found)
    };
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    two.install(|| (0..seeds).into_par_iter().with_max_len(1).map(whole).collect())
}

/// Runs the program on a root and returns what it said; an exit code that is not allowed is an
/// error.
pub(crate) fn run(
    program: &Path,
    root: &Path,
    arguments: &[&str],
    allowed: &[i32],
) -> anyhow::Result<Output> {
    let output = Command::new(program).arg("--root").arg(root).args(arguments).output()?;
    let code = output.status.code();
    if !code.is_some_and(|code| allowed.contains(&code)) {
        let told = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        bail!(
            "zwidth {arguments:?} ended with {code:?}\n{}\n{}",
            told(&output.stdout),
            told(&output.stderr)
        );
    }
    Ok(output)
}

/// Starts the program on a root; nobody answers it, and what it says can be heard.
fn started(program: &Path, root: &Path, line: &str) -> std::io::Result<Child> {
    let mut command = Command::new(program);
    command.arg("--root").arg(root).args(words(line));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()
}

/// The most hits of `n`, each with probability `hit`, down to which the chance of as many or more is
/// what is asked for; 0 if it never is.
fn most_hits(n: usize, hit: f64, is_reached: impl Fn(f64) -> bool) -> usize {
    // from all of them down: the chance of k misses
    let mut probability = hit.powi(n as i32);
    let mut reached = 0.0;
    for misses in 0..=n {
        reached += probability;
        if is_reached(reached) {
            return n - misses;
        }
        let k = misses as f64;
        probability *= (n as f64 - k) / (k + 1.0) * (1.0 - hit) / hit;
    }
    0
}

/// A number in [0, 1) that follows from words.
fn fraction(words: &str) -> anyhow::Result<f64> {
    let bits = u64::from_str_radix(&hex_blake3(words.as_bytes())[..13], 16)?;
    Ok(bits as f64 / 2_f64.powi(52))
}
