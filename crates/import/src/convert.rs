//! From their numbers to ours: a line, a derivative, an integral, a mean.

/// `sign · (scale · (x − first) + offset)`, where `first` is the first value or 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Linear {
    /// 1 or −1.
    pub(super) sign: f64,
    /// Of the unit named, in one of theirs.
    pub(super) scale: f64,
    /// In the unit named.
    pub(super) offset: f64,
    /// Whether the first value is subtracted.
    pub(super) zero_first: bool,
}

impl Linear {
    /// Leaves every value as it is, bit for bit: adding −0, unlike 0, keeps the sign of −0.
    pub(super) const IDENTITY: Self =
        Self { sign: 1.0, scale: 1.0, offset: -0.0, zero_first: false };

    /// Converts `values`, and multiplies them by `factor` (that of the unit).
    pub(super) fn apply(&self, values: &mut [f64], factor: f64) {
        let first = values.first().copied().unwrap_or(0.0);
        self.apply_from(values, factor, first);
    }

    /// [`Linear::apply`] to a part of a column whose first value is `first`.
    pub(super) fn apply_from(&self, values: &mut [f64], factor: f64, first: f64) {
        let first = if self.zero_first { first } else { 0.0 };
        for x in values {
            *x = self.sign * (self.scale * (*x - first) + self.offset) * factor;
        }
    }

    /// The conversion in words: `−(0.5 (x − x₀) + 2)`; `None` where it changes nothing.
    #[allow(clippy::float_cmp)] // the neutral values are those that were typed or defaulted
    pub(super) fn words(&self) -> Option<String> {
        if *self == Self::IDENTITY {
            return None;
        }
        let x = if self.zero_first { "(x − first x)" } else { "x" };
        let scaled = if self.scale == 1.0 { x.to_owned() } else { format!("{} {x}", self.scale) };
        let shifted =
            if self.offset == 0.0 { scaled } else { format!("({scaled} + {})", self.offset) };
        Some(if self.sign < 0.0 { format!("−{shifted}") } else { shifted })
    }
}

/// dx/dt by central differences, second order on uneven times too; one-sided at both ends.
///
/// Fornberg, Math. Comp. 51 (1988) 699: with steps h before and k after a sample,
/// (h² x₊ + (k² − h²) x − k² x₋) / (h k (h + k)). At least two samples, t increasing.
pub(super) fn derivative(t: &[f64], x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let step = |i: usize| (x[i + 1] - x[i]) / (t[i + 1] - t[i]);
    (0..n)
        .map(|i| match i {
            0 => step(0),
            _ if i == n - 1 => step(n - 2),
            _ => {
                let (h, k) = (t[i] - t[i - 1], t[i + 1] - t[i]);
                (h * h * x[i + 1] + (k * k - h * h) * x[i] - k * k * x[i - 1]) / (h * k * (h + k))
            }
        })
        .collect()
}

/// ∫ x dt from the first sample, where it is 0, by the trapezoidal rule.
pub(super) fn integral(t: &[f64], x: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    (0..x.len())
        .map(|i| {
            if i > 0 {
                sum += 0.5 * (x[i] + x[i - 1]) * (t[i] - t[i - 1]);
            }
            sum
        })
        .collect()
}

/// The arithmetic mean, summed in order.
#[allow(clippy::cast_precision_loss)]
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_applied_in_the_order_that_is_written_down() {
        let line = Linear { sign: -1.0, scale: 2.0, offset: 1.0, zero_first: true };
        let mut values = [10.0, 11.0];
        line.apply(&mut values, 0.5);
        assert_eq!(values, [-0.5, -1.5]);
        assert_eq!(line.words().unwrap(), "−(2 (x − first x) + 1)");
    }

    #[test]
    fn the_identity_keeps_every_bit() {
        let mut values = [-0.0, 0.0, 1e-321, 0.1];
        let bits = values.map(f64::to_bits);
        Linear::IDENTITY.apply(&mut values, 1.0);
        assert_eq!(values.map(f64::to_bits), bits);
        assert_eq!(Linear::IDENTITY.words(), None);
    }

    #[test]
    fn the_derivative_of_a_parabola_is_exact_inside_on_uneven_times() {
        let t = [0.0, 0.5, 2.0, 2.25];
        let x = t.map(|t| 3.0 * t * t - t);
        assert_eq!(derivative(&t, &x)[1..3], [2.0, 11.0]);
        assert_eq!(derivative(&t, &x)[0], 0.5);
    }

    #[test]
    fn the_integral_of_a_ramp_is_exact_and_begins_at_zero() {
        let t = [1.0, 1.5, 3.0];
        assert_eq!(integral(&t, &t.map(|t| 2.0 * t)), [0.0, 1.25, 8.0]);
    }

    #[test]
    fn the_derivative_of_the_integral_is_the_signal_on_smooth_data() {
        let t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-3).collect();
        let x: Vec<f64> = t.iter().map(|t| libm::sin(6.0 * t)).collect();
        let again = derivative(&t, &integral(&t, &x));
        let worst = (1..999).map(|i| (again[i] - x[i]).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-5, "{worst}");
    }
}
