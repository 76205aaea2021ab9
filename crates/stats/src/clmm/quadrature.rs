//! One participant's likelihood by nested adaptive Gauss–Hermite quadrature.
//!
//! Given the participant's effect v₀ those of the modes are independent, so the integral over
//! 1 + M effects is ∫ φ(v₀) Π Iₘ(σᵤ v₀) dv₀ with Iₘ(s) = ∫ φ(v) P(answers in mode m | s + σᵥ v) dv:
//! Q outer nodes times M integrals of Q inner nodes, in place of Q^(1 + M). Nodes are placed by mode
//! and curvature of the integrand (Liu & Pierce 1994, Biometrika 81:624): the inner ones anew per
//! outer node, the outer ones by the product of the inner integrals, not by the joint mode.
//!
//! The gradient is that of the integral, by Fisher's identity: the posterior mean of the gradient
//! of ln P(answers | v), with the same nodes. It differs from the derivative of the rule by what
//! the rule itself is off.

use super::cell::{Levels, Slopes, fixed};
use super::laplace::Effects;
use super::model::Cells;
use super::point::Point;
use core::f64::consts::{PI, SQRT_2};
use zwidth_numerics::gauss_hermite::Rule;

/// Nodes need not sit on the mode to rounding: a step as short as this is the last, and leaves
/// its square.
const STEP: f64 = 1e-4;
/// More steps than a log-concave integrand takes.
const MAX_STEPS: usize = 100;
/// A step beyond this many SDs overshoots: it is cut.
const LONGEST: f64 = 5.0;

/// The logarithm of the likelihood (without the inner categories' widths) and its gradient by the
/// parameters. `effects` is where the searches for modes begin, and where they ended.
pub(super) fn integrate(
    cells: &Cells,
    point: &Point,
    rule: &Rule,
    effects: &mut Effects,
) -> (f64, Point) {
    let (levels, fixed) = (Levels::new(&point.theta), fixed(cells, point));
    let log_weights: Vec<f64> = rule.weights.iter().map(|w| libm::log(*w)).collect();
    let outer = Outer { cells, point, levels, fixed, nodes: &rule.nodes, log_weights };
    let scale = outer.settle(effects);
    let centre = effects.participant;
    let mut nodes: Vec<Node> = Vec::with_capacity(rule.nodes.len());
    for (x, log_weight) in rule.nodes.iter().zip(&outer.log_weights) {
        let mut node = outer.node(centre + SQRT_2 * scale * x, effects);
        node.log_weight += log_weight;
        nodes.push(node);
    }
    let (log_sum, shares) = log_sum(nodes.iter().map(|node| node.log_weight));
    let mut gradient = Point::zero(point.theta.len(), point.beta.len());
    for (node, share) in nodes.iter().zip(&shares) {
        node.add_to(&mut gradient, share, cells);
    }
    // dv₀ = √2 scale dx, and φ = e^(−v²/2) / √(2π).
    (log_sum + libm::log(scale) - libm::log(PI) / 2.0, gradient)
}

/// What the outer integrand is made of.
struct Outer<'a> {
    cells: &'a Cells,
    point: &'a Point,
    levels: Levels,
    /// xβ per cell.
    fixed: Vec<f64>,
    nodes: &'a [f64],
    log_weights: Vec<f64>,
}

/// The outer integrand at one v₀.
struct Node {
    v: f64,
    /// −v₀²/2 + Σ ln Iₘ.
    log_weight: f64,
    /// Its first derivative by v₀, and the negative of its second.
    slope: f64,
    bend: f64,
    /// Posterior mean of nⱼ − Nⱼ F, cell by cell and threshold by threshold.
    residuals: Vec<f64>,
    /// Posterior mean of Σ vₘ times the slope of mode m.
    mode_slope: f64,
}

impl Node {
    /// Adds `share` of this node's gradient.
    fn add_to(&self, gradient: &mut Point, share: &f64, cells: &Cells) {
        let thresholds = gradient.theta.len();
        let mut by_eta = 0.0;
        for (cell, residuals) in self.residuals.chunks_exact(thresholds).enumerate() {
            let all: f64 = residuals.iter().sum();
            gradient.theta.iter_mut().zip(residuals).for_each(|(by, r)| *by += share * r);
            let x = &cells.x[cell];
            gradient.beta.iter_mut().zip(x).for_each(|(by, x)| *by -= share * all * x);
            by_eta -= all;
        }
        gradient.sd[0] += share * self.v * by_eta;
        gradient.sd[1] += share * self.mode_slope;
    }
}

