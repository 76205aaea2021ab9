//! Collects what is wrong with a `study.toml` while its values are converted.

use super::units::MILLI;
use crate::model::Coordinate;
use crate::{StudyError, locate};

/// No number is larger, nor one that divides smaller than its inverse, in the unit in which it is
/// typed.
const LARGEST: f64 = 1e9;
/// No position lies further out: a hundred turns, or a hundred metres.
pub(super) const FARTHEST_DEG: f64 = 36_000.0;
pub(super) const FARTHEST_MM: f64 = 100_000.0;
/// No session has more trials of a kind than this.
pub(super) const MOST_TRIALS: u32 = 100_000;
/// Times that a trial which did not meet the protocol is done again, at most: who cannot do it in so many cannot do it.
pub(super) const MOST_REDONE: u32 = 20;
/// The most problems that are reported at once.
const MOST_ERRORS: usize = 100;

/// Collects problems while the values are converted.
pub(super) struct Check<'a> {
    text: &'a str,
    pub(super) errors: Vec<StudyError>,
}

impl<'a> Check<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, errors: Vec::new() }
    }

    pub(super) fn error(&mut self, key: &str, problem: impl Into<String>) {
        // Each reads the text again for its line: a file of a million mistakes would take for ever.
        if self.errors.len() >= MOST_ERRORS {
            return;
        }
        let line = locate::line_of(self.text, key);
        self.errors.push(StudyError { line, key: key.to_owned(), problem: problem.into() });
    }

    pub(super) fn positive(&mut self, key: &str, value: f64) -> f64 {
        let least = 1.0 / LARGEST;
        // Here and below it is said what is allowed, so that a NaN is not.
        if !(least..=LARGEST).contains(&value) {
            let problem =
                format!("{value} must be a number above 0, from {least:e} to {LARGEST:e}");
            self.error(key, problem);
        }
        value
    }

    /// Above 0, and at most so much: what is more would run for ever or fill the disk.
    pub(super) fn within(&mut self, key: &str, value: f64, most: f64) -> f64 {
        if value > most {
            self.error(key, format!("{value} must be at most {most}"));
            return most;
        }
        self.positive(key, value)
    }

    pub(super) fn not_negative(&mut self, key: &str, value: f64) -> f64 {
        if !(0.0..=LARGEST).contains(&value) {
            self.error(key, format!("{value} must be 0 or a number above it, at most {LARGEST:e}"));
        }
        value
    }

    /// A number that lies no further from 0 than this.
    pub(super) fn near(&mut self, key: &str, value: f64, most: f64) -> f64 {
        if !(-most..=most).contains(&value) {
            self.error(key, format!("{value} must be a finite number, from -{most} to {most}"));
        }
        value
    }

    /// A position or velocity: given in degrees in a rotational study, in millimetres in a linear
    /// one; returned in radians. `missing` stands in for an absent key; without it the key is
    /// required.
    pub(super) fn position(
        &mut self,
        at: &str,
        [deg_key, mm_key]: [&str; 2],
        [deg, mm]: [Option<f64>; 2],
        coordinate: Coordinate,
        missing: Option<f64>,
    ) -> f64 {
        let (key, value) = match coordinate {
            Coordinate::Rotational => (deg_key, deg),
            Coordinate::Linear { .. } => (mm_key, mm),
        };
        let key = format!("{at}.{key}");
        let value = self.required(&key, value.or(missing));
        match coordinate {
            Coordinate::Rotational => self.near(&key, value, FARTHEST_DEG).to_radians(),
            Coordinate::Linear { lever_m } => self.near(&key, value, FARTHEST_MM) * MILLI / lever_m,
        }
    }

    pub(super) fn required(&mut self, key: &str, value: Option<f64>) -> f64 {
        if value.is_none() {
            self.error(key, "is missing; this kind of environment needs it");
        }
        // Any number will do: with a problem noted no study comes out.
        value.unwrap_or(0.0)
    }
}
