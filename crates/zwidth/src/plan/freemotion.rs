//! Stage `freemotion`: the plane fit of every trial in a free environment.

use super::{analysis_parameters, derived, known, made, paths, read_all, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_runner::Job;
use zwidth_store::{Layout, StudyData, TrialEntry};
use zwidth_study::Scene;

/// The fits of the study.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    vec![derived(layout, "free_motion.parquet")]
}

/// Trials of free motion that count.
fn free_trials(data: &StudyData) -> Vec<&TrialEntry> {
    let free = |t: &&TrialEntry| {
        data.study.environment(&t.meta.environment).is_some_and(|e| matches!(e.scene, Scene::Free))
    };
    data.counting().filter(free).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let trials = free_trials(data);
    if trials.is_empty() {
        return Vec::new();
    }
    let (inputs, outputs) = (paths(&trials), tables_of(&data.layout));
    let out = outputs.clone();
    let parameters = format!("{}; {}", analysis_parameters(data), known(&trials));
    let make = move |from: &_| {
        let (trials, mut problems) = read_all(&trials);
        let one = |t| {
            let fit = zwidth_freemotion::plane_fit(t, &data.study);
            fit.map_err(|e| format!("{} {} trial {}: {e}", t.meta.participant, t.meta.session, t.meta.trial))
        };
        let (fits, more) = split(trials.par_iter().map(one).collect());
        problems.extend(more);
        made(&[zwidth_freemotion::table(&fits)?], &out, from, problems)
    };
    vec![Job {
        stage: "freemotion",
        name: "plane fits of free motion".to_owned(),
        version: zwidth_freemotion::VERSION,
        parameters,
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}
