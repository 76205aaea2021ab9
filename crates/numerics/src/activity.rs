//! When a signal is active: a two-threshold (Schmitt) switch over a sampled signal.

/// From where to where a signal is active; indices of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Activity {
    /// First sample with |v| above the upper threshold.
    pub onset: usize,
    /// First sample with |v| below the lower threshold after the last one above the upper; `None`
    /// where the series ends while the signal is still active.
    pub end: Option<usize>,
}

/// The activity of `v`: it switches on where |v| > `on`, off where |v| < `off`, and lasts from the
/// first switching on to the last switching off, so that a pause in between (a reversal, with `v` a
/// velocity) belongs to it. Noise between the thresholds neither begins nor prolongs it. `None` if
/// |v| never exceeds `on`. Unit of `on` and `off` as `v`; `off` is at most `on`.
pub fn activity(v: &[f64], on: f64, off: f64) -> Option<Activity> {
    let onset = v.iter().position(|v| v.abs() > on)?;
    let last = v.iter().rposition(|v| v.abs() > on)?;
    let after = v[last..].iter().position(|v| v.abs() < off);
    Some(Activity { onset, end: after.map(|i| last + i) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(v: &[f64], expect: Option<(usize, Option<usize>)>) {
        assert_eq!(
            activity(v, 0.5, 0.2),
            expect.map(|(onset, end)| Activity { onset, end }),
            "{v:?}"
        );
    }

    #[test]
    fn a_pause_belongs_to_the_activity_and_noise_after_it_does_not() {
        check(&[0.0, 0.6, 0.1, 0.0, -0.7, -0.3, -0.1, 0.4, 0.0], Some((1, Some(6))));
    }

    #[test]
    fn a_signal_that_never_exceeds_the_threshold_is_never_active() {
        check(&[0.0, 0.5, -0.5], None);
        check(&[], None);
    }

    #[test]
    fn a_series_that_stops_while_active_has_no_end() {
        check(&[0.0, -0.6, 0.3, 0.2], Some((1, None)));
    }
}
