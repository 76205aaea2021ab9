//! Compression and decompression as two single-valued curves on a common grid of angles.

use std::ops::RangeInclusive;
use zwidth_numerics::phases::Phases;

/// The two branches, and evenly spaced angles that both of them reach.
pub(crate) struct Branches<'a> {
    theta: &'a [f64],
    pub(crate) grid: Vec<f64>,
    /// The samples of each, in the order of growing angles.
    forward: Vec<u32>,
    backward: Vec<u32>,
}

/// The samples at which the lever is farther along than ever before on its way: they make any
/// quantity a function of θ. A lever that jitters or turns back for a moment adds nothing until it
/// is past its farthest point again. Where the way begins at an angle that is another's (`left`),
/// so does a lever that still stands there: its force is that of what holds it, not yet that of the
/// way.
fn advancing(
    theta: &[f64],
    samples: RangeInclusive<usize>,
    left: Option<f64>,
    direction: f64,
) -> Vec<u32> {
    let mut branch = Vec::new();
    let mut farthest = left;
    for i in samples {
        if farthest.is_none_or(|farthest| direction * theta[i] > direction * farthest) {
            // a recording has fewer samples than that: the store has checked
            branch.push(i as u32);
            farthest = Some(theta[i]);
        }
    }
    if direction < 0.0 {
        branch.reverse();
    }
    branch
}

/// The branches are compared where they share at least this share of the compression's angles: a
/// lever that a brake holds moves back by the angle sensor's jitter and has no decompression.
const LEAST_SHARE: f64 = 0.1;

impl<'a> Branches<'a> {
    /// Both branches, and `points` angles over the range that both cover; `None` where that is less
    /// than a tenth of the compression's. The angle of the reversal belongs to the compression
    /// alone: a lever that a brake holds there has the force of neither way until it has left.
    pub(crate) fn of(theta: &'a [f64], phases: Phases, points: usize) -> Option<Self> {
        let Phases { onset, reversal, end } = phases;
        let forward = advancing(theta, onset..=reversal, None, 1.0);
        let backward = advancing(theta, reversal + 1..=end, Some(theta[reversal]), -1.0);
        let [ahead, back] = [&forward, &backward]
            .map(|branch| Some((at(theta, *branch.first()?), at(theta, *branch.last()?))));
        let (ahead, back) = (ahead?, back?);
        let low = ahead.0.max(back.0);
        let high = ahead.1.min(back.1);
        if high <= low || high - low < LEAST_SHARE * (ahead.1 - ahead.0) || points < 2 {
            return None;
        }
        let grid = (0..points).map(|i| {
            // Both ends exactly: rounding must not take a point past what both branches cover.
            if i + 1 == points {
                return high;
            }
            (low + (high - low) * (i as f64 / (points - 1) as f64)).min(high)
        });
        let grid = grid.collect();
        Some(Self { theta, grid, forward, backward })
    }

    /// What each branch has of `y`, quantities of each sample, on the grid: by linear interpolation, so
    /// that `y` is called for the samples beside an angle of the grid alone, in their order and
    /// seldom twice.
    pub(crate) fn on_grid<const N: usize>(
        &self,
        mut y: impl FnMut(usize) -> [f64; N],
    ) -> [Vec<[f64; N]>; 2] {
        [&self.forward, &self.backward].map(|branch| {
            let theta = |k: usize| at(self.theta, branch[k]);
            // The first sample that is not before the angle, what is there, and what is before it.
            let mut k = 0;
            let mut here = y(branch[0] as usize);
            let mut before = None;
            let mut values = Vec::with_capacity(self.grid.len());
            for angle in &self.grid {
                let from = k;
                while k + 1 < branch.len() && theta(k) < *angle {
                    k += 1;
                }
                if k > from {
                    let is_next = k == from + 1;
                    before = Some(if is_next { here } else { y(branch[k - 1] as usize) });
                    here = y(branch[k] as usize);
                }
                values.push(match before {
                    // A sample's own angle: arithmetic would blur its value.
                    Some(before) if theta(k) > *angle => {
                        let share = (angle - theta(k - 1)) / (theta(k) - theta(k - 1));
                        std::array::from_fn(|j| before[j] + share * (here[j] - before[j]))
                    }
                    _ => here,
                });
            }
            values
        })
    }

    /// By how much each of the quantities `y` of the compression exceeds that of the decompression, on
    /// the grid.
    pub(crate) fn gaps<const N: usize>(&self, y: impl FnMut(usize) -> [f64; N]) -> [Vec<f64>; N] {
        let [forward, backward] = self.on_grid(y);
        std::array::from_fn(|j| forward.iter().zip(&backward).map(|(f, b)| f[j] - b[j]).collect())
    }
}

fn at(theta: &[f64], place: u32) -> f64 {
    theta[place as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_and_turning_back_add_nothing_to_a_branch() {
        let theta = [0.0, 1.0, 0.5, 0.8, 1.0, 2.0, 1.5, 1.6, 0.0];
        let force = [0.0, 1.0, 9.0, 9.0, 9.0, 2.0, 1.0, 9.0, -1.0];
        let phases = Phases { onset: 0, reversal: 5, end: 8 };
        let found = Branches::of(&theta, phases, 4).unwrap();
        assert_eq!(found.grid, [0.0, 0.5, 1.0, 1.5]);
        let [forward, backward] = found.on_grid(|i| [force[i]]).map(|branch| branch.concat());
        assert_eq!(forward, [0.0, 0.5, 1.0, 1.5]);
        let expect = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0];
        assert!(backward.iter().zip(expect).all(|(f, e)| (f - e).abs() < 1e-15));
    }

    /// Held at its reversal with 5 N, which it leaves at 2 N: the way back has 2 N up to its first
    /// angle.
    #[test]
    fn what_holds_a_lever_at_its_reversal_is_not_the_force_of_the_way_back() {
        let theta = [0.0, 1.0, 2.0, 2.0, 2.0, 1.9, 1.0, 0.0];
        let force = [1.0, 3.0, 5.0, 5.0, 4.0, 2.0, 2.0, 2.0];
        let phases = Phases { onset: 0, reversal: 2, end: 7 };
        let found = Branches::of(&theta, phases, 20).unwrap();
        assert_eq!(found.grid.last(), Some(&1.9));
        let [_, backward] = found.on_grid(|i| [force[i]]).map(|branch| branch.concat());
        assert!(backward.iter().all(|force| (force - 2.0).abs() < 1e-12), "{backward:?}");
    }

    #[test]
    fn a_lever_that_is_held_and_jitters_has_no_decompression() {
        let theta = [0.0, 1.0, 2.0, 1.95, 1.9, 1.95];
        let phases = Phases { onset: 0, reversal: 2, end: 5 };
        assert!(Branches::of(&theta, phases, 11).is_none());
    }

    #[test]
    fn a_movement_without_a_way_back_has_no_common_range() {
        let phases = Phases { onset: 0, reversal: 2, end: 2 };
        assert!(Branches::of(&[0.0, 1.0, 2.0], phases, 11).is_none());
    }
}
