//! Stage `tables`: every derived table that people read, in every format; tables that are too long
//! to be read, only for programs.

pub(crate) mod long;
pub(crate) mod printed;

use crate::characterise::{self, Characterisation};
use crate::tables::long::for_programs;
use crate::tables::printed::Printed;
use crate::{compare, freemotion, identify, ladder, likert, metrics, replay, report, trade};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_metrics::by_mode;
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Output, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::MetricId;
use zwidth_tables::{Format, Table, TableError, Wording, write_csv};

/// Its version is raised when a table would be written differently from the same data.
const STAGE: Stage = Stage { name: "tables", version: 23 };

/// The tables that are printed. The trade runs models, and what modes and device are is written in
/// study.toml: neither is marked as simulated.
pub fn printed(data: &StudyData) -> Vec<Printed> {
    let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
    let answers = data.sessions.iter().any(|session| session.record.source.is_simulated());
    let sweeps = data.sweeps.iter().any(|sweep| sweep.source.is_simulated());
    let any = trials || answers || sweeps;
    let whole = |files: Vec<PathBuf>, simulated| {
        files.into_iter().map(move |file| Printed::whole(&file).marked(simulated))
    };
    whole(of_trials(data), trials)
        .chain(whole(likert::printed(data), answers))
        // These are marked by themselves.
        .chain(compare::tables(data))
        .chain(whole(trade::tables(data), false))
        .chain(whole(of_sweeps(data), sweeps))
        .chain(whole(report::of_data(data), any))
        .chain(whole(report::of_design(data), false))
        .collect()
}

/// What is made of the trials' samples.
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

/// What is made of the sweeps: models and parameters. The curve is data of a figure.
fn of_sweeps(data: &StudyData) -> Vec<PathBuf> {
    let actuators = characterise::actuators(data).into_iter();
    let found = actuators.map(|(id, _)| Characterisation::of(&data.layout, id));
    found.flat_map(|found| [found.models.files(), found.parameters.files()].concat()).collect()
}

/// Where a printed table lies in a format.
fn printed_as(layout: &Layout, stem: &str, format: Format) -> PathBuf {
    layout.reports().join("tables").join(format!("{stem}.{}", format.extension()))
}

/// The printed tables, as Parquet.
pub(crate) fn files(data: &StudyData) -> Vec<PathBuf> {
    let names = printed(data).into_iter().map(|table| table.name());
    names.map(|name| printed_as(&data.layout, &name, Format::Parquet)).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let for_programs = for_programs(data);
    printed(data).into_iter().map(|table| job(data, table, &for_programs)).collect()
}

/// How a table is printed.
#[derive(Serialize)]
struct Printing {
    wording: Wording,
    simulated: bool,
    metric: Option<MetricId>,
}

fn job(data: &StudyData, table: Printed, for_programs: &BTreeSet<String>) -> Job {
    let name = table.name();
    let formats =
        Format::ALL.into_iter().filter(|f| f.is_for_programs() || !for_programs.contains(&name));
    let outputs = formats.map(|f| printed_as(&data.layout, &name, f)).collect();
    let wording = Wording::of(&data.study);
    let simulated = table.simulated;
    let metric = table.metric.clone();
    let how = Printing { wording, simulated, metric };
    Job::new(STAGE, format!("table {name}"), how, table, outputs, make)
}

fn make(how: &Printing, table: &Printed, making: &Making) -> Result<Made, JobError> {
    let format = |path: &Path| {
        Format::ALL.into_iter().find(|f| path.extension().is_some_and(|e| e == f.extension()))
    };
    let files = making.outputs.iter().filter_map(|path| Some((format(path)?, path.as_path())));
    let files: Vec<_> = files.collect();
    if table.metric.is_none() && files.iter().all(|(format, _)| format.is_for_programs()) {
        let input = &table.file;
        let outputs = files
            .into_iter()
            .map(|(format, path)| long(format, path, how.simulated, input, making));
        return Ok(Made { outputs: outputs.collect(), ..Made::default() });
    }
    Ok(Made::of(write(&table.read()?, &files, &how.wording, making.from)?))
}

/// A file of a table that may be of any length.
fn long(format: Format, path: &Path, simulated: bool, input: &Path, making: &Making) -> Output {
    let path = path.to_owned();
    let input = input.to_owned();
    let from = making.from.clone();
    Output::Long(Box::new(move |out| {
        let parts = Table::parts(&input)?.map(|part| Ok(part?.with_mark(simulated)));
        match format {
            Format::Parquet => Table::write_parts::<TableError>(parts, &from, &path, out)?,
            _ => write_csv(parts, out)?,
        }
        Ok(())
    }))
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