impl Outer<'_> {
    /// Moves `effects.participant` to the mode of the outer integrand; gives the scale 1/√bend.
    fn settle(&self, effects: &mut Effects) -> f64 {
        let (mut scale, mut bracket) = (1.0, Bracket::NONE);
        for _ in 0..MAX_STEPS {
            let here = self.node(effects.participant, effects);
            let step = (here.slope / here.bend).clamp(-LONGEST, LONGEST);
            scale = 1.0 / here.bend.sqrt();
            if step.is_nan() || step.abs() < STEP * scale {
                effects.participant += step;
                break;
            }
            effects.participant = bracket.step(effects.participant, step);
        }
        scale
    }

    /// The outer integrand at `v`.
    fn node(&self, v: f64, effects: &mut Effects) -> Node {
        let su = self.point.sd[0];
        let mut node = Node {
            v,
            log_weight: -v * v / 2.0,
            slope: -v,
            bend: 1.0,
            residuals: Vec::with_capacity(self.cells.x.len() * self.point.theta.len()),
            mode_slope: 0.0,
        };
        for m in 0..self.cells.groups.len() {
            let inner = self.inner(m, su * v, &mut effects.modes[m], &mut node);
            node.log_weight += inner.value;
            node.slope += su * inner.slope;
            node.bend += su * su * inner.bend;
        }
        node
    }

    /// ln Iₘ at the shift σᵤ v₀ with its slope and bend by that shift. What the mode gives to the
    /// gradient goes to the node.
    fn inner(&self, m: usize, shift: f64, mode: &mut f64, node: &mut Node) -> Slopes {
        let sw = self.point.sd[1];
        if sw.abs() <= f64::MIN_POSITIVE {
            *mode = 0.0;
            return self.group(m, shift, Some(&mut node.residuals));
        }
        let scale = self.settle_mode(m, shift, mode);
        let place = |x: &f64| *mode + SQRT_2 * scale * x;
        let mut residuals = Vec::new();
        let at: Vec<Slopes> = self
            .nodes
            .iter()
            .map(|x| self.group(m, shift + sw * place(x), Some(&mut residuals)))
            .collect();
        let weigh = |((x, here), log_weight): ((&f64, &Slopes), &f64)| {
            here.value - place(x) * place(x) / 2.0 + log_weight
        };
        let (log_sum, shares) =
            log_sum(self.nodes.iter().zip(&at).zip(&self.log_weights).map(weigh));
        let mut mean = Slopes::default();
        for ((x, here), share) in self.nodes.iter().zip(&at).zip(&shares) {
            mean.slope += share * here.slope;
            mean.bend += share * here.bend;
            node.mode_slope += share * place(x) * here.slope;
        }
        let first = node.residuals.len();
        let width = residuals.len() / shares.len();
        node.residuals.resize(first + width, 0.0);
        for (residuals, share) in residuals.chunks_exact(width).zip(&shares) {
            let means = node.residuals[first..].iter_mut().zip(residuals);
            means.for_each(|(mean, residual)| *mean += share * residual);
        }
        // The logarithm of a mean bends by the mean bend less the slopes' variance.
        let spread = |(here, share): (&Slopes, &f64)| {
            share * (here.slope - mean.slope) * (here.slope - mean.slope)
        };
        let variance: f64 = at.iter().zip(&shares).map(spread).sum();
        Slopes {
            value: log_sum + libm::log(scale) - libm::log(PI) / 2.0,
            slope: mean.slope,
            bend: mean.bend - variance,
        }
    }

    /// Moves `mode` to that of the inner integrand; gives the scale.
    fn settle_mode(&self, m: usize, shift: f64, mode: &mut f64) -> f64 {
        let sw = self.point.sd[1];
        let (mut scale, mut bracket) = (1.0, Bracket::NONE);
        for _ in 0..MAX_STEPS {
            let here = self.group(m, shift + sw * *mode, None);
            let bend = 1.0 + sw * sw * here.bend;
            let step = ((sw * here.slope - *mode) / bend).clamp(-LONGEST, LONGEST);
            scale = 1.0 / bend.sqrt();
            if step.is_nan() || step.abs() < STEP * scale {
                *mode += step;
                break;
            }
            *mode = bracket.step(*mode, step);
        }
        scale
    }

    /// ln P(answers in mode m) with its slope and bend by η; nⱼ − Nⱼ F of each cell and threshold
    /// is pushed where it is asked for.
    fn group(&self, m: usize, shift: f64, mut residuals: Option<&mut Vec<f64>>) -> Slopes {
        let mut sum = Slopes::default();
        for cell in self.cells.groups[m].clone() {
            let eta = self.fixed[cell] + shift;
            sum.add(self.levels.slopes(self.cells, cell, eta, residuals.as_deref_mut()));
        }
        sum
    }
}

/// Where the mode of a log-concave integrand lies: it rises below and falls above. Newton's steps
/// alone may go to and fro for ever where an answer is a steep step of the effect, as it is where
/// people differ a lot.
struct Bracket {
    low: f64,
    high: f64,
}

impl Bracket {
    const NONE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// A step from `here`, or halfway across the bracket where that one would leave it. The
    /// integrand rises in the direction of `step`.
    fn step(&mut self, here: f64, step: f64) -> f64 {
        if step > 0.0 {
            self.low = here;
        } else {
            self.high = here;
        }
        let there = here + step;
        let inside = self.low < there && there < self.high;
        if inside { there } else { f64::midpoint(self.low, self.high) }
    }
}

/// ln Σ eˣ and each term's share of the sum.
fn log_sum(logarithms: impl Iterator<Item = f64> + Clone) -> (f64, Vec<f64>) {
    let most = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
    let mut shares: Vec<f64> = logarithms.map(|x| libm::exp(x - most)).collect();
    let sum: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|s| *s /= sum);
    (most + libm::log(sum), shares)
}
