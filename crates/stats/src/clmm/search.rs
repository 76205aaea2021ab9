//! The search for the maximum of the likelihood.

use super::likelihood::{Integral, Likelihood};
use super::model::{Model, Terms};
use super::point::Point;
use crate::clm;
use crate::tested::Unestimable;
use zwidth_numerics::dense::{Matrix, dot};
use zwidth_numerics::minimise::minimise;

/// Slope of the log-likelihood, per standard error of a parameter, at which a maximum is flat: it
/// is then 1e-13 below the top.
const FLAT: f64 = 5e-7;
/// A search that rounding stops earlier has still found a maximum if this
/// much slope is left, or less: estimates are off by a ten-thousandth of their standard error.
const NEARLY_FLAT: f64 = 1e-4;
/// SDs at which a search begins.
const FIRST_SD: [f64; 2] = [1.0, 0.5];
/// No search begins at an SD below this: zero is a stationary point, which it would not leave.
const LEAST_SD: f64 = 0.3;
/// Variance of the coordinates where nothing is known of it.
const UNKNOWN: f64 = 0.25;

/// The start of a search, with how far its parameters may be expected to move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Start {
    /// Coordinates.
    pub(super) coordinates: Vec<f64>,
    /// A guess of their covariance. It makes the search's steps alike in all directions.
    pub(super) covariance: Vec<Vec<f64>>,
    /// Whether a coordinate stays where it is.
    pub(super) held: Vec<bool>,
}

/// The end of a search.
#[derive(Debug, Clone)]
pub(super) struct Peak {
    pub(super) coordinates: Vec<f64>,
    pub(super) log_likelihood: f64,
    /// Largest slope left, per standard error.
    pub(super) slope: f64,
}

impl Start {
    /// The fit without random effects, with SDs to begin with. Where answers are separated (those
    /// of a bootstrap may be) it begins without effects of the columns.
    pub(super) fn new(model: &Model) -> Self {
        let plain = clm::Model::of(model.answers.clone());
        let width = model.thresholds() + model.columns() + 2;
        let (point, mut covariance) = match model.answers.screen().and_then(|()| clm::fit(&plain)) {
            Ok(fit) => {
                let covariance = by_coordinates(&fit.covariance, &fit.thresholds);
                (Point { theta: fit.thresholds, beta: fit.coefficients, sd: FIRST_SD }, covariance)
            }
            Err(_) => {
                let theta = moved(plain.cumulated_logits(), model);
                let beta = vec![0.0; model.columns()];
                let covariance = (0..width - 2).map(|i| one_entry(width - 2, i, UNKNOWN)).collect();
                (Point { theta, beta, sd: FIRST_SD }, covariance)
            }
        };
        covariance.iter_mut().for_each(|row| row.resize(width, 0.0));
        for (sd, variance) in sd_variances(model).into_iter().enumerate() {
            covariance.push(one_entry(width, width - 2 + sd, variance));
        }
        let mut start =
            Self { covariance, coordinates: point.coordinates(), held: vec![false; width] };
        start.hold_as(model);
        start
    }

    /// The start of a search that ended at `peak` before, with all SDs of the model free again.
    pub(super) fn again(model: &Model, peak: &[f64], covariance: &[Vec<f64>]) -> Self {
        let mut start = Self {
            coordinates: peak.to_vec(),
            covariance: covariance.to_vec(),
            held: vec![false; peak.len()],
        };
        for (sd, variance) in sd_variances(model).into_iter().enumerate() {
            let place = peak.len() - 2 + sd;
            // An SD that was held at zero has no variance to go by.
            if start.covariance[place][place] <= 0.0 {
                start.covariance[place][place] = variance;
            }
        }
        start.hold_as(model);
        start
    }

    /// Holds the coefficients and the SD that the model does not estimate.
    fn hold_as(&mut self, model: &Model) {
        for (column, value) in model.held.iter().enumerate() {
            if let Some(value) = value {
                self.hold_at(model.thresholds() + column, *value);
            }
        }
        if model.terms == Terms::Participant {
            self.hold_at(self.held.len() - 1, 0.0);
        }
    }

    /// Keeps a coordinate at a value.
    pub(super) fn hold_at(&mut self, coordinate: usize, value: f64) {
        self.coordinates[coordinate] = value;
        self.held[coordinate] = true;
    }

    /// The coordinates that are not held.
    pub(super) fn free(&self) -> Vec<usize> {
        (0..self.held.len()).filter(|&i| !self.held[i]).collect()
    }

