//! Stages of the study's own: programs that `[[stage]]` of study.toml names. Each is a job whose
//! function starts the program, the stated exception to jobs that only compute: its key has the
//! command, the program's files and all that it reads.

mod figures;
mod inputs;
mod parameters;
mod script;

pub use script::{ReadScript, read_program, read_script};

use crate::shared::conditions::{repeats, trial_sources};
use crate::shared::own_stages::{figure_files, values};
use crate::shared::trials::label_trials;
use crate::{likert, metrics};
use inputs::StageFiles;
use parameters::{Parameters, StageTrial};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;
use zwidth_import::{StudyTrials, outside_values};
use zwidth_results::{OutsideValue, Row as _, TrialKey};
use zwidth_runner::{
    HeldSignals, Inputs as _, Job, JobError, MOST_PRINTED, Made, Making, Script, ScriptError,
    Stage, last_printed, run_script,
};
use zwidth_store::{Layout, Signal, StudyData, TrialEntry};
use zwidth_study::{OwnStage, Source, StudyId, printable_lines};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "stage", version: 1 };

/// What the table is called that a stage writes into `out/`, in either format.
const TABLES: [&str; 2] = ["table.parquet", "table.csv"];

/// The files of its own that a stage consists of.
fn own_files(layout: &Layout, stage: &OwnStage) -> Vec<PathBuf> {
    stage.files.iter().map(|file| layout.analysis().join(file)).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut trials: Vec<&TrialEntry> =
        repeats(data).into_iter().flat_map(|repeats| repeats.trials).collect();
    trials.sort_by_key(|trial| (&trial.meta.participant, &trial.meta.session, trial.meta.trial));
    // Before anything is recorded, or while all of it is sealed, there is nothing to give them.
    if trials.is_empty() {
        return Vec::new();
    }
    let recorded: BTreeSet<Signal> =
        trials.iter().flat_map(|trial| trial.said.signals.iter().copied()).collect();
    let is_simulated = trial_sources(data).into_iter().any(Source::is_simulated);
    let jobs = data.study.stages.iter().map(|stage| {
        let layout = &data.layout;
        let labelled = trials.iter().zip(label_trials(&trials)).map(|(trial, label)| StageTrial {
            participant: trial.meta.participant.clone(),
            session: trial.meta.session.clone(),
            environment: trial.meta.environment.clone(),
            source: trial.meta.source,
            label,
        });
        let metrics = data.study.of_stage(&stage.id);
        let parameters = Parameters {
            command: stage.command.clone(),
            inputs: stage.inputs.clone(),
            columns: stage.columns.clone(),
            format: stage.format,
            gives: stage.gives.clone(),
            figures: stage.figures.clone(),
            trials: labelled.collect(),
            simulated: is_simulated,
            stage: stage.clone(),
            study: layout.study().clone(),
            metrics: metrics.cloned().collect(),
        };
        let of_others = data.study.stages.iter().filter(|other| stage.gets(other.id.as_str()));
        let tables = |other: &OwnStage| {
            other.gives.iter().map(|metric| values(layout, other, metric)).collect::<Vec<_>>()
        };
        let channels = data.study.channels.iter().filter(|own| stage.takes(own.id.as_str()));
        let inputs = StageFiles {
            own: own_files(layout, stage),
            trials: stage.gets("samples").then(|| trials.iter().map(|t| t.path.clone()).collect()),
            signals: recorded.iter().copied().filter(|own| stage.takes(own.name())).collect(),
            channels: channels.cloned().collect(),
            metrics: stage.gets("metrics").then(|| metrics::of_sessions(data)),
            answers: stage.gets("answers").then(|| likert::answers(data)),
            stages: of_others.map(|other| (other.clone(), tables(other))).collect(),
        };
        let tables = stage.gives.iter().flat_map(|metric| values(layout, stage, metric).files());
        let figures = stage.figures.iter().flat_map(|figure| figure_files(layout, stage, figure));
        let outputs = tables.chain(figures).collect();
        Job::new(STAGE, format!("stage {}", stage.id), parameters, inputs, outputs, make)
    });
    jobs.collect()
}

fn make(parameters: &Parameters, files: &StageFiles, making: &Making) -> Result<Made, JobError> {
    let stage = &parameters.stage;
    let read = read_script(making.root, &parameters.study, stage)?;
    check_unchanged(&read, &files.own, making)?;
    if !making.scripts.allow(&read.digest) {
        return Err(not_allowed(&read, stage, &parameters.study).into());
    }
    // Signals are held back as long as the folder is there.
    let signals = HeldSignals::hold()
        .map_err(|e| format!("Ctrl-C could not reach the program, so it is not started: {e}"))?;
    let folder = tempfile::Builder::new().prefix("zwidth-stage-").tempdir().map_err(|e| {
        format!("no folder can be made for it in {}: {e}", std::env::temp_dir().display())
    })?;
    let work = folder.path().join("work");
    let made = in_folder(&work, parameters, files, &read, making, &signals);
    // What the program printed, and errors about its table, name files by where they lay.
    let nowhere = work.join("").to_string_lossy().into_owned();
    made.map_err(|error| error.to_string().replace(&nowhere, "").into())
}

