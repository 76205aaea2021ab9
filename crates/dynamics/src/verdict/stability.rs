//! Whether a step lies inside a method's stability region, along a run.

use zwidth_numerics::expm::{Ladder, spectral_radius};

use crate::scene::terms::Curve;
use crate::solve::Solver;
use crate::system::linear::LinearPart;
use crate::system::region::Motion;
use crate::system::row::MOST;
use crate::system::{OMEGA, System, THETA};
use crate::trajectory::Trajectory;

/// A spectral radius up to this is 1: rounding of the estimate.
const ONE: f64 = 1.0 + 1e-6;

/// Growth of a linear system over one step: spectral radii of the method's map and of the exact
/// flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Growth {
    method: f64,
    exact: f64,
}

impl Growth {
    /// `None` for methods without a limit.
    pub(crate) fn of(solver: &dyn Solver, a: &LinearPart, h: f64) -> Option<Self> {
        let method = spectral_radius(&solver.amplification(a, h)?);
        Some(Self { method, exact: spectral_radius(&Ladder::<MOST>::new(a.a, h).flow(h)) })
    }

    /// The method's growth beyond that of the exact flow.
    pub(crate) fn excess(self) -> f64 {
        self.method / self.exact.max(1.0)
    }

    /// The method grows where the flow does not; where the flow itself grows, at twice its rate.
    pub(super) fn is_unstable(self) -> bool {
        self.method > ONE && (self.exact <= ONE || self.method > self.exact * self.exact)
    }
}

/// The worst growth in the regions in which a run moved, its curved terms linearised along it.
pub(super) fn worst(
    solver: &dyn Solver,
    system: &System,
    run: &Trajectory,
    h: f64,
) -> Option<Growth> {
    let moving = run.regions.iter().filter(|region| region.motion != Motion::Rest);
    let slopes = slopes(system, run);
    let parts = moving.flat_map(|region| {
        let part = system.linear_part(region);
        let factors = system.curved(region);
        slopes.iter().map(move |slope| {
            let mut part = part;
            for (i, factor) in factors.iter().enumerate() {
                part.a.columns[THETA][i] += factor * slope.per_rad_n;
                part.a.columns[OMEGA][i] += factor * slope.per_rad_s_n;
            }
            part
        })
    });
    let growths: Vec<Growth> = parts.filter_map(|part| Growth::of(solver, &part, h)).collect();
    // An unstable step is worse than any excess: where the flow itself grows, a large one may be
    // right.
    growths.into_iter().reduce(|a, b| match (a.is_unstable(), b.is_unstable()) {
        (true, false) => a,
        (false, true) => b,
        _ if a.excess() >= b.excess() => a,
        _ => b,
    })
}

/// Slopes of the curved terms along a run: evenly from the least to the greatest; one that is zero
/// without curved terms.
fn slopes(system: &System, run: &Trajectory) -> Vec<Curve> {
    /// Between them a method's limit is not jumped over.
    const STEPS: usize = 8;
    let states = run.states.chunks_exact(run.layout.n);
    let along: Vec<Curve> = states.filter_map(|z| system.curve(z)).collect();
    if along.is_empty() {
        return vec![Curve::default()];
    }
    let slopes: [fn(&Curve) -> f64; 2] = [|c| c.per_rad_n, |c| c.per_rad_s_n];
    let [[k0, k1], [b0, b1]] = slopes.map(|slope| {
        let values = along.iter().map(slope);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    });
    let grid = (0..=STEPS).flat_map(|i| {
        let share = i as f64 / STEPS as f64;
        [0.0, 1.0].map(|other| Curve {
            force_n: 0.0,
            per_rad_n: k0 + share * (k1 - k0),
            per_rad_s_n: b0 + other * (b1 - b0),
        })
    });
    grid.collect()
}
