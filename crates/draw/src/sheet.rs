//! A drawn page: shapes in points from the top left, before they are written in a format.

use rustybuzz::ttf_parser::OutlineBuilder;

use crate::font::{Fonts, Label, Piece};
use crate::style::{Colour, Stroke};

/// Points per millimetre.
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
        Self {
            left: self.left - by,
            top: self.top - by,
            right: self.right + by,
            bottom: self.bottom + by,
        }
    }
}

/// What a shape is drawn with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ink {
    Stroke(Stroke),
    /// Colour and opacity.
    Fill(Colour, f64),
}

/// Where a shape lies. Lengths are whole hundredths of a point (3.5 µm on paper).
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// An open polygon.
    Curve(Vec<At>),
    /// A closed polygon.
    Area(Vec<At>),
    /// Centre and radius.
    Disc(At, f64),
    /// A rectangle, and the radius of its corners.
    Box(Rect, f64),
    /// Letters of one style that start on the base line at a point; if turned, they read upwards.
    Words { piece: Piece, start: At, turned: bool },
}

/// Something drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shape {
    pub(crate) form: Form,
    pub(crate) ink: Ink,
}

/// A page being drawn.
pub(crate) struct Sheet<'f> {
    pub(crate) fonts: &'f Fonts<'f>,
    pub(crate) shapes: Vec<Shape>,
}

impl<'f> Sheet<'f> {
    pub(crate) fn new(fonts: &'f Fonts<'f>) -> Self {
        Self { fonts, shapes: Vec::new() }
    }

    fn put(&mut self, form: Form, ink: Ink) {
        self.shapes.push(Shape { form, ink });
    }

    /// An open polygon drawn with a pen.
    pub(crate) fn stroke(&mut self, points: &[At], stroke: &Stroke) {
        if points.len() >= 2 && stroke.width_pt > 0.0 {
            self.put(Form::Curve(places(points)), Ink::Stroke(pen(stroke)));
        }
    }

    /// A closed polygon filled with a colour.
    pub(crate) fn fill(&mut self, points: &[At], colour: Colour, opacity: f64) {
        if points.len() >= 3 {
            self.put(Form::Area(places(points)), fill(colour, opacity));
        }
    }

    pub(crate) fn disc(&mut self, centre: At, diameter_pt: f64, colour: Colour, opacity: f64) {
        self.put(Form::Disc(place(centre), hundredth(diameter_pt / 2.0)), fill(colour, opacity));
    }

    pub(crate) fn rect(&mut self, rect: &Rect, colour: Colour, opacity: f64) {
        self.put(Form::Box(sized(rect), 0.0), fill(colour, opacity));
    }

    /// A frame with rounded corners.
    pub(crate) fn frame(&mut self, rect: &Rect, radius_pt: f64, stroke: &Stroke) {
        self.put(Form::Box(sized(rect), hundredth(radius_pt)), Ink::Stroke(pen(stroke)));
    }

    /// A line of text that starts on the base line at `at`; `turned` reads upwards.
    pub(crate) fn text(&mut self, label: &Label, (x, y): At, colour: Colour, turned: bool) {
        // Spaces leave no ink.
        for piece in label.pieces.iter().filter(|piece| !piece.text.trim().is_empty()) {
            let (dx, dy) =
                if turned { (piece.y_pt, -piece.x_pt) } else { (piece.x_pt, piece.y_pt) };
            let form = Form::Words { piece: piece.clone(), start: place((x + dx, y + dy)), turned };
            self.put(form, Ink::Fill(colour, 1.0));
        }
    }
}

/// An opacity from 0 to 1; NaN counts as 1.
fn share(opacity: f64) -> f64 {
    if opacity.is_nan() { 1.0 } else { opacity.clamp(0.0, 1.0) }
}

fn pen(stroke: &Stroke) -> Stroke {
    Stroke { opacity: share(stroke.opacity), ..*stroke }
}

