//! Stage `tables`: every derived table that people read, in every format.

use crate::{
    characterise, compare, freemotion, identify, ladder, likert, metrics, replay, report, trade,
};
use std::path::{Path, PathBuf};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::Coordinate;
use zwidth_tables::{Format, Table};

/// Its version is raised when a table would be written differently from the same data.
const STAGE: Stage = Stage { name: "tables", version: 5 };

/// The derived tables that are printed.
pub fn printed(data: &StudyData) -> Vec<PathBuf> {
    let mut tables = Vec::new();
    if metrics::of_study(data).is_some() {
        let [trials, conditions] = metrics::study_files(&data.layout);
        tables.extend([conditions, trials]);
    }
    tables.extend(freemotion::planes(data));
    tables.extend(freemotion::plants(data));
    tables.extend(ladder::of_study(data));
    tables.extend(replay::of_study(data));
    tables.extend(identify::tables(data));
    tables.extend(likert::tally(data));
    tables.extend(compare::tables(data));
    tables.extend(trade::tables(data));
    for (actuator, _) in characterise::actuators(data) {
        // Models and parameters; the curve is data of a figure.
        tables.extend(characterise::tables_of(&data.layout, actuator).into_iter().take(2));
    }
    tables.extend(report::tables(data));
    tables
}

/// Where a printed table lies in a format.
fn printed_as(layout: &Layout, stem: &str, format: Format) -> PathBuf {
    layout.reports().join("tables").join(format!("{stem}.{}", format.extension()))
}

/// The printed tables, as Parquet.
pub(crate) fn files(data: &StudyData) -> Vec<PathBuf> {
    printed(data)
        .iter()
        .map(|path| printed_as(&data.layout, &stem(path), Format::Parquet))
        .collect()
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    printed(data).into_iter().map(|path| job(data, path)).collect()
}

fn job(data: &StudyData, input: PathBuf) -> Job {
    let stem = stem(&input);
    let outputs = Format::ALL.iter().map(|f| printed_as(&data.layout, &stem, *f)).collect();
    Job::new(STAGE, format!("table {stem}"), data.study.coordinate, input, outputs, make)
}

fn make(coordinate: &Coordinate, input: &PathBuf, making: &Making) -> Result<Made, JobError> {
    let table = Table::from_parquet(input)?;
    let files = Format::ALL.into_iter().zip(making.outputs.iter().map(PathBuf::as_path));
    let files: Vec<_> = files.collect();
    Ok(Made { outputs: table.to_bytes(&files, *coordinate, making.from)?, ..Made::default() })
}
