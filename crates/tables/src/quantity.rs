//! A quantity in a sentence or at an axis: its number and its unit, as the study's people read it.
//! No sentence names a unit itself: otherwise a linear study would speak of radians.

use crate::rounding::number;
use crate::unit::shown_unit;
use zwidth_study::Coordinate;

/// Three significant digits: an uncertainty of a tenth, of which two digits count.
const SHARE_UNKNOWN: f64 = 0.1;

/// A measured value in `unit` (that of a column) as people read it, three significant digits:
/// `4.05 N/rad`, `32.2°`; in a linear study `0.293 N/mm`, `12.5 mm`.
pub fn quantity(value: f64, unit: &str, coordinate: Coordinate) -> String {
    let (unit, factor) = shown_unit(unit, coordinate);
    let shown = factor * value;
    with_unit(&number(shown, Some(SHARE_UNKNOWN * shown.abs())), &unit)
}

/// A given value, with no more digits than it has: `4 N/rad`.
pub fn given(value: f64, unit: &str, coordinate: Coordinate) -> String {
    let (unit, factor) = shown_unit(unit, coordinate);
    with_unit(&number(factor * value, None), &unit)
}

/// A number with its unit after it, which no line break parts from it: `4.05 N/rad`; `32.2°`
/// without a space, and nothing after a pure number.
pub fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" | "1" => number.to_owned(),
        "°" => format!("{number}°"),
        unit => format!("{number}\u{a0}{unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLIDE: Coordinate = Coordinate::Linear { lever_m: 1.0 };

    #[test]
    fn a_quantity_stands_in_the_unit_that_the_study_speaks() {
        let lever = Coordinate::Rotational;
        assert_eq!(quantity(4.05, "N/rad", lever), "4.05\u{a0}N/rad");
        assert_eq!(quantity(292.75, "N/rad", SLIDE), "0.293\u{a0}N/mm");
        assert_eq!(given(100.0, "N/rad", SLIDE), "0.1\u{a0}N/mm");
        assert_eq!(quantity(0.0125, "rad", SLIDE), "12.5\u{a0}mm");
        assert_eq!(quantity(32.23_f64.to_radians(), "rad", lever), "32.2°");
        assert_eq!(quantity(-0.5_f64.to_radians(), "rad/s", lever), "−0.500\u{a0}°/s");
        assert_eq!(quantity(2.5, "N", SLIDE), "2.50\u{a0}N");
        assert_eq!(
            (with_unit("79", "1"), given(0.0, "N", lever)),
            ("79".to_owned(), "0\u{a0}N".to_owned())
        );
    }
}
