//! The ranges of the numbers of a scene's terms, and points in these ranges.

use crate::LadderError;
use zwidth_device::{HAND_RANGES, TwinParameters};
use zwidth_numerics::sobol::sobol_points;

/// A number that is not known exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Its name, with its unit.
    pub name: &'static str,
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Its source, or that it is assumed.
    pub source: &'static str,
}

const fn range(name: &'static str, [low, high]: [f64; 2], source: &'static str) -> Range {
    Range { name, low, high, source }
}

/// The ranges that the twin's table (`docs/twin.md`) does not have.
const FURTHER: [Range; 6] = [
    range("finger_stiffness_n_per_m", HAND_RANGES[0], "hand and finger: Gurari 2017"),
    range("finger_damping_ns_per_m", HAND_RANGES[1], "hand and finger: assumed"),
    range("finger_mass_kg", HAND_RANGES[2], "hand and finger: assumed"),
    range("weight_kg", [0.01, 0.04], "assumed: a printed lever, its centre at 40 mm"),
    range("delay_periods", [0.0, 1.0], "assumed: computed and sent within a period of the loop"),
    range("angle_zero_counts", [0.0, 1.0], "where the magnet happens to sit"),
];

/// Every range, those of the twin's table first, in its order.
pub fn ranges() -> Vec<Range> {
    let twin = TwinParameters::table().map(|p| range(p.name, p.range, p.source));
    twin.into_iter().chain(FURTHER).collect()
}

/// A value of every number.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The twin's numbers.
    pub(crate) twin: TwinParameters,
    pub(crate) finger_stiffness_n_per_m: f64,
    pub(crate) finger_damping_ns_per_m: f64,
    pub(crate) finger_mass_kg: f64,
    pub(crate) weight_kg: f64,
    /// Delay as a share of the loop's period.
    pub(crate) delay_periods: f64,
    /// The place of the angle sensor's zero between two counts.
    pub(crate) angle_zero_counts: f64,
    /// The seed of the force sensor's noise.
    pub(crate) seed: u64,
}

impl Point {
    /// The first points of Sobol's sequence over the ranges.
    ///
    /// # Errors
    /// More ranges than the sequence has coordinates.
    pub fn sobol(points: usize) -> Result<Vec<Self>, LadderError> {
        let ranges = ranges();
        let shares = sobol_points(ranges.len(), points).ok_or(LadderError::TooManyRanges)?;
        let mut points = Vec::with_capacity(shares.len());
        for (seed, shares) in (0..).zip(shares) {
            let values: Vec<f64> =
                ranges.iter().zip(shares).map(|(r, x)| r.low + (r.high - r.low) * x).collect();
            points.push(Self::of(&values, seed));
        }
        Ok(points)
    }

    /// The twin's defaults, and the middle of what it does not have.
    pub fn usual() -> Self {
        let twin = TwinParameters::table().map(|p| p.default);
        let middle = FURTHER.map(|r| 0.5 * (r.low + r.high));
        Self::of(&[twin.as_slice(), &middle].concat(), 0)
    }

    /// In the order of [`ranges`].
    fn of(values: &[f64], seed: u64) -> Self {
        let mut twin = TwinParameters::default();
        let table = TwinParameters::table();
        let (own, further) = values.split_at(table.len());
        for (parameter, value) in table.iter().zip(own) {
            *(parameter.field)(&mut twin) = *value;
        }
        Self {
            twin,
            finger_stiffness_n_per_m: further[0],
            finger_damping_ns_per_m: further[1],
            finger_mass_kg: further[2],
            weight_kg: further[3],
            delay_periods: further[4],
            angle_zero_counts: further[5],
            seed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_within_every_range_and_the_first_in_the_middle() {
        let points = Point::sobol(64).unwrap();
        let first = &points[0];
        assert!((first.twin.lever_m - 0.07).abs() < 1e-12);
        assert!((first.finger_mass_kg - 0.115).abs() < 1e-12);
        for point in &points {
            let mut twin = point.twin.clone();
            for p in TwinParameters::table() {
                let value = *(p.field)(&mut twin);
                assert!(p.range[0] <= value && value <= p.range[1], "{} {value}", p.name);
            }
            assert!((0.0..1.0).contains(&point.delay_periods));
        }
    }

    #[test]
    fn every_range_says_where_it_comes_from() {
        assert!(ranges().iter().all(|r| !r.source.is_empty() && r.low < r.high));
    }
}
