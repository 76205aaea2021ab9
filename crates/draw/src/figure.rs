//! The description of a figure: plain data, nothing drawn yet.
//!
//! Lengths on paper are millimetres (`_mm`) or points (`_pt`, 1/72 inch). Data carry the unit that
//! the axis names: a layer holds the numbers that the axis shows (degrees, if the axis says
//! degrees). Every text is [markup](crate::markup): `*F*_{ex}`, `10^{−3}`, `**bold**`. In every
//! array of data NaN means "no value here" and leaves a gap; an infinity is an error.

use crate::style::{self, Colour, Marker, Stroke};
use crate::typeface::Font;

/// Width of one column of a thesis or journal page, in mm.
pub const ONE_COLUMN_MM: f64 = 85.0;
/// Width of both columns of a thesis or journal page, in mm.
pub const TWO_COLUMNS_MM: f64 = 175.0;

/// A whole figure. `Figure::default()` is an empty one, two columns wide, its legend above.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Heading above everything; a thesis puts it into the caption instead. Also the file's own
    /// title.
    pub title: Option<String>,
    /// What the figure shows, in a sentence: `<desc>` of the SVG, subject of the PDF, for readers
    /// who cannot see it.
    pub description: String,
    /// Width on paper, e.g. [`ONE_COLUMN_MM`].
    pub width_mm: f64,
    /// Height on paper; `None` lets every panel have the height that suits it.
    pub height_mm: Option<f64>,
    /// The panels, each with its place in the grid.
    pub panels: Vec<Panel>,
    /// Relative widths of the columns' plot areas; empty: all alike.
    pub column_weights: Vec<f64>,
    /// Where the shared legend is. It holds every named layer once, in order of appearance.
    pub legend: LegendPlace,
    /// Small print under the figure.
    pub footnotes: Vec<String>,
    /// A stamp at the figure's head, clear of the data: `SYNTHETIC` on figures made from simulated
    /// recordings.
    pub mark: Option<String>,
    /// Whether heading and small print are left to a caption beside it. The stamp stays, and the
    /// files keep their title.
    pub bare: bool,
    /// The font of its words; the bundled Noto Sans where there is none.
    pub font: Option<Font>,
    /// Where the figure comes from (hashes, parameters, versions), stored in the files and not
    /// shown.
    pub provenance: Option<String>,
}

impl Default for Figure {
    fn default() -> Self {
        Self {
            title: None,
            description: String::new(),
            width_mm: TWO_COLUMNS_MM,
            height_mm: None,
            panels: Vec::new(),
            column_weights: Vec::new(),
            legend: LegendPlace::Above,
            footnotes: Vec::new(),
            mark: None,
            bare: false,
            font: None,
            provenance: None,
        }
    }
}

/// Where the shared legend is; never inside a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendPlace {
    /// Between the heading and the panels.
    Above,
    /// Between the panels and the footnotes.
    Below,
    /// No legend.
    Hidden,
}

/// A panel's place in the grid, counted from the top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// First row.
    pub row: usize,
    /// First column.
    pub column: usize,
    /// Rows covered, at least 1.
    pub rows: usize,
    /// Columns covered, at least 1.
    pub columns: usize,
}

impl Cell {
    /// One cell of the grid.
    pub fn at(row: usize, column: usize) -> Self {
        Self { row, column, rows: 1, columns: 1 }
    }

    /// The same place, `rows` high and `columns` wide.
    pub fn spanning(self, rows: usize, columns: usize) -> Self {
        Self { rows, columns, ..self }
    }
}

/// One pair of axes with what is drawn between them, later layers over earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Place in the grid.
    pub cell: Cell,
    /// Short heading over the panel, e.g. `**a**  spring`.
    pub title: Option<String>,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub layers: Vec<Layer>,
    /// Shown instead of the layers where there is nothing to draw: `no angle was recorded`.
    pub note: Option<String>,
    /// Height of the plot area; `None`: as suits the content. Where the figure has a height of its
    /// own these count as proportions.
    pub height_mm: Option<f64>,
}

impl Panel {
    /// A panel without title and note.
    pub fn new(cell: Cell, x: Axis, y: Axis, layers: Vec<Layer>) -> Self {
        Self { cell, title: None, x, y, layers, note: None, height_mm: None }
    }

    /// The same panel with a heading.
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self { title: Some(title.into()), ..self }
    }

    /// Its curves.
    pub fn lines(&self) -> impl Iterator<Item = &Line> {
        self.layers.iter().filter_map(|layer| match layer {
            Layer::Line(line) => Some(line),
            _ => None,
        })
    }

    /// The same panel with a plot area of this height.
    pub fn tall(self, height_mm: f64) -> Self {
        Self { height_mm: Some(height_mm), ..self }
    }

    /// An empty panel that says why it is empty.
    pub fn with_note(cell: Cell, x: Axis, y: Axis, note: impl Into<String>) -> Self {
        Self { note: Some(note.into()), ..Self::new(cell, x, y, Vec::new()) }
    }
}

