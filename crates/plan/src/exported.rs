//! The derived tables that leave in an export.

use std::path::PathBuf;
use zwidth_results::{
    Compared, EffectDifference, GivenAnswer, GroupDifference, GroupModeDifference, Mean,
    ModeDifference, PeopleThreshold, Presentation, PsychometricFit, Row, TrialEvent, TrialScore,
};
use zwidth_runner::Job;
use zwidth_store::Layout;

/// A table that leaves, and its files: several where a table was made for each session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// Its name.
    pub name: &'static str,
    /// Its files, in the order of its rows.
    pub files: Vec<PathBuf>,
}

/// Tables of the study, below `derived/<study>`: the folder and the name.
const OF_STUDY: [(&str, &str); 13] = [
    ("", "trials"),
    ("", "metrics"),
    ("", GivenAnswer::NAME),
    ("", TrialScore::NAME),
    ("thresholds", Presentation::NAME),
    ("thresholds", PsychometricFit::NAME),
    ("thresholds", PeopleThreshold::NAME),
    ("compare", Compared::NAME),
    ("compare", Mean::NAME),
    ("compare", ModeDifference::NAME),
    ("compare", EffectDifference::NAME),
    ("compare", GroupDifference::NAME),
    ("compare", GroupModeDifference::NAME),
];

/// The tables that leave, of those that the jobs of a study make.
pub fn exported(layout: &Layout, jobs: &[Job]) -> Vec<Exported> {
    let outputs = || jobs.iter().flat_map(|job| &job.outputs);
    let derived = layout.derived();
    let of_study = OF_STUDY.into_iter().filter_map(|(folder, name)| {
        let file = derived.join(folder).join(format!("{name}.parquet"));
        outputs().any(|output| *output == file).then(|| Exported { name, files: vec![file] })
    });
    let mut tables: Vec<Exported> = of_study.collect();
    let folder = derived.join("metrics");
    let is_of_events = |output: &&PathBuf| {
        let name = output.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        output.parent() == Some(&folder) && name.ends_with(".events.parquet")
    };
    let mut events: Vec<PathBuf> = outputs().filter(is_of_events).cloned().collect();
    events.sort();
    if !events.is_empty() {
        tables.push(Exported { name: TrialEvent::NAME, files: events });
    }
    tables
}
