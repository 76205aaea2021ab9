//! Stage `average`: each condition of a session has a table for each alignment of means against time,
//! and one of force against position. If there is no mean, they are empty and their note says why.

use crate::figures::drawing::{Drawing, Figured};
use crate::shared::conditions::{Repeats, repeats, sessions};
use crate::shared::making::{derived, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, open_all};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError, Parameters, SessionLoop, WhyNot};
use zwidth_figures::{About, EnvironmentOfPeople, MEAN_LOOPS, ModeOfPeople, draws_each};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Environment, SceneKind, Source};
use zwidth_tables::{Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "average", version: zwidth_average::VERSION };

/// The average of a condition with the alignment asked for: `average/P01.S01.spring.hybrid.parquet`
/// at onset, `….hybrid.landmarks.parquet` by landmarks.
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
    let over_people = over_people(data).into_iter().map(|people| people.job(data));
    repeats(data).iter().map(|repeats| job(data, repeats)).chain(over_people).collect()
}

/// One condition in which several participants have trials.
struct People<'a> {
    environment: &'a Environment,
    mode: usize,
    /// The mean loops of every session.
    sessions: Vec<PathBuf>,
    /// The mean over participants.
    mean: PathBuf,
}

/// The conditions that several participants have, of those with something rendered.
fn over_people(data: &StudyData) -> Vec<People<'_>> {
    let all = sessions(data);
    let mut found = Vec::new();
    for environment in data.study.environments.iter().filter(|e| is_rendered(e)) {
        for (place, mode) in data.study.modes.iter().enumerate() {
            let of: Vec<Repeats> =
                all.iter().filter_map(|session| session.repeats(environment, mode)).collect();
            let first = of.iter().filter_map(|repeats| repeats.trials.first());
            let people: BTreeSet<_> = first.map(|trial| &trial.meta.participant).collect();
            if people.len() > 1 {
                let name = format!("average/people.{}.{}.parquet", environment.id, mode.id);
                let sessions = of.iter().map(|r| looped(&data.layout, r)).collect();
                let mean = derived(&data.layout, name);
                found.push(People { environment, mode: place, sessions, mean });
            }
        }
    }
    found
}

/// Free motion has no mean course, and of nothing known there is none.
fn is_rendered(environment: &Environment) -> bool {
    !matches!(environment.scene.kind(), SceneKind::Free | SceneKind::None)
}

impl People<'_> {
    fn job(self, data: &StudyData) -> Job {
        let environment = &self.environment.id;
        let mode = &data.study.modes[self.mode].id;
        let name = format!("average over participants {environment} {mode}");
        let level = data.study.analysis.confidence;
        Job::new(STAGE, name, level, self.sessions, vec![self.mean], make_people)
    }
}

fn make_people(level: &f64, sessions: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let looked_at = zwidth_average::looked_at();
    let names: Vec<&str> = looked_at.iter().map(String::as_str).collect();
    // Of a large study the tables together would take far more memory than the courses.
    let one = |file: &PathBuf| SessionLoop::of(&Table::columns_from_parquet(file, &names)?);
    let loops: Vec<_> = sessions.par_iter().map(one).collect::<Result<_, TableError>>()?;
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
    sources: BTreeSet<Source>,
}

/// The figure of the means over participants, if there are several.
pub(crate) fn figure(data: &StudyData) -> Option<Drawing> {
    let people = over_people(data);
    let mut environments: Vec<(Environment, Vec<usize>)> = Vec::new();
    for of in &people {
        match environments.last_mut().filter(|(last, _)| last.id == of.environment.id) {
            Some((_, modes)) => modes.push(of.mode),
            None => environments.push((of.environment.clone(), vec![of.mode])),
        }
    }
    let of = Drawn {
        about: About::of(&data.study),
        environments,
        sources: data.counting().map(|trial| trial.meta.source).collect(),
    };
    let most = people.iter().map(|people| people.sessions.len()).max().unwrap_or(0);
    let each = |sessions| if draws_each(most) { sessions } else { Vec::new() };
    let files: Vec<(PathBuf, Vec<PathBuf>)> =
        people.into_iter().map(|people| (people.mean, each(people.sessions))).collect();
    let trials = data.counting().count();
    (!files.is_empty())
        .then(|| Drawing::new(data, MEAN_LOOPS, [""; 0], of, OfPeople(files), draw).of(trials))
}

/// Each condition's mean over participants, and the means of its sessions where they are drawn.
struct OfPeople(Vec<(PathBuf, Vec<PathBuf>)>);

impl Inputs for OfPeople {
    fn files(&self) -> Vec<PathBuf> {
        self.0
            .iter()
            .flat_map(|(mean, sessions)| [mean].into_iter().chain(sessions))
            .cloned()
            .collect()
    }
}

fn draw(of: &Drawn, OfPeople(files): &OfPeople) -> Figured {
    let columns = zwidth_figures::loop_columns();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let read = |path: &PathBuf| Table::columns_from_parquet(path, &columns);
    let mut tables = Vec::new();
    for (mean, sessions) in files {
        let mean =
            Table::columns_from_parquet(mean, &[columns.as_slice(), &["sessions"]].concat())?;
        tables.push((mean, sessions.iter().map(read).collect::<Result<Vec<Table>, _>>()?));
    }
    let mut tables = tables.iter();
    let mut environments = Vec::new();
    for (environment, modes) in &of.environments {
        let modes = modes
            .iter()
            .zip(tables.by_ref())
            .map(|(index, (mean, sessions))| ModeOfPeople { index: *index, mean, sessions });
        environments.push(EnvironmentOfPeople { environment, modes: modes.collect() });
    }
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    Ok((zwidth_figures::mean_loops(&of.about, &environments, &sources)?, Vec::new()))
}

/// The averages of one condition, by each alignment.
fn job(data: &StudyData, repeats: &Repeats) -> Job {
    Job::new(
        STAGE,
        format!("average {}", repeats.who),
        OfTrials::new(parameters(data, repeats), &repeats.trials),
        files(&repeats.trials),
        [
            aligned(&data.layout, repeats, Alignment::Onset),
            aligned(&data.layout, repeats, Alignment::Landmarks),
            looped(&data.layout, repeats),
        ]
        .to_vec(),
        make,
    )
    .of_part(&repeats.key)
}

fn make(of: &OfTrials<Parameters>, files: &Recordings, making: &Making) -> Result<Made, JobError> {
    let (trials, problems) = open_all(files, &of.trials)?;
    let table = |alignment| -> Result<Table, JobError> {
        match zwidth_average::average(&trials, &of.stage, alignment) {
            Ok(average) => Ok(zwidth_average::table(&[average])?),
            Err(AverageError::WhyNot(why)) => Ok(zwidth_average::no_average(&why)?),
            Err(error) => Err(error.into()),
        }
    };
    let looped = match zwidth_average::mean_loop(&trials, &of.stage) {
        Ok(mean) => zwidth_average::loop_table(&mean)?,
        Err(AverageError::WhyNot(why)) => zwidth_average::no_loop(&why)?,
        Err(error) => return Err(error.into()),
    };
    let tables = [table(Alignment::Onset)?, table(Alignment::Landmarks)?, looped];
    // A mean without a column that could not be read is void.
    if let Some(error) = trials.iter().find_map(|trial| trial.columns().failure()) {
        return Err(error.into());
    }
    write_tables(&tables, making, problems)
}
