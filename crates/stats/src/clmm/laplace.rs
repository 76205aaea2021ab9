//! Laplace's approximation of one participant's likelihood, with its exact gradient.
//!
//! With standardised effects v₀ (participant) and vₘ (one per mode), η = xβ + σᵤ v₀ + σᵥ vₘ, let
//! h(v) = |v|²/2 − Σ ln P(answers | v). Then ∫ e^(−h) dv (2π)^(−q/2) ≈ e^(−h(v̂)) |H|^(−1/2), H the
//! second derivatives of h at its minimum v̂ (Tierney & Kadane 1986, JASA 81:82; Christensen 2022,
//! vignettes of R's ordinal). Given v₀ the modes are independent, so H is an arrow: with S the
//! bend Σ Nⱼ F(1 − F) of a mode's cells, A = 1 + σᵥ² S and c = 1 + σᵤ² Σ S/A, |H| = c Π A, and a
//! system with H costs one pass over the modes.
//!
//! The gradient follows v̂ through ∂v̂/∂ψ = −H⁻¹ ∂²h/∂v∂ψ; one system per participant serves all
//! parameters, because only its product with ∂ ln|H|/∂v is needed.

use super::model::Cells;
use super::point::Point;
use crate::logistic::softplus_and_share;
use crate::symmetric::dot;

/// The search ends where no effect moves by more than this in a step; the last step squares it.
const STEP: f64 = 1e-7;
/// Next to the minimum rounding hides the fall of h: steps shorter than this are taken unseen.
const TRUSTED: f64 = 1e-4;
/// A convex function with its exact second derivatives needs a handful of steps, a dozen from far.
const MAX_STEPS: usize = 100;

/// The most likely effects of one participant: where a search begins that has been there before.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Effects {
    /// v₀, in SDs.
    pub(super) participant: f64,
    /// vₘ, in SDs.
    pub(super) modes: Vec<f64>,
}

impl Effects {
    /// No effects.
    pub(super) fn none(cells: &Cells) -> Self {
        Self { participant: 0.0, modes: vec![0.0; cells.groups.len()] }
    }
}

/// Sums over the cells of one mode: slope and bend by η.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes {
    /// ln P(answers).
    pub(super) value: f64,
    /// d ln P / dη.
    pub(super) slope: f64,
    /// −d² ln P / dη².
    pub(super) bend: f64,
}

impl Slopes {
    pub(super) fn add(&mut self, other: Self) {
        self.value += other.value;
        self.slope += other.slope;
        self.bend += other.bend;
    }
}

/// xβ of each cell.
pub(super) fn fixed(cells: &Cells, point: &Point) -> Vec<f64> {
    cells.x.iter().map(|x| dot(x, &point.beta)).collect()
}

/// The terms of one cell that depend on η.
pub(super) fn slopes(cells: &Cells, cell: usize, theta: &[f64], eta: f64) -> Slopes {
    let mut sum = Slopes::default();
    for ((theta, below), beside) in theta.iter().zip(&cells.below[cell]).zip(&cells.beside[cell]) {
        if *beside > 0.0 {
            let z = theta - eta;
            let (softplus, share) = softplus_and_share(z);
            sum.value += below * z - beside * softplus;
            sum.slope += beside * share - below;
            sum.bend += beside * share * (1.0 - share);
        }
    }
    sum
}

/// The logarithm of the approximation (without the inner categories' widths, which are the same
/// for all) and its gradient by the parameters. `effects` is where the search starts, and where it
/// ended.
pub(super) fn laplace(cells: &Cells, point: &Point, effects: &mut Effects) -> (f64, Point) {
    let fixed = fixed(cells, point);
    let arrow = settle(cells, point, &fixed, effects);
    let value = -arrow.height - arrow.log_determinant() / 2.0;
    (value, gradient(cells, point, &fixed, effects, &arrow))
}

/// h and its derivatives at some effects.
struct Arrow {
    height: f64,
    /// Per mode.
    slopes: Vec<Slopes>,
    /// A = 1 + σᵥ² S, per mode.
    spokes: Vec<f64>,
    /// c = 1 + σᵤ² Σ S/A.
    hub: f64,
    sd: [f64; 2],
}

impl Arrow {
    fn new(cells: &Cells, point: &Point, fixed: &[f64], effects: &Effects) -> Self {
        let mut height = effects.participant * effects.participant / 2.0;
        let mut slopes = Vec::with_capacity(cells.groups.len());
        for (group, v) in cells.groups.iter().zip(&effects.modes) {
            let shift = point.sd[0] * effects.participant + point.sd[1] * v;
            let mut sum = Slopes::default();
            for cell in group.clone() {
                sum.add(self::slopes(cells, cell, &point.theta, fixed[cell] + shift));
            }
            height += v * v / 2.0 - sum.value;
            slopes.push(sum);
        }
        let spokes: Vec<f64> =
            slopes.iter().map(|s| 1.0 + point.sd[1] * point.sd[1] * s.bend).collect();
        let share: f64 = slopes.iter().zip(&spokes).map(|(s, a)| s.bend / a).sum();
        let hub = 1.0 + point.sd[0] * point.sd[0] * share;
        Self { height, slopes, spokes, hub, sd: point.sd }
    }

    fn log_determinant(&self) -> f64 {
        libm::log(self.hub) + self.spokes.iter().map(|a| libm::log(*a)).sum::<f64>()
    }

