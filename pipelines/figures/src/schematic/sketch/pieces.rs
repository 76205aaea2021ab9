//! Pieces along a line, words at their place, and the panel that holds them.

use super::way::{Point, Way};
use zwidth_draw::style::{self, Colour, Stroke};
use zwidth_draw::{Axis, Band, Cell, Layer, Line, Panel, Points, Text, TextPlace};

/// Length of an arrow's head, mm, and half its width as a share of that.
const HEAD_MM: f64 = 2.4;
const HEAD_WIDE: f64 = 0.42;
/// The most of a short arrow that is head.
const HEAD_SHARE: f64 = 0.6;
/// Length of a coil, and how far it stands out to either side, mm.
const COIL_MM: (f64, f64) = (1.9, 1.9);
/// Shares of a spring that are straight, at either end.
const STRAIGHT: f64 = 0.1;
/// Where a damper's cup begins and ends and where its piston stands, as shares of its length.
const DAMPER: [f64; 3] = [0.3, 0.7, 0.55];
/// Half the width of a damper's cup and of its piston, mm.
const CUP_MM: (f64, f64) = (2.2, 1.5);
/// Points per millimetre.
const PT_PER_MM: f64 = 72.0 / 25.4;
/// Distance between two hatches of a ground, and how far each leans and reaches, mm.
const HATCH_MM: (f64, f64) = (1.3, 1.3);

/// A line from point to point.
pub(crate) fn line(points: impl IntoIterator<Item = Point>, stroke: Stroke) -> Layer {
    let (x, y) = points.into_iter().unzip();
    Layer::Line(Line { x, y, stroke, ..Line::default() })
}

/// A line along a way that ends in an arrow's head.
pub(crate) fn arrow(way: &Way, stroke: Stroke) -> Vec<Layer> {
    let end = way.length();
    let long = HEAD_MM.min(HEAD_SHARE * end);
    let [left, right] = [HEAD_WIDE, -HEAD_WIDE].map(|left| way.at(end - long, left * long));
    let head = [left, way.at(end, 0.0), right];
    vec![line(way.points(), stroke), line(head, stroke)]
}

/// What goes from point to point: a line in ink that ends in an arrow.
pub(crate) fn flow(points: impl IntoIterator<Item = Point>) -> Vec<Layer> {
    arrow(&Way::through(points), style::mean(style::INK))
}

/// A spring along a way.
pub(crate) fn spring(way: &Way, stroke: Stroke) -> Layer {
    let length = way.length();
    let first = STRAIGHT * length;
    let last = (1.0 - STRAIGHT) * length;
    // Fewer than three coils look like no spring.
    let coils = ((last - first) / COIL_MM.0).round().max(3.0) as usize;
    let mut points = vec![way.at(0.0, 0.0)];
    for i in 0..=2 * coils {
        let left = match i {
            0 => 0.0,
            i if i == 2 * coils => 0.0, // it begins and ends on its own line
            i if i % 2 == 0 => -COIL_MM.1,
            _ => COIL_MM.1,
        };
        points.push(way.at(first + (last - first) * i as f64 / (2 * coils) as f64, left));
    }
    points.push(way.at(length, 0.0));
    line(points, stroke)
}

/// A damper along a way: a piston in a cup that is open towards the way's beginning.
pub(crate) fn damper(way: &Way, stroke: Stroke) -> Vec<Layer> {
    let [open, bottom, piston] = DAMPER.map(|share| share * way.length());
    // A point halfway too, because the way may be an arc.
    let [rod, foot] = [(0.0, piston), (bottom, way.length())]
        .map(|(from, to)| [from, (from + to) / 2.0, to].map(|along| way.at(along, 0.0)));
    let (cup, disc) = CUP_MM;
    let corners = [(open, cup), (bottom, cup), (bottom, -cup), (open, -cup)];
    vec![
        line(rod, stroke),
        line([way.at(piston, disc), way.at(piston, -disc)], stroke),
        line(corners.map(|(along, left)| way.at(along, left)), stroke),
        line(foot, stroke),
    ]
}

/// Something that does not move: a line along a straight way, hatched on its right.
pub(crate) fn ground(way: &Way, stroke: Stroke) -> Vec<Layer> {
    let fine = Stroke { width_pt: 0.6, ..stroke };
    let (apart, reach) = HATCH_MM;
    let hatches = (way.length() / apart).floor().max(1.0);
    let mut layers: Vec<Layer> = (0..hatches as usize)
        .map(|i| {
            let along = way.length() * (i as f64 + 0.5) / hatches;
            line([way.at(along, 0.0), way.at(along + reach, -reach)], fine)
        })
        .collect();
    layers.push(line(way.points(), stroke));
    layers
}

