//! Stage `average`: each condition of a session has a table for each alignment of means against time,
//! and one of force against position. If there is no mean, they are empty and their note says why.

use crate::figures::drawing::{Drawing, Figured};
use crate::shared::conditions::{Repeats, repeats, sessions, trial_sources};
use crate::shared::making::{derived, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, open_all};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError, Parameters, SessionLoop, WhyNot};
use zwidth_figures::{About, EnvironmentOfPeople, MEAN_LOOPS, ModeOfPeople, draws_each};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Environment, Source};
use zwidth_tables::{Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "average", version: zwidth_average::VERSION };

/// The average of a condition with an alignment: `average/P01.S01.spring.hybrid.parquet` at onset,
/// `….hybrid.landmarks.parquet` by landmarks.
pub(crate) fn aligned(layout: &Layout, repeats: &Repeats, alignment: Alignment) -> PathBuf {
    let suffix = match alignment {
        Alignment::Onset => "",
        Alignment::Landmarks => ".landmarks",
    };
    derived(layout, format!("average/{}{suffix}.parquet", repeats.key))
}

/// The mean of force against position of a condition: `average/P01.S01.spring.hybrid.loop.parquet`.
pub(crate) fn looped(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("average/{}.loop.parquet", repeats.key))
}

/// Every average of the study aligned at onset: what the summary speaks of.
pub(crate) fn at_onset(data: &StudyData) -> Vec<PathBuf> {
    repeats(data).iter().map(|r| aligned(&data.layout, r, Alignment::Onset)).collect()
}

/// What an average of a condition depends on besides its trials.
pub(crate) fn parameters(data: &StudyData, repeats: &Repeats) -> Parameters {
    Parameters { analysis: data.study.analysis, scene: repeats.environment.scene }
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    for repeats in repeats(data) {
        let name = format!("average {}", repeats.who);
        let parameters = OfTrials::new(parameters(data, &repeats), &repeats.trials);
        let files = files(&repeats.trials);
        // In the order of `make`.
        let outputs = vec![
            aligned(&data.layout, &repeats, Alignment::Onset),
            aligned(&data.layout, &repeats, Alignment::Landmarks),
            looped(&data.layout, &repeats),
        ];
        let job = Job::new(STAGE, name, parameters, files, outputs, make);
        jobs.push(job.of_part(repeats.key));
    }
    for people in over_people(data) {
        let environment = &people.environment.id;
        let mode = &data.study.modes[people.mode].id;
        let name = format!("average over participants {environment} {mode}");
        let level = data.study.analysis.confidence;
        jobs.push(Job::new(STAGE, name, level, people.sessions, vec![people.mean], make_people));
    }
    jobs
}

/// One condition in which several participants have trials.
struct People<'a> {
    environment: &'a Environment,
    /// Its place among the study's modes.
    mode: usize,
    /// The mean loops of every session.
    sessions: Vec<PathBuf>,
    /// The mean over participants.
    mean: PathBuf,
}

/// The conditions that several participants have, of those with something rendered.
fn over_people(data: &StudyData) -> Vec<People<'_>> {
    let all = sessions(data);
    let mut conditions = Vec::new();
    for environment in &data.study.environments {
        // Free motion has no mean course, and neither has a questionnaire.
        if !environment.scene.pushes_back() {
            continue;
        }
        for (place, mode) in data.study.modes.iter().enumerate() {
            let repeats: Vec<Repeats> =
                all.iter().filter_map(|session| session.repeats(environment, mode)).collect();
            let first = repeats.iter().filter_map(|repeats| repeats.trials.first());
            let people: BTreeSet<_> = first.map(|trial| &trial.meta.participant).collect();
            // One person's sessions have a mean, but none over participants.
            if people.len() > 1 {
                let name = format!("average/people.{}.{}.parquet", environment.id, mode.id);
                let sessions = repeats.iter().map(|r| looped(&data.layout, r)).collect();
                let mean = derived(&data.layout, name);
                conditions.push(People { environment, mode: place, sessions, mean });
            }
        }
    }
    conditions
}

