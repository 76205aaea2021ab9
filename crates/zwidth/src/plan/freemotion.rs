//! Stage `freemotion`: in a free environment, the plane fit of every trial that brings an
//! acceleration, the plant of every other that has an angle.

use super::{JobError, analysis_parameters, derived, known, made, paths, read_all, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_freemotion::FreeMotionError;
use zwidth_runner::{Job, Made, Provenance};
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::Scene;

/// The plane fits of the study.
pub(super) fn planes_of(layout: &Layout) -> PathBuf {
    derived(layout, "free_motion.parquet")
}

/// The plants of the study.
pub(super) fn plants_of(layout: &Layout) -> PathBuf {
    derived(layout, "plant.parquet")
}

/// Trials of free motion that count.
fn free_trials(data: &StudyData) -> Vec<&TrialEntry> {
    let free = |t: &&TrialEntry| {
        data.study.environment(&t.meta.environment).is_some_and(|e| matches!(e.scene, Scene::Free))
    };
    data.counting().filter(free).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let has = |t: &TrialEntry, signal: Signal| t.signals.contains(&signal);
    let angle_alone = |t: &&TrialEntry| has(t, Signal::Theta) && !has(t, Signal::ThetaDdot);
    let (plants, planes): (Vec<_>, Vec<_>) = free_trials(data).into_iter().partition(angle_alone);
    let plane = job(
        data,
        "plane fits of free motion",
        planes,
        planes_of(&data.layout),
        |trials, out, from| {
            let (fits, problems) =
                fit_all(trials, |t| zwidth_freemotion::plane_fit(t, &data.study));
            made(&[zwidth_freemotion::table(&fits)?], &[out], from, problems)
        },
    );
    let plant =
        job(data, "plant in free motion", plants, plants_of(&data.layout), |trials, out, from| {
            let (fits, problems) =
                fit_all(trials, |t| zwidth_freemotion::plant_fit(t, &data.study));
            made(&[zwidth_freemotion::plant_table(&fits)?], &[out], from, problems)
        });
    plane.into_iter().chain(plant).collect()
}

/// The fits of the trials that can be read and fitted, and what is wrong with the others.
fn fit_all<F: Send>(
    trials: &[&TrialEntry],
    fit: impl Fn(&Trial) -> Result<F, FreeMotionError> + Sync,
) -> (Vec<F>, Vec<String>) {
    let (trials, mut problems) = read_all(trials, Signal::all());
    let one = |t: &Trial| {
        fit(t).map_err(|e| {
            format!("{} {} trial {}: {e}", t.meta.participant, t.meta.session, t.meta.trial)
        })
    };
    let (fits, more) = split(trials.par_iter().map(one).collect());
    problems.extend(more);
    (fits, problems)
}

/// The job that makes one table of `trials`; none without any.
fn job<'a>(
    data: &'a StudyData,
    name: &str,
    trials: Vec<&'a TrialEntry>,
    output: PathBuf,
    make: impl Fn(&[&TrialEntry], PathBuf, &Provenance) -> Result<Made, JobError> + Send + Sync + 'a,
) -> Option<Job<'a>> {
    let out = output.clone();
    (!trials.is_empty()).then(|| Job {
        stage: "freemotion",
        name: name.to_owned(),
        version: zwidth_freemotion::VERSION,
        parameters: format!("{}; {}", analysis_parameters(data), known(&trials)),
        inputs: paths(&trials),
        outputs: vec![output],
        tolerant: false,
        make: Box::new(move |from| make(&trials, out.clone(), from)),
    })
}
