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

use super::cell::{Levels, Slopes, fixed};
use super::model::Cells;
use super::point::Point;

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

/// The logarithm of the approximation (without the inner categories' widths, which are the same
/// for all) and its gradient by the parameters. `effects` is where the search starts, and where it
/// ended.
pub(super) fn laplace(cells: &Cells, point: &Point, effects: &mut Effects) -> (f64, Point) {
    let levels = Levels::new(&point.theta);
    let fixed = fixed(cells, point);
    let person = Person { cells, point, levels, fixed };
    let arrow = person.settle(effects);
    // |H| = c Π A.
    let log_determinant =
        libm::log(arrow.hub) + arrow.spokes.iter().map(|a| libm::log(*a)).sum::<f64>();
    let value = -arrow.height - log_determinant / 2.0;
    (value, person.gradient(effects, &arrow))
}

/// Moves `effects` to the most likely ones.
pub(super) fn settle(cells: &Cells, point: &Point, effects: &mut Effects) {
    let levels = Levels::new(&point.theta);
    let fixed = fixed(cells, point);
    Person { cells, point, levels, fixed }.settle(effects);
}

/// A participant at one point of the parameters.
struct Person<'a> {
    cells: &'a Cells,
    point: &'a Point,
    levels: Levels,
    /// xβ per cell.
    fixed: Vec<f64>,
}

/// h and its second derivatives at some effects.
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
    fn new(height: f64, slopes: Vec<Slopes>, sd: [f64; 2]) -> Self {
        let spokes: Vec<f64> = slopes.iter().map(|s| 1.0 + sd[1] * sd[1] * s.bend).collect();
        let share: f64 = slopes.iter().zip(&spokes).map(|(s, a)| s.bend / a).sum();
        Self { height, slopes, spokes, hub: 1.0 + sd[0] * sd[0] * share, sd }
    }

    /// Solves H x = b.
    fn solve(&self, b: &Effects) -> Effects {
        let product = self.sd[0] * self.sd[1];
        let spokes = self.slopes.iter().zip(&self.spokes).zip(&b.modes);
        let eliminated: f64 = spokes.clone().map(|((s, a), b)| product * s.bend / a * b).sum();
        let participant = (b.participant - eliminated) / self.hub;
        let modes = spokes.map(|((s, a), b)| (b - product * s.bend * participant) / a).collect();
        Effects { participant, modes }
    }

    /// −∂h/∂v.
    fn descent(&self, effects: &Effects) -> Effects {
        let all: f64 = self.slopes.iter().map(|s| s.slope).sum();
        let modes = self.slopes.iter().zip(&effects.modes);
        Effects {
            participant: self.sd[0] * all - effects.participant,
            modes: modes.map(|(s, v)| self.sd[1] * s.slope - v).collect(),
        }
    }

    /// Half the variance of η in each mode: what ½ ln|H| gains per unit of its bend S.
    fn half_variances(&self) -> Vec<f64> {
        let [su, sw] = self.sd;
        self.spokes.iter().map(|a| 0.5 * (sw * sw / a + su * su / (self.hub * a * a))).collect()
    }
}

