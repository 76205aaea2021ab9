//! What a stage of the study's own gets: tables in `in/`, of trials that count alone.

use super::parameters::{Parameters, StageTrial};
use crate::likert;
use crate::metrics::join_tables;
use crate::shared::handle::Derived;
use crate::shared::trials::Recordings;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use zwidth_results::{GivenAnswer, OutsideValue, Row as _, TrialKey};
use zwidth_runner::{Inputs, JobError, Provenance};
use zwidth_store::{Lasting, SamplesWriter, Signal, Trial, read_trial_and_channels};
use zwidth_study::{Channel, ChannelId, OwnStage, StageFormat};
use zwidth_tables::{Column, Field, Table, Type, Values, write_csv};

/// The files that a stage's job reads.
pub(super) struct StageFiles {
    /// Those that the stage consists of.
    pub(super) own: Vec<PathBuf>,
    /// The recordings of all trials, where it gets samples.
    pub(super) trials: Option<Recordings>,
    /// The signals that any trial recorded.
    pub(super) signals: BTreeSet<Signal>,
    /// The study's own quantities per sample.
    pub(super) channels: Vec<Channel>,
    /// The tables of metrics of each session, where it gets metrics. Those of the whole study have the
    /// stage's own, too.
    pub(super) metrics: Option<Vec<Vec<PathBuf>>>,
    /// The answers, where it gets them; nothing inside where nothing was answered.
    pub(super) answers: Option<Option<Derived<GivenAnswer>>>,
    /// The stages whose tables it gets, with one for each metric that they give.
    pub(super) stages: Vec<(OwnStage, Vec<Derived<OutsideValue>>)>,
}

impl Inputs for StageFiles {
    fn files(&self) -> Vec<PathBuf> {
        let mut files = self.own.clone();
        files.extend(self.trials.files());
        files.extend(self.metrics.files());
        files.extend(self.answers.files());
        files.extend(self.stages.iter().flat_map(|(_, tables)| tables.files()));
        files
    }
}

/// Trials that are read at a time: enough for all cores, few enough for memory.
const TRIALS_AT_ONCE: usize = 32;

/// Writes all that a stage gets into a folder; returns what had to be left out, and why.
pub(super) fn write(
    parameters: &Parameters,
    files: &StageFiles,
    folder: &Path,
) -> Result<Vec<String>, JobError> {
    let mut problems = Vec::new();
    if let Some(trials) = &files.trials {
        let channels: Vec<ChannelId> = files.channels.iter().map(|own| own.id.clone()).collect();
        let read = |(file, trial): (&std::sync::Arc<Path>, &StageTrial)| {
            let read = read_trial_and_channels(file, files.signals.iter().copied(), &channels);
            read.map(|read| Trial { meta: trial.labelled(read.meta), ..read })
        };
        let mut unread = Vec::new();
        let parts = trials
            .chunks(TRIALS_AT_ONCE)
            .zip(parameters.trials.chunks(TRIALS_AT_ONCE))
            .flat_map(|(files, trials)| files.par_iter().zip(trials).map(read).collect::<Vec<_>>());
        let parts = parts.filter_map(|part| match part {
            Ok(read) => Some(Ok(read)),
            // The disk's fault is no finding about a trial.
            Err(error) if error.by_system => Some(Err(JobError::from(error))),
            Err(error) => {
                unread.push(error.to_string());
                None
            }
        });
        match parameters.format {
            StageFormat::Parquet => write_samples(parts, files, folder)?,
            StageFormat::Csv => {
                let tables = parts.map(|part| Ok(table_of(&part?, files)?));
                write_table("samples", parameters.format, folder, tables)?;
            }
        }
        problems.extend(unread);
    }
    if let Some(sessions) = &files.metrics {
        let parts = sessions.iter().map(|tables| join_tables(tables));
        write_table("metrics", parameters.format, folder, parts)?;
    }
    if let Some(answers) = &files.answers {
        let rows = answers.as_ref().map(likert::read_counting).transpose()?.unwrap_or_default();
        let table = Table::of_rows(&rows).map_err(JobError::from);
        write_table("answers", parameters.format, folder, std::iter::once(table))?;
    }
    for (stage, tables) in &files.stages {
        let table = of_stage(&parameters.trials, stage, tables);
        write_table(stage.id.as_str(), parameters.format, folder, std::iter::once(table))?;
    }
    Ok(problems)
}

