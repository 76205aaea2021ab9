//! Stage `tables`: every derived table that people read, in every format; tables that are too long
//! to be read, only for programs.

pub(crate) mod long;
pub(crate) mod printed;

use crate::characterise::{self, Characterisation};
use crate::tables::long::for_programs;
use crate::tables::printed::Printed;
use crate::{
    compare, curves, freemotion, identify, ladder, likert, metrics, people, relations, replay,
    report, thresholds, trade,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_metrics::by_mode;
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Output, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::MetricId;
use zwidth_tables::{Format, Table, TableError, Wording, write_csv};

/// Its version is raised when a table would be written differently from the same data.
const STAGE: Stage = Stage { name: "tables", version: 28 };

/// The tables that are printed. The trade runs models, and modes and device come from study.toml:
/// neither is marked as simulated.
pub fn printed(data: &StudyData) -> Vec<Printed> {
    let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
    let answers = data.sessions.iter().any(|session| session.record.source.is_simulated());
    let sweeps = data.sweeps.iter().any(|sweep| sweep.source.is_simulated());
    let any = trials || answers || sweeps;
    [
        mark(of_trials(data), trials),
        mark(likert::printed(data), answers),
        thresholds::printed(data),
        // These are marked by themselves.
        compare::tables(data),
        curves::tables(data),
        relations::tables(data),
        people::tables(data),
        mark(trade::tables(data), false),
        mark(of_sweeps(data), sweeps),
        mark(report::of_data(data), any),
        mark(report::of_design(data), false),
    ]
    .concat()
}

/// Whole tables, marked if simulated data go into them.
fn mark(files: Vec<PathBuf>, simulated: bool) -> Vec<Printed> {
    files.iter().map(|file| Printed::whole(file).marked(simulated)).collect()
}

/// The tables of the trials' samples.
fn of_trials(data: &StudyData) -> Vec<PathBuf> {
    let mut tables = Vec::new();
    if metrics::of_study(data).is_some() {
        let [trials, conditions] = metrics::study_files(&data.layout);
        tables.extend([conditions, trials]);
    }
    tables.extend(freemotion::tables(data));
    tables.extend(ladder::of_study(data).files());
    tables.extend(replay::of_study(data).into_iter().flatten());
    tables.extend(identify::tables(data));
    tables
}

/// The tables of the sweeps: models and parameters. The curve is data of a figure.
fn of_sweeps(data: &StudyData) -> Vec<PathBuf> {
    let mut tables = Vec::new();
    for (actuator, _) in characterise::actuators(data) {
        let Characterisation { models, parameters, .. } =
            Characterisation::of(&data.layout, actuator);
        tables.extend([models.files(), parameters.files()].concat());
    }
    tables
}

/// Where a printed table lies in a format.
fn printed_as(layout: &Layout, stem: &str, format: Format) -> PathBuf {
    layout.reports().join("tables").join(format!("{stem}.{}", format.extension()))
}

/// The printed tables, as Parquet.
pub(crate) fn files(data: &StudyData) -> Vec<PathBuf> {
    let tables = printed(data).into_iter();
    tables.map(|table| printed_as(&data.layout, &table.name(), Format::Parquet)).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let for_programs = for_programs(data);
    let mut jobs = Vec::new();
    for table in printed(data) {
        let name = table.name();
        let formats = Format::ALL
            .into_iter()
            .filter(|f| f.is_for_programs() || !for_programs.contains(&name));
        let outputs = formats.map(|f| printed_as(&data.layout, &name, f)).collect();
        let printing = Printing {
            wording: Wording::of(&data.study),
            simulated: table.simulated,
            metric: table.metric.clone(),
        };
        jobs.push(Job::new(STAGE, format!("table {name}"), printing, table, outputs, make));
    }
    jobs
}

/// How a table is printed.
#[derive(Serialize)]
struct Printing {
    wording: Wording,
    simulated: bool,
    metric: Option<MetricId>,
}

fn make(printing: &Printing, table: &Printed, making: &Making) -> Result<Made, JobError> {
    let mut files = Vec::new();
    for path in making.outputs {
        let mut formats = Format::ALL.into_iter();
        let format = formats.find(|f| path.extension().is_some_and(|e| e == f.extension()));
        files.extend(format.map(|format| (format, path.as_path())));
    }
    // Formats for people are laid out from the whole table; the others can be of any length.
    if table.metric.is_none() && files.iter().all(|(format, _)| format.is_for_programs()) {
        let simulated = printing.simulated;
        let outputs = files.into_iter().map(|(format, path)| {
            let path = path.to_owned();
            let input = table.file.clone();
            let from = making.from.clone();
            // Written after the job's function has returned: it may borrow nothing of it.
            Output::Long(Box::new(move |out| {
                let parts = Table::parts(&input)?.map(|part| Ok(part?.with_mark(simulated)));
                match format {
                    Format::Parquet => Table::write_parts::<TableError>(parts, &from, &path, out)?,
                    _ => write_csv(parts, out)?,
                }
                Ok(())
            }))
        });
        return Ok(Made { outputs: outputs.collect(), ..Made::default() });
    }
    Ok(Made::of(write(&table.read()?, &files, &printing.wording, making.from)?))
}

/// The bytes of a printed table's files. For people the table of conditions has the modes beside
/// each other: with one metric per column it would take pages.
///
/// # Errors
/// Those of [`Table::to_bytes`].
pub fn write(
    table: &Table,
    files: &[(Format, &Path)],
    wording: &Wording,
    from: &BTreeMap<String, String>,
) -> Result<Vec<Vec<u8>>, TableError> {
    let narrow = (table.name() == "conditions").then(|| by_mode(table, &wording.modes));
    // Where two labels are alike it stays wide.
    let narrow = narrow.and_then(Result::ok);
    table.to_bytes(narrow.as_ref().unwrap_or(table), files, wording, from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::data;

    #[test]
    fn single_answers_are_a_table_that_is_printed() {
        let mut study = data();
        let meta = study.trials[0].meta.clone();
        let names = |study: &StudyData| -> Vec<String> {
            printed(study).iter().map(Printed::name).collect()
        };
        study.answers.clear();
        assert!(!names(&study).contains(&"answers".to_owned()));
        study.answers.push(zwidth_store::Answer {
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            trial: meta.trial,
            condition: meta.condition(),
            question: "felt".parse().unwrap(),
            value: 4.into(),
            time_ms: None,
        });
        assert!(names(&study).contains(&"answers".to_owned()));
        let csv = printed_as(&study.layout, "answers", Format::Csv);
        let jobs = jobs(&study);
        assert!(jobs.iter().any(|job| job.outputs.contains(&csv)));
    }
}