    /// Solves H x = b.
    fn solve(&self, b: &Effects) -> Effects {
        let product = self.sd[0] * self.sd[1];
        let spokes = || self.slopes.iter().zip(&self.spokes);
        let known: f64 = spokes().zip(&b.modes).map(|((s, a), b)| product * s.bend / a * b).sum();
        let participant = (b.participant - known) / self.hub;
        let mode = |((s, a), b): ((&Slopes, &f64), &f64)| (b - product * s.bend * participant) / a;
        Effects { participant, modes: spokes().zip(&b.modes).map(mode).collect() }
    }

    /// −∂h/∂v.
    fn descent(&self, effects: &Effects) -> Effects {
        let all: f64 = self.slopes.iter().map(|s| s.slope).sum();
        let mode = |(s, v): (&Slopes, &f64)| self.sd[1] * s.slope - v;
        Effects {
            participant: self.sd[0] * all - effects.participant,
            modes: self.slopes.iter().zip(&effects.modes).map(mode).collect(),
        }
    }
}

/// Moves the effects to the minimum of h by Newton's method with halved steps.
fn settle(cells: &Cells, point: &Point, fixed: &[f64], effects: &mut Effects) -> Arrow {
    let mut here = Arrow::new(cells, point, fixed, effects);
    for _ in 0..MAX_STEPS {
        let step = here.solve(&here.descent(effects));
        let longest = step.modes.iter().fold(step.participant.abs(), |m, s| m.max(s.abs()));
        let mut share = 1.0;
        loop {
            let trial = moved(effects, &step, share);
            let there = Arrow::new(cells, point, fixed, &trial);
            if longest < TRUSTED || there.height < here.height || share < f64::EPSILON {
                (*effects, here) = (trial, there);
                break;
            }
            share /= 2.0;
        }
        if longest.is_nan() || longest < STEP || share < f64::EPSILON {
            break;
        }
    }
    here
}

fn moved(effects: &Effects, step: &Effects, share: f64) -> Effects {
    let modes = effects.modes.iter().zip(&step.modes).map(|(v, s)| v + share * s).collect();
    Effects { participant: effects.participant + share * step.participant, modes }
}

fn gradient(
    cells: &Cells,
    point: &Point,
    fixed: &[f64],
    effects: &Effects,
    arrow: &Arrow,
) -> Point {
    let [su, sw] = point.sd;
    let mut sum = Point::zero(point.theta.len(), point.beta.len());
    // q: half the variance of η of a mode's cells; −½ d ln|H| = −q dS.
    let q: Vec<f64> =
        arrow.spokes.iter().map(|a| 0.5 * (sw * sw / a + su * su / (arrow.hub * a * a))).collect();
    // T = −dS/dη, per mode: half of what moves ln|H| along v.
    let twists: Vec<f64> = cells
        .groups
        .iter()
        .zip(&effects.modes)
        .map(|(group, v)| {
            let shift = su * effects.participant + sw * v;
            group.clone().map(|cell| twist(cells, cell, &point.theta, fixed[cell] + shift)).sum()
        })
        .collect();
    let pull: Vec<f64> = q.iter().zip(&twists).map(|(q, t)| q * t).collect();
    let along = Effects {
        participant: su * pull.iter().sum::<f64>(),
        modes: pull.iter().map(|p| sw * p).collect(),
    };
    let adjoint = arrow.solve(&along);
    for (m, group) in cells.groups.iter().enumerate() {
        let (v, a) = (effects.modes[m], arrow.spokes[m]);
        let shift = su * effects.participant + sw * v;
        let follow = su * adjoint.participant + sw * adjoint.modes[m];
        let mut by_eta = 0.0;
        for cell in group.clone() {
            let mut cell_by_eta = 0.0;
            let counts = cells.below[cell].iter().zip(&cells.beside[cell]);
            for ((theta, (below, beside)), by) in point.theta.iter().zip(counts).zip(&mut sum.theta)
            {
                let (_, share) = softplus_and_share(theta - fixed[cell] - shift);
                let bend = beside * share * (1.0 - share);
                let along =
                    below - beside * share - q[m] * bend * (1.0 - 2.0 * share) + follow * bend;
                *by += along;
                cell_by_eta -= along;
            }
            sum.beta.iter_mut().zip(&cells.x[cell]).for_each(|(by, x)| *by += cell_by_eta * x);
            by_eta += cell_by_eta;
        }
        let Slopes { slope, bend, .. } = arrow.slopes[m];
        let bend_share = bend / a;
        sum.sd[0] += by_eta * effects.participant + adjoint.participant * slope
            - su * bend_share / arrow.hub;
        sum.sd[1] += by_eta * v + adjoint.modes[m] * slope - sw * bend_share
            + su * su * sw / arrow.hub * bend_share * bend_share;
    }
    sum
}

/// Σ Nⱼ F'' of one cell.
fn twist(cells: &Cells, cell: usize, theta: &[f64], eta: f64) -> f64 {
    let one = |(theta, beside): (&f64, &f64)| {
        let (_, share) = softplus_and_share(theta - eta);
        beside * share * (1.0 - share) * (1.0 - 2.0 * share)
    };
    theta.iter().zip(&cells.beside[cell]).map(one).sum()
}
