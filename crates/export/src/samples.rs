//! All samples as one table: Parquet with a row group for each trial, and CSV.

use crate::contents::Contents;
use crate::folder::Folder;
use crate::{ExportError, ExportedTrial};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;
use zwidth_store::{Lasting, Samples, SamplesWriter, StoreError, Trial};
use zwidth_study::{TaskLevel, TrialMeta};
use zwidth_tables::SYNTHETIC;

/// The table as Parquet.
pub(crate) const PARQUET: &str = "samples.parquet";
/// The table as CSV.
pub(crate) const CSV: &str = "samples.csv";

pub(crate) fn write_parquet(
    folder: &mut Folder,
    contents: &Contents,
    software: &str,
) -> Result<(), ExportError> {
    folder.write(PARQUET, "samples of all trials, a row group for each trial", |out| {
        let path = Path::new(PARQUET);
        let (signals, channels) = (&contents.signals, &contents.channels);
        let mut file =
            SamplesWriter::begin(out, signals, channels, contents.tasks, Lasting::Kept, path)?;
        for trial in &contents.trials {
            let Trial { meta, samples, .. } = trial.read()?;
            file.add(&meta, &samples)?;
        }
        let mut footer = BTreeMap::from([
            ("software".to_owned(), software.to_owned()),
            ("source".to_owned(), contents.source.clone()),
        ]);
        if contents.is_simulated {
            footer.insert("mark".to_owned(), SYNTHETIC.to_owned());
        }
        Ok(file.end(footer)?)
    })
}

pub(crate) fn write_csv(folder: &mut Folder, contents: &Contents) -> Result<(), ExportError> {
    let columns = contents.sample_columns()?;
    folder.write(CSV, "samples of all trials", |out| {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        write!(out, "{}\r\n", names.join(","))?;
        contents.trials.iter().try_for_each(|trial| add(out, trial, contents))
    })
}

/// The lines of a trial. Ids need no quotes.
fn add(out: &mut dyn Write, trial: &ExportedTrial, contents: &Contents) -> Result<(), ExportError> {
    let samples = trial.read()?.samples;
    let TrialMeta {
        participant, session, trial, repeat, environment, mode, source, presented, ..
    } = &trial.meta;
    let mut keys = format!(
        "{participant},{session},{trial},{repeat},{environment},{mode},{}",
        source.as_str()
    );
    if contents.tasks {
        keys += &match presented {
            Some(own) => {
                let level = own.level.map(TaskLevel::value).map(number).unwrap_or_default();
                format!(",{},{},{level}", own.task, own.interval)
            }
            None => ",,,".to_owned(),
        };
    }
    let columns = columns(&samples, contents);
    let mut lines = String::new();
    for row in 0..samples.len() {
        lines += &keys;
        for column in &columns {
            lines.push(',');
            if let Some(value) = column.and_then(|(values, _)| values.get(row)) {
                // Writing to a text does not fail.
                let _ = match column {
                    Some((_, true)) => write!(lines, "{value}"),
                    _ => write!(lines, "{}", number(*value)),
                };
            }
        }
        lines += "\r\n";
        if lines.len() > PART {
            out.write_all(lines.as_bytes())?;
            lines.clear();
        }
    }
    Ok(out.write_all(lines.as_bytes())?)
}

/// Bytes of lines that are written at a time.
const PART: usize = 1 << 20;

/// The columns of samples, in the order of the table, each with whether its numbers are whole; none
/// where the trial lacks it.
fn columns<'s>(samples: &'s Samples, contents: &Contents) -> Vec<Option<(&'s [f64], bool)>> {
    let signals = contents.signals.iter().map(|signal| {
        let is_whole = signal.column().storage == zwidth_store::Storage::U16;
        samples.get(*signal).map(|values| (values, is_whole))
    });
    let channels = contents.channels.iter();
    let channels =
        channels.map(|channel| samples.channel(&channel.id).map(|values| (values, false)));
    signals.chain(channels).collect()
}

/// A number, to the last bit: the shortest text that reads back as the same.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// The columns that a trial has: name, unit, values.
pub(crate) fn recorded<'a>(
    samples: &'a Samples,
    contents: &'a Contents,
) -> impl Iterator<Item = (&'a str, &'a str, &'a [f64])> {
    let signals = contents.signals.iter().filter_map(|signal| {
        let column = signal.column();
        Some((column.name, column.unit, samples.get(*signal)?))
    });
    let channels = contents.channels.iter().filter_map(|channel| {
        Some((channel.id.as_str(), channel.unit.as_str(), samples.channel(&channel.id)?))
    });
    signals.chain(channels)
}

/// What a trial's own file says of it, in words.
pub(crate) fn about(trial: &ExportedTrial) -> Vec<(&'static str, String)> {
    let TrialMeta {
        participant, session, trial, repeat, environment, mode, source, presented, ..
    } = &trial.meta;
    let mut about = vec![
        ("participant", participant.to_string()),
        ("session", session.to_string()),
        ("trial", trial.to_string()),
        ("repeat", repeat.to_string()),
        ("environment", environment.to_string()),
        ("mode", mode.to_string()),
        ("source", source.as_str().to_owned()),
    ];
    if let Some(own) = presented {
        about.push(("task", own.task.to_string()));
        about.push(("interval", own.interval.to_string()));
        about.extend(own.level.map(|level| ("level", number(level.value()))));
    }
    if source.is_simulated() {
        about.push(("mark", SYNTHETIC.to_owned()));
    }
    about
}

/// The error of what a form cannot hold.
pub(crate) fn refused(path: &str, what: &str, remedy: &str) -> ExportError {
    StoreError::new(Path::new(path), what, remedy).into()
}
