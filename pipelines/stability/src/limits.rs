//! The stiffest wall at one point, by every limit.

use crate::curves::LIMITS;
use crate::error::StabilityError;
use crate::measured::TICKS;
use crate::quantity::Point;
use zwidth_dynamics::Textbook;
use zwidth_results::{LimitKind, StiffestWall, WallLimit};

/// An error above this makes a limit unsafe: below, it is that of the search.
const ROUNDING: f64 = 1e-6;

/// The stiffest wall at a point, by every limit.
///
/// # Errors
/// A point that makes no sense.
pub fn limits(point: &Point) -> Result<Vec<StiffestWall>, StabilityError> {
    let wall = &point.wall;
    let exact = wall.stiffest_stable()?;
    let lifted = "the lifted map x' = A x over a period: ρ(A) = 1";
    let passive = "b = max (T/2) Re{(1 − e^(−jωT)) H}/(1 − cos ωT)";
    let simulated = "the loop simulated: swings neither grow nor die";
    let mut limits = vec![
        (WallLimit::LiftedMap, LimitKind::Exact, lifted, "this software", exact),
        (
            WallLimit::Measured,
            LimitKind::Measured,
            simulated,
            "this software",
            wall.stiffest_measured(TICKS, 1e-3)?,
        ),
        (
            WallLimit::Passivity,
            LimitKind::Passivity,
            passive,
            Textbook::ColgateSchenkel.citation(),
            wall.stiffest_passive(),
        ),
    ];
    // They stand in the order of the formulas.
    let of_formulas = LIMITS.into_iter().filter(|(_, kind)| *kind == LimitKind::Textbook);
    limits.extend(Textbook::ALL.into_iter().zip(of_formulas).map(|(formula, (limit, kind))| {
        let stiffest = formula.stiffest(wall, point.dry);
        (limit, kind, formula.formula(), formula.citation(), stiffest)
    }));
    let rows = limits.into_iter().map(|(limit, kind, equation, source, stiffness)| {
        let error_share = exact
            .zip(stiffness)
            .filter(|(exact, _)| *exact > 0.0)
            .map(|(exact, stiffness)| stiffness / exact - 1.0);
        // What is measured is no claim about walls.
        let claimed = error_share.filter(|_| kind != LimitKind::Measured);
        StiffestWall {
            limit,
            kind,
            equation: equation.to_owned(),
            source: source.to_owned(),
            stiffness_n_per_m: stiffness,
            error_share,
            is_unsafe: claimed.map(|error| error > ROUNDING),
        }
    });
    Ok(rows.collect())
}
