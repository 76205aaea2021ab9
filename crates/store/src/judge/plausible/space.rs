//! What positions and forces in several axes show: their units, lost markers, axes that stand still.

use super::doubt::{Doubt, LEAST_SAMPLES, first, range};
use crate::{Columns, Signal};

const POSITIONS: [Signal; 3] = [Signal::X, Signal::Y, Signal::Z];
const FORCES: [Signal; 3] = [Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// No hand that holds a device goes farther along an axis in a trial, m; a few millimetres read as metres
/// do.
const FARTHEST_M: f64 = 3.0;
/// No hand is faster, m/s: a pitcher's is at 20.
const FASTEST_M_S: f64 = 30.0;
/// A step of less than this, m, may be noise at a high rate.
const LEAST_STEP_M: f64 = 0.02;
/// No hand pushes harder along an axis, N.
const STRONGEST_N: f64 = 1000.0;
/// An axis that holds one value for as long, s, while another moves, has stopped …
const HELD_S: f64 = 1.0;
/// … as far as this, m: less may be that other's noise.
const MOVED_M: f64 = 0.02;

pub(super) fn doubts(samples: &dyn Columns) -> Vec<Doubt> {
    let mut doubts: Vec<Doubt> = POSITIONS
        .into_iter()
        .filter_map(|axis| too_far(samples, axis).or_else(|| jump(samples, axis)))
        .collect();
    doubts.extend(frozen(samples));
    doubts.extend(FORCES.into_iter().filter_map(|axis| too_strong(samples, axis)));
    doubts.extend(FORCES.into_iter().filter_map(|axis| constant(samples, axis)));
    doubts
}

fn too_far(samples: &dyn Columns, axis: Signal) -> Option<Doubt> {
    let range_m = range(&samples.column(axis)?);
    if range_m <= FARTHEST_M {
        return None;
    }
    let what = format!(
        "it goes over {range_m:.1} m, farther than a hand that holds a device: millimetres taken for metres, or a number \
         that stands for a lost marker?"
    );
    let remedy = "mend unit or scale of the column in the mapping, or leave such rows out with missing = \"drop\"";
    Some(Doubt::new(axis, what, remedy))
}

/// A step that no hand makes between two samples.
fn jump(samples: &dyn Columns, axis: Signal) -> Option<Doubt> {
    let x = samples.column(axis)?;
    let t = samples.column(Signal::Time)?;
    let step_m = |i: usize| (x[i] - x[i - 1]).abs();
    let row = first(1..x.len().min(t.len()), |i| {
        step_m(i) > LEAST_STEP_M && step_m(i) > FASTEST_M_S * (t[i] - t[i - 1])
    })?;
    let what = format!(
        "it jumps by {:.3} m within {:.4} s, which no hand does: a lost marker, or two places of one device?",
        step_m(row),
        t[row] - t[row - 1]
    );
    let remedy = "mend the recording, leave such rows out with missing = \"drop\", or exclude the trial: a jump counts as path";
    Some(Doubt { row: Some(row), ..Doubt::new(axis, what, remedy) })
}

/// An axis that holds one value while another one moves: throughout, unless that is 0, which a planar
/// device may write, or for a second.
fn frozen(samples: &dyn Columns) -> Option<Doubt> {
    let remedy = "look at the marker or the encoder, and at `from` in the mapping; a device without this axis has no such \
                  column: remove it from the mapping";
    for axis in POSITIONS {
        let hold = {
            let Some(x) = samples.column(axis).filter(|x| x.len() >= LEAST_SAMPLES) else {
                continue;
            };
            let Some((from, to)) = longest_hold(&x) else { continue };
            (from, to, x[from], to - from == x.len())
        };
        let (from, to, held, is_whole) = hold;
        let length_s = {
            let Some(t) = samples.column(Signal::Time) else { continue };
            t[to - 1] - t[from]
        };
        if length_s <= HELD_S || (is_whole && held == 0.0) {
            continue;
        }
        let moves = |other: &Signal| {
            let x = samples.column(*other).filter(|_| *other != axis);
            x.is_some_and(|x| range(&x[from..to]) > MOVED_M)
        };
        let Some(other) = POSITIONS.iter().find(|other| moves(other)) else { continue };
        let so_long =
            if is_whole { "throughout".to_owned() } else { format!("for {length_s:.2} s") };
        let what = format!("it is {held} m {so_long}, while {} moves", other.name());
        return Some(Doubt { row: Some(from), ..Doubt::new(axis, what, remedy) });
    }
    None
}

/// The longest stretch of one value: from, and behind its end.
fn longest_hold(values: &[f64]) -> Option<(usize, usize)> {
    let mut longest = (0, 0);
    let mut from = 0;
    for run in values.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
        if run.len() > longest.1 - longest.0 {
            longest = (from, from + run.len());
        }
        from += run.len();
    }
    (longest.1 > longest.0).then_some(longest)
}

