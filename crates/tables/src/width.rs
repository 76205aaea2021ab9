//! The approximate width of texts and numbers on paper, too wide rather than too narrow, in widths
//! of a digit (half an em in most text fonts).

use crate::rounding::Decimal;
use crate::shown::Cell;

/// Widths of signs about as wide as `i`, as `e` and as `m`, of other capitals and of all other
/// letters, a little more than in Latin Modern.
const THIN_DIGITS: f64 = 0.65;
const NARROW_DIGITS: f64 = 0.9;
const BROAD_DIGITS: f64 = 1.75;
const CAPITAL_DIGITS: f64 = 1.5;
const LETTER_DIGITS: f64 = 1.1;
/// Width of `× 10` with the gaps around the cross.
const POWER_DIGITS: f64 = 5.0;
/// A gap between groups of three digits.
const GROUP_GAP_DIGITS: f64 = 0.4;

/// The width of a text on one line.
pub(crate) fn width(text: &str) -> f64 {
    text.chars().map(letter).sum()
}

/// The width of its longest word, which no line can be narrower than.
pub(crate) fn longest_word(text: &str) -> f64 {
    text.split_whitespace().map(width).fold(0.0, f64::max)
}

/// Signs of these widths.
const THIN: &str = "ijlI.,:;!|'()[] ⁰¹²³⁴⁵⁶⁷⁸⁹⁻·°₀₁₂₃₄₅₆₇₈₉";
const NARROW: &str = "acefrstvz";
const BROAD: &str = "mwMW—%@&±×−+=<>≤≥≈→√∞";

fn letter(letter: char) -> f64 {
    match letter {
        '0'..='9' | '-' | '–' => 1.0,
        '\u{300}'..='\u{36f}' => 0.0, // stands over the letter before it
        _ if THIN.contains(letter) => THIN_DIGITS,
        _ if NARROW.contains(letter) => NARROW_DIGITS,
        _ if BROAD.contains(letter) => BROAD_DIGITS,
        _ if letter.is_uppercase() => CAPITAL_DIGITS,
        _ => LETTER_DIGITS,
    }
}

/// Room that the numbers of a column need when their points stand below each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Room {
    /// Whether one of them is only known to lie below what is shown.
    pub(crate) below: bool,
    /// Whether one of them is negative.
    pub(crate) sign: bool,
    /// Digits before the point.
    pub(crate) whole: usize,
    /// Digits behind it.
    pub(crate) decimals: usize,
    /// Digits of a power of ten.
    pub(crate) power: usize,
    /// Whether such a power is negative.
    pub(crate) power_sign: bool,
}

impl Room {
    /// The room for the numbers of a column's cells.
    pub(crate) fn of(cells: &[Cell]) -> Self {
        let numbers = cells.iter().filter_map(|cell| match cell {
            Cell::Number(number) => Some(Self::number(number)),
            _ => None,
        });
        numbers.fold(Self::default(), Self::both)
    }

    fn number(number: &Decimal) -> Self {
        let digits = number.mantissa.trim_start_matches('-');
        let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
        let power = number.exponent.map(|e| e.unsigned_abs().to_string().len());
        Self {
            below: number.below,
            sign: number.mantissa.starts_with('-'),
            whole: whole.len(),
            decimals: decimals.len(),
            power: power.unwrap_or(0),
            power_sign: number.exponent.is_some_and(|e| e < 0),
        }
    }

    fn both(self, other: Self) -> Self {
        Self {
            below: self.below || other.below,
            sign: self.sign || other.sign,
            whole: self.whole.max(other.whole),
            decimals: self.decimals.max(other.decimals),
            power: self.power.max(other.power),
            power_sign: self.power_sign || other.power_sign,
        }
    }

    /// Its width.
    pub(crate) fn width(self) -> f64 {
        let [whole, decimals] = [self.whole, self.decimals]
            .map(|n| n as f64 + GROUP_GAP_DIGITS * (n.saturating_sub(1) / 3) as f64);
        let below = if self.below { BROAD_DIGITS } else { 0.0 };
        let sign = if self.sign { BROAD_DIGITS } else { 0.0 };
        let point = if self.decimals > 0 { THIN_DIGITS } else { 0.0 };
        let power = if self.power > 0 { POWER_DIGITS + self.power as f64 } else { 0.0 };
        below + sign + whole + point + decimals + power
    }
}

/// The width of the widest of a column's cells, whose numbers need this room.
pub(crate) fn widest_cell(cells: &[Cell], room: Room) -> f64 {
    let others = cells.iter().filter(|c| !matches!(c, Cell::Number(_)));
    others.map(|c| width(&c.typeset())).fold(room.width(), f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rounding::rounded;
    use crate::shown::{shown, tests::sample};

    #[test]
    fn a_dot_above_takes_no_room_and_a_broad_letter_more_than_a_narrow_one() {
        assert!((width("θ\u{307}") - width("θ")).abs() < 1e-12);
        assert!(width("mm") > width("nn") && width("nn") > width("ii"));
        assert!((longest_word("a long one") - width("long")).abs() < 1e-12);
    }

    #[test]
    fn the_room_of_a_column_is_that_of_all_its_numbers_together() {
        let columns = shown(&sample(), None);
        let expect = Room { sign: true, whole: 1, decimals: 3, ..Room::default() };
        assert_eq!(Room::of(&columns[2].cells), expect);
        let small = Room::number(&rounded(1.251_6e-12, Some(1e-13), None));
        let expect_small =
            Room { whole: 1, decimals: 2, power: 2, power_sign: true, ..Room::default() };
        assert_eq!(small, expect_small);
        assert!(small.both(expect).width() > expect.width());
    }
}
