//! The user's force as the model's input: at the times at which the sensor gave new values.

use zwidth_dynamics::Series;
use zwidth_numerics::series::interpolate;
use zwidth_numerics::updates::{Updates, updates};

/// The force as straight lines between its sensor's updates, from t = 0 on. After the last update
/// its value is held. Without ages each sample is an update. `t` starts at 0.
pub(crate) fn input(t: &[f64], force: &[f64], age: Option<&[f64]>) -> Series {
    let Some(age) = age else { return Series { t_s: t.to_vec(), value: force.to_vec() } };
    let Updates { t, values } = updates(t, force, age);
    // An age puts the first update before 0 or after it: before, the series is cut at 0; after, the
    // first value holds until then.
    let is_late = t.first().is_none_or(|t| *t > 0.0);
    let outside = if is_late { values.first() } else { values.last() };
    let at_zero = interpolate(&t, &values, 0.0).or(outside.copied()).unwrap_or(0.0);
    let mut series = Series { t_s: vec![0.0], value: vec![at_zero] };
    for (t, value) in t.iter().zip(&values).filter(|(t, _)| **t > 0.0) {
        series.t_s.push(*t);
        series.value.push(*value);
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 3 N/s sampled 1000 times a second by a sensor of 80 a second, whose values arrive
    /// 2 ms late.
    #[test]
    fn a_held_ramp_becomes_a_ramp_again() {
        let t: Vec<f64> = (0..1000).map(|i| f64::from(i) / 1000.0).collect();
        let taken = |t: f64| ((t - 0.002) * 80.0).floor() / 80.0;
        let force: Vec<f64> = t.iter().map(|t| 3.0 * taken(*t)).collect();
        let age: Vec<f64> = t.iter().map(|t| f64::from((t - taken(*t)) as f32)).collect();
        let input = input(&t, &force, Some(&age));
        assert_eq!(input.t_s[0].to_bits(), 0.0_f64.to_bits());
        for (t, value) in input.t_s.iter().zip(&input.value) {
            assert!((value - 3.0 * t).abs() < 1e-6, "{value} at {t} s");
        }
        assert_eq!(input.t_s.len(), 80);
    }

    #[test]
    fn before_the_first_update_its_value_holds() {
        let input = input(&[0.0, 1.0, 2.0], &[5.0, 6.0, 7.0], Some(&[-0.5, -0.25, 0.0]));
        assert_eq!((input.t_s, input.value), (vec![0.0, 0.5, 1.25, 2.0], vec![5.0, 5.0, 6.0, 7.0]));
    }

    #[test]
    fn without_ages_every_sample_counts() {
        let input = input(&[0.0, 1.0], &[5.0, 5.0], None);
        assert_eq!((input.t_s, input.value), (vec![0.0, 1.0], vec![5.0, 5.0]));
    }
}
