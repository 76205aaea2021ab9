//! Divides areas of the screen by plain sums: a constraint solver, run for every frame, would cost
//! more than all the drawing.

use ratatui::layout::Rect;

/// Rows of an area from its top, by their heights; where it ends, they are empty.
pub(super) fn rows<const N: usize>(area: Rect, heights: [u16; N]) -> [Rect; N] {
    let mut rest = area;
    heights.map(|height| {
        let (row, below) = cut(rest, height);
        rest = below;
        row
    })
}

/// An area cut into its first rows and the rest.
pub(super) fn cut(area: Rect, height: u16) -> (Rect, Rect) {
    let height = height.min(area.height);
    (Rect { height, ..area }, Rect { y: area.y + height, height: area.height - height, ..area })
}

/// An area cut into its first columns and the rest.
pub(super) fn cut_left(area: Rect, width: u16) -> (Rect, Rect) {
    let width = width.min(area.width);
    (Rect { width, ..area }, Rect { x: area.x + width, width: area.width - width, ..area })
}

/// Two halves side by side with a gap between them.
pub(super) fn halves(area: Rect, gap: u16) -> [Rect; 2] {
    let width = area.width.saturating_sub(gap) / 2;
    let (left, rest) = cut_left(area, width);
    [left, Rect { x: rest.right() - width, width, ..rest }]
}

/// `n` parts one above the other, as high as one another; a row more for the first ones where it
/// does not divide.
pub(super) fn shares(area: Rect, n: u16) -> impl Iterator<Item = Rect> {
    let (height, more) = (area.height / n, area.height % n);
    (0..n).map(move |i| {
        let y = area.y + i * height + i.min(more);
        Rect { y, height: height + u16::from(i < more), ..area }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Rect = Rect { x: 2, y: 3, width: 11, height: 7 };

    #[test]
    fn rows_follow_each_other_and_end_with_the_area() {
        let [a, b, c] = rows(AREA, [2, 4, 4]);
        assert_eq!([a.y, b.y, c.y, c.height], [3, 5, 9, 1]);
    }

    #[test]
    fn halves_are_as_wide_as_one_another() {
        assert_eq!(halves(AREA, 2).map(|half| (half.x, half.width)), [(2, 4), (9, 4)]);
        assert_eq!(halves(Rect { width: 1, ..AREA }, 2).map(|half| half.width), [0, 0]);
    }

    #[test]
    fn shares_fill_the_area() {
        let shares: Vec<(u16, u16)> = shares(AREA, 2).map(|r| (r.y, r.height)).collect();
        assert_eq!(shares, [(3, 4), (7, 3)]);
    }
}
