//! Where everything is on the page.
//!
//! From top to bottom: heading and stamp, legend, the grid of panels, legend (if below), footnotes.
//! The grid is solved in rounds, because the room for tick labels depends on the ticks, and those
//! on the size of the plot.

use crate::axis;
use crate::error::Error;
use crate::figure::{Cell, Figure, LegendPlace, Ticks};
use crate::font::{self, Fonts, Label};
use crate::grid::{self, Decor};
use crate::legend::{self, Legend};
use crate::panel::{self, PanelPlan};
use crate::scale;
use crate::sheet::{At, PT_PER_MM, Rect};
use crate::style::{SMALL_PT, TITLE_PT};

/// Free edge of the page, in pt: nothing is cut off by a hair.
const PAGE_MARGIN_PT: f64 = 2.0;
/// Between columns, and between rows, of the grid, in pt.
const GRID_GAP_PT: (f64, f64) = (14.0, 7.0);
/// Between the page's blocks (heading, legend, grid, footnotes), in pt.
const BLOCK_GAP_PT: f64 = 5.0;
/// Between the figure's heading and the legend under it, in pt.
const TITLE_GAP_PT: f64 = 1.5;
/// Rounds of the grid's solution; ticks settle in two.
const ROUNDS: usize = 3;
/// Room inside the stamp around its letters, in pt: sideways, up and down.
pub(crate) const MARK_PAD_PT: (f64, f64) = (4.0, 2.2);

/// The whole page.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plan<'a> {
    pub(crate) width_pt: f64,
    pub(crate) height_pt: f64,
    pub(crate) title: (Vec<Label>, At),
    pub(crate) mark: Option<(Label, Rect)>,
    pub(crate) legend: (Legend, At),
    pub(crate) panels: Vec<PanelPlan<'a>>,
    pub(crate) footnotes: (Vec<Label>, f64),
}

/// The most that a page may measure, in mm: ISO A0.
const MOST_MM: f64 = 1189.0;

fn check_size(what: &'static str, value: f64, most: f64) -> Result<(), Error> {
    if value > 0.0 && value <= most { Ok(()) } else { Err(Error::Size { what, value, most }) }
}

fn check(figure: &Figure) -> Result<(), Error> {
    if figure.panels.is_empty() {
        return Err(Error::NoPanels);
    }
    check_size("width_mm", figure.width_mm, MOST_MM)?;
    if let Some(height) = figure.height_mm {
        check_size("height_mm", height, MOST_MM)?;
    }
    for panel in &figure.panels {
        if let Some(height) = panel.height_mm {
            check_size("a panel's height_mm", height, MOST_MM)?;
        }
        scale::check(panel)?;
    }
    for &weight in &figure.column_weights {
        check_size("a column's weight", weight, 1e6)?;
    }
    match grid::clash(&cells(figure)) {
        Some(i) => Err(scale::wrong(
            &figure.panels[i],
            " covers no cell of the grid, or one that another panel covers too",
        )),
        None => Ok(()),
    }
}

fn cells(figure: &Figure) -> Vec<Cell> {
    figure.panels.iter().map(|panel| panel.cell).collect()
}

