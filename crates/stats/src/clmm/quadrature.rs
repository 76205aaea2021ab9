//! One participant's likelihood by the trapezoidal rule on a lattice of effects.
//!
//! Given the participant's effect u those of the modes are independent, so the integral over 1 and
//! M effects is ∫ φ(u/σᵤ)/σᵤ Π Iₘ(u) du with Iₘ(u) = ∫ φ(w/σᵥ)/σᵥ P(answers in mode m | u + w) dw:
//! an integral of integrals. All are sums over a lattice of logits, multiples of a power of two,
//! and their sum u + w lies on it again: P is evaluated once per place of the lattice, not once per
//! pair of u and w.
//!
//! The integrands are analytic between the poles of the logistic function, at a distance of π from
//! the real line, and fall off as a normal density does. For such integrands the rule's error falls
//! exponentially with the lattice's step (Trefethen & Weideman 2014, SIAM Rev. 56:385), whatever
//! the SDs, and is below 1e-10 here. Between two steps the nodes do not move with the parameters:
//! the returned gradient is the derivative of the sum itself, so a search is not misled even far
//! from the estimates, where SDs are large and integrands nearly boxes.

use super::cell::{Levels, Residual, fixed, near};
use super::laplace::{Effects, settle};
use super::model::Cells;
use super::point::Point;
use core::f64::consts::PI;

/// Effects this many SDs from the most likely ones are left out. The posterior of an effect is
/// narrower than its normal density, as answers only narrow it (their likelihood is log-concave),
/// and its mean is within an SD or so of the most likely effect: less than 1e-12 of it is farther
/// out.
const REACH: f64 = 8.5;
/// An SD below this counts as none: the likelihood, even in it, gains less than rounding.
const NO_SD: f64 = 1e-8;
/// An SD above this counts as this: people so far apart give one answer each nearly always, and
/// farther ones the same.
const LARGEST_SD: f64 = 30.0;
/// Steps, at least, in the SD of an effect: the error of its density's sum is 2 e^(−2π² · 1.6²).
const STEPS_PER_SD: f64 = 1.6;
/// Steps, at least, in what the answers leave of that SD: an error of 2 e^(−2π² · 1.3²).
const STEPS_PER_POSTERIOR_SD: f64 = 1.3;
/// The largest step: with poles at ±πi the error is 2 e^(−2π² / 0.5).
const LARGEST_STEP: f64 = 0.5;
/// The most that one answer tells: −d² ln P / dη² is at most ½.
const INFORMATION: f64 = 0.5;
/// Nodes with less than this share of the integral are left out of its gradient.
const NO_SHARE: f64 = 1e-18;
/// Where even the largest product of probabilities is smaller, logarithms take its place: what is
/// lost at 1e-308 is then no part of the integral.
const LEAST_PRODUCT: f64 = 1e-200;

/// The logarithm of the likelihood (without the inner categories' widths) and its gradient by the
/// parameters. `effects` is where the search for the most likely ones begins, and where it ended.
pub(super) fn integrate(cells: &Cells, point: &Point, effects: &mut Effects) -> (f64, Point) {
    let sd = point.sd.map(|sd| sd.clamp(-LARGEST_SD, LARGEST_SD));
    let inside = Point { sd, ..point.clone() };
    settle(cells, &inside, effects);
    let levels = Levels::new(&point.theta);
    let fixed = fixed(cells, point);
    let lattice = Lattice::new(cells, sd, effects);
    let modes: Vec<Mode> =
        (0..cells.groups.len()).map(|m| Mode::new(cells, m, &levels, &fixed, &lattice)).collect();
    let heights = (0..lattice.outer.places.len()).map(|i| {
        modes.iter().map(|mode| libm::log(mode.inner[i])).sum::<f64>()
            + libm::log(lattice.outer.weights[i])
    });
    let (log_sum, shares) = log_sum(heights.collect());
    let mut gradient = Point::zero(point.theta.len(), point.beta.len());
    gradient.sd[0] = shares.iter().zip(&lattice.outer.scores).map(|(s, score)| s * score).sum();
    modes.iter().for_each(|mode| mode.add_to(&mut gradient, &lattice, &shares, &cells.x));
    for (slope, sd) in gradient.sd.iter_mut().zip(point.sd) {
        // Beyond the largest SD nothing changes.
        if sd.abs() > LARGEST_SD {
            *slope = 0.0;
        }
    }
    (log_sum + modes.iter().map(|mode| mode.log_scale).sum::<f64>(), gradient)
}