fn too_strong(samples: &dyn Columns, axis: Signal) -> Option<Doubt> {
    let force = samples.column(axis)?;
    let row = first(0..force.len(), |i| force[i].abs() > STRONGEST_N)?;
    let what = format!(
        "{:e} N is more than a person weighs: mN taken for N, counts for a force, or a number that stands for a missing value?",
        force[row]
    );
    let remedy = "mend unit or scale of the column in the mapping, or leave such rows empty with missing = \"drop\"";
    Some(Doubt { row: Some(row), ..Doubt::new(axis, what, remedy) })
}

/// An axis of the force that is one value throughout, and not 0, while another changes.
fn constant(samples: &dyn Columns, axis: Signal) -> Option<Doubt> {
    let held = {
        let force = samples.column(axis).filter(|force| force.len() >= LEAST_SAMPLES)?;
        let held = *force.first()?;
        let is_one = force.iter().all(|f| f.to_bits() == held.to_bits());
        (is_one && held != 0.0).then_some(held)?
    };
    let changes = |other: &Signal| {
        let force = samples.column(*other).filter(|_| *other != axis);
        force.is_some_and(|force| range(&force) > 0.0)
    };
    let other = FORCES.iter().find(|other| changes(other))?;
    let what = format!("it is {held} N throughout, while {} changes", other.name());
    let remedy = "look at the sensor and its cable, and at `from` in the mapping; exclude the trial if the signal was lost";
    Some(Doubt::new(axis, what, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;

    /// Two seconds of a circle of 5 cm at 100 Hz about (1, 0.5, 0.2) m, with a force that turns.
    fn circle() -> Samples {
        let t: Vec<f64> = (0..200_u32).map(|i| f64::from(i) / 100.0).collect();
        let mut samples = Samples::default();
        let of = |f: fn(f64) -> f64| t.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        samples.set(Signal::X, of(|t| 1.0 + 0.05 * libm::cos(5.0 * t)));
        samples.set(Signal::Y, of(|t| 0.5 + 0.05 * libm::sin(5.0 * t)));
        samples.set(Signal::Z, of(|t| 0.2 + 0.01 * t));
        samples.set(Signal::ForceX, of(|t| libm::cos(5.0 * t)));
        samples.set(Signal::ForceY, of(|t| libm::sin(5.0 * t)));
        samples.set(Signal::ForceZ, of(|_| 0.0));
        samples.set(Signal::Time, t);
        samples
    }

    #[track_caller]
    fn check(signal: Signal, change: impl Fn(usize, f64) -> f64, expect: &[&str]) {
        let mut samples = circle();
        let values = samples.get(signal).unwrap().iter().enumerate();
        let values = values.map(|(i, v)| change(i, *v)).collect();
        samples.set(signal, values);
        let found: Vec<String> = doubts(&samples).into_iter().map(|doubt| doubt.what).collect();
        assert_eq!(found.len(), expect.len(), "{found:?}");
        for (found, words) in found.iter().zip(expect) {
            assert!(found.contains(words), "{found}");
        }
    }

    #[test]
    fn a_recording_as_it_should_be_raises_no_doubt_and_neither_does_a_planar_one() {
        check(Signal::X, |_, x| x, &[]);
        check(Signal::Z, |_, _| 0.0, &[]);
    }

    #[test]
    fn wrong_units_lost_markers_and_axes_that_stand_still_are_told() {
        check(Signal::X, |_, x| 1000.0 * x, &["millimetres taken for metres"]);
        check(Signal::Y, |i, y| if i == 70 { 0.0 } else { y }, &["it jumps by 0.4"]);
        check(Signal::Z, |_, _| 0.15, &["it is 0.15 m throughout, while x_m moves"]);
        check(Signal::Y, |i, y| if i > 60 { 0.5 } else { y }, &["it is 0.5 m for 1.38 s"]);
        check(Signal::ForceX, |_, f| 5000.0 * f, &["more than a person weighs"]);
        check(Signal::ForceZ, |_, _| 1.5, &["it is 1.5 N throughout, while force_x_n changes"]);
    }
}
