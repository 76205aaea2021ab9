//! `cargo xtask bits`: the main job gives the same bytes on one thread and on many, and on
//! processors with and without vector units. Apart from their origin, the files are those whose
//! hashes were written down at the last intended change, with the versions of the stages that made
//! them. A stage whose content changes must raise its version.

use crate::shell::{Hashes, hashed, lay_down, program, remove, scratch};
use anyhow::{Context as _, bail, ensure};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;
use zwidth_store::hex_blake3;

/// The study that comes along.
const STUDY: &str = "thesis-twin";
/// Where that is written down: a stage a line, with its version, the number of its files and one hash of them all.
const WRITTEN: &str = "tests/thesis-twin.b3";
/// More threads than most machines have processors: the order in which jobs end is another one each
/// time.
const MANY: &str = "16";
/// User-mode emulation (Debian: qemu-user), and processors it can be. The libraries below us choose
/// their kernels by what a processor says it can do: the first has no SSSE3, SSE4, AVX or FMA, the
/// second has AVX2 and FMA but no AVX-512.
const EMULATOR: &str = "qemu-x86_64";
const PROCESSORS: [&str; 2] = ["qemu64", "Haswell"];
/// At most so many files are named that differ.
const NAMED: usize = 10;

/// What is written down, by stage.
type Written = BTreeMap<String, Content>;

/// What a stage made, without its origin. PNG and PDF, which are drawn from the SVG's shapes, and
/// the records are left out: they are compared within one run.
#[derive(Debug, Clone, PartialEq)]
struct Content {
    version: u32,
    files: usize,
    /// Of the hashes and paths of its files, in the order of the paths.
    hash: String,
}

/// Runs the job in each way and compares what it made with what is written down; with `renew`,
/// writes it down. With `without_origin`, only compares the content with what is written down.
pub(crate) fn compare(how: How) -> anyhow::Result<()> {
    let program = program()?;
    let root = scratch("bits");
    if how == How::AllWays {
        let native = |threads: &'static str| {
            (format!("{threads} thread(s)"), Command::new(&program), threads)
        };
        let emulated = PROCESSORS.into_iter().map(|cpu| {
            let mut command = Command::new(EMULATOR);
            command.args(["-cpu", cpu]).arg(&program);
            (format!("a {cpu} processor"), command, MANY)
        });
        let mut first: Option<Hashes> = None;
        for (way, command, threads) in [native("1"), native(MANY)].into_iter().chain(emulated) {
            let started = Instant::now();
            let made =
                hashes(command, &root, threads, &[]).with_context(|| format!("with {way}"))?;
            println!("{way}: {} files in {:.0} s", made.len(), started.elapsed().as_secs_f64());
            match &first {
                Some(first) => same(first, &made).with_context(|| format!("with {way}"))?,
                None => first = Some(made),
            }
        }
    }
    let made = hashes(Command::new(&program), &root, MANY, &["--without-origin"])?;
    let made = content(&root, &made)?;
    std::fs::remove_dir_all(&root)?;
    let written = Path::new(WRITTEN);
    let before = if written.exists() { read(written)? } else { Written::default() };
    not_raised(&before, &made)?;
    if how == How::Renew {
        std::fs::write(written, text(&made))?;
        println!("wrote {WRITTEN}");
        return Ok(());
    }
    unchanged(&before, &made)?;
    let files: usize = made.values().map(|stage| stage.files).sum();
    println!("without origin: {files} files of {} stages, as written down", made.len());
    Ok(())
}

/// What [`compare`] does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum How {
    /// Every way, and then the content.
    AllWays,
    /// The content alone.
    WithoutOrigin,
    /// The content, which is written down.
    Renew,
}

/// Makes everything anew in a root of its own, which holds a copy of the raw data.
fn hashes(
    mut command: Command,
    root: &Path,
    threads: &str,
    options: &[&str],
) -> anyhow::Result<Hashes> {
    remove(root)?;
    let raw = Path::new("raw").join(STUDY);
    lay_down(&raw, &root.join(&raw), std::fs::copy)?;
    command.arg("--root").arg(root).args(["--threads", threads, "--quiet", "run", "--fresh"]);
    command.args(options).arg(STUDY);
    let Output { status, stderr, .. } = command
        .output()
        .with_context(|| format!("{:?}; is it installed?", command.get_program()))?;
    if !status.success() {
        bail!("zwidth run ended with {status}\n{}", String::from_utf8_lossy(&stderr));
    }
    hashed(root)
}

/// What was made, by the stages that the records of that run name.
fn content(root: &Path, hashes: &Hashes) -> anyhow::Result<Written> {
    let records = std::fs::read(root.join("derived").join(STUDY).join("records.json"))?;
    let records: BTreeMap<String, Record> = serde_json::from_slice(&records)?;
    let mut made: BTreeMap<String, (u32, BTreeMap<String, &String>)> = BTreeMap::new();
    for Record { stage, version, outputs } in records.into_values() {
        let (_, files) = made.entry(stage).or_insert_with(|| (version, BTreeMap::new()));
        for path in outputs.into_keys().filter(|p| !p.ends_with(".png") && !p.ends_with(".pdf")) {
            let hash = hashes.get(&path).with_context(|| format!("{path} was not made"))?;
            files.insert(path, hash);
        }
    }
    let mut written = Written::new();
    for (stage, (version, files)) in made {
        let lines: String = files.iter().map(|(path, hash)| format!("{hash}  {path}\n")).collect();
        let hash = hex_blake3(lines.as_bytes());
        written.insert(stage, Content { version, files: files.len(), hash });
    }
    Ok(written)
}

