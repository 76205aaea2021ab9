//! Paints a sheet on pixels and writes these as PNG.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use png::chunk::IDAT;
use png::{BitDepth, ColorType, Encoder, PixelDimensions, Unit};
use rustybuzz::ttf_parser::OutlineBuilder;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Shader,
    StrokeDash, Transform,
};

use crate::drawing::Drawing;
use crate::error::Error;
use crate::font::Fonts;
use crate::sheet::{At, Form, Ink, Shape};
use crate::style::{Colour, Stroke};

/// Points per inch.
const PT_PER_INCH: f64 = 72.0;
/// Millimetres per inch.
const MM_PER_INCH: f64 = 25.4;
/// A curve of more points is stroked in pieces, of so many points each.
const LONG: usize = 4096;
const PIECE: usize = 128;
/// The most pixels that an image may have: 100 megapixels take 400 MB while being drawn.
const MOST_PIXELS: f64 = 1e8;

fn fault(reason: &dyn std::fmt::Display) -> Error {
    Error::Encode { format: "PNG", reason: reason.to_string() }
}

/// An opaque 8-bit PNG at `dpi`, with its resolution and the provenance inside.
pub(crate) fn png(drawing: &Drawing, fonts: &Fonts, dpi: f64) -> Result<Vec<u8>, Error> {
    let scale = dpi / PT_PER_INCH;
    let width = drawing.size_pt.0 * scale;
    let height = drawing.size_pt.1 * scale;
    if !(dpi > 0.0 && width * height <= MOST_PIXELS) {
        let most = (MOST_PIXELS / (width * height)).sqrt() * dpi;
        return Err(Error::Size {
            what: "dpi",
            value: dpi,
            most: if most.is_finite() { most.floor() } else { 0.0 },
        });
    }
    let width = width.round().max(1.0) as u32;
    let height = height.round().max(1.0) as u32;
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| fault(&"the image has no pixels"))?;
    pixmap.fill(Color::WHITE);
    drawing.shapes.iter().for_each(|shape| paint(&mut pixmap, shape, fonts, scale as f32));

    let mut bytes = Vec::new();
    encode(&mut bytes, &pixmap, dpi, drawing.provenance.as_deref())
        .map_err(|error| fault(&error))?;
    Ok(bytes)
}

/// The outline of a form in pixels, `scale` per point; `None` where nothing is to be seen.
pub(crate) fn outline(form: &Form, fonts: &Fonts, scale: f32) -> Option<Path> {
    let mut pixels = Pixels { path: PathBuilder::new(), scale };
    form.trace(fonts, &mut pixels);
    pixels.path.finish()
}

fn paint(pixmap: &mut Pixmap, shape: &Shape, fonts: &Fonts, scale: f32) {
    if let (Form::Curve(points), Ink::Stroke(stroke)) = (&shape.form, &shape.ink)
        && points.len() > LONG
    {
        return long_curve(pixmap, points, stroke, scale);
    }
    let Some(path) = outline(&shape.form, fonts, scale) else { return };
    match &shape.ink {
        Ink::Fill(colour, opacity) => {
            let ink = ink(*colour, *opacity);
            // By winding, as fonts mean it: parts of a letter may overlap.
            pixmap.fill_path(&path, &ink, FillRule::Winding, Transform::identity(), None);
        }
        Ink::Stroke(stroke) => {
            let pen = pen(stroke, scale);
            let ink = ink(stroke.colour, stroke.opacity);
            pixmap.stroke_path(&path, &ink, &pen, Transform::identity(), None);
        }
    }
}

fn pen(stroke: &Stroke, scale: f32) -> tiny_skia::Stroke {
    tiny_skia::Stroke {
        width: stroke.width_pt as f32 * scale,
        line_join: LineJoin::Round,
        line_cap: if stroke.round_ends() { LineCap::Round } else { LineCap::Butt },
        dash: stroke.dashes_pt().and_then(|dashes_pt| {
            let dashes = dashes_pt.into_iter().map(|pt| pt as f32 * scale).collect();
            StrokeDash::new(dashes, stroke.from_pt as f32 * scale)
        }),
        ..tiny_skia::Stroke::default()
    }
}