/// Plans the page of a figure, refusing what cannot be drawn.
pub(crate) fn plan<'a>(figure: &'a Figure, fonts: &Fonts) -> Result<Plan<'a>, Error> {
    // First of all: what follows indexes the grid by cells and divides by weights.
    check(figure)?;
    let width_pt = figure.width_mm * PT_PER_MM;
    let inner_pt = width_pt - 2.0 * PAGE_MARGIN_PT;
    let mark = mark(figure, fonts, width_pt)?;
    // A stamp that takes more than half of a narrow page stands above the heading, another beside
    // it.
    let above = mark.as_ref().filter(|(label, _)| label.width_pt > width_pt / 2.0);
    let head = PAGE_MARGIN_PT + above.map_or(0.0, |(_, frame)| frame.height() + BLOCK_GAP_PT);
    let beside = mark.as_ref().filter(|_| above.is_none());
    let (mark_width, mark_height) =
        beside.map_or((0.0, 0.0), |(_, frame)| (frame.width() + BLOCK_GAP_PT, frame.height()));
    let beside_mark_pt = inner_pt - mark_width;
    let title = match figure.title.as_ref().filter(|_| !figure.bare) {
        Some(title) => fonts.parted(&format!("**{title}**"), TITLE_PT, beside_mark_pt)?,
        None => Vec::new(),
    };
    let title_pt = if title.is_empty() { 0.0 } else { font::height_pt(&title) + TITLE_GAP_PT };
    let below = figure.legend == LegendPlace::Below;
    // under a heading the legend lies below the stamp as well
    let clear_of_mark = below || title_pt >= mark_height;
    let legend_room_pt = if clear_of_mark { inner_pt } else { beside_mark_pt };
    let legend = legend::plan(figure, fonts, legend_room_pt)?;
    let mut footnotes = Vec::new();
    for note in figure.footnotes.iter().filter(|_| !figure.bare) {
        footnotes.extend(fonts.parted(note, SMALL_PT, inner_pt)?);
    }

    let (above_pt, below_pt) =
        if below { (0.0, spaced(legend.height_pt())) } else { (legend.height_pt(), 0.0) };
    let top = head + spaced((title_pt + above_pt).max(mark_height));
    let foot_pt = below_pt + spaced(font::height_pt(&footnotes)) + PAGE_MARGIN_PT;
    let grid_pt = figure.height_mm.map(|mm| mm * PT_PER_MM - top - foot_pt);
    let (panels, bottom) = solve(figure, fonts, top, grid_pt)?;

    // The legend begins where the plots do, unless it would stick out to the right then.
    let plots_left = panels.iter().map(|panel| panel.plot.left).fold(width_pt, f64::min);
    let last_left = PAGE_MARGIN_PT + legend_room_pt - legend.width_pt();
    let legend_top = if below { bottom + BLOCK_GAP_PT } else { head + title_pt };
    Ok(Plan {
        width_pt,
        height_pt: bottom + foot_pt,
        title: (title, (PAGE_MARGIN_PT, head)),
        mark,
        legend: (legend, (plots_left.min(last_left).max(PAGE_MARGIN_PT), legend_top)),
        panels,
        footnotes: (footnotes, bottom + below_pt + BLOCK_GAP_PT),
    })
}

/// Height of a block with its distance from the next, nothing if it is empty.
fn spaced(height_pt: f64) -> f64 {
    if height_pt > 0.0 { height_pt + BLOCK_GAP_PT } else { 0.0 }
}

/// The stamp: its letters and its frame in the page's upper right corner.
fn mark(figure: &Figure, fonts: &Fonts, width_pt: f64) -> Result<Option<(Label, Rect)>, Error> {
    let Some(mark) = &figure.mark else { return Ok(None) };
    let label = fonts.label(&format!("**{mark}**"), SMALL_PT)?;
    let room_pt = width_pt - 2.0 * (PAGE_MARGIN_PT + MARK_PAD_PT.0);
    if label.width_pt > room_pt {
        let need_pt = label.width_pt;
        return Err(Error::TextTooLong { text: mark.clone(), need_pt, have_pt: room_pt });
    }
    let right = width_pt - PAGE_MARGIN_PT;
    let left = right - label.width_pt - 2.0 * MARK_PAD_PT.0;
    let bottom = PAGE_MARGIN_PT + label.cap_pt() + 2.0 * MARK_PAD_PT.1;
    Ok(Some((label, Rect { left, right, top: PAGE_MARGIN_PT, bottom })))
}

