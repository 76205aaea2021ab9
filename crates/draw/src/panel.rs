//! One panel, planned: its axes, its words, and the room they take around the plot area.

use crate::axis::{self, AxisPlan, PLOT_GAP_PT};
use crate::error::Error;
use crate::figure::{Direction, Figure, Panel, Range, Ticks};
use crate::font::{self, Fonts, Label};
use crate::grid::Decor;
use crate::references::{self, Word};
use crate::scale::{self, Ends, Scale};
use crate::sheet::Rect;
use crate::style::{LABEL_PT, SMALL_PT};

/// Least side of a plot area, in pt.
const LEAST_PLOT_PT: f64 = 20.0;
/// Share of a panel's width that its note may fill.
const NOTE_SHARE: f64 = 0.7;

/// A panel with its place on the page.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PanelPlan<'a> {
    pub(crate) panel: &'a Panel,
    pub(crate) plot: Rect,
    pub(crate) x: AxisPlan,
    pub(crate) y: AxisPlan,
    pub(crate) x_scale: Option<Scale>,
    pub(crate) y_scale: Option<Scale>,
    pub(crate) title: Vec<Label>,
    pub(crate) note: Vec<Label>,
    pub(crate) references: Vec<Word>,
    /// Room around the plot that this panel needs.
    pub(crate) decor: Decor,
    /// Room left of the plot that its column has: axis labels of a column line up at its far side.
    pub(crate) left_pt: f64,
}

/// Plans a panel whose plot area is `plot` and whose axes run between `ends`.
pub(crate) fn plan<'a>(
    figure: &Figure,
    fonts: &Fonts,
    panel: &'a Panel,
    ends: [Option<Ends>; 2],
    plot: Rect,
) -> Result<PanelPlan<'a>, Error> {
    let have_pt = plot.width().min(plot.height());
    if have_pt < LEAST_PLOT_PT {
        return Err(scale::wrong(
            panel,
            &format!(
                " has {have_pt:.0} pt of room for its data and needs {LEAST_PLOT_PT:.0}; make the figure larger or its labels shorter"
            ),
        ));
    }
    let [x_numbered, y_numbered] = numbered(figure, panel);
    let is_drawing = panel.x.ticks == Ticks::Bare && panel.y.ticks == Ticks::Bare;
    let axes = [&panel.x, &panel.y];
    let has_one_scale = axes.iter().all(|axis| matches!(axis.range, Range::OneScale(..)));
    let ends = if is_drawing || has_one_scale { one_scale(ends, &plot) } else { ends };
    let x = axis::plan(fonts, &panel.x, ends[0], Direction::Horizontal, plot.width(), x_numbered)?;
    let y = axis::plan(fonts, &panel.y, ends[1], Direction::Vertical, plot.height(), y_numbered)?;
    let title = match &panel.title {
        Some(title) => fonts.parted(title, LABEL_PT, plot.width())?,
        None => Vec::new(),
    };
    let note = match &panel.note {
        Some(note) => fonts.parted(note, SMALL_PT, NOTE_SHARE * plot.width())?,
        None => Vec::new(),
    };
    let x_scale = x.ends.map(|ends| Scale { ends, page_pt: (plot.left, plot.right) });
    // Numbers count upwards, names downwards.
    let page_pt = if y.named { (plot.top, plot.bottom) } else { (plot.bottom, plot.top) };
    let y_scale = y.ends.map(|ends| Scale { ends, page_pt });
    let references = match panel.note {
        None => references::plan(fonts, panel, x_scale, y_scale, &title, &plot)?,
        Some(_) => Vec::new(),
    };
    let decor = decor(&x, &y, &title, &references, &plot);
    Ok(PanelPlan {
        panel,
        plot,
        x,
        y,
        x_scale,
        y_scale,
        title,
        note,
        references,
        decor,
        left_pt: decor.left,
    })
}

/// The ends, the range of one axis grown to both sides so that a unit is as long on either.
fn one_scale(ends: [Option<Ends>; 2], plot: &Rect) -> [Option<Ends>; 2] {
    let [Some(x), Some(y)] = ends else { return ends };
    let unit = ((x.1 - x.0) / plot.width()).max((y.1 - y.0) / plot.height());
    [(x, plot.width()), (y, plot.height())].map(|((low, high), length_pt)| {
        let room = (unit * length_pt - (high - low)) / 2.0;
        Some((low - room, high + room))
    })
}