/// The nodes of one normal effect.
struct Axis {
    /// Effects, in logits: multiples of the step.
    places: Vec<f64>,
    /// Density times step.
    weights: Vec<f64>,
    /// d ln density / dσ.
    scores: Vec<f64>,
    step: f64,
}

impl Axis {
    /// The nodes of an effect, most likely at one of `centres` (in SDs), of which the answers tell
    /// no more than `information`, the inverse of a variance.
    fn new(sd: f64, information: f64, centres: &[f64]) -> Self {
        if sd.abs() < NO_SD {
            let step = LARGEST_STEP;
            return Self { places: vec![0.0], weights: vec![1.0], scores: vec![0.0], step };
        }
        let size = sd.abs();
        let posterior_sd = 1.0 / (1.0 / (size * size) + information).sqrt();
        let largest = (size / STEPS_PER_SD).min(posterior_sd / STEPS_PER_POSTERIOR_SD);
        // The largest power of two that is not above it, so that one axis' step is a whole multiple
        // of the other's.
        let step = libm::ldexp(1.0, libm::frexp(largest.min(LARGEST_STEP)).1 - 1);
        let ends = centres.iter().map(|centre| sd * centre);
        let low = ends.clone().fold(f64::INFINITY, f64::min) - REACH * size;
        let high = ends.fold(f64::NEG_INFINITY, f64::max) + REACH * size;
        let numbers = (low / step).ceil() as i32..=(high / step).floor() as i32;
        let places: Vec<f64> = numbers.map(|k| f64::from(k) * step).collect();
        let height = step / (size * (2.0 * PI).sqrt());
        let mut weights = Vec::with_capacity(places.len());
        let mut scores = Vec::with_capacity(places.len());
        for place in &places {
            let square = place * place / (size * size);
            weights.push(height * libm::exp(-square / 2.0));
            scores.push((square - 1.0) / sd);
        }
        Self { places, weights, scores, step }
    }
}

/// The nodes of the participant's effect and of the modes', and where their sums lie.
struct Lattice {
    outer: Axis,
    inner: Axis,
    /// Slots from an outer node, and from an inner one, to the next.
    strides: [usize; 2],
    /// The sum of the effects in each slot.
    sums: Vec<f64>,
    /// e^sum.
    lifts: Vec<f64>,
}

impl Lattice {
    fn new(cells: &Cells, sd: [f64; 2], effects: &Effects) -> Self {
        let answers: Vec<f64> = (0..cells.groups.len()).map(|m| answers(cells, m)).collect();
        let most = answers.iter().copied().fold(0.0, f64::max);
        let inner = Axis::new(sd[1], INFORMATION * most, &effects.modes);
        // What a mode tells of the participant is blurred by the mode's own effect.
        let blurred = answers.iter().map(|n| 1.0 / (sd[1] * sd[1] + 1.0 / (INFORMATION * n)));
        let outer = Axis::new(sd[0], blurred.sum(), &[effects.participant]);
        let n = outer.places.len();
        let k = inner.places.len();
        // Beyond the length of the finer axis no two sums share a slot, and a longer stride would
        // only leave slots empty.
        let strides = if outer.step >= inner.step {
            [((outer.step / inner.step) as usize).min(k), 1]
        } else {
            [1, ((inner.step / outer.step) as usize).min(n)]
        };
        let mut sums = vec![0.0; strides[0] * (n - 1) + strides[1] * (k - 1) + 1];
        for (i, u) in outer.places.iter().enumerate() {
            for (j, w) in inner.places.iter().enumerate() {
                sums[i * strides[0] + j * strides[1]] = u + w;
            }
        }
        let lifts = sums.iter().map(|sum| libm::exp(near(*sum))).collect();
        Self { outer, inner, strides, sums, lifts }
    }

