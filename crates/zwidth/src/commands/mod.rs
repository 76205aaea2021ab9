//! The commands, one file each.

pub(crate) mod acquire;
mod alike;
pub(crate) mod allow;
mod bench;
pub(crate) mod beside;
mod calibrate;
pub(crate) mod characterise;
pub(crate) mod check;
mod cluster;
pub(crate) mod compare;
pub(crate) mod consent;
pub(crate) mod device;
pub(crate) mod export;
pub(crate) mod figure;
mod impedance;
pub(crate) mod import;
pub(crate) mod judge;
pub(crate) mod ladder;
pub(crate) mod list;
pub(crate) mod locate;
pub(crate) mod methods;
pub(crate) mod metric;
mod near;
pub(crate) mod new;
pub(crate) mod open;
mod output;
pub(crate) mod participant;
pub(crate) mod ports;
pub(crate) mod power;
pub(crate) mod recover;
pub(crate) mod run;
pub(crate) mod said;
pub(crate) mod shards;
pub(crate) mod shell;
pub(crate) mod simulate;
pub(crate) mod stability;
pub(crate) mod table;
pub(crate) mod trace;
pub(crate) mod trade;
mod twice;
pub(crate) mod twin;
pub(crate) mod unseal;
pub(crate) mod verify;
pub(crate) mod why;

use anyhow::{Context as _, bail};
use near::did_you_mean;
use std::ffi::OsString;
use std::path::Path;
use zwidth_runner::HashesRead;
use zwidth_store::{FirstErrors, Layout, SessionLog, StoreError, StudyData};
use zwidth_study::{ParticipantId, SessionId, StudyId};

/// The named studies, or all there are under `raw/`.
fn studies(root: &Path, named: Vec<StudyId>) -> anyhow::Result<Vec<Layout>> {
    let ids = if named.is_empty() { all(root)? } else { named };
    ids.into_iter().map(|id| study(root, id)).collect()
}

/// Folders of studies that no command can name, where all studies are meant: none of them is
/// passed by without a word.
fn nameless(root: &Path, named: &[StudyId]) -> Vec<StoreError> {
    let folders = if named.is_empty() { std::fs::read_dir(root.join("raw")).ok() } else { None };
    let mut findings = Vec::new();
    for entry in folders.into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(error) = StudyId::new(name.as_str()).err().filter(|_| is_study(&entry.path()))
        else {
            continue;
        };
        let what = format!(
            "the study in the folder {name:?} is left out, because its name cannot be a study's: {}",
            error.why
        );
        findings.push(StoreError::new(
            &root.join("raw"),
            what,
            "rename the folder, and study.id in its study.toml",
        ));
    }
    // A folder is listed in the file system's order, which differs between machines.
    findings.sort_by(|a, b| a.what.cmp(&b.what));
    findings
}

/// The studies below the folder that these arguments name, where they could not be parsed.
pub(crate) fn studies_of(arguments: impl Iterator<Item = OsString>) -> String {
    let root = root_argument(arguments).or_else(|| std::env::var_os("ZWIDTH_ROOT"));
    let studies = all(Path::new(&root.unwrap_or_default())).unwrap_or_default();
    studies.iter().map(StudyId::as_str).collect::<Vec<_>>().join(", ")
}

/// The value of `--root`.
fn root_argument(mut arguments: impl Iterator<Item = OsString>) -> Option<OsString> {
    while let Some(argument) = arguments.next() {
        match argument.to_str()?.strip_prefix("--root") {
            Some("") => return arguments.next(),
            Some(rest) => return rest.strip_prefix('=').map(OsString::from),
            None => {}
        }
    }
    None
}

/// A study that must be there.
fn study(root: &Path, id: StudyId) -> anyhow::Result<Layout> {
    let layout = Layout::new(root, id);
    if !is_study(&layout.raw()) {
        let existing = all(root).unwrap_or_default();
        let existing: Vec<&str> = existing.iter().map(StudyId::as_str).collect();
        let id = layout.study();
        if existing.is_empty() {
            bail!(
                "there is no study '{id}': {} is missing; go to the folder that has raw/ or name it with --root, \
                 or make a new study with `zwidth new {id}`",
                layout.study_toml().display(),
            );
        }
        bail!(
            "there is no study '{id}': {} is missing{}; there {} {}; make a new one with `zwidth new {id}`",
            layout.study_toml().display(),
            did_you_mean(id.as_str(), existing.iter().copied()),
            if existing.len() == 1 { "is" } else { "are" },
            existing.join(", "),
        );
    }
    Ok(layout)
}

/// A study that must be there, with what was recorded of it.
fn load(root: &Path, id: &StudyId) -> anyhow::Result<StudyData> {
    let layout = study(root, id.clone())?;
    StudyData::load(&layout).map_err(|findings| join_findings(&findings))
}

/// What to say of a name that no study can have.
fn no_study(name: &Path) -> String {
    format!("there is no study '{}'; `zwidth list` shows them", name.display())
}

