//! Boundaries with intervals, and the region below them.

use super::search::{Ending, Found, Probe};
use zwidth_dynamics::DriveMode;

/// The stiffest wall of one damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// B, N s/m.
    pub damping_ns_per_m: f64,
    /// K, N/m: the middle of the interval; if it is censored, the value that was reached.
    pub stiffness_n_per_m: f64,
    /// The interval, N/m: from the stiffest wall that came to rest in every repeat to the softest
    /// that swung in every one.
    pub interval_n_per_m: [f64; 2],
    /// Whether an actuator saturated, or the guard stopped it, in any repeat: at least so stiff.
    pub is_censored: bool,
    /// Repeats.
    pub repeats: usize,
}

/// What a mode renders after a push.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Which actuators render.
    pub mode: DriveMode,
    /// The push, m.
    pub push_m: f64,
    /// The boundary, damping rising.
    pub bounds: Vec<Bound>,
}

impl Region {
    /// K_max(0), N/m.
    pub fn undamped(&self) -> Option<&Bound> {
        self.bounds.first().filter(|bound| bound.damping_ns_per_m <= 0.0)
    }

    /// The damping with the stiffest wall.
    pub fn stiffest(&self) -> Option<&Bound> {
        self.bounds.iter().max_by(|a, b| a.stiffness_n_per_m.total_cmp(&b.stiffness_n_per_m))
    }

    /// Whether any bound is censored: the area is then at least what it is.
    pub fn is_censored(&self) -> bool {
        self.bounds.iter().any(|bound| bound.is_censored)
    }

    /// ∫ K_max dB over the dampings, by trapezia, with the ends of its interval, N² s/m².
    pub fn area(&self) -> [f64; 3] {
        let stiffnesses: [fn(&Bound) -> f64; 3] = [
            |bound| bound.stiffness_n_per_m,
            |bound| bound.interval_n_per_m[0],
            |bound| bound.interval_n_per_m[1],
        ];
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

/// The searches at each damping of a region, N s/m.
type Dampings<'a> = Vec<(f64, Vec<&'a Found>)>;

/// Joins searches to regions, in the order of the first of each.
pub fn regions(searches: &[(Probe, Found)]) -> Vec<Region> {
    let mut regions: Vec<(Region, Dampings)> = Vec::new();
    for (probe, search) in searches {
        let existing = regions
            .iter()
            .position(|(region, _)| region.mode == probe.mode && same(region.push_m, probe.push_m));
        let at = existing.unwrap_or_else(|| {
            let region = Region { mode: probe.mode, push_m: probe.push_m, bounds: Vec::new() };
            regions.push((region, Vec::new()));
            regions.len() - 1
        });
        let dampings = &mut regions[at].1;
        match dampings.iter_mut().find(|(b, _)| same(*b, probe.damping_ns_per_m)) {
            Some((_, repeats)) => repeats.push(search),
            None => dampings.push((probe.damping_ns_per_m, vec![search])),
        }
    }
    let finished = regions.into_iter().map(|(mut region, mut dampings)| {
        dampings.sort_by(|a, b| a.0.total_cmp(&b.0));
        region.bounds = dampings.iter().map(|(b, repeats)| bound(*b, repeats)).collect();
        region
    });
    finished.collect()
}

/// Whether two numbers are one: they are copies of what the test lists, not results.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

fn bound(damping_ns_per_m: f64, repeats: &[&Found]) -> Bound {
    let brackets: Vec<(f64, Option<f64>)> = repeats.iter().map(|search| search.bracket()).collect();
    let is_censored = repeats.iter().any(|search| search.ending != Ending::Boundary);
    let low = brackets.iter().map(|b| b.0).fold(f64::INFINITY, f64::min);
    let high = brackets.iter().map(|b| b.1.unwrap_or(b.0)).fold(0.0, f64::max);
    // A wall that saturated without swinging bounds from below alone: there is no middle.
    let middle = if is_censored { low } else { 0.5 * (low + high) };
    Bound {
        damping_ns_per_m,
        stiffness_n_per_m: middle,
        interval_n_per_m: [low, high],
        is_censored,
        repeats: repeats.len(),
    }
}
