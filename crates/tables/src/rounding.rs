//! Numbers as people read them: rounded by their uncertainty.

/// Significant digits of an uncertainty (GUM, JCGM 100:2008, 7.2.6).
const UNCERTAINTY_DIGITS: usize = 2;
/// Significant digits of a number of unknown uncertainty.
const PLAIN_DIGITS: usize = 4;
/// An uncertainty smaller than this share of its number is a residue of arithmetic: nothing is
/// measured that well.
const RESIDUE: f64 = 1e-9;
/// From 10 to this power on, a number is shown with a power of ten.
const LARGE: i32 = 6;
/// A number whose last digit stands below 10 to this power is shown with a power of ten.
const SMALL: i32 = -7;
/// Of a p value below this, only that is said (American Psychological Association, Numbers and
/// Statistics Guide, 7th edition).
const SMALLEST_P: f64 = 0.001;

/// A rounded number: `mantissa × 10^exponent`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Decimal {
    /// Whether what is shown lies below it: `< 0.001`.
    pub(crate) below: bool,
    /// Digits with a point and an ASCII sign: `-12.30`.
    pub(crate) mantissa: String,
    /// The power of ten, where one is used.
    pub(crate) exponent: Option<i32>,
}

impl Decimal {
    fn new(mantissa: String, exponent: Option<i32>) -> Self {
        // What is rounded to nothing has no sign any more.
        let zero = !mantissa.contains(|c| matches!(c, '1'..='9'));
        let mantissa = if zero { mantissa.trim_start_matches('-').to_owned() } else { mantissa };
        Self { below: false, mantissa, exponent }
    }

    /// A whole number, all its digits.
    pub(crate) fn integer(value: i64) -> Self {
        Self::new(value.to_string(), None)
    }

    /// A p value: `0.0123`, or `< 0.001`. None is 0, though a double may hold no smaller one.
    pub(crate) fn p_value(value: f64) -> Self {
        let below = value < SMALLEST_P;
        Self { below, ..rounded(if below { SMALLEST_P } else { value }, None, None) }
    }

    /// For programs: `-1.23e-7`, `<0.001`.
    pub(crate) fn ascii(&self) -> String {
        let power = self.exponent.map(|e| format!("e{e}")).unwrap_or_default();
        format!("{}{}{power}", if self.below { "<" } else { "" }, self.mantissa)
    }

    /// For people: `−1.23 × 10⁻⁷`, `< 0.001`, with spaces that do not break.
    pub(crate) fn typeset(&self) -> String {
        let below = if self.below { "<\u{a0}" } else { "" };
        let power = self.exponent.map(|e| format!("\u{a0}×\u{a0}10{}", raised(e)));
        format!("{below}{}{}", self.mantissa.replace('-', "−"), power.unwrap_or_default())
    }
}

/// A number as people read it: to the digits its `uncertainty` allows (same unit), or to four where
/// that is not known.
pub fn number(value: f64, uncertainty: Option<f64>) -> String {
    rounded(value, uncertainty, None).typeset()
}

/// What follows `p` in a sentence: `= 0.0123`, or `< 0.001`.
pub fn p_value(value: f64) -> String {
    let p = Decimal::p_value(value);
    format!("{} {}", if p.below { "<" } else { "=" }, p.mantissa)
}

fn raised(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let letters = exponent.to_string();
    letters.chars().map(|c| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])).collect()
}

/// `value` to so many significant `digits`; without these to the digits its `uncertainty` allows (same
/// unit), or to four where that is not known or nothing.
pub(crate) fn rounded(value: f64, uncertainty: Option<f64>, digits: Option<usize>) -> Decimal {
    if let Some(digits) = digits {
        return at_place(value, last_place(value, digits));
    }
    if let Some(u) = uncertainty.filter(|u| *u > RESIDUE * value.abs()) {
        return at_place(value, last_place(u, UNCERTAINTY_DIGITS));
    }
    let place = last_place(value, PLAIN_DIGITS);
    let whole = leading_power(value, PLAIN_DIGITS) < LARGE;
    // Below a million no digit before the point is rounded away.
    let shown = at_place(value, if whole { place.min(0) } else { place });
    // −0 + 0 is 0, and what is shown has lost that sign too.
    let is_exact = shown.ascii().parse::<f64>().is_ok_and(|v| v.total_cmp(&(value + 0.0)).is_eq());
    if is_exact && shown.mantissa.contains('.') {
        let mantissa = shown.mantissa.trim_end_matches('0').trim_end_matches('.');
        return Decimal::new(mantissa.to_owned(), shown.exponent);
    }
    shown
}

/// The power of ten of the last of `digits` significant digits.
fn last_place(value: f64, digits: usize) -> i32 {
    leading_power(value, digits) - digits as i32 + 1
}

/// The power of ten of the first digit of `value`, once it is rounded to `digits`; 0 for 0.
fn leading_power(value: f64, digits: usize) -> i32 {
    // From the text, not by a logarithm, which may be off by one at a power of ten.
    power_of(&format!("{value:.*e}", digits - 1))
}

fn power_of(scientific: &str) -> i32 {
    scientific.rsplit('e').next().and_then(|power| power.parse().ok()).unwrap_or(0)
}

