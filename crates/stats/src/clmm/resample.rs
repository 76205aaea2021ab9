//! The parametric bootstrap of a likelihood ratio: studies drawn from the fit without the columns
//! in question, and fitted with and without them.
//!
//! Davison & Hinkley (1997), *Bootstrap Methods and their Application*, §4.2. Each study has its
//! own stream of the ChaCha8 cipher, so one seed gives one result, whatever the number of threads.

use super::fit::highest;
use super::likelihood::Integral;
use super::model::Model;
use super::point::Point;
use super::search::{Start, climb};
use crate::answers::{Answers, Scale};
use crate::bootstrap::{normal, stream, uniform};
use crate::logistic::logit;
use crate::tested::Unestimable;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use zwidth_numerics::dense::dot;

/// Ratios of discrete answers tie; searches leave less than this between equal ones.
const TIE: f64 = 1e-6;

/// The outcome of a parametric bootstrap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// The likelihood ratio of the answers themselves.
    pub statistic: f64,
    /// (1 + as_large) / (1 + resamples).
    pub p_value: f64,
    /// Studies drawn.
    pub resamples: usize,
    /// Those of them whose ratio is at least that of the answers.
    pub as_large: usize,
    /// Those of them whose search found no maximum: counted as large, which can only raise p.
    pub unfitted: usize,
}

/// Tests whether `columns` matter by `resamples` studies drawn without them, `seed` being the key
/// of their random numbers. A ratio by any integral makes a valid test; Laplace's is the quick one.
///
/// # Errors
/// A search on the answers themselves that found no maximum.
pub fn bootstrap(
    model: &Model,
    integral: Integral,
    columns: &[usize],
    resamples: usize,
    seed: u64,
) -> Result<Bootstrap, Unestimable> {
    let smaller = model.without(columns);
    let (_, peak) = highest(&smaller, integral)?;
    let truth = Point::at(&peak.coordinates, smaller.thresholds());
    let (_, larger) = highest(model, integral)?;
    let statistic = 2.0 * (larger.log_likelihood - peak.log_likelihood).max(0.0);
    let ratios: Vec<Result<f64, Unestimable>> = (0..resamples)
        .into_par_iter()
        .map(|number| {
            let mut rng = stream(seed, number as u64);
            drawn(&smaller, &truth, &mut rng, model).map_or(Ok(0.0), |answers| {
                let larger = model.with(answers);
                ratio(&larger, &larger.without(columns), integral)
            })
        })
        .collect();
    let unfitted = ratios.iter().filter(|ratio| ratio.is_err()).count();
    let as_large = ratios
        .iter()
        .filter(|ratio| ratio.as_ref().map_or(true, |ratio| *ratio >= statistic - TIE))
        .count();
    let p_value = (1 + as_large) as f64 / (1 + resamples) as f64;
    Ok(Bootstrap { statistic, p_value, resamples, as_large, unfitted })
}

/// Twice what the larger model gains.
fn ratio(larger: &Model, smaller: &Model, integral: Integral) -> Result<f64, Unestimable> {
    let larger = climb(larger, integral, &Start::new(larger))?;
    let smaller = climb(smaller, integral, &Start::new(smaller))?;
    Ok(2.0 * (larger.log_likelihood - smaller.log_likelihood).max(0.0))
}

/// New answers to the columns of `model`, drawn from `smaller` at `truth`; `None` if all are equal:
/// no model gains anything there.
fn drawn(smaller: &Model, truth: &Point, rng: &mut ChaCha8Rng, model: &Model) -> Option<Answers> {
    let effects: Vec<Vec<f64>> = smaller
        .participants
        .iter()
        .map(|cells| {
            let u = truth.sd[0] * normal(rng);
            cells.groups.iter().map(|_| u + truth.sd[1] * normal(rng)).collect()
        })
        .collect();
    let columns = &smaller.answers.columns;
    let mut codes = Vec::with_capacity(smaller.places.len());
    for (row, &(participant, group)) in smaller.places.iter().enumerate() {
        let x: Vec<f64> = columns.iter().map(|column| column.values[row]).collect();
        let eta = dot(&x, &truth.beta) + effects[participant][group];
        let latent = eta + logit(uniform(rng));
        codes.push(truth.theta.partition_point(|&theta| theta < latent));
    }
    // A category that nobody chose is none of the model's: the others are numbered anew.
    let old = &smaller.answers.scale.used;
    let used: Vec<usize> = (0..old.len()).filter(|code| codes.contains(code)).collect();
    let scale = Scale { used: used.iter().map(|&code| old[code]).collect(), unused: Vec::new() };
    let codes = codes.iter().map(|code| used.partition_point(|u| u < code)).collect();
    (used.len() > 1).then(|| Answers { scale, codes, columns: model.answers.columns.clone() })
}
