//! From a path that a person typed to the job behind it: by its place, or for a copy elsewhere by
//! the origin in the file.

use super::near::did_you_mean;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_runner::{Records, Results, origins};
use zwidth_store::{Layout, MOST_BYTES, RealFiles, hex_blake3, read_named};
use zwidth_study::StudyId;

/// A result asked about.
#[derive(Debug, clap::Args)]
pub(crate) struct Traced {
    /// A file under derived/ or reports/, relative to the current folder or --root; or a copy of
    /// one, anywhere
    pub(crate) path: PathBuf,
}

/// How a file's job was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FoundBy {
    /// By its place under derived/ or reports/.
    Path,
    /// By the origin that stands in it.
    Origin,
    /// By its content, which is what a job made.
    Content,
}

/// The folder of a study's reports that figures are remade into.
pub(super) const REMADE: &str = "remade";

/// Where a typed path leads.
pub(super) enum Place {
    /// Into the results of a study: relative to the root, with `/`.
    Results(StudyId, String),
    /// Elsewhere: under `raw/` (relative to the root), or outside.
    Raw(String),
    /// Outside of the data folders.
    Outside,
}

/// The records of a study's jobs; warns of those that are not believed.
///
/// # Errors
/// A link on the way to their file.
pub(super) fn records(layout: &Layout, screen: &Screen) -> anyhow::Result<Records> {
    let (records, remarks) = Records::read(&Results::new(layout, &RealFiles))?;
    remarks.iter().for_each(|remark| screen.warn(remark.to_string()));
    Ok(records)
}

/// Where `typed` leads, taken from the current folder, or else from the root.
pub(super) fn place(root: &Path, typed: &Path) -> Place {
    let real_root = real(if root.as_os_str().is_empty() { Path::new(".") } else { root });
    // From the current folder first, as every program reads a path.
    let candidates = [real(typed), real(&real_root.join(typed))];
    let inside = candidates.iter().filter_map(|p| p.strip_prefix(&real_root).ok());
    let shown = inside.map(|p| p.to_string_lossy().replace('\\', "/"));
    shown
        .map(|path| place_below_root(&path))
        .find(|place| !matches!(place, Place::Outside))
        .unwrap_or(Place::Outside)
}

fn place_below_root(path: &str) -> Place {
    let mut parts = path.split('/');
    let folder = parts.next();
    let study = parts.next().and_then(|id| StudyId::new(id).ok());
    match (folder, study) {
        (Some("derived" | "reports"), Some(study)) => Place::Results(study, path.to_owned()),
        (Some("raw"), _) => Place::Raw(path.to_owned()),
        _ => Place::Outside,
    }
}

/// The path from the file system's root on, without `..` and links as far as it exists.
fn real(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (path.canonicalize(), path.parent(), path.file_name()) {
        (Ok(real), _, _) => real,
        (Err(_), Some(parent), Some(name)) => real(parent).join(name),
        _ => path,
    }
}

/// Whether a file among the results is one that `zwidth figure` remade: no job's own, but it says
/// which job's figure it is.
pub(super) fn is_a_copy(root: &Path, path: &str) -> bool {
    let folder = path.split('/').nth(2);
    path.starts_with("reports/") && folder == Some(REMADE) && root.join(path).is_file()
}

/// A job that made a file, as its study's records have it.
pub(super) struct Maker {
    pub(super) layout: Layout,
    pub(super) records: Records,
    pub(super) job: String,
    pub(super) by: FoundBy,
    /// The output that the file is, relative to the root; of a copy the job's output of the same
    /// extension, if any.
    pub(super) path: String,
}