fn all(root: &Path) -> anyhow::Result<Vec<StudyId>> {
    let raw = root.join("raw");
    let list = std::fs::read_dir(&raw).with_context(|| {
        format!("cannot list {}; choose the data folder with --root", raw.display())
    })?;
    let mut ids: Vec<StudyId> = list
        .flatten()
        .filter(|entry| is_study(&entry.path()))
        .filter_map(|entry| StudyId::new(entry.file_name().to_string_lossy()).ok())
        .collect();
    ids.sort();
    if ids.is_empty() {
        bail!("there is no study under {}; make one with `zwidth new STUDY`", raw.display());
    }
    Ok(ids)
}

/// A session that must be there.
fn session<'a>(
    data: &'a StudyData,
    participant: &ParticipantId,
    session: &SessionId,
) -> anyhow::Result<&'a SessionLog> {
    let study = data.layout.study();
    data.session(participant, session).with_context(|| {
        format!(
            "there is no session {session} of {participant} in {study} that can be read; see `zwidth list {study}`"
        )
    })
}

/// The hashes of the raw files that reading a study has read.
fn hashes_read(data: &StudyData) -> HashesRead {
    let trials = data.trials.iter().map(|t| (t.path.clone(), &t.blake3));
    let sweeps = data.sweeps.iter().map(|s| (s.path.as_path().into(), &s.blake3));
    let outside = data.outside.iter().map(|own| (own.path.as_path().into(), &own.blake3));
    trials.chain(sweeps).chain(outside).collect()
}

/// Whether a folder is a study's: one with recordings stays one without its study.toml, which is
/// then missed.
fn is_study(folder: &Path) -> bool {
    ["study.toml", "trials", "sweeps", "sessions"].iter().any(|name| folder.join(name).exists())
}

/// The most lines of an error: of more the first are printed, and how many others there are.
const MOST_LINES: usize = 20;

/// Why something is withdrawn, as it is kept in a log: one line.
fn one_line<'a>(reason: &'a str, of_what: &str) -> anyhow::Result<&'a str> {
    let reason = reason.trim();
    if reason.is_empty() || reason.chars().any(char::is_control) {
        bail!("say in one line why {of_what} is withdrawn");
    }
    Ok(reason)
}

/// Several findings as one error, one line each.
fn join_findings(findings: &[StoreError]) -> anyhow::Error {
    let lines: Vec<String> = findings.iter().take(MOST_LINES).map(ToString::to_string).collect();
    as_lines(lines, findings.len().saturating_sub(MOST_LINES))
}

/// The same for recordings that go into one import, of which many have the same fault: it is
/// reported once.
fn sum_up(findings: &FirstErrors) -> anyhow::Error {
    let mut kinds: Vec<(&StoreError, usize)> = Vec::new();
    let mut unlisted = findings.more();
    for finding in findings.iter() {
        let alike = kinds.iter().position(|(first, _)| {
            first.path != finding.path
                && (&first.column, first.row) == (&finding.column, finding.row)
                && (&first.what, &first.remedy) == (&finding.what, &finding.remedy)
        });
        match alike {
            Some(alike) => kinds[alike].1 += 1,
            None if kinds.len() == MOST_LINES => unlisted += 1,
            None => kinds.push((finding, 0)),
        }
    }
    let lines = kinds.iter().map(|(first, more)| match more {
        0 => first.to_string(),
        1 => format!("{first} (and so in 1 more file)"),
        more => format!("{first} (and so in {more} more files)"),
    });
    as_lines(lines.collect(), unlisted)
}

/// Lines as one error, with a last one that says how many more there are.
fn as_lines(mut lines: Vec<String>, more: usize) -> anyhow::Error {
    if more > 0 {
        lines.push(format!("and {} more", thousands(more)));
    }
    anyhow::anyhow!("{}", lines.join("\n       "))
}

/// A number with commas between its thousands.
fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let threes = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    threes.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_findings_twenty_are_told_and_the_others_counted() {
        let finding = |i| StoreError::new(Path::new("a.csv"), format!("row {i}"), "mend it");
        let findings: Vec<StoreError> = (0..1500).map(finding).collect();
        for told in [join_findings(&findings), sum_up(&findings.iter().cloned().collect())] {
            let told = told.to_string();
            assert_eq!(told.lines().count(), 21, "{told}");
            assert!(told.ends_with("a.csv: row 19; mend it\n       and 1,480 more"), "{told}");
        }
        assert_eq!([7, 1000, 1_234_567].map(thousands), ["7", "1,000", "1,234,567"]);
    }

    #[test]
    fn what_is_the_same_in_many_files_is_said_once() {
        let of = |file: &str, what: &str| StoreError::new(Path::new(file), what, "mend it");
        let findings = [of("a", "no t"), of("b", "no t"), of("b", "no f"), of("c", "no t")];
        let told = sum_up(&findings.into_iter().collect()).to_string();
        assert_eq!(told, "a: no t; mend it (and so in 2 more files)\n       b: no f; mend it",);
    }
}
