//! Inputs (5)–(7) and recorded series, as spans in each of which x¨ = −ω² (x − mean): ω = 0 is a
//! straight line, and a sine is exact.

use std::f64::consts::{FRAC_PI_2, TAU};

use serde::{Deserialize, Serialize};

use super::numbers;
use crate::error::{Result, check, finite, not_negative, positive};

/// A recorded signal: straight lines between its samples (first-order hold), constant after the
/// last.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Sample times, s; increasing, uneven steps allowed; two equal times are a jump.
    pub t_s: Vec<f64>,
    /// Values, N for a force, rad for a displacement.
    pub value: Vec<f64>,
}

/// A signal of time. The magnitudes of (5)–(7) push into the object: the thesis' minus in (7) is
/// dropped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Input {
    /// value + rate · t.
    Line {
        /// Value at t = 0.
        value: f64,
        /// Change per second.
        #[serde(default)]
        rate: f64,
    },
    /// (5): 2a and 0 in turn, each for a quarter of the period, the first instant of each its own.
    /// A run that ends with a period ends at 0, as (5) has it, for what begins at the last
    /// sample lies beyond the run.
    Step {
        /// a.
        magnitude: f64,
        /// T, s.
        period_s: f64,
    },
    /// (6): 0 → 2a → 0 → 2a → 0 in straight lines over the period.
    Ramp {
        /// a.
        magnitude: f64,
        /// T, s.
        period_s: f64,
    },
    /// (7): a + a sin(ω t).
    Sine {
        /// a.
        magnitude: f64,
        /// ω, rad/s; π/2 in the thesis.
        omega_rad_s: f64,
    },
    /// A recorded signal.
    Series(Series),
}

/// From `t_s` on the signal starts at `value` with `rate`, and x¨ = −ω² (x − mean).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    /// End of the span, s; infinite for the last.
    pub(crate) end_s: f64,
    /// Start of the span, s.
    pub(crate) start_s: f64,
    /// Value at the start.
    pub(crate) value: f64,
    /// Rate at the start, 1/s.
    pub(crate) rate: f64,
}

impl Input {
    /// (5) with the thesis' T = 4 s.
    #[cfg(test)]
    pub(crate) fn step(magnitude: f64) -> Self {
        Self::Step { magnitude, period_s: super::numbers::DURATION_S }
    }

    /// (6) with the thesis' T = 4 s.
    #[cfg(test)]
    pub(crate) fn ramp(magnitude: f64) -> Self {
        Self::Ramp { magnitude, period_s: super::numbers::DURATION_S }
    }

    /// (7) with the thesis' π/2 rad/s.
    pub fn sine(magnitude: f64) -> Self {
        Self::Sine { magnitude, omega_rad_s: FRAC_PI_2 }
    }

    /// The same value for ever.
    pub fn constant(value: f64) -> Self {
        Self::Line { value, rate: 0.0 }
    }

    /// ω and the mean value about which the signal swings; both 0 unless it is a sine.
    pub(crate) fn swing(&self) -> (f64, f64) {
        match *self {
            Self::Sine { magnitude, omega_rad_s } => (omega_rad_s, magnitude),
            _ => (0.0, 0.0),
        }
    }

    /// The period with which the signal repeats, s; none for one that does not, or is constant.
    pub(crate) fn period_s(&self) -> Option<f64> {
        match *self {
            Self::Line { .. } | Self::Series(_) => None,
            // Both say the same twice in T.
            Self::Step { magnitude, period_s } | Self::Ramp { magnitude, period_s } => {
                (magnitude > 0.0).then_some(0.5 * period_s)
            }
            Self::Sine { magnitude, omega_rad_s } => {
                (magnitude > 0.0 && omega_rad_s > 0.0).then(|| TAU / omega_rad_s)
            }
        }
    }

