//! How the lever moves, and when that changes: of a trajectory and of the right motion, read in the
//! same way, and which changes belong together.

use crate::sides::{Side, Sides};
use zwidth_dynamics::EventKind;
use zwidth_results::LeverEvent;

/// A motion that covers less than this share of the right motion's range is no motion.
const TRAVEL_SHARE: f64 = 1e-3;
/// A rest of fewer samples is none.
const FEWEST_AT_REST: usize = 4;
/// A lever that moves goes on moving down to this share of the velocity at which it began to.
const GOES_ON: f64 = 0.5;
/// More pairs of changes are not compared: whoever changes so often chatters.
const MOST_PAIRS: usize = 4_000_000;

/// How a lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Forward,
    Backward,
    Rest,
    AtLowStop,
    AtHighStop,
}

impl Way {
    fn moves(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }
}

/// Samples of one way of moving, both included.
#[derive(Debug, Clone, Copy)]
struct Phase {
    way: Way,
    from: usize,
    to: usize,
}

/// A change of the way of moving.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    from: Way,
    to: Way,
    /// When, s.
    pub(crate) t_s: f64,
    /// The time between the samples between which it lies, s.
    pub(crate) between_s: f64,
    /// The first sample of the way before, and the last of that behind.
    pub(crate) around: [usize; 2],
}

impl Change {
    /// What it is.
    pub(crate) fn event(&self) -> LeverEvent {
        match (self.from, self.to) {
            (_, Way::AtLowStop | Way::AtHighStop) => LeverEvent::StopReached,
            (Way::AtLowStop | Way::AtHighStop, _) => LeverEvent::StopLeft,
            (_, Way::Rest) => LeverEvent::CameToRest,
            (Way::Rest, _) => LeverEvent::BrokeLoose,
            _ => LeverEvent::TurnedRound,
        }
    }
}

/// The changes of both, as far as they belong together.
#[derive(Debug, Default)]
pub(crate) struct Compared {
    /// Those of the right motion with those of the trajectory.
    pub(crate) both: Vec<(Change, Change)>,
    /// Those of the right motion alone.
    pub(crate) missed: Vec<Change>,
    /// Those of the trajectory alone.
    pub(crate) extra: Vec<Change>,
}

/// The changes of trajectory and right motion; `near_rad` from a stop a lever at rest leans on it.
/// None if there are too many.
pub(crate) fn compared(sides: &Sides<'_>, near_rad: f64) -> Option<Compared> {
    let [right, own] = [&sides.right, &sides.own].map(|side| changes(sides, side, near_rad));
    (right.len() * own.len() <= MOST_PAIRS)
        .then(|| pair(&right, &own, *sides.t_s.last().unwrap_or(&1.0)))
}

/// What the event is to which a change of the right motion belongs: an actuator that lets go frees
/// the lever, too.
pub(crate) fn cause(sides: &Sides<'_>, change: &Change) -> LeverEvent {
    let event = change.event();
    let lets_go = sides.right.run.events.iter().any(|e| {
        e.kind == EventKind::LetGo && (e.t_s - change.t_s).abs() <= 2.0 * change.between_s
    });
    if event == LeverEvent::BrokeLoose && lets_go { LeverEvent::ActuatorLetGo } else { event }
}

fn changes(sides: &Sides<'_>, side: &Side, near_rad: f64) -> Vec<Change> {
    let phases = phases(sides, side, near_rad);
    phases.windows(2).map(|pair| change(sides, side, pair[0], pair[1])).collect()
}

/// The ways of moving in their order. A rest of few samples is none, nor is a motion over a short
/// way: what was before goes on.
fn phases(sides: &Sides<'_>, side: &Side, near_rad: f64) -> Vec<Phase> {
    let ways = ways(sides, side, near_rad);
    let each = ways.into_iter().enumerate().map(|(i, way)| Phase { way, from: i, to: i });
    let all = joined(each);
    let long = all.into_iter().filter(|p| p.way.moves() || p.to - p.from + 1 >= FEWEST_AT_REST);
    let least_rad = sides.unseen_rad().max(TRAVEL_SHARE * sides.right.range_rad());
    let covers = |p: &Phase| (side.theta_rad[p.to] - side.theta_rad[p.from]).abs();
    let far = joined(long).into_iter().filter(|p| !p.way.moves() || covers(p) > least_rad);
    joined(far)
}

/// Phases of one way that follow each other are one. A lever at rest rests, whether it leans on a
/// stop or not.
fn joined(phases: impl Iterator<Item = Phase>) -> Vec<Phase> {
    let mut all: Vec<Phase> = Vec::new();
    for phase in phases {
        match all.last_mut() {
            Some(last) if last.way == phase.way || !(last.way.moves() || phase.way.moves()) => {
                last.to = phase.to;
            }
            _ => all.push(phase),
        }
    }
    all
}

