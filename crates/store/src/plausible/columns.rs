//! What single columns say: clock, reach of the angle, sensors that stop or end.

use super::asked::Asked;
use super::doubt::{Doubt, LEAST_SAMPLES, first, range};
use crate::columns::LONG;
use crate::{Columns, Signal};
use zwidth_numerics::series::ends;
use zwidth_study::{Coordinate, Scene};

/// Two turns: no lever goes farther, and 13° read as radians do.
const FARTHEST_RAD: f64 = 4.0 * core::f64::consts::PI;
/// No slide goes farther, m; a few millimetres read as metres do.
const FARTHEST_M: f64 = 2.0;
/// Half a turn: no lever goes farther from one sample to the next.
const WRAPPED_RAD: f64 = core::f64::consts::PI;
/// No hand pushes harder, N: it is more than a person weighs.
const STRONGEST_N: f64 = 1000.0;
/// A hand's movement recorded with a longer interval than this, s, is not recorded.
const LONGEST_INTERVAL_S: f64 = 0.5;
/// No rig records a hand at shorter intervals, s.
const SHORTEST_INTERVAL_S: f64 = 1e-5;
/// A clock jumps by more than this many of its usual intervals …
const JUMP: f64 = 5.0;
/// … and by more than this, s.
const LEAST_JUMP_S: f64 = 0.05;
/// The velocity's noise passes the onset for so many samples at a time, at most …
const SPIKE: usize = 3;
/// … and this often in each direction, at least, while the lever rests …
const SPIKES: usize = 2;
/// … which is as long as it is this share of its range from where it began.
const AT_REST: f64 = 0.05;
/// What a derivative of equal values differs by from 0, in any unit of ours.
const ROUNDING: f64 = 1e-9;
/// By how much two clocks may differ over a trial.
const CLOCKS_DIFFER: f64 = 0.1;
/// A signal that holds one value this long, s, while the lever moves, has stopped.
const HELD_S: f64 = 1.0;
/// How far the lever then moves, as a share of its whole range.
const MOVED: f64 = 0.2;
/// A signal at the end of its range stands there in so many samples at least …
const LEAST_AT_THE_END: usize = 20;
/// … and in this share of them …
const AT_THE_END: f64 = 0.05;
/// … and so much longer than it holds a value otherwise …
const LONGER: f64 = 5.0;
/// … while within this share of all that it does …
const NEAR_THE_END: f64 = 0.02;
/// … there are, from the first sample at the end to the last, fewer others than this share of these.
const FEW: f64 = 0.15;

pub(super) fn doubts(asked: &Asked, samples: &dyn Columns) -> Vec<Doubt> {
    let least = samples.column(Signal::Time).map_or(0, |t| least_held(&t));
    let stopped = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx]
        .into_iter()
        .filter_map(|signal| stopped(asked, samples, signal, least));
    let at_the_end = [Signal::ForceEx, Signal::TorqueEx]
        .into_iter()
        .filter_map(|signal| at_the_end(samples, signal));
    let doubtful = samples.column(Signal::Time).filter(|t| has_doubtful_interval(t));
    let usual_s = doubtful.and_then(|t| usual_interval_s(&t));
    let single = [
        interval(usual_s),
        jump(samples, usual_s),
        clocks(samples),
        too_far(asked, samples),
        wrapped(asked, samples),
        too_strong(samples),
        noisy_onset(asked, samples),
    ];
    single.into_iter().flatten().chain(stopped).chain(at_the_end).collect()
}

/// Whether any interval is so short or so long that [`interval`] or [`jump`] could find something: that
/// is quickly told, and of most recordings the usual one need not be sought.
fn has_doubtful_interval(t: &[f64]) -> bool {
    let usual = SHORTEST_INTERVAL_S..=LEAST_JUMP_S;
    first(1..t.len(), |i| !usual.contains(&(t[i] - t[i - 1]))).is_some()
}

/// So many samples has a value that is held for longer than [`HELD_S`], at least.
fn least_held(t: &[f64]) -> usize {
    let [first_s, .., last_s] = *t else { return 0 };
    let most_s = 2.0 * (last_s - first_s) / (t.len() - 1) as f64;
    let is_even = first(1..t.len(), |i| t[i] - t[i - 1] > most_s).is_none();
    if is_even { (HELD_S / most_s) as usize } else { 0 }
}

