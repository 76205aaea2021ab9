//! Stage `average`: two tables a condition of a session, one for each alignment; without a mean
//! they are empty and their note says why.

use super::{
    JobError, Repeats, analysis_parameters, derived, known, made, paths, read_all, repeats,
};
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError};
use zwidth_runner::Job;
use zwidth_store::{Layout, Signal, StudyData, Trial};
use zwidth_tables::Table;

/// The average of a condition with the alignment asked for: `average/P01.S01.spring.hybrid.parquet`
/// at onset, `….hybrid.landmarks.parquet` by landmarks.
pub(super) fn aligned(layout: &Layout, repeats: &Repeats, alignment: Alignment) -> PathBuf {
    let suffix = match alignment {
        Alignment::Onset => "",
        Alignment::Landmarks => ".landmarks",
    };
    derived(layout, format!("average/{}{suffix}.parquet", repeats.key))
}

/// Every average of the study aligned at onset: what the summary speaks of.
pub(super) fn all(data: &StudyData) -> Vec<PathBuf> {
    jobs(data).into_iter().filter_map(|job| job.outputs.into_iter().next()).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    repeats(data).into_iter().map(|repeats| job(data, repeats)).collect()
}

fn job<'a>(data: &'a StudyData, repeats: Repeats<'a>) -> Job<'a> {
    let outputs =
        Alignment::ALL.map(|alignment| aligned(&data.layout, &repeats, alignment)).to_vec();
    let (out, trials) = (outputs.clone(), repeats.trials);
    Job {
        stage: "average",
        name: format!("average {}", repeats.who),
        version: zwidth_average::VERSION,
        parameters: format!("{}; {}", analysis_parameters(data), known(&trials)),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, problems) = read_all(&trials, Signal::all());
            let average = |alignment| average(&trials, data, alignment);
            let tables = Alignment::ALL.into_iter().map(average).collect::<Result<Vec<_>, _>>()?;
            made(&tables, &out, from, problems)
        }),
    }
}

/// The average's table; where there is none and no fault, an empty one that says why.
fn average(trials: &[Trial], data: &StudyData, alignment: Alignment) -> Result<Table, JobError> {
    match zwidth_average::average(trials, &data.study, alignment) {
        Ok(average) => Ok(zwidth_average::table(&[average])?),
        Err(AverageError::WhyNot(why)) => {
            Ok(zwidth_average::table(&[])?.with_note(sentence(&why.to_string())))
        }
        Err(error) => Err(error.into()),
    }
}

/// A reason as a sentence.
fn sentence(reason: &str) -> String {
    let mut letters = reason.chars();
    let first = letters.next().map(|c| c.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}.", letters.as_str().trim_end_matches('.'))
}
