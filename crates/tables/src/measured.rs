//! The metrics of trials.

use crate::{Table, TableError};
use std::path::Path;
use zwidth_results::{Column, Row as _, TrialKey};

/// The metrics of trials: which trial each row is of, and a column for each metric.
#[derive(Debug, Clone)]
pub struct Measured {
    trials: Vec<TrialKey>,
    table: Table,
}

impl Measured {
    /// Those of a table.
    ///
    /// # Errors
    /// A table that does not say which trial a row is about.
    pub fn of(table: Table) -> Result<Self, TableError> {
        Ok(Self { trials: table.to_rows()?, table })
    }

    /// Those of a file, with these metrics alone.
    ///
    /// # Errors
    /// A file that cannot be read, or lacks one of them.
    pub fn read(file: &Path, metrics: &[&str]) -> Result<Self, TableError> {
        let keys = TrialKey::fields();
        let keys: Vec<&str> = keys.iter().map(|field| &*field.name).collect();
        Self::of(Table::columns_from_parquet(file, &[&keys, metrics].concat())?)
    }

    /// Which trials they are, in the order of the rows.
    pub fn trials(&self) -> &[TrialKey] {
        &self.trials
    }

    /// A metric as a column; `None` if there is no such metric.
    pub fn metric(&self, name: &str) -> Option<&Column> {
        self.table.column(name).ok()
    }

    /// The values of a metric, of any numbers: of `trials`' order.
    ///
    /// # Errors
    /// A metric that is missing, or is not a number.
    pub fn numbers(&self, metric: &str) -> Result<Vec<Option<f64>>, TableError> {
        self.table.numbers(metric)
    }

    /// The yes and no of a metric.
    ///
    /// # Errors
    /// A metric that is missing, or is not a yes or no.
    pub fn flags(&self, metric: &str) -> Result<Vec<Option<bool>>, TableError> {
        self.table.flags(metric)
    }

    /// The words of a metric.
    ///
    /// # Errors
    /// A metric that is not there, or has no words.
    pub fn words(&self, metric: &str) -> Result<Vec<Option<&str>>, TableError> {
        Ok(self.table.words(metric)?.collect())
    }

    /// The table.
    pub fn table(&self) -> &Table {
        &self.table
    }
}
