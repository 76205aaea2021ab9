//! The fit: least squares over the samples of many trials.

use crate::IdentifyError;
use crate::slopes::{Parameter, errors, slopes};
use rayon::prelude::*;
use std::cell::RefCell;
use zwidth_numerics::nonlinear::{Bounds, Minimum, least_squares};

/// One trial's part of the normal equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block<const P: usize> {
    /// JᵀJ.
    pub(crate) curvature: [[f64; P]; P],
    /// Jᵀr.
    pub(crate) gradient: [f64; P],
}

/// Predictions of trial `i` at some points; `None` where the model does not run.
pub(crate) type Predict<'a, const P: usize> =
    &'a (dyn Fn(usize, &[[f64; P]]) -> Vec<Option<Vec<f64>>> + Sync);

/// A problem of least squares: the trials by their numbers, the observations of each, and the
/// model.
pub(crate) struct Problem<'a, const P: usize> {
    pub(crate) trials: &'a [usize],
    pub(crate) observed: &'a [&'a [f64]],
    pub(crate) parameters: &'a [Parameter; P],
    pub(crate) predict: Predict<'a, P>,
}

impl<const P: usize> Problem<'_, P> {
    /// The best of the minima that are reached from `starts`.
    pub(crate) fn fit(&self, starts: &[[f64; P]]) -> Result<Minimum<P>, IdentifyError> {
        let minima = starts.iter().filter_map(|start| self.minimum(*start).ok());
        // A start from which the model does not run is no loss while another does.
        let best = minima.min_by(|a, b| a.rss.total_cmp(&b.rss));
        best.ok_or(IdentifyError::NoStart { starts: starts.len() })
    }

    /// The least Σ r² with parameter `j` held at `value`, from `start`.
    pub(crate) fn held(&self, start: [f64; P], j: usize, value: f64) -> Option<f64> {
        let mut parameters = *self.parameters;
        let mut start = start;
        (parameters[j].lower, parameters[j].upper, start[j]) = (value, value, value);
        let held = Problem { parameters: &parameters, ..*self };
        held.minimum(start).ok().map(|minimum| minimum.rss)
    }

    /// Σ r² at a point, and Jᵀr with slopes from elsewhere.
    pub(crate) fn gradient(&self, at: &[f64; P], slopes: &[Vec<[f64; P]>]) -> (f64, [f64; P]) {
        let errors = self.errors(at);
        let all = sum(&errors.iter().zip(slopes).map(|(e, s)| block(e, s)).collect::<Vec<_>>());
        (errors.iter().flatten().map(|e| e * e).sum(), all.gradient)
    }

    /// The minimum that is reached from `start`.
    fn minimum(&self, start: [f64; P]) -> Result<Minimum<P>, IdentifyError> {
        let samples = self.trials.iter().map(|i| self.observed[*i].len()).sum();
        let bounds = Bounds {
            lower: self.parameters.map(|p| p.lower),
            upper: self.parameters.map(|p| p.upper),
        };
        // The minimiser asks for residuals one by one: all of a point are made at once, in
        // parallel, and kept.
        let kept: RefCell<Kept<P>> = RefCell::new(Kept::new());
        Ok(least_squares(samples, |i, at| kept.borrow_mut().at(self, at, i), start, &bounds)?)
    }

    /// Errors of every trial, in order.
    fn errors(&self, at: &[f64; P]) -> Vec<Vec<f64>> {
        self.trials
            .par_iter()
            .map(|i| errors(|p| (self.predict)(*i, p), self.observed[*i], at))
            .collect()
    }

    /// Slopes of these errors.
    pub(crate) fn slopes(&self, at: &[f64; P]) -> Vec<Vec<[f64; P]>> {
        self.trials
            .par_iter()
            .map(|i| {
                slopes(|p| (self.predict)(*i, p), self.observed[*i].len(), self.parameters, at)
            })
            .collect()
    }

    /// Every trial's part of the normal equations at a point, with its slopes there.
    pub(crate) fn blocks(&self, at: &[f64; P], slopes: &[Vec<[f64; P]>]) -> Vec<Block<P>> {
        self.errors(at).iter().zip(slopes).map(|(errors, slopes)| block(errors, slopes)).collect()
    }
}

/// The last point at which the minimiser asked for residuals.
struct Kept<const P: usize> {
    /// The bits of its parameters; `None` before the first.
    point: Option<[u64; P]>,
    errors: Vec<f64>,
    slopes: Vec<[f64; P]>,
    /// The least Σ r² so far.
    least: f64,
}

impl<const P: usize> Kept<P> {
    fn new() -> Self {
        Self { point: None, errors: Vec::new(), slopes: Vec::new(), least: f64::INFINITY }
    }

    /// Residual `i` at a point, with its slopes.
    fn at(&mut self, problem: &Problem<P>, at: &[f64; P], i: usize) -> (f64, [f64; P]) {
        // By bits: any other point, however near, has other errors.
        let bits = at.map(f64::to_bits);
        if self.point != Some(bits) {
            self.errors = problem.errors(at).concat();
            let rss: f64 = self.errors.iter().map(|e| e * e).sum();
            // The minimiser steps back from a point that is not better, and never looks at its
            // slopes: they are not made, which spares six runs of seven.
            self.slopes = match rss < self.least {
                true => problem.slopes(at).concat(),
                false => vec![[0.0; P]; self.errors.len()],
            };
            self.least = self.least.min(rss);
            self.point = Some(bits);
        }
        (self.errors[i], self.slopes[i])
    }
}

fn block<const P: usize>(errors: &[f64], slopes: &[[f64; P]]) -> Block<P> {
    let mut block = Block { curvature: [[0.0; P]; P], gradient: [0.0; P] };
    for (r, slope) in errors.iter().zip(slopes) {
        for j in 0..P {
            block.gradient[j] += slope[j] * r;
            for k in 0..P {
                block.curvature[j][k] += slope[j] * slope[k];
            }
        }
    }
    block
}

/// The sum of blocks.
pub(crate) fn sum<'b, const P: usize>(blocks: impl IntoIterator<Item = &'b Block<P>>) -> Block<P> {
    let mut sum = Block { curvature: [[0.0; P]; P], gradient: [0.0; P] };
    for block in blocks {
        for j in 0..P {
            sum.gradient[j] += block.gradient[j];
            for k in 0..P {
                sum.curvature[j][k] += block.curvature[j][k];
            }
        }
    }
    sum
}
