//! A small study in a temporary folder, for the tests of import.

use super::context::{Step, bytes_of};
use super::{By, Mapping, Report, import};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::TempDir;
use zwidth_store::{Files, Layout, RealFiles, StoreError, StudyData, Trial, read_trial, verify};
use zwidth_store::{Signal, read_events};
use zwidth_study::{Event, Study, StudyId, template};

pub(super) const UTC: &str = "2026-01-01T00:00:00Z";
/// Who imports in tests.
pub(super) const BY: By = By { utc: UTC, software: "zwidth test" };

/// Labels for a file that is one trial of P01 S01.
pub(super) const ONE: &str = "
[trial]
participant = \"P01\"
session = \"S01\"
environment = \"spring\"
mode = \"hybrid\"
";

/// Time and force by name.
pub(super) const FORCE: &str = "
[time]
from = \"t\"
unit = \"s\"
[[column]]
to = \"force_ex_n\"
from = \"f\"
unit = \"N\"
";

/// The study of the template: lever 0.045 m, spring and spring_wall, active, passive and hybrid;
/// with one repeat of each.
pub(super) fn template_once() -> String {
    template(&StudyId::new("demo").unwrap()).replace("repeats = 6", "repeats = 1")
}

/// A study folder and a folder of recordings.
pub(super) struct World {
    root: PathBuf,
    /// Removes `root` at the end, where it is a temporary folder.
    _folder: Option<TempDir>,
    pub(super) layout: Layout,
    study: Study,
}

impl World {
    /// The study of [`template_once`].
    pub(super) fn new() -> Self {
        Self::with(&template_once())
    }

    /// The study of this text, which must have the id `demo`.
    pub(super) fn with(study_toml: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let world = Self::below(folder.path(), study_toml);
        Self { _folder: Some(folder), ..world }
    }

    /// The same folder, with another text of the study.
    pub(super) fn again(world: Self, study_toml: &str) -> Self {
        Self { _folder: world._folder, ..Self::below(&world.root, study_toml) }
    }

    /// The study of this text, below a folder that stays.
    pub(super) fn below(root: &Path, study_toml: &str) -> Self {
        let study = Study::from_toml(study_toml).unwrap();
        let layout = Layout::new(root, study.id.clone());
        std::fs::create_dir_all(layout.raw()).unwrap();
        std::fs::write(layout.study_toml(), study_toml).unwrap();
        Self { root: root.to_owned(), _folder: None, layout, study }
    }

    /// Writes a recording, and gives its path.
    pub(super) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.root.join("theirs").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, content).unwrap();
        path
    }

    pub(super) fn import_on(
        &self,
        map: &str,
        files: &[PathBuf],
        disk: &dyn Files,
    ) -> Result<Report, Vec<StoreError>> {
        let mapping = Mapping::from_toml(map, Path::new("map.toml"))?;
        self.followed(&mapping, files, disk)
    }

    /// Imports, and holds what progress is told against what there is.
    fn followed(
        &self,
        mapping: &Mapping,
        files: &[PathBuf],
        disk: &dyn Files,
    ) -> Result<Report, Vec<StoreError>> {
        let told = Mutex::new((0, Vec::new()));
        let progress = |step: Step| match step {
            Step::Read(bytes) => told.lock().unwrap().0 += bytes,
            Step::Written { all } => told.lock().unwrap().1.push(all),
        };
        let report = import(&self.layout, &self.study, mapping, files, BY, disk, &progress)?;
        let (read, written) = told.into_inner().unwrap();
        let all = bytes_of(files);
        // Each block of a long text has its header again.
        assert!((all..=2 * all).contains(&read), "progress reaches the end: {read} of {all} bytes");
        assert!(written.iter().all(|all| *all == written.len()), "{written:?}");
        Ok(report)
    }

    /// The same with every text read block by block.
    pub(super) fn import_streamed(
        &self,
        map: &str,
        files: &[PathBuf],
    ) -> Result<Report, Vec<StoreError>> {
        let mut mapping = Mapping::from_toml(map, Path::new("map.toml"))?;
        mapping.file.long_from = 0;
        self.followed(&mapping, files, &RealFiles)
    }

    pub(super) fn import(&self, map: &str, files: &[PathBuf]) -> Result<Report, Vec<StoreError>> {
        self.import_on(map, files, &RealFiles)
    }

    /// Imports one file, and expects an error with these words, in this column and row; and that
    /// nothing was written.
    pub(super) fn refuses(
        &self,
        map: &str,
        file: &PathBuf,
        words: &str,
        at: Option<(&str, usize)>,
    ) {
        let before = self.written();
        let errors = self.import(map, std::slice::from_ref(file)).unwrap_err();
        let shown = errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
        assert!(shown.contains(words), "{shown}");
        let found = errors.iter().find(|e| e.to_string().contains(words)).unwrap();
        if let Some((column, row)) = at {
            assert_eq!((found.column.as_deref(), found.row), (Some(column), Some(row)), "{shown}");
        }
        assert_eq!(self.written(), before, "{shown}");
    }

    /// Every file and folder under `raw/demo`, sorted.
    pub(super) fn written(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut folders = vec![self.layout.raw()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                found.push(path.strip_prefix(self.layout.raw()).unwrap().display().to_string());
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        found.sort();
        found
    }

    pub(super) fn trial(&self, participant: &str, session: &str, trial: u32) -> Trial {
        let p = participant.parse().unwrap();
        let s = session.parse().unwrap();
        read_trial(&self.layout.trial(&p, &s, trial), Signal::all()).unwrap()
    }

    /// A signal of trial `trial` of P01 S01.
    pub(super) fn column(&self, trial: u32, signal: Signal) -> Vec<f64> {
        self.trial("P01", "S01", trial).samples.get(signal).unwrap().to_vec()
    }

    /// What the file of trial `trial` of P01 S01 says was computed.
    pub(super) fn computed(&self, trial: u32) -> String {
        self.trial("P01", "S01", trial).file.remove("made_by_import").unwrap_or_default()
    }

    pub(super) fn events(&self, participant: &str, session: &str) -> Vec<Event> {
        let p = participant.parse().unwrap();
        let s = session.parse().unwrap();
        let mut events = read_events(&self.layout.events(&p, &s)).unwrap();
        assert!(matches!(events.remove(0), Event::LaidDown { .. }));
        events
    }

    /// The whole study, in which `verify` may find nothing.
    pub(super) fn load(&self) -> StudyData {
        let data = StudyData::load(&self.layout).unwrap();
        assert_eq!((&data.problems, verify(&self.layout)), (&vec![], vec![]));
        data
    }
}

/// A mapping of kind `trials` from its parts.
pub(super) fn trials_map(parts: &[&str]) -> String {
    format!("kind = \"trials\"\n{}", parts.concat())
}

/// A column of theirs that becomes one of ours.
pub(super) fn column(to: &str, from: &str, unit: &str) -> String {
    format!("[[column]]\nto = \"{to}\"\nfrom = \"{from}\"\nunit = \"{unit}\"\n")
}

/// Equal within rounding.
pub(super) fn close(found: &[f64], expect: &[f64]) {
    assert_eq!(found.len(), expect.len(), "{found:?}");
    for (a, b) in found.iter().zip(expect) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{found:?} {expect:?}");
    }
}

/// Labels from columns: many trials in a file.
pub(super) const COLUMNS: &str = "
[trial]
participant = { column = \"who\" }
session = \"S01\"
environment = \"spring\"
mode = { column = \"mode\" }
trial = { column = \"n\" }
kind = { column = \"kind\" }
likert = { column = \"q\" }
";
