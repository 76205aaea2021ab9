//! The zero of a sensor: a median over a stretch at rest, and whether it was one.

use super::convert::{Zero, median};
use zwidth_numerics::series::ends;

/// The stretch at whose end a sensor is expected to have come to rest, if none is named, s.
const BEGINNING_S: f64 = 0.5;
/// Samples that tell whether a signal rests.
const LEAST: usize = 4;
/// A filter that settles is looked at in so many windows …
const SETTLING: u32 = 5;
/// … of this length at least, s.
const SETTLING_S: f64 = 0.1;
/// A stretch that drifts is told if the drift comes to this share of all that the signal does over the trial.
const DRIFT: f64 = 0.1;
/// A zero is off, or a stretch is not at rest, if it differs by so many times what the values scatter …
const SCATTERS: f64 = 3.0;
/// … and by this share of all that the signal does in the trial.
const SHARE: f64 = 0.05;
/// The standard deviation of a normal distribution in median absolute deviations.
const DEVIATIONS: f64 = 1.482_602_218_505_602;

/// The zero of a sensor in a trial.
#[derive(Debug, Default, PartialEq)]
pub(super) struct SensorZero {
    /// In their unit, as recorded.
    pub(super) value: f64,
    /// The source of the zero in words, for the trial's file.
    pub(super) words: Option<String>,
    /// Why it may not be the zero of the sensor.
    pub(super) doubt: Option<String>,
}

/// The zero of a signal: its values as recorded, at times in s.
///
/// # Errors
/// There is no sample in the stretch that is to be taken.
pub(super) fn find(zero: Zero, t_s: &[f64], x: &[f64]) -> Result<SensorZero, String> {
    match zero {
        Zero::None => Ok(SensorZero::default()),
        Zero::First => Ok(SensorZero {
            value: x.first().copied().unwrap_or(0.0),
            words: None,
            // A filter begins with a value of its own, and settles on that of the samples at rest.
            doubt: settles(t_s, x).or_else(|| steps_off(t_s, x)),
        }),
        Zero::Rest { from_s, to_s } => {
            let stretch = within(t_s, x, from_s, to_s);
            if stretch.is_empty() {
                return Err(format!(
                    "the trial has no sample from {from_s} s to {to_s} s, where its zero is to be taken"
                ));
            }
            let (value, spread) = median_and_deviation(stretch);
            let n = stretch.len();
            let words = format!(
                "{value} as recorded, the median of {n} samples from {from_s} s to {to_s} s, standard deviation {spread:.3e}"
            );
            let doubt = match n < LEAST {
                true => Some(format!(
                    "its zero is taken from {n} samples, from {from_s} s to {to_s} s; one odd value among so few is taken \
                     for it: choose a longer stretch"
                )),
                false => unrest(t_s, stretch, x, from_s, to_s),
            };
            Ok(SensorZero { value, words: Some(words), doubt })
        }
    }
}

/// A signal that moves fastest at its very beginning, and ever more slowly from there on, always one way: a
/// filter that settles.
fn settles(t_s: &[f64], x: &[f64]) -> Option<String> {
    let interval_s = (t_s.last()? - t_s.first()?) / t_s.len() as f64;
    let window_s = SETTLING_S.max(LEAST as f64 * interval_s);
    let middles = (0..SETTLING).map_while(|i| {
        let from_s = f64::from(i) * window_s;
        let window = within(t_s, x, from_s, from_s + window_s);
        (window.len() >= LEAST).then(|| median(window.to_vec()))
    });
    let middles: Vec<f64> = middles.collect();
    let steps: Vec<f64> = middles.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let is_slowing =
        steps.windows(2).all(|pair| pair[0] * pair[1] > 0.0 && pair[1].abs() < pair[0].abs());
    let (first, last) = (steps.first()?, steps.last()?);
    let has_slowed = steps.len() + 1 == SETTLING as usize && last.abs() < first.abs() / 2.0;
    let went = (middles.last()? - x.first()?).abs();
    (is_slowing && has_slowed && went > SHARE * range(x)).then(|| {
        format!(
            "its first value, {}, is taken for its zero, from which it settles as a filter does, to {:.4} within {:.1} s: give a \
             stretch at rest, zero = {{ from_s = …, to_s = … }}",
            x[0],
            middles[middles.len() - 1],
            window_s * f64::from(SETTLING)
        )
    })
}

/// A first value off all that follows.
fn steps_off(t_s: &[f64], x: &[f64]) -> Option<String> {
    let beginning = within(t_s, x, 0.0, BEGINNING_S);
    // Its second half: a filter has come to rest by then.
    let settled = &beginning[beginning.len() / 2..];
    if settled.len() < LEAST {
        return None;
    }
    let first = x.first()?;
    let (usual, _) = median_and_deviation(settled);
    let off = (first - usual).abs();
    let is_odd = off > SCATTERS * range(settled) && off > SHARE * range(x);
    is_odd.then(|| {
        format!(
            "its first value, {first}, is taken for its zero, and it rests at {usual} half a second later: give a stretch at \
             rest, zero = {{ from_s = 0.1, to_s = {BEGINNING_S} }}"
        )
    })
}