/// One axis. `Axis::new("*θ*", "°")` reads "θ (°)" and fits its data.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity.
    pub label: String,
    /// Unit, set in parentheses after the label; empty for none.
    pub unit: String,
    /// Ends of the axis.
    pub range: Range,
    /// Axes of one figure with the same key share one range that holds all of theirs, x with y
    /// too. Directly stacked panels that share their x axis number it once, at the bottom;
    /// neighbours that share their y axis once, at the left.
    pub link: Option<String>,
    /// The labels at the ticks.
    pub ticks: Ticks,
}

impl Axis {
    /// A numeric axis that fits its data with a little room.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            range: Range::Auto,
            link: None,
            ticks: Ticks::Numbers,
        }
    }

    /// An axis of named places at 0, 1, 2, …; on a y axis the first is on top.
    pub fn categories<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Self {
        let names = names.into_iter().map(Into::into).collect();
        Self { ticks: Ticks::Categories(names), ..Self::new("", "") }
    }

    /// An invisible axis, from `low` to `high`: see [`Ticks::Bare`].
    pub fn bare(low: f64, high: f64) -> Self {
        Self { ticks: Ticks::Bare, range: Range::Fixed(low, high), ..Self::new("", "") }
    }

    /// The same axis sharing its range with all axes of this key.
    pub fn linked(self, key: impl Into<String>) -> Self {
        Self { link: Some(key.into()), ..self }
    }

    /// The same axis with another range.
    pub fn ranged(self, range: Range) -> Self {
        Self { range, ..self }
    }
}

/// How an axis finds its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// The data's extent and 4 % on either side.
    Auto,
    /// The extent of the data and of these two values, and 4 % on either side: so that figures
    /// which are to be compared have one axis.
    Holding(f64, f64),
    /// Exactly the data's extent: for time, which starts and ends with the recording.
    Tight,
    /// From the first to the second value; data outside are cut off at the plot's edge.
    Fixed(f64, f64),
    /// The same, where both axes of a panel are so: one unit is as long on the one as on the other,
    /// and the range of one grows to both sides where it must. Panels of one size whose axes are all
    /// as long have one scale.
    OneScale(f64, f64),
}

/// The labels at an axis' ticks.
#[derive(Debug, Clone, PartialEq)]
pub enum Ticks {
    /// Numbers in steps of 1, 2 or 5 × 10ⁿ.
    Numbers,
    /// Whole numbers without their sign: counts of answers to either side of zero.
    Magnitudes,
    /// Powers of ten: the data are logarithms to base ten, and a whole number *n* reads 10ⁿ. Bare
    /// ticks stand at the two- to ninefold of each power where there is room. The axis always
    /// holds two powers, unless its range is fixed.
    Powers,
    /// Numbers of which the data are the natural logarithms, in round steps; where they span several powers of ten, one,
    /// two and five times each. So ratios that are equally far from 1 stand equally far from it.
    Logarithms,
    /// These names at 0, 1, 2, …; none is left out, long ones wrap or turn.
    Categories(Vec<String>),
    /// Nothing, and no edge of the plot either: for a drawing of things. Where both axes of a panel
    /// are bare one unit is as long on the one as on the other, and the panel's range grows
    /// where it must.
    Bare,
}

/// Which way something runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Along x.
    Horizontal,
    /// Along y.
    Vertical,
}

impl Direction {
    /// What belongs to x and what to y, of something that lies along it and something across it.
    pub(crate) fn x_and_y<T>(self, along: T, across: T) -> (T, T) {
        match self {
            Self::Horizontal => (along, across),
            Self::Vertical => (across, along),
        }
    }
}

/// One thing drawn in a panel.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// A curve.
    Line(Line),
    /// The area between two curves.
    Band(Band),
    /// Separate points.
    Points(Points),
    /// A straight line across the panel.
    Reference(Reference),
    /// Words inside the panel.
    Text(Text),
    /// Estimates with their intervals.
    Intervals(Intervals),
    /// Diverging stacked bars of answers.
    Likert(Likert),
}

/// A curve through `(x[i], y[i])`, in the order given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Line {
    /// Horizontal positions; NaN breaks the curve.
    pub x: Vec<f64>,
    /// Vertical positions, as many; NaN breaks the curve.
    pub y: Vec<f64>,
    /// Where `true` at both ends of a piece, the piece is dotted in the rhythm of the pen's dashes
    /// (past the wall, say). Empty: nowhere.
    pub dotted: Vec<bool>,
    /// Pen.
    pub stroke: Stroke,
    /// Entry in the legend.
    pub name: Option<String>,
}

/// The area between `low` and `high` over `x`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Horizontal positions; a NaN in any of the three breaks the band.
    pub x: Vec<f64>,
    /// Lower edge, as many.
    pub low: Vec<f64>,
    /// Upper edge, as many.
    pub high: Vec<f64>,
    /// Fill, laid on at [`style::BAND_OPACITY`].
    pub colour: Colour,
    /// Entry in the legend; a band and a line of one name share one entry.
    pub name: Option<String>,
}