/// The way of moving at each sample. A lever whose angle stays at a stop stands there, whatever its
/// velocity: a solver that lets it be pressed on has one that trembles.
fn ways(sides: &Sides<'_>, side: &Side, near_rad: f64) -> Vec<Way> {
    let mut before = Way::Rest;
    let samples = side.theta_rad.iter().zip(&side.theta_dot_rad_s).enumerate();
    samples
        .map(|(i, (theta, omega))| {
            let step_s = if i > 0 { sides.t_s[i] - sides.t_s[i - 1] } else { 0.0 };
            let has_moved = i == 0 || (theta - side.theta_rad[i - 1]).abs() > 0.0;
            let is_pressed = !has_moved && (omega * step_s).abs() > sides.unseen_rad();
            let goes_on = match before {
                Way::Forward => *omega > 0.0,
                Way::Backward => *omega < 0.0,
                _ => false,
            };
            let least = if goes_on { GOES_ON * sides.rest_rad_s } else { sides.rest_rad_s };
            before = match sides.stops_rad() {
                Some([low, _]) if is_pressed && theta - low <= near_rad => Way::AtLowStop,
                Some([_, high]) if is_pressed && high - theta <= near_rad => Way::AtHighStop,
                _ if *omega > least => Way::Forward,
                _ if *omega < -least => Way::Backward,
                Some([low, _]) if theta - low <= near_rad => Way::AtLowStop,
                Some([_, high]) if high - theta <= near_rad => Way::AtHighStop,
                _ => Way::Rest,
            };
            before
        })
        .collect()
}

/// When a way of moving becomes another one: where the velocity, continued from the samples of the
/// motion, passes the threshold of rest (or 0 between two motions), or the angle a stop.
fn change(sides: &Sides<'_>, side: &Side, a: Phase, b: Phase) -> Change {
    let t = &sides.t_s;
    let omega = &side.theta_dot_rad_s;
    let [i, j] = [a.to, b.from];
    let between_s = t[j] - t[i];
    let stop = match (b.way, sides.stops_rad()) {
        (Way::AtLowStop, Some([low, _])) => Some(low),
        (Way::AtHighStop, Some([_, high])) => Some(high),
        _ => None,
    };
    // A lever may still move in a stop that gives way.
    let earliest_s = if stop.is_some() { t[a.from] } else { t[i] };
    let found = match stop {
        Some(stop) if a.way.moves() => reaches(sides, side, a, stop),
        _ if a.way.moves() => {
            let level = if b.way.moves() { 0.0 } else { sides.rest_rad_s };
            let sign = if a.way == Way::Forward { 1.0 } else { -1.0 };
            let first = a.from.max(i.saturating_sub(2));
            passes(&t[first..=i], &omega[first..=i], sign * level, t[i])
        }
        _ => {
            let sign = if b.way == Way::Forward { 1.0 } else { -1.0 };
            let last = b.to.min(j + 2);
            passes(&t[j..=last], &omega[j..=last], sign * sides.rest_rad_s, t[j])
        }
    };
    let t_s = found.unwrap_or(0.5 * (t[i] + t[j])).clamp(earliest_s, t[j]);
    Change { from: a.way, to: b.way, t_s, between_s, around: [a.from, b.to] }
}

/// When the angle, continued from the last samples of a motion, reaches a stop, s.
fn reaches(sides: &Sides<'_>, side: &Side, motion: Phase, stop: f64) -> Option<f64> {
    /// Steps of Newton's method: the motion between two samples is nearly a parabola.
    const STEPS: usize = 6;
    let t = &sides.t_s;
    // The last sample before the stop: others may stand in it.
    let beyond =
        |k: usize| (side.theta_rad[k] - stop) * (side.theta_rad[motion.from] - stop) <= 0.0;
    let i = (motion.from..=motion.to).rev().find(|k| !beyond(*k))?;
    let h = motion.from.max(i.saturating_sub(2));
    let [c0, c1, c2] = parabola(&t[h..=i], &side.theta_dot_rad_s[h..=i], t[i])?;
    let missing = stop - side.theta_rad[i];
    let mut s = missing / c0;
    for _ in 0..STEPS {
        let way = s * (c0 + s * (c1 / 2.0 + s * c2 / 3.0));
        s -= (way - missing) / (c0 + s * (c1 + s * c2));
    }
    let last = *t.get(i + 1)?;
    s.is_finite().then(|| (t[i] + s).clamp(t[i], last))
}

/// When the parabola through up to three values passes a level, s: the time next to `from_s`.
fn passes(t_s: &[f64], x: &[f64], level: f64, from_s: f64) -> Option<f64> {
    let [c0, c1, c2] = parabola(t_s, x, from_s)?;
    let c0 = c0 - level;
    // The root that stays finite where the parabola is a line.
    let root = libm::sqrt(c1 * c1 - 4.0 * c2 * c0);
    let denominator = -c1 - if c1 >= 0.0 { root } else { -root };
    let near = 2.0 * c0 / denominator;
    near.is_finite().then_some(from_s + near)
}

