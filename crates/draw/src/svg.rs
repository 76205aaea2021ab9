//! Writes SVG: a handful of shapes in points, with text as outlines or as text.
//!
//! Coordinates are written to a hundredth of a point (3.5 µm on paper). Shapes of one style stand in one group,
//! and each glyph's outline is written once, so that files stay small and can be edited by hand.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::font::{self, FAMILY, Fonts, Label, Piece, Style};
use crate::style::{Colour, Dash, Stroke};

/// Points a millimetre.
pub(crate) const PT_PER_MM: f64 = 72.0 / 25.4;

/// A point on the page, in pt from the top left.
pub(crate) type At = (f64, f64);

/// A rectangle on the page, in pt, y downwards.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rect {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Rect {
    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }
    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }
    pub(crate) fn grown(&self, by: f64) -> Self {
        Self { left: self.left - by, top: self.top - by, right: self.right + by, bottom: self.bottom + by }
    }
}

/// What becomes of letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TextAs {
    /// Filled outlines: looks alike wherever it is opened.
    Outlines,
    /// `<text>` in the bundled font: for the PDF, which embeds the font, so that its words can be found and copied.
    Text,
}

/// An SVG document being written.
pub(crate) struct Svg<'a> {
    fonts: &'a Fonts,
    text_as: TextAs,
    body: String,
    /// Style of the group that is open.
    open: Option<String>,
    /// Outlines in use, by face and glyph.
    glyphs: BTreeMap<(Style, u16), String>,
}

impl<'a> Svg<'a> {
    pub(crate) fn new(fonts: &'a Fonts, text_as: TextAs) -> Self {
        Self { fonts, text_as, body: String::new(), open: None, glyphs: BTreeMap::new() }
    }

