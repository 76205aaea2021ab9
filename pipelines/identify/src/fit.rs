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

/// What is fitted: the trials by their numbers, what was recorded of each, and the model.
pub(crate) struct Problem<'a, const P: usize> {
    pub(crate) trials: &'a [usize],
    pub(crate) observed: &'a [&'a [f64]],
    pub(crate) parameters: &'a [Parameter; P],
    pub(crate) predict: Predict<'a, P>,
}

impl<const P: usize> Problem<'_, P> {
    /// The best of the minima that are reached from `starts`.
    pub(crate) fn fit(&self, starts: &[[f64; P]]) -> Result<Minimum<P>, IdentifyError> {
        let minima = starts.iter().filter_map(|start| self.from(*start).ok());
        let best = minima.min_by(|a, b| a.rss.total_cmp(&b.rss));
        best.ok_or(IdentifyError::NoStart { starts: starts.len() })
    }

    /// The least Σ r² with parameter `j` held at `value`, from `start`.
    pub(crate) fn held(&self, start: [f64; P], j: usize, value: f64) -> Option<f64> {
        let mut parameters = *self.parameters;
        let mut start = start;
        (parameters[j].lower, parameters[j].upper, start[j]) = (value, value, value);
        let held = Problem { parameters: &parameters, ..*self };
        held.from(start).ok().map(|minimum| minimum.rss)
    }

    /// Σ r² at a point, and Jᵀr with slopes from elsewhere.
    pub(crate) fn gradient(&self, at: &[f64; P], slopes: &[Vec<[f64; P]>]) -> (f64, [f64; P]) {
        let errors = self.errors(at);
        let all = sum(&errors.iter().zip(slopes).map(|(e, s)| block(e, s)).collect::<Vec<_>>());
        (errors.iter().flatten().map(|e| e * e).sum(), all.gradient)
    }

    /// Samples of all trials.
    fn samples(&self) -> usize {
        self.trials.iter().map(|i| self.observed[*i].len()).sum()
    }

    /// The minimiser asks for residuals one by one: all of a point are made at once, in parallel,
    /// and kept.
    fn from(&self, start: [f64; P]) -> Result<Minimum<P>, IdentifyError> {
        let kept: RefCell<Kept<P>> = RefCell::new(Kept::new());
        let residual = |i: usize, at: &[f64; P]| kept.borrow_mut().at(self, at, i);
        let bounds = Bounds {
            lower: self.parameters.map(|p| p.lower),
            upper: self.parameters.map(|p| p.upper),
        };
        Ok(least_squares(self.samples(), residual, start, &bounds)?)
    }

    /// Errors of every trial, in order.
    fn errors(&self, at: &[f64; P]) -> Vec<Vec<f64>> {
        let one = |i: &usize| errors(|p| (self.predict)(*i, p), self.observed[*i], at);
        self.trials.par_iter().map(one).collect()
    }

    /// Their slopes.
    pub(crate) fn slopes(&self, at: &[f64; P]) -> Vec<Vec<[f64; P]>> {
        let one = |i: &usize| {
            slopes(|p| (self.predict)(*i, p), self.observed[*i].len(), self.parameters, at)
        };
        self.trials.par_iter().map(one).collect()
    }

    /// Every trial's part of the normal equations at a point, with its slopes there.
    pub(crate) fn blocks(&self, at: &[f64; P], slopes: &[Vec<[f64; P]>]) -> Vec<Block<P>> {
        self.errors(at).iter().zip(slopes).map(|(errors, slopes)| block(errors, slopes)).collect()
    }
}

/// The last point the minimiser asked for.
struct Kept<const P: usize> {
    of: Option<[u64; P]>,
    errors: Vec<f64>,
    slopes: Vec<[f64; P]>,
    least: f64,
}

impl<const P: usize> Kept<P> {
    fn new() -> Self {
        Self { of: None, errors: Vec::new(), slopes: Vec::new(), least: f64::INFINITY }
    }

    /// Residual `i` at a point, with its slopes.
    fn at(&mut self, problem: &Problem<P>, at: &[f64; P], i: usize) -> (f64, [f64; P]) {
        let bits = at.map(f64::to_bits);
        if self.of != Some(bits) {
            self.make(problem, at);
            self.of = Some(bits);
        }
        (self.errors[i], self.slopes[i])
    }

    /// A minimiser steps back from a point that is not better, and never looks at its slopes: they
    /// are not made, which spares six runs of seven.
    fn make(&mut self, problem: &Problem<P>, at: &[f64; P]) {
        self.errors = problem.errors(at).concat();
        let rss: f64 = self.errors.iter().map(|e| e * e).sum();
        self.slopes = match rss < self.least {
            true => problem.slopes(at).concat(),
            false => vec![[0.0; P]; self.errors.len()],
        };
        self.least = self.least.min(rss);
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
