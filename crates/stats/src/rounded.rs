//! The one place where numbers of another library's distributions are rounded.
//!
//! statrs takes `ln` and `exp` from the platform, whose last bits differ between processors, and
//! intervals are stored. So its numbers are rounded to nine significant digits at once, before
//! anything is computed from them, and all later results are the same everywhere. A number rounds
//! to different nine digits only if two platforms lie on either side of the middle between two of
//! these. With differences around 1e-15 (degrees of freedom below some hundreds) that is one number
//! in a million, and one in ten thousand at worst (a thousand degrees of freedom, where statrs
//! subtracts large logarithms). Rounding results instead would mean rounding many numbers for each
//! of these, with the differences that had built up by then.

/// The nearest number of nine significant digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn nine_significant_digits_are_left_and_differences_below_them_are_gone() {
        for (value, expect) in [
            (1.959_963_984_540_054, 1.959_963_98),
            (-12.706_204_736_174_694, -12.706_204_7),
            (4.567_890_123_456e-300, 4.567_890_12e-300),
        ] {
            for value in [value, f64::next_up(value), f64::next_down(value)] {
                assert_eq!(rounded(value).to_bits(), f64::to_bits(expect), "{value}");
            }
        }
        assert_eq!((rounded(0.0), rounded(f64::INFINITY)), (0.0, f64::INFINITY));
    }
}