fn fill(colour: Colour, opacity: f64) -> Ink {
    Ink::Fill(colour, share(opacity))
}

fn hundredth(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn place((x, y): At) -> At {
    (hundredth(x), hundredth(y))
}

/// Places, each once where several follow each other.
fn places(points: &[At]) -> Vec<At> {
    let mut places: Vec<At> = points.iter().copied().map(place).collect();
    places.dedup();
    places
}

fn sized(rect: &Rect) -> Rect {
    let (left, top) = place((rect.left, rect.top));
    // Rounded by their lengths: boxes of one size stay of one size, wherever they stand.
    Rect {
        left,
        top,
        right: left + hundredth(rect.width()),
        bottom: top + hundredth(rect.height()),
    }
}

/// Control points of a quarter circle as a cubic, in radii from its ends: off by 0.03 % of the
/// radius.
const QUARTER: f64 = 0.552_284_75;

impl Form {
    /// The outline on the page, in pt.
    pub(crate) fn trace(&self, fonts: &Fonts, pen: &mut dyn OutlineBuilder) {
        match self {
            Self::Curve(points) => polygon(points, pen),
            Self::Area(points) => {
                polygon(points, pen);
                pen.close();
            }
            Self::Disc((x, y), r) => {
                rounded(&Rect { left: x - r, top: y - r, right: x + r, bottom: y + r }, *r, pen);
            }
            Self::Box(Rect { left, top, right, bottom }, r) if *r <= 0.0 => {
                polygon(&[(*left, *top), (*right, *top), (*right, *bottom), (*left, *bottom)], pen);
                pen.close();
            }
            Self::Box(rect, r) => rounded(rect, *r, pen),
            Self::Words { piece, start, turned } => {
                let scale = piece.size_pt / fonts.units_per_em(piece.face);
                for glyph in &piece.glyphs {
                    let from = (f64::from(glyph.x), f64::from(glyph.y));
                    let placed = &mut Placed { pen, scale, from, start: *start, turned: *turned };
                    fonts.trace(piece.face, glyph.id, placed);
                }
            }
        }
    }
}

fn polygon(points: &[At], pen: &mut dyn OutlineBuilder) {
    for (i, &(x, y)) in points.iter().enumerate() {
        match i {
            0 => pen.move_to(x as f32, y as f32),
            _ => pen.line_to(x as f32, y as f32),
        }
    }
}

/// A rectangle with round corners, clockwise from the upper edge's left end.
fn rounded(&Rect { left, top, right, bottom }: &Rect, r: f64, pen: &mut dyn OutlineBuilder) {
    let corners = [
        ((right, top), (1.0, 0.0)),
        ((right, bottom), (0.0, 1.0)),
        ((left, bottom), (-1.0, 0.0)),
        ((left, top), (0.0, -1.0)),
    ];
    pen.move_to((left + r) as f32, top as f32);
    for ((x, y), (dx, dy)) in corners {
        // the way turns from (dx, dy) to (-dy, dx)
        let at = |back: f64, on: f64| {
            ((x - back * dx - on * dy) as f32, (y - back * dy + on * dx) as f32)
        };
        let rest = (1.0 - QUARTER) * r;
        let [(x0, y0), (x1, y1)] = [r, rest].map(|back| at(back, 0.0));
        let [(x2, y2), (x3, y3)] = [rest, r].map(|on| at(0.0, on));
        pen.line_to(x0, y0);
        pen.curve_to(x1, y1, x2, y2, x3, y3);
    }
    pen.close();
}

/// Carries a glyph from the font's units, y upwards, to its place on the page.
struct Placed<'p> {
    pen: &'p mut dyn OutlineBuilder,
    scale: f64,
    from: (f64, f64),
    start: At,
    turned: bool,
}

impl Placed<'_> {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        let along = self.scale * (self.from.0 + f64::from(x));
        let up = self.scale * (self.from.1 + f64::from(y));
        let (dx, dy) = if self.turned { (-up, -along) } else { (along, -up) };
        ((self.start.0 + dx) as f32, (self.start.1 + dy) as f32)
    }
}

