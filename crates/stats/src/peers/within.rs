//! pyfixest's fixed effects: a constant for each participant, and least squares of what remains.

use super::trials::{Row, Trials};
use crate::error::all_finite;
use crate::tested::{Tested, Unestimable, at_least, not_constant};
use crate::welch::tested;
use std::collections::BTreeMap;
use zwidth_numerics::dense::{Matrix, dot};

/// Sums over the trials of a participant.
#[derive(Clone)]
struct Own {
    /// Trials of each mode.
    counts: Vec<f64>,
    /// Sums of the values of each mode.
    sums: Vec<f64>,
}

/// What is taken for granted of the errors of trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Errors {
    /// They are independent and of one variance.
    Independent,
    /// Those of one participant may be correlated in any way.
    OfParticipants,
}

/// A test, and what it uses.
pub(super) struct Within {
    pub(super) tested: Tested,
    pub(super) participants: Vec<usize>,
    pub(super) trials: usize,
}

/// Σ weightⱼ βⱼ over the modes, with constants for participants and `weights` that add up to 0. With errors of participants the
/// variance is CRV1 (Liang & Zeger 1986, Biometrika 73:13), times G / (G − 1) (N − 1) / (N − k − 1), and t has G − 1 degrees of
/// freedom. A participant with a single trial is left out.
pub(super) fn within(
    data: Trials<'_>,
    modes: &[usize],
    weights: &[f64],
    errors: Errors,
    level: f64,
) -> Result<Within, Unestimable> {
    let mode_count = modes.len();
    // Far from zero sums of squares would lose their digits.
    let origin = data.value.iter().sum::<f64>() / data.value.len() as f64;
    let mut people: BTreeMap<usize, Own> = BTreeMap::new();
    let none = Own { counts: vec![0.0; mode_count], sums: vec![0.0; mode_count] };
    for Row { participant, place, value } in data.rows(modes) {
        let own = people.entry(participant).or_insert_with(|| none.clone());
        own.counts[place] += 1.0;
        own.sums[place] += value - origin;
    }
    people.retain(|_, own| own.counts.iter().sum::<f64>() > 1.5);
    at_least("participants with several trials", people.len(), 2)?;

    // Of every mode but the first, which its column stands against.
    let mut squares = Matrix::zeros(mode_count - 1, mode_count - 1);
    let mut products = vec![0.0; mode_count - 1];
    for own in people.values() {
        let n: f64 = own.counts.iter().sum();
        let mean = own.sums.iter().sum::<f64>() / n;
        for k in 1..mode_count {
            squares[(k - 1, k - 1)] += own.counts[k];
            products[k - 1] += own.sums[k] - own.counts[k] * mean;
        }
        squares.add_outer(-1.0 / n, &own.counts[1..], &own.counts[1..]);
    }
    let confounded = || Unestimable::Confounded { what: "the modes".to_owned() };
    let (inverse, _) = squares.inverse_and_log_det().ok_or_else(confounded)?;
    let mut effects = vec![0.0];
    effects.extend(inverse.times_vector(&products));
    let along = inverse.times_vector(&weights[1..]);

    let level_of = |own: &Own| {
        let n: f64 = own.counts.iter().sum();
        let of_modes: f64 = own.counts.iter().zip(&effects).map(|(n, effect)| n * effect).sum();
        (own.sums.iter().sum::<f64>() - of_modes) / n
    };
    let mut rss = 0.0;
    let mut trials = 0_usize;
    for Row { participant, place, value } in data.rows(modes) {
        let Some(own) = people.get(&participant) else { continue };
        let residual = value - origin - level_of(own) - effects[place];
        rss += residual * residual;
        trials += 1;
    }
    let clusters = people.len() as f64;
    let rows = trials as f64;
    let slopes = mode_count as f64 - 1.0;
    let (variance, df) = if errors == Errors::OfParticipants {
        let scores = people.values().map(|own| {
            let level = level_of(own);
            let of_mode = |k: usize| own.sums[k] - own.counts[k] * (level + effects[k]);
            (1..mode_count).map(|k| along[k - 1] * of_mode(k)).sum::<f64>()
        });
        let sum: f64 = scores.map(|score| score * score).sum();
        let few = clusters / (clusters - 1.0) * (rows - 1.0) / (rows - slopes - 1.0);
        (few * sum, clusters - 1.0)
    } else {
        let spare = rows - slopes - clusters;
        if spare < 0.5 {
            let what = "participants from the residual".to_owned();
            return Err(Unestimable::Confounded { what });
        }
        (rss / spare * inverse.form(&weights[1..], &weights[1..]), spare)
    };
    let estimate = dot(weights, &effects);
    all_finite(&[estimate, variance])?;
    not_constant("residuals", variance.sqrt() <= f64::EPSILON * origin.abs().max(estimate.abs()))?;
    Ok(Within {
        tested: tested(estimate, variance.sqrt(), df, level)?,
        participants: people.keys().copied().collect(),
        trials,
    })
}
