//! `[[stage]]` of a `study.toml`: a program of the study's own that computes metrics, or draws figures,
//! of what a run has found.

use crate::words::words;
use crate::{Better, MetricId, StageId};
use serde::{Deserialize, Serialize};

/// A stage of a study's own: a command, the files that it consists of, and what it gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct OwnStageTable")]
pub struct OwnStage {
    /// Its name: its table and its figures are called after it.
    pub id: StageId,
    /// The program and its arguments; no shell reads them.
    pub command: Vec<String>,
    /// The files that it consists of, from `analysis/<study>` on, with `/`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// What it gets: `samples`, `metrics`, `answers`, or the table of another stage, by its id.
    pub inputs: Vec<StageId>,
    /// The columns of samples that it gets; all, where none is named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// In which format it gets them.
    #[serde(skip_serializing_if = "is_parquet", default = "parquet")]
    pub format: StageFormat,
    /// It is ended after this time, s.
    #[serde(default = "ten_minutes")]
    pub timeout_s: u32,
    /// The metrics that it gives: columns of its table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gives: Vec<GivenMetric>,
    /// The figures that it draws.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<GivenFigure>,
}

fn parquet() -> StageFormat {
    StageFormat::Parquet
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands a reference
fn is_parquet(format: &StageFormat) -> bool {
    *format == StageFormat::Parquet
}

fn ten_minutes() -> u32 {
    600
}

words! {
    /// In which format a stage of a study's own gets tables.
    StageFormat {
        /// Apache Parquet.
        Parquet = "parquet",
        /// Comma-separated values, with numbers to the last digit.
        Csv = "csv",
    }
}

/// A metric that a stage gives: a column of its table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct GivenMetricTable")]
pub struct GivenMetric {
    /// Its name: the column's in the stage's table.
    pub id: MetricId,
    /// Its unit.
    pub unit: String,
    /// What people call it.
    pub label: String,
    /// Which values are better.
    #[serde(default = "neither")]
    pub better: Better,
}

fn neither() -> Better {
    Better::Neither
}

/// A figure that a stage draws.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct GivenFigureTable")]
pub struct GivenFigure {
    /// Its file in `out/figures`: SVG, PDF or PNG, by its ending.
    pub file: String,
    /// What it shows, in one sentence.
    pub caption: String,
}

/// A command as a person reads it: arguments with blanks in quotation marks.
pub fn command_line(command: &[String]) -> String {
    let words = command.iter().map(|word| match word {
        plain if !plain.is_empty() && !plain.contains([' ', '"', '\'']) => plain.clone(),
        other => format!("{other:?}"),
    });
    words.collect::<Vec<_>>().join(" ")
}

impl OwnStage {
    /// Inputs that are not the tables of other stages.
    pub const INPUTS: [&str; 3] = ["samples", "metrics", "answers"];

    /// The command as a person reads it ([`command_line`]).
    pub fn command_line(&self) -> String {
        command_line(&self.command)
    }

    /// Who it is, in words: `stage grip of the study: python3 grip.py`.
    pub fn in_words(&self) -> String {
        format!("stage {} of the study: {}", self.id, self.command_line())
    }

    /// Whether it gets this column of samples.
    pub fn takes(&self, column: &str) -> bool {
        self.columns.is_empty() || self.columns.iter().any(|own| own == column)
    }

    /// Whether it gets this input.
    pub fn gets(&self, input: &str) -> bool {
        self.inputs.iter().any(|own| own.as_str() == input)
    }
}