    /// Σⱼ wⱼ f(u + w) for each outer node, of values f by slot and weights by inner node.
    fn over_inner(&self, weights: &[f64], by_slot: &[f64]) -> Vec<f64> {
        let [across, along] = self.strides;
        let n = self.outer.places.len();
        if across > 1 {
            let windows = (0..n).map(|i| &by_slot[i * across..]);
            return windows.map(|window| sum_of_products(weights, window)).collect();
        }
        let mut sums = vec![0.0; n];
        for (j, weight) in weights.iter().enumerate() {
            let values = by_slot[j * along..].iter();
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        sums
    }

    /// In each slot the sum of products of an outer node's factor and an inner node's weight whose effects add up to it.
    fn pairs(&self, factors: &[f64], weights: &[f64]) -> Vec<f64> {
        let [across, along] = self.strides;
        let mut by_slot = vec![0.0; self.sums.len()];
        let (rows, stride, row) =
            if across > 1 { (factors, across, weights) } else { (weights, along, factors) };
        for (number, factor) in rows.iter().enumerate() {
            let slots = by_slot[number * stride..].iter_mut();
            slots.zip(row).for_each(|(slot, value)| *slot += factor * value);
        }
        by_slot
    }
}

/// Σ aᵢ bᵢ over the shorter of the two, in four sums side by side.
fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 4;
    let mut sums = [0.0; SUMS];
    for (a, b) in a.chunks(SUMS).zip(b.chunks(SUMS)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum()
}

/// How many answers one mode has.
fn answers(cells: &Cells, m: usize) -> f64 {
    cells.groups[m]
        .clone()
        .map(|c| {
            let (below, beside) = (&cells.below[c], &cells.beside[c]);
            let last = beside.iter().zip(below).next_back().map_or(0.0, |(b, n)| b - n);
            below.iter().sum::<f64>() + last
        })
        .sum()
}

/// One mode's answers on the lattice.
struct Mode {
    /// P(answers | u + w) per slot, over the largest of them.
    shares: Vec<f64>,
    /// ln of the largest.
    log_scale: f64,
    /// nⱼ − Nⱼ F by slot, of each cell and threshold where there are answers.
    residuals: Vec<Residual>,
    /// Iₘ(u) per outer node, over the largest P.
    inner: Vec<f64>,
}

impl Mode {
    fn new(cells: &Cells, m: usize, levels: &Levels, fixed: &[f64], lattice: &Lattice) -> Self {
        let (shares, log_scale, residuals) = by_products(cells, m, levels, fixed, lattice)
            .unwrap_or_else(|| by_logarithms(cells, m, levels, fixed, lattice));
        let inner = lattice.over_inner(&lattice.inner.weights, &shares);
        Self { shares, log_scale, residuals, inner }
    }