/// Plans all panels from `top` down and says where the lowest ends. The grid is `height_pt` high,
/// or as high as suits the panels.
fn solve<'a>(
    figure: &'a Figure,
    fonts: &Fonts,
    top: f64,
    height_pt: Option<f64>,
) -> Result<(Vec<PanelPlan<'a>>, f64), Error> {
    let cells = cells(figure);
    let ends = scale::ends(figure)?;
    let mut decor = vec![FIRST_GUESS; cells.len()];
    let mut panels: Vec<PanelPlan<'a>> = Vec::new();
    let mut bottom = top;
    for _ in 0..ROUNDS {
        let (plots, low) = place(figure, fonts, &cells, &decor, top, height_pt)?;
        bottom = low;
        panels.clear();
        for ((panel, &ends), plot) in figure.panels.iter().zip(&ends).zip(plots) {
            panels.push(panel::plan(figure, fonts, panel, ends, plot)?);
        }
        decor = panels.iter().map(|panel| panel.decor).collect();
    }
    // What a column has at its left is certain only when all of its panels are planned.
    let margins = grid::column_margins(&cells, &decor);
    for panel in &mut panels {
        panel.left_pt = margins[panel.panel.cell.column].0;
    }
    Ok((panels, bottom))
}

/// Plot areas of the panels, given the room each needs around its own, and the lower end of the
/// grid.
fn place(
    figure: &Figure,
    fonts: &Fonts,
    cells: &[Cell],
    decor: &[Decor],
    top: f64,
    height_pt: Option<f64>,
) -> Result<(Vec<Rect>, f64), Error> {
    let inner_pt = figure.width_mm * PT_PER_MM - 2.0 * PAGE_MARGIN_PT;
    let weights: Vec<f64> = (0..grid::size(cells).1)
        .map(|column| figure.column_weights.get(column).copied().unwrap_or(1.0))
        .collect();
    let margins = grid::column_margins(cells, decor);
    let widths = grid::share(inner_pt, &margins, GRID_GAP_PT.0, &weights);
    let columns = grid::tracks(PAGE_MARGIN_PT, &margins, GRID_GAP_PT.0, &widths);

    let margins = grid::row_margins(cells, decor);
    let mut heights = row_heights(figure, fonts, &widths)?;
    if let Some(height_pt) = height_pt {
        heights = grid::share(height_pt, &margins, GRID_GAP_PT.1, &heights);
    }
    let rows = grid::tracks(top, &margins, GRID_GAP_PT.1, &heights);
    let bottom = rows.last().zip(margins.last()).map_or(top, |(row, margin)| row.1 + margin.1);
    Ok((cells.iter().map(|cell| grid::plot(cell, &columns, &rows)).collect(), bottom))
}

/// Room around a plot before anything is measured.
const FIRST_GUESS: Decor = Decor { left: 36.0, right: 6.0, top: 12.0, bottom: 28.0 };

/// Heights of the rows in pt: the most that a panel of that row alone asks for.
fn row_heights(figure: &Figure, fonts: &Fonts, widths: &[f64]) -> Result<Vec<f64>, Error> {
    let rows = grid::size(&cells(figure)).0;
    let narrowest = widths.iter().copied().fold(f64::INFINITY, f64::min);
    // Two thirds of the narrowest plot's width, less where several are stacked.
    let (share, least_mm, most_mm) = match rows {
        1 => (0.68, 35.0, 62.0),
        2 => (0.6, 30.0, 45.0),
        _ => (0.5, 22.0, 26.0),
    };
    let usual = (share * narrowest).clamp(least_mm * PT_PER_MM, most_mm * PT_PER_MM);
    let mut heights: Vec<Option<f64>> = vec![None; rows];
    for panel in figure.panels.iter().filter(|panel| panel.cell.rows == 1) {
        let mut need = match (panel.height_mm, &panel.y.ticks) {
            (Some(mm), _) => mm * PT_PER_MM,
            (None, Ticks::Categories(names)) => NAMED_ROW_PT * names.len().max(1) as f64,
            (None, _) if panel.note.is_some() => NOTE_PT.min(usual),
            (None, _) => usual,
        };
        if let Ticks::Categories(names) = &panel.y.ticks {
            need = need.max(axis::names_pt(fonts, names, figure.width_mm * PT_PER_MM)?);
        }
        let height = &mut heights[panel.cell.row];
        *height = Some(height.map_or(need, |height| height.max(need)));
    }
    Ok(heights.into_iter().map(|height| height.unwrap_or(usual)).collect())
}

/// Height of a row of a named y axis, in pt.
const NAMED_ROW_PT: f64 = 19.0;

/// Height of a panel that has only a note, in pt.
const NOTE_PT: f64 = 56.0;
