//! A metric's numbers as people read them: values and differences in its unit. A metric of natural logarithms is read as
//! what they are the logarithms of, and its differences as ratios.

use crate::quantity::with_unit;
use crate::rounding::number;
use crate::unit::shown_unit;
use zwidth_results::Sides;
use zwidth_study::{Contrast, Coordinate, TaskQuantity};

/// How the numbers of a metric are read.
#[derive(Debug, Clone, PartialEq)]
pub struct Amounts {
    /// The unit of values, and of differences that are no ratios.
    unit: String,
    factor: f64,
    are_logarithms: bool,
}

/// A difference as it is told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Amount {
    /// With its unit: `0.94 N`; of logarithms `1.40 times`, between two ratios `1.40 times as large a ratio`.
    pub text: String,
    /// The ends of its interval, where there is one: `0.89 to 0.99`.
    pub ends: Option<String>,
}

impl Amounts {
    /// Those of a metric in `unit`.
    pub fn of(unit: &str, coordinate: Coordinate) -> Self {
        let logarithm_of = TaskQuantity::logarithm_of(unit);
        let (unit, factor) = shown_unit(logarithm_of.unwrap_or(unit), coordinate);
        Self { unit, factor, are_logarithms: logarithm_of.is_some() }
    }

    /// The unit of values; `1` of pure numbers.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// What a value, or what it is the logarithm of, is multiplied by to be in that unit.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// Whether values are natural logarithms, so that differences are read as ratios.
    pub fn are_logarithms(&self) -> bool {
        self.are_logarithms
    }

    /// A value in the unit.
    pub fn value(&self, own: f64) -> f64 {
        self.factor * if self.are_logarithms { libm::exp(own) } else { own }
    }

    /// A difference in the unit, or as a ratio.
    fn difference(&self, own: f64) -> f64 {
        if self.are_logarithms { libm::exp(own) } else { self.factor * own }
    }

    /// A mean with its standard deviation, which sets the digits: `1.617 ± 0.029`; of logarithms the geometric mean and
    /// the factor of one deviation, `27.3 ×/÷ 1.24`.
    pub fn mean(&self, mean: f64, sd: Option<f64>) -> String {
        let value = self.value(mean);
        let (error, spread) = if self.are_logarithms {
            let factor = sd.map(libm::exp);
            let error = sd.map(|sd| sd * value);
            (error, factor.map(|factor| format!(" ×/÷ {}", number(factor, Some(factor - 1.0)))))
        } else {
            let sd = sd.map(|sd| sd * self.factor);
            (sd, sd.map(|sd| format!(" ± {}", number(sd, Some(sd)))))
        };
        number(value, error) + &spread.unwrap_or_default()
    }

    /// A difference with the ends of its interval; its standard error sets the digits of all three.
    pub fn told(
        &self,
        difference: f64,
        ends: Option<(f64, f64)>,
        error: Option<f64>,
        sides: Sides,
    ) -> Amount {
        let scale = if self.are_logarithms { self.difference(difference) } else { self.factor };
        let error = error.map(|error| error * scale);
        let shown = |own: f64| number(self.difference(own), error);
        let ends = ends.map(|(low, high)| format!("{} to {}", shown(low), shown(high)));
        let text = match (self.are_logarithms, sides) {
            (false, _) => with_unit(&shown(difference), &self.unit),
            (true, Sides::Values) => format!("{} times", shown(difference)),
            (true, Sides::Differences) => format!("{} times as large a ratio", shown(difference)),
        };
        Amount { text, ends }
    }

    /// What is compared, by ids or as a whole: where differences are ratios with a stroke in place of each minus,
    /// `hybrid / active`.
    pub fn compared(&self, what: &str) -> String {
        match self.are_logarithms {
            true => what.replace(Contrast::MINUS, Contrast::OVER),
            false => what.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVER: Coordinate = Coordinate::Rotational;
    const SLIDE: Coordinate = Coordinate::Linear { lever_m: 0.1 };
    /// Natural logarithms of 1.4, 1.24 and 1.57, and of 1.05.
    const RATIOS: [f64; 3] = [0.336_472, 0.215_111, 0.451_076];
    const ERROR: f64 = 0.048_790;

    fn told(unit: &str, sides: Sides) -> (String, String) {
        let [difference, low, high] = RATIOS;
        let amounts = Amounts::of(unit, LEVER);
        let amount = amounts.told(difference, Some((low, high)), Some(ERROR), sides);
        (amount.text, amount.ends.unwrap())
    }

    #[test]
    fn a_difference_of_logarithms_is_a_ratio_and_of_two_such_how_many_times_as_large() {
        for (unit, sides, text, ends) in [
            ("N", Sides::Values, "0.336\u{a0}N", "0.215 to 0.451"),
            ("N", Sides::Differences, "0.336\u{a0}N", "0.215 to 0.451"),
            ("rad", Sides::Values, "19.3°", "12.3 to 25.8"),
            ("ln N", Sides::Values, "1.400 times", "1.240 to 1.570"),
            ("ln rad", Sides::Values, "1.400 times", "1.240 to 1.570"),
            ("ln 1", Sides::Differences, "1.400 times as large a ratio", "1.240 to 1.570"),
        ] {
            assert_eq!(told(unit, sides), (text.to_owned(), ends.to_owned()), "{unit}");
        }
        let alone = Amounts::of("ln N", LEVER).told(-0.5, None, None, Sides::Values);
        assert_eq!((alone.text.as_str(), alone.ends), ("0.6065 times", None));
    }

    #[test]
    fn a_mean_of_logarithms_is_a_geometric_mean_in_the_unit_that_people_read() {
        let mean = libm::log(25.0);
        for (unit, coordinate, mean, sd, expect) in [
            ("N", LEVER, 1.617, Some(0.029), "1.617 ± 0.029"),
            ("ln N/rad", LEVER, mean, Some(libm::log(1.2)), "25.0 ×/÷ 1.20"),
            ("ln N/rad", SLIDE, mean, None, "0.2500"),
            ("ln rad", LEVER, libm::log(0.5), None, "28.65"),
        ] {
            assert_eq!(Amounts::of(unit, coordinate).mean(mean, sd), expect, "{unit}");
        }
    }

    #[test]
    fn what_a_ratio_compares_has_a_stroke() {
        let both = "(yes − no) × (soft − stiff)";
        assert_eq!(Amounts::of("ln N", LEVER).compared(both), "(yes / no) × (soft / stiff)");
        assert_eq!(Amounts::of("N", LEVER).compared(both), both);
    }
}
