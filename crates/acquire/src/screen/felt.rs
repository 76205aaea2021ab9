//! What is felt: the user's force against the angle, with the trials of the same condition before
//! it, the force that the environment commands, and its wall. Only where a window is wide enough to
//! have it beside the traces.

use super::look::{Look, Role};
use super::place::{cut, cut_left};
use super::trace::{GUTTER, colour, force_ends, marker};
use crate::{Point, View};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Context, Line as Segment};

/// From so many columns on there is room for it: the traces keep what they have in a window of 80.
const WIDE: u16 = 112;

/// Its share of those columns.
const SHARE: u16 = 3;

/// Dashes of the wall, from the bottom to the top.
const DASHES: u16 = 8;

/// The traces' part of an area, and the part of what is felt; it has no columns where there is no
/// room for it.
pub(super) fn split(area: Rect) -> [Rect; 2] {
    if area.width < WIDE {
        return [area, Rect { x: area.right(), width: 0, ..area }];
    }
    let (traces, felt) = cut_left(area, area.width - area.width / SHARE);
    let (_, felt) = cut_left(felt, 2);
    [traces, felt]
}

/// Draws it.
pub(super) fn draw(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    if area.width <= GUTTER {
        return;
    }
    let (title, rest) = cut(area, 1);
    let (plot, axis) = cut(rest, rest.height.saturating_sub(1));
    let ends = view.theta_range_rad;
    let (left, right) = (ends.0.to_degrees(), ends.1.to_degrees());
    let (low, high) = force_ends(view);
    let quiet = look.style(Role::Quiet);
    let earlier = view.earlier_alike().count();
    let ghosts = match earlier {
        0 => String::new(),
        1 => "  · one before".to_owned(),
        n => format!("  · {n} before"),
    };
    Line::from_iter([
        Span::styled(if look.ascii { "force (N) at angle" } else { "force (N) at angle θ" }, quiet),
        Span::styled(ghosts, quiet),
    ])
    .render(title, buffer);
    let (gutter, inside) = cut_left(plot, GUTTER);
    for (row, cells) in (0..).zip(gutter.rows()) {
        let label = match row {
            0 => format!("{high:.0}"),
            row if row + 1 == gutter.height => format!("{low:.0}"),
            _ => String::new(),
        };
        let text = format!("{label:>width$}│", width = usize::from(GUTTER) - 1);
        Line::styled(text, quiet).render(cells, buffer);
    }
    Canvas::default()
        .x_bounds([left, right])
        .y_bounds([low, high])
        .paint(|context| paint(context, view, look, [low, high]))
        .render(inside, buffer);
    let (_, axis) = cut_left(axis, GUTTER);
    let unit = if look.ascii { " deg" } else { "°" };
    Line::styled(format!("{left:.0}"), quiet).render(axis, buffer);
    Line::styled(format!("{right:.0}{unit}"), quiet).right_aligned().render(axis, buffer);
}

/// What came before lies below what comes now.
fn paint(context: &mut Context<'_>, view: &View, look: Look, [low, high]: [f64; 2]) {
    let segment = |from: [f64; 2], to: [f64; 2], shade: Color| {
        Segment::new(from[0], from[1], to[0], to[1], colour(shade, look))
    };
    let at = |point: &Point| [point.theta_rad.to_degrees(), point.force_ex_n.clamp(low, high)];
    context.marker(marker('.', look));
    for points in view.earlier_alike() {
        for pair in points.windows(2) {
            context.draw(&segment(at(&pair[0]), at(&pair[1]), Color::DarkGray));
        }
    }
    context.layer();
    if let Some(wall_rad) = view.wall_rad {
        context.marker(marker('|', look));
        let (wall, step) = (wall_rad.to_degrees(), (high - low) / f64::from(2 * DASHES));
        for dash in (0..2 * DASHES).step_by(2) {
            let from = low + f64::from(dash) * step;
            context.draw(&segment([wall, from], [wall, from + step], Color::Yellow));
        }
    }
    context.marker(marker('-', look));
    for pair in view.law.windows(2) {
        // What lies beyond the scale is not drawn along its edge.
        if pair.iter().all(|(_, n)| (low..=high).contains(n)) {
            let ends = [pair[0], pair[1]].map(|(rad, n)| [rad.to_degrees(), n]);
            context.draw(&segment(ends[0], ends[1], Color::Yellow));
        }
    }
    context.layer();
    context.marker(marker('*', look));
    let mut before: Option<[f64; 2]> = None;
    for point in view.trace.iter().filter(|point| point.force_ex_n.is_finite()) {
        let here = at(point);
        if let Some(before) = before {
            context.draw(&segment(before, here, Color::Green));
        }
        before = Some(here);
    }
}
