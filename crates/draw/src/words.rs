//! Words inside a panel: where they go so that they cover as little as possible.

use crate::curve::{self, Point, Window};
use crate::error::Error;
use crate::figure::{Layer, Text, TextPlace};
use crate::font::{self, Fonts, Label};
use crate::panel::PanelPlan;
use crate::sheet::{Rect, Sheet, centred, lines};
use crate::style::{INK, SMALL_PT};

/// Distance of words from the plot's edges and from the point they name, in pt.
const OFF_PT: f64 = 3.0;
/// Room between words and the box that they stand in, in pt.
const INSIDE_PT: f64 = 1.5;

/// Draws the words of a text layer over everything else in their panel, beside the words that have
/// taken a place before, to which it adds its own.
pub(crate) fn draw(
    sheet: &mut Sheet,
    text: &Text,
    plan: &PanelPlan<'_>,
    taken: &mut Vec<Rect>,
) -> Result<(), Error> {
    let plot = plan.plot.grown(-OFF_PT);
    let x = plan.x_scale;
    let y = plan.y_scale;
    let page = |(at_x, at_y): Point| Some((x?.pt(at_x), y?.pt(at_y)));
    if let TextPlace::Within(low, high) = text.place
        && let (Some((left, bottom)), Some((right, top))) = (page(low), page(high))
    {
        let room = Rect { left, top, right, bottom }.grown(-INSIDE_PT);
        let block = fitted(sheet.fonts, &text.lines, &room)?;
        let top = (room.top + room.bottom - font::height_pt(&block)) / 2.0;
        centred(sheet, &block, ((left + right) / 2.0, top), INK);
        return Ok(());
    }
    let block = wrapped(sheet.fonts, &text.lines, plot.width())?;
    let width = font::widest_pt(&block);
    let height = font::height_pt(&block);
    if height > plot.height() {
        let text = text.lines.join(" / ");
        return Err(Error::TextTooLong { text, need_pt: height, have_pt: plot.height() });
    }
    // how far the upper left corner lies from the point
    let (at, (dx, dy)) = match text.place {
        TextPlace::Over(x, y) => ((x, y), (-width / 2.0, -OFF_PT - height)),
        TextPlace::Amid(x, y) => ((x, y), (-width / 2.0, -height / 2.0)),
        TextPlace::RightOf(x, y) => ((x, y), (OFF_PT, -height / 2.0)),
        TextPlace::LeftOf(x, y) => ((x, y), (-OFF_PT - width, -height / 2.0)),
        // No place of its own, or one on axes that the panel does not have: into a corner.
        TextPlace::EmptiestCorner | TextPlace::Within(..) => ((f64::NAN, f64::NAN), (0.0, 0.0)),
    };
    match page(at).filter(|(x, y)| x.is_finite() && y.is_finite()) {
        Some((x, y)) => {
            let left = (x + dx).min(plot.right - width).max(plot.left);
            let top = (y + dy).min(plot.bottom - height).max(plot.top);
            let wish = Rect { left, top, right: left + width, bottom: top + height };
            let Rect { left, top, .. } = free(wish, &plot, taken);
            taken.push(Rect { left, top, right: left + width, bottom: top + height });
            match text.place {
                TextPlace::RightOf(..) => lines(sheet, &block, (left, top), INK),
                _ => centred(sheet, &block, (left + width / 2.0, top), INK),
            }
        }
        None => {
            let corner = emptiest(corners(&plot, width, height), plan);
            taken.push(corner);
            lines(sheet, &block, (corner.left, corner.top), INK);
        }
    }
    Ok(())
}

/// The place nearest to a wish, upwards and downwards first, that no other words have taken; the
/// wish where there is none.
fn free(wish: Rect, plot: &Rect, taken: &[Rect]) -> Rect {
    /// How far it moves at a time, pt.
    const STEP_PT: f64 = 2.0;
    /// Lines may stand this much closer than the room between lines, pt.
    const CLOSER_PT: f64 = 1.5;
    let is_free = |rect: &Rect| {
        taken.iter().all(|other| {
            rect.right <= other.left
                || other.right <= rect.left
                || rect.bottom <= other.top + CLOSER_PT
                || other.bottom <= rect.top + CLOSER_PT
        })
    };
    if is_free(&wish) {
        return wish;
    }
    let [across, along] =
        [plot.width(), plot.height()].map(|length_pt| (length_pt / STEP_PT) as i32);
    let mut nearest: Option<(f64, Rect)> = None;
    for i in -across..=across {
        for j in -along..=along {
            let dx = STEP_PT * f64::from(i);
            let dy = STEP_PT * f64::from(j);
            // Sideways a word leaves what it names sooner than up or down.
            let far = 4.0 * dx.abs() + dy.abs();
            let rect = Rect {
                left: wish.left + dx,
                right: wish.right + dx,
                top: wish.top + dy,
                bottom: wish.bottom + dy,
            };
            let is_nearer = nearest.as_ref().is_none_or(|(least, _)| far < *least);
            let is_inside = rect.left >= plot.left
                && rect.right <= plot.right
                && rect.top >= plot.top
                && rect.bottom <= plot.bottom;
            if is_nearer && is_inside && is_free(&rect) {
                nearest = Some((far, rect));
            }
        }
    }
    nearest.map_or(wish, |(_, rect)| rect)
}