/// `value` rounded to a multiple of 10^place (ties of the exact binary value to even).
fn at_place(value: f64, place: i32) -> Decimal {
    // From the first digit of `value` as it is, not yet rounded.
    let digits = usize::try_from(power_of(&format!("{value:e}")) - place + 1).unwrap_or(0);
    // Rounding may carry: 9.96 to a tenth is 10.0, and has a digit more.
    let power = if digits == 0 { place } else { leading_power(value, digits) };
    if place >= SMALL && power < LARGE {
        let decimals = match place {
            ..=0 => format!("{value:.*}", place.unsigned_abs() as usize),
            // No overflow: `place` is at most `power`, and so less than 6.
            _ => {
                let step = f64::from(10_i32.pow(place.unsigned_abs()));
                format!("{:.0}", (value / step).round_ties_even() * step)
            }
        };
        return Decimal::new(decimals, None);
    }
    if digits == 0 && value.abs() > 0.5 * 10.0_f64.powi(place) {
        let sign = if value < 0.0 { "-" } else { "" };
        return Decimal::new(format!("{sign}1"), Some(place));
    }
    if digits == 0 || value.abs() <= 0.0 {
        return Decimal::new("0".to_owned(), None);
    }
    let text = format!("{value:.*e}", power.abs_diff(place) as usize);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    Decimal::new(mantissa.to_owned(), exponent.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_are_asked_for_are_kept_whatever_is_known() {
        for (value, digits, expect) in [
            (0.012_345, 3, "0.0123"),
            (0.5, 3, "0.500"),
            (9.996, 3, "10.0"),
            (1234.5, 2, "1200"),
            (-0.0, 3, "0.00"),
            (1.5e9, 3, "1.50e9"),
            (-2.4e-9, 1, "-2e-9"),
        ] {
            assert_eq!(rounded(value, Some(0.1), Some(digits)).ascii(), expect, "{value} {digits}");
        }
    }

    fn check(value: f64, uncertainty: Option<f64>, expect: &str) {
        assert_eq!(rounded(value, uncertainty, None).ascii(), expect, "{value} ± {uncertainty:?}");
    }

    #[test]
    fn two_digits_of_the_uncertainty_decide() {
        check(0.276_543, Some(0.012_34), "0.277");
        check(0.012_34, Some(0.012_34), "0.012");
        check(5.0, Some(0.25), "5.00");
        check(5.38, Some(0.996), "5.4");
        check(12_345.6, Some(234.0), "12350");
        check(-0.001, Some(0.3), "0.00");
        check(3.0, Some(2_000.0), "0");
        check(1.234_567e-7, Some(2.1e-9), "1.235e-7");
        check(2.1e-9, Some(2.1e-9), "2.1e-9");
        check(1_234_567.0, Some(1_200.0), "1.2346e6");
        check(1.0e-12, Some(1.0e-9), "0");
        check(-6.0e-9, Some(1.0e-7), "-1e-8");
        check(0.0, Some(0.3), "0.00");
    }

    #[test]
    fn an_uncertainty_that_rounds_up_a_power_of_ten_takes_its_digits_along() {
        check(9.87, Some(0.099_9), "9.87");
        check(0.099_9, Some(0.099_9), "0.10");
    }

    #[test]
    fn without_an_uncertainty_there_are_four_digits() {
        check(5.379_8, None, "5.380");
        check(0.001_234_56, None, "0.001235");
        check(12_345.6, None, "12346");
        check(1.234_56e-5, None, "1.235e-5");
        check(9_999_999.0, None, "1.000e7");
        check(-1.5e300, None, "-1.5e300");
        check(9.999_96, None, "10.00");
        check(9.999_96e-9, None, "1.000e-8");
        check(1e-321, Some(0.0), "9.98e-322");
    }

    #[test]
    fn an_exact_number_has_no_trailing_zeros() {
        check(0.1, None, "0.1");
        check(2.0, None, "2");
        check(1000.0, None, "1000");
        check(1e9, None, "1e9");
    }

    #[test]
    fn an_uncertainty_that_is_a_residue_of_arithmetic_gives_no_digits() {
        check(7.981_666_666_666_677, Some(7.1e-14), "7.982");
        check(7.1e-14, Some(7.1e-14), "7.1e-14");
    }

    #[test]
    fn zero_has_no_sign() {
        check(0.0, None, "0");
        check(-0.0, None, "0");
        check(-0.0, Some(0.01), "0.000");
        check(-0.0, Some(1e-12), "0");
    }

    #[test]
    fn a_p_value_is_told_to_be_one_or_to_lie_below_a_thousandth() {
        let p_values = [0.0, 0.000_999_9, 0.001, 0.012_345, 1.0];
        assert_eq!(p_values.map(p_value), ["< 0.001", "< 0.001", "= 0.001", "= 0.01235", "= 1"]);
    }

    #[test]
    fn people_read_a_real_minus_and_a_raised_power() {
        assert_eq!(rounded(-1.234_56e-10, None, None).typeset(), "−1.235\u{a0}×\u{a0}10⁻¹⁰");
        assert_eq!(Decimal::integer(-3).typeset(), "−3");
    }
}
