//! Lines on which a function over the unit square equals a level: marching squares, with crossings
//! found by bisection and then joined.

use std::collections::BTreeMap;

/// A point of the unit square.
pub(crate) type Place = [f64; 2];

/// An edge of the grid: its lower left corner, and whether it runs upward.
type Edge = (usize, usize, bool);

/// A grid of values over the unit square, row by row; none where there is no value.
pub(crate) struct Field<'a> {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) above: &'a dyn Fn(usize, usize) -> Option<bool>,
    /// Whether the level is passed at a place between the corners.
    pub(crate) above_at: &'a dyn Fn(Place) -> bool,
}

impl Field<'_> {
    /// The lines between what is above the level and what is not.
    pub(crate) fn lines(&self) -> Vec<Vec<Place>> {
        let mut next: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for j in 0..self.rows - 1 {
            for i in 0..self.columns - 1 {
                for [a, b] in self.crossed(i, j) {
                    next.entry(a).or_default().push(b);
                    next.entry(b).or_default().push(a);
                }
            }
        }
        let mut lines = Vec::new();
        // Open lines first, from an end; what is left are rings.
        for open in [true, false] {
            while let Some(start) = begin(&next, open) {
                lines.push(walk(&mut next, start));
            }
        }
        lines
            .into_iter()
            .map(|line| line.into_iter().map(|edge| self.crossing(edge)).collect())
            .collect()
    }

    /// The pairs of edges of a cell that a line joins.
    fn crossed(&self, i: usize, j: usize) -> Vec<[Edge; 2]> {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| (self.above)(i + di, j + dj));
        // No line crosses a cell with a corner without a value: a gap in the map is no limit.
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return Vec::new() };
        let low = (i, j, false);
        let high = (i, j + 1, false);
        let left = (i, j, true);
        let right = (i + 1, j, true);
        let edges: Vec<Edge> = [(a != b, low), (b != c, right), (c != d, high), (d != a, left)]
            .into_iter()
            .filter_map(|(differs, edge)| differs.then_some(edge))
            .collect();
        match edges[..] {
            [one, other] => vec![[one, other]],
            // A saddle: the values at the corners do not tell which pairs belong together.
            [..] if edges.len() == 4 => vec![[low, right], [high, left]],
            [..] => Vec::new(),
        }
    }

    /// Where the level is passed on an edge, to a thousandth of a cell.
    fn crossing(&self, (i, j, upward): Edge) -> Place {
        const HALVINGS: u32 = 10;
        let ends = [(i, j), (i + usize::from(!upward), j + usize::from(upward))];
        let [mut a, mut b] = ends.map(|(i, j)| {
            [i as f64 / (self.columns - 1) as f64, j as f64 / (self.rows - 1) as f64]
        });
        let first = (self.above)(i, j).unwrap_or_default();
        for _ in 0..HALVINGS {
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            if (self.above_at)(middle) == first {
                a = middle;
            } else {
                b = middle;
            }
        }
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }
}

/// Where a line begins: an end of an open one, or anywhere.
fn begin(next: &BTreeMap<Edge, Vec<Edge>>, open: bool) -> Option<Edge> {
    next.iter()
        .find(|(_, to)| if open { to.len() == 1 } else { !to.is_empty() })
        .map(|(edge, _)| *edge)
}

/// Follows a line and takes what it passed out.
fn walk(next: &mut BTreeMap<Edge, Vec<Edge>>, start: Edge) -> Vec<Edge> {
    let mut line = vec![start];
    let mut at = start;
    while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
        if let Some(back) = next.get_mut(&to)
            && let Some(place) = back.iter().position(|edge| *edge == at)
        {
            back.remove(place);
        }
        line.push(to);
        at = to;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(above: &dyn Fn(Place) -> bool) -> Vec<Vec<Place>> {
        const N: usize = 41;
        let at = |i: usize, j: usize| {
            Some(above([i as f64 / (N - 1) as f64, j as f64 / (N - 1) as f64]))
        };
        Field { columns: N, rows: N, above: &at, above_at: above }.lines()
    }

    #[test]
    fn a_circle_is_one_ring_of_points_on_it() {
        let inside = |p: Place| (p[0] - 0.5).hypot(p[1] - 0.5) > 0.3;
        let lines = lines(&inside);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        for p in &lines[0] {
            assert!(((p[0] - 0.5).hypot(p[1] - 0.5) - 0.3).abs() < 1e-4, "{p:?}");
        }
    }

    #[test]
    fn two_bands_are_two_open_lines_from_edge_to_edge() {
        let lines = lines(&|p| p[1] > 0.3 && p[1] < 0.7);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| line.len() == 41));
    }
}