/// The jobs that made a copy which lies anywhere: by each origin in it, or else by its content.
///
/// # Errors
/// It cannot be read; nothing in it, nor its content, is known under this root.
pub(super) fn copies(root: &Path, typed: &Path, screen: &Screen) -> anyhow::Result<Vec<Maker>> {
    let bytes = read_named(typed, MOST_BYTES).with_context(|| {
        format!(
            "cannot read {}, which is under neither derived/ nor reports/ (--root chooses where)",
            typed.display()
        )
    })?;
    let origins = origins(&bytes);
    let content = hex_blake3(&bytes);
    let extension = typed.extension();
    let mut makers = Vec::new();
    for layout in studies_with_records(root) {
        let records = records(&layout, screen)?;
        for (job, record) in records.iter() {
            let same =
                record.outputs.iter().find(|(_, hash)| **hash == content).map(|(path, _)| path);
            // The origin before the content: several jobs may make the same bytes.
            let by = match same {
                _ if origins.contains(&record.origin) => FoundBy::Origin,
                Some(_) => FoundBy::Content,
                None => continue,
            };
            let mut outputs = record.outputs.keys();
            let path = same
                .or_else(|| outputs.clone().find(|path| Path::new(path).extension() == extension))
                .or_else(|| outputs.next());
            let path = path.cloned().unwrap_or_default();
            makers.push(Maker {
                layout: layout.clone(),
                records: records.clone(),
                job: job.to_owned(),
                by,
                path,
            });
        }
    }
    if makers.is_empty() {
        bail!("{}", unknown_copy(root, typed, &origins));
    }
    Ok(makers)
}

/// The studies that were run.
fn studies_with_records(root: &Path) -> Vec<Layout> {
    let folders = std::fs::read_dir(root.join("derived")).into_iter().flatten().flatten();
    let mut ids: Vec<StudyId> = folders
        .filter_map(|entry| StudyId::new(entry.file_name().to_string_lossy()).ok())
        .collect();
    // A folder is listed in no order of its own.
    ids.sort();
    ids.into_iter()
        .map(|id| Layout::new(root, id))
        .filter(|layout| Results::records_file(layout).exists())
        .collect()
}

fn unknown_copy(root: &Path, typed: &Path, origins: &[String]) -> String {
    let file = typed.display();
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    let root = root.display();
    match origins.first() {
        Some(origin) => format!(
            "{file} says that it is from {origin}, and nothing under {root} was made from that: its inputs have changed \
             since, or it is from another folder of data (choose it with --root); figures and Parquet files hold the list \
             of their inputs themselves (docs/data.md)"
        ),
        None => format!(
            "no job made {file}: it neither says where it is from nor is the same as anything made under derived/ or \
             reports/ of {root}; choose the folder of the data with --root"
        ),
    }
}

/// What to say of a path that no job makes.
pub(super) fn no_job(path: &str, study: &StudyId, outputs: &[String]) -> String {
    if path.ends_with("/records.json") {
        return format!(
            "{path} is the runner's own record of what was made from what; no job makes it"
        );
    }
    if path.starts_with("reports/simulate/") {
        return format!(
            "no job makes {path}: `zwidth simulate` wrote it, and the file itself holds the solver and the scene"
        );
    }
    // A mistyped folder would outweigh the name.
    let near = did_you_mean(file_name(path), outputs.iter().map(|output| file_name(output)));
    format!(
        "no job of {study} makes {path}{near} (`zwidth run {study} --dry-run --fresh` lists the jobs)"
    )
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or_default()
}

/// What to say of a raw file.
pub(super) fn is_raw(path: &str) -> String {
    format!("{path} is raw: recorded or imported, and made by no job; `zwidth verify` checks it")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_told_by_its_first_two_folders() {
        assert!(
            matches!(place_below_root("reports/s/figures/a.svg"), Place::Results(s, _) if s.as_str() == "s")
        );
        assert!(matches!(place_below_root("derived/s/a.parquet"), Place::Results(..)));
        assert!(matches!(place_below_root("raw/s/study.toml"), Place::Raw(_)));
        for outside in ["", "derived", "reports/..", "other/s/a", "README.md"] {
            assert!(matches!(place_below_root(outside), Place::Outside), "{outside}");
        }
    }

    #[test]
    fn a_path_that_does_not_exist_yet_has_a_place() {
        let folder = tempfile::tempdir().unwrap();
        let typed = folder.path().join("reports/s/figures/a.svg");
        assert!(
            matches!(place(folder.path(), &typed), Place::Results(_, p) if p == "reports/s/figures/a.svg")
        );
        let typed = Path::new("derived/s/a.parquet");
        assert!(
            matches!(place(folder.path(), typed), Place::Results(_, p) if p == "derived/s/a.parquet")
        );
        assert!(matches!(place(folder.path(), Path::new("../a.svg")), Place::Outside));
    }
}
