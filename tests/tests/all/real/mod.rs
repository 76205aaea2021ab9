//! Recordings made by others, from their files to figures and tables with the mappings in
//! `studies/`.
//!
//! The recordings are not part of this repository: `ZWIDTH_REAL_DATA` names the folder that holds
//! them.

mod brake;
mod ethz;
mod shoes;
mod tsa;

use crate::binary::zwidth;
use crate::folders::{files, workspace};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zwidth_store::Layout;
use zwidth_tables::Table;

/// The folder of the recordings of one set.
fn recordings(set: &str) -> PathBuf {
    let root = std::env::var_os("ZWIDTH_REAL_DATA").expect("ZWIDTH_REAL_DATA names a folder");
    PathBuf::from(root).join(set)
}

/// A study of `studies/`, in a temporary folder.
struct Real {
    folder: TempDir,
    layout: Layout,
}

impl Real {
    /// The study with its `study.toml` and no data.
    fn new(id: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), id.parse().unwrap());
        fs::create_dir_all(layout.raw()).unwrap();
        fs::copy(workspace().join("studies").join(id).join("study.toml"), layout.study_toml())
            .unwrap();
        Self { folder, layout }
    }

    /// Imports files with a mapping of the study; returns what the import says.
    #[track_caller]
    fn import(&self, map: &str, recordings: &[PathBuf]) -> String {
        let id = self.layout.study().as_str();
        let map = workspace().join("studies").join(id).join(map);
        let mut arguments = vec!["import", id, "--map", map.to_str().unwrap()];
        arguments.extend(recordings.iter().map(|f| f.to_str().unwrap()));
        let said = zwidth(self.folder.path(), &arguments).exits(0).out;
        // Nothing that these rigs recorded is a wrong unit, a lost sensor or a stopped clock.
        assert!(!said.contains("read with care"), "{said}");
        said
    }

    /// Checks the files made, runs the study, and runs it again, which makes nothing.
    #[track_caller]
    fn run(self) -> Self {
        zwidth(self.folder.path(), &["verify"]).exits(0);
        zwidth(self.folder.path(), &["run"]).exits(0);
        assert!(zwidth(self.folder.path(), &["run", "--json"]).exits(0).made().is_empty());
        for svg in files(&self.layout.reports(), "svg") {
            assert!(
                !labels(&svg).iter().any(|l| l.contains("SYNTHETIC")),
                "{} is of measured data",
                svg.display()
            );
        }
        self
    }

    fn derived(&self, name: &str) -> Table {
        Table::from_parquet(&self.layout.derived().join(name)).unwrap()
    }

    fn report(&self, name: &str) -> PathBuf {
        self.layout.reports().join(name)
    }

    fn summary(&self) -> String {
        fs::read_to_string(self.report("summary.md")).unwrap()
    }
}

/// The texts of a figure, as its groups of outlined letters are labelled.
pub(crate) fn labels(svg: &Path) -> Vec<String> {
    let text = fs::read_to_string(svg).unwrap();
    text.split("aria-label=\"")
        .skip(1)
        .filter_map(|rest| Some(rest.split_once('"')?.0.to_owned()))
        .collect()
}

/// The floats of a column, none of which may be null.
fn floats(table: &Table, column: &str) -> Vec<f64> {
    table.floats(column).unwrap().into_iter().map(|v| v.unwrap()).collect()
}

/// The estimate of one parameter of one model in a table of parameters.
fn parameter(table: &Table, model: &str, parameter: &str) -> f64 {
    let (models, names) = (table.texts("model").unwrap(), table.texts("parameter").unwrap());
    let row = (0..table.height())
        .find(|i| models[*i].as_deref() == Some(model) && names[*i].as_deref() == Some(parameter));
    floats(table, "estimate")[row.unwrap()]
}

#[track_caller]
fn close(found: f64, expect: f64, tolerance: f64) {
    assert!((found - expect).abs() <= tolerance, "{found} is not {expect} ± {tolerance}");
}
