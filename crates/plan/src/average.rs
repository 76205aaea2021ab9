//! Stage `average`: each condition of a session has two tables, one for each alignment. If there is
//! no mean, they are empty and their note says why.

use crate::conditions::{Repeats, repeats};
use crate::making::{derived, write_tables};
use crate::trials::{OfTrials, files, read_all};
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError, Parameters};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StudyData};
use zwidth_tables::Table;

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

/// Every average of the study aligned at onset: what the summary speaks of.
pub(crate) fn at_onset(data: &StudyData) -> Vec<PathBuf> {
    repeats(data).iter().map(|r| aligned(&data.layout, r, Alignment::Onset)).collect()
}

/// What an average of a condition depends on besides its trials.
pub(crate) fn parameters(data: &StudyData, repeats: &Repeats) -> Parameters {
    Parameters { analysis: data.study.analysis, scene: repeats.environment.scene }
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    repeats(data).iter().map(|repeats| job(data, repeats)).collect()
}

/// The averages of one condition, by each alignment.
fn job(data: &StudyData, repeats: &Repeats) -> Job {
    Job::new(
        STAGE,
        format!("average {}", repeats.who),
        OfTrials::new(parameters(data, repeats), &repeats.trials),
        files(&repeats.trials),
        Alignment::ALL.map(|alignment| aligned(&data.layout, repeats, alignment)).to_vec(),
        make,
    )
    .of_part(&repeats.key)
}

fn make(
    of: &OfTrials<Parameters>,
    files: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let (trials, problems) = read_all(files, &of.trials, Signal::all());
    let table = |alignment| -> Result<Table, JobError> {
        match zwidth_average::average(&trials, &of.stage, alignment) {
            Ok(average) => Ok(zwidth_average::table(&[average])?),
            Err(AverageError::WhyNot(why)) => Ok(zwidth_average::no_average(&why)?),
            Err(error) => Err(error.into()),
        }
    };
    let tables = Alignment::ALL.into_iter().map(table).collect::<Result<Vec<_>, _>>()?;
    write_tables(&tables, making, problems)
}
