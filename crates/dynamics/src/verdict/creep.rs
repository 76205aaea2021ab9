//! Creep of a method: the lever moves on while the model's lever stands still.

use super::path::Path;
use super::reference::KnownMotion;
use super::swings::{FEW, SEEN};

/// A stretch of fewer steps of the method is not looked at: that late a motion may end.
const FEWEST_STEPS: f64 = 16.0;
/// The middle of a stretch, as shares of it. A motion may end late and begin early.
const MIDDLE: [f64; 2] = [0.25, 0.75];
/// Parts of that middle. A run that creeps moves in each of them.
const PARTS: usize = 4;

/// The longest way of a run's lever, largest less smallest θ, within a stretch in which the
/// reference's stands still, rad; 0 if the run does not creep. Of a reference that oscillates only
/// long stretches count: in a short one a run that sticks and slips at other times may be slipping.
pub(super) fn creep_rad(run: &Path, reference: &KnownMotion, step_s: f64) -> f64 {
    let oscillates = reference.swings.len() >= FEW;
    let seen_s = if oscillates { SEEN * reference.path.end_s() } else { 0.0 };
    let shortest_s = seen_s.max(FEWEST_STEPS * step_s);
    let stretches = reference.path.stands_s().into_iter();
    let long = stretches.filter(|[from_s, to_s]| to_s - from_s >= shortest_s);
    long.filter(|[from_s, to_s]| {
        let edges = (0..=PARTS).map(|k| {
            let share = MIDDLE[0] + (MIDDLE[1] - MIDDLE[0]) * k as f64 / PARTS as f64;
            from_s + share * (to_s - from_s)
        });
        run.along(edges).windows(2).all(|pair| (pair[1] - pair[0]).abs() > reference.bound_rad)
    })
    .map(|[from_s, to_s]| run.way_rad(from_s, to_s))
    .fold(0.0, f64::max)
}