/// The usual interval of the clock, s: the middle one.
fn usual_interval_s(t: &[f64]) -> Option<f64> {
    let steps = || t.windows(2).map(|t| t[1] - t[0]);
    if t.len() < LEAST_SAMPLES {
        return None;
    }
    let middle = (t.len() - 1) / 2;
    if t.len() > LONG {
        return Some(ranked(steps, middle));
    }
    let mut copy: Vec<f64> = steps().collect();
    Some(*copy.select_nth_unstable_by(middle, f64::total_cmp).1)
}

fn interval(usual_s: Option<f64>) -> Option<Doubt> {
    let interval_s = usual_s?;
    let so = if interval_s > LONGEST_INTERVAL_S {
        "no movement of a hand can be read from that: milliseconds taken for seconds?"
    } else if interval_s < SHORTEST_INTERVAL_S {
        "no rig records a hand so fast: seconds taken for milliseconds, days of a spreadsheet taken for seconds, or a rate_hz in kilohertz?"
    } else {
        return None;
    };
    let what = format!("a sample comes every {interval_s} s; {so}");
    let remedy = "mend unit or rate_hz in [time] of the mapping, and import again";
    Some(Doubt::new(Signal::Time, what, remedy))
}

fn jump(samples: &dyn Columns, usual_s: Option<f64>) -> Option<Doubt> {
    let t = samples.column(Signal::Time)?;
    let usual_s = usual_s?;
    let least_s = (JUMP * usual_s).max(LEAST_JUMP_S);
    let row = (1..t.len()).find(|i| t[*i] - t[*i - 1] > least_s)?;
    let what = format!(
        "the clock jumps by {:.3} s from the sample before; the usual interval is {:.6} s: samples are missing, or two \
         recordings lie in one file",
        t[row] - t[row - 1],
        usual_s
    );
    let remedy = "split the recording there, or exclude the trial: what happened between is drawn as a straight line";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::Time, what, remedy) })
}

fn clocks(samples: &dyn Columns) -> Option<Doubt> {
    let device_s = samples.reach(Signal::DeviceTime)?;
    let host_s = {
        let t = samples.column(Signal::Time)?;
        t.last()? - t.first()?
    };
    let differ = (device_s / host_s - 1.0).abs() > CLOCKS_DIFFER;
    if samples.rows() < LEAST_SAMPLES || !differ {
        return None;
    }
    let what = format!(
        "the device's clock runs for {device_s} s while t_s runs for {host_s} s: one of them has another unit, or the \
         rate does not fit"
    );
    let remedy = "compare their units, and rate_hz, with what the rig writes";
    Some(Doubt::new(Signal::DeviceTime, what, remedy))
}

fn too_far(asked: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let theta = samples.column(Signal::Theta)?;
    let size = |value: f64| match asked.coordinate {
        Coordinate::Rotational => value.abs() / FARTHEST_RAD,
        Coordinate::Linear { lever_m } => value.abs() * lever_m / FARTHEST_M,
    };
    let row = first(0..theta.len(), |i| size(theta[i]) > 1.0)?;
    let what = match asked.coordinate {
        Coordinate::Rotational => format!(
            "{:.0}° is more than two turns of a lever: degrees taken for radians, or counts for an angle?",
            theta[row].to_degrees()
        ),
        Coordinate::Linear { lever_m } => format!(
            "{:.1} m is farther than a slide goes: millimetres taken for metres, or counts for a length?",
            theta[row] * lever_m
        ),
    };
    let remedy = "mend unit or scale of the column in the mapping, and import again";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::Theta, what, remedy) })
}

/// An angle that starts over at a full turn.
fn wrapped(asked: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let theta =
        samples.column(Signal::Theta).filter(|_| asked.coordinate == Coordinate::Rotational)?;
    let row = first(1..theta.len(), |i| (theta[i] - theta[i - 1]).abs() > WRAPPED_RAD)?;
    let what = format!(
        "the angle goes from {:.0}° to {:.0}° within a sample: one that starts over at a full turn?",
        theta[row - 1].to_degrees(),
        theta[row].to_degrees()
    );
    let remedy =
        "unwrap the angle before the import (numpy.unwrap), or mend its unit in the mapping";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::Theta, what, remedy) })
}

