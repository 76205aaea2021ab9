//! The log-likelihood of all participants at one point, and its gradient.

use super::laplace::{Effects, laplace};
use super::model::Model;
use super::point::Point;
use super::quadrature::integrate;
use crate::logistic::inner;
use rayon::prelude::*;

/// How the random effects are integrated out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integral {
    /// Laplace's approximation: quick, biased where a participant gave few answers.
    Laplace,
    /// The trapezoidal rule on a lattice, to ten digits or more.
    Quadrature,
}

/// Participants that are worth a task of their own: Laplace's approximation of one takes
/// microseconds, quadrature a hundred times that.
const TOGETHER: [usize; 2] = [64, 2];

/// The log-likelihood as a function of the parameters. It remembers each participant's effects, so
/// that the next search for them begins near its end.
pub(super) struct Likelihood<'a> {
    model: &'a Model,
    integral: Integral,
    effects: Vec<Effects>,
    /// Answers per category.
    counts: Vec<f64>,
}

impl<'a> Likelihood<'a> {
    pub(super) fn new(model: &'a Model, integral: Integral) -> Self {
        let mut counts = vec![0.0; model.answers.categories()];
        model.answers.codes.iter().for_each(|&code| counts[code] += 1.0);
        let effects = model.participants.iter().map(Effects::none).collect();
        Self { model, integral, effects, counts }
    }

    /// The log-likelihood and its gradient by the parameters. Participants are summed in their
    /// order: the bits do not depend on the number of threads.
    pub(super) fn at(&mut self, point: &Point) -> (f64, Point) {
        let integral = self.integral;
        let parts: Vec<(f64, Point)> = self
            .model
            .participants
            .par_iter()
            .zip(self.effects.par_iter_mut())
            .with_min_len(TOGETHER[usize::from(integral == Integral::Quadrature)])
            .map(|(cells, effects)| match integral {
                Integral::Laplace => laplace(cells, point, effects),
                Integral::Quadrature => integrate(cells, point, effects),
            })
            .collect();
        // The inner categories' part, which no effect moves.
        let mut value = 0.0;
        let mut gradient = Point::zero(point.theta.len(), point.beta.len());
        for k in 1..point.theta.len() {
            let [part, slope, _] = inner(self.counts[k], point.theta[k] - point.theta[k - 1]);
            value += part;
            gradient.theta[k] += slope;
            gradient.theta[k - 1] -= slope;
        }
        for (part, by) in &parts {
            value += part;
            gradient.add(by);
        }
        if !value.is_finite() {
            // Effects that led nowhere are no place to begin.
            self.effects = self.model.participants.iter().map(Effects::none).collect();
        }
        (value, gradient)
    }
}
