//! Draws a panel's layers with plotters, in the data's own coordinates.

use std::collections::BTreeSet;

use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text as Words};
use plotters::style::{Color as _, IntoFont as _, RGBColor, TextStyle};
use plotters_backend::text_anchor::{HPos, Pos, VPos};

use crate::backend::{Curve, Mark, Pen, UNITS_PER_PT, units};
use crate::curve::{self, COLUMN_PT, Point, Window};
use crate::error::Error;
use crate::figure::{Band, Intervals, Layer, Likert, Line, Points, Reference};
use crate::likert::{self, Segment};
use crate::panel::PanelPlan;
use crate::scale::{Ends, Scale};
use crate::sheet::Sheet;
use crate::style::{self, BAND_OPACITY, Colour, SMALL_PT, Stroke};

/// A panel's plot area as plotters sees it.
struct Plot<'s, 'f> {
    area: DrawingArea<Pen<'s, 'f>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    window: Window,
    x: Scale,
    y: Scale,
}

type Outcome = Result<(), Error>;

fn refused<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> Error {
    Error::Encode { format: "SVG", reason: error.to_string() }
}

fn rgb(Colour { r, g, b }: Colour) -> RGBColor {
    RGBColor(r, g, b)
}

/// Draws all layers of a panel that has data.
pub(crate) fn draw(sheet: &mut Sheet, plan: &PanelPlan<'_>, size_pt: (f64, f64)) -> Outcome {
    let (Some(x), Some(y)) = (plan.x_scale, plan.y_scale) else { return Ok(()) };
    let [x_units, y_units] = [&x, &y].map(|s| units(s.page_pt.0)..units(s.page_pt.1));
    let coordinates = Cartesian2d::new(x.ends.0..x.ends.1, y.ends.0..y.ends.1, (x_units, y_units));
    let area = Pen { sheet, size_pt }.into_drawing_area().apply_coord_spec(coordinates);
    let plot = Plot { area, window: Window { x: x.ends, y: y.ends }, x, y };
    plan.panel.layers.iter().try_for_each(|layer| match layer {
        Layer::Line(line) => plot.line(line),
        Layer::Band(band) => plot.band(band),
        Layer::Points(points) => plot.points(points),
        Layer::Reference(reference) => plot.reference(reference),
        Layer::Intervals(intervals) => plot.intervals(intervals),
        Layer::Likert(likert) => plot.likert(likert),
        Layer::Text(_) => Ok(()), // laid out with the panel, so that it can avoid the data
    })
}

impl Plot<'_, '_> {
    fn curve(&self, points: Vec<Point>, stroke: Stroke) -> Outcome {
        self.area.draw(&Curve { points, stroke }).map_err(refused)
    }

    fn disc(&self, at: Point, diameter_pt: f64, colour: Colour, opacity: f64) -> Outcome {
        let style = rgb(colour).mix(opacity).filled();
        self.area.draw(&Circle::new(at, units(diameter_pt / 2.0), style)).map_err(refused)
    }

    /// The points that print needs, in data coordinates.
    fn thinned(&self, points: Vec<Point>) -> Vec<Point> {
        // What print can show is a length on the page, so thinning needs places there.
        let page: Vec<Point> = points.iter().map(|&(x, y)| (self.x.pt(x), self.y.pt(y))).collect();
        curve::thin(&page).into_iter().map(|i| points[i]).collect()
    }

    fn line(&self, line: &Line) -> Outcome {
        let points: Vec<Point> = line.x.iter().copied().zip(line.y.iter().copied()).collect();
        let stretches = curve::stretches(&points, |i| line.dotted.get(i).copied().unwrap_or(false));
        for (dotted, stretch) in stretches {
            let dash = if dotted { line.stroke.dash.dotted() } else { line.stroke.dash };
            let stroke = line.stroke.dashed(dash);
            // A value between two gaps would vanish as a line: it is drawn as a dot.
            if let [lone] = stretch[..]
                && self.window.holds(lone)
            {
                self.disc(lone, 1.5 * stroke.width_pt, stroke.colour, stroke.opacity)?;
            }
            // Cut before it is thinned: what lies outside must not decide what stays inside.
            for part in curve::cut_line(&stretch, &self.window) {
                let begins = part.first().filter(|_| dotted).map(|from| self.x.pt(from.0));
                let stroke = begins.map_or(stroke, |x_pt| stroke.on_beat(x_pt));
                self.curve(self.thinned(part), stroke)?;
            }
        }
        Ok(())
    }

    /// An area between two curves; plotters' own area ends at one height.
    fn band(&self, band: &Band) -> Outcome {
        let style = rgb(band.colour).mix(BAND_OPACITY).filled();
        let [lows, highs] = [&band.low, &band.high].map(|edge| {
            let mut points: Vec<Point> = Vec::new();
            for (i, &value) in edge.iter().enumerate() {
                // A gap in either edge is a gap in both.
                let is_whole = band.low[i].is_finite() && band.high[i].is_finite();
                points.push((band.x[i], if is_whole { value } else { f64::NAN }));
            }
            curve::stretches(&points, |_| false)
        });
        for ((_, low), (_, high)) in lows.into_iter().zip(highs) {
            let mut outline = self.thinned(low);
            outline.extend(self.thinned(high).into_iter().rev());
            let inside = curve::cut_area(&outline, &self.window);
            self.area.draw(&Polygon::new(inside, style)).map_err(refused)?;
        }
        Ok(())
    }

