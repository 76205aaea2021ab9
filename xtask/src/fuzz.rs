//! `cargo xtask fuzz`: arbitrary bytes in the place of each file that is read (`fuzz/`).
//!
//! libFuzzer is guided by counters that LLVM puts on every edge. With these flags a stable compiler
//! adds them too.

use crate::shell::{cargo, target};
use crate::tried::note;
use anyhow::{Context as _, bail, ensure};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use zwidth_import::readers::readers;

/// The counters of libFuzzer: which edges were taken, and which numbers were compared.
const COUNTERS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=4";
const HOST: &str = "x86_64-unknown-linux-gnu";

/// A target, what people call its file, the runs that it gets, and the longest input in bytes.
struct Kind {
    name: &'static str,
    about: String,
    runs: u64,
    longest: u32,
}

const TEXT: u64 = 10_000_000;
const BINARY: u64 = 1_000_000;

/// Every target: our own files, then the formats of others.
fn kinds() -> Vec<Kind> {
    let ours = [
        // Mending tries each bit of a frame, which takes time by the square of its length.
        ("journal", "a trial's journal", TEXT, 1024),
        ("events", "a session's log", TEXT, 4096),
        ("head", "the head of a log, and its log", TEXT, 4096),
        ("record", "a session's record", TEXT, 4096),
        ("records", "the runner's records.json", TEXT, 4096),
        ("study", "study.toml", BINARY, 4096),
        ("calibration", "calibration.toml", BINARY, 1024),
        ("mapping", "a mapping file", BINARY, 4096),
        ("scene", "a scene", BINARY, 4096),
        ("twin", "twin.toml", BINARY, 1024),
        ("trial", "a trial's Parquet file", BINARY, 16_384),
        ("sweep", "a sweep's Parquet file", BINARY, 16_384),
        ("whole", "any text file of a study, and what verify says of it", BINARY, 4096),
        ("wire", "what a board and its host send", TEXT, 1024),
        ("firmata", "what a board that speaks Firmata and its host send", TEXT, 512),
        ("lines", "what a board that prints lines and its host send", TEXT, 512),
        ("participant", "what a participant's screen and its session send", TEXT, 1024),
    ];
    let ours = ours.map(|(name, about, runs, longest)| {
        let about = about.to_owned();
        Kind { name, about, runs, longest }
    });
    let theirs = readers().map(|reader| {
        let about = format!("{} to be imported", reader.name());
        let (runs, longest) = if reader.is_packed() { (BINARY, 8192) } else { (TEXT, 4096) };
        Kind { name: reader.word(), about, runs, longest }
    });
    ours.into_iter().chain(theirs).collect()
}

/// Targets at once.
const AT_ONCE: usize = 2;

/// Memory that a reader may have, MiB, and the time that it may take for one input, s.
const MOST_MEMORY: &str = "1024";
const MOST_TIME: &str = "10";

/// Fuzzes one target or `all`, each with so many runs or its own number.
pub(crate) fn fuzz(which: &str, runs: Option<u64>) -> anyhow::Result<()> {
    let kinds = kinds();
    let chosen: Vec<&Kind> =
        kinds.iter().filter(|kind| which == "all" || kind.name == which).collect();
    if chosen.is_empty() && which != "seeds" {
        let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
        bail!("'{which}' is no target; there are all, {}", names.join(", "));
    }
    for kind in &chosen {
        let seeds = seeds(kind.name);
        ensure!(seeds.is_dir(), "{} is not there: cargo xtask fuzz seeds", seeds.display());
    }
    let program = build()?;
    if which == "seeds" {
        let written = Command::new(&program).env("ZWIDTH_FUZZ", "seeds").status()?;
        ensure!(written.success(), "the seeds cannot be written");
        return Ok(());
    }
    let tried = |kind: &&Kind| tell(&program, kind, runs.unwrap_or(kind.runs));
    let threads = rayon::ThreadPoolBuilder::new().num_threads(AT_ONCE).build()?;
    let told: anyhow::Result<Vec<bool>> =
        threads.install(|| chosen.par_iter().with_max_len(1).map(tried).collect());
    let broken = told?.into_iter().filter(|is_broken| *is_broken).count();
    ensure!(
        broken == 0,
        "{broken} targets have a finding: mend it, and keep the input below fuzz/seeds"
    );
    Ok(())
}

/// Where a target's seeds lie.
fn seeds(target: &str) -> PathBuf {
    Path::new("fuzz/seeds").join(target)
}

/// Runs one target, says and notes what came of it; whether it has a finding.
fn tell(program: &Path, kind: &Kind, runs: u64) -> anyhow::Result<bool> {
    let began = Instant::now();
    let found = one(program, kind, runs)?;
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "{:<12} {runs:>9} runs in {seconds:>6.0} s: {}",
        kind.name,
        found.as_deref().unwrap_or("no finding")
    );
    let what = format!("any bytes as {}", kind.about);
    let command = format!("cargo xtask fuzz {} {runs}", kind.name);
    note(&what, command, runs, u64::from(found.is_some()), began)?;
    Ok(found.is_some())
}

fn target_folder() -> PathBuf {
    target().join("fuzz")
}

fn build() -> anyhow::Result<PathBuf> {
    let folder = target_folder();
    cargo(
        "build --release --quiet --locked --manifest-path fuzz/Cargo.toml --target",
        &[HOST],
        &[("RUSTFLAGS", COUNTERS.to_owned()), ("CARGO_TARGET_DIR", folder.display().to_string())],
        "the fuzz targets do not build; they need a C++ compiler",
    )?;
    Ok(folder.join(HOST).join("release/fuzz"))
}

/// Runs a target from its seeds on; what it found, in words.
fn one(program: &Path, kind: &Kind, runs: u64) -> anyhow::Result<Option<String>> {
    let corpus = target_folder().join("corpus").join(kind.name);
    std::fs::create_dir_all(&corpus)?;
    let seeds = seeds(kind.name);
    let findings = target_folder().join(format!("finding-{}-", kind.name));
    let counts = format!("-runs={runs} -max_len={} -seed=1", kind.longest);
    let limits = format!("-rss_limit_mb={MOST_MEMORY} -malloc_limit_mb={MOST_MEMORY}");
    let more = format!("-timeout={MOST_TIME} -print_final_stats=1 -verbosity=0");
    let output = Command::new(program)
        .env("ZWIDTH_FUZZ", kind.name)
        .arg(&corpus)
        .arg(&seeds)
        .args([counts, limits, more].iter().flat_map(|line| line.split(' ')))
        .arg(format!("-artifact_prefix={}", findings.display()))
        .output()
        .with_context(|| format!("{} does not run", program.display()))?;
    if output.status.success() {
        return Ok(None);
    }
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let telling = |line: &&str| {
        ["panicked", "ERROR", "written to", "is no target"].iter().any(|w| line.contains(w))
    };
    let lines: Vec<&str> = said.lines().filter(telling).collect();
    Ok(Some(if lines.is_empty() { said } else { lines.join("; ") }))
}

#[cfg(test)]
mod tests {
    use super::{kinds, seeds};
    use std::path::Path;

    /// A reader that is added has its target by itself, but not what a fuzzer begins from.
    #[test]
    fn every_target_has_seeds() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for kind in kinds() {
            assert!(root.join(seeds(kind.name)).is_dir(), "cargo xtask fuzz seeds: {}", kind.name);
        }
    }
}
