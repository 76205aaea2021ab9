//! Boundaries with intervals, and the region below them.

use super::search::{Ending, Found, Probe};
use zwidth_dynamics::DriveMode;
use zwidth_results::WallBound;

/// What a mode renders after a push.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Which actuators render.
    pub mode: DriveMode,
    /// The push, m.
    pub push_m: f64,
    /// The boundary, damping rising. A bound's stiffness is the middle of its interval; if it is
    /// censored, the value that was reached.
    pub bounds: Vec<WallBound>,
}

impl Region {
    /// K_max(0), N/m.
    pub fn undamped(&self) -> Option<&WallBound> {
        self.bounds.first().filter(|bound| bound.damping_ns_per_m <= 0.0)
    }

    /// The damping with the stiffest wall.
    pub fn stiffest(&self) -> Option<&WallBound> {
        self.bounds.iter().max_by(|a, b| a.stiffness_n_per_m.total_cmp(&b.stiffness_n_per_m))
    }

    /// Whether any bound is censored: the area is then at least what it is.
    pub fn is_censored(&self) -> bool {
        self.bounds.iter().any(|bound| bound.is_censored)
    }

    /// ∫ K_max dB over the dampings, by trapezia, with the ends of its interval, N² s/m².
    pub fn area(&self) -> [f64; 3] {
        let stiffnesses: [fn(&WallBound) -> f64; 3] =
            [|bound| bound.stiffness_n_per_m, |bound| bound.ci_low, |bound| bound.ci_high];
        stiffnesses.map(|stiffness| {
            let parts = self.bounds.windows(2).map(|pair| {
                let width = pair[1].damping_ns_per_m - pair[0].damping_ns_per_m;
                0.5 * width * (stiffness(&pair[0]) + stiffness(&pair[1]))
            });
            parts.sum()
        })
    }

    /// B_end, N s/m.
    pub fn end_ns_per_m(&self) -> f64 {
        self.bounds.last().map_or(0.0, |bound| bound.damping_ns_per_m)
    }
}

/// Joins searches to regions, in the order of the first of each.
pub fn regions(searches: &[(Probe, Found)]) -> Vec<Region> {
    let mut regions: Vec<Region> = Vec::new();
    for (Probe { mode, push_m, .. }, _) in searches {
        if regions.iter().any(|region| region.mode == *mode && same(region.push_m, *push_m)) {
            continue;
        }
        let own = searches
            .iter()
            .filter(|(probe, _)| probe.mode == *mode && same(probe.push_m, *push_m))
            .map(|(probe, search)| (probe.damping_ns_per_m, search));
        let mut own: Vec<(f64, &Found)> = own.collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        let dampings = own.chunk_by(|a, b| same(a.0, b.0));
        let bounds = dampings.map(|repeats| bound(*mode, *push_m, repeats)).collect();
        regions.push(Region { mode: *mode, push_m: *push_m, bounds });
    }
    regions
}

/// Whether two numbers are one: they are copies of what the test lists, not results.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

/// The stiffest wall of one damping: from the stiffest one that came to rest in every repeat to the
/// softest that swung in every one.
fn bound(mode: DriveMode, push_m: f64, repeats: &[(f64, &Found)]) -> WallBound {
    let brackets: Vec<(f64, Option<f64>)> =
        repeats.iter().map(|(_, search)| search.bracket()).collect();
    let is_censored = repeats.iter().any(|(_, search)| search.ending != Ending::Boundary);
    let ci_low = brackets.iter().map(|b| b.0).fold(f64::INFINITY, f64::min);
    let ci_high = brackets.iter().map(|b| b.1.unwrap_or(b.0)).fold(0.0, f64::max);
    WallBound {
        mode: mode.as_str().into(),
        push_m,
        damping_ns_per_m: repeats[0].0,
        // A wall that saturated without swinging bounds from below alone: there is no middle.
        stiffness_n_per_m: if is_censored { ci_low } else { 0.5 * (ci_low + ci_high) },
        ci_low,
        ci_high,
        is_censored,
        repeats: repeats.len(),
    }
}
