//! The plan of a study: which jobs its data give. Each file binds one stage, a pure function, to
//! the files that it reads and makes.
//!
//! A stage is declared in one place: its name and version ([`zwidth_runner::Stage`]), the files of
//! each of its jobs, and what else its function gets, as one serialisable struct. There is no
//! domain logic here: what a stage does with what it reads is the stage's.

#![allow(clippy::ptr_arg)] // a job's function takes what the job holds, not a view of it

mod average;
mod captions;
mod characterise;
mod compare;
mod conditions;
mod courses;
mod design;
mod drawing;
mod figures;
mod freemotion;
mod identify;
mod ladder;
mod likert;
mod likert_figures;
mod long;
mod making;
mod measured;
mod methods;
mod metrics;
mod oscillations;
mod page;
mod preregistered;
mod rehearsed;
mod replay;
mod replay_figures;
mod replayable;
mod report;
mod responses;
mod runs;
mod scenes;
mod schematics;
mod summary;
mod tables;
#[cfg(test)]
mod tests;
mod trade;
mod trials;

pub use compare::{
    By, answers, asked_in_vain, compared, comparison, is_metric, metric_in_words, spreads,
};
pub use figures::{captions, chosen_in_vain, describe, on_demand};
pub use ladder::ladders;
pub use methods::recorded;
pub use oscillations::{Oscillations, oscillations};
pub use page::{JOB as PAGE, file as page_file};
pub use preregistered::{analysis, plan_file};
pub use rehearsed::{Rehearsal, TwinOf, rehearsal, rehearsed, rehearsed_trials};
pub use report::built_in;
pub use responses::{Responses, responses};
pub use tables::{printed as printed_tables, write as write_table};
pub use trade::{Traded, scenes as trade_scenes};

use rayon::prelude::*;
use zwidth_runner::Job;
use zwidth_store::{Findings, StudyData};

/// Every job of a study, of which this was found.
pub fn jobs(data: &StudyData, found: &Findings) -> Vec<Job> {
    let of_data: [fn(&StudyData) -> Vec<Job>; 13] = [
        characterise::jobs,
        // Before the metrics, of which some rest on it.
        identify::jobs,
        metrics::jobs,
        average::jobs,
        freemotion::jobs,
        ladder::jobs,
        replay::jobs,
        courses::jobs,
        runs::jobs,
        likert::jobs,
        compare::jobs,
        trade::jobs,
        scenes::jobs,
    ];
    // Side by side: in a study of tens of thousands of trials that takes as long as all else.
    let (of_data, (figures, tables, page, summary)) = rayon::join(
        || of_data.into_par_iter().map(|jobs| jobs(data)).collect::<Vec<_>>(),
        || {
            let (figures, tables) = rayon::join(|| figures::made(data), || tables::jobs(data));
            let page = || page::jobs(data, found, &figures);
            let (page, summary) = rayon::join(page, || summary::job(data, found, &figures));
            (figures, tables, page, summary)
        },
    );
    let mut jobs: Vec<Job> = of_data.into_iter().flatten().collect();
    jobs.extend(report::jobs(data, &figures));
    jobs.extend(tables);
    let captions = (!figures.is_empty()).then(|| captions::job(data, &figures));
    jobs.extend(figures.into_iter().map(|figure| figure.job));
    jobs.extend(captions);
    jobs.push(summary);
    jobs.extend(page);
    jobs
}

/// The stages, in the order in which a person thinks of them.
pub const STAGES: [&str; 16] = [
    "characterise",
    "metrics",
    "average",
    "freemotion",
    "ladder",
    "replay",
    "identify",
    "likert",
    "compare",
    "trade",
    "simulate",
    "figures",
    "report",
    "tables",
    "summary",
    "page",
];