/// What of a record is needed here.
#[derive(serde::Deserialize)]
struct Record {
    stage: String,
    version: u32,
    outputs: BTreeMap<String, String>,
}

/// An error that names the files that differ.
fn same(expected: &Hashes, made: &Hashes) -> anyhow::Result<()> {
    let paths: BTreeSet<&String> = expected.keys().chain(made.keys()).collect();
    let differ = paths.iter().filter_map(|path| match (expected.get(*path), made.get(*path)) {
        (Some(_), None) => Some(format!("{path} was not made")),
        (None, _) => Some(format!("{path} is new")),
        (was, is) => (was != is).then(|| format!("{path} has other bytes")),
    });
    let differ: Vec<String> = differ.collect();
    let named: Vec<&str> = differ.iter().take(NAMED).map(String::as_str).collect();
    ensure!(
        differ.is_empty(),
        "{} of {} files differ:\n{}",
        differ.len(),
        paths.len(),
        named.join("\n")
    );
    Ok(())
}

/// An error that names the stages whose files have another content, at the same version.
fn not_raised(before: &Written, made: &Written) -> anyhow::Result<()> {
    let is_other = |was: &Content, now: &Content| was.version == now.version && was != now;
    let other =
        made.iter().filter(|(stage, now)| before.get(*stage).is_some_and(|was| is_other(was, now)));
    let other: Vec<&str> = other.map(|(stage, _)| stage.as_str()).collect();
    ensure!(
        other.is_empty(),
        "files of these stages have another content, and the versions of the stages are the same; where that is \
         meant, raise their VERSION: {}",
        other.join(", ")
    );
    Ok(())
}

/// An error that names the stages that differ from what is written down.
fn unchanged(before: &Written, made: &Written) -> anyhow::Result<()> {
    let stages: BTreeSet<&String> = before.keys().chain(made.keys()).collect();
    let differ = stages.into_iter().filter(|stage| before.get(*stage) != made.get(*stage));
    let differ: Vec<&str> = differ.map(String::as_str).collect();
    ensure!(
        differ.is_empty(),
        "{} differ from {WRITTEN}; where that is meant, `cargo xtask bits renew` writes it down",
        differ.join(", ")
    );
    Ok(())
}

fn read(file: &Path) -> anyhow::Result<Written> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let mut written = Written::new();
    for line in text.lines() {
        let parts: Vec<&str> = line.split(' ').collect();
        let [stage, version, files, hash] = parts[..] else {
            bail!("{}: {line}: not a stage, its version, files and hash", file.display());
        };
        let content =
            Content { version: version.parse()?, files: files.parse()?, hash: hash.to_owned() };
        written.insert(stage.to_owned(), content);
    }
    Ok(written)
}

fn text(written: &Written) -> String {
    let mut text = String::new();
    for (stage, Content { version, files, hash }) in written {
        let _ = writeln!(text, "{stage} {version} {files} {hash}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hashes(files: &[(&str, &str)]) -> Hashes {
        files.iter().map(|(path, hash)| ((*path).to_owned(), (*hash).to_owned())).collect()
    }

    fn content(version: u32, hash: &str) -> Written {
        let stage = |version, hash: &str| Content { version, files: 2, hash: hash.to_owned() };
        [("likert".to_owned(), stage(2, "12ab")), ("metrics".to_owned(), stage(version, hash))]
            .into()
    }

    #[test]
    fn what_is_written_down_reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("written.b3");
        std::fs::write(&file, text(&content(1, "00ff"))).unwrap();
        assert_eq!(read(&file).unwrap(), content(1, "00ff"));
    }

    #[test]
    fn a_file_that_is_other_new_or_missing_is_named() {
        let expected = hashes(&[("a", "1"), ("b", "2"), ("c", "3")]);
        assert!(same(&expected, &expected.clone()).is_ok());
        let told = same(&expected, &hashes(&[("a", "1"), ("b", "9"), ("d", "3")]))
            .unwrap_err()
            .to_string();
        assert!(told.contains("3 of 4 files differ"), "{told}");
        for words in ["b has other bytes", "c was not made", "d is new"] {
            assert!(told.contains(words), "{told}");
        }
    }

    #[test]
    fn a_stage_whose_content_changes_has_to_raise_its_version() {
        let before = content(1, "00");
        assert!(not_raised(&before, &before).is_ok() && unchanged(&before, &before).is_ok());
        let told = not_raised(&before, &content(1, "11")).unwrap_err().to_string();
        assert!(told.ends_with("VERSION: metrics"), "{told}");
        assert!(not_raised(&before, &content(2, "11")).is_ok());
        for other in [content(2, "11"), content(2, "00")] {
            assert!(unchanged(&before, &other).is_err());
        }
        assert!(not_raised(&Written::default(), &before).is_ok());
    }
}
