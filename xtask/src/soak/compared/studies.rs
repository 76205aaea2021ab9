//! Studies drawn from the people, each compared by the stage's own code.

use super::people::{CONTRASTS, ENVIRONMENTS, METRICS, MODES, PARTICIPANTS, People, What};
use anyhow::Context as _;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::collections::BTreeMap;
use zwidth_compare::{Compared, Parameters, compare};
use zwidth_study::{Contrast, Families, ModeId};
use zwidth_tables::Table;

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

fn one_study(metrics: &Table) -> anyhow::Result<Vec<(What, Said)>> {
    let mut found = Vec::new();
    for (metric, name) in METRICS.into_iter().enumerate() {
        let compared = compare(metrics, &parameters(metric, name)?)?;
        found.extend(read(metric, &compared)?);
    }
    Ok(found)
}

/// No order is told: the sharp null is another hypothesis.
fn parameters(metric: usize, name: &str) -> anyhow::Result<Parameters> {
    let mode = |id: &str| -> anyhow::Result<ModeId> { Ok(id.parse()?) };
    let contrast = |[of, against]: [&str; 2]| -> anyhow::Result<Contrast> {
        Ok(Contrast { mode: mode(of)?, against: mode(against)? })
    };
    Ok(Parameters {
        preregistered: None,
        metric: name.to_owned(),
        primary: metric == 0,
        simulated: true,
        environments: ENVIRONMENTS.iter().map(|id| id.parse()).collect::<Result<_, _>>()?,
        bounds: vec![None; ENVIRONMENTS.len()],
        modes: MODES.into_iter().map(mode).collect::<Result<_, _>>()?,
        contrasts: CONTRASTS.into_iter().map(contrast).collect::<Result<_, _>>()?,
        families: Families::Metric,
        alpha: ALPHA,
        level: LEVEL,
        noticed: None,
        effect_sizes: Vec::new(),
        orders: Vec::new(),
    })
}

/// The rows of the tables of contrasts and of models that have a test.
fn read(metric: usize, compared: &Compared) -> anyhow::Result<Vec<(What, Said)>> {
    let models: BTreeMap<What, usize> = rows(metric, &compared.models)?.collect();
    let table = &compared.contrasts;
    let [estimate, std_error, low, high, df, p, sign_flip, signed_rank] = numbers(
        table,
        [
            "difference",
            "difference_std_error",
            "difference_ci_low",
            "difference_ci_high",
            "df",
            "p_value",
            "p_sign_flip",
            "p_signed_rank",
        ],
    )?;
    let [model_low, model_high, model_p] =
        numbers(&compared.models, ["difference_ci_low", "difference_ci_high", "p_value"])?;
    let model = |what: &What| {
        let row = *models.get(what)?;
        Some(([model_low[row]?, model_high[row]?], model_p[row]?))
    };
    let said = |(what, row): (What, usize)| {
        let said = Said {
            estimate: estimate[row]?,
            std_error: std_error[row]?,
            df: df[row]?,
            interval: [low[row]?, high[row]?],
            p_value: p[row]?,
            p_exact: [sign_flip[row]?, signed_rank[row]?],
            model: model(&what),
        };
        Some((what, said))
    };
    Ok(rows(metric, table)?.filter_map(said).collect())
}

fn numbers<const N: usize>(
    table: &Table,
    names: [&str; N],
) -> anyhow::Result<[Vec<Option<f64>>; N]> {
    let mut all = names.map(|_| Vec::new());
    for (column, name) in all.iter_mut().zip(names) {
        *column = table.floats(name)?;
    }
    Ok(all)
}

/// What the rows of a table are about.
fn rows(metric: usize, table: &Table) -> anyhow::Result<impl Iterator<Item = (What, usize)>> {
    let names = table.texts("environment")?.into_iter().zip(table.texts("contrast")?);
    let known: Vec<(What, usize)> = names
        .enumerate()
        .filter_map(|(row, (environment, contrast))| {
            let named = |[mode, against]: &[&str; 2]| Some(format!("{mode} − {against}"));
            let environment =
                ENVIRONMENTS.iter().position(|id| Some(*id) == environment.as_deref())?;
            let contrast = CONTRASTS.iter().position(|of| named(of) == contrast)?;
            Some((What { metric, environment, contrast }, row))
        })
        .collect();
    Ok(known.into_iter())
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