/// Runs the program in a folder, and takes what it gives.
fn in_folder(
    work: &Path,
    parameters: &Parameters,
    files: &StageFiles,
    read: &ReadScript,
    making: &Making,
    signals: &HeldSignals,
) -> Result<Made, JobError> {
    let stage = &parameters.stage;
    for folder in ["in", "out/figures"] {
        fs::create_dir_all(work.join(folder))?;
    }
    read.write_into(work)?;
    let problems = inputs::write(parameters, files, &work.join("in"))?;
    let printed = work.with_file_name("printed");
    let timeout = Duration::from_secs(stage.timeout_s.into());
    let script = Script { command: &stage.command, folder: work, printed: &printed, timeout };
    run_script(&script, signals).map_err(|error| describe(&error, stage, &printed))?;
    let mut outputs = Vec::new();
    let table = table_in(&work.join("out"), stage)?;
    if let Some(table) = &table {
        for (metric, rows) in parameters.metrics.iter().zip(rows_of(table, parameters)?) {
            let title = format!("{}, by the stage {} of the study", metric.label, stage.id);
            let table = Table::of_rows(&rows)?
                .called(OutsideValue::NAME, title)
                .with_unit("value", &metric.unit)
                .with_mark(parameters.simulated);
            let path = making.outputs.get(outputs.len()).ok_or("it has no place for a table")?;
            outputs.push(table.to_parquet(making.from, path)?);
        }
    }
    let (figures, care) = figures::take(&work.join("out/figures"), parameters, making)?;
    outputs.extend(figures);
    Ok(Made { problems, care, ..Made::of(outputs) })
}

/// The files that are run must be those that the key names: they were hashed a moment ago.
fn check_unchanged(read: &ReadScript, paths: &[PathBuf], making: &Making) -> Result<(), JobError> {
    for (file, path) in read.files.iter().zip(paths) {
        if making.hash_of(path).is_some_and(|hash| hash != file.blake3) {
            let shown = making.shown(path);
            return Err(format!("{shown} changed while the run went on; run again").into());
        }
    }
    Ok(())
}

/// What to say where nobody has allowed a stage.
fn not_allowed(read: &ReadScript, stage: &OwnStage, study: &StudyId) -> String {
    let files = read.files.iter().map(|file| file.file.as_str()).collect::<Vec<_>>().join(", ");
    let files = if files.is_empty() { "no files" } else { &files };
    format!(
        "nobody has allowed it here: it would run `{}` with your rights ({files} of analysis/{study}); look at \
         them, then `zwidth allow {study}`, or run once with --allow-scripts",
        stage.command_line(),
    )
}

/// Why the program gave nothing, with the last that it printed.
fn describe(error: &ScriptError, stage: &OwnStage, printed: &Path) -> String {
    let program = stage.command.first().map(String::as_str).unwrap_or_default();
    let what = match error {
        ScriptError::NotStarted(why) => {
            return format!(
                "'{program}' cannot be started ({why}); install it, or change command in study.toml"
            );
        }
        ScriptError::Stopped => return "it was ended because zwidth was told to end".to_owned(),
        ScriptError::ExitCode(code) => format!("'{program}' ended with exit code {code}"),
        ScriptError::Signal(signal) => format!("'{program}' was ended by signal {signal}"),
        ScriptError::TooLong => format!(
            "'{program}' was ended after {} s; give it more time with timeout_s in study.toml",
            stage.timeout_s
        ),
        ScriptError::PrintedTooMuch => format!(
            "'{program}' was ended because it printed more than {} MiB; let it print less",
            MOST_PRINTED >> 20
        ),
        ScriptError::Lost(why) => format!("'{program}' was lost: {why}"),
    };
    match last_printed(printed) {
        Ok((text, _)) if text.trim().is_empty() => format!("{what}; it printed nothing"),
        Ok((text, has_more)) => {
            let which = if has_more { "the last that it printed" } else { "it printed" };
            format!("{what}; {which}:\n{}", printable_lines(text.trim_end()))
        }
        Err(error) => format!("{what}; what it printed cannot be read: {error}"),
    }
}

/// The table that the program wrote, if it gives metrics.
fn table_in(out: &Path, stage: &OwnStage) -> Result<Option<PathBuf>, JobError> {
    let all = TABLES.map(|name| out.join(name));
    let there: Vec<&PathBuf> =
        all.iter().filter(|path| fs::symlink_metadata(path).is_ok()).collect();
    match (there.as_slice(), stage.gives.is_empty()) {
        ([], true) => Ok(None),
        ([_, ..], true) => {
            Err("it wrote a table, but gives no metrics; name them by gives = [...] in study.toml"
                .into())
        }
        ([], false) => {
            Err("it wrote no table; let it write out/table.parquet or out/table.csv".into())
        }
        ([only], false) => Ok(Some((*only).clone())),
        (_, false) => {
            Err("it wrote both out/table.parquet and out/table.csv; let it write one of them"
                .into())
        }
    }
}

/// The rows of each metric in the program's table, in the order of trials.
fn rows_of(table: &Path, parameters: &Parameters) -> Result<Vec<Vec<OutsideValue>>, JobError> {
    let keys: Vec<TrialKey> = parameters.trials.iter().map(StageTrial::key).collect();
    // A link could lead to a pipe, or to a file that changes meanwhile.
    if !fs::symlink_metadata(table)?.is_file() {
        return Err(format!("{} is not a regular file; write it as one", table.display()).into());
    }
    let rows = outside_values(table, &parameters.metrics, &StudyTrials::of_keys(&keys), None);
    let mut rows = rows.map_err(|errors| {
        let mut told: Vec<String> =
            errors.iter().take(MOST_TOLD).map(ToString::to_string).collect();
        let more = errors.len().saturating_sub(MOST_TOLD) + errors.more();
        told.extend((more > 0).then(|| format!("and {more} more")));
        told.join("\n")
    })?;
    for own in &mut rows {
        own.sort_by(|a, b| {
            let key =
                |row: &OutsideValue| (row.participant.clone(), row.session.clone(), row.trial);
            key(a).cmp(&key(b))
        });
    }
    Ok(rows)
}

/// Errors of a table that are told one by one.
const MOST_TOLD: usize = 10;