/// A velocity whose noise passes the onset, forwards and backwards, while the lever rests: the
/// movement would begin too early.
fn noisy_onset(asked: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let leaves = {
        let theta = samples.column(Signal::Theta)?;
        let (first, far) = (*theta.first()?, AT_REST * range(&theta));
        theta.iter().position(|theta| (theta - first).abs() > far)?
    };
    let velocity = samples.column(Signal::ThetaDot)?;
    // 0 below the onset, else the direction.
    let side =
        |value: &f64| i8::from(*value > asked.onset_rad_s) - i8::from(-*value > asked.onset_rad_s);
    let (mut from, mut first, mut spikes) = (0, None, [0, 0]);
    // A run that begins while it rests ends before that, or is longer than a spike.
    let rest = &velocity[..velocity.len().min(leaves + SPIKE + 1)];
    for run in rest.chunk_by(|a, b| side(a) == side(b)) {
        if from >= leaves {
            break;
        }
        if side(&run[0]) != 0 && run.len() <= SPIKE {
            first = first.or(Some(from));
            spikes[usize::from(run[0] > 0.0)] += 1;
        }
        from += run.len();
    }
    if spikes.iter().any(|n| *n < SPIKES) {
        return None;
    }
    let what = format!(
        "its noise passes onset_deg_s {} times while the lever rests: the movement seems to begin too early, and resting to swing",
        spikes[0] + spikes[1]
    );
    let remedy = "set onset_deg_s (and offset_deg_s) under [analysis] of study.toml above the noise of the velocity at rest";
    Some(Doubt { row: first, ..Doubt::new(Signal::ThetaDot, what, remedy) })
}

/// A force that no hand has.
fn too_strong(samples: &dyn Columns) -> Option<Doubt> {
    let force = samples.column(Signal::ForceEx)?;
    let row = first(0..force.len(), |i| force[i].abs() > STRONGEST_N)?;
    let what = format!(
        "{:e} N is more than a person weighs: mN taken for N, counts for a force, or a number that stands for a missing value?",
        force[row]
    );
    let remedy = "mend unit or scale of the column in the mapping, or leave such rows empty with missing = \"drop\"";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::ForceEx, what, remedy) })
}

/// A signal that holds one value: throughout, or for a second in which the lever moves on, which takes
/// `least` samples. No more than one column is there at a time.
fn stopped(asked: &Asked, samples: &dyn Columns, signal: Signal, least: usize) -> Option<Doubt> {
    let values = samples.column(signal)?;
    if values.len() < LEAST_SAMPLES {
        return None;
    }
    let remedy = "look at the sensor and its cable, and at `from` in the mapping; exclude the trial if the signal was lost";
    // An angle may well be held for long: the lever rests.
    let least = if signal == Signal::Theta { values.len() } else { least.min(values.len()) };
    let (from, to) = longest_hold(&values, least)?;
    let (held, is_whole) = (values[from], to - from == values.len());
    drop(values);
    if is_whole {
        let others = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx];
        let moves = |other: &Signal| samples.column(*other).is_some_and(|v| range(&v) > ROUNDING);
        let other = others.iter().find(|other| moves(other))?;
        // Of an isometric trial the angle is one value and the velocity none, whatever the force does.
        let of_motion = |signal: &Signal| matches!(signal, Signal::Theta | Signal::ThetaDot);
        let rests = signal == Signal::Theta || held == 0.0;
        let is_isometric = of_motion(&signal) && rests && !of_motion(other);
        if is_isometric {
            return None;
        }
        // Nobody pushes against nothing: no force is what is to be measured there.
        let nothing = held == 0.0 && matches!(asked.scene, Scene::Free | Scene::None);
        if nothing {
            return None;
        }
        let what = format!("it is {held} throughout, while {} changes", other.name());
        return Some(Doubt::new(signal, what, remedy));
    }
    if signal == Signal::Theta || held == 0.0 {
        return None;
    }
    let length_s = {
        let t = samples.column(Signal::Time)?;
        t[to - 1] - t[from]
    };
    if length_s <= HELD_S {
        return None;
    }
    let theta = samples.column(Signal::Theta)?;
    let moved = range(&theta[from..to]) > MOVED * range(&theta);
    if !moved {
        return None;
    }
    let what = format!("it holds {held} for {length_s:.2} s while the lever moves on");
    Some(Doubt { row: Some(from), ..Doubt::new(signal, what, remedy) })
}

