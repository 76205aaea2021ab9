//! Stage `tables`: every derived table that people read, in every format.

use super::{characterise, freemotion, identify, likert, metrics, replay};
use std::path::PathBuf;
use zwidth_runner::{Job, Made};
use zwidth_store::{Layout, StudyData};
use zwidth_tables::{Format, Table};

/// Version of the formats: raised when a table would be written differently from the same data.
const VERSION: u32 = 4;

/// The derived tables that are printed, if a job makes them.
pub(crate) fn printed(data: &StudyData) -> Vec<PathBuf> {
    let layout = &data.layout;
    let mut tables = vec![metrics::by_condition(layout), metrics::of_study(layout)];
    tables.extend([freemotion::planes_of(layout), freemotion::plants_of(layout)]);
    tables.extend(replay::tables_of(layout));
    tables.extend(identify::tables_of(layout));
    tables.push(likert::tally_of(layout));
    for (actuator, _) in characterise::actuators(data) {
        // Models and parameters; the curve is data of a figure.
        tables.extend(characterise::tables_of(layout, actuator).into_iter().take(2));
    }
    tables.extend(super::report::tables_of(layout));
    tables
}

/// Where a printed table lies in a format.
pub(crate) fn report(layout: &Layout, stem: &str, format: Format) -> PathBuf {
    layout.reports().join("tables").join(format!("{stem}.{}", format.extension()))
}

pub(super) fn jobs<'a>(data: &'a StudyData, planned: &[Job]) -> Vec<Job<'a>> {
    let is_made = |path: &PathBuf| planned.iter().any(|j| j.outputs.contains(path));
    printed(data).into_iter().filter(is_made).map(|path| job(data, path)).collect()
}

fn job(data: &StudyData, input: PathBuf) -> Job<'_> {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let outputs: Vec<PathBuf> =
        Format::ALL.iter().map(|f| report(&data.layout, &stem, *f)).collect();
    let coordinate = data.study.coordinate;
    let (file, out) = (input.clone(), outputs.clone());
    Job {
        stage: "tables",
        name: format!("table {stem}"),
        version: VERSION,
        parameters: format!("{coordinate:?}"),
        inputs: vec![input],
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let table = Table::from_parquet(&file)?;
            let files: Vec<_> =
                Format::ALL.into_iter().zip(out.iter().map(PathBuf::as_path)).collect();
            Ok(Made { outputs: table.to_bytes(&files, coordinate, from)?, ..Made::default() })
        }),
    }
}
