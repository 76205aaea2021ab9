//! Where the figures and tables of model runs go.

use std::path::{Path, PathBuf};
use zwidth_draw::{DEFAULT_DPI, Drawing, Figure, draw};
use zwidth_runner::Provenance;
use zwidth_store::{RealFiles, replace};
use zwidth_tables::{Table, csv};

/// A folder, what made the files, and the files written so far.
pub(in crate::commands) struct Output<'a> {
    folder: &'a Path,
    provenance: Provenance,
    pub(in crate::commands) files: Vec<PathBuf>,
}

impl<'a> Output<'a> {
    /// Files that say with which software and from what they were made.
    pub(super) fn new(
        folder: &'a Path,
        made_from: impl IntoIterator<Item = (&'static str, String)>,
    ) -> Self {
        let source = ("source", "model run, not measured".to_owned());
        let software = ("software", concat!("zwidth ", env!("CARGO_PKG_VERSION")).to_owned());
        // Of two values of a key the later one counts.
        let facts = [source].into_iter().chain(made_from).chain([software]);
        let provenance = facts.map(|(key, value)| (key.to_owned(), value)).collect();
        Self { folder, provenance, files: Vec::new() }
    }

    /// Writes a figure as SVG, PDF and PNG.
    pub(in crate::commands) fn figure(&mut self, name: &str, figure: Figure) -> anyhow::Result<()> {
        let drawing = self.drawn(figure)?;
        self.write(name, "svg", drawing.svg()?.as_bytes())?;
        self.write(name, "pdf", &drawing.pdf()?)?;
        self.write(name, "png", &drawing.png(DEFAULT_DPI)?)
    }

    /// A figure drawn, which says in each form what made it.
    pub(super) fn drawn(&self, figure: Figure) -> anyhow::Result<Drawing> {
        let provenance = Some(serde_json::to_string(&self.provenance)?);
        Ok(draw(&Figure { provenance, ..figure })?)
    }

    /// Writes a table as Parquet and CSV, in SI units and radians.
    pub(in crate::commands) fn table(&mut self, name: &str, table: &Table) -> anyhow::Result<()> {
        let parquet = table.to_parquet(&self.provenance, &self.path(name, "parquet"))?;
        self.write(name, "parquet", &parquet)?;
        self.write(name, "csv", csv(table).as_bytes())
    }

    /// Writes a text as it is.
    pub(super) fn text(&mut self, name: &str, extension: &str, text: &str) -> anyhow::Result<()> {
        self.write(name, extension, text.as_bytes())
    }

    /// Writes a file, and keeps its path.
    pub(super) fn write(
        &mut self,
        name: &str,
        extension: &str,
        bytes: &[u8],
    ) -> anyhow::Result<()> {
        let path = self.path(name, extension);
        replace(&RealFiles, &path, bytes)?;
        self.files.push(path);
        Ok(())
    }

    fn path(&self, name: &str, extension: &str) -> PathBuf {
        self.folder.join(format!("{name}.{extension}"))
    }
}

/// Writes a text to a file of its own.
pub(in crate::commands) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    Ok(replace(&RealFiles, path, text.as_bytes())?)
}
