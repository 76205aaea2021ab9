//! What single columns show: clock, range of the angle, sensors that stop or saturate.

use super::asked::Asked;
use super::doubt::{Doubt, LEAST_SAMPLES, first, range};
use crate::form::columns::LONG;
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
const SHORTEST_INTERVAL_S: f64 = 1.5e-5;
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
/// The largest derivative of equal values, in any unit used here.
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
/// Steps of more than this share of all that a signal does are coarse …
const COARSE: f64 = 0.005;
/// … and one that dwells on the last of them so much longer than on those before slows down.
const SLOWS: f64 = 1.25;
/// A hand's movement is not recorded within this, s.
const SHORTEST_SPAN_S: f64 = 0.1;
/// A value that stands alone is off its neighbours by this share of all that the signal does …
const ALONE: f64 = 0.2;
/// … a force, which a blow moves quickly, by so many times that …
const ALONE_FORCE: f64 = 3.0;
/// … and by so many times more than values usually are.
const FAR: f64 = 10.0;
/// Neighbours before a value, and as many behind it, that tell what it should be.
const NEIGHBOURS: usize = 6;
/// The share of a signal's values that counts as usual.
const USUAL: f64 = 0.95;
/// Samples at the ends of a trial that tell whether it moves there.
const AN_END: usize = 5;

pub(super) fn doubts(expected: &Asked, samples: &dyn Columns) -> Vec<Doubt> {
    let least = samples.column(Signal::Time).map_or(0, |t| least_held(&t));
    let doubtful = samples.column(Signal::Time).filter(|t| has_doubtful_interval(t));
    let usual_s = doubtful.and_then(|t| usual_interval_s(&t));
    let time =
        [interval(usual_s).or_else(|| span(samples)), jump(samples, usual_s), clocks(samples)];
    // All of a signal together: of a long recording a file gives few columns at a time.
    let theta = [
        too_far(expected, samples),
        wrapped(expected, samples),
        stopped(expected, samples, Signal::Theta, least),
        alone(expected, samples, Signal::Theta, ALONE),
    ];
    let velocity = [
        noisy_onset(expected, samples),
        begins_moving(expected, samples),
        stopped(expected, samples, Signal::ThetaDot, least),
    ];
    let strong = too_strong(samples);
    let [force, torque] = [Signal::ForceEx, Signal::TorqueEx].map(|signal| {
        [
            stopped(expected, samples, signal, least),
            at_the_end(samples, signal),
            alone(expected, samples, signal, ALONE_FORCE),
        ]
    });
    let all = time.into_iter().chain(theta).chain(velocity).chain([strong]);
    all.chain(force).chain(torque).flatten().collect()
}

/// Whether any interval is so short or so long that [`interval`] or [`jump`] could find something: that
/// is quickly told, and of most recordings the usual one need not be sought.
fn has_doubtful_interval(t: &[f64]) -> bool {
    let usual = SHORTEST_INTERVAL_S..=LEAST_JUMP_S;
    first(1..t.len(), |i| !usual.contains(&(t[i] - t[i - 1]))).is_some()
}

/// The least number of samples of a value that is held for longer than [`HELD_S`].
fn least_held(t: &[f64]) -> usize {
    let [first_s, .., last_s] = *t else { return 0 };
    let most_s = 2.0 * (last_s - first_s) / (t.len() - 1) as f64;
    let is_even = first(1..t.len(), |i| t[i] - t[i - 1] > most_s).is_none();
    // By a clock with gaps, few samples may last as long: then every stretch counts.
    if is_even { (HELD_S / most_s) as usize } else { 0 }
}

