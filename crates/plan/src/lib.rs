//! The plan of a study: the jobs that its data need. Each file or folder binds one stage, a pure
//! function, to the files that it reads and makes; `shared` has their common parts.
//!
//! A stage is declared in one place: its name and version ([`zwidth_runner::Stage`]), the files of
//! each of its jobs, and what else its function gets, as one serialisable struct. There is no
//! domain logic here: what a stage does with its inputs is in the stage's own crate.

#![allow(clippy::ptr_arg)] // a job's function takes what the job holds, not a view of it

mod average;
mod characterise;
mod compare;
mod curves;
mod exported;
mod figures;
mod freemotion;
mod identify;
mod ladder;
mod likert;
mod metrics;
mod outside;
mod page;
mod people;
mod rehearsed;
mod relations;
mod replay;
mod report;
mod responses;
mod scenes;
mod shared;
mod stages;
mod tables;
#[cfg(test)]
mod tests;
mod thresholds;
mod trade;

pub use compare::{
    By, answers, asked_in_vain, claims, compared, comparison, effects, inflation_by_groups, peers,
    spreads, verdicts,
};
pub use curves::{compared_curves, spreads_of_curve};
pub use exported::{Exported, exported};
pub use figures::font::font;
pub use figures::{captions, chosen_in_vain, describe, on_demand};
pub use ladder::ladders;
pub use page::methods::recorded;
pub use page::preregistered::{analysis, plan_file, plan_finding, plan_text};
pub use page::{JOB as PAGE, file as page_file};
pub use rehearsed::{OtherSetups, Rehearsal, TwinOf, rehearsal, rehearsed, rehearsed_trials};
pub use replay::oscillations::{Oscillations, oscillations};
pub use report::built_in;
pub use responses::{Responses, responses};
pub use stages::{ReadScript, read_program, read_script};
pub use tables::printed::Printed;
pub use tables::{printed as printed_tables, write as write_table};
pub use thresholds::perception;
pub use trade::{Traded, scenes as trade_scenes};
pub use zwidth_compare::CurveSpread;
pub use zwidth_metrics::{in_words as metric_in_words, is_number as is_metric};

use rayon::prelude::*;
use zwidth_runner::Job;
use zwidth_store::{Findings, StudyData};

/// A stage, and those of its jobs that follow from the data alone.
type OfData = (&'static str, fn(&StudyData) -> Vec<Job>);

/// Each stage stands after those whose results it reads.
const OF_DATA: [OfData; 19] = [
    ("characterise", characterise::jobs),
    ("identify", identify::jobs),
    // Their metrics become columns of the next one's table; what they read comes from it, too.
    ("stage", stages::jobs),
    // Some of them rest on the identified plant.
    ("metrics", metrics::jobs),
    ("average", average::jobs),
    ("freemotion", freemotion::jobs),
    ("ladder", ladder::jobs),
    ("replay", replay::jobs),
    ("replay", replay::courses::jobs),
    ("replay", replay::runs::jobs),
    ("likert", likert::jobs),
    ("thresholds", thresholds::jobs),
    ("compare", compare::jobs),
    ("compare", curves::jobs),
    ("compare", relations::jobs),
    ("compare", people::jobs),
    ("thresholds", thresholds::over_people::jobs),
    ("trade", trade::jobs),
    ("simulate", scenes::jobs),
];

/// Stages that share their name with a figure or a file of the page, and the stage of the study's own
/// programs, which reads what later ones make.
const AMONG_ALL: [&str; 3] = ["likert", "replay", "stage"];

/// The jobs needed for `--only STAGE`: those of the stage, of the stages before it and of the tables.
/// In a large study they are planned in a fraction of the time that all jobs need. `None` if the stage
/// has no jobs, or needs more.
pub fn jobs_of_stage(data: &StudyData, stage: &str) -> Option<Vec<Job>> {
    let last = OF_DATA.iter().rposition(|(name, _)| *name == stage)?;
    // `--only` goes by the names of files too: those jobs are found among all alone.
    if AMONG_ALL.contains(&stage) {
        return None;
    }
    let mut jobs = jobs_of_stages(data, &OF_DATA[..=last]);
    let is_any = jobs.iter().any(|job| job.stage.name == stage);
    jobs.extend(tables::jobs(data));
    is_any.then_some(jobs)
}

fn jobs_of_stages(data: &StudyData, stages: &[OfData]) -> Vec<Job> {
    let jobs: Vec<_> = stages.par_iter().map(|(_, jobs)| jobs(data)).collect();
    jobs.into_iter().flatten().collect()
}

/// Every job of a study, given its findings.
pub fn jobs(data: &StudyData, findings: &Findings) -> Vec<Job> {
    // Side by side: in a study of tens of thousands of trials that takes as long as all else.
    let (mut jobs, (figures, tables, page, summary)) = rayon::join(
        || jobs_of_stages(data, &OF_DATA),
        || {
            let (figures, tables) = rayon::join(|| figures::of_run(data), || tables::jobs(data));
            let (page, summary) = rayon::join(
                || page::jobs(data, findings, &figures),
                || page::summary::job(data, findings, &figures),
            );
            (figures, tables, page, summary)
        },
    );
    jobs.extend(report::jobs(data, &figures));
    jobs.extend(tables);
    // Before the figures give their jobs away.
    let captions = (!figures.is_empty()).then(|| figures::captions::job(data, &figures));
    jobs.extend(figures.into_iter().map(|figure| figure.job));
    jobs.extend(captions);
    jobs.push(page::counted::job(data, findings));
    jobs.push(summary);
    jobs.extend(page);
    jobs
}

/// The stages, in the order in which a person thinks of them.
pub const STAGES: [&str; 19] = [
    "characterise",
    "metrics",
    "stage",
    "average",
    "freemotion",
    "ladder",
    "replay",
    "identify",
    "likert",
    "thresholds",
    "compare",
    "trade",
    "simulate",
    "trials",
    "figures",
    "report",
    "tables",
    "summary",
    "page",
];