/// Lines wrapped to a width.
fn wrapped(fonts: &Fonts, lines: &[String], width_pt: f64) -> Result<Vec<Label>, Error> {
    let mut block = Vec::new();
    for line in lines {
        block.extend(fonts.block(line, SMALL_PT, width_pt)?);
    }
    Ok(block)
}

/// Lines in a box: wrapped, and cut off where that is not enough.
fn fitted(fonts: &Fonts, lines: &[String], room: &Rect) -> Result<Vec<Label>, Error> {
    let in_box = |lines: &[String]| match wrapped(fonts, lines, room.width()) {
        Err(Error::TextTooLong { .. }) => Ok(None),
        Err(error) => Err(error),
        Ok(block) => Ok(Some(block).filter(|b| font::height_pt(b) <= room.height())),
    };
    if let Some(block) = in_box(lines)? {
        return Ok(block);
    }
    // By halves: each try sets all lines anew.
    let longest = lines.iter().map(|l| l.chars().count()).max().unwrap_or(0);
    let mut fits = 0;
    let mut too_long = longest;
    while too_long - fits > 1 {
        let most = usize::midpoint(fits, too_long);
        match in_box(&shortened(lines, most))? {
            Some(_) => fits = most,
            None => too_long = most,
        }
    }
    in_box(&shortened(lines, fits))?.ok_or_else(|| {
        let need_pt = lines.len() as f64 * fonts.line_height_pt(SMALL_PT);
        Error::TextTooLong { text: lines.join(" / "), need_pt, have_pt: room.height() }
    })
}

/// The first so many signs of each line, and that it goes on.
fn shortened(lines: &[String], most: usize) -> Vec<String> {
    let shortened = lines.iter().map(|line| match line.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.clone(),
    });
    shortened.collect()
}

/// Boxes of the given size in the corners: upper left, upper right, lower right, lower left.
fn corners(plot: &Rect, width: f64, height: f64) -> [Rect; 4] {
    let at = |left: f64, top: f64| Rect { left, top, right: left + width, bottom: top + height };
    let right = plot.right - width;
    let low = plot.bottom - height;
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
    let (Some(x_scale), Some(y_scale)) = (plan.x_scale, plan.y_scale) else { return 0.0 };
    let page = |x: &[f64], y: &[f64]| -> Vec<Point> {
        x.iter().zip(y).map(|(&x, &y)| (x_scale.pt(x), y_scale.pt(y))).collect()
    };
    let window = Window { x: (rect.left, rect.right), y: (rect.top, rect.bottom) };
    let parts = plan.panel.layers.iter().map(|layer| match layer {
        Layer::Line(line) => length(&page(&line.x, &line.y), &window),
        Layer::Band(b) => {
            length(&page(&b.x, &b.low), &window) + length(&page(&b.x, &b.high), &window)
        }
        Layer::Points(points) => {
            let points = page(&points.x, &points.y);
            points.iter().filter(|&&point| window.holds(point)).count() as f64
        }
        _ => 0.0,
    });
    parts.sum()
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

    /// Lines set in a box of that size, in pt.
    fn in_box(lines: &[&str], (width, height): (f64, f64)) -> Vec<Label> {
        let room = Rect { left: 0.0, top: 0.0, right: width, bottom: height };
        let lines: Vec<String> = lines.iter().map(|l| (*l).to_owned()).collect();
        let block = fitted(Fonts::bundled().unwrap(), &lines, &room).unwrap();
        assert!(font::widest_pt(&block) <= width && font::height_pt(&block) <= height);
        block
    }

    #[test]
    fn words_in_a_box_wrap_then_are_cut_off_and_never_shrink() {
        let text = |block: &[Label]| block.iter().map(Label::text).collect::<Vec<_>>();
        let wide = in_box(&["equations of motion"], (60.0, 30.0));
        assert_eq!((text(&wide).len(), wide[0].size_pt), (2, SMALL_PT));
        let low = in_box(&["equations of motion"], (60.0, 16.0));
        assert_eq!((text(&low), low[0].size_pt), (vec!["equations of mo…".to_owned()], SMALL_PT));
        let cut = text(&in_box(&["one", &"W".repeat(1000)], (60.0, 30.0)));
        assert_eq!(cut[0], "one");
        assert!(cut[1].starts_with("WWW") && cut[1].ends_with('…'), "{cut:?}");
    }

    #[test]
    fn words_go_to_the_first_corner_that_the_data_leave_free() {
        check([0.0, 1.0], 0);
        check([1.0, 0.0], 1);
    }
}
