//! Places plot areas in a grid so that their edges line up whatever is around them.

use crate::figure::Cell;
use crate::sheet::Rect;

/// Room that a panel needs around its plot area, in pt.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Decor {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

/// Start and end of each track's plot area.
type Tracks = Vec<(f64, f64)>;

/// Number of rows and columns that the cells cover.
pub(crate) fn size(cells: &[Cell]) -> (usize, usize) {
    let rows = cells.iter().map(|c| c.row + c.rows).max().unwrap_or(0);
    let columns = cells.iter().map(|c| c.column + c.columns).max().unwrap_or(0);
    (rows, columns)
}

/// No page holds more rows or columns than this.
const MOST_TRACKS: usize = 50;

/// First cell that is empty, out of bounds, or overlaps an earlier one.
pub(crate) fn clash(cells: &[Cell]) -> Option<usize> {
    (0..cells.len()).find(|&i| {
        let b = &cells[i];
        // Checked before the sums below, which a cell far out of bounds would make overflow.
        let is_sound = [(b.row, b.rows), (b.column, b.columns)]
            .iter()
            .all(|(first, count)| *first < MOST_TRACKS && (1..=MOST_TRACKS).contains(count));
        let mut earlier = cells[..i].iter();
        !is_sound
            || earlier.any(|a| {
                let is_apart = a.row + a.rows <= b.row
                    || b.row + b.rows <= a.row
                    || a.column + a.columns <= b.column
                    || b.column + b.columns <= a.column;
                !is_apart
            })
    })
}

/// Room before and after each track: the most that any panel starting or ending there needs.
fn margins(count: usize, spans: impl Iterator<Item = (usize, usize, f64, f64)>) -> Vec<(f64, f64)> {
    let mut margins = vec![(0.0_f64, 0.0_f64); count];
    for (first, len, before, after) in spans {
        margins[first].0 = margins[first].0.max(before);
        margins[first + len - 1].1 = margins[first + len - 1].1.max(after);
    }
    margins
}

pub(crate) fn column_margins(cells: &[Cell], decor: &[Decor]) -> Vec<(f64, f64)> {
    let spans = cells.iter().zip(decor).map(|(c, d)| (c.column, c.columns, d.left, d.right));
    margins(size(cells).1, spans)
}

pub(crate) fn row_margins(cells: &[Cell], decor: &[Decor]) -> Vec<(f64, f64)> {
    let spans = cells.iter().zip(decor).map(|(c, d)| (c.row, c.rows, d.top, d.bottom));
    margins(size(cells).0, spans)
}

/// Lengths of tracks that share what the margins and gaps leave of `whole`, by weight. May be
/// negative.
pub(crate) fn share(whole: f64, margins: &[(f64, f64)], gap: f64, weights: &[f64]) -> Vec<f64> {
    let taken: f64 = margins.iter().map(|(a, b)| a + b).sum::<f64>()
        + gap * margins.len().saturating_sub(1) as f64;
    // Negative lengths are refused by the panel that gets one, which can say how much it lacks.
    let total: f64 = weights.iter().sum();
    weights.iter().map(|weight| (whole - taken) * weight / total).collect()
}

/// Tracks of the given lengths from `start` on.
pub(crate) fn tracks(start: f64, margins: &[(f64, f64)], gap: f64, lengths: &[f64]) -> Tracks {
    let mut at = start;
    let mut tracks = Vec::new();
    for (&(before, after), &length) in margins.iter().zip(lengths) {
        let from = at + before;
        at = from + length + after + gap;
        tracks.push((from, from + length));
    }
    tracks
}

/// The plot area of a cell.
pub(crate) fn plot(cell: &Cell, columns: &Tracks, rows: &Tracks) -> Rect {
    Rect {
        left: columns[cell.column].0,
        right: columns[cell.column + cell.columns - 1].1,
        top: rows[cell.row].0,
        bottom: rows[cell.row + cell.rows - 1].1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_of_a_column_line_up_though_their_labels_differ_in_width() {
        let cells = [Cell::at(0, 0), Cell::at(1, 0), Cell::at(0, 1).spanning(2, 1)];
        let decor =
            [20.0, 34.0, 25.0].map(|left| Decor { left, right: 4.0, top: 3.0, bottom: 10.0 });
        let margins = column_margins(&cells, &decor);
        let widths = share(300.0, &margins, 10.0, &[1.0, 1.0]);
        let columns = tracks(0.0, &margins, 10.0, &widths);
        let rows = tracks(0.0, &row_margins(&cells, &decor), 10.0, &[50.0, 70.0]);
        let plots: Vec<Rect> = cells.iter().map(|cell| plot(cell, &columns, &rows)).collect();
        assert_eq!((plots[0].left, plots[0].right), (plots[1].left, plots[1].right));
        assert_eq!((plots[2].top, plots[2].bottom), (plots[0].top, plots[1].bottom));
        assert_eq!(plots[0].left, 34.0);
        assert!((plots[2].right - 296.0).abs() < 1e-9);
        assert!((plots[0].width() - plots[2].width()).abs() < 1e-9);
    }

    #[test]
    fn overlapping_and_empty_cells_are_found() {
        assert_eq!(clash(&[Cell::at(0, 0), Cell::at(0, 1)]), None);
        assert_eq!(clash(&[Cell::at(0, 0).spanning(2, 2), Cell::at(1, 1)]), Some(1));
        assert_eq!(clash(&[Cell::at(0, 0).spanning(0, 1)]), Some(0));
        assert_eq!(clash(&[Cell::at(usize::MAX, 0)]), Some(0));
    }
}
