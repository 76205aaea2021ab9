//! The best θ: several starts, then the fits with a variance of exactly zero; the lowest criterion
//! wins.

use super::design::Design;
use super::profile::{factors, profile};
use crate::tested::Unestimable;
use zwidth_numerics::dense::{Matrix, dot};
use zwidth_numerics::minimise::minimise;

/// Relative standard deviations that searches begin with.
const STARTS: [f64; 2] = [1.0, 0.1];
/// Slope that ends a search, as a share of the rows: an error of 1e-10 or so in θ.
const SLOPE: f64 = 1e-10;
/// Slope that an optimum may be left with where rounding ended the search, as a share of the rows.
const SLOPE_LEFT: f64 = 1e-6;
/// Criteria within this share of the rows (and of themselves) are one.
const SAME: f64 = 1e-12;
/// A residual variance below this share of the response's counts as 0: the repeats do not differ.
const NO_VARIANCE: f64 = 1e-10;

/// The best θ found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Optimum {
    /// The entries of the terms' factors, diagonals not negative.
    pub(super) theta: Vec<f64>,
    /// Minus twice the log-likelihood.
    pub(super) deviance: f64,
    /// Largest component of the gradient in the entries that are not held at zero.
    pub(super) slope: f64,
    /// Smallest slope of the criterion in a variance that is zero; not negative at an optimum.
    pub(super) bound_slope: Option<f64>,
    /// Steps of the search that found it.
    pub(super) iterations: usize,
    /// Whether a column of a factor is zero.
    pub(super) singular: bool,
}

/// Minimises the criterion.
pub(super) fn search(design: &Design, reml: bool) -> Result<Optimum, Unestimable> {
    let all: Vec<bool> = vec![true; design.entries.len()];
    let starts = STARTS.map(|start| {
        let diagonal = design.entries.iter().map(|e| if e.a == e.b { start } else { 0.0 });
        descend(design, reml, &diagonal.collect::<Vec<f64>>(), &all)
    });
    // The criterion may have several minima: a search from large variances and one from small.
    let mut best = starts.into_iter().flatten().min_by(|a, b| a.deviance.total_cmp(&b.deviance));
    // Each round holds one column more, so there are no more rounds than columns.
    while let Some(descent) = &best {
        let Some(lower) = with_a_zero(design, reml, descent) else { break };
        let iterations = descent.iterations + lower.iterations;
        best = Some(Descent { iterations, ..lower });
    }
    match best.map(|descent| finish(design, reml, descent)) {
        Some(Finished { spent: true, .. }) => Err(Unestimable::Constant { units: "repeats" }),
        Some(Finished { optimum, .. }) if is_optimal(design, &optimum) => Ok(optimum),
        other => Err(Unestimable::NotConverged {
            what: "the variances",
            slope: other.map_or(f64::INFINITY, |finished| finished.optimum.slope),
        }),
    }
}

/// The end of one descent; entries that are not `free` were held at zero.
#[derive(Debug, Clone)]
struct Descent {
    theta: Vec<f64>,
    free: Vec<bool>,
    deviance: f64,
    slope: f64,
    iterations: usize,
}

/// An optimum, and whether it has spent all of the residual variance.
struct Finished {
    optimum: Optimum,
    spent: bool,
}

/// Goes down from `start` in the free entries; `None` if the criterion does not exist there.
fn descend(design: &Design, reml: bool, start: &[f64], free: &[bool]) -> Option<Descent> {
    let chosen = |all: &[f64]| -> Vec<f64> {
        all.iter().zip(free).filter(|(_, free)| **free).map(|(x, _)| *x).collect()
    };
    let spread_out = |few: &[f64]| -> Vec<f64> {
        let mut few = few.iter();
        free.iter()
            .map(|free| if *free { few.next().copied().unwrap_or(0.0) } else { 0.0 })
            .collect()
    };
    let criterion = |few: &[f64]| match profile(design, reml, &spread_out(few)) {
        Some(profile) => (profile.deviance, chosen(&profile.gradient)),
        None => (f64::NAN, vec![f64::NAN; few.len()]),
    };
    let minimum = minimise(criterion, &chosen(start), SLOPE * design.rows as f64).ok()?;
    Some(Descent {
        theta: spread_out(&minimum.point),
        free: free.to_vec(),
        deviance: minimum.value,
        slope: minimum.slope(),
        iterations: minimum.iterations,
    })
}

/// The lowest of the fits that hold one more column of a factor at zero, if it is no higher.
fn with_a_zero(design: &Design, reml: bool, from: &Descent) -> Option<Descent> {
    let columns: Vec<(usize, usize)> =
        design.entries.iter().filter(|e| e.a == e.b).map(|e| (e.term, e.b)).collect();
    let held = columns.into_iter().filter_map(|(term, b)| {
        let inside = design.entries.iter().map(|entry| entry.term == term && entry.b == b);
        let free: Vec<bool> =
            from.free.iter().zip(inside).map(|(free, inside)| *free && !inside).collect();
        (free != from.free).then(|| descend(design, reml, &from.theta, &free)).flatten()
    });
    let lowest = held.min_by(|a, b| a.deviance.total_cmp(&b.deviance))?;
    // A variance of zero is preferred to one that gains nothing but rounding.
    let same = SAME * (design.rows as f64 + from.deviance.abs());
    (lowest.deviance <= from.deviance + same).then_some(lowest)
}

/// Rectifies signs and computes the slopes in variances that are zero.
fn finish(design: &Design, reml: bool, descent: Descent) -> Finished {
    let Descent { mut theta, free, deviance, slope, iterations } = descent;
    // A column of T and its negative make the same covariance: the one with a diagonal above 0
    // stands.
    for (at, entry) in design.entries.iter().enumerate() {
        if entry.a == entry.b && theta[at] < 0.0 {
            let column = design.entries.iter().zip(&mut theta);
            column
                .filter(|(e, _)| e.term == entry.term && e.b == entry.b)
                .for_each(|(_, theta)| *theta = -*theta);
        }
    }
    let last = profile(design, reml, &theta);
    let spent = last.as_ref().is_none_or(|last| last.rss <= NO_VARIANCE * design.rss);
    let bound_slope = last.as_ref().and_then(|last| {
        let zero = design.entries.iter().zip(&free).filter(|(e, free)| e.a == e.b && !**free);
        zero.map(|(e, _)| {
            // A new column may hold anything from its diagonal down.
            let slopes = &last.in_variances[e.term];
            let size = slopes.rows - e.b;
            let below = Matrix::from_fn(size, size, |i, j| slopes[(e.b + i, e.b + j)]);
            below.eigen().0.into_iter().fold(f64::INFINITY, f64::min)
        })
        .min_by(f64::total_cmp)
    });
    let singular = factors(design, &theta).iter().any(|t| {
        (0..t.rows).any(|b| {
            let column: Vec<f64> = (b..t.rows).map(|a| t[(a, b)]).collect();
            dot(&column, &column) <= 0.0
        })
    });
    Finished {
        optimum: Optimum { theta, deviance, slope, bound_slope, iterations, singular },
        spent,
    }
}

/// Whether the criterion is flat in what is free, and does not fall from what is zero.
fn is_optimal(design: &Design, optimum: &Optimum) -> bool {
    let left = SLOPE_LEFT * design.rows as f64;
    optimum.slope <= left && optimum.bound_slope.is_none_or(|slope| slope >= -left)
}
