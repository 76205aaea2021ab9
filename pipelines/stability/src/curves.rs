//! The limits of a map as lines.

use crate::contour::Field;
use crate::map::{Cell, Map, Methods, placed};
use rayon::prelude::*;
use zwidth_results::{LimitKind, LimitName, WallLimit};

/// A radius or growth up to this is 1: rounding of the estimate.
const ONE: f64 = 1.0 + 1e-6;

/// A limit on a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name.
    pub limit: LimitName,
    /// What it is.
    pub kind: LimitKind,
    /// Its pieces, each a list of x and y in SI units.
    pub pieces: Vec<Vec<[f64; 2]>>,
}

/// The limits of a cell, in the order of [`Cell`].
pub(crate) const LIMITS: [(WallLimit, LimitKind); 8] = [
    (WallLimit::LiftedMap, LimitKind::Exact),
    (WallLimit::Passivity, LimitKind::Passivity),
    (WallLimit::Rk4, LimitKind::Method),
    (WallLimit::SymplecticEuler, LimitKind::Method),
    (WallLimit::ColgateSchenkel, LimitKind::Textbook),
    (WallLimit::Hulin, LimitKind::Textbook),
    (WallLimit::AbbottOkamura, LimitKind::Textbook),
    (WallLimit::Diolaiti, LimitKind::Textbook),
];

/// Whether a limit is passed in a cell.
pub(crate) fn passes(cell: &Cell, limit: usize) -> Option<bool> {
    // The two solvers' growths are quotients of estimated radii, whose rounding is no growth.
    let bound = if LIMITS[limit].1 == LimitKind::Method { ONE } else { 1.0 };
    cell[limit].map(|value| value >= bound)
}

/// The limits of a map that cross it.
pub fn curves(map: &Map) -> Vec<Curve> {
    let curves: Vec<Curve> = LIMITS
        .into_par_iter()
        .enumerate()
        .map(|(limit, (computed, kind))| {
            let methods = Methods::new();
            let spans = [map.x, map.y];
            let field = Field {
                columns: map.x.cells,
                rows: map.y.cells,
                above: &|i, j| passes(&map.cells[j * map.x.cells + i], limit),
                above_at: &|share| {
                    let cell = methods.cell(&placed(&map.point, spans, share));
                    passes(&cell, limit).unwrap_or(true)
                },
            };
            let lines = field.lines();
            let pieces = lines
                .iter()
                .map(|line| line.iter().map(|[x, y]| [map.x.at(*x), map.y.at(*y)]).collect())
                .collect();
            Curve { limit: LimitName::Computed(computed), kind, pieces }
        })
        .collect();
    curves.into_iter().filter(|curve| !curve.pieces.is_empty()).collect()
}
