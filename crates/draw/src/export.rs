//! From the finished SVG to the bytes of PNG and PDF.

use std::sync::Arc;

use krilla::Document;
use krilla::geom::Size;
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt as _, SvgSettings};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use crate::error::Error;
use crate::font::{FAMILY, Style};

/// Pixels an inch of CSS and of usvg's trees.
const CSS_DPI: f64 = 96.0;
/// Millimetres an inch.
const MM_PER_INCH: f64 = 25.4;
/// The most pixels that an image may have: 100 megapixels take 400 MB while being drawn.
const MOST_PIXELS: f64 = 1e8;

fn fault(format: &'static str) -> impl Fn(&dyn std::fmt::Display) -> Error {
    move |reason| Error::Encode { format, reason: reason.to_string() }
}

/// Parses an SVG with the bundled font and no other.
pub(crate) fn tree(svg: &str) -> Result<Tree, Error> {
    let mut fonts = fontdb::Database::new();
    for style in Style::ALL {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(style.bytes())));
    }
    let options = Options { fontdb: Arc::new(fonts), font_family: FAMILY.to_owned(), ..Options::default() };
    Tree::from_str(svg, &options).map_err(|error| fault("SVG")(&error))
}

/// An opaque 8-bit PNG at `dpi`, with its resolution and `comment` inside.
pub(crate) fn png(svg: &str, dpi: f64, comment: Option<&str>) -> Result<Vec<u8>, Error> {
    let tree = tree(svg)?;
    let scale = dpi / CSS_DPI;
    let (width, height) = (f64::from(tree.size().width()) * scale, f64::from(tree.size().height()) * scale);
    if !(dpi > 0.0 && width * height <= MOST_PIXELS) {
        let most = (MOST_PIXELS / (width * height)).sqrt() * dpi;
        return Err(Error::Size {
            what: "dpi",
            value: dpi,
            most: if most.is_finite() { most.floor() } else { 0.0 },
        });
    }
    let (width, height) = (width.round().max(1.0) as u32, height.round().max(1.0) as u32);
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| fault("PNG")(&"the image has no pixels"))?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());

    let opaque: Vec<u8> = pixmap.data().chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    let mut bytes = Vec::new();
    let encoded = encode(&mut bytes, (width, height), &opaque, dpi, comment);
    encoded.map_err(|error| fault("PNG")(&error))?;
    Ok(bytes)
}

fn encode(
    bytes: &mut Vec<u8>,
    (width, height): (u32, u32),
    rgb: &[u8],
    dpi: f64,
    comment: Option<&str>,
) -> Result<(), png::EncodingError> {
    let per_metre = (dpi * 1000.0 / MM_PER_INCH).round() as u32;
    let mut encoder = png::Encoder::new(bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced); // High: seven times as long for 2 % less
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    if let Some(comment) = comment {
        encoder.add_itxt_chunk("Comment".to_owned(), comment.to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()
}

/// A one-page PDF with the font embedded. `width_pt` × `height_pt` is the size on paper.
pub(crate) fn pdf(svg: &str, (width_pt, height_pt): (f64, f64), head: PdfHead<'_>) -> Result<Vec<u8>, Error> {
    let tree = tree(svg)?;
    let size =
        Size::from_wh(width_pt as f32, height_pt as f32).ok_or_else(|| fault("PDF")(&"the page is empty"))?;
    let mut document = Document::new();
    let metadata = Metadata::new().title(head.title.to_owned()).description(head.description.to_owned());
    document.set_metadata(match head.keywords {
        Some(keywords) => metadata.keywords(vec![keywords.to_owned()]),
        None => metadata,
    });
    let mut page = document.start_page_with(PageSettings::new(size));
    let mut surface = page.surface();
    let drawn = surface.draw_svg(&tree, size, SvgSettings::default());
    surface.finish();
    page.finish();
    drawn.ok_or_else(|| fault("PDF")(&"the drawing was refused"))?;
    document.finish().map_err(|error| Error::Encode { format: "PDF", reason: format!("{error:?}") })
}

/// Texts of a PDF's document information.
pub(crate) struct PdfHead<'a> {
    pub(crate) title: &'a str,
    pub(crate) description: &'a str,
    pub(crate) keywords: Option<&'a str>,
}