/// The usual interval of the clock, s: the middle one.
fn usual_interval_s(t: &[f64]) -> Option<f64> {
    let steps = || t.windows(2).map(|t| t[1] - t[0]);
    if t.len() < LEAST_SAMPLES {
        return None;
    }
    let middle = (t.len() - 1) / 2;
    // A copy would be one more long column in memory.
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

fn span(samples: &dyn Columns) -> Option<Doubt> {
    let t = samples.column(Signal::Time).filter(|t| t.len() >= LEAST_SAMPLES)?;
    let span_s = t.last()? - t.first()?;
    if span_s >= SHORTEST_SPAN_S {
        return None;
    }
    let what = format!(
        "the whole recording lasts {span_s:.4} s; no hand moves in that: seconds taken for milliseconds, or milliseconds \
         for microseconds?"
    );
    let remedy = "mend unit or rate_hz in [time] of the mapping, and import again";
    Some(Doubt::new(Signal::Time, what, remedy))
}

/// A movement of which the recording lacks the beginning, and has the end.
fn begins_moving(expected: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let velocity = samples.column(Signal::ThetaDot).filter(|v| v.len() >= LEAST_SAMPLES)?;
    let [first, last] = [&velocity[..AN_END], &velocity[velocity.len() - AN_END..]].map(|end| {
        let mut speeds: Vec<f64> = end.iter().map(|v| v.abs()).collect();
        *speeds.select_nth_unstable_by(end.len() / 2, f64::total_cmp).1
    });
    let (low, high) = ends(&velocity);
    let fastest = low.abs().max(high.abs());
    if first <= expected.onset_rad_s.max(ALONE * fastest) || last > expected.onset_rad_s {
        return None;
    }
    let what = format!(
        "it moves at {:.0} % of its largest speed when the recording begins: onset, duration and what comes of them are \
         those of the recording and not of the movement",
        100.0 * first / fastest
    );
    let remedy =
        "record from rest on; exclude the trial, or do not use what begins with the movement";
    Some(Doubt { row: Some(0), ..Doubt::new(Signal::ThetaDot, what, remedy) })
}

/// Values that are far off their neighbours on both sides, or one value far off all others, however often
/// it comes.
fn alone(expected: &Asked, samples: &dyn Columns, signal: Signal, share: f64) -> Option<Doubt> {
    let values = samples.column(signal).filter(|values| values.len() >= LEAST_SAMPLES)?;
    let least = ALONE * range(&values) / 2.0;
    // Of most recordings this is all: no step is so large.
    first(1..values.len(), |i| step(&values, i) > least)?;
    let returns = first(1..values.len(), |i| step(&values, i) > least && comes_back(&values, i));
    let off = returns.and_then(|_| off_neighbours(&values, share));
    let (row, words) = match (off, apart(&values)) {
        (Some(Off { row, usual, count }), _) => {
            let [value, usual] = [values[row], usual].map(|value| shown(expected, signal, value));
            (row, format!("{value} where its neighbours are {usual}, in {count} samples"))
        }
        (None, Some((row, count))) => {
            let value = shown(expected, signal, values[row]);
            (row, format!("{value} in {count} samples, far from all others"))
        }
        (None, None) => return None,
    };
    let what =
        format!("it is {words}: a number that stands for a missing value, or a disturbance?");
    let remedy = "leave such rows out (missing = \"drop\", and missing_words in [file]), or exclude the trial";
    Some(Doubt { row: Some(row), ..Doubt::new(signal, what, remedy) })
}

fn step(values: &[f64], i: usize) -> f64 {
    (values[i] - values[i - 1]).abs()
}

fn shown(expected: &Asked, signal: Signal, value: f64) -> String {
    match signal {
        Signal::Theta => expected.place(value),
        _ => format!("{value:.4}"),
    }
}

/// Whether the step to a value is undone soon after it, or undoes one soon before: what stands alone
/// has such a step. At the ends of a signal nothing tells.
fn comes_back(values: &[f64], i: usize) -> bool {
    if i <= NEIGHBOURS || i + NEIGHBOURS >= values.len() {
        return true;
    }
    let half = step(values, i) / 2.0;
    let after = &values[i + 1..i + NEIGHBOURS + 1];
    let before = &values[i - NEIGHBOURS - 1..i - 1];
    after.iter().any(|v| (v - values[i - 1]).abs() <= half)
        || before.iter().any(|v| (v - values[i]).abs() <= half)
}

/// Values off their neighbours: the first, what its neighbours are, and how many.
struct Off {
    row: usize,
    usual: f64,
    count: usize,
}

/// Values that are farther off the middle of their neighbours than values usually are, and than a share
/// of the range.
fn off_neighbours(values: &[f64], share: f64) -> Option<Off> {
    let middles: Vec<f64> = (0..values.len())
        .map(|i| {
            let from = i.saturating_sub(NEIGHBOURS);
            let to = (i + NEIGHBOURS + 1).min(values.len());
            let mut near = values[from..to].to_vec();
            let middle = near.len() / 2;
            *near.select_nth_unstable_by(middle, f64::total_cmp).1
        })
        .collect();
    let offs: Vec<f64> =
        values.iter().zip(&middles).map(|(v, middle)| (v - middle).abs()).collect();
    let usual = (USUAL * offs.len() as f64) as usize;
    let usual = *offs.clone().select_nth_unstable_by(usual, f64::total_cmp).1;
    let least = (share * range(&middles)).max(FAR * usual);
    let alone: Vec<usize> = (0..values.len()).filter(|i| offs[*i] > least).collect();
    let row = *alone.first()?;
    Some(Off { row, usual: middles[row], count: alone.len() })
}

/// The lowest or the highest value, if it is far from all others: where it is first, and how often.
fn apart(values: &[f64]) -> Option<(usize, usize)> {
    let (low, high) = ends(values);
    for end in [low, high] {
        let is_end = |value: &f64| value.to_bits() == end.to_bits();
        let mut others = 0;
        let mut least = f64::INFINITY;
        let mut most = f64::NEG_INFINITY;
        for value in values.iter().filter(|value| !is_end(value)) {
            others += 1;
            least = least.min(*value);
            most = most.max(*value);
        }
        let rest = most - least;
        let gap = (least - end).max(end - most);
        if others >= LEAST_SAMPLES && rest > 0.0 && gap > ALONE_FORCE * rest {
            return Some((values.iter().position(is_end)?, values.len() - others));
        }
    }
    None
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

fn too_far(expected: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let theta = samples.column(Signal::Theta)?;
    let row = first(0..theta.len(), |i| match expected.coordinate {
        Coordinate::Rotational => theta[i].abs() / FARTHEST_RAD > 1.0,
        Coordinate::Linear { lever_m } => theta[i].abs() * lever_m / FARTHEST_M > 1.0,
    })?;
    let what = match expected.coordinate {
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
fn wrapped(expected: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let theta =
        samples.column(Signal::Theta).filter(|_| expected.coordinate == Coordinate::Rotational)?;
    let row = first(1..theta.len(), |i| step(&theta, i) > WRAPPED_RAD)?;
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
fn noisy_onset(expected: &Asked, samples: &dyn Columns) -> Option<Doubt> {
    let leaves = {
        let theta = samples.column(Signal::Theta)?;
        let first = *theta.first()?;
        let far = AT_REST * range(&theta);
        theta.iter().position(|theta| (theta - first).abs() > far)?
    };
    let velocity = samples.column(Signal::ThetaDot)?;
    // 0 below the onset, else the direction.
    let side = |value: &f64| {
        i8::from(*value > expected.onset_rad_s) - i8::from(-*value > expected.onset_rad_s)
    };
    let mut from = 0;
    let mut first = None;
    let mut spikes = [0, 0];
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
fn stopped(expected: &Asked, samples: &dyn Columns, signal: Signal, least: usize) -> Option<Doubt> {
    let values = samples.column(signal)?;
    if values.len() < LEAST_SAMPLES {
        return None;
    }
    let remedy = "look at the sensor and its cable, and at `from` in the mapping; exclude the trial if the signal was lost";
    // An angle may well be held for long: the lever rests.
    let least = if signal == Signal::Theta { values.len() } else { least.min(values.len()) };
    let (from, to) = longest_hold(&values, least)?;
    let held = values[from];
    let is_whole = to - from == values.len();
    // Let go before others are looked at: of a long recording few columns may be in memory.
    drop(values);
    if is_whole {
        let others = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx];
        let mut others = others.into_iter();
        let other =
            others.find(|other| samples.column(*other).is_some_and(|v| range(&v) > ROUNDING))?;
        // Of an isometric trial the angle is one value and the velocity none, whatever the force does.
        let motion = [Signal::Theta, Signal::ThetaDot];
        let rests = signal == Signal::Theta || held == 0.0;
        let is_isometric = motion.contains(&signal) && rests && !motion.contains(&other);
        // Nobody pushes against nothing: no force is what is to be measured there.
        let is_free = held == 0.0 && matches!(expected.scene, Scene::Free | Scene::None);
        if is_isometric || is_free {
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

/// A signal that stands at its largest value while the lever moves or is held by a hand: its sensor, or
/// what read it, goes no farther. Where nothing moves it may be a load that is held, and only other trials
/// can tell.
fn at_the_end(samples: &dyn Columns, signal: Signal) -> Option<Doubt> {
    let moved = samples.column(Signal::Theta).is_some_and(|theta| range(&theta) > ROUNDING);
    let values = samples.column(signal).filter(|_| moved)?;
    let Plateau { value, first, share } = plateau(&values)?;
    let what = format!(
        "it stands at its largest value, {value}, in {:.0} % of the samples: the sensor or its converter is at the end of \
         its range",
        100.0 * share
    );
    let remedy = "larger values are lost: exclude the trial, or report it in your methods; check scale and range of the sensor";
    Some(Doubt { row: Some(first), ..Doubt::new(signal, what, remedy) })
}

/// Where a signal stays at its largest value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plateau {
    /// The value.
    pub value: f64,
    /// The first sample there, from 0.
    pub first: usize,
    /// The share of all samples there.
    pub share: f64,
}

/// Where a signal stays at its largest value because its sensor saturates there; `None` if it comes
/// to rest there.
pub fn plateau(values: &[f64]) -> Option<Plateau> {
    let (low, high) = ends(values);
    let end = *values.iter().find(|value| value.abs() >= low.abs().max(high.abs()))?;
    let bits = end.to_bits();
    let held = values.iter().filter(|value| value.to_bits() == bits).count();
    let n = values.len() as f64;
    let count = held as f64;
    if held < LEAST_AT_THE_END || count < AT_THE_END * n {
        return None;
    }
    let changes = values.windows(2).filter(|w| w[0].to_bits() != w[1].to_bits()).count();
    let usual = n / (changes + 1) as f64;
    if count < LONGER * usual || changes == 0 {
        return None;
    }
    let first = values.iter().position(|value| value.to_bits() == bits)?;
    let last = values.iter().rposition(|value| value.to_bits() == bits)?;
    // A load that is held scatters about its value: where a sensor ends, nothing lies just below.
    let close = NEAR_THE_END * (high - low);
    let others = values[first..=last].iter().filter(|value| value.to_bits() != bits);
    if others.filter(|value| (**value - end).abs() < close).count() as f64 > FEW * count {
        return None;
    }
    let is_slowing = slows(values, end, COARSE * (high - low));
    (!is_slowing).then_some(Plateau { value: end, first, share: count / n })
}

/// Whether a signal of coarse steps (of this size at least) slows down on its way to its largest value, as
/// a hand does before it turns: it dwells longer on the step before than on those before that.
fn slows(values: &[f64], end: f64, coarse: f64) -> bool {
    // How far the three steps next to the end are from it.
    let mut offs = [0.0; 3];
    let mut from = 0.0;
    for off in &mut offs {
        let farther =
            values.iter().map(|value| (value - end).abs()).filter(|off| *off > from + ROUNDING);
        from = farther.fold(f64::INFINITY, f64::min);
        *off = from;
    }
    if offs[0] < coarse || !offs[2].is_finite() {
        return false;
    }
    let [first, second, third] = offs.map(|off| {
        values.iter().filter(|value| ((**value - end).abs() - off).abs() <= ROUNDING).count() as f64
    });
    first > SLOWS * (second + third) / 2.0
}

/// The value that `rank` others of `values` come before, in the order of [`f64::total_cmp`]. By
/// counting, sixteen bits at a time: of a long recording no copy is made.
fn ranked<I: Iterator<Item = f64>>(values: impl Fn() -> I, mut rank: usize) -> f64 {
    const BITS: u32 = 16;
    let mut prefix = 0_u64;
    for place in (0..u64::BITS / BITS).rev().map(|i| i * BITS) {
        const COUNTS: usize = 1 << BITS;
        let mut counts = vec![0_usize; COUNTS];
        // Only those that begin with the bits found so far; at first there are none.
        let above = place + BITS;
        let keys = values().map(ordered);
        for key in keys.filter(|key| key.checked_shr(above) == prefix.checked_shr(above)) {
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
    let some = values.iter().step_by((least / 2).max(1));
    let mut pairs = some.clone().zip(some.skip(1));
    if !pairs.any(|(a, b)| a.to_bits() == b.to_bits()) && least > 1 {
        return None;
    }
    let mut longest = (0, 0);
    let mut from = 0;
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
