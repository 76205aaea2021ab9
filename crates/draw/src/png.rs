//! Paints a sheet on pixels and writes these as PNG.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use png::chunk::IDAT;
use png::{BitDepth, ColorType, Encoder, PixelDimensions, Unit};
use rustybuzz::ttf_parser::OutlineBuilder;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Shader, StrokeDash,
    Transform,
};

use crate::error::Error;
use crate::font::Fonts;
use crate::sheet::{Form, Ink, Shape};
use crate::style::Colour;

/// Points an inch.
const PT_PER_INCH: f64 = 72.0;
/// Millimetres an inch.
const MM_PER_INCH: f64 = 25.4;
/// The most pixels that an image may have: 100 megapixels take 400 MB while being drawn.
const MOST_PIXELS: f64 = 1e8;

fn fault(reason: &dyn std::fmt::Display) -> Error {
    Error::Encode { format: "PNG", reason: reason.to_string() }
}

/// An opaque 8-bit PNG at `dpi`, with its resolution and `comment` inside.
pub(crate) fn png(
    shapes: &[Shape],
    fonts: &Fonts,
    (width_pt, height_pt): (f64, f64),
    dpi: f64,
    comment: Option<&str>,
) -> Result<Vec<u8>, Error> {
    let scale = dpi / PT_PER_INCH;
    let (width, height) = (width_pt * scale, height_pt * scale);
    if !(dpi > 0.0 && width * height <= MOST_PIXELS) {
        let most = (MOST_PIXELS / (width * height)).sqrt() * dpi;
        return Err(Error::Size {
            what: "dpi",
            value: dpi,
            most: if most.is_finite() { most.floor() } else { 0.0 },
        });
    }
    let (width, height) = (width.round().max(1.0) as u32, height.round().max(1.0) as u32);
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| fault(&"the image has no pixels"))?;
    pixmap.fill(Color::WHITE);
    shapes.iter().for_each(|shape| paint(&mut pixmap, shape, fonts, scale as f32));

    let mut bytes = Vec::new();
    encode(&mut bytes, &pixmap, dpi, comment).map_err(|error| fault(&error))?;
    Ok(bytes)
}

/// The outline of a form in pixels, `scale` a point; `None` where nothing is to be seen.
pub(crate) fn outline(form: &Form, fonts: &Fonts, scale: f32) -> Option<Path> {
    let mut pixels = Pixels { path: PathBuilder::new(), scale };
    form.trace(fonts, &mut pixels);
    pixels.path.finish()
}

fn paint(pixmap: &mut Pixmap, shape: &Shape, fonts: &Fonts, scale: f32) {
    let Some(path) = outline(&shape.form, fonts, scale) else { return };
    match &shape.ink {
        Ink::Fill(colour, opacity) => {
            let ink = ink(*colour, *opacity);
            pixmap.fill_path(&path, &ink, FillRule::Winding, Transform::identity(), None);
        }
        Ink::Stroke(stroke) => {
            let dash = |pt: Vec<f64>| {
                let dashes = pt.into_iter().map(|pt| pt as f32 * scale).collect();
                StrokeDash::new(dashes, stroke.from_pt as f32 * scale)
            };
            let pen = tiny_skia::Stroke {
                width: stroke.width_pt as f32 * scale,
                line_join: LineJoin::Round,
                line_cap: if stroke.round_ends() { LineCap::Round } else { LineCap::Butt },
                dash: stroke.dashes_pt().and_then(dash),
                ..tiny_skia::Stroke::default()
            };
            let ink = ink(stroke.colour, stroke.opacity);
            pixmap.stroke_path(&path, &ink, &pen, Transform::identity(), None);
        }
    }
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
