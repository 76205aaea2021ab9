//! Writes a sheet as SVG, with words as outlines or as text.
//!
//! Shapes of one style are in one group, and each glyph's outline is written once, so files stay
//! small and can be edited by hand.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use rustybuzz::ttf_parser::OutlineBuilder;

use crate::drawing::Drawing;
use crate::font::{Fonts, Piece};
use crate::sheet::{At, Form, Ink, PT_PER_MM, Shape};
use crate::typeface::{Style, Typeface};

/// How words are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Words<'a> {
    /// As shapes: every program shows them alike, and needs no font.
    Outlines,
    /// As text that can be edited and searched, in a font of this name if there is one.
    Text(Option<&'a str>),
}

/// The font of words that are text, and what comes near it.
const FAMILY: &str = "'Noto Sans', 'DejaVu Sans', sans-serif";

/// The document.
pub(crate) fn svg(drawing: &Drawing, fonts: &Fonts, words: Words<'_>) -> String {
    let mut body = Body { fonts, words, text: String::new(), open: None, glyphs: BTreeMap::new() };
    drawing.shapes.iter().for_each(|shape| body.put(shape));
    body.close();
    let (width_pt, height_pt) = drawing.size_pt;
    let [w, h] = [width_pt, height_pt].map(number);
    let [w_mm, h_mm] = [width_pt, height_pt].map(|pt| number(pt / PT_PER_MM));
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{w_mm}mm\" height=\"{h_mm}mm\" viewBox=\"0 0 {w} {h}\"{family} role=\"img\">\n\
         {title}{desc}{metadata}{defs}{body}</svg>\n",
        family = match words {
            Words::Outlines => String::new(),
            Words::Text(None) => format!(" font-family=\"{FAMILY}\""),
            Words::Text(Some(font)) => {
                // Quoted as a string of CSS, within an attribute.
                let font = font.replace('\\', "\\\\").replace('\'', "\\'");
                format!(" font-family=\"'{}', {FAMILY}\"", escape(&font))
            }
        },
        title = stored("title", &drawing.title),
        desc = stored("desc", &drawing.description),
        metadata = stored("metadata", drawing.provenance.as_deref().unwrap_or_default()),
        defs = body.defs(),
        body = body.text,
    )
}

/// The shapes, as they are written.
struct Body<'a> {
    fonts: &'a Fonts<'a>,
    words: Words<'a>,
    text: String,
    /// Style of the group that is open.
    open: Option<Ink>,
    /// Outlines in use, by face and glyph.
    glyphs: BTreeMap<(Typeface, u16), String>,
}

impl Body<'_> {
    /// Appends a shape to the group of its style.
    fn put(&mut self, shape: &Shape) {
        if self.open != Some(shape.ink) {
            self.close();
            // Writing to a string cannot fail, here and below.
            let _ = writeln!(self.text, "<g {}>", style(&shape.ink));
            self.open = Some(shape.ink);
        }
        match &shape.form {
            Form::Curve(points) | Form::Area(points) => {
                self.text.push_str("<path d=\"");
                push_path(&mut self.text, points);
                let is_closed = matches!(shape.form, Form::Area(_));
                self.text.push_str(if is_closed { "z\"/>" } else { "\"/>" });
            }
            Form::Disc((x, y), r) => {
                let [x, y, r] = [*x, *y, *r].map(number);
                let _ = write!(self.text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>");
            }
            Form::Box(rect, r) => {
                let [x, y, w, h] = [rect.left, rect.top, rect.width(), rect.height()].map(number);
                let _ = write!(self.text, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"");
                if *r > 0.0 {
                    let _ = write!(self.text, " rx=\"{}\"", number(*r));
                }
                self.text.push_str("/>");
            }
            Form::Words { piece, start, turned } => match self.words {
                Words::Outlines => self.outlines(piece, *start, *turned),
                Words::Text(_) => self.as_text(piece, *start, *turned),
            },
        }
        self.text.push('\n');
    }

    fn close(&mut self) {
        if self.open.take().is_some() {
            self.text.push_str("</g>\n");
        }
    }

    /// Text as long as its outlines, whatever the font.
    fn as_text(&mut self, piece: &Piece, (x, y): At, turned: bool) {
        let scale = piece.size_pt / self.fonts.units_per_em(piece.face);
        let length = f64::from(piece.advance) * scale;
        let [x, y, size, length] = [x, y, piece.size_pt, length].map(number);
        let face = match piece.face.style {
            Style::Regular => "",
            Style::Italic => " font-style=\"italic\"",
            Style::Bold => " font-weight=\"bold\"",
        };
        let place = match turned {
            true => format!("transform=\"translate({x} {y}) rotate(-90)\""),
            false => format!("x=\"{x}\" y=\"{y}\""),
        };
        let words = escape(&piece.text);
        let _ = write!(
            self.text,
            "<text {place} font-size=\"{size}\"{face} textLength=\"{length}\" \
             lengthAdjust=\"spacingAndGlyphs\" xml:space=\"preserve\">{words}</text>"
        );
    }

    fn outlines(&mut self, piece: &Piece, start: At, turned: bool) {
        let fonts = self.fonts;
        let label = escape(&piece.text);
        let place = transform(piece, fonts, start, turned);
        let _ = write!(self.text, "<g aria-label=\"{label}\" transform=\"{place}\">");
        for glyph in &piece.glyphs {
            let outline = self.glyphs.entry((piece.face, glyph.id)).or_insert_with(|| {
                let mut path = PathData(String::new());
                fonts.trace(piece.face, glyph.id, &mut path);
                path.0
            });
            if !outline.is_empty() {
                // Readers of SVG 1.1 know no plain `href`.
                let _ =
                    write!(self.text, "<use xlink:href=\"#{}\"", glyph_name(piece.face, glyph.id));
                for (name, value) in [("x", glyph.x), ("y", glyph.y)] {
                    if value != 0 {
                        let _ = write!(self.text, " {name}=\"{value}\"");
                    }
                }
                self.text.push_str("/>");
            }
        }
        self.text.push_str("</g>");
    }

    fn defs(&self) -> String {
        let mut defs = String::from("<defs>\n");
        for ((face, id), outline) in self.glyphs.iter().filter(|(_, outline)| !outline.is_empty()) {
            let _ = writeln!(defs, "<path id=\"{}\" d=\"{outline}\"/>", glyph_name(*face, *id));
        }
        defs + "</defs>\n"
    }
}

