//! The stiffest wall by every limit at one point.

use crate::curves::word;
use crate::error::StabilityError;
use crate::measured::TICKS;
use crate::quantity::Point;
use zwidth_dynamics::Textbook;

/// What one limit says of the stiffest wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// Its word in tables.
    pub limit: String,
    /// `exact`, `passivity`, `textbook`, `measured`.
    pub kind: &'static str,
    /// Its equation.
    pub equation: String,
    /// Where it comes from.
    pub source: String,
    /// K, N/m.
    pub stiffness_n_per_m: Option<f64>,
    /// Its error against the exact one, as a share of that.
    pub error_share: Option<f64>,
}

impl Limit {
    /// Whether a wall that it allows is unstable.
    pub fn is_unsafe(&self) -> Option<bool> {
        /// A difference below this is that of the search.
        const ROUNDING: f64 = 1e-6;
        self.error_share.filter(|_| self.kind != "measured").map(|error| error > ROUNDING)
    }
}

/// The stiffest wall at a point, by every limit.
///
/// # Errors
/// A point that makes no sense.
pub fn limits(point: &Point) -> Result<Vec<Limit>, StabilityError> {
    let wall = &point.wall;
    let exact = wall.stiffest_stable()?;
    let of = |limit: &str, kind, equation: &str, source: &str, stiffness: Option<f64>| Limit {
        limit: limit.to_owned(),
        kind,
        equation: equation.to_owned(),
        source: source.to_owned(),
        stiffness_n_per_m: stiffness,
        error_share: exact
            .zip(stiffness)
            .filter(|(exact, _)| *exact > 0.0)
            .map(|(exact, stiffness)| stiffness / exact - 1.0),
    };
    let lifted = "the lifted map x' = A x over a period: ρ(A) = 1";
    let passive = "b = max (T/2) Re{(1 − e^(−jωT)) H}/(1 − cos ωT)";
    let simulated = "the loop simulated: swings neither grow nor die";
    let mut limits = vec![
        of("lifted_map", "exact", lifted, "this software", exact),
        of(
            "measured",
            "measured",
            simulated,
            "this software",
            wall.stiffest_measured(TICKS, 1e-3)?,
        ),
        of(
            "passivity",
            "passivity",
            passive,
            Textbook::ColgateSchenkel.citation(),
            wall.stiffest_passive(),
        ),
    ];
    limits.extend(Textbook::ALL.map(|formula| {
        let stiffest = formula.stiffest(wall, point.dry);
        of(word(formula), "textbook", formula.formula(), formula.citation(), stiffest)
    }));
    Ok(limits)
}
