//! Words inside a panel: where they go so that they cover as little as possible.

use crate::curve::{self, Point, Window};
use crate::error::Error;
use crate::figure::{Layer, Text, TextPlace};
use crate::font::{self, Label};
use crate::panel::PanelPlan;
use crate::sheet::{Rect, Sheet, centred, lines};
use crate::style::{INK, SMALL_PT};

/// Distance of words from the plot's edges and from the point they name, in pt.
const OFF_PT: f64 = 3.0;

/// Draws the words of a text layer over everything else in their panel.
pub(crate) fn draw(sheet: &mut Sheet, text: &Text, plan: &PanelPlan<'_>) -> Result<(), Error> {
    let plot = plan.plot.grown(-OFF_PT);
    let mut block: Vec<Label> = Vec::new();
    for line in &text.lines {
        block.extend(sheet.fonts.block(line, SMALL_PT, plot.width())?);
    }
    let (width, height) = (font::widest_pt(&block), font::height_pt(&block));
    if height > plot.height() {
        let text = text.lines.join(" / ");
        return Err(Error::TextTooLong { text, need_pt: height, have_pt: plot.height() });
    }
    match (text.place, plan.x_scale(), plan.y_scale()) {
        (TextPlace::Over(x, y), Some(x_scale), Some(y_scale)) => {
            let middle = x_scale.pt(x).min(plot.right - width / 2.0).max(plot.left + width / 2.0);
            let top = (y_scale.pt(y) - OFF_PT - height).min(plot.bottom - height).max(plot.top);
            centred(sheet, &block, (middle, top), INK);
        }
        _ => {
            let corner = emptiest(corners(&plot, width, height), plan);
            lines(sheet, &block, (corner.left, corner.top), INK);
        }
    }
    Ok(())
}

/// Boxes of the given size in the corners: upper left, upper right, lower right, lower left.
fn corners(plot: &Rect, width: f64, height: f64) -> [Rect; 4] {
    let at = |left: f64, top: f64| Rect { left, top, right: left + width, bottom: top + height };
    let (right, low) = (plot.right - width, plot.bottom - height);
    [at(plot.left, plot.top), at(right, plot.top), at(right, low), at(plot.left, low)]
}

/// The first of the boxes that cover the fewest data.
fn emptiest(boxes: [Rect; 4], plan: &PanelPlan<'_>) -> Rect {
    let mut best = (f64::INFINITY, boxes[0]);
    for rect in boxes {
        let covered = covered(plan, &rect);
        if covered < best.0 {
            best = (covered, rect);
        }
    }
    best.1
}

/// How much of a panel's data lies inside a rectangle of the page: points by number, curves by
/// length in pt. Only for comparing places.
fn covered(plan: &PanelPlan<'_>, rect: &Rect) -> f64 {
    let (Some(x_scale), Some(y_scale)) = (plan.x_scale(), plan.y_scale()) else {
        return 0.0;
    };
    let page = |x: &[f64], y: &[f64]| -> Vec<Point> {
        x.iter().zip(y).map(|(&x, &y)| (x_scale.pt(x), y_scale.pt(y))).collect()
    };
    let window = Window { x: (rect.left, rect.right), y: (rect.top, rect.bottom) };
    let inside =
        |points: &[Point]| points.iter().filter(|&&point| window.holds(point)).count() as f64;
    let of_layer = |layer: &Layer| match layer {
        Layer::Line(line) => length(&page(&line.x, &line.y), &window),
        Layer::Band(b) => {
            length(&page(&b.x, &b.low), &window) + length(&page(&b.x, &b.high), &window)
        }
        Layer::Points(points) => inside(&page(&points.x, &points.y)),
        _ => 0.0,
    };
    plan.panel.layers.iter().map(of_layer).sum()
}

/// Length of the part of a curve inside the window.
fn length(points: &[Point], window: &Window) -> f64 {
    let parts = curve::cut_line(points, window);
    let pieces = parts
        .iter()
        .flat_map(|part| part.windows(2))
        .map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1));
    pieces.map(|(dx, dy)| (dx * dx + dy * dy).sqrt()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Cell, Figure, Line, Panel, Range};
    use crate::font::Fonts;

    /// Index of the corner that a diagonal through the panel leaves to the words.
    fn check(y: [f64; 2], expect: usize) {
        let line = Line { x: vec![0.0, 1.0], y: y.to_vec(), ..Line::default() };
        let axis = || Axis::new("", "").ranged(Range::Tight);
        let panel = Panel::new(Cell::at(0, 0), axis(), axis(), vec![Layer::Line(line)]);
        let figure = Figure { panels: vec![panel], ..Figure::default() };
        let page = crate::layout::plan(&figure, Fonts::bundled().unwrap()).unwrap();
        let boxes = corners(&page.panels[0].plot, 60.0, 20.0);
        assert_eq!(emptiest(boxes, &page.panels[0]), boxes[expect]);
    }

    #[test]
    fn words_go_to_the_first_corner_that_the_data_leave_free() {
        check([0.0, 1.0], 0);
        check([1.0, 0.0], 1);
    }
}
