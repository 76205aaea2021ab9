//! `cargo xtask bits`: the main job gives the same bytes on one thread and on many, and on
//! processors with and without vector units. Without what files say of their making these are the
//! bytes that were written down when a number was last meant to change, with the versions of the
//! stages that made them: a stage whose content changes has to raise its version.

use anyhow::{Context as _, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;
use zwidth_store::hex_blake3;

/// The study that comes along.
const STUDY: &str = "thesis-twin";
/// Where the hashes are written down, in the form of `b3sum`, below the versions of the stages.
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

/// Hash of each file below `derived/` and `reports/`, by its path.
type Hashes = BTreeMap<String, String>;

/// What is written down: each stage's version, and the files that it made, without their origin.
#[derive(Debug, Default, Clone, PartialEq)]
struct Content {
    /// By stage.
    versions: BTreeMap<String, u32>,
    /// By path: the stage, and the hash. PNG and PDF, which are drawn from the SVG's shapes, and
    /// the records are left out: they are compared within one run.
    files: BTreeMap<String, (String, String)>,
}

/// Runs the job in each way and compares what it made with what is written down; with `renew`,
/// writes it down. With `without_origin`, only compares the content with what is written down.
pub(crate) fn compare(program: &Path, scratch: &Path, how: How) -> anyhow::Result<()> {
    let root = scratch.join("bits");
    if how == How::AllWays {
        let native =
            |threads: &'static str| (format!("{threads} thread(s)"), plain(program), threads);
        let emulated =
            PROCESSORS.iter().map(|cpu| (format!("a {cpu} processor"), under(cpu, program), MANY));
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
    let made = hashes(plain(program), &root, MANY, &["--without-origin"])?;
    let made = content(&root, made)?;
    std::fs::remove_dir_all(scratch)?;
    let written = Path::new(WRITTEN);
    let before = if written.exists() { read(written)? } else { Content::default() };
    not_raised(&before, &made)?;
    if how == How::Renew {
        std::fs::write(written, text(&made))?;
        println!("wrote {WRITTEN}");
        return Ok(());
    }
    unchanged(&before, &made)?;
    println!("without origin: {} files, as written down", made.files.len());
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

fn plain(program: &Path) -> Command {
    Command::new(program)
}

fn under(processor: &str, program: &Path) -> Command {
    let mut command = Command::new(EMULATOR);
    command.args(["-cpu", processor]).arg(program);
    command
}

/// Makes everything anew in a root of its own, which holds a copy of the raw data.
fn hashes(
    mut command: Command,
    root: &Path,
    threads: &str,
    options: &[&str],
) -> anyhow::Result<Hashes> {
    if root.exists() {
        std::fs::remove_dir_all(root)?;
    }
    let raw = Path::new("raw").join(STUDY);
    for file in files(&raw)? {
        let copy = root.join(&file);
        std::fs::create_dir_all(copy.parent().unwrap_or(root))?;
        std::fs::copy(&file, copy)?;
    }
    command.arg("--root").arg(root).args(["--threads", threads, "--quiet", "run", "--fresh"]);
    command.args(options).arg(STUDY);
    let Output { status, stderr, .. } = command
        .output()
        .with_context(|| format!("{:?}; is it installed?", command.get_program()))?;
    if !status.success() {
        bail!("zwidth run ended with {status}\n{}", String::from_utf8_lossy(&stderr));
    }
    let mut hashes = Hashes::new();
    for file in ["derived", "reports"]
        .iter()
        .map(|f| files(&root.join(f)))
        .collect::<Result<Vec<_>, _>>()?
        .concat()
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

/// What was made, with the stages that the records of that run name.
fn content(root: &Path, hashes: Hashes) -> anyhow::Result<Content> {
    let records = std::fs::read(root.join("derived").join(STUDY).join("records.json"))?;
    let records: BTreeMap<String, Record> = serde_json::from_slice(&records)?;
    let mut content = Content::default();
    for Record { stage, version, outputs } in records.into_values() {
        for path in outputs.keys().filter(|path| !path.ends_with(".png") && !path.ends_with(".pdf"))
        {
            let hash = hashes.get(path).with_context(|| format!("{path} was not made"))?;
            content.files.insert(path.clone(), (stage.clone(), hash.clone()));
        }
        content.versions.insert(stage, version);
    }
    Ok(content)
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
    let count = paths.len();
    let differ = paths.into_iter().filter(|path| expected.get(*path) != made.get(*path));
    let told: Vec<String> = differ
        .map(|path| told(path, expected.get(path).is_some(), made.get(path).is_some()))
        .collect();
    if told.is_empty() {
        return Ok(());
    }
    bail!("{} of {count} files differ:\n{}", told.len(), some(&told))
}

/// An error that names the stages of which some file has another content, at the same version.
fn not_raised(before: &Content, made: &Content) -> anyhow::Result<()> {
    let other: Vec<String> = made
        .files
        .iter()
        .filter(|(path, (stage, hash))| {
            let was = before.files.get(*path).filter(|(was_of, _)| was_of == stage);
            was.is_some_and(|(_, was)| was != hash)
                && before.versions.get(stage) == made.versions.get(stage)
        })
        .map(|(path, (stage, _))| format!("{path} ({stage})"))
        .collect();
    if other.is_empty() {
        return Ok(());
    }
    bail!(
        "{} files have another content, and the version of their stage is the same; where that is meant, raise \
         its VERSION:\n{}",
        other.len(),
        some(&other)
    )
}

/// An error that names what differs from what is written down.
fn unchanged(before: &Content, made: &Content) -> anyhow::Result<()> {
    let hashes = |content: &Content| -> Hashes {
        content.files.iter().map(|(path, (_, hash))| (path.clone(), hash.clone())).collect()
    };
    let meant = format!("{WRITTEN}; where that is meant, `cargo xtask bits renew` writes it down");
    same(&hashes(before), &hashes(made)).with_context(|| meant.clone())?;
    if before.versions != made.versions {
        bail!("the versions of stages differ from {meant}");
    }
    Ok(())
}

fn told(path: &str, was: bool, is: bool) -> String {
    match (was, is) {
        (true, false) => format!("{path} was not made"),
        (false, _) => format!("{path} is new"),
        _ => format!("{path} has other bytes"),
    }
}

fn some(lines: &[String]) -> String {
    lines.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join("\n")
}

/// A line of a stage's version begins so: `# metrics 9`. The stage's files follow.
const STAGE: &str = "# ";

fn read(file: &Path) -> anyhow::Result<Content> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let bad =
        |line: &str| format!("{}: {line}: neither a stage nor a line of b3sum", file.display());
    let mut content = Content::default();
    let mut of = String::new();
    for line in text.lines() {
        if let Some((stage, version)) = line.strip_prefix(STAGE).and_then(|l| l.split_once(' ')) {
            of = stage.to_owned();
            content.versions.insert(of.clone(), version.parse().with_context(|| bad(line))?);
            continue;
        }
        let (hash, path) = line.split_once("  ").with_context(|| bad(line))?;
        content.files.insert(path.to_owned(), (of.clone(), hash.to_owned()));
    }
    Ok(content)
}

fn text(content: &Content) -> String {
    let mut text = String::new();
    for (stage, version) in &content.versions {
        let _ = writeln!(text, "{STAGE}{stage} {version}");
        for (path, (_, hash)) in content.files.iter().filter(|(_, (of, _))| of == stage) {
            let _ = writeln!(text, "{hash}  {path}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hashes(files: &[(&str, &str)]) -> Hashes {
        files.iter().map(|(path, hash)| ((*path).to_owned(), (*hash).to_owned())).collect()
    }

    fn content(version: u32, hash: &str) -> Content {
        let file = |stage: &str, hash: &str| (stage.to_owned(), hash.to_owned());
        Content {
            versions: [("likert".to_owned(), 2), ("metrics".to_owned(), version)].into(),
            files: [
                ("derived/a b.parquet".to_owned(), file("metrics", hash)),
                ("reports/θ.svg".to_owned(), file("likert", "12ab")),
            ]
            .into(),
        }
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
        assert!(told.contains("derived/a b.parquet (metrics)"), "{told}");
        assert!(not_raised(&before, &content(2, "11")).is_ok());
        for other in [content(2, "11"), content(2, "00")] {
            assert!(unchanged(&before, &other).is_err());
        }
        assert!(not_raised(&Content::default(), &before).is_ok());
    }
}