    pub(crate) fn fonts(&self) -> &'a Fonts {
        self.fonts
    }

    /// An open polygon drawn with a pen.
    pub(crate) fn stroke(&mut self, points: &[At], stroke: &Stroke) {
        if points.len() >= 2 {
            let path = path(points);
            self.put(&stroke_style(stroke), format_args!("<path d=\"{path}\"/>"));
        }
    }

    /// A closed polygon filled with a colour.
    pub(crate) fn fill(&mut self, points: &[At], colour: Colour, opacity: f64) {
        if points.len() >= 3 {
            let path = path(points);
            self.put(&fill_style(colour, opacity), format_args!("<path d=\"{path}z\"/>"));
        }
    }

    pub(crate) fn disc(&mut self, (x, y): At, diameter_pt: f64, colour: Colour, opacity: f64) {
        let (x, y, r) = (number(x), number(y), number(diameter_pt / 2.0));
        self.put(&fill_style(colour, opacity), format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>"));
    }

    pub(crate) fn rect(&mut self, rect: &Rect, colour: Colour, opacity: f64) {
        let attributes = rect_attributes(rect);
        self.put(&fill_style(colour, opacity), format_args!("<rect {attributes}/>"));
    }

    /// A frame with rounded corners.
    pub(crate) fn frame(&mut self, rect: &Rect, radius_pt: f64, stroke: &Stroke) {
        let (attributes, r) = (rect_attributes(rect), number(radius_pt));
        self.put(&stroke_style(stroke), format_args!("<rect {attributes} rx=\"{r}\"/>"));
    }

    /// A line of text that starts on the base line at `at`; `turned` reads upwards.
    pub(crate) fn text(&mut self, label: &Label, at: At, colour: Colour, turned: bool) {
        for piece in label.pieces.iter().filter(|piece| !piece.text.trim().is_empty()) {
            // other renderers would put a mark over a Greek letter elsewhere
            let marked = piece.text.contains(font::is_mark);
            let element = match self.text_as {
                TextAs::Text if !marked => written(piece, at, turned),
                _ => self.outlined(piece, at, turned),
            };
            self.put(&fill_style(colour, 1.0), format_args!("{element}"));
        }
    }

    fn outlined(&mut self, piece: &Piece, at: At, turned: bool) -> String {
        let fonts = self.fonts;
        let scale = piece.size_pt / fonts.units_per_em(piece.style);
        let place = place(piece, at, turned, (scale, -scale));
        let mut element = format!("<g aria-label=\"{}\" transform=\"{place}\">", escape(&piece.text));
        for glyph in &piece.glyphs {
            let outline = self
                .glyphs
                .entry((piece.style, glyph.id))
                .or_insert_with(|| fonts.outline(piece.style, glyph.id));
            if !outline.is_empty() {
                let _ = write!(element, "<use xlink:href=\"#{}\"", glyph_name(piece.style, glyph.id));
                attribute(&mut element, "x", glyph.x);
                attribute(&mut element, "y", glyph.y);
                element.push_str("/>");
            }
        }
        element + "</g>"
    }

    /// Appends an element to the group of its style.
    fn put(&mut self, style: &str, element: std::fmt::Arguments<'_>) {
        if self.open.as_deref() != Some(style) {
            self.close();
            let _ = writeln!(self.body, "<g {style}>");
            self.open = Some(style.to_owned());
        }
        let _ = writeln!(self.body, "{element}");
    }

    fn close(&mut self) {
        if self.open.take().is_some() {
            self.body.push_str("</g>\n");
        }
    }

    /// The document. `head` are the texts that are stored and not shown.
    pub(crate) fn finish(mut self, width_pt: f64, height_pt: f64, head: &Head<'_>) -> String {
        self.close();
        let (w, h) = (number(width_pt), number(height_pt));
        let (w_mm, h_mm) = (number(width_pt / PT_PER_MM), number(height_pt / PT_PER_MM));
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
             width=\"{w_mm}mm\" height=\"{h_mm}mm\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
             {title}{desc}{metadata}{defs}{body}</svg>\n",
            title = stored("title", head.title),
            desc = stored("desc", head.description),
            metadata = stored("metadata", head.provenance.unwrap_or_default()),
            defs = self.defs(),
            body = self.body,
        )
    }

    fn defs(&self) -> String {
        let mut defs = String::from("<defs>\n");
        for ((style, id), outline) in self.glyphs.iter().filter(|(_, outline)| !outline.is_empty()) {
            let _ = writeln!(defs, "<path id=\"{}\" d=\"{outline}\"/>", glyph_name(*style, *id));
        }
        defs + "</defs>\n"
    }
}

/// Texts stored in the file and not shown.
pub(crate) struct Head<'a> {
    pub(crate) title: &'a str,
    pub(crate) description: &'a str,
    pub(crate) provenance: Option<&'a str>,
}

fn stored(name: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<{name}>{}</{name}>\n", escape(text)) }
}

fn written(piece: &Piece, at: At, turned: bool) -> String {
    let face = match piece.style {
        Style::Regular => "",
        Style::Italic => " font-style=\"italic\"",
        Style::Bold => " font-weight=\"bold\"",
    };
    let (size, text) = (number(piece.size_pt), escape(&piece.text));
    let place = place(piece, at, turned, (1.0, 1.0));
    format!(
        "<text xml:space=\"preserve\" font-family=\"{FAMILY}\" font-size=\"{size}\"{face} transform=\"{place}\">{text}</text>"
    )
}

/// Transform from a piece's own coordinates, scaled along and down the line, to the page.
fn place(piece: &Piece, (x, y): At, turned: bool, (along, down): (f64, f64)) -> String {
    let ((dx, dy), matrix) = if turned {
        ((piece.y_pt, -piece.x_pt), (0.0, -along, down, 0.0))
    } else {
        ((piece.x_pt, piece.y_pt), (along, 0.0, 0.0, down))
    };
    let (e, f) = (number(x + dx), number(y + dy));
    let (a, b, c, d) = matrix;
    format!("matrix({} {} {} {} {e} {f})", factor(a), factor(b), factor(c), factor(d))
}