/// A curve of so many points that it crosses itself again and again, stroked piece by piece: the
/// whole takes the square of its crossings of a row of pixels. Pieces overlap, so a translucent
/// curve is one layer.
fn long_curve(pixmap: &mut Pixmap, points: &[At], stroke: &Stroke, scale: f32) {
    let Some(mut layer) = Pixmap::new(pixmap.width(), pixmap.height()) else { return };
    let mut piece = Stroke { opacity: 1.0, ..*stroke };
    for from in (0..points.len() - 1).step_by(PIECE) {
        // One stretch more than its own: there the joint with the next piece is.
        let part = &points[from..points.len().min(from + PIECE + 2)];
        let mut path = PathBuilder::new();
        path.move_to(part[0].0 as f32 * scale, part[0].1 as f32 * scale);
        part[1..].iter().for_each(|&(x, y)| path.line_to(x as f32 * scale, y as f32 * scale));
        if let Some(path) = path.finish() {
            let ink = ink(piece.colour, piece.opacity);
            layer.stroke_path(&path, &ink, &pen(&piece, scale), Transform::identity(), None);
        }
        // Dashes go on where the piece's own part ends.
        let own = &part[..part.len().min(PIECE + 1)];
        let lengths = own.windows(2).map(|pair| {
            let dx = pair[1].0 - pair[0].0;
            let dy = pair[1].1 - pair[0].1;
            (dx * dx + dy * dy).sqrt()
        });
        piece.from_pt += lengths.sum::<f64>();
    }
    let paint = PixmapPaint { opacity: stroke.opacity as f32, ..PixmapPaint::default() };
    pixmap.draw_pixmap(0, 0, layer.as_ref(), &paint, Transform::identity(), None);
}

fn ink(Colour { r, g, b }: Colour, opacity: f64) -> Paint<'static> {
    let alpha = (opacity * 255.0).round() as u8;
    Paint { shader: Shader::SolidColor(Color::from_rgba8(r, g, b, alpha)), ..Paint::default() }
}

/// An outline in pixels.
struct Pixels {
    path: PathBuilder,
    scale: f32,
}

impl OutlineBuilder for Pixels {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(x * self.scale, y * self.scale);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(x * self.scale, y * self.scale);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let s = self.scale;
        self.path.quad_to(x1 * s, y1 * s, x * s, y * s);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let s = self.scale;
        self.path.cubic_to(x1 * s, y1 * s, x2 * s, y2 * s, x * s, y * s);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

fn encode(
    bytes: &mut Vec<u8>,
    pixmap: &Pixmap,
    dpi: f64,
    comment: Option<&str>,
) -> Result<(), png::EncodingError> {
    let per_metre = (dpi * 1000.0 / MM_PER_INCH).round() as u32;
    let mut encoder = Encoder::new(bytes, pixmap.width(), pixmap.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_pixel_dims(Some(PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: Unit::Meter,
    }));
    if let Some(comment) = comment {
        // Not tEXt, which holds Latin-1 alone: provenance may name any path.
        encoder.add_itxt_chunk("Comment".to_owned(), comment.to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_chunk(IDAT, &compressed(pixmap)?)?;
    writer.finish()
}

/// The image data, some rows at a time: the encoder's own way, row by row, takes longer than the
/// compression. No filters, which are for photographs. Level 6 takes two and a half times as long
/// for files a tenth smaller.
fn compressed(pixmap: &Pixmap) -> std::io::Result<Vec<u8>> {
    const NO_FILTER: u8 = 0;
    const ROWS: usize = 16;
    let row_bytes = 4 * pixmap.width() as usize;
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::new(2));
    let mut rows = Vec::with_capacity(ROWS * row_bytes);
    for some in pixmap.data().chunks(ROWS * row_bytes) {
        rows.clear();
        for row in some.chunks_exact(row_bytes) {
            rows.push(NO_FILTER);
            row.chunks_exact(4).for_each(|rgba| rows.extend_from_slice(&rgba[..3])); // nothing shines through paper
        }
        zlib.write_all(&rows)?;
    }
    zlib.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::Dash;

    fn drawn(points: &[At], stroke: Stroke) -> Pixmap {
        let mut pixmap = Pixmap::new(400, 200).unwrap();
        pixmap.fill(Color::WHITE);
        let shape = Shape { form: Form::Curve(points.to_vec()), ink: Ink::Stroke(stroke) };
        paint(&mut pixmap, &shape, Fonts::bundled().unwrap(), 1.0);
        pixmap
    }

    #[test]
    fn a_curve_of_many_points_looks_as_one_of_few() {
        let wave = |n: usize| -> Vec<At> {
            let turn = |i: usize| i as f64 / (n - 1) as f64;
            (0..n)
                .map(|i| (10.0 + 380.0 * turn(i), 100.0 + 80.0 * (12.0 * turn(i)).sin()))
                .collect()
        };
        for dash in [Dash::Solid, Dash::Dashed] {
            for opacity in [1.0, 0.4] {
                let stroke =
                    Stroke { colour: Colour::hex(0), width_pt: 2.0, opacity, dash, from_pt: 0.0 };
                let (few, many) = (drawn(&wave(LONG), stroke), drawn(&wave(LONG + 1), stroke));
                let dark = |pixmap: &Pixmap| pixmap.data().iter().filter(|&&v| v < 200).count();
                assert!(dark(&few) > 500, "{dash:?} {opacity}");
                let off = few.data().iter().zip(many.data()).map(|(a, b)| a.abs_diff(*b));
                let (worst, unlike) = off.fold((0, 0), |(worst, unlike), off| {
                    (worst.max(off), unlike + usize::from(off > 40))
                });
                assert!(unlike < 40 && worst < 128, "{dash:?} {opacity}: {unlike}, {worst}");
            }
        }
    }
}
