//! The limits of a map as lines.

use crate::contour::Field;
use crate::map::{Cell, METHODS, Map, Methods, placed};
use rayon::prelude::*;
use zwidth_dynamics::{NAMED_SOLVERS, Textbook};

/// A radius or growth up to this is 1: rounding of the estimate.
const ONE: f64 = 1.0 + 1e-6;

/// A limit on a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its word in tables.
    pub limit: String,
    /// `exact`, `passivity`, `method`, `textbook`, `measured`, `others`.
    pub kind: &'static str,
    /// What stands at it in a figure.
    pub label: String,
    /// Its pieces, each a list of x and y in SI units.
    pub pieces: Vec<Vec<[f64; 2]>>,
}

/// A formula's word in this stage's tables, where a quantity is called `delay` already.
pub(crate) fn word(formula: Textbook) -> &'static str {
    if formula == Textbook::Delay { "hulin" } else { formula.as_str() }
}

/// What a limit is called: its word, its kind, its label.
pub(crate) fn names() -> [(&'static str, &'static str, String); 8] {
    let method = |i: usize| {
        let label = NAMED_SOLVERS.iter().find(|named| named.name == METHODS[i]);
        // All of RK4's ways of switching have one map.
        let label = label.map_or(METHODS[i], |named| named.label).split(',').next();
        (METHODS[i], "method", label.unwrap_or_default().to_owned())
    };
    let book = |formula: Textbook| {
        let label = match formula {
            Textbook::ColgateSchenkel => "Colgate–Schenkel",
            Textbook::Delay => "Hulin",
            Textbook::AbbottOkamura => "Abbott–Okamura",
            Textbook::Diolaiti => "Diolaiti",
        };
        (word(formula), "textbook", label.to_owned())
    };
    let [a, b, c, d] = Textbook::ALL.map(book);
    let exact = ("lifted_map", "exact", "stable".to_owned());
    let passive = ("passivity", "passivity", "passive".to_owned());
    [exact, passive, method(0), method(1), a, b, c, d]
}

/// Whether a limit is passed in a cell.
pub(crate) fn passes(cell: &Cell, limit: usize) -> Option<bool> {
    let bound = if limit == 2 || limit == 3 { ONE } else { 1.0 };
    cell.values()[limit].map(|value| value >= bound)
}

/// The limits of a map that cross it.
pub fn curves(map: &Map) -> Vec<Curve> {
    let made: Vec<Curve> = names()
        .into_par_iter()
        .enumerate()
        .map(|(limit, (word, kind, label))| {
            let methods = Methods::new();
            let spans = [map.x, map.y];
            let above = |i: usize, j: usize| passes(&map.cells[j * map.x.cells + i], limit);
            let above_at = |share| {
                let cell = methods.cell(&placed(&map.point, spans, share));
                passes(&cell, limit).unwrap_or(true)
            };
            let field = Field {
                columns: map.x.cells,
                rows: map.y.cells,
                above: &above,
                above_at: &above_at,
            };
            let si = |share: &[f64; 2]| [map.x.at(share[0]), map.y.at(share[1])];
            let pieces = field.lines().iter().map(|line| line.iter().map(si).collect()).collect();
            Curve { limit: word.to_owned(), kind, label, pieces }
        })
        .collect();
    made.into_iter().filter(|curve| !curve.pieces.is_empty()).collect()
}
