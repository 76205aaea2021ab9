//! Writes a sheet as PDF, with words as text in embedded fonts, so that they can be found and
//! copied.

use std::sync::LazyLock;

use krilla::Document;
use krilla::color::rgb;
use krilla::geom::{PathBuilder, Point, Size, Transform};
use krilla::metadata::Metadata;
use krilla::num::NormalizedF32;
use krilla::page::PageSettings;
use krilla::paint::{Fill, LineCap, LineJoin, Stroke, StrokeDash};
use krilla::surface::Surface;
use krilla::text::{Font, GlyphId, KrillaGlyph};
use rustybuzz::ttf_parser::OutlineBuilder;

use crate::drawing::Drawing;
use crate::error::Error;
use crate::font::{Fonts, Piece};
use crate::sheet::{At, Form, Ink};
use crate::style::{self, Colour};
use crate::typeface::{Style, Typeface};

fn fault(reason: &dyn std::fmt::Display) -> Error {
    Error::Encode { format: "PDF", reason: reason.to_string() }
}

/// A one-page PDF of a size on paper with its fonts embedded; the provenance is its keyword. The
/// `fonts` are the drawing's own, or the bundled ones.
pub(crate) fn pdf(drawing: &Drawing, fonts: &Fonts) -> Result<Vec<u8>, Error> {
    let (width_pt, height_pt) = drawing.size_pt;
    let size = Size::from_wh(width_pt as f32, height_pt as f32)
        .ok_or_else(|| fault(&"the page is empty"))?;
    let font = drawing.font.as_ref();
    let own = Style::ALL.map(|style| Font::new(font?.file(style)?.bytes.clone().into(), 0));
    let mut document = Document::new();
    let metadata =
        Metadata::new().title(drawing.title.clone()).description(drawing.description.clone());
    document.set_metadata(match &drawing.provenance {
        Some(provenance) => metadata.keywords(vec![provenance.clone()]),
        None => metadata,
    });
    let mut page = document.start_page_with(PageSettings::new(size));
    let mut surface = page.surface();
    for shape in &drawing.shapes {
        let (fill, stroke) = match &shape.ink {
            Ink::Fill(colour, opacity) => (Some(fill(*colour, *opacity)), None),
            Ink::Stroke(pen) => (None, Some(stroke(pen))),
        };
        // Both, though one is none: the surface keeps what the shape before was drawn with.
        surface.set_fill(fill);
        surface.set_stroke(stroke);
        if let Form::Words { piece, start, turned } = &shape.form {
            let Typeface { is_own, style } = piece.face;
            let faces = if is_own { &own } else { &*BUNDLED };
            let face = faces[style as usize].clone().ok_or(Error::Font)?;
            write(&mut surface, piece, *start, *turned, face, fonts.units_per_em(piece.face));
            continue;
        }
        let mut paper = Paper(PathBuilder::new());
        shape.form.trace(fonts, &mut paper);
        if let Some(path) = paper.0.finish() {
            surface.draw_path(&path);
        }
    }
    surface.finish();
    page.finish();
    document.finish().map_err(|error| fault(&format!("{error:?}")))
}

/// The faces of the bundled font as they are embedded, parsed once per process.
static BUNDLED: LazyLock<[Option<Font>; 3]> =
    LazyLock::new(|| Style::ALL.map(|style| Font::new(style.bundled().into(), 0)));

/// Writes letters of one face, which has so many units per em, as text.
fn write(surface: &mut Surface<'_>, piece: &Piece, (x, y): At, turned: bool, face: Font, em: f64) {
    let mut glyphs = Vec::new();
    for (k, glyph) in piece.glyphs.iter().enumerate() {
        // As far as to the next: glyphs have places here, and advances in a PDF.
        let next = piece.glyphs.get(k + 1).map_or(piece.advance, |next| next.x);
        let advance = (f64::from(next - glyph.x) / em) as f32;
        let up = (f64::from(glyph.y) / em) as f32;
        let id = GlyphId::new(u32::from(glyph.id));
        let letters = glyph.letters.clone();
        glyphs.push(KrillaGlyph::new(id, advance, 0.0, up, 0.0, letters, None));
    }
    let first = piece.glyphs.first().map_or(piece.advance, |glyph| glyph.x);
    let x = x as f32;
    let y = y as f32;
    surface.push_transform(&match turned {
        true => Transform::from_row(0.0, -1.0, 1.0, 0.0, x, y),
        false => Transform::from_translate(x, y),
    });
    let from = Point::from_xy((f64::from(first) / em * piece.size_pt) as f32, 0.0);
    // Letters that changed places cannot be copied in their order: they are outlines.
    let outlined = !piece.glyphs.is_sorted_by_key(|glyph| glyph.letters.start);
    surface.draw_glyphs(from, &glyphs, face, &piece.text, piece.size_pt as f32, outlined);
    surface.pop();
}

fn colour(Colour { r, g, b }: Colour) -> rgb::Color {
    rgb::Color::new(r, g, b)
}

fn share(opacity: f64) -> NormalizedF32 {
    NormalizedF32::new(opacity as f32).unwrap_or(NormalizedF32::ONE)
}

fn fill(ink: Colour, opacity: f64) -> Fill {
    Fill { paint: colour(ink).into(), opacity: share(opacity), ..Fill::default() }
}

fn stroke(pen: &style::Stroke) -> Stroke {
    Stroke {
        paint: colour(pen.colour).into(),
        width: pen.width_pt as f32,
        opacity: share(pen.opacity),
        line_join: LineJoin::Round,
        line_cap: if pen.round_ends() { LineCap::Round } else { LineCap::Butt },
        dash: pen.dashes_pt().map(|dashes_pt| StrokeDash {
            array: dashes_pt.into_iter().map(|pt| pt as f32).collect(),
            offset: pen.from_pt as f32,
        }),
        ..Stroke::default()
    }
}

/// An outline on the page.
struct Paper(PathBuilder);

impl OutlineBuilder for Paper {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.0.close();
    }
}
