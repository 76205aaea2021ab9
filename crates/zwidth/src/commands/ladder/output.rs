//! Where the figures and tables of a ladder go.

use crate::args::Ladder as Asked;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_draw::{DEFAULT_DPI, Figure, draw};
use zwidth_ladder::Ladder;
use zwidth_runner::Provenance;
use zwidth_store::{RealFiles, replace};
use zwidth_tables::{Table, csv};

/// A folder, what made the files, and the files written so far.
pub(super) struct Output<'a> {
    folder: &'a Path,
    provenance: Provenance,
    pub(super) files: Vec<PathBuf>,
}

impl<'a> Output<'a> {
    /// Files that say what they were made of.
    pub(super) fn new(folder: &'a Path, ladder: &Ladder, asked: &Asked, synthetic: bool) -> Self {
        let source = match synthetic {
            true => "SYNTHETIC: model runs under a simulated force, not measured",
            false => "model runs, not measured",
        };
        let mut provenance = BTreeMap::from([
            ("software".to_owned(), concat!("zwidth ", env!("CARGO_PKG_VERSION")).to_owned()),
            ("source".to_owned(), source.to_owned()),
            ("scene".to_owned(), ladder.scene.clone()),
            ("points".to_owned(), ladder.points.to_string()),
            ("version".to_owned(), zwidth_ladder::VERSION.to_string()),
        ]);
        if let Some(rate_hz) = asked.rate {
            provenance.insert("rate_hz".to_owned(), rate_hz.to_string());
        }
        Self { folder, provenance, files: Vec::new() }
    }

    /// Writes a figure as SVG, PDF and PNG.
    pub(super) fn figure(&mut self, name: &str, figure: Figure) -> anyhow::Result<()> {
        let provenance = Some(serde_json::to_string(&self.provenance)?);
        let drawing = draw(&Figure { provenance, ..figure })?;
        self.write(name, "svg", drawing.svg()?.as_bytes())?;
        self.write(name, "pdf", &drawing.pdf()?)?;
        self.write(name, "png", &drawing.png(DEFAULT_DPI)?)
    }

    /// Writes a table as Parquet and CSV, in SI units and radians.
    pub(super) fn table(&mut self, name: &str, table: &Table) -> anyhow::Result<()> {
        let parquet = table.to_parquet(&self.provenance, &self.path(name, "parquet"))?;
        self.write(name, "parquet", &parquet)?;
        self.write(name, "csv", csv(table).as_bytes())
    }

    fn write(&mut self, name: &str, extension: &str, bytes: &[u8]) -> anyhow::Result<()> {
        let path = self.path(name, extension);
        replace(&RealFiles, &path, bytes)?;
        self.files.push(path);
        Ok(())
    }

    fn path(&self, name: &str, extension: &str) -> PathBuf {
        self.folder.join(format!("{name}.{extension}"))
    }
}