/// A scale to six decimals: glyphs are some thousand units high.
fn factor(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn glyph_name(style: Style, id: u16) -> String {
    let letter = match style {
        Style::Regular => 'r',
        Style::Italic => 'i',
        Style::Bold => 'b',
    };
    format!("{letter}{id}")
}

fn attribute(element: &mut String, name: &str, value: i32) {
    if value != 0 {
        let _ = write!(element, " {name}=\"{value}\"");
    }
}

fn stroke_style(stroke: &Stroke) -> String {
    let mut style = format!(
        "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        hex(stroke.colour),
        number(stroke.width_pt)
    );
    if stroke.opacity < 1.0 {
        let _ = write!(style, " stroke-opacity=\"{}\"", number(stroke.opacity));
    }
    let w = stroke.width_pt;
    let _ = match stroke.dash {
        Dash::Solid => Ok(()),
        Dash::Dashed => write!(style, " stroke-dasharray=\"{} {}\"", number(4.0 * w), number(2.5 * w)),
        // dots: dashes of almost no length under round caps
        Dash::Dotted => {
            write!(style, " stroke-dasharray=\"0.01 {}\" stroke-linecap=\"round\"", number(2.1 * w))
        }
    };
    style
}

fn fill_style(colour: Colour, opacity: f64) -> String {
    let mut style = format!("fill=\"{}\"", hex(colour));
    if opacity < 1.0 {
        let _ = write!(style, " fill-opacity=\"{}\"", number(opacity));
    }
    style
}

fn hex(Colour { r, g, b }: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn rect_attributes(rect: &Rect) -> String {
    let (x, y, w, h) = (number(rect.left), number(rect.top), number(rect.width()), number(rect.height()));
    format!("x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"")
}

/// Path data: the first point absolute, then steps in hundredths that add up exactly.
fn path(points: &[At]) -> String {
    let mut path = String::from("M");
    let mut places: Vec<_> = points.iter().map(|&(x, y)| (hundredths(x), hundredths(y))).collect();
    places.dedup();
    let mut last = (0, 0);
    for (i, &here) in places.iter().enumerate() {
        if i == 1 {
            path.push('l');
        }
        push_number(&mut path, here.0 - last.0);
        push_number(&mut path, here.1 - last.1);
        last = here;
    }
    path
}

fn push_number(path: &mut String, value: i64) {
    let text = decimal(value);
    if !(text.starts_with('-') || path.ends_with(['M', 'l'])) {
        path.push(' ');
    }
    path.push_str(&text);
}

fn hundredths(value: f64) -> i64 {
    (value * 100.0).round() as i64
}

/// `value` to two decimals, without trailing or leading zeros.
pub(crate) fn number(value: f64) -> String {
    decimal(hundredths(value))
}

fn decimal(hundredths: i64) -> String {
    let (sign, size) = (if hundredths < 0 { "-" } else { "" }, hundredths.unsigned_abs());
    match (size / 100, size % 100) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, rest) if rest % 10 == 0 => format!("{sign}.{}", rest / 10),
        (0, rest) => format!("{sign}.{rest:02}"),
        (whole, rest) if rest % 10 == 0 => format!("{sign}{whole}.{}", rest / 10),
        (whole, rest) => format!("{sign}{whole}.{rest:02}"),
    }
}

/// Text as XML character data. Control characters, which XML cannot hold, become spaces.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' => escaped.push('\n'),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_right_to_a_hundredth() {
        for (value, expect) in [
            (0.0, "0"),
            (-0.001, "0"),
            (1.0, "1"),
            (0.5, ".5"),
            (-0.25, "-.25"),
            (12.345, "12.35"),
            (0.07, ".07"),
        ] {
            assert_eq!(number(value), expect);
        }
    }

    #[test]
    fn steps_of_a_path_add_up_without_drift() {
        assert_eq!(path(&[(1.004, 2.0), (1.008, 2.0), (1.012, 2.5), (0.0, 2.5)]), "M1 2l.01 0 0 .5-1.01 0");
    }

    #[test]
    fn text_cannot_break_out_of_the_document() {
        assert_eq!(escape("a<b>&\"\u{0}"), "a&lt;b&gt;&amp;&quot; ");
    }
}
