//! The search for the maximum of the likelihood.

use super::likelihood::{Integral, Likelihood};
use super::model::{Model, Terms};
use super::point::Point;
use crate::clm;
use crate::symmetric::cholesky;
use crate::tested::Unestimable;
use zwidth_numerics::minimise::minimise;

/// Slope of the log-likelihood, per standard error of a parameter, at which a maximum is flat: it
/// is then 1e-13 below the top.
const FLAT: f64 = 5e-7;
/// A search that rounding (or a rule of few nodes) stops earlier has still found a maximum if this
/// much slope is left, or less: estimates are off by a ten-thousandth of their standard error.
const NEARLY_FLAT: f64 = 1e-4;
/// SDs at which a search begins.
const FIRST_SD: [f64; 2] = [1.0, 0.5];

/// Where a search begins, and how far its parameters may be expected to move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Start {
    /// Coordinates.
    pub(super) coordinates: Vec<f64>,
    /// A guess of their covariance. It makes the search's steps alike in all directions.
    pub(super) covariance: Vec<Vec<f64>>,
    /// Whether a coordinate stays where it is.
    pub(super) held: Vec<bool>,
}

/// Where a search ended.
#[derive(Debug, Clone)]
pub(super) struct Peak {
    pub(super) coordinates: Vec<f64>,
    pub(super) log_likelihood: f64,
    /// Largest slope left, per standard error.
    pub(super) slope: f64,
}

impl Start {
    /// The fit without random effects, with SDs to begin with.
    pub(super) fn new(model: &Model) -> Result<Self, Unestimable> {
        let plain = clm::fit(&clm::Model::of(model.answers.clone()))?;
        let point = Point { theta: plain.thresholds, beta: plain.coefficients, sd: FIRST_SD };
        let mut start = Self {
            covariance: by_coordinates(&plain.covariance, &point.theta),
            coordinates: point.coordinates(),
            held: vec![false; model.thresholds() + model.columns() + 2],
        };
        let width = start.coordinates.len();
        start.covariance.iter_mut().for_each(|row| row.resize(width, 0.0));
        // The variance of an SD estimated from n values is 1/(2n) of its square.
        let groups: usize = model.participants.iter().map(|cells| cells.groups.len()).sum();
        for (sd, values) in [model.participants.len(), groups].into_iter().enumerate() {
            let mut row = vec![0.0; width];
            row[width - 2 + sd] = 1.0 / (2.0 * values as f64);
            start.covariance.push(row);
        }
        if model.terms == Terms::Participant {
            start.hold_at(width - 1, 0.0);
        }
        Ok(start)
    }

    /// Keeps a coordinate at a value.
    pub(super) fn hold_at(&mut self, coordinate: usize, value: f64) {
        self.coordinates[coordinate] = value;
        self.held[coordinate] = true;
    }

    fn free(&self) -> Vec<usize> {
        (0..self.held.len()).filter(|&i| !self.held[i]).collect()
    }

    /// The triangle whose product with its transpose is the covariance of the free coordinates.
    fn shape(&self, free: &[usize]) -> Vec<Vec<f64>> {
        let pick = |i: &usize| free.iter().map(|&j| self.covariance[*i][j]).collect::<Vec<_>>();
        let covariance: Vec<Vec<f64>> = free.iter().map(pick).collect();
        // Any shape will do, if slowly.
        let diagonal = |i: usize| [vec![0.0; i], vec![covariance[i][i].max(0.01).sqrt()]].concat();
        cholesky(&covariance).unwrap_or_else(|| (0..free.len()).map(diagonal).collect())
    }
}

/// Rows of a covariance of (θ, β) as one of the coordinates.
fn by_coordinates(covariance: &[Vec<f64>], theta: &[f64]) -> Vec<Vec<f64>> {
    let steps = |row: &[f64]| -> Vec<f64> {
        let step = |k: usize| (row[k] - row[k - 1]) / (theta[k] - theta[k - 1]);
        let one = |k: usize| if k == 0 || k >= theta.len() { row[k] } else { step(k) };
        (0..row.len()).map(one).collect()
    };
    let half: Vec<Vec<f64>> = covariance.iter().map(|row| steps(row)).collect();
    transpose(&transpose(&half).iter().map(|row| steps(row)).collect::<Vec<_>>())
}

fn transpose(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..a.len()).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

/// Climbs from `start` to a maximum.
pub(super) fn climb(model: &Model, integral: Integral, start: &Start) -> Result<Peak, Unestimable> {
    let mut likelihood = Likelihood::new(model, integral);
    let free = start.free();
    let shape = start.shape(&free);
    let place = |steps: &[f64]| {
        let mut coordinates = start.coordinates.clone();
        for (row, &i) in shape.iter().zip(&free) {
            coordinates[i] += row.iter().zip(steps).map(|(l, s)| l * s).sum::<f64>();
        }
        coordinates
    };
    let cost = |steps: &[f64]| {
        let coordinates = place(steps);
        let point = Point::at(&coordinates, model.thresholds());
        let (value, gradient) = likelihood.at(&point);
        let slopes = gradient.by_coordinates(&coordinates);
        let along = |j: usize| {
            -shape.iter().zip(&free).skip(j).map(|(row, &i)| row[j] * slopes[i]).sum::<f64>()
        };
        (-value, (0..free.len()).map(along).collect())
    };
    let what = "thresholds, coefficients and SDs";
    let found = minimise(cost, &vec![0.0; free.len()], FLAT)
        .map_err(|_| Unestimable::NotConverged { what, slope: f64::INFINITY })?;
    let slope = found.slope();
    if slope > NEARLY_FLAT {
        return Err(Unestimable::NotConverged { what, slope });
    }
    Ok(Peak { coordinates: place(&found.point), log_likelihood: -found.value, slope })
}
