//! Creep: the lever moves on steadily where the right motion's is held.

use crate::sides::Sides;

/// A stretch of fewer samples is not looked at: that late a motion may end.
const FEWEST: usize = 16;
/// The middle of a stretch, as shares of it: a motion may end late and begin early.
const MIDDLE: [f64; 2] = [0.25, 0.75];
/// Parts of that middle. A lever that creeps moves in each of them, the same way, and in the slowest
/// by at least this share of the fastest: what dies out does not creep.
const PARTS: usize = 4;
const STEADY: f64 = 0.5;
/// Nor is it further from a straight line than this share of its way: what swings does not creep.
const STRAIGHT: f64 = 0.25;

/// A stretch in which the right lever is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    /// When it begins, s.
    pub(crate) from_s: f64,
    /// Its steady speed in the trajectory, rad/s; 0 where it moves unsteadily, or by less than the
    /// file's angles can show.
    pub(crate) creep_rad_s: f64,
}

/// The stretches in which the right lever is held, as far as they are long enough.
pub(crate) fn held(sides: &Sides<'_>) -> Vec<Held> {
    let samples: Vec<usize> = (0..sides.len()).collect();
    let stretches = samples.chunk_by(|a, b| sides.is_held(*a) && sides.is_held(*b));
    let long = stretches.filter(|stretch| stretch.len() >= FEWEST);
    long.map(|stretch| {
        let [from, to] = [stretch[0], stretch[stretch.len() - 1]];
        Held { from_s: sides.t_s[from], creep_rad_s: creep_rad_s(sides, from, to) }
    })
    .collect()
}

/// The steady speed between two samples: the slope of the line through the middle half.
fn creep_rad_s(sides: &Sides<'_>, from: usize, to: usize) -> f64 {
    let Sides { t_s, own, .. } = sides;
    let theta = &own.theta_rad;
    let place = |share: f64| {
        let time = t_s[from] + share * (t_s[to] - t_s[from]);
        from + t_s[from..=to].partition_point(|t| *t < time)
    };
    let edges: Vec<usize> = (0..=PARTS)
        .map(|k| place(MIDDLE[0] + (MIDDLE[1] - MIDDLE[0]) * k as f64 / PARTS as f64).min(to))
        .collect();
    let speeds = edges.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        if b > a { (theta[b] - theta[a]) / (t_s[b] - t_s[a]) } else { 0.0 }
    });
    let speeds: Vec<f64> = speeds.collect();
    let [slowest, fastest] = speeds.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], speed| {
        [low.min(speed.abs()), high.max(speed.abs())]
    });
    let one_way = speeds.windows(2).all(|pair| pair[0] * pair[1] > 0.0);
    let (first, last) = (edges[0], edges[PARTS]);
    let is_seen = (theta[last] - theta[first]).abs() > sides.unseen_rad();
    if !one_way || slowest < STEADY * fastest || !is_seen {
        return 0.0;
    }
    // From the first of them on: the differences keep the digits that a large time would take.
    let n = (last - first + 1) as f64;
    let [t_sum, theta_sum] = (first..=last)
        .fold([0.0, 0.0], |[t, x], i| [t + (t_s[i] - t_s[first]), x + (theta[i] - theta[first])]);
    let [t_mean, theta_mean] = [t_sum / n, theta_sum / n];
    let [products, squares] = (first..=last).fold([0.0, 0.0], |[products, squares], i| {
        let t = t_s[i] - t_s[first] - t_mean;
        [products + t * (theta[i] - theta[first] - theta_mean), squares + t * t]
    });
    let slope = products / squares;
    let off_rad = (first..=last)
        .map(|i| theta[i] - theta[first] - theta_mean - slope * (t_s[i] - t_s[first] - t_mean));
    let way_rad = (slope * (t_s[last] - t_s[first])).abs();
    let is_line = off_rad.fold(0.0, |most: f64, off| most.max(off.abs())) <= STRAIGHT * way_rad;
    if is_line { slope } else { 0.0 }
}