fn stored(name: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<{name}>{}</{name}>\n", escape(text)) }
}

/// Transform from a piece's own units, y upwards, to the page.
fn transform(piece: &Piece, fonts: &Fonts, (x, y): At, turned: bool) -> String {
    let scale = piece.size_pt / fonts.units_per_em(piece.face);
    let [along, down] = [scale, -scale].map(factor);
    let [x, y] = [x, y].map(number);
    match turned {
        true => format!("matrix(0 {down} {down} 0 {x} {y})"),
        false => format!("matrix({along} 0 0 {down} {x} {y})"),
    }
}

/// A scale to six decimals: glyphs are some thousand units high.
fn factor(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn glyph_name(Typeface { is_own, style }: Typeface, id: u16) -> String {
    let letters = if is_own { ['R', 'I', 'B'] } else { ['r', 'i', 'b'] };
    format!("{}{id}", letters[style as usize])
}

fn style(ink: &Ink) -> String {
    let stroke = match ink {
        Ink::Stroke(stroke) => stroke,
        Ink::Fill(colour, opacity) => {
            let mut style = format!("fill=\"{}\"", colour.css());
            if *opacity < 1.0 {
                let _ = write!(style, " fill-opacity=\"{}\"", number(*opacity));
            }
            return style;
        }
    };
    let mut style = format!(
        "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        stroke.colour.css(),
        number(stroke.width_pt)
    );
    if stroke.opacity < 1.0 {
        let _ = write!(style, " stroke-opacity=\"{}\"", number(stroke.opacity));
    }
    if let Some(dashes) = stroke.dashes_pt() {
        let dashes: Vec<String> = dashes.into_iter().map(number).collect();
        let _ = write!(style, " stroke-dasharray=\"{}\"", dashes.join(" "));
        if stroke.from_pt > 0.0 {
            let _ = write!(style, " stroke-dashoffset=\"{}\"", number(stroke.from_pt));
        }
    }
    if stroke.round_ends() {
        style.push_str(" stroke-linecap=\"round\"");
    }
    style
}

/// Path data: the first point absolute, then steps in hundredths that add up exactly.
fn push_path(path: &mut String, points: &[At]) {
    path.push('M');
    let mut last = (0, 0);
    for (i, &(x, y)) in points.iter().enumerate() {
        if i == 1 {
            path.push('l');
        }
        // Differences of whole numbers: rounded steps would add up to a drift.
        let here = (hundredths(x), hundredths(y));
        push_number(path, here.0 - last.0);
        push_number(path, here.1 - last.1);
        last = here;
    }
}

fn push_number(path: &mut String, value: i64) {
    if value >= 0 && !path.ends_with(['M', 'l']) {
        path.push(' ');
    }
    push_decimal(path, value);
}

fn hundredths(value: f64) -> i64 {
    (value * 100.0).round() as i64
}

/// `value` to two decimals, without trailing or leading zeros.
pub(crate) fn number(value: f64) -> String {
    let mut text = String::new();
    push_decimal(&mut text, hundredths(value));
    text
}

/// Digit by digit: curves have ten thousands of numbers, and formatting them is most of writing a
/// figure.
fn push_decimal(text: &mut String, hundredths: i64) {
    let size = hundredths.unsigned_abs();
    let whole = size / 100;
    let rest = (size % 100) as u8;
    if hundredths < 0 {
        text.push('-');
    }
    if whole > 0 || rest == 0 {
        let _ = write!(text, "{whole}");
    }
    if rest > 0 {
        text.push('.');
        text.push(char::from(b'0' + rest / 10));
    }
    if !rest.is_multiple_of(10) {
        text.push(char::from(b'0' + rest % 10));
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

/// A glyph's outline as path data, in font units, y upwards.
struct PathData(String);

impl PathData {
    fn add(&mut self, command: char, values: &[f32]) {
        self.0.push(command);
        for (i, &value) in values.iter().enumerate() {
            let text = number(f64::from(value));
            // A minus sign parts two numbers as well as a blank.
            if i > 0 && !text.starts_with('-') {
                self.0.push(' ');
            }
            self.0.push_str(&text);
        }
    }
}

impl OutlineBuilder for PathData {
    fn move_to(&mut self, x: f32, y: f32) {
        self.add('M', &[x, y]);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.add('L', &[x, y]);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.add('Q', &[x1, y1, x, y]);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.add('C', &[x1, y1, x2, y2, x, y]);
    }
    fn close(&mut self) {
        self.0.push('Z');
    }
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
        let mut path = String::new();
        push_path(&mut path, &[(1.0, 2.0), (1.01, 2.0), (1.01, 2.5), (0.0, 2.5)]);
        assert_eq!(path, "M1 2l.01 0 0 .5-1.01 0");
    }

    #[test]
    fn text_cannot_break_out_of_the_document() {
        assert_eq!(escape("a<b>&\"\u{0}"), "a&lt;b&gt;&amp;&quot; ");
    }
}
