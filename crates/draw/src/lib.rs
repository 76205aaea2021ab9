//! Figures: one style, axes, bands, bars; drawn once, written as SVG, PDF and PNG.
//!
//! A [`Figure`] is plain data. [`draw`] lays it out and gives a [`Drawing`], which gives the bytes
//! of an SVG, a PNG and a PDF: the same bytes on every run. Nothing here knows studies, files or
//! the clock.
//!
//! ```
//! use zwidth_draw::{Axis, Cell, Figure, Layer, Line, ONE_COLUMN_MM, Panel, draw, style};
//!
//! let line = Line {
//!     x: vec![0.0, 1.0, 2.0],
//!     y: vec![0.0, 2.5, 4.0],
//!     stroke: style::mean(style::mode_colour(0)),
//!     name: Some("active".into()),
//!     ..Line::default()
//! };
//! let (x, y) = (Axis::new("*θ*", "°"), Axis::new("*F*_{ex}", "N"));
//! let panel = Panel::new(Cell::at(0, 0), x, y, vec![Layer::Line(line)]);
//! let figure = Figure { width_mm: ONE_COLUMN_MM, panels: vec![panel], ..Figure::default() };
//!
//! let drawing = draw(&figure)?;
//! assert!(drawing.svg()?.starts_with("<?xml"));
//! # Ok::<(), zwidth_draw::Error>(())
//! ```
//!
//! **Thinning.** Of every run of points within 1/200 inch, a curve keeps the first, lowest, highest
//! and last, and of these only the ones that lie more than 0.04 pt (14 µm) off the straight line
//! through their neighbours. Of points that fall on one spot of 1/200 inch, one is drawn. The
//! omitted points could not be seen in print.

#![cfg_attr(test, allow(clippy::float_cmp))] // tests compare exact results exactly

mod axis;
mod backend;
mod curve;
mod drawing;
mod error;
mod figure;
mod font;
mod grid;
mod layers;
mod layout;
mod legend;
mod likert;
pub mod markup;
mod page;
mod panel;
mod pdf;
mod png;
mod references;
mod scale;
mod sheet;
pub mod style;
mod svg;
mod ticks;
mod typeface;
mod words;

pub use drawing::Drawing;
pub use error::Error;
pub use figure::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, LegendPlace, Likert, LikertScale, Line,
    ONE_COLUMN_MM, Panel, Points, Range, Reference, TWO_COLUMNS_MM, Text, TextPlace, Ticks, dodge,
};
pub use typeface::{Font, FontFile};

use font::{Fonts, with_fonts};
use sheet::Sheet;

/// Resolution of PNGs for screens, in dots per inch.
pub const DEFAULT_DPI: f64 = 200.0;

/// Lays a figure out and draws it.
///
/// # Errors
/// Data that do not fit together, nothing to draw, an impossible range or size, a text that finds
/// no room, a font that cannot be drawn with: see [`Error`].
pub fn draw(figure: &Figure) -> Result<Drawing, Error> {
    with_fonts(figure.font.as_ref(), |fonts| {
        let plan = layout::plan(figure, fonts)?;
        let mut sheet = Sheet::new(fonts);
        page::draw(&mut sheet, &plan)?;
        Ok(Drawing {
            shapes: sheet.shapes,
            size_pt: (plan.width_pt, plan.height_pt),
            title: figure.title.as_deref().map(markup::plain).unwrap_or_default(),
            description: figure.description.clone(),
            font: figure.font.clone(),
            provenance: figure.provenance.clone(),
        })
    })
}

impl Drawing {
    /// The SVG: words as outlines, title, description and provenance inside, nothing outside needed
    /// to show it.
    ///
    /// # Errors
    /// [`Error::Font`] and [`Error::FontFile`] as [`draw`].
    pub fn svg(&self) -> Result<String, Error> {
        with_fonts(self.font.as_ref(), |fonts| Ok(svg::svg(self, fonts, svg::Words::Outlines)))
    }

