//! Does a mean of force against position lie between its repeats? Sessions of the simulated device
//! and people, one seed per study, are compared with the recordings themselves.

use super::{RATE, run};
use crate::shell::{program, scratch, words};
use anyhow::{Context as _, ensure};
use zwidth_store::{Layout, Signal, StudyData, TrialEntry, read_trial};
use zwidth_study::StudyId;
use zwidth_tables::Table;

/// Participants of a study, with one session each.
const PEOPLE: usize = 10;
/// What interpolation between samples of different repeats rounds by, N.
const ROUNDING_N: f64 = 1e-9;

/// The angle and the force of a repeat, rad and N.
type Course = (Vec<f64>, Vec<f64>);

pub(crate) fn loops(sessions: usize) -> anyhow::Result<()> {
    let program = program()?;
    let mut conditions = 0;
    let mut points = 0;
    let mut outside = 0;
    for seed in 1..=sessions.div_ceil(PEOPLE) {
        let root = scratch("loops").join(format!("loops-{seed}"));
        let people = format!("--participants {PEOPLE} --sessions 1");
        let twin = format!("twin loops {people} --rate {RATE} --seed {seed}");
        run(&program, &root, &words(&twin), &[0])?;
        run(&program, &root, &["run", "loops", "--only", "average", "--quiet"], &[0, 3])?;
        let layout = Layout::new(&root, StudyId::new("loops")?);
        let data = StudyData::load(&layout).map_err(|found| anyhow::anyhow!("{found:?}"))?;
        let mut trials: Vec<&TrialEntry> = data.counting().collect();
        let key = |t: &&TrialEntry| {
            let m = &t.meta;
            format!("{}.{}.{}.{}", m.participant, m.session, m.environment, m.mode)
        };
        trials.sort_by_key(key);
        for repeats in trials.chunk_by(|a, b| key(a) == key(b)) {
            let path = layout.derived().join(format!("average/{}.loop.parquet", key(&repeats[0])));
            let table = Table::from_parquet(&path).with_context(|| format!("seed {seed}"))?;
            if table.height() == 0 {
                continue;
            }
            conditions += 1;
            let courses = repeats.iter().map(|t| course(t)).collect::<anyhow::Result<Vec<_>>>()?;
            let [looked_at, off] = between(&table, &courses)?;
            points += looked_at;
            outside += off;
            ensure!(off == 0, "{off} points of {} lie outside their repeats", path.display());
        }
        std::fs::remove_dir_all(&root)?;
    }
    println!(
        "{conditions} conditions, {points} points of their means, {outside} outside their repeats"
    );
    Ok(())
}

fn course(trial: &TrialEntry) -> anyhow::Result<Course> {
    let read = read_trial(&trial.path, [Signal::Time, Signal::Theta, Signal::ForceEx])?;
    let of = |signal| read.samples.get(signal).map(<[f64]>::to_vec).context("a signal is missing");
    Ok((of(Signal::Theta)?, of(Signal::ForceEx)?))
}

/// How many points of the ways in and out were held against the repeats, and how many lie outside.
fn between(table: &Table, repeats: &[Course]) -> anyhow::Result<[usize; 2]> {
    let branches = table.texts("branch")?;
    let angles = table.floats("theta_rad")?;
    let means = table.floats("force_ex_mean_n")?;
    let mut counts = [0, 0];
    for ((branch, angle), mean) in branches.iter().zip(&angles).zip(&means) {
        let (Some(branch), Some(angle), Some(mean)) = (branch.as_deref(), angle, mean) else {
            continue;
        };
        if branch == "held" {
            continue;
        }
        let forces: Vec<f64> =
            repeats.iter().flat_map(|repeat| crossings(repeat, branch == "in", *angle)).collect();
        let low = forces.iter().copied().fold(f64::INFINITY, f64::min);
        let high = forces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        counts[0] += 1;
        counts[1] += usize::from(!(low - ROUNDING_N <= *mean && *mean <= high + ROUNDING_N));
    }
    Ok(counts)
}

/// The forces at which a repeat passes an angle: on its way to the farthest one, or back from there. Where
/// it goes to and fro, each counts.
fn crossings((theta, force): &Course, is_in: bool, angle: f64) -> Vec<f64> {
    let farthest =
        (0..theta.len()).fold(0, |best, i| if theta[i] > theta[best] { i } else { best });
    let steps = if is_in { 0..farthest } else { farthest..theta.len() - 1 };
    let passes = |i: &usize| {
        let low = theta[*i].min(theta[*i + 1]);
        let high = theta[*i].max(theta[*i + 1]);
        low <= angle && angle <= high
    };
    let at = |i: usize| match theta[i + 1] - theta[i] {
        0.0 => force[i],
        step => force[i] + (force[i + 1] - force[i]) * (angle - theta[i]) / step,
    };
    steps.filter(passes).map(at).collect()
}