impl OutlineBuilder for Placed<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.pen.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.pen.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (x1, y1) = self.at(x1, y1);
        let (x, y) = self.at(x, y);
        self.pen.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (x1, y1) = self.at(x1, y1);
        let (x2, y2) = self.at(x2, y2);
        let (x, y) = self.at(x, y);
        self.pen.curve_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.pen.close();
    }
}

/// Lines one under the other, the first one's upper edge at `top`.
pub(crate) fn lines(sheet: &mut Sheet, lines: &[Label], (left, mut top): At, colour: Colour) {
    for line in lines {
        sheet.text(line, (left, top + line.ascent_pt()), colour, false);
        top += line.height_pt();
    }
}

/// Lines centred on `middle`, the first one's upper edge at `top`.
pub(crate) fn centred(sheet: &mut Sheet, block: &[Label], (middle, mut top): At, colour: Colour) {
    for line in block {
        lines(sheet, std::slice::from_ref(line), (middle - line.width_pt / 2.0, top), colour);
        top += line.height_pt();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends of lines and curves.
    #[derive(Default)]
    struct Ends(Vec<(f32, f32)>);

    impl OutlineBuilder for Ends {
        fn move_to(&mut self, x: f32, y: f32) {
            self.0.push((x, y));
        }
        fn line_to(&mut self, x: f32, y: f32) {
            self.0.push((x, y));
        }
        fn quad_to(&mut self, _: f32, _: f32, x: f32, y: f32) {
            self.0.push((x, y));
        }
        fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
            self.0.push((x, y));
        }
        fn close(&mut self) {}
    }

    fn ends(form: &Form) -> Vec<(f32, f32)> {
        let mut ends = Ends::default();
        form.trace(Fonts::bundled().unwrap(), &mut ends);
        ends.0
    }

    #[test]
    fn a_disc_touches_the_four_sides_of_its_square_and_a_round_corner_its_two() {
        // Each side twice: a straight piece of no length begins and ends there.
        let sides = [(2.0, 0.0), (4.0, 2.0), (2.0, 4.0), (0.0, 2.0)];
        let expect = sides.map(|side| [side; 2]).concat();
        assert_eq!(ends(&Form::Disc((2.0, 2.0), 2.0))[..8], expect);
        let rect = Rect { left: 0.0, top: 0.0, right: 10.0, bottom: 6.0 };
        let found = ends(&Form::Box(rect, 1.0));
        assert_eq!(found[..4], [(1.0, 0.0), (9.0, 0.0), (10.0, 1.0), (10.0, 5.0)]);
        assert_eq!(found[4..8], [(9.0, 6.0), (1.0, 6.0), (0.0, 5.0), (0.0, 1.0)]);
    }

    #[test]
    fn turned_letters_read_upwards() {
        let fonts = Fonts::bundled().unwrap();
        let label = fonts.label("l", 10.0).unwrap();
        let words =
            |turned| Form::Words { piece: label.pieces[0].clone(), start: (50.0, 50.0), turned };
        for ((x, y), (turned_x, turned_y)) in
            ends(&words(false)).into_iter().zip(ends(&words(true)))
        {
            assert!(x >= 50.0 && y <= 50.0, "to the right of its start and above it: {x}, {y}");
            assert!((turned_x - y).abs() < 1e-5 && (turned_y - (100.0 - x)).abs() < 1e-5);
        }
    }

    #[test]
    fn lengths_are_whole_hundredths_and_what_falls_on_one_place_is_one_point() {
        let mut sheet = Sheet::new(Fonts::bundled().unwrap());
        sheet.stroke(&[(1.004, 2.0), (1.001, 2.0), (1.012, 2.5)], &Stroke::default());
        assert_eq!(sheet.shapes[0].form, Form::Curve(vec![(1.0, 2.0), (1.01, 2.5)]));
    }
}
