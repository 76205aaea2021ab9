//! What single columns say: clock, reach of the angle, sensors that stop or end.

use super::asked::Asked;
use super::doubt::{Doubt, LEAST_SAMPLES, range};
use crate::{Samples, Signal};
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
const JUMP: f64 = 50.0;
/// … and by more than this, s.
const LEAST_JUMP_S: f64 = 0.25;
/// By how much two clocks may differ over a trial.
const CLOCKS_DIFFER: f64 = 0.1;
/// A signal that holds one value this long, s, while the lever moves, has stopped.
const HELD_S: f64 = 1.0;
/// How far the lever then moves, as a share of its whole range.
const MOVED: f64 = 0.2;
/// A signal at the end of its range stands there in this share of the samples at least …
const AT_THE_END: f64 = 0.05;
/// … and so much longer than it holds a value otherwise.
const LONGER: f64 = 5.0;

pub(super) fn doubts(asked: &Asked, samples: &Samples) -> Vec<Doubt> {
    let stopped = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx]
        .into_iter()
        .filter_map(|signal| stopped(asked, samples, signal));
    let at_the_end = [Signal::ForceEx, Signal::TorqueEx]
        .into_iter()
        .filter_map(|signal| at_the_end(samples, signal));
    let single = [
        interval(samples),
        jump(samples),
        clocks(samples),
        too_far(asked, samples),
        wrapped(asked, samples),
        too_strong(samples),
    ];
    single.into_iter().flatten().chain(stopped).chain(at_the_end).collect()
}

/// The usual interval of the clock, s.
fn usual_interval_s(t: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = t.windows(2).map(|t| t[1] - t[0]).collect();
    let middle = steps.len() / 2;
    (t.len() >= LEAST_SAMPLES).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

fn interval(samples: &Samples) -> Option<Doubt> {
    let interval_s = usual_interval_s(samples.get(Signal::Time)?)?;
    let so = if interval_s > LONGEST_INTERVAL_S {
        "no movement of a hand can be read from that: milliseconds taken for seconds?"
    } else if interval_s < SHORTEST_INTERVAL_S {
        "no rig records a hand so fast: seconds taken for milliseconds, or a rate_hz in kilohertz?"
    } else {
        return None;
    };
    let what = format!("a sample comes every {interval_s} s; {so}");
    let remedy = "mend unit or rate_hz in [time] of the mapping, and import again";
    Some(Doubt::new(Signal::Time, what, remedy))
}

fn jump(samples: &Samples) -> Option<Doubt> {
    let t = samples.get(Signal::Time)?;
    let least_s = (JUMP * usual_interval_s(t)?).max(LEAST_JUMP_S);
    let row = (1..t.len()).find(|i| t[*i] - t[*i - 1] > least_s)?;
    let what = format!(
        "the clock jumps by {:.3} s from the sample before; the usual interval is {:.6} s: samples are missing, or two \
         recordings lie in one file",
        t[row] - t[row - 1],
        usual_interval_s(t)?
    );
    let remedy = "split the recording there, or exclude the trial: what happened between is drawn as a straight line";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::Time, what, remedy) })
}

fn clocks(samples: &Samples) -> Option<Doubt> {
    let length = |t: &[f64]| Some(t.last()? - t.first()?);
    let t = samples.get(Signal::Time)?;
    let (host_s, device_s) = (length(t)?, length(samples.get(Signal::DeviceTime)?)?);
    let differ = (device_s / host_s - 1.0).abs() > CLOCKS_DIFFER;
    let what = format!(
        "the device's clock runs for {device_s} s while t_s runs for {host_s} s: one of them has another unit, or the \
         rate does not fit"
    );
    let remedy = "compare their units, and rate_hz, with what the rig writes";
    (t.len() >= LEAST_SAMPLES && differ).then(|| Doubt::new(Signal::DeviceTime, what, remedy))
}

fn too_far(asked: &Asked, samples: &Samples) -> Option<Doubt> {
    let theta = samples.get(Signal::Theta)?;
    let size = |value: f64| match asked.coordinate {
        Coordinate::Rotational => value.abs() / FARTHEST_RAD,
        Coordinate::Linear { lever_m } => value.abs() * lever_m / FARTHEST_M,
    };
    let row = theta.iter().position(|value| size(*value) > 1.0)?;
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
fn wrapped(asked: &Asked, samples: &Samples) -> Option<Doubt> {
    let theta =
        samples.get(Signal::Theta).filter(|_| asked.coordinate == Coordinate::Rotational)?;
    let row = (1..theta.len()).find(|i| (theta[*i] - theta[*i - 1]).abs() > WRAPPED_RAD)?;
    let what = format!(
        "the angle goes from {:.0}° to {:.0}° within a sample: one that starts over at a full turn?",
        theta[row - 1].to_degrees(),
        theta[row].to_degrees()
    );
    let remedy =
        "unwrap the angle before the import (numpy.unwrap), or mend its unit in the mapping";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::Theta, what, remedy) })
}

