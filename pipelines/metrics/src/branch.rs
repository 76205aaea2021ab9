//! Compression and decompression as two single-valued curves F(θ) on a common grid.

use std::ops::RangeInclusive;
use zwidth_numerics::phases::Phases;
use zwidth_numerics::series::interpolate_all;

/// F over strictly increasing θ.
pub(crate) struct Branch {
    theta: Vec<f64>,
    force: Vec<f64>,
}

/// The two branches on a grid of evenly spaced angles that both of them reach.
pub(crate) struct Branches {
    pub(crate) theta: Vec<f64>,
    pub(crate) forward: Vec<f64>,
    pub(crate) backward: Vec<f64>,
}

/// The samples at which the lever is farther along than ever before on its way: they make F a
/// function of θ. A lever that jitters or turns back for a moment adds nothing until it is past its
/// farthest point again. Where the way begins at an angle that is another's (`left`), so does a
/// lever that still stands there: its force is that of what holds it, not yet that of the way.
fn advancing(
    theta: &[f64],
    force: impl Fn(usize) -> f64,
    samples: RangeInclusive<usize>,
    left: Option<f64>,
    direction: f64,
) -> Branch {
    let mut branch = Branch { theta: Vec::new(), force: Vec::new() };
    let mut farthest = left;
    for i in samples {
        if farthest.is_none_or(|farthest| direction * theta[i] > direction * farthest) {
            branch.theta.push(theta[i]);
            branch.force.push(force(i));
            farthest = Some(theta[i]);
        }
    }
    if direction < 0.0 {
        branch.theta.reverse();
        branch.force.reverse();
    }
    branch
}

/// The branches are compared where they share at least this share of the compression's angles: a
/// lever that a brake holds moves back by the angle sensor's jitter and has no decompression.
const LEAST_SHARE: f64 = 0.1;

/// Both branches, `force` that of each sample, by linear interpolation on `points` angles over the range that both cover; `None`
/// where that is less than a tenth of the compression's. The angle of the reversal belongs to the
/// compression alone: a lever that a brake holds there has the force of neither way until it has
/// left.
pub(crate) fn branches(
    theta: &[f64],
    force: impl Fn(usize) -> f64,
    phases: Phases,
    points: usize,
) -> Option<Branches> {
    let Phases { onset, reversal, end } = phases;
    let forward = advancing(theta, &force, onset..=reversal, None, 1.0);
    let backward = advancing(theta, &force, reversal + 1..=end, Some(theta[reversal]), -1.0);
    let low = forward.theta.first()?.max(*backward.theta.first()?);
    let high = forward.theta.last()?.min(*backward.theta.last()?);
    let least = LEAST_SHARE * (forward.theta.last()? - forward.theta.first()?);
    if high <= low || high - low < least || points < 2 {
        return None;
    }
    let grid: Vec<f64> = (0..points).map(|i| grid_point(low, high, i, points)).collect();
    let on_grid = |b: &Branch| -> Option<Vec<f64>> {
        interpolate_all(&b.theta, &b.force, &grid).into_iter().collect()
    };
    Some(Branches { forward: on_grid(&forward)?, backward: on_grid(&backward)?, theta: grid })
}

/// Point `i` of an even grid that begins with `low` and ends with `high`, both exactly.
fn grid_point(low: f64, high: f64, i: usize, points: usize) -> f64 {
    if i + 1 == points {
        return high;
    }
    (low + (high - low) * (i as f64 / (points - 1) as f64)).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_and_turning_back_add_nothing_to_a_branch() {
        let theta = [0.0, 1.0, 0.5, 0.8, 1.0, 2.0, 1.5, 1.6, 0.0];
        let force = [0.0, 1.0, 9.0, 9.0, 9.0, 2.0, 1.0, 9.0, -1.0];
        let phases = Phases { onset: 0, reversal: 5, end: 8 };
        let found = branches(&theta, |i| force[i], phases, 4).unwrap();
        assert_eq!(found.theta, [0.0, 0.5, 1.0, 1.5]);
        assert_eq!(found.forward, [0.0, 0.5, 1.0, 1.5]);
        let expect = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0];
        assert!(found.backward.iter().zip(expect).all(|(f, e)| (f - e).abs() < 1e-15));
    }

    /// Held at its reversal with 5 N, which it leaves at 2 N: the way back has 2 N up to its first
    /// angle.
    #[test]
    fn what_holds_a_lever_at_its_reversal_is_not_the_force_of_the_way_back() {
        let theta = [0.0, 1.0, 2.0, 2.0, 2.0, 1.9, 1.0, 0.0];
        let force = [1.0, 3.0, 5.0, 5.0, 4.0, 2.0, 2.0, 2.0];
        let phases = Phases { onset: 0, reversal: 2, end: 7 };
        let found = branches(&theta, |i| force[i], phases, 20).unwrap();
        assert_eq!(found.theta.last(), Some(&1.9));
        assert!(
            found.backward.iter().all(|force| (force - 2.0).abs() < 1e-12),
            "{:?}",
            found.backward
        );
    }

    #[test]
    fn a_lever_that_is_held_and_jitters_has_no_decompression() {
        let theta = [0.0, 1.0, 2.0, 1.95, 1.9, 1.95];
        let phases = Phases { onset: 0, reversal: 2, end: 5 };
        let force = [5.0, 5.0, 5.0, 4.0, 2.0, 0.0];
        assert!(branches(&theta, |i| force[i], phases, 11).is_none());
    }

    #[test]
    fn a_movement_without_a_way_back_has_no_common_range() {
        let phases = Phases { onset: 0, reversal: 2, end: 2 };
        assert!(branches(&[0.0, 1.0, 2.0], |_| 0.0, phases, 11).is_none());
    }
}
