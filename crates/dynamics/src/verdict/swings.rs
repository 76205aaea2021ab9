//! Swings of a run: from one end of a motion to the next.

use std::cmp::Ordering;
use zwidth_numerics::order::{sorted, upper_median};

use crate::system::region::Motion;
use crate::system::transition::EventKind;
use crate::system::{OMEGA, THETA};
use crate::trajectory::Trajectory;

/// Fewer swings are an impact, or a movement there and back, and no oscillation: three cycles.
pub const FEW: usize = 6;

/// Where the reference oscillates, what takes up less than this share of the run does not name it.
pub(super) const SEEN: f64 = 0.05;

/// The way of the lever from one end of a motion to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Swing {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    /// Half of the peak-to-peak angle, rad.
    pub(super) amplitude_rad: f64,
}

impl Swing {
    pub(super) fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }

    /// Whether it is at least so large and at most so long.
    fn is_within(&self, amplitude_rad: f64, duration_s: f64) -> bool {
        self.amplitude_rad >= amplitude_rad && self.duration_s() <= duration_s
    }
}

/// The oscillation of a run in numbers: its existing swings; all 0 for fewer than six.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Swings {
    /// How many.
    pub count: usize,
    /// Median of half their peak-to-peak angle, rad; 0 without any.
    pub amplitude_rad: f64,
    /// 1 / (2 · their mean duration), Hz; 0 without any.
    pub frequency_hz: f64,
}

impl Swings {
    pub(super) fn of(swings: &[Swing]) -> Self {
        let median = upper_median(swings.iter().map(|swing| swing.amplitude_rad));
        let Some(amplitude_rad) = median.filter(|_| swings.len() >= FEW) else {
            return Self::default();
        };
        let whole_s: f64 = swings.iter().map(Swing::duration_s).sum();
        let frequency_hz = if whole_s > 0.0 { swings.len() as f64 / (2.0 * whole_s) } else { 0.0 };
        Self { count: swings.len(), amplitude_rad, frequency_hz }
    }
}

/// The swings of a run that exist: half of their peak-to-peak angle is above the bound.
pub(super) fn existing(run: &Trajectory, bound_rad: f64) -> Vec<Swing> {
    let turns = if run.events.is_empty() { sampled_turns(run) } else { event_turns(run) };
    between(&turns, bound_rad)
}

/// The same by the samples alone.
pub(super) fn sampled(run: &Trajectory, bound_rad: f64) -> Vec<Swing> {
    between(&sampled_turns(run), bound_rad)
}

/// Swings of a run, each from where the lever leaves the angle at which it turned: how long it rests
/// there is no part of it, nor whether a velocity of 0 is one of 1e-20.
pub(super) fn without_rests(run: &Trajectory, swings: &[Swing]) -> Vec<Swing> {
    /// What it moves before that, as a share of the swing.
    const LEFT: f64 = 0.02;
    let theta = |i: usize| run.states[i * run.layout.n + THETA];
    let moving = |swing: &Swing| {
        let [from, to] = [swing.from_s, swing.to_s].map(|s| run.t_s.partition_point(|t| *t < s));
        let near_rad = LEFT * 2.0 * swing.amplitude_rad;
        let left = (from..to).rev().find(|i| (theta(*i) - theta(from)).abs() <= near_rad);
        Swing { from_s: run.t_s[left.unwrap_or(from)], ..*swing }
    };
    swings.iter().map(moving).collect()
}

/// The swings from one turn to the next that are above the bound.
fn between(turns: &[(f64, f64)], bound_rad: f64) -> Vec<Swing> {
    turns
        .windows(2)
        .map(|pair| Swing {
            from_s: pair[0].0,
            to_s: pair[1].0,
            amplitude_rad: 0.5 * (pair[1].1 - pair[0].1).abs(),
        })
        .filter(|swing| swing.amplitude_rad > bound_rad)
        .collect()
}

/// Time and angle at the events that end a motion: a reversal, a stop, coming to rest on an edge.
fn event_turns(run: &Trajectory) -> Vec<(f64, f64)> {
    let ends = run.events.iter().filter(|event| match event.kind {
        EventKind::Reversal | EventKind::Stop => true,
        EventKind::Zone => event.region.motion == Motion::Rest,
        _ => false,
    });
    ends.map(|event| (event.t_s, event.theta_rad)).collect()
}

/// Time and angle of the samples at which a motion has ended: the velocity changed its sign or
/// became zero.
fn sampled_turns(run: &Trajectory) -> Vec<(f64, f64)> {
    // As if at rest before the first sample: where a run begins to move is no turn.
    let mut last = Some(Ordering::Equal);
    let mut turns = Vec::new();
    for (t, z) in run.t_s.iter().zip(run.states.chunks_exact(run.layout.n)) {
        let now = z[OMEGA].partial_cmp(&0.0);
        if last != Some(Ordering::Equal) && now != last {
            turns.push((*t, z[THETA]));
        }
        last = now;
    }
    turns
}

/// Whether a run swings in a way that the reference does not: at some size and speed it has several
/// times as many swings. A method may get the size and the speed of a swing wrong and still show
/// the reference's. Where the reference oscillates too, swings that take up less than a twentieth
/// of the run do not name it: a hesitation before the first slip.
pub(super) fn has_its_own(run: &[Swing], reference: &[Swing], duration_s: f64) -> bool {
    /// The reference's swings count down to this share of a size, and up to so many times a
    /// duration.
    const SIZE: f64 = 0.1;
    const SLOWER: f64 = 2.0;
    /// The run has its own if they are more than so many times the reference's.
    const TIMES: usize = 3;
    let least_s = if reference.len() < FEW { 0.0 } else { SEEN * duration_s };
    let largest = reference.iter().map(|swing| swing.amplitude_rad).fold(0.0, f64::max);
    let sizes = tenths(&sorted(run.iter().map(|swing| swing.amplitude_rad)));
    let durations = tenths(&sorted(run.iter().map(Swing::duration_s)));
    sizes.iter().any(|&size| {
        durations.iter().any(|&duration| {
            let own: Vec<&Swing> = run.iter().filter(|s| s.is_within(size, duration)).collect();
            let small = SIZE * size.min(largest);
            let slow = SLOWER * duration;
            let alike = reference.iter().filter(|s| s.is_within(small, slow)).count();
            own.len() >= FEW + TIMES * alike
                && own.iter().map(|swing| swing.duration_s()).sum::<f64>() >= least_s
        })
    })
}

/// Every tenth part of a sorted list, from the first to the last.
fn tenths(sorted: &[f64]) -> Vec<f64> {
    let Some(last) = sorted.len().checked_sub(1) else { return Vec::new() };
    (0..=10).map(|i| sorted[i * last / 10]).collect()
}
