//! `cargo xtask bits`: the main job gives the same bytes on one thread and on many, on processors with and without
//! vector units, and those that were written down when a number was last meant to change.

use anyhow::{Context as _, bail};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;
use zwidth_store::hex_blake3;

/// The study that comes along.
const STUDY: &str = "thesis-twin";
/// Where the hashes are written down, in the form of `b3sum`.
const WRITTEN: &str = "tests/thesis-twin.b3";
/// More threads than most machines have processors: the order in which jobs end is another one each time.
const MANY: &str = "16";
/// User-mode emulation (Debian: qemu-user), and processors it can be. The libraries below us choose their kernels by
/// what a processor says it can do: the first has no SSSE3, SSE4, AVX or FMA, the second has AVX2 and FMA but no AVX-512.
const EMULATOR: &str = "qemu-x86_64";
const PROCESSORS: [&str; 2] = ["qemu64", "Haswell"];
/// At most so many files are named that differ.
const NAMED: usize = 10;

/// Hash of each file below `derived/` and `reports/`, by its path.
type Hashes = BTreeMap<String, String>;

/// Runs the job in each way and compares what it made with what is written down; with `renew`, writes it down.
pub(crate) fn compare(program: &Path, scratch: &Path, renew: bool) -> anyhow::Result<()> {
    let native = |threads: &'static str| (format!("{threads} thread(s)"), plain(program), threads);
    let emulated = PROCESSORS.iter().map(|cpu| (format!("a {cpu} processor"), under(cpu, program), MANY));
    let ways = [native("1"), native(MANY)].into_iter().chain(emulated.filter(|_| !renew));
    let written = Path::new(WRITTEN);
    let mut first: Option<Hashes> = if renew { None } else { Some(read(written)?) };
    for (way, command, threads) in ways {
        let started = Instant::now();
        let made = hashes(command, &scratch.join("bits"), threads).with_context(|| format!("with {way}"))?;
        println!("{way}: {} files in {:.0} s", made.len(), started.elapsed().as_secs_f64());
        match &first {
            Some(first) => same(first, &made).with_context(|| format!("with {way}"))?,
            None => first = Some(made),
        }
    }
    std::fs::remove_dir_all(scratch)?;
    if renew {
        std::fs::write(written, text(&first.unwrap_or_default()))?;
        println!("wrote {WRITTEN}");
    }
    Ok(())
}

fn plain(program: &Path) -> Command {
    Command::new(program)
}

fn under(processor: &str, program: &Path) -> Command {
    let mut command = Command::new(EMULATOR);
    command.args(["-cpu", processor]).arg(program);
    command
}

/// Makes everything anew in a root of its own, which holds a copy of the raw data.
fn hashes(mut command: Command, root: &Path, threads: &str) -> anyhow::Result<Hashes> {
    if root.exists() {
        std::fs::remove_dir_all(root)?;
    }
    let raw = Path::new("raw").join(STUDY);
    for file in files(&raw)? {
        let copy = root.join(&file);
        std::fs::create_dir_all(copy.parent().unwrap_or(root))?;
        std::fs::copy(&file, copy)?;
    }
    command.arg("--root").arg(root).args(["--threads", threads, "--quiet", "run", "--fresh", STUDY]);
    let Output { status, stderr, .. } =
        command.output().with_context(|| format!("{:?}; is it installed?", command.get_program()))?;
    if !status.success() {
        bail!("zwidth run ended with {status}\n{}", String::from_utf8_lossy(&stderr));
    }
    let mut hashes = Hashes::new();
    for file in
        ["derived", "reports"].iter().map(|f| files(&root.join(f))).collect::<Result<Vec<_>, _>>()?.concat()
    {
        let path = file.strip_prefix(root)?.to_string_lossy().into_owned();
        hashes.insert(path, hex_blake3(&std::fs::read(&file)?));
    }
    Ok(hashes)
}

/// Every file below a folder.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else {
            found.push(path);
        }
    }
    Ok(found)
}

/// An error that names the files that differ.
fn same(expected: &Hashes, made: &Hashes) -> anyhow::Result<()> {
    let paths: std::collections::BTreeSet<&String> = expected.keys().chain(made.keys()).collect();
    let told = |path: &&&String| match (expected.get(**path), made.get(**path)) {
        (Some(_), None) => format!("{path} was not made"),
        (None, Some(_)) => format!("{path} is new"),
        _ => format!("{path} has other bytes"),
    };
    let differ: Vec<&&String> = paths.iter().filter(|p| expected.get(**p) != made.get(**p)).collect();
    if differ.is_empty() {
        return Ok(());
    }
    let named: Vec<String> = differ.iter().take(NAMED).map(told).collect();
    bail!(
        "{} of {} files differ from {WRITTEN}; where that is meant, `cargo xtask bits renew` writes them down:\n{}",
        differ.len(),
        paths.len(),
        named.join("\n")
    )
}

fn read(file: &Path) -> anyhow::Result<Hashes> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let line = |line: &str| line.split_once("  ").map(|(hash, path)| (path.to_owned(), hash.to_owned()));
    text.lines()
        .map(|l| line(l).with_context(|| format!("{}: not a line of b3sum: {l}", file.display())))
        .collect()
}

fn text(hashes: &Hashes) -> String {
    hashes.iter().fold(String::new(), |mut text, (path, hash)| {
        let _ = writeln!(text, "{hash}  {path}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[(&str, &str)]) -> Hashes {
        files.iter().map(|(path, hash)| ((*path).to_owned(), (*hash).to_owned())).collect()
    }

    #[test]
    fn what_is_written_down_reads_back() {
        let file = std::env::temp_dir().join(format!("zwidth-bits-{}.b3", std::process::id()));
        let hashes = of(&[("derived/a b.parquet", "00ff"), ("reports/θ.svg", "12ab")]);
        std::fs::write(&file, text(&hashes)).unwrap();
        assert_eq!(read(&file).unwrap(), hashes);
        std::fs::remove_file(file).unwrap();
    }

    #[test]
    fn a_file_that_is_other_new_or_missing_is_named() {
        let expected = of(&[("a", "1"), ("b", "2"), ("c", "3")]);
        assert!(same(&expected, &expected.clone()).is_ok());
        let told = same(&expected, &of(&[("a", "1"), ("b", "9"), ("d", "3")])).unwrap_err().to_string();
        assert!(told.contains("3 of 4 files differ"), "{told}");
        for words in ["b has other bytes", "c was not made", "d is new"] {
            assert!(told.contains(words), "{told}");
        }
    }
}