/// Separate points.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Horizontal positions; points with a NaN are left out.
    pub x: Vec<f64>,
    /// Vertical positions, as many.
    pub y: Vec<f64>,
    /// Fill.
    pub colour: Colour,
    /// 0 (not seen) to 1 (solid).
    pub opacity: f64,
    /// Size on paper.
    pub diameter_pt: f64,
    /// Entry in the legend.
    pub name: Option<String>,
}

impl Default for Points {
    fn default() -> Self {
        Self {
            x: Vec::new(),
            y: Vec::new(),
            colour: style::INK,
            opacity: 1.0,
            diameter_pt: style::POINT_PT,
            name: None,
        }
    }
}

/// A straight line across the whole panel, with a label outside of the plot area: over a vertical
/// line, to the right of a horizontal one.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Which way the line runs.
    pub direction: Direction,
    /// Its place on the other axis, which is stretched to hold it.
    pub at: f64,
    /// Words at its end.
    pub label: Option<String>,
    /// Pen, e.g. [`style::reference()`].
    pub stroke: Stroke,
    /// Entry in the legend.
    pub name: Option<String>,
}

impl Reference {
    /// A line without words and without an entry in the legend.
    pub fn new(direction: Direction, at: f64, stroke: Stroke) -> Self {
        Self { direction, at, label: None, stroke, name: None }
    }
}

/// Words inside the panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Lines of markup, top to bottom.
    pub lines: Vec<String>,
    /// Where they stand.
    pub place: TextPlace,
}

/// Where words are inside a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TextPlace {
    /// In the corner where they cover the fewest data.
    EmptiestCorner,
    /// Centred over this point of the data's coordinates.
    Over(f64, f64),
    /// Centred on this point.
    Amid(f64, f64),
    /// Beginning to the right of this point, at its height.
    RightOf(f64, f64),
    /// Ending to the left of this point, at its height.
    LeftOf(f64, f64),
    /// Centred in the box between these corners, the lower left and the upper right one: wrapped,
    /// set smaller where they must be, and cut off at `…` where that is not enough.
    Within((f64, f64), (f64, f64)),
}

/// Estimates with whiskers from `low` to `high`.
#[derive(Debug, Clone, PartialEq)]
pub struct Intervals {
    /// Which way the whiskers run.
    pub direction: Direction,
    /// Place on the other axis; see [`dodge`] for several at one category.
    pub at: Vec<f64>,
    /// Estimates, as many; NaN leaves one out.
    pub estimate: Vec<f64>,
    /// Lower ends, as many; NaN leaves the whisker out and keeps the estimate.
    pub low: Vec<f64>,
    /// Upper ends, as many.
    pub high: Vec<f64>,
    /// Colour of whisker and marker.
    pub colour: Colour,
    /// Shape at the estimate.
    pub marker: Marker,
    /// Entry in the legend.
    pub name: Option<String>,
}

impl Intervals {
    /// Discs in ink, without an entry in the legend.
    pub fn new(direction: Direction, at: Vec<f64>, [estimate, low, high]: [Vec<f64>; 3]) -> Self {
        let marker = Marker::Disc;
        Self { direction, at, estimate, low, high, colour: style::INK, marker, name: None }
    }
}

/// Diverging stacked bars: one row of boxes per group of answers, one box per answer, with its count
/// inside; or a thin strip for each person, one under the other, without counts. The middle answer of
/// an odd number straddles zero, so that the bar leans to the side that the answers lean to. Belongs
/// on `y: Axis::categories(rows)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Likert {
    /// The answers from the most negative to the most positive: the legend.
    pub answers: Vec<String>,
    /// For each row of the y axis its strips, from the top: of each the count of each answer.
    pub rows: Vec<Vec<Vec<u32>>>,
    /// What a box's length means. The number inside is a count in either case.
    pub scale: LikertScale,
}

/// What the length of a Likert box means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LikertScale {
    /// Number of answers.
    Counts,
    /// Per cent of the strip's answers: for people or rows of unequal totals.
    Percent,
}

/// Offset of the `index`-th of `count` marks that share one category, in category units: the marks
/// spread over half of the category's room.
pub fn dodge(index: usize, count: usize) -> f64 {
    /// Share of the room between two categories that marks of one category take up.
    const SPREAD: f64 = 0.5;
    (index as f64 + 0.5) / count.max(1) as f64 * SPREAD - SPREAD / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dodged_marks_are_symmetric_about_their_category() {
        assert_eq!(dodge(0, 1), 0.0);
        assert_eq!(dodge(0, 2), -dodge(1, 2));
        assert_eq!(dodge(1, 3), 0.0);
        assert!(dodge(2, 3) < 0.5, "marks must not reach the next category");
    }
}