impl Person<'_> {
    /// η of a cell.
    fn eta(&self, cell: usize, mode: usize, effects: &Effects) -> f64 {
        let [su, sw] = self.point.sd;
        self.fixed[cell] + su * effects.participant + sw * effects.modes[mode]
    }

    /// h and its second derivatives at `effects`.
    fn arrow(&self, effects: &Effects) -> Arrow {
        let mut height = effects.participant * effects.participant / 2.0;
        let mut slopes = Vec::with_capacity(self.cells.groups.len());
        for (mode, group) in self.cells.groups.iter().enumerate() {
            let mut sum = Slopes::default();
            for cell in group.clone() {
                let eta = self.eta(cell, mode, effects);
                sum.add(self.levels.slopes(self.cells, cell, eta, None));
            }
            height += effects.modes[mode] * effects.modes[mode] / 2.0 - sum.value;
            slopes.push(sum);
        }
        Arrow::new(height, slopes, self.point.sd)
    }

    /// Moves the effects to the minimum of h by Newton's method with halved steps.
    fn settle(&self, effects: &mut Effects) -> Arrow {
        let mut here = self.arrow(effects);
        for _ in 0..MAX_STEPS {
            let step = here.solve(&here.descent(effects));
            let longest = step.modes.iter().fold(step.participant.abs(), |m, s| m.max(s.abs()));
            // Where the SD is some logits, whole steps may jump from side to side for ever.
            let mut share = 1.0;
            loop {
                let modes = effects.modes.iter().zip(&step.modes);
                let trial = Effects {
                    participant: effects.participant + share * step.participant,
                    modes: modes.map(|(v, s)| v + share * s).collect(),
                };
                let ahead = self.arrow(&trial);
                if longest < TRUSTED || ahead.height < here.height || share < f64::EPSILON {
                    (*effects, here) = (trial, ahead);
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

    /// The gradient of −h − ½ ln|H| at the minimum of h.
    fn gradient(&self, effects: &Effects, arrow: &Arrow) -> Point {
        let [su, sw] = self.point.sd;
        let half_variances = arrow.half_variances();
        let adjoint = arrow.solve(&self.pull(effects, &half_variances));
        let mut sum = Point::zero(self.point.theta.len(), self.point.beta.len());
        for (mode, group) in self.cells.groups.iter().enumerate() {
            // By how much η of this mode follows, through v̂.
            let follow = su * adjoint.participant + sw * adjoint.modes[mode];
            let mut by_eta = 0.0;
            for cell in group.clone() {
                let eta = self.eta(cell, mode, effects);
                by_eta += self.add_cell(&mut sum, cell, eta, half_variances[mode], follow);
            }
            // S/A, and where the SDs stand in h and in |H| themselves.
            let slope = arrow.slopes[mode].slope;
            let share = arrow.slopes[mode].bend / arrow.spokes[mode];
            sum.sd[0] +=
                by_eta * effects.participant + adjoint.participant * slope - su * share / arrow.hub;
            sum.sd[1] += by_eta * effects.modes[mode] + adjoint.modes[mode] * slope
                - sw * share * (1.0 - su * su * share / arrow.hub);
        }
        sum
    }

    /// −½ ∂ ln|H| / ∂v.
    fn pull(&self, effects: &Effects, half_variances: &[f64]) -> Effects {
        let [su, sw] = self.point.sd;
        let mut pulls = Vec::with_capacity(half_variances.len());
        for (mode, half_variance) in half_variances.iter().enumerate() {
            let cells = self.cells.groups[mode].clone();
            let twist: f64 = cells.map(|c| self.twist(c, self.eta(c, mode, effects))).sum();
            pulls.push(half_variance * twist);
        }
        Effects {
            participant: su * pulls.iter().sum::<f64>(),
            modes: pulls.iter().map(|pull| sw * pull).collect(),
        }
    }

    /// −dS/dη = Σ Nⱼ F'' of one cell.
    fn twist(&self, cell: usize, eta: f64) -> f64 {
        let counts = self.cells.beside[cell].iter();
        counts.zip(self.levels.shares(eta)).map(|(n, f)| n * f * (1.0 - f) * (1.0 - 2.0 * f)).sum()
    }

    /// Adds what a cell gives by θ and β; returns what it gives by η.
    fn add_cell(
        &self,
        sum: &mut Point,
        cell: usize,
        eta: f64,
        half_variance: f64,
        follow: f64,
    ) -> f64 {
        let mut by_eta = 0.0;
        let counts = self.cells.below[cell].iter().zip(&self.cells.beside[cell]);
        for (((below, beside), share), by) in
            counts.zip(self.levels.shares(eta)).zip(&mut sum.theta)
        {
            let bend = beside * share * (1.0 - share);
            let determinant = half_variance * bend * (1.0 - 2.0 * share);
            let along = below - beside * share - determinant + follow * bend;
            *by += along;
            by_eta -= along;
        }
        sum.beta.iter_mut().zip(&self.cells.x[cell]).for_each(|(by, x)| *by += by_eta * x);
        by_eta
    }
}