/// Writes samples as Parquet, a row group for each trial. The program reads them once, so nothing is packed.
fn write_samples(
    parts: impl Iterator<Item = Result<Trial, JobError>>,
    files: &StageFiles,
    folder: &Path,
) -> Result<(), JobError> {
    let path = folder.join("samples.parquet");
    let out = BufWriter::new(File::create(&path)?);
    let signals: Vec<Signal> = files.signals.iter().copied().collect();
    let mut table =
        SamplesWriter::begin(out, &signals, &files.channels, false, Lasting::Once, &path)?;
    for part in parts {
        let Trial { meta, samples, .. } = part?;
        table.add(&meta, &samples)?;
    }
    Ok(table.end(BTreeMap::new())?)
}

/// Writes a table that is given in parts.
fn write_table(
    name: &str,
    format: StageFormat,
    folder: &Path,
    parts: impl Iterator<Item = Result<Table, JobError>>,
) -> Result<(), JobError> {
    let path = folder.join(format!("{name}.{}", format.as_str()));
    let mut out = BufWriter::new(File::create(&path)?);
    match format {
        StageFormat::Parquet => Table::write_parts(parts, &Provenance::new(), &path, &mut out)?,
        StageFormat::Csv => {
            let mut parts = parts.peekable();
            // What is read for a part may fail, and `write_csv` knows errors of tables alone.
            let mut failed = None;
            let good = std::iter::from_fn(|| match parts.next()? {
                Ok(table) => Some(Ok(table)),
                Err(error) => {
                    failed = Some(error);
                    None
                }
            });
            write_csv(good, &mut out)?;
            if let Some(error) = failed {
                return Err(error);
            }
        }
    }
    Ok(out.flush()?)
}

/// The samples of a trial, each with the trial's key.
fn table_of(trial: &Trial, files: &StageFiles) -> Result<Table, zwidth_tables::TableError> {
    let Trial { meta, samples, .. } = trial;
    let rows = samples.len();
    // Of a million samples the key is the same: its columns are made of one.
    let mut columns = TrialKey::columns(&[TrialKey::from(meta)]);
    columns.iter_mut().for_each(|column| repeat(&mut column.values, rows));
    // What a trial lacks is null in its rows: every part of the table has the same columns.
    let values = |values: Option<&[f64]>| match values {
        Some(values) => Values::Float(values.iter().map(|value| Some(*value)).collect()),
        None => Values::Float(vec![None; rows]),
    };
    for signal in files.signals.iter().copied() {
        let of = signal.column();
        let field = Field {
            name: of.name.into(),
            unit: of.unit.into(),
            description: of.description.into(),
            kind: Type::Float,
        };
        columns.push(Column { field, values: values(samples.get(signal)) });
    }
    for channel in &files.channels {
        let field = Field {
            name: channel.id.to_string().into(),
            unit: channel.unit.clone().into(),
            description: channel.description.clone().into(),
            kind: Type::Float,
        };
        columns.push(Column { field, values: values(samples.channel(&channel.id)) });
    }
    Table::new("samples", "Samples of the trials that count", columns)
}

/// As many times the first value.
fn repeat(values: &mut Values, rows: usize) {
    match values {
        Values::Float(all) => all.resize(rows, all.first().copied().flatten()),
        Values::Integer(all) => all.resize(rows, all.first().copied().flatten()),
        Values::Text(all) => all.resize(rows, all.first().cloned().flatten()),
        Values::Flag(all) => all.resize(rows, all.first().copied().flatten()),
    }
}

/// The table of another stage: a row for each trial, a column for each metric.
fn of_stage(
    trials: &[StageTrial],
    stage: &OwnStage,
    tables: &[Derived<OutsideValue>],
) -> Result<Table, JobError> {
    let keys: Vec<TrialKey> = trials.iter().map(StageTrial::key).collect();
    let mut columns = TrialKey::columns(&keys);
    for (metric, table) in stage.gives.iter().zip(tables) {
        let mut values = BTreeMap::new();
        for OutsideValue { participant, session, trial, value } in table.read()? {
            values.extend(value.map(|value| ((participant, session, trial), value)));
        }
        let of = |key: &TrialKey| {
            values.get(&(key.participant.clone(), key.session.clone(), key.trial)).copied()
        };
        let field = Field {
            name: metric.id.to_string().into(),
            unit: metric.unit.clone().into(),
            description: metric.label.clone().into(),
            kind: Type::Float,
        };
        columns.push(Column { field, values: Values::Float(keys.iter().map(of).collect()) });
    }
    let title = format!("What the stage {} gives", stage.id);
    Ok(Table::new(stage.id.as_str(), &title, columns)?)
}
