//! Draws a planned page: frames, ticks, words, and the data between them.

use crate::axis::{AxisPlan, PLOT_GAP_PT, PlannedTick, TICK_GAP_PT};
use crate::error::Error;
use crate::figure::{Direction, Layer};
use crate::font::{self, Label};
use crate::layers;
use crate::layout::{MARK_PAD_PT, Plan};
use crate::legend;
use crate::panel::PanelPlan;
use crate::scale::Scale;
use crate::sheet::{At, Rect, Sheet, centred, lines};
use crate::style::{self, AXIS_PT, GREY, GRID, GRID_PT, INK, MARK, PAPER, Stroke, TICK_PT};
use crate::words;

/// Draws the page.
pub(crate) fn draw(sheet: &mut Sheet, plan: &Plan<'_>) -> Result<(), Error> {
    let page = Rect { left: 0.0, top: 0.0, right: plan.width_pt, bottom: plan.height_pt };
    // SVG and PDF have no paper of their own: on a dark screen the ink would not be seen.
    sheet.rect(&page, PAPER, 1.0);
    lines(sheet, &plan.title.0, plan.title.1, INK);
    if let Some((label, frame)) = &plan.mark {
        let stroke = Stroke { width_pt: 0.8, ..style::mean(MARK) };
        sheet.frame(&frame.grown(-stroke.width_pt / 2.0), 2.0, &stroke);
        let start = (frame.left + MARK_PAD_PT.0, frame.bottom - MARK_PAD_PT.1);
        sheet.text(label, start, MARK, false);
    }
    legend::draw(sheet, &plan.legend.0, plan.legend.1);
    for panel in &plan.panels {
        draw_panel(sheet, panel, (plan.width_pt, plan.height_pt))?;
    }
    lines(sheet, &plan.footnotes.0, (plan.title.1.0, plan.footnotes.1), GREY);
    Ok(())
}

fn draw_panel(sheet: &mut Sheet, plan: &PanelPlan<'_>, size_pt: (f64, f64)) -> Result<(), Error> {
    // The grid lies under the data, the axes and all words over them.
    grid_lines(sheet, plan);
    if plan.note.is_empty() {
        layers::draw(sheet, plan, size_pt)?;
    }
    axis_lines(sheet, plan);
    x_labels(sheet, plan);
    y_labels(sheet, plan);
    let plot = &plan.plot;
    let title_top = plot.top - PLOT_GAP_PT - font::height_pt(&plan.title);
    lines(sheet, &plan.title, (plot.left, title_top), INK);
    for word in &plan.references {
        sheet.text(&word.label, word.at, GREY, false);
    }
    let note_top = (plot.top + plot.bottom - font::height_pt(&plan.note)) / 2.0;
    centred(sheet, &plan.note, ((plot.left + plot.right) / 2.0, note_top), GREY);
    // Words avoid those of the layers before theirs.
    let mut taken = Vec::new();
    for layer in plan.panel.layers.iter().filter(|_| plan.note.is_empty()) {
        if let Layer::Text(text) = layer {
            words::draw(sheet, text, plan, &mut taken)?;
        }
    }
    Ok(())
}

/// Length of a tick between two powers of ten, in pt.
const MINOR_TICK_PT: f64 = 0.5 * TICK_PT;

fn length_pt(tick: &PlannedTick) -> f64 {
    if tick.minor { MINOR_TICK_PT } else { TICK_PT }
}

/// Each tick with its place on the page.
fn places(axis: &AxisPlan, scale: Option<Scale>) -> impl Iterator<Item = (&PlannedTick, f64)> {
    axis.ticks.iter().filter_map(move |tick| scale.map(|scale| (tick, scale.pt(tick.at))))
}

