//! plotters on our sheet: a drawing backend with hundredths of a point for pixels.
//!
//! plotters counts whole pixels; at 7,200 to the inch these are finer than any printer's. Its
//! strokes have no dashes, so curves go through [`Curve`], an element of ours.

use std::convert::Infallible;

use plotters::element::{Drawable, PointCollection};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};

use crate::legend;
use crate::sheet::{At, Rect, Sheet};
use crate::style::{Colour, Dash, Marker, Stroke};

/// Backend pixels per point.
pub(crate) const UNITS_PER_PT: f64 = 100.0;

/// A length in backend pixels.
pub(crate) fn units(pt: f64) -> i32 {
    // Far within i32: the largest page, 1189 mm, has 337,000 of these.
    (pt * UNITS_PER_PT).round() as i32
}

fn on_page((x, y): BackendCoord) -> At {
    (f64::from(x) / UNITS_PER_PT, f64::from(y) / UNITS_PER_PT)
}

type Outcome = Result<(), DrawingErrorKind<Infallible>>;

/// plotters' hand on a sheet of the given size.
pub(crate) struct Pen<'s, 'f> {
    pub(crate) sheet: &'s mut Sheet<'f>,
    pub(crate) size_pt: (f64, f64),
}

fn colour(color: BackendColor) -> (Colour, f64) {
    let (r, g, b) = color.rgb;
    (Colour { r, g, b }, color.alpha)
}

fn stroke<S: BackendStyle>(style: &S) -> Stroke {
    let (colour, opacity) = colour(style.color());
    let width_pt = f64::from(style.stroke_width()) / UNITS_PER_PT;
    Stroke { colour, opacity, width_pt, dash: Dash::Solid, from_pt: 0.0 }
}

