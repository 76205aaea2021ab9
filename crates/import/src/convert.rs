//! Conversion of recorded numbers to ours: a line, a mean, a median.

use zwidth_numerics::order;
pub(super) use zwidth_numerics::series::{central_slope as central, slope};

/// `sign · (scale · (x − zero) + offset)`, where `zero` is the first value, a median or 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Linear {
    /// 1 or −1.
    pub(super) sign: f64,
    /// Of the unit named, in one of theirs.
    pub(super) scale: f64,
    /// In the unit named.
    pub(super) offset: f64,
    /// Subtracted first of all.
    pub(super) zero: Zero,
}

/// The zero that is subtracted from every value of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Zero {
    None,
    /// The first value.
    First,
    /// The median of the values in a stretch, in seconds from the trial's first sample.
    Rest {
        from_s: f64,
        to_s: f64,
    },
}

impl Linear {
    /// Leaves every value as it is, bit for bit: adding −0, unlike 0, keeps the sign of −0.
    pub(super) const IDENTITY: Self =
        Self { sign: 1.0, scale: 1.0, offset: -0.0, zero: Zero::None };

    /// Converts values, less `zero` and times `factor` (that of the unit).
    pub(super) fn apply(&self, values: &mut [f64], factor: f64, zero: f64) {
        for x in values {
            // In the order of `words`, which the files carry: another order would round differently.
            *x = self.sign * (self.scale * (*x - zero) + self.offset) * factor;
        }
    }

    /// Converts a whole column, whose first value is its zero if one is asked for.
    pub(super) fn apply_to_all(&self, values: &mut [f64], factor: f64) {
        let first = values.first().copied().filter(|_| self.zero == Zero::First);
        self.apply(values, factor, first.unwrap_or(0.0));
    }

    /// The conversion in words: `−(0.5 (x − x₀) + 2)`; `None` where it changes nothing.
    #[allow(clippy::float_cmp)] // the neutral values are those that were typed or defaulted
    pub(super) fn words(&self) -> Option<String> {
        if *self == Self::IDENTITY {
            return None;
        }
        let x = match self.zero {
            Zero::None => "x",
            Zero::First => "(x − first x)",
            Zero::Rest { .. } => "(x − x at rest)",
        };
        let scaled = if self.scale == 1.0 { x.to_owned() } else { format!("{} {x}", self.scale) };
        let shifted =
            if self.offset == 0.0 { scaled } else { format!("({scaled} + {})", self.offset) };
        Some(if self.sign < 0.0 { format!("−{shifted}") } else { shifted })
    }
}

/// The arithmetic mean, summed in order.
#[allow(clippy::cast_precision_loss)]
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The median; 0 of none.
pub(super) fn median(values: Vec<f64>) -> f64 {
    order::median(values).unwrap_or(0.0)
}

#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_applied_in_the_order_that_is_written_down() {
        let line = Linear { sign: -1.0, scale: 2.0, offset: 1.0, zero: Zero::First };
        let mut values = [10.0, 11.0];
        line.apply(&mut values, 0.5, 10.0);
        assert_eq!(values, [-0.5, -1.5]);
        assert_eq!(line.words().unwrap(), "−(2 (x − first x) + 1)");
    }

    #[test]
    fn the_identity_keeps_every_bit() {
        let mut values = [-0.0, 0.0, 1e-321, 0.1];
        let bits = values.map(f64::to_bits);
        Linear::IDENTITY.apply(&mut values, 1.0, 0.0);
        assert_eq!(values.map(f64::to_bits), bits);
        assert_eq!(Linear::IDENTITY.words(), None);
    }
}