/// A circle around paper, which hides what was drawn there before: two spots, because the points of
/// a line are thinned where it stands upright.
pub(crate) fn ring(centre: Point, radius: f64, stroke: Stroke) -> [Layer; 2] {
    let diameter_pt = 2.0 * radius * PT_PER_MM;
    [(stroke.width_pt, stroke.colour), (-stroke.width_pt, style::PAPER)]
        .map(|(more_pt, colour)| disc(centre, diameter_pt + more_pt, colour))
}

/// A round spot; its size is in points.
pub(crate) fn disc((x, y): Point, diameter_pt: f64, colour: Colour) -> Layer {
    Layer::Points(Points { x: vec![x], y: vec![y], colour, diameter_pt, ..Points::default() })
}

/// A light ground between two corners.
pub(crate) fn tint(low: Point, high: Point, colour: Colour) -> Layer {
    let x = vec![low.0, high.0];
    let low = vec![low.1; 2];
    let high = vec![high.1; 2];
    Layer::Band(Band { x, low, high, colour, name: None })
}

/// Words centred over a point.
pub(crate) fn over(words: impl Into<String>, (x, y): Point) -> Layer {
    text(vec![words.into()], TextPlace::Over(x, y))
}

/// Lines centred on a point.
pub(crate) fn amid(lines: Vec<String>, (x, y): Point) -> Layer {
    text(lines, TextPlace::Amid(x, y))
}

/// Lines to the right of a point.
pub(crate) fn right_of(lines: Vec<String>, (x, y): Point) -> Layer {
    text(lines, TextPlace::RightOf(x, y))
}

/// Lines to the left of a point.
pub(crate) fn left_of(lines: Vec<String>, (x, y): Point) -> Layer {
    text(lines, TextPlace::LeftOf(x, y))
}

/// Lines in the box between two corners.
pub(crate) fn within(lines: Vec<String>, low: Point, high: Point) -> Layer {
    text(lines, TextPlace::Within(low, high))
}

fn text(lines: Vec<String>, place: TextPlace) -> Layer {
    Layer::Text(Text { lines, place })
}

/// A panel that shows what lies between two corners, true to scale.
pub(crate) fn panel(cell: Cell, low: Point, high: Point, layers: Vec<Layer>) -> Panel {
    let x = Axis::bare(low.0, high.0);
    let y = Axis::bare(low.1, high.1);
    Panel::new(cell, x, y, layers).tall(high.1 - low.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(layer: &Layer) -> Vec<Point> {
        match layer {
            Layer::Line(l) => l.x.iter().copied().zip(l.y.iter().copied()).collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn a_spring_and_a_damper_run_from_one_end_of_their_way_to_the_other() {
        let way = Way::through([(2.0, 1.0), (20.0, 1.0)]);
        let pen = style::mean(style::INK);
        let coils = points(&spring(&way, pen));
        assert_eq!((coils[0], coils[coils.len() - 1]), ((2.0, 1.0), (20.0, 1.0)));
        assert!(coils.iter().all(|(_, y)| (y - 1.0).abs() <= COIL_MM.1));
        let parts = damper(&way, pen);
        assert_eq!((points(&parts[0])[0], points(&parts[3])[2]), ((2.0, 1.0), (20.0, 1.0)));
    }

    #[test]
    fn an_arrow_s_tip_is_the_end_of_its_way() {
        let way = Way::through([(0.0, 0.0), (9.0, 0.0), (9.0, 5.0)]);
        let parts = arrow(&way, style::mean(style::INK));
        let head = points(&parts[1]);
        assert_eq!(head[1], (9.0, 5.0));
        assert!(head[0].0 < 9.0 && head[2].0 > 9.0 && head[0].1 < 5.0);
    }

    #[test]
    fn a_ground_is_hatched_on_its_right() {
        let hatches = ground(&Way::through([(0.0, 0.0), (0.0, 10.0)]), style::mean(style::INK));
        assert!(hatches.len() > 5);
        assert!(hatches.iter().flat_map(points).all(|(x, _)| x >= 0.0));
    }
}