fn make_people(level: &f64, sessions: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let columns = zwidth_average::looked_at();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    // Of a large study the tables together would take far more memory than the courses.
    let loops = sessions
        .par_iter()
        .map(|file| SessionLoop::of(&Table::columns_from_parquet(file, &columns)?));
    let loops: Vec<_> = loops.collect::<Result<_, TableError>>()?;
    let table = match zwidth_average::over_participants(loops.into_iter().flatten(), *level)? {
        Some(table) => table,
        None => zwidth_average::no_loop(&WhyNot::Nobody)?,
    };
    write_tables(&[table], making, Vec::new())
}

/// What the figure over participants depends on besides tables.
#[derive(Serialize)]
struct Drawn {
    about: About,
    environments: Vec<(Environment, Vec<usize>)>,
    sources: Vec<Source>,
}

/// The figure of the means over participants, if there are several.
pub(crate) fn figure(data: &StudyData) -> Option<Drawing> {
    let people = over_people(data);
    // Conditions of one environment follow each other.
    let environments = people.chunk_by(|a, b| a.environment.id == b.environment.id).map(|own| {
        let modes = own.iter().map(|condition| condition.mode).collect();
        (own[0].environment.clone(), modes)
    });
    let drawn = Drawn {
        about: About::of(&data.study),
        environments: environments.collect(),
        sources: trial_sources(data),
    };
    let most = people.iter().map(|people| people.sessions.len()).max().unwrap_or(0);
    let mut files = OfPeople::new();
    for People { mean, sessions, .. } in people {
        // What is not drawn is no input: the figure would be made again whenever a session changes.
        files.push((mean, if draws_each(most) { sessions } else { Vec::new() }));
    }
    let trials = data.counting().count();
    (!files.is_empty())
        .then(|| Drawing::new(data, MEAN_LOOPS, [""; 0], drawn, files, draw).of(trials))
}

/// Each condition's mean over participants, and the means of its sessions where they are drawn.
type OfPeople = Vec<(PathBuf, Vec<PathBuf>)>;

fn draw(drawn: &Drawn, files: &OfPeople) -> Figured {
    let columns = zwidth_figures::loop_columns();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut tables = Vec::new();
    for (mean, sessions) in files {
        let mean =
            Table::columns_from_parquet(mean, &[columns.as_slice(), &["sessions"]].concat())?;
        let sessions = sessions.iter().map(|path| Table::columns_from_parquet(path, &columns));
        tables.push((mean, sessions.collect::<Result<Vec<Table>, _>>()?));
    }
    // Taken in turn: tables stand in the order of environments and their modes.
    let mut tables = tables.iter();
    let mut environments = Vec::new();
    for (environment, modes) in &drawn.environments {
        let modes = modes
            .iter()
            .zip(tables.by_ref())
            .map(|(index, (mean, sessions))| ModeOfPeople { index: *index, mean, sessions });
        environments.push(EnvironmentOfPeople { environment, modes: modes.collect() });
    }
    Ok((zwidth_figures::mean_loops(&drawn.about, &environments, &drawn.sources)?, Vec::new()))
}

/// The averages of one condition, by each alignment.
fn make(
    parameters: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (trials, problems) = open_all(files, &parameters.trials)?;
    let looped = match zwidth_average::mean_loop(&trials, &parameters.stage) {
        Ok(mean) => zwidth_average::loop_table(&mean)?,
        Err(AverageError::WhyNot(why)) => zwidth_average::no_loop(&why)?,
        Err(error) => return Err(error.into()),
    };
    let mut tables = Vec::new();
    for alignment in [Alignment::Onset, Alignment::Landmarks] {
        tables.push(match zwidth_average::average(&trials, &parameters.stage, alignment) {
            Ok(average) => zwidth_average::table(&[average])?,
            Err(AverageError::WhyNot(why)) => zwidth_average::no_average(&why)?,
            Err(error) => return Err(error.into()),
        });
    }
    tables.push(looped);
    // A mean without a column that could not be read is void.
    if let Some(error) = trials.iter().find_map(|trial| trial.columns().failure()) {
        return Err(error.into());
    }
    write_tables(&tables, making, problems)
}