/// Room that a panel needs on its four sides.
fn decor(x: &AxisPlan, y: &AxisPlan, title: &[Label], references: &[Word], plot: &Rect) -> Decor {
    let (x_before, x_after) = x.overhang_pt(Direction::Horizontal, plot.width());
    let (y_before, y_after) = y.overhang_pt(Direction::Vertical, plot.height());
    let words_right = references.iter().map(|word| word.at.0 + word.label.width_pt - plot.right);
    let words_top = references.iter().map(|word| plot.top - word.at.1 + word.label.ascent_pt());
    let heading = if title.is_empty() { 0.0 } else { PLOT_GAP_PT + font::height_pt(title) };
    Decor {
        left: y.depth_pt(Direction::Vertical).max(x_before),
        right: words_right.fold(x_after, f64::max),
        top: words_top.fold(heading.max(y_after), f64::max),
        bottom: x.depth_pt(Direction::Horizontal).max(y_before),
    }
}

/// Whether a panel's x and y axis carry numbers: not where the panel below, or to the left, shares
/// that axis.
fn numbered(figure: &Figure, panel: &Panel) -> [bool; 2] {
    // The neighbour must cover the same columns, or rows: else its numbers do not line up with
    // these.
    let (cell, x, y) = (panel.cell, &panel.x.link, &panel.y.link);
    let mut numbered = [true; 2];
    for other in &figure.panels {
        let o = other.cell;
        let is_below =
            o.row == cell.row + cell.rows && (o.column, o.columns) == (cell.column, cell.columns);
        let is_left =
            o.column + o.columns == cell.column && (o.row, o.rows) == (cell.row, cell.rows);
        numbered[0] &= !(is_below && x.is_some() && *x == other.x.link);
        numbered[1] &= !(is_left && y.is_some() && *y == other.y.link);
    }
    numbered
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Cell};

    /// One unit of a panel with a line is as long across as upwards; and what else its plan has.
    fn check_one_scale(axis: fn() -> Axis, check: fn(&PanelPlan)) {
        let line =
            crate::figure::Line { x: vec![0.0, 1.0], y: vec![0.0, 1.0], ..Default::default() };
        let layers = vec![crate::figure::Layer::Line(line)];
        let panel = Panel::new(Cell::at(0, 0), axis(), axis(), layers).tall(40.0);
        let figure = Figure { panels: vec![panel], ..Figure::default() };
        let page = crate::layout::plan(&figure, Fonts::bundled().unwrap()).unwrap();
        let plan = &page.panels[0];
        let length = |scale: Scale| (scale.pt(1.0) - scale.pt(0.0)).abs();
        let (x, y) = (length(plan.x_scale.unwrap()), length(plan.y_scale.unwrap()));
        assert!((x - y).abs() < 1e-9 && x > 0.0, "{x} pt across, {y} pt upwards");
        check(plan);
    }

    #[test]
    fn one_unit_of_axes_of_one_scale_is_as_long_on_either_and_numbered() {
        let axis = || Axis::new("x", "mm").ranged(Range::OneScale(-50.0, 50.0));
        check_one_scale(axis, |plan| {
            assert!(!plan.x.ticks.is_empty() && plan.y.ends == Some((-50.0, 50.0)));
        });
    }

    #[test]
    fn one_unit_of_a_bare_panel_is_as_long_across_as_upwards() {
        check_one_scale(
            || Axis::bare(-1.0, 1.0),
            |plan| {
                assert!(plan.x.ticks.is_empty() && plan.y.ticks.is_empty());
                assert_eq!(plan.decor, Decor::default(), "no room is taken around it");
            },
        );
    }

    #[test]
    fn stacked_panels_number_a_shared_axis_once() {
        let axis = |link: &str| Axis::new("t", "s").linked(link);
        let panel = |row, link: &str| {
            Panel::new(Cell::at(row, 0), axis(link), Axis::new("F", "N"), Vec::new())
        };
        let figure = Figure {
            panels: vec![panel(0, "t"), panel(1, "t"), panel(2, "other")],
            ..Figure::default()
        };
        let x_numbered: Vec<bool> =
            figure.panels.iter().map(|panel| numbered(&figure, panel)[0]).collect();
        assert_eq!(x_numbered, [false, true, true]);
        assert!(figure.panels.iter().all(|panel| numbered(&figure, panel)[1]));
    }
}