fn grid_lines(sheet: &mut Sheet, plan: &PanelPlan<'_>) {
    if !plan.note.is_empty() {
        return; // lines would run through the words
    }
    let pen = Stroke { width_pt: GRID_PT, ..style::mean(GRID) };
    let Rect { left, top, right, bottom } = plan.plot;
    let PanelPlan { x, y, .. } = plan;
    for (_, at) in places(x, plan.x_scale).filter(|(tick, _)| !x.named && !tick.minor) {
        sheet.stroke(&[(at, top), (at, bottom)], &pen);
    }
    for (_, at) in places(y, plan.y_scale).filter(|(tick, _)| !y.named && !tick.minor) {
        sheet.stroke(&[(left, at), (right, at)], &pen);
    }
}

/// The left and lower edge of the plot, and ticks outwards. Beside names and on a bare axis there
/// is no edge.
fn axis_lines(sheet: &mut Sheet, plan: &PanelPlan<'_>) {
    let pen = Stroke { width_pt: AXIS_PT, ..style::mean(INK) };
    let Rect { left, top, right, bottom } = plan.plot;
    let corner = [(left, top), (left, bottom), (right, bottom)];
    match (plan.x.bare, plan.y.named || plan.y.bare) {
        (false, false) => sheet.stroke(&corner, &pen),
        (false, true) => sheet.stroke(&corner[1..], &pen),
        (true, false) => sheet.stroke(&corner[..2], &pen),
        (true, true) => {}
    }
    for (tick, x) in places(&plan.x, plan.x_scale).filter(|_| !plan.x.named) {
        sheet.stroke(&[(x, bottom), (x, bottom + length_pt(tick))], &pen);
    }
    for (tick, y) in places(&plan.y, plan.y_scale).filter(|_| !plan.y.named) {
        sheet.stroke(&[(left, y), (left - length_pt(tick), y)], &pen);
    }
}

fn x_labels(sheet: &mut Sheet, plan: &PanelPlan<'_>) {
    let plot = &plan.plot;
    let top = plot.bottom + TICK_PT + TICK_GAP_PT;
    for (tick, x) in places(&plan.x, plan.x_scale) {
        if plan.x.turned {
            let left = x - font::height_pt(&tick.lines) / 2.0;
            let longest = font::widest_pt(&tick.lines);
            upwards(sheet, &tick.lines, (left, top), |line| longest - line.width_pt);
        } else {
            centred(sheet, &tick.lines, (x, top), INK);
        }
    }
    let under =
        plot.bottom + plan.x.depth_pt(Direction::Horizontal) - font::height_pt(&plan.x.label);
    centred(sheet, &plan.x.label, ((plot.left + plot.right) / 2.0, under), INK);
}

fn y_labels(sheet: &mut Sheet, plan: &PanelPlan<'_>) {
    let plot = &plan.plot;
    let right = plot.left - TICK_PT - TICK_GAP_PT;
    for (tick, y) in places(&plan.y, plan.y_scale) {
        // centred by the capitals' height, which is what digits have
        let line_pt = tick.lines.first().map_or(0.0, Label::height_pt);
        let first = y - (tick.lines.len().saturating_sub(1)) as f64 * line_pt / 2.0
            + tick.lines.first().map_or(0.0, Label::cap_pt) / 2.0;
        for (i, line) in tick.lines.iter().enumerate() {
            sheet.text(line, (right - line.width_pt, first + i as f64 * line_pt), INK, false);
        }
    }
    let at = (plot.left - plan.left_pt, plot.top);
    upwards(sheet, &plan.y.label, at, |line| (plot.height() - line.width_pt) / 2.0);
}

/// Lines that read upwards, side by side from `left`; `from_top` is how far below `top` a line
/// ends.
fn upwards(
    sheet: &mut Sheet,
    block: &[Label],
    (mut left, top): At,
    from_top: impl Fn(&Label) -> f64,
) {
    for line in block {
        let base = (left + line.ascent_pt(), top + from_top(line) + line.width_pt);
        sheet.text(line, base, INK, true);
        left += line.height_pt();
    }
}
