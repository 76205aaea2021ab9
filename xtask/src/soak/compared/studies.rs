//! Studies drawn from the people, each compared by the stage's own code.

use super::people::{CONTRASTS, ENVIRONMENTS, METRICS, MODES, PARTICIPANTS, People, What};
use anyhow::Context as _;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::collections::BTreeMap;
use zwidth_compare::{MetricParameters, Parameters, compare};
use zwidth_results::{ModeDifference, Model};
use zwidth_study::{Contrast, Families, ModeId};
use zwidth_tables::Measured;

/// Level of the intervals, and below what p counts.
pub(crate) const LEVEL: f64 = 0.95;
pub(crate) const ALPHA: f64 = 0.05;

/// What one study says of one difference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Said {
    pub(crate) estimate: f64,
    pub(crate) std_error: f64,
    pub(crate) df: f64,
    pub(crate) interval: [f64; 2],
    pub(crate) p_value: f64,
    /// Of the two exact tests: by flipping signs, by signed ranks.
    pub(crate) p_exact: [f64; 2],
    /// Interval and p of the mixed model, where it has one.
    pub(crate) model: Option<([f64; 2], f64)>,
}

/// What was said of a difference, study by study: by both sessions, and by the first alone.
#[derive(Debug, Clone, Default)]
pub(crate) struct Found {
    pub(crate) both: BTreeMap<What, Vec<Said>>,
    pub(crate) first: BTreeMap<What, Vec<Said>>,
}

/// So many studies; the same whatever the number of threads.
pub(crate) fn all(people: &People, seeds: u64) -> anyhow::Result<Found> {
    let one = |seed| -> anyhow::Result<[Vec<(What, Said)>; 2]> {
        let chosen = draw(people.len(), seed);
        let of = |first| -> anyhow::Result<_> { one_study(&people.table(&chosen, first)?) };
        Ok([of(false)?, of(true)?])
    };
    let studies: Vec<_> = (0..seeds)
        .into_par_iter()
        .map(|seed| one(seed).with_context(|| format!("seed {seed}")))
        .collect::<anyhow::Result<_>>()?;
    let mut found = Found::default();
    for [both, first] in studies {
        both.into_iter().for_each(|(what, said)| found.both.entry(what).or_default().push(said));
        first.into_iter().for_each(|(what, said)| found.first.entry(what).or_default().push(said));
    }
    Ok(found)
}

/// The places of a study's participants. Each is drawn from all: the people are the population,
/// however few they are, and no study exhausts it.
fn draw(people: usize, seed: u64) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || ((u128::from(rng.next_u64()) * people as u128) >> u64::BITS) as usize;
    (0..PARTICIPANTS).map(|_| one()).collect()
}

fn one_study(metrics: &Measured) -> anyhow::Result<Vec<(What, Said)>> {
    let found = compare(metrics, &parameters()?)?;
    Ok(found.contrasts.iter().filter_map(|row| said(row, &found.models)).collect())
}

/// No order is told: the sharp null is another hypothesis.
fn parameters() -> anyhow::Result<Parameters> {
    let mode = |id: &str| -> anyhow::Result<ModeId> { Ok(id.parse()?) };
    let contrast = |[of, against]: [&str; 2]| -> anyhow::Result<Contrast> {
        Ok(Contrast { mode: mode(of)?, against: mode(against)? })
    };
    let metric = |(place, name): (usize, &str)| -> anyhow::Result<MetricParameters> {
        Ok(MetricParameters {
            metric: name.parse()?,
            chosen_after: None,
            primary: place == 0,
            better: zwidth_study::Better::Lower,
            preregistered: None,
            bounds: vec![None; ENVIRONMENTS.len()],
            noticed: None,
        })
    };
    Ok(Parameters {
        metrics: METRICS.into_iter().enumerate().map(metric).collect::<Result<_, _>>()?,
        environments: ENVIRONMENTS.iter().map(|id| id.parse()).collect::<Result<_, _>>()?,
        modes: MODES.into_iter().map(mode).collect::<Result<_, _>>()?,
        contrasts: CONTRASTS.into_iter().map(contrast).collect::<Result<_, _>>()?,
        families: Families::Metric,
        curve_claims: 0,
        alpha: ALPHA,
        level: LEVEL,
        effect_sizes: Vec::new(),
        groups: None,
        covariates: Vec::new(),
        over: None,
        effects: Vec::new(),
        dose_curves: Vec::new(),
        orders: Vec::new(),
    })
}

/// What a contrast that has a test says, with the mixed model beside it.
fn said(row: &ModeDifference, models: &[Model]) -> Option<(What, Said)> {
    let is_compared = |[mode, against]: &[&str; 2]| {
        (row.contrast.mode.as_str(), row.contrast.against.as_str()) == (*mode, *against)
    };
    let what = What {
        metric: METRICS.iter().position(|name| *name == row.metric.as_str())?,
        environment: ENVIRONMENTS.iter().position(|id| *id == row.environment.as_str())?,
        contrast: CONTRASTS.iter().position(is_compared)?,
    };
    let is_own = |model: &&Model| {
        (&model.metric, &model.environment, &model.contrast)
            == (&row.metric, &row.environment, &row.contrast)
    };
    let model = models.iter().find(is_own).and_then(|model| {
        Some(([model.difference_ci_low?, model.difference_ci_high?], model.p_value?))
    });
    let said = Said {
        estimate: row.difference,
        std_error: row.difference_std_error?,
        df: row.df?,
        interval: [row.difference_ci_low?, row.difference_ci_high?],
        p_value: row.p_value?,
        p_exact: [row.p_sign_flip?, row.p_signed_rank?],
        model,
    };
    Some((what, said))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everybody_is_drawn_as_often() {
        let mut drawn = [0; 40];
        for seed in 0..4000 {
            draw(40, seed).into_iter().for_each(|person| drawn[person] += 1);
        }
        // binomial with mean 1200: within 5 of its deviations
        assert!(drawn.iter().all(|n| (1029..=1371).contains(n)), "{drawn:?}");
        assert_eq!(draw(40, 1), draw(40, 1));
    }
}
