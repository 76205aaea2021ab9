//! Numbers in twice the working precision.
//!
//! Each is an unevaluated sum of two doubles (Dekker, Numer. Math. 18 (1971) 224–242; Hida, Li &
//! Bailey 2001): some 32 digits from additions and multiplications alone, so the same bits on any
//! machine.

use std::ops::{Add, Div, Mul, Sub};

/// `high + low`, where `high` is the sum rounded to a double. Relative error of an operation: about
/// 1e-31.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pair {
    /// The number, rounded.
    pub high: f64,
    /// What rounding took away.
    pub low: f64,
}

impl Pair {
    /// 0.
    pub(crate) const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// `high + low` for |low| well below |high|.
    #[inline]
    fn joined(high: f64, low: f64) -> Self {
        let total = high + low;
        Self { high: total, low: low - (total - high) }
    }

    /// `a b` without loss.
    #[inline]
    pub(super) fn product(a: f64, b: f64) -> Self {
        /// 2^27 + 1 splits 53 digits in two halves (Veltkamp).
        const SPLITTER: f64 = 134_217_729.0;
        let [[ah, al], [bh, bl]] = [a, b].map(|x| {
            let c = SPLITTER * x;
            let high = c - (c - x);
            [high, x - high]
        });
        let high = a * b;
        Self { high, low: ((ah * bh - high) + ah * bl + al * bh) + al * bl }
    }
}

impl From<f64> for Pair {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Pair {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        // The rounding error of the sum of the high parts (Knuth).
        let high = self.high + other.high;
        let from_other = high - self.high;
        let error = (self.high - (high - from_other)) + (other.high - from_other);
        Self::joined(high, error + (self.low + other.low))
    }
}

impl Sub for Pair {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for Pair {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let Self { high, low } = Self::product(self.high, other.high);
        Self::joined(high, low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Pair {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.high / other.high;
        let rest = self - other * Self::from(quotient);
        Self::joined(quotient, rest.high / other.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_product_loses_is_kept() {
        // By rational arithmetic: the square of the double nearest to 0.1, less that square as a
        // double.
        assert_eq!(
            Pair::product(0.1, 0.1).low.to_bits(),
            (-8.326_672_684_688_674e-19_f64).to_bits()
        );
    }

    #[test]
    fn a_quotient_has_the_digits_of_the_fraction() {
        // Python: x = Fraction(0.3) / Fraction(0.005); float(x), float(x - Fraction(float(x)));
        // with doubles for both.
        let quotient = Pair::from(0.3) / Pair::from(0.005);
        assert_eq!(quotient.high.to_bits(), 60.0_f64.to_bits());
        assert!(
            (quotient.low / -3.469_446_951_953_614e-15 - 1.0).abs() < 1e-15,
            "{}",
            quotient.low
        );
    }

    #[test]
    fn what_is_done_is_undone_to_31_digits() {
        let (a, b) = (Pair::from(0.1) / Pair::from(7.0), Pair::from(0.3) * Pair::from(1e-9));
        for back in [(a + b) - b, (a * b) / b, (a / b) * b] {
            let error = back - a;
            assert!((error.high / a.high).abs() < 1e-30, "{error:?}");
        }
    }
}