    /// The triangle whose product with its transpose is the covariance of the free coordinates.
    fn shape(&self, free: &[usize]) -> Matrix {
        let size = free.len();
        let covariance = Matrix::from_fn(size, size, |a, b| self.covariance[free[a]][free[b]]);
        // Any shape will do, if slowly.
        covariance.cholesky(0.0).unwrap_or_else(|| {
            Matrix::from_fn(size, size, |a, b| {
                if a == b { covariance[(a, a)].max(0.01).sqrt() } else { 0.0 }
            })
        })
    }
}

/// Thresholds where the answers of a model with held coefficients have them: each by those answers
/// that lie on both sides of it, or halfway between those below and those above.
fn moved(mut theta: Vec<f64>, model: &Model) -> Vec<f64> {
    /// Distance of two thresholds that the answers put at one place.
    const APART: f64 = 0.1;
    let held: Vec<f64> = model.held.iter().map(|value| value.unwrap_or(0.0)).collect();
    let patterns = model.answers.patterns(0..model.answers.codes.len());
    for k in 0..theta.len() {
        let mut below = f64::NEG_INFINITY;
        let mut above = f64::INFINITY;
        let mut across = None;
        for pattern in &patterns {
            let place = dot(&pattern.x, &held);
            let [low, high] = [&pattern.counts[..=k], &pattern.counts[k + 1..]]
                .map(|counts| counts.iter().any(|count| *count > 0.0));
            match (low, high) {
                (true, true) => across = Some(place),
                (true, false) => below = below.max(place),
                (false, _) => above = above.min(place),
            }
        }
        theta[k] += across.unwrap_or(0.5 * (below + above));
        if k > 0 && theta[k] <= theta[k - 1] {
            theta[k] = theta[k - 1] + APART;
        }
    }
    theta
}

/// Variance of each SD as estimated from its number of values: σ² / (2n), with σ about 1.
fn sd_variances(model: &Model) -> [f64; 2] {
    let groups: usize = model.participants.iter().map(|cells| cells.groups.len()).sum();
    [model.participants.len(), groups].map(|values| 1.0 / (2.0 * values as f64))
}

/// A row of zeros but for one entry.
fn one_entry(width: usize, place: usize, entry: f64) -> Vec<f64> {
    let mut row = vec![0.0; width];
    row[place] = entry;
    row
}

/// Rows of a covariance of (θ, β) as one of the coordinates.
fn by_coordinates(covariance: &[Vec<f64>], theta: &[f64]) -> Vec<Vec<f64>> {
    let half: Vec<Vec<f64>> = covariance.iter().map(|row| steps(row, theta)).collect();
    transpose(&transpose(&half).iter().map(|row| steps(row, theta)).collect::<Vec<_>>())
}

/// A row by (θ, β) as one by the coordinates: d ln(θₖ − θₖ₋₁) = (dθₖ − dθₖ₋₁) / (θₖ − θₖ₋₁).
fn steps(row: &[f64], theta: &[f64]) -> Vec<f64> {
    (0..row.len())
        .map(|k| match k == 0 || k >= theta.len() {
            true => row[k],
            false => (row[k] - row[k - 1]) / (theta[k] - theta[k - 1]),
        })
        .collect()
}

fn transpose(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..a.len()).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

/// Climbs from `start` to a maximum.
pub(super) fn climb(model: &Model, integral: Integral, start: &Start) -> Result<Peak, Unestimable> {
    let mut likelihood = Likelihood::new(model, integral);
    let free = start.free();
    let shape = start.shape(&free);
    let mut first = start.coordinates.clone();
    for i in first.len() - 2..first.len() {
        if !start.held[i] {
            first[i] = first[i].abs().max(LEAST_SD);
        }
    }
    let place = |steps: &[f64]| {
        let mut coordinates = first.clone();
        for (row, &i) in free.iter().enumerate() {
            coordinates[i] += dot(shape.row(row), steps);
        }
        coordinates
    };
    let cost = |steps: &[f64]| {
        let coordinates = place(steps);
        let point = Point::at(&coordinates, model.thresholds());
        let (value, gradient) = likelihood.at(&point);
        let slopes = gradient.by_coordinates(&coordinates);
        let mut downhill = Vec::with_capacity(free.len());
        for j in 0..free.len() {
            // Above its diagonal the triangle is 0.
            let rows = free.iter().enumerate().skip(j);
            downhill.push(-rows.map(|(row, &i)| shape[(row, j)] * slopes[i]).sum::<f64>());
        }
        (-value, downhill)
    };
    let what = "thresholds, coefficients and SDs";
    let minimum = minimise(cost, &vec![0.0; free.len()], FLAT)
        .map_err(|_| Unestimable::NotConverged { what, slope: f64::INFINITY })?;
    let slope = minimum.slope();
    if slope > NEARLY_FLAT {
        return Err(Unestimable::NotConverged { what, slope });
    }
    Ok(Peak { coordinates: place(&minimum.point), log_likelihood: -minimum.value, slope })
}
