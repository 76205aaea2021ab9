//! A table as it is printed: a whole derived table, or one metric's rows of it.

use crate::shared::handle::Derived;
use std::path::{Path, PathBuf};
use zwidth_results::{Compared, MetricNote};
use zwidth_runner::Inputs;
use zwidth_study::MetricId;
use zwidth_tables::{Table, TableError, of_metric};

/// A table that is printed: a derived one, or one metric's rows of it.
#[derive(Debug, Clone)]
pub struct Printed {
    pub(crate) file: PathBuf,
    /// The metric whose rows they are.
    pub(crate) metric: Option<MetricId>,
    /// Whether columns without any value are left out.
    drops_empty: bool,
    /// Whether it has to be marked: simulated data go into it, and it does not say so by itself.
    pub(crate) simulated: bool,
}

impl Printed {
    /// The whole of a derived table.
    pub(crate) fn whole(file: &Path) -> Self {
        Self { file: file.to_owned(), metric: None, drops_empty: false, simulated: false }
    }

    /// The same, without the columns that have no value in any row.
    pub(crate) fn without_empty_columns(file: &Path) -> Self {
        Self { drops_empty: true, ..Self::whole(file) }
    }

    /// The same, marked if simulated data go into it.
    pub(crate) fn marked(self, simulated: bool) -> Self {
        Self { simulated, ..self }
    }

    /// A metric's rows of a table of all metrics.
    pub(crate) fn of_metric(file: &Path, metric: &str) -> Self {
        Self { metric: metric.parse().ok(), ..Self::whole(file) }
    }

    /// What it is called.
    pub fn name(&self) -> String {
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        self.metric.as_ref().map_or_else(|| stem.to_string(), |metric| format!("{stem}_{metric}"))
    }

    /// Whether it was made.
    pub fn exists(&self) -> bool {
        self.file.exists()
    }

    /// The tables beside a metric's rows: what the metric is, and the notes below them.
    fn metrics_and_notes(&self) -> (Derived<Compared>, Derived<MetricNote>) {
        // The stage writes all of its tables into one folder.
        let folder = self.file.parent().unwrap_or(Path::new(""));
        (Derived::within(folder), Derived::within(folder))
    }

    /// The table.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(&self) -> Result<Table, TableError> {
        let table = Table::from_parquet(&self.file)?;
        let Some(metric) = &self.metric else {
            let table = if self.drops_empty { table.without_empty_columns() } else { table };
            return Ok(table.with_mark(self.simulated));
        };
        let (metrics, notes) = self.metrics_and_notes();
        match metrics.read_of(metric)?.first() {
            Some(metric) => of_metric(&table, metric, &notes.read_of(&metric.metric)?),
            None => Ok(table.rows(&[])),
        }
    }

    /// Its title and how many rows it has.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn about(&self) -> Result<(String, usize), TableError> {
        if self.metric.is_some() {
            return self.read().map(|table| (table.title().to_owned(), table.height()));
        }
        Table::about(&self.file).map(|about| (about.title, about.rows))
    }
}

impl Inputs for Printed {
    fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.file.clone()];
        if self.metric.is_some() {
            files.extend(self.metrics_and_notes().files());
        }
        files
    }
}