/// A signal that stands at its largest value: its sensor, or what read it, goes no farther.
fn at_the_end(samples: &dyn Columns, signal: Signal) -> Option<Doubt> {
    let values = samples.column(signal)?;
    let (low, high) = ends(&values);
    let end = *values.iter().find(|value| value.abs() >= low.abs().max(high.abs()))?;
    let is_there = |value: &f64| value.to_bits() == end.to_bits();
    let there = values.iter().filter(|value| is_there(value)).count();
    let (n, count) = (values.len() as f64, there as f64);
    if there < LEAST_AT_THE_END || count < AT_THE_END * n {
        return None;
    }
    let changes = values.windows(2).filter(|w| w[0].to_bits() != w[1].to_bits()).count();
    let usual = n / (changes + 1) as f64;
    if count < LONGER * usual || changes == 0 {
        return None;
    }
    let first = values.iter().position(is_there)?;
    let last = values.iter().rposition(is_there)?;
    // A load that is held scatters about its value: where a sensor ends, nothing lies just below.
    let close = NEAR_THE_END * (high - low);
    let is_close = |value: &&f64| !is_there(value) && (**value - end).abs() < close;
    if values[first..=last].iter().filter(is_close).count() as f64 > FEW * count {
        return None;
    }
    let what = format!(
        "it stands at its largest value, {end}, in {:.0} % of the samples: the sensor or its converter is at the end of \
         its range",
        100.0 * count / n
    );
    let remedy = "larger values are lost: exclude the trial, or report it in your methods; check scale and range of the sensor";
    Some(Doubt { row: Some(first), ..Doubt::new(signal, what, remedy) })
}

/// The value that `rank` others of `values` come before, in the order of [`f64::total_cmp`]. By
/// counting, sixteen bits at a time: of a long recording no copy is made.
fn ranked<I: Iterator<Item = f64>>(values: impl Fn() -> I, mut rank: usize) -> f64 {
    const BITS: u32 = 16;
    let mut prefix = 0_u64;
    for place in (0..u64::BITS / BITS).rev().map(|i| i * BITS) {
        const COUNTS: usize = 1 << BITS;
        let mut counts = vec![0_usize; COUNTS];
        let above = |key: u64| key.checked_shr(place + BITS).unwrap_or(0);
        for key in values().map(ordered).filter(|key| above(*key) == above(prefix)) {
            counts[(key >> place) as usize & (COUNTS - 1)] += 1;
        }
        let mut at = 0;
        while at + 1 < COUNTS && counts[at] <= rank {
            rank -= counts[at];
            at += 1;
        }
        prefix |= (at as u64) << place;
    }
    f64::from_bits(if prefix >> 63 == 1 { prefix ^ (1 << 63) } else { !prefix })
}

/// A number whose order is that of [`f64::total_cmp`].
fn ordered(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | (1 << 63) }
}

/// From where to where (exclusive) the longest stretch of one value goes; none if it is soon told that
/// no stretch has `least` samples.
fn longest_hold(values: &[f64], least: usize) -> Option<(usize, usize)> {
    // A stretch of so many has two that are half as far apart.
    let some = || values.iter().step_by((least / 2).max(1));
    if !some().zip(some().skip(1)).any(|(a, b)| a.to_bits() == b.to_bits()) && least > 1 {
        return None;
    }
    let (mut longest, mut from) = ((0, 0), 0);
    for i in 1..=values.len() {
        if i == values.len() || values[i].to_bits() != values[from].to_bits() {
            if i - from > longest.1 - longest.0 {
                longest = (from, i);
            }
            from = i;
        }
    }
    Some(longest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ranked_value_is_that_of_a_sorted_copy() {
        let mut values: Vec<f64> =
            (0..1000).map(|i| libm::sin(f64::from(i) * 7.3) * 1e-3).collect();
        values.extend([0.0, -0.0, 1e300, -1e300, 1e-321, 5.0, 5.0, 5.0]);
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        for (rank, value) in sorted.iter().enumerate() {
            let found = ranked(|| values.iter().copied(), rank);
            assert_eq!(found.to_bits(), value.to_bits(), "{rank}");
        }
    }
}