    /// Adds the posterior mean of the gradient of ln P(answers | u + w) and of ln φ(w/σᵥ)/σᵥ, with
    /// the posterior `shares` of the outer nodes.
    fn add_to(&self, gradient: &mut Point, lattice: &Lattice, shares: &[f64], x: &[Vec<f64>]) {
        let Axis { weights, scores, .. } = &lattice.inner;
        let of_outer = shares.iter().zip(&self.inner);
        let of_outer: Vec<f64> = of_outer
            .map(|(share, inner)| if *share > NO_SHARE { share / inner } else { 0.0 })
            .collect();
        let scored: Vec<f64> = weights.iter().zip(scores).map(|(w, score)| w * score).collect();
        gradient.sd[1] += sum_of_products(&of_outer, &lattice.over_inner(&scored, &self.shares));
        // Slot by slot: many pairs of nodes share one, and the residuals of its cells.
        let mut posterior = lattice.pairs(&of_outer, weights);
        posterior.iter_mut().zip(&self.shares).for_each(|(pairs, share)| *pairs *= share);
        for Residual { cell, threshold, places } in &self.residuals {
            let mean = sum_of_products(&posterior, places);
            gradient.theta[*threshold] += mean;
            gradient.beta.iter_mut().zip(&x[*cell]).for_each(|(by, x)| *by -= mean * x);
        }
    }
}

/// P(answers of a mode) in each slot over the largest of them, the logarithm of the largest, and
/// the residuals.
type Shares = (Vec<f64>, f64, Vec<Residual>);

/// The shares by products of probabilities, which spares their logarithms; `None` where the answers
/// are too many for such a product.
fn by_products(
    cells: &Cells,
    m: usize,
    levels: &Levels,
    fixed: &[f64],
    lattice: &Lattice,
) -> Option<Shares> {
    let mut residuals = Vec::new();
    let mut shares = vec![1.0; lattice.lifts.len()];
    for cell in cells.groups[m].clone() {
        let own = libm::exp(near(fixed[cell]));
        let lifts: Vec<f64> = lattice.lifts.iter().map(|lift| lift * own).collect();
        levels.multiply_by_probability(cells, cell, &lifts, &mut shares, &mut residuals);
    }
    let most = shares.iter().fold(0.0, |most: f64, share| most.max(*share));
    if most < LEAST_PRODUCT {
        return None;
    }
    shares.iter_mut().for_each(|share| *share /= most);
    Some((shares, libm::log(most), residuals))
}

/// The shares by logarithms, for any number of answers.
fn by_logarithms(
    cells: &Cells,
    m: usize,
    levels: &Levels,
    fixed: &[f64],
    lattice: &Lattice,
) -> Shares {
    let mut residuals = Vec::new();
    let mut logarithms = vec![0.0; lattice.sums.len()];
    for cell in cells.groups[m].clone() {
        let mut by_threshold = Vec::new();
        for (logarithm, sum) in logarithms.iter_mut().zip(&lattice.sums) {
            let eta = fixed[cell] + sum;
            *logarithm += levels.slopes(cells, cell, eta, Some(&mut by_threshold)).value;
        }
        let thresholds = levels.thresholds();
        residuals.extend((0..thresholds).map(|threshold| Residual {
            cell,
            threshold,
            places: by_threshold.iter().skip(threshold).step_by(thresholds).copied().collect(),
        }));
    }
    let log_scale = logarithms.iter().fold(f64::NEG_INFINITY, |most, x| most.max(*x));
    let shares = logarithms.iter().map(|x| libm::exp(x - log_scale)).collect();
    (shares, log_scale, residuals)
}

/// ln Σ eˣ and each term's share of the sum.
fn log_sum(logarithms: Vec<f64>) -> (f64, Vec<f64>) {
    // Against the largest no exponential overflows, and the sum is 1 at least.
    let most = logarithms.iter().fold(f64::NEG_INFINITY, |most, x| most.max(*x));
    let mut shares: Vec<f64> = logarithms.iter().map(|x| libm::exp(x - most)).collect();
    let sum: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|s| *s /= sum);
    (most + libm::log(sum), shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One mode of one participant, who answered so often below and beside three thresholds.
    fn cells(times: f64) -> Cells {
        let below = vec![vec![2.0 * times, times, 4.0 * times]];
        let beside = vec![vec![3.0 * times, 5.0 * times, 7.0 * times]];
        Cells { groups: std::iter::once(0..1).collect(), x: vec![vec![]], below, beside }
    }

    #[test]
    fn products_are_what_logarithms_say_and_too_many_answers_are_left_to_those() {
        let levels = Levels::new(&[-1.5, 0.25, 3.0]);
        for (times, has_product) in [(1.0, true), (10.0, true), (1000.0, false)] {
            let cells = cells(times);
            let lattice = Lattice::new(&cells, [0.8, 0.6], &Effects::none(&cells));
            let (shares, log_scale, residuals) =
                by_logarithms(&cells, 0, &levels, &[0.3], &lattice);
            let products = by_products(&cells, 0, &levels, &[0.3], &lattice);
            assert_eq!(products.is_some(), has_product, "{times}");
            if let Some((found, scale, left)) = products {
                assert!((scale - log_scale).abs() < 1e-11 * times);
                assert!(found.iter().zip(&shares).all(|(a, b)| (a - b).abs() < 1e-11 * times));
                for (a, b) in left.iter().zip(&residuals) {
                    assert_eq!((a.cell, a.threshold), (b.cell, b.threshold));
                    let pairs = a.places.iter().zip(&b.places);
                    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12 * times));
                }
            }
        }
    }
}