    /// The SVG with its words as text, to be edited and searched, in the font of this name where it is
    /// installed, else in the figure's own. The figure is laid out by the widths of its own font;
    /// in another each word is stretched to the width that it had.
    ///
    /// # Errors
    /// As [`svg`](Self::svg).
    pub fn svg_with_text(&self, font: Option<&str>) -> Result<String, Error> {
        let own = self.font.as_ref().and_then(Font::family);
        let words = svg::Words::Text(font.or(own));
        with_fonts(self.font.as_ref(), |fonts| Ok(svg::svg(self, fonts, words)))
    }

    /// An opaque PNG at `dpi` dots per inch ([`DEFAULT_DPI`] for screens), provenance in its
    /// `Comment`.
    ///
    /// # Errors
    /// [`Error::Size`] if `dpi` is not positive or the image would pass 100 megapixels,
    /// [`Error::Encode`] if the libraries refuse the drawing, otherwise as [`svg`](Self::svg).
    pub fn png(&self, dpi: f64) -> Result<Vec<u8>, Error> {
        with_fonts(self.font.as_ref(), |fonts| png::png(self, fonts, dpi))
    }

    /// A one-page PDF of the figure's size, its font embedded so that words can be searched and
    /// copied, provenance among its keywords.
    ///
    /// # Errors
    /// [`Error::Encode`] if the libraries refuse the drawing, otherwise as [`svg`](Self::svg).
    pub fn pdf(&self) -> Result<Vec<u8>, Error> {
        with_fonts(self.font.as_ref(), |fonts| pdf::pdf(self, fonts))
    }

    /// Every two words whose letters overlap: none, if a figure has the room that its words need.
    ///
    /// # Errors
    /// [`Error::Font`] as [`draw`].
    pub fn overlapping_words(&self) -> Result<Vec<[String; 2]>, Error> {
        /// An italic letter may lean over the subscript after it, in pt.
        const LEAN_PT: f32 = 1.1;
        let words = self.words(&Fonts::new(self.font.as_ref())?);
        let mut overlapping = Vec::new();
        for (i, (word, a)) in words.iter().enumerate() {
            for (other, b) in &words[..i] {
                let apart = a.right() <= b.left() + LEAN_PT
                    || b.right() <= a.left() + LEAN_PT
                    || a.bottom() <= b.top() + LEAN_PT
                    || b.bottom() <= a.top() + LEAN_PT;
                if !apart {
                    overlapping.push([other.clone(), word.clone()]);
                }
            }
        }
        Ok(overlapping)
    }

    /// Every word of a line whose letters are smaller than those of small print
    /// ([`style::SMALL_PT`]), its lowered and raised letters apart: none.
    pub fn small_words(&self) -> Vec<String> {
        let pieces = self.shapes.iter().filter_map(|shape| match &shape.form {
            sheet::Form::Words { piece, .. } => Some(piece),
            _ => None,
        });
        let small = pieces.filter(|piece| piece.line_pt < style::SMALL_PT);
        small.map(|piece| piece.text.clone()).collect()
    }

    /// The words with what their letters cover on the page, pt.
    fn words(&self, fonts: &Fonts) -> Vec<(String, tiny_skia::Rect)> {
        let words = self.shapes.iter().filter_map(|shape| {
            let sheet::Form::Words { piece, .. } = &shape.form else { return None };
            let ink = png::outline(&shape.form, fonts, 1.0)?.compute_tight_bounds()?;
            Some((piece.text.clone(), ink))
        });
        words.collect()
    }
}

#[cfg(test)]
extern crate self as zwidth_draw; // the gallery names this crate as its users do
#[cfg(test)]
#[path = "../examples/gallery.rs"]
#[allow(dead_code, unreachable_pub)]
mod gallery;
#[cfg(test)]
mod tests;