    /// Points inside the plot; of those that fall on the same spot of print (200 to the inch) only
    /// the first.
    fn points(&self, points: &Points) -> Outcome {
        let mut taken = BTreeSet::new();
        for at in points.x.iter().copied().zip(points.y.iter().copied()) {
            let spot = [self.x.pt(at.0), self.y.pt(at.1)].map(|pt| (pt / COLUMN_PT).floor() as i64);
            if self.window.holds(at) && taken.insert(spot) {
                self.disc(at, points.diameter_pt, points.colour, points.opacity)?;
            }
        }
        Ok(())
    }

    fn reference(&self, reference: &Reference) -> Outcome {
        let &Reference { direction, at, .. } = reference;
        let (along, _) = direction.x_and_y(self.window.x, self.window.y);
        let ends = [along.0, along.1].map(|end| direction.x_and_y(end, at));
        let parts = curve::cut_line(&ends, &self.window);
        parts.into_iter().try_for_each(|part| self.curve(part, reference.stroke))
    }

    fn intervals(&self, intervals: &Intervals) -> Outcome {
        let point = |at: f64, value: f64| intervals.direction.x_and_y(value, at);
        let whisker = rgb(intervals.colour).stroke_width(units(style::WHISKER_PT).unsigned_abs());
        for (i, &at) in intervals.at.iter().enumerate() {
            let ends = [point(at, intervals.low[i]), point(at, intervals.high[i])];
            for part in curve::cut_line(&ends, &self.window) {
                self.area.draw(&PathElement::new(part, whisker)).map_err(refused)?;
            }
            let estimate = point(at, intervals.estimate[i]);
            if self.window.holds(estimate) {
                let &Intervals { marker, colour, .. } = intervals;
                self.area.draw(&Mark { at: estimate, marker, colour }).map_err(refused)?;
            }
        }
        Ok(())
    }

    fn likert(&self, likert: &Likert) -> Outcome {
        let zero = curve::cut_line(&[(0.0, self.window.y.0), (0.0, self.window.y.1)], &self.window);
        zero.into_iter().try_for_each(|zero| self.curve(zero, style::zero()))?;
        for (row, strips) in likert.rows.iter().enumerate() {
            let height = 2.0 * HALF_BAR / strips.len().max(1) as f64;
            for (strip, counts) in strips.iter().enumerate() {
                let top = row as f64 - HALF_BAR + strip as f64 * height;
                // Counts of narrow boxes stand over the bar, from left to right, and must not
                // touch.
                let mut taken_pt = f64::NEG_INFINITY;
                for segment in likert::segments(counts, likert.scale) {
                    let colour = style::likert_colour(segment.answer, likert.answers.len());
                    let room_pt = self.segment(&segment, (top, top + height), colour)?;
                    if let (Some(room_pt), [_]) = (room_pt, &strips[..]) {
                        taken_pt =
                            self.count(segment.count, row as f64, room_pt, colour, taken_pt)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Draws the part of a box that the plot shows and says where on the page it begins and ends.
    fn segment(
        &self,
        segment: &Segment,
        (top, bottom): Ends,
        colour: Colour,
    ) -> Result<Option<Ends>, Error> {
        let from = segment.from.max(self.window.x.0);
        let to = segment.to.min(self.window.x.1);
        if from >= to {
            return Ok(None);
        }
        let page = (self.x.pt(from), self.x.pt(to));
        // A box thinner than its seams would not be seen: they leave half of it.
        let seam = SEAM_PT.min((page.1 - page.0) / 4.0) * (to - from) / (page.1 - page.0);
        let corners = [(from + seam, top), (to - seam, bottom)];
        self.area.draw(&Rectangle::new(corners, rgb(colour).filled())).map_err(refused)?;
        Ok(Some(page))
    }

    /// Writes a count into its box, or over it if it is too narrow, clear of the count that ends at
    /// `taken_pt`. Says how far the room over the bar is taken then.
    fn count(
        &self,
        count: u32,
        row: f64,
        room_pt: Ends,
        ground: Colour,
        taken_pt: f64,
    ) -> Result<f64, Error> {
        let text = count.to_string();
        let middle_pt = (room_pt.0 + room_pt.1) / 2.0;
        let style = |ink: Colour, vertical| TextStyle {
            font: ("sans-serif", SMALL_PT * UNITS_PER_PT).into_font(),
            color: rgb(ink).to_backend_color(),
            pos: Pos::new(HPos::Center, vertical),
        };
        let inside = style(style::text_on(ground), VPos::Center);
        let (width, _) = self.area.estimate_text_size(&text, &inside).map_err(refused)?;
        let width_pt = f64::from(width) / UNITS_PER_PT;
        if width_pt <= room_pt.1 - room_pt.0 - 2.0 * SEAM_PT {
            let words = Words::new(text, (self.x.value(middle_pt), row), inside);
            return self.area.draw(&words).map_err(refused).map(|()| taken_pt);
        }
        let middle_pt = middle_pt.max(taken_pt + width_pt / 2.0 + COUNTS_APART_PT);
        let over = (self.x.value(middle_pt), row - HALF_BAR - COUNT_OFF);
        let words = Words::new(text, over, style(style::INK, VPos::Bottom));
        self.area.draw(&words).map_err(refused).map(|()| middle_pt + width_pt / 2.0)
    }
}

/// Half the height of a Likert bar, in rows.
const HALF_BAR: f64 = 0.34;
/// Distance of a count from the bar it stands over, in rows.
const COUNT_OFF: f64 = 0.05;
/// Room between two counts over a bar, in pt.
const COUNTS_APART_PT: f64 = 1.5;
/// Half the white seam between neighbouring boxes, in pt.
const SEAM_PT: f64 = 0.3;
