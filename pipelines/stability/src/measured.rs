//! The exact limit again, by experiment: the loop is simulated and its swings are examined.

use crate::curves::{Curve, passes};
use crate::map::{Map, placed};
use rayon::prelude::*;
use zwidth_results::{LimitKind, LimitName, WallLimit};

/// Ticks of a simulated loop: at 0.5 % beyond the limit its swings change by more than rounding.
pub(crate) const TICKS: usize = 3000;
/// Places along x at which the limit is measured.
const PLACES: usize = 9;

/// Points of the limit at evenly spaced places along x: where the lifted map passes 1, the
/// simulated loop is tried a cell on either side, and the crossing of its swings closed in on. A
/// point at which the two sides do not differ is not a crossing.
pub fn measured(map: &Map) -> Option<Curve> {
    let crossings: Vec<(usize, usize)> = (0..PLACES)
        .map(|k| (2 * k + 1) * (map.x.cells - 1) / (2 * PLACES))
        .flat_map(|i| crossings(map, i).into_iter().map(move |j| (i, j)))
        .collect();
    let points: Vec<[f64; 2]> =
        crossings.into_par_iter().filter_map(|(i, j)| point(map, i, j)).collect();
    (!points.is_empty()).then(|| Curve {
        limit: LimitName::Computed(WallLimit::Measured),
        kind: LimitKind::Measured,
        pieces: vec![points],
    })
}

/// The rows between which the exact limit is passed in a column.
fn crossings(map: &Map, i: usize) -> Vec<usize> {
    let rows = (0..map.y.cells - 1).filter(|j| {
        let [a, b] = [*j, j + 1].map(|j| passes(&map.cells[j * map.x.cells + i], 0));
        a.zip(b).is_some_and(|(a, b)| a != b)
    });
    rows.collect()
}

fn point(map: &Map, i: usize, j: usize) -> Option<[f64; 2]> {
    /// Halvings of three cells: a thousandth of one.
    const HALVINGS: u32 = 11;
    // A cell more on either side: the loop's own limit may lie beside the cell that the map's
    // crosses.
    let [mut a, mut b] = [j.saturating_sub(1), j + 2].map(|j| map.y.share(j.min(map.y.cells - 1)));
    let x = map.x.share(i);
    let grows = |y: f64| {
        let wall = placed(&map.point, [map.x, map.y], [x, y]).wall;
        // A run that fails does so because it grew beyond all bounds.
        wall.simulated_growth(TICKS).map_or(true, |growth| growth > 1.0)
    };
    let first = grows(a);
    if first == grows(b) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (a + b);
        if grows(middle) == first {
            a = middle;
        } else {
            b = middle;
        }
    }
    Some([map.x.at(x), map.y.at(0.5 * (a + b))])
}