/// A force that no hand has.
fn too_strong(samples: &Samples) -> Option<Doubt> {
    let force = samples.get(Signal::ForceEx)?;
    let row = force.iter().position(|value| value.abs() > STRONGEST_N)?;
    let what = format!(
        "{:e} N is more than a person weighs: mN taken for N, counts for a force, or a number that stands for a missing value?",
        force[row]
    );
    let remedy = "mend unit or scale of the column in the mapping, or leave such rows empty with missing = \"drop\"";
    Some(Doubt { row: Some(row), ..Doubt::new(Signal::ForceEx, what, remedy) })
}

/// A signal that holds one value: throughout, or for a second in which the lever moves on.
fn stopped(asked: &Asked, samples: &Samples, signal: Signal) -> Option<Doubt> {
    let (t, values) = (samples.get(Signal::Time)?, samples.get(signal)?);
    if values.len() < LEAST_SAMPLES {
        return None;
    }
    let remedy = "look at the sensor and its cable, and at `from` in the mapping; exclude the trial if the signal was lost";
    let (from, to) = longest_hold(values);
    if to - from == values.len() {
        let others = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx];
        let moves = |other: &Signal| samples.get(*other).is_some_and(|v| !is_constant(v));
        let other = others.iter().find(|other| moves(other))?;
        // Nobody pushes against nothing: no force is what is to be measured there.
        let nothing = values[0] == 0.0 && matches!(asked.scene, Scene::Free | Scene::None);
        let what = format!("it is {} throughout, while {} changes", values[0], other.name());
        return (!nothing).then(|| Doubt::new(signal, what, remedy));
    }
    let theta = samples.get(Signal::Theta)?;
    let length_s = t[to - 1] - t[from];
    let moved = range(&theta[from..to]) > MOVED * range(theta);
    let what = format!("it holds {} for {length_s:.2} s while the lever moves on", values[from]);
    (signal != Signal::Theta && length_s > HELD_S && moved && values[from] != 0.0)
        .then(|| Doubt { row: Some(from), ..Doubt::new(signal, what, remedy) })
}

/// A signal that stands at its largest value: its sensor, or what read it, goes no farther.
fn at_the_end(samples: &Samples, signal: Signal) -> Option<Doubt> {
    let values = samples.get(signal)?;
    let end = values.iter().copied().reduce(|a, b| if b.abs() > a.abs() { b } else { a })?;
    let is_there = |value: &f64| value.to_bits() == end.to_bits();
    let there: Vec<usize> = (0..values.len()).filter(|i| is_there(&values[*i])).collect();
    let (n, count) = (values.len() as f64, there.len() as f64);
    let changes = values.windows(2).filter(|w| w[0].to_bits() != w[1].to_bits()).count();
    let usual = n / (changes + 1) as f64;
    let stands = there.len() >= LEAST_SAMPLES
        && count >= AT_THE_END * n
        && count >= LONGER * usual
        && changes > 0;
    let what = format!(
        "it stands at its largest value, {end}, in {:.0} % of the samples: the sensor or its converter is at the end of \
         its range",
        100.0 * count / n
    );
    let remedy = "what was larger is lost: exclude the trial, or say so; check scale and range of the sensor";
    stands.then(|| Doubt { row: there.first().copied(), ..Doubt::new(signal, what, remedy) })
}

fn is_constant(values: &[f64]) -> bool {
    values.windows(2).all(|w| w[0].to_bits() == w[1].to_bits())
}

/// From where to where (exclusive) the longest stretch of one value goes.
fn longest_hold(values: &[f64]) -> (usize, usize) {
    let (mut longest, mut from) = ((0, 0), 0);
    for i in 1..=values.len() {
        if i == values.len() || values[i].to_bits() != values[from].to_bits() {
            if i - from > longest.1 - longest.0 {
                longest = (from, i);
            }
            from = i;
        }
    }
    longest
}
