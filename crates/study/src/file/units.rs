//! Between the units that people type and SI.

/// Grams in a kilogram, millimetres in a metre.
pub(super) const MILLI: f64 = 1e-3;

pub(super) fn degrees(rad: f64) -> f64 {
    decimal(rad.to_degrees())
}

/// Takes the last bits of a unit conversion away, so that 26.6 is written as 26.6.
pub(super) fn decimal(value: f64) -> f64 {
    const DIGITS: f64 = 1e9;
    (value * DIGITS).round() / DIGITS
}
