//! A slow sensor's values at the times at which they were new.

/// New values of a sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Updates {
    /// When each was taken, s, rising.
    pub t: Vec<f64>,
    /// What each was.
    pub values: Vec<f64>,
}

/// Finds the updates of a signal that is held between them: an age grows with the clock until a new
/// value comes. A value of age a at time t was taken at t − a. All three are equally long; times in
/// s.
pub fn updates(t: &[f64], values: &[f64], age: &[f64]) -> Updates {
    let mut updates = Updates { t: Vec::new(), values: Vec::new() };
    // A new value came with a sample if the age did not grow as the clock did.
    let is_new = |i: &usize| match i.checked_sub(1) {
        // Half of the interval as margin: the age is stored in single precision.
        Some(before) => age[*i] < age[before] + (t[*i] - t[before]) / 2.0,
        None => true,
    };
    for i in (0..t.len()).filter(is_new) {
        let taken = t[i] - age[i];
        // Rounded ages can put a value before the last one, and interpolation needs rising times.
        if updates.t.last().is_none_or(|last| taken > *last) {
            updates.t.push(taken);
            updates.values.push(values[i]);
        }
    }
    updates
}

impl Updates {
    /// The signal at times `t`, rising as the updates do: straight lines between updates, the last
    /// value before the first and after the last of them. A held value lags behind by half of the
    /// sensor's interval on average, and so turns an elastic spring into one that gives more than it
    /// gets.
    pub fn at(&self, t: &[f64]) -> Vec<f64> {
        let last = self.values.last().copied().unwrap_or(0.0);
        let mut interpolated = Vec::with_capacity(t.len());
        let mut before: Option<(f64, f64)> = None;
        for (taken, value) in self.t.iter().copied().zip(self.values.iter().copied()) {
            // The times on the line that ends here.
            let here = t[interpolated.len()..].iter().take_while(|at| **at < taken);
            let slope = before.map(|(t0, y0)| (value - y0) / (taken - t0));
            interpolated.extend(here.map(|at| match before.zip(slope) {
                Some(((t0, y0), slope)) => y0 + (at - t0) * slope,
                None => last,
            }));
            // An update's own time: arithmetic would blur its value.
            let own = t.get(interpolated.len()).filter(|at| **at <= taken);
            interpolated.extend(own.map(|_| value));
            before = Some((taken, value));
        }
        interpolated.resize(t.len(), last);
        interpolated
    }
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
        let values: Vec<f64> = t.iter().map(|t| 3.0 * taken(*t)).collect();
        let age: Vec<f64> = t.iter().map(|t| f64::from((t - taken(*t)) as f32)).collect();
        let found = updates(&t, &values, &age);
        assert_eq!(found.t.len(), 81);
        for (t, value) in t.iter().zip(found.at(&t)).filter(|(t, _)| **t < 0.985) {
            assert!((value - 3.0 * t).abs() < 1e-6, "{value} at {t} s");
        }
        assert_eq!(found.at(&[2.0]), [values[999]]);
    }

    #[test]
    fn between_updates_there_are_straight_lines_and_beyond_them_the_last_value() {
        let found = Updates { t: vec![1.0, 2.0, 2.5, 4.0], values: vec![3.0, 5.0, 4.0, 7.0] };
        let t = [0.0, 0.5, 1.0, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 4.5];
        assert_eq!(found.at(&t), [7.0, 7.0, 3.0, 4.0, 4.5, 5.0, 4.0, 5.0, 7.0, 7.0]);
        assert_eq!(found.at(&[]), []);
        assert_eq!(Updates::default().at(&[1.0, 2.0]), [0.0; 2]);
    }

    #[test]
    fn a_sensor_as_fast_as_the_samples_is_new_at_each() {
        let found = updates(&[0.0, 1.0, 2.0], &[5.0, 5.0, 6.0], &[0.0, 0.0, 0.0]);
        assert_eq!((found.t, found.values), (vec![0.0, 1.0, 2.0], vec![5.0, 5.0, 6.0]));
    }
}