    /// Adds name, value and usual size of each parameter of the signal `name`, whose own usual size
    /// is `usual`. A series' largest value stands for it.
    pub(crate) fn list(&self, name: &str, usual: f64, list: &mut Vec<(String, f64, f64)>) {
        /// ω of the thesis' sine, rad/s.
        const OMEGA_RAD_S: f64 = FRAC_PI_2;
        let period = numbers::DURATION_S;
        let mut push = |field: &str, value: f64, usual: f64| {
            list.push((format!("{name}.{field}"), value, usual));
        };
        match self {
            Self::Line { value, rate } => {
                push("line.value", *value, usual);
                push("line.rate", *rate, usual);
            }
            Self::Step { magnitude, period_s } => {
                push("step.magnitude", *magnitude, usual);
                push("step.period_s", *period_s, period);
            }
            Self::Ramp { magnitude, period_s } => {
                push("ramp.magnitude", *magnitude, usual);
                push("ramp.period_s", *period_s, period);
            }
            Self::Sine { magnitude, omega_rad_s } => {
                push("sine.magnitude", *magnitude, usual);
                push("sine.omega_rad_s", *omega_rad_s, OMEGA_RAD_S);
            }
            Self::Series(series) => {
                let sizes = series.value.iter().enumerate();
                if let Some((i, value)) = sizes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) {
                    push(&format!("series.value[{i}]"), *value, usual);
                }
            }
        }
    }

    /// Span number `i`; beyond the last one the last is repeated.
    pub(crate) fn span(&self, i: usize) -> Span {
        match self {
            Self::Line { value, rate } => endless(*value, *rate),
            Self::Sine { magnitude, omega_rad_s } => endless(*magnitude, magnitude * omega_rad_s),
            Self::Step { magnitude, period_s } => {
                quarter(i, *period_s, [2.0 * magnitude, 0.0], [0.0, 0.0])
            }
            Self::Ramp { magnitude, period_s } => {
                let rate = 8.0 * magnitude / period_s;
                quarter(i, *period_s, [0.0, 2.0 * magnitude], [rate, -rate])
            }
            Self::Series(series) => series.span(i),
        }
    }

    /// Number of a span that does not end after the one that holds at `t`, not below `number`: a
    /// start for the search of that one, so that short periods do not make it long.
    pub(crate) fn number_near(&self, t: f64, number: usize) -> usize {
        match self {
            Self::Step { period_s, .. } | Self::Ramp { period_s, .. } => {
                // One less, since rounding may put the quotient a span too far.
                number.max(((4.0 * t / period_s) as usize).saturating_sub(1))
            }
            _ => number,
        }
    }

    /// Value and rate at `t` seconds, within `span`.
    pub(crate) fn at(&self, span: &Span, t: f64) -> [f64; 2] {
        let (omega, mean) = self.swing();
        let dt = t - span.start_s;
        if omega > 0.0 {
            let (sine, cosine) = libm::sincos(omega * dt);
            let offset = span.value - mean;
            let quick = span.rate / omega;
            return [
                mean + offset * cosine + quick * sine,
                omega * (quick * cosine - offset * sine),
            ];
        }
        [span.value + span.rate * dt, span.rate]
    }

    pub(crate) fn check(&self, name: &str, duration_s: f64) -> Result<()> {
        /// More periods than this in a run could not be distinguished in time.
        const MOST_PERIODS: f64 = 1e9;
        match self {
            Self::Line { value, rate } => {
                finite(format_args!("{name}.value"), *value)?;
                finite(format_args!("{name}.rate"), *rate)
            }
            Self::Step { magnitude, period_s } | Self::Ramp { magnitude, period_s } => {
                not_negative(format_args!("{name}.magnitude"), *magnitude)?;
                let slow = *period_s * MOST_PERIODS >= duration_s;
                let allowed = "finite and at least a billionth of duration_s";
                let ok = slow && period_s.is_finite();
                check(format_args!("{name}.period_s"), *period_s, ok, allowed)
            }
            Self::Sine { magnitude, omega_rad_s } => {
                not_negative(format_args!("{name}.magnitude"), *magnitude)?;
                positive(format_args!("{name}.omega_rad_s"), *omega_rad_s)
            }
            Self::Series(series) => series.check(name),
        }
    }
}

