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
        let stiffness = |bound: &&Bound| bound.stiffness_n_per_m;
        self.bounds.iter().max_by(|a, b| stiffness(a).total_cmp(&stiffness(b)))
    }

    /// Whether any bound is censored: the area is then at least what it is.
    pub fn is_censored(&self) -> bool {
        self.bounds.iter().any(|bound| bound.is_censored)
    }

    /// ∫ K_max dB over the dampings, by trapezia, with the ends of its interval, N² s/m².
    pub fn area(&self) -> [f64; 3] {
        let by = |get: fn(&Bound) -> f64| {
            let part = |pair: &[Bound]| {
                let width = pair[1].damping_ns_per_m - pair[0].damping_ns_per_m;
                0.5 * width * (get(&pair[0]) + get(&pair[1]))
            };
            self.bounds.windows(2).map(part).sum()
        };
        [
            by(|bound| bound.stiffness_n_per_m),
            by(|bound| bound.interval_n_per_m[0]),
            by(|bound| bound.interval_n_per_m[1]),
        ]
    }

    /// B_end, N s/m.
    pub fn end_ns_per_m(&self) -> f64 {
        self.bounds.last().map_or(0.0, |bound| bound.damping_ns_per_m)
    }
}

/// What was found at each damping of a region, N s/m.
type Dampings<'a> = Vec<(f64, Vec<&'a Found>)>;

/// Joins searches to regions, in the order of the first of each.
pub fn regions(searches: &[(Probe, Found)]) -> Vec<Region> {
    let mut regions: Vec<(Region, Dampings)> = Vec::new();
    for (probe, found) in searches {
        let is = |region: &Region| region.mode == probe.mode && same(region.push_m, probe.push_m);
        let at = regions.iter().position(|(region, _)| is(region)).unwrap_or_else(|| {
            let region = Region { mode: probe.mode, push_m: probe.push_m, bounds: Vec::new() };
            regions.push((region, Vec::new()));
            regions.len() - 1
        });
        let dampings = &mut regions[at].1;
        match dampings.iter_mut().find(|(b, _)| same(*b, probe.damping_ns_per_m)) {
            Some((_, all)) => all.push(found),
            None => dampings.push((probe.damping_ns_per_m, vec![found])),
        }
    }
    let finished = |(mut region, mut dampings): (Region, Dampings)| {
        dampings.sort_by(|a, b| a.0.total_cmp(&b.0));
        region.bounds = dampings.iter().map(|(b, all)| bound(*b, all)).collect();
        region
    };
    regions.into_iter().map(finished).collect()
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

fn bound(damping_ns_per_m: f64, all: &[&Found]) -> Bound {
    let brackets: Vec<(f64, Option<f64>)> = all.iter().map(|found| found.bracket()).collect();
    let is_censored = all.iter().any(|found| found.ending != Ending::Boundary);
    let low = brackets.iter().map(|b| b.0).fold(f64::INFINITY, f64::min);
    let high = brackets.iter().map(|b| b.1.unwrap_or(b.0)).fold(0.0, f64::max);
    let middle = if is_censored { low } else { 0.5 * (low + high) };
    Bound {
        damping_ns_per_m,
        stiffness_n_per_m: middle,
        interval_n_per_m: [low, high],
        is_censored,
        repeats: all.len(),
    }
}