/// A stretch in which the signal does not rest.
fn unrest(t_s: &[f64], stretch: &[f64], x: &[f64], from_s: f64, to_s: f64) -> Option<String> {
    if stretch.len() < 2 * LEAST {
        return None;
    }
    let (before, after) = stretch.split_at(stretch.len() / 2);
    let [before, after] = [before, after].map(|half| median(half.to_vec()));
    // What it scatters from one sample to the next, which a slow motion does not change.
    let steps = stretch.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let scatter = DEVIATIONS * median(steps) / std::f64::consts::SQRT_2;
    let drift = (after - before).abs();
    // As far as it would go over the whole trial, if it went on so.
    let whole = drift * 2.0 * (t_s[t_s.len() - 1] - t_s[0]) / (to_s - from_s);
    let drifts =
        drift > SCATTERS * scatter && (drift > SHARE * range(x) || whole > DRIFT * range(x));
    drifts.then(|| {
        format!(
            "its zero is taken from {from_s} s to {to_s} s, where it does not rest: it goes from {before} to {after} (medians \
             of both halves); choose another stretch"
        )
    })
}

/// The values from one time to another after the first.
fn within<'a>(t_s: &[f64], x: &'a [f64], from_s: f64, to_s: f64) -> &'a [f64] {
    let Some(start) = t_s.first() else { return &[] };
    let from = t_s.partition_point(|t| t - start < from_s);
    let to = t_s.partition_point(|t| t - start <= to_s);
    &x[from..to.max(from)]
}

/// The median, and a standard deviation from the median of what the values are off it.
fn median_and_deviation(values: &[f64]) -> (f64, f64) {
    let middle = median(values.to_vec());
    let off = values.iter().map(|value| (value - middle).abs()).collect();
    (middle, DEVIATIONS * median(off))
}

fn range(values: &[f64]) -> f64 {
    let (low, high) = ends(values);
    (high - low).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sensor that rests at 2.3 for a second and is pushed then.
    fn pushed(first: f64) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..100).map(|i| 0.04 * f64::from(i)).collect();
        let noise = |i: usize| 0.01 * f64::from(u8::try_from(i * 7 % 5).unwrap()) - 0.02;
        let mut x: Vec<f64> =
            (0..100).map(|i| 2.3 + noise(i) + 0.1 * (i as f64 - 25.0).max(0.0)).collect();
        x[0] = first;
        (t, x)
    }

    #[test]
    fn a_zero_is_a_median_over_a_stretch_with_its_spread() {
        let (t, x) = pushed(1.15);
        let found = find(Zero::Rest { from_s: 0.0, to_s: 0.5 }, &t, &x).unwrap();
        assert!((found.value - 2.3).abs() < 0.011 && found.doubt.is_none(), "{found:?}");
        assert!(found.words.unwrap().contains("median of 13 samples from 0 s to 0.5 s"));
        let none = find(Zero::Rest { from_s: 9.0, to_s: 9.5 }, &t, &x).unwrap_err();
        assert!(none.contains("no sample from 9 s"), "{none}");
    }

    #[test]
    fn a_stretch_that_does_not_rest_is_told_and_a_first_value_at_rest_is_not() {
        let (t, x) = pushed(1.15);
        let doubt = find(Zero::Rest { from_s: 0.5, to_s: 2.5 }, &t, &x).unwrap().doubt.unwrap();
        assert!(doubt.contains("does not rest"), "{doubt}");
        let (t, x) = pushed(2.29);
        assert_eq!(find(Zero::First, &t, &x).unwrap().doubt, None);
        // A lever that moves at once has no other zero than its first value.
        let moving: Vec<f64> = t.iter().map(|t| 3.0 * t).collect();
        assert_eq!(find(Zero::First, &t, &moving).unwrap().doubt, None);
    }

    #[test]
    fn a_filter_that_settles_a_drift_and_too_few_samples_are_told() {
        let t: Vec<f64> = (0..100).map(|i| 0.04 * f64::from(i)).collect();
        let settling: Vec<f64> = t.iter().map(|t| 2.3 - 2.3 * libm::exp(-t / 0.3)).collect();
        let doubt = find(Zero::First, &t, &settling).unwrap().doubt.unwrap();
        assert!(doubt.contains("settles as a filter does"), "{doubt}");
        // A movement begins slowly.
        let moving: Vec<f64> = t.iter().map(|t| 1.0 - libm::cos(t.min(3.0))).collect();
        assert_eq!(find(Zero::First, &t, &moving).unwrap().doubt, None);
        let drifting: Vec<f64> =
            t.iter().map(|t| 0.3 * t + if *t > 2.0 { 2.0 } else { 0.0 }).collect();
        let rest = Zero::Rest { from_s: 0.0, to_s: 0.5 };
        let doubt = find(rest, &t, &drifting).unwrap().doubt.unwrap();
        assert!(doubt.contains("does not rest"), "{doubt}");
        let one = find(Zero::Rest { from_s: 0.0, to_s: 0.01 }, &t, &moving).unwrap();
        assert!(one.doubt.unwrap().contains("from 1 samples"));
    }
}
