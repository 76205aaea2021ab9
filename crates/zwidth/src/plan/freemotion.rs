//! Stage `freemotion`: the plane fit of every trial in a free environment.

use super::{analysis_parameters, derived, made, read_all, split};
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
fn free_trials(data: &StudyData) -> Vec<PathBuf> {
    let free = |t: &&TrialEntry| {
        data.study.environment(&t.meta.environment).is_some_and(|e| matches!(e.scene, Scene::Free))
    };
    data.counting().filter(free).map(|t| t.path.clone()).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let inputs = free_trials(data);
    if inputs.is_empty() {
        return Vec::new();
    }
    let outputs = tables_of(&data.layout);
    let (files, out) = (inputs.clone(), outputs.clone());
    let make = move |from: &_| {
        let (trials, mut problems) = read_all(&files);
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
        parameters: analysis_parameters(data),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}