/// c0 + c1 s + c2 s² through two or three values, with s from `from_s` on; none of fewer.
fn parabola(t_s: &[f64], x: &[f64], from_s: f64) -> Option<[f64; 3]> {
    match (t_s, x) {
        ([t0, t1], [x0, x1]) => {
            let slope = (x1 - x0) / (t1 - t0);
            Some([x0 + slope * (from_s - t0), slope, 0.0])
        }
        ([t0, t1, t2], [x0, x1, x2]) => {
            let [s0, s1, s2] = [t0 - from_s, t1 - from_s, t2 - from_s];
            // Newton's divided differences, expanded.
            let d01 = (x1 - x0) / (s1 - s0);
            let d12 = (x2 - x1) / (s2 - s1);
            let d = (d12 - d01) / (s2 - s0);
            Some([x0 - d01 * s0 + d * s0 * s1, d01 - d * (s0 + s1), d])
        }
        _ => None,
    }
}

/// Pairs changes of the same kind in their order, so that the fewest are left over, and of equally
/// many pairs those that lie next to each other.
fn pair(right: &[Change], own: &[Change], end_s: f64) -> Compared {
    /// The price of a change that is left over; the time between two that are paired costs its share
    /// of the whole.
    const LEFT_OVER: f64 = 0.5;
    let columns = own.len() + 1;
    let alike = |a: &Change, b: &Change| a.from == b.from && a.to == b.to;
    let price = |a: &Change, b: &Change| (a.t_s - b.t_s).abs() / end_s;
    let mut cost = vec![0.0; (right.len() + 1) * columns];
    for i in 0..=right.len() {
        for j in 0..=own.len() {
            let at = |i: usize, j: usize| i * columns + j;
            if i + j == 0 {
                continue;
            }
            let mut best = f64::INFINITY;
            if i > 0 {
                best = best.min(cost[at(i - 1, j)] + LEFT_OVER);
            }
            if j > 0 {
                best = best.min(cost[at(i, j - 1)] + LEFT_OVER);
            }
            if i > 0 && j > 0 && alike(&right[i - 1], &own[j - 1]) {
                best = best.min(cost[at(i - 1, j - 1)] + price(&right[i - 1], &own[j - 1]));
            }
            cost[at(i, j)] = best;
        }
    }
    let mut compared = Compared::default();
    let [mut i, mut j] = [right.len(), own.len()];
    while i + j > 0 {
        let here = cost[i * columns + j];
        let is = |other: f64| (other - here).abs() <= 1e-12 * (1.0 + here);
        if i > 0
            && j > 0
            && alike(&right[i - 1], &own[j - 1])
            && is(cost[(i - 1) * columns + j - 1] + price(&right[i - 1], &own[j - 1]))
        {
            compared.both.push((right[i - 1], own[j - 1]));
            i -= 1;
            j -= 1;
        } else if i > 0 && is(cost[(i - 1) * columns + j] + LEFT_OVER) {
            compared.missed.push(right[i - 1]);
            i -= 1;
        } else {
            compared.extra.push(own[j - 1]);
            j -= 1;
        }
    }
    compared.both.reverse();
    compared.missed.reverse();
    compared.extra.reverse();
    compared
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found_by_its_values_and_passes_where_it_should() {
        let x = |t: f64| 3.0 - 2.0 * (t - 1.0) - 4.0 * (t - 1.0) * (t - 1.0);
        let t = [0.7, 0.85, 1.0];
        let [c0, c1, c2] = parabola(&t, &t.map(x), 1.0).unwrap();
        assert!((c0 - 3.0).abs() < 1e-12 && (c1 + 2.0).abs() < 1e-11 && (c2 + 4.0).abs() < 1e-11);
        let at = passes(&t, &t.map(x), 0.5, 1.0).unwrap();
        assert!((x(at) - 0.5).abs() < 1e-12 && at > 1.0, "{at}");
        let line = passes(&[0.0, 1.0], &[5.0, 4.0], 0.0, 1.0).unwrap();
        assert!((line - 5.0).abs() < 1e-12, "{line}");
        assert!(passes(&t, &[1.0; 3], 0.0, 1.0).is_none());
    }

    #[test]
    fn of_a_series_the_change_that_is_missing_is_found() {
        let change = |t_s: f64, from: Way, to: Way| Change {
            from,
            to,
            t_s,
            between_s: 1e-3,
            around: [0, 0],
        };
        let ways =
            [Way::Rest, Way::Forward, Way::Rest, Way::Forward, Way::Rest, Way::Forward, Way::Rest];
        let right: Vec<Change> =
            ways.windows(2).enumerate().map(|(i, w)| change(1.0 + i as f64, w[0], w[1])).collect();
        // The second slip does not happen, and the third is late.
        let own: Vec<Change> = [0, 1, 4, 5]
            .map(|i| Change { t_s: right[i].t_s + if i > 3 { 0.25 } else { 0.0 }, ..right[i] })
            .to_vec();
        let found = pair(&right, &own, 10.0);
        let missed: Vec<f64> = found.missed.iter().map(|change| change.t_s).collect();
        assert_eq!((missed, found.extra.len()), (vec![3.0, 4.0], 0));
        let late: Vec<f64> = found.both.iter().map(|(right, own)| own.t_s - right.t_s).collect();
        assert_eq!(late, [0.0, 0.0, 0.25, 0.25]);
    }
}