/// The only span of a signal that has one.
fn endless(value: f64, rate: f64) -> Span {
    Span { start_s: 0.0, end_s: f64::INFINITY, value, rate }
}

/// Quarter `i` of a period: even quarters start at the first of the pairs, odd ones at the second.
fn quarter(i: usize, period_s: f64, values: [f64; 2], rates: [f64; 2]) -> Span {
    // Both from the number, not one from the other: sums of quarters would drift.
    let [start_s, end_s] = [i, i + 1].map(|k| k as f64 * period_s / 4.0);
    Span { start_s, end_s, value: values[i % 2], rate: rates[i % 2] }
}

impl Series {
    fn span(&self, i: usize) -> Span {
        let last = self.t_s.len() - 1;
        if i >= last {
            let start_s = self.t_s[last];
            let value = self.value[last];
            return Span { start_s, end_s: f64::INFINITY, value, rate: 0.0 };
        }
        let start_s = self.t_s[i];
        let end_s = self.t_s[i + 1];
        let step = end_s - start_s;
        // Two equal times are a jump: nothing lies in the span between them, and it needs no rate.
        let rate = if step > 0.0 { (self.value[i + 1] - self.value[i]) / step } else { 0.0 };
        Span { start_s, end_s, value: self.value[i], rate }
    }

    fn check(&self, name: &str) -> Result<()> {
        let counts = (self.t_s.len() as f64, self.value.len() as f64);
        check(format_args!("{name}.series.t_s.len()"), counts.0, counts.0 > 0.0, "at least 1")?;
        let same = self.t_s.len() == self.value.len();
        check(format_args!("{name}.series.value.len()"), counts.1, same, "the number of times")?;
        for (i, (&t, &value)) in self.t_s.iter().zip(&self.value).enumerate() {
            let in_order = if i == 0 { t <= 0.0 } else { t >= self.t_s[i - 1] };
            if in_order && t.is_finite() && value.is_finite() {
                continue; // a fit checks a recorded series at every run: names are made for what is wrong alone
            }
            let time = format_args!("{name}.series.t_s[{i}]");
            finite(time, t)?;
            finite(format_args!("{name}.series.value[{i}]"), value)?;
            check(time, t, in_order, "0 at first, then never running backwards")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(input: &Input, t: f64) -> f64 {
        let mut i = 0;
        while input.span(i).end_s <= t {
            i += 1;
        }
        input.at(&input.span(i), t)[0]
    }

    fn check(input: &Input, points: &[(f64, f64)]) {
        for &(t, expect) in points {
            let found = value(input, t);
            assert!(
                (found - expect).abs() < 1e-14,
                "{input:?} at {t}: {found} instead of {expect}"
            );
        }
    }

    #[test]
    fn the_inputs_are_the_magnitudes_of_equations_5_to_7() {
        check(&Input::step(2.0), &[(0.0, 4.0), (0.99, 4.0), (1.0, 0.0), (2.5, 4.0), (3.5, 0.0)]);
        check(
            &Input::ramp(2.0),
            &[(0.0, 0.0), (0.5, 2.0), (1.0, 4.0), (1.75, 1.0), (2.5, 2.0), (3.75, 1.0)],
        );
        check(&Input::sine(2.0), &[(0.0, 2.0), (1.0, 4.0), (2.0, 2.0), (3.0, 0.0)]);
    }

    #[test]
    fn a_series_is_held_in_straight_lines_over_uneven_steps_and_jumps_at_equal_times() {
        let series = Series { t_s: vec![0.0, 1.0, 1.0, 4.0], value: vec![0.0, 2.0, 5.0, 8.0] };
        check(&Input::Series(series), &[(0.5, 1.0), (1.0, 5.0), (3.0, 7.0), (9.0, 8.0)]);
    }

    #[test]
    fn time_that_runs_backwards_is_named() {
        let input = Input::Series(Series { t_s: vec![0.0, 2.0, 1.0], value: vec![0.0; 3] });
        let error = input.check("input", 4.0).unwrap_err().to_string();
        assert!(error.contains("input.series.t_s[2] is 1"), "{error}");
    }
}
