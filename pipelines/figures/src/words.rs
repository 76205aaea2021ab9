//! What several figures share: the name of a study's coordinate and its unit on axes, axes of powers
//! of ten, marks, names as markup.

use std::sync::Arc;
use zwidth_draw::style::{self, Colour};
use zwidth_draw::{Axis, Direction, Layer, Reference, Ticks, markup};
use zwidth_dynamics::NAMED_SOLVERS;
use zwidth_study::{Coordinate, Source};
use zwidth_tables::{shown_unit, with_unit};

/// The stamp of a figure made from simulated data; `None` otherwise.
pub fn mark(sources: impl IntoIterator<Item = Source>) -> Option<String> {
    let simulated = sources.into_iter().any(Source::is_simulated);
    simulated.then(|| "SYNTHETIC: simulated, not measured".to_owned())
}

/// The stamp of a figure made from model runs.
pub(crate) fn model_mark() -> Option<String> {
    Some("SIMULATION: a model run".to_owned())
}

/// Symbols and units of a study's axes: degrees for a lever, millimetres for a slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Words {
    coordinate: Coordinate,
}

impl Words {
    /// The words of a study with this coordinate.
    pub fn new(coordinate: Coordinate) -> Self {
        Self { coordinate }
    }

    /// An angle in the unit of the axis: degrees, or millimetres along the slide.
    pub fn position(self, theta_rad: f64) -> f64 {
        match self.coordinate {
            Coordinate::Rotational => theta_rad.to_degrees(),
            Coordinate::Linear { lever_m } => theta_rad * lever_m * 1e3,
        }
    }

    /// Positions as they stand on the axis; null becomes a gap.
    pub(crate) fn positions(self, values: impl IntoIterator<Item = Option<f64>>) -> Vec<f64> {
        values.into_iter().map(|v| v.map_or(f64::NAN, |v| self.position(v))).collect()
    }

    /// Axis of the position.
    pub(crate) fn position_axis(self) -> Axis {
        match self.coordinate {
            Coordinate::Rotational => Axis::new("*θ*", "°"),
            Coordinate::Linear { .. } => Axis::new("*x*", "mm"),
        }
    }

    /// Axis of the velocity.
    pub(crate) fn velocity_axis(self) -> Axis {
        match self.coordinate {
            Coordinate::Rotational => Axis::new("*θ̇*", "°/s"),
            Coordinate::Linear { .. } => Axis::new("*ẋ*", "mm/s"),
        }
    }

    /// Word for the position, in notes.
    pub(crate) fn position_word(self) -> &'static str {
        match self.coordinate {
            Coordinate::Rotational => "angle",
            Coordinate::Linear { .. } => "displacement",
        }
    }

    /// A place as text, as at a wall line: `26.6°`, `12 mm`.
    pub(crate) fn place(self, theta_rad: f64) -> String {
        let value = (self.position(theta_rad) * 10.0).round() / 10.0;
        with_unit(&value.to_string(), &shown_unit("rad", self.coordinate).0)
    }

    /// The same with a minus sign, not a hyphen.
    pub(crate) fn signed_place(self, theta_rad: f64) -> String {
        self.place(theta_rad).replace('-', "−")
    }
}

/// A name from a study as it stands: its stars and underscores are not markup.
pub(crate) fn plain(name: &str) -> String {
    markup::escape(name)
}

/// Participant and session as they stand in a heading: no line break parts them.
pub(crate) fn keep_together(who: &str) -> String {
    who.replace(' ', "\u{a0}")
}

/// A share as per cent: 0.95 → `95 %`.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", (share * 1e4).round() / 1e2)
}

/// Axis of powers of ten.
pub(crate) fn powers_axis(label: &str, unit: &str) -> Axis {
    Axis { ticks: Ticks::Powers, ..Axis::new(label, unit) }
}

/// Axis of numbers above zero, of which it takes the natural logarithms.
pub(crate) fn logarithms_axis(label: &str, unit: &str) -> Axis {
    Axis { ticks: Ticks::Logarithms, ..Axis::new(label, unit) }
}

/// What an axis of powers takes of a value; what is not above zero has no place on it.
pub(crate) fn logarithm(value: f64) -> f64 {
    if value > 0.0 { libm::log10(value) } else { f64::NAN }
}

/// The same of several values.
pub(crate) fn logarithms(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| logarithm(*value)).collect()
}

/// The colour of the solver of this name; that of the exact one for an unknown name.
pub(crate) fn solver_colour(name: &str) -> Colour {
    let number = NAMED_SOLVERS.iter().position(|named| named.name == name);
    style::solver_colour(number.unwrap_or(0))
}

/// The heading of the `number`-th panel of a figure, after its letter.
pub(crate) fn lettered(number: usize, title: &str) -> String {
    format!("**{}**  {title}", char::from(b'a' + (number % 26) as u8))
}

/// Names in order, each once.
pub(crate) fn distinct<'a>(names: impl Iterator<Item = &'a Arc<str>>) -> Vec<Arc<str>> {
    let mut seen: Vec<Arc<str>> = Vec::new();
    for name in names {
        if !seen.contains(name) {
            seen.push(name.clone());
        }
    }
    seen
}

/// The line at the logarithm of 1, where what a person just feels stands.
pub(crate) fn just_felt(direction: Direction) -> Layer {
    let line = Reference::new(direction, 0.0, style::reference());
    Layer::Reference(Reference { label: Some("just felt".to_owned()), ..line })
}

/// Axis of time.
pub(crate) fn time_axis(label: &str) -> Axis {
    Axis::new(label, "s").ranged(zwidth_draw::Range::Tight).linked("time")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lever_speaks_degrees_and_a_slide_millimetres() {
        let lever = Words::new(Coordinate::Rotational);
        let slide = Words::new(Coordinate::Linear { lever_m: 0.5 });
        assert!((lever.position(std::f64::consts::PI) - 180.0).abs() < 1e-12);
        assert!((slide.position(0.02) - 10.0).abs() < 1e-12);
        assert_eq!(lever.place(26.6_f64.to_radians()), "26.6°");
        assert_eq!(slide.place(0.02), "10\u{a0}mm");
    }

    #[test]
    fn one_simulated_trial_marks_the_whole_figure() {
        assert!(mark([Source::Imported, Source::Twin]).is_some());
        assert!(mark([Source::Imported, Source::Simulated]).is_some());
        assert!(mark([Source::Imported, Source::Recorded]).is_none());
    }
}