impl DrawingBackend for Pen<'_, '_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (units(self.size_pt.0).unsigned_abs(), units(self.size_pt.1).unsigned_abs())
    }

    fn ensure_prepared(&mut self) -> Outcome {
        Ok(())
    }

    fn present(&mut self) -> Outcome {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Outcome {
        self.draw_rect(point, (point.0 + 1, point.1 + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Outcome {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        a: BackendCoord,
        b: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Outcome {
        let (left, top) = on_page(a);
        let (right, bottom) = on_page(b);
        let rect = Rect { left, top, right, bottom };
        let (colour, opacity) = colour(style.color());
        match fill {
            true => self.sheet.rect(&rect, colour, opacity),
            false => self.sheet.frame(&rect, 0.0, &stroke(style)),
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome {
        let points: Vec<At> = path.into_iter().map(on_page).collect();
        self.sheet.stroke(&points, &stroke(style));
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        _fill: bool, // rings are not drawn
    ) -> Outcome {
        let (colour, opacity) = colour(style.color());
        self.sheet.disc(on_page(centre), 2.0 * f64::from(radius) / UNITS_PER_PT, colour, opacity);
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome {
        let points: Vec<At> = path.into_iter().map(on_page).collect();
        let (colour, opacity) = colour(style.color());
        self.sheet.fill(&points, colour, opacity);
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &T,
        at: BackendCoord,
    ) -> Outcome {
        let size_pt = style.size() / UNITS_PER_PT;
        let label = self.sheet.fonts.label(text, size_pt).map_err(font_error)?;
        let along = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => label.width_pt / 2.0,
            HPos::Right => label.width_pt,
        };
        let down = match style.anchor().v_pos {
            VPos::Top => label.ascent_pt(),
            VPos::Center => label.cap_pt() / 2.0,
            VPos::Bottom => 0.0,
        };
        let (x, y) = on_page(at);
        let turned = matches!(style.transform(), FontTransform::Rotate270);
        let start = if turned { (x + down, y + along) } else { (x - along, y + down) };
        self.sheet.text(&label, start, colour(style.color()).0, turned);
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let label =
            self.sheet.fonts.label(text, style.size() / UNITS_PER_PT).map_err(font_error)?;
        Ok((units(label.width_pt).unsigned_abs(), units(label.height_pt()).unsigned_abs()))
    }
}

fn font_error(error: crate::Error) -> DrawingErrorKind<Infallible> {
    DrawingErrorKind::FontError(Box::new(error))
}

/// A curve in data coordinates, with any of our pens.
pub(crate) struct Curve {
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) stroke: Stroke,
}

impl<'a> PointCollection<'a, (f64, f64)> for &'a Curve {
    type Point = &'a (f64, f64);
    type IntoIter = &'a [(f64, f64)];

    fn point_iter(self) -> Self::IntoIter {
        &self.points
    }
}

impl Drawable<Pen<'_, '_>> for Curve {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        pen: &mut Pen<'_, '_>,
        _: (u32, u32),
    ) -> Outcome {
        let points: Vec<At> = points.map(on_page).collect();
        pen.sheet.stroke(&points, &self.stroke);
        Ok(())
    }
}

/// The marker of an estimate at a place of the data, its size that of all markers.
pub(crate) struct Mark {
    pub(crate) at: (f64, f64),
    pub(crate) marker: Marker,
    pub(crate) colour: Colour,
}

impl<'a> PointCollection<'a, (f64, f64)> for &'a Mark {
    type Point = &'a (f64, f64);
    type IntoIter = std::iter::Once<&'a (f64, f64)>;

    fn point_iter(self) -> Self::IntoIter {
        std::iter::once(&self.at)
    }
}

impl Drawable<Pen<'_, '_>> for Mark {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        points: I,
        pen: &mut Pen<'_, '_>,
        _: (u32, u32),
    ) -> Outcome {
        points
            .map(on_page)
            .for_each(|at| legend::draw_marker(pen.sheet, self.marker, at, self.colour));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
    use plotters::prelude::IntoDrawingArea as _;
    use plotters::style::{Color as _, IntoFont as _, RGBColor};

    use super::*;
    use crate::drawing::Drawing;
    use crate::font::Fonts;

    const RED: RGBColor = RGBColor(255, 0, 0);

    /// What an element drawn by plotters becomes.
    fn check<E>(element: E, expect: &[&str])
    where
        for<'a> &'a E: PointCollection<'a, (i32, i32)>,
        E: for<'s, 'f> Drawable<Pen<'s, 'f>>,
    {
        let mut sheet = Sheet::new(Fonts::bundled().unwrap());
        Pen { sheet: &mut sheet, size_pt: (100.0, 50.0) }
            .into_drawing_area()
            .draw(&element)
            .unwrap();
        let drawing = Drawing {
            shapes: sheet.shapes,
            size_pt: (100.0, 50.0),
            title: String::new(),
            description: String::new(),
            font: None,
            provenance: None,
        };
        let svg = drawing.svg().unwrap();
        assert!(expect.iter().all(|part| svg.contains(part)), "{expect:?} in {svg}");
    }

    #[test]
    fn elements_of_plotters_land_at_hundredths_of_a_point() {
        check(
            Circle::new((1050, 2025), 150, RED.filled()),
            &["cx=\"10.5\" cy=\"20.25\" r=\"1.5\"", "#ff0000"],
        );
        check(
            Rectangle::new([(100, 200), (350, 400)], RED.filled()),
            &["x=\"1\" y=\"2\" width=\"2.5\" height=\"2\""],
        );
        check(
            Polygon::new([(0, 0), (100, 0), (0, 100)], RED.mix(0.5)),
            &["M0 0l1 0-1 1z", "fill-opacity=\".5\""],
        );
        check(
            PathElement::new([(0, 0), (101, 50)], plotters::style::Color::stroke_width(&RED, 80)),
            &["M0 0l1.01 .5", "stroke-width=\".8\""],
        );
    }

    #[test]
    fn texts_of_plotters_are_markup_in_our_font() {
        let style = ("sans-serif", 800).into_font().color(&RED);
        check(
            Text::new("*F*_{ex}", (500, 500), style),
            &["aria-label=\"F\"", "xlink:href=\"#i", "aria-label=\"ex\"", "xlink:href=\"#r"],
        );
    }
}
