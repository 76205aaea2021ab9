//! Figures 26 and 27: what an environment renders, drawn to the angles of the study: device,
//! spring, wall.

use crate::FigureKind;
use crate::words::{Words, plain};
use serde::Serialize;
use std::f64::consts::TAU;
use zwidth_draw::style::{self, Dash, Stroke};
use zwidth_draw::{
    Axis, Cell, Figure, Layer, LegendPlace, Line, ONE_COLUMN_MM, Panel, Points, Text, TextPlace,
};
use zwidth_study::{Coordinate, Environment, Spring, Study};

/// The figure [`environment`].
pub const ENVIRONMENT: FigureKind = FigureKind {
    stem: "environment",
    shows: "device, spring and wall at the study's own angles",
    drawn_from: "trial",
};

/// Height of the drawing, mm.
const PANEL_MM: f64 = 50.0;
/// What the drawing covers, in lengths of the lever: to either side of the axis, below it and above
/// it.
const REACH: (f64, f64, f64) = (1.35, -0.3, 1.36);
// Distances from the axis, in lengths of the lever.
/// The arc of the work space: just beyond the lever's tip.
const ARC: f64 = 1.12;
/// The numbers at the arc.
const NUMBERS: f64 = 1.2;
/// The spring.
const SPRING: f64 = 0.68;
/// The arrow of θ.
const THETA: f64 = 0.42;
/// The arrow of the device's torque.
const TORQUE: f64 = 0.22;
/// Both ends of what the spring stands against.
const STOP: (f64, f64) = (0.56, 0.8);
/// Both ends of the wall: the lever's tip runs into it, the spring does not.
const WALL: (f64, f64) = (0.8, ARC);
/// Coils of the spring.
const COILS: usize = 9;
/// How far a coil stands out to either side.
const COIL: f64 = 0.07;
/// Hatches of a wall.
const HATCHES: usize = 7;
/// Length of a hatch.
const HATCH: f64 = 0.09;
/// The lever is drawn at this share of its work space: the spring is seen at length, and a wall
/// ahead.
const LEVER_AT: f64 = 0.33;
/// Pieces of an arc over a whole turn.
const PIECES: f64 = 360.0;

type Point = (f64, f64);

/// An environment, and the device that renders it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Placement {
    /// What is rendered.
    pub environment: Environment,
    /// What the coordinate is called.
    pub coordinate: Coordinate,
    /// Lever length L, m.
    pub lever_m: Option<f64>,
    /// Work space, lower end, rad.
    pub theta_min_rad: Option<f64>,
    /// Work space, upper end, rad.
    pub theta_max_rad: Option<f64>,
}

impl Placement {
    /// An environment of a study.
    pub fn of(study: &Study, environment: &Environment) -> Self {
        let device = &study.device;
        Self {
            environment: environment.clone(),
            coordinate: study.coordinate,
            lever_m: device.lever_m,
            theta_min_rad: device.theta_min_rad,
            theta_max_rad: device.theta_max_rad,
        }
    }
}

/// The device and what it renders, as far as it is a lever between stops on a spring; none
/// otherwise.
///
/// Angles are true; θ = 0 stands upright, and θ > 0 compresses. Lengths are in lengths of the
/// lever. What the drawing shows is commanded, not measured.
pub fn environment(placement: &Placement) -> Option<Figure> {
    let Placement { coordinate, environment, .. } = placement;
    let (low, high) = (placement.theta_min_rad?, placement.theta_max_rad?);
    let spring = environment.scene.spring().filter(|_| *coordinate == Coordinate::Rotational)?;
    let wall = environment.scene.wall_rad();
    let words = Words::new(*coordinate);
    let lever = low + LEVER_AT * (high - low);
    let mut layers = work_space(words, low, high);
    layers.extend(rendered_spring(spring, lever, high));
    layers.extend(wall.iter().flat_map(|at| rendered_wall(words, *at)));
    layers.extend(device(lever));
    let panel = Panel::new(
        Cell::at(0, 0),
        Axis::bare(-REACH.0, REACH.0),
        Axis::bare(REACH.1, REACH.2),
        layers,
    );
    Some(Figure {
        title: Some(plain(&environment.label)),
        description: format!(
            "Environment {}: the lever between its stops, the virtual spring{}.",
            environment.label,
            if wall.is_some() { " and the virtual wall" } else { "" }
        ),
        width_mm: ONE_COLUMN_MM,
        panels: vec![Panel { height_mm: Some(PANEL_MM), ..panel }],
        legend: LegendPlace::Hidden,
        footnotes: footnotes(placement.lever_m, words, spring, wall, high),
        ..Figure::default()
    })
}

/// What is drawn, in numbers.
fn footnotes(
    lever_m: Option<f64>,
    words: Words,
    spring: Spring,
    wall: Option<f64>,
    high: f64,
) -> Vec<String> {
    let force = |theta_rad: f64| spring.stiffness_n_per_rad * (theta_rad - spring.rest_rad);
    let lever = lever_m.map(|l| format!("Lever {} mm. ", number(l * 1e3)));
    let mut notes = vec![format!(
        "{}Spring: {} N/rad, at rest at {}, {} N at {}.",
        lever.unwrap_or_default(),
        number(spring.stiffness_n_per_rad),
        signed(words, spring.rest_rad),
        number(force(high)),
        signed(words, high),
    )];
    notes.extend(wall.map(|at| {
        format!(
            "Wall: from {} on (where the spring has {} N) each actuator in use gets its full voltage.",
            signed(words, at),
            number(force(at))
        )
    }));
    notes
}

/// To two decimals, without idle zeros.
fn number(value: f64) -> String {
    format!("{}", (value * 100.0).round() / 100.0).replace('-', "−")
}

fn signed(words: Words, theta_rad: f64) -> String {
    words.place(theta_rad).replace('-', "−")
}

/// The point at `distance` from the axis and `theta` from upright.
fn at(distance: f64, theta: f64) -> Point {
    (distance * libm::sin(theta), distance * libm::cos(theta))
}

fn line(points: impl IntoIterator<Item = Point>, stroke: Stroke) -> Layer {
    let (x, y) = points.into_iter().unzip();
    Layer::Line(Line { x, y, stroke, ..Line::default() })
}

fn text(words: impl Into<String>, (x, y): Point) -> Layer {
    Layer::Text(Text { lines: vec![words.into()], place: TextPlace::Over(x, y) })
}

/// A number centred on its place outside of the arc.
fn number_at(words: String, theta: f64) -> Layer {
    /// A line of text stands over its place; this far below, its middle lies there.
    const HALF_LINE: f64 = 0.06;
    let (x, y) = at(NUMBERS, theta);
    text(words, (x, y - HALF_LINE))
}

fn arc(distance: f64, from: f64, to: f64) -> impl Iterator<Item = Point> {
    let pieces = ((to - from).abs() / TAU * PIECES).ceil().max(1.0) as usize;
    (0..=pieces).map(move |i| at(distance, from + (to - from) * i as f64 / pieces as f64))
}

/// An arc that ends in an arrow's head.
fn arrow(distance: f64, from: f64, to: f64, stroke: Stroke) -> [Layer; 2] {
    /// Length of the head and half its width.
    const HEAD: (f64, f64) = (0.085, 0.035);
    let back = to - (to - from).signum() * HEAD.0 / distance;
    let head = [at(distance - HEAD.1, back), at(distance, to), at(distance + HEAD.1, back)];
    [line(arc(distance, from, to), stroke), line(head, stroke)]
}

/// The arc between the stops, with numbers at its ends and upright.
fn work_space(words: Words, low: f64, high: f64) -> Vec<Layer> {
    let thin = style::single(style::GREY);
    let mut layers = vec![line(arc(ARC, low, high), thin)];
    let upright = (low < 0.0 && high > 0.0).then_some(0.0);
    for theta in [low, high].into_iter().chain(upright) {
        layers.push(line([at(ARC - 0.03, theta), at(ARC + 0.03, theta)], thin));
        layers.push(number_at(signed(words, theta), theta));
    }
    layers.extend(upright.map(|theta| line([at(0.0, theta), at(ARC, theta)], style::reference())));
    layers
}

/// A line from the axis outwards with hatches behind it.
fn ground(theta: f64, (from, to): (f64, f64), stroke: Stroke) -> Vec<Layer> {
    let fine = Stroke { width_pt: 0.6, ..stroke };
    let hatch = |i: usize| {
        let distance = from + (to - from) * (i as f64 + 0.5) / HATCHES as f64;
        line([at(distance, theta), at(distance + HATCH / 2.0, theta + HATCH / distance)], fine)
    };
    let mut layers: Vec<Layer> = (0..HATCHES).map(hatch).collect();
    layers.push(line([at(from, theta), at(to, theta)], stroke));
    layers
}

/// The spring between the lever and the end of the work space, and where the lever stands when it
/// rests.
fn rendered_spring(spring: Spring, lever: f64, high: f64) -> Vec<Layer> {
    let pen = style::mean(style::TISSUE);
    let span = high - lever;
    let turn = |i: usize| {
        let side = match i {
            0 => 0.0,
            i if i == 2 * COILS => 0.0, // it begins and ends on its own line
            i if i % 2 == 0 => -COIL,
            _ => COIL,
        };
        // The first and the last tenth are straight.
        at(SPRING + side, lever + span * (0.1 + 0.8 * i as f64 / (2 * COILS) as f64))
    };
    let zigzag = (0..=2 * COILS).map(turn);
    let ends = [at(SPRING, lever), at(SPRING, high)];
    let mut layers = vec![
        line([ends[0]].into_iter().chain(zigzag).chain([ends[1]]), pen),
        text(format!("*K* = {} N/rad", number(spring.stiffness_n_per_rad)), at(0.7, high + 0.48)),
        line([(0.0, 0.0), at(1.0, spring.rest_rad)], style::reference().dashed(Dash::Dotted)),
        text("rest", at(0.66, spring.rest_rad - 0.26)),
    ];
    layers.extend(ground(high, STOP, style::mean(style::INK)));
    layers
}

fn rendered_wall(words: Words, theta: f64) -> Vec<Layer> {
    let pen = Stroke { width_pt: 1.8, ..style::mean(style::MARK) };
    let mut layers = ground(theta, WALL, pen);
    layers.push(text(format!("wall {}", signed(words, theta)), at(NUMBERS + 0.04, theta)));
    layers
}

/// The lever on its axis, the user's push, the device's torque, and the angle.
fn device(lever: f64) -> Vec<Layer> {
    let bar = Stroke { width_pt: 3.2, ..style::mean(style::INK) };
    let force = style::mean(style::INK);
    let disc = |colour, diameter_pt| {
        Layer::Points(Points {
            x: vec![0.0],
            y: vec![0.0],
            colour,
            diameter_pt,
            ..Points::default()
        })
    };
    let mut layers = vec![line([(0.0, 0.0), at(1.0, lever)], bar)];
    layers.extend(arrow(0.93, lever - 0.42, lever - 0.04, force));
    layers.push(text("*F*_{ex}", at(0.97, lever - 0.4)));
    layers.extend(arrow(TORQUE, lever + 1.1, lever - 1.1, style::mean(style::MOTOR)));
    layers.push(text("*T*_{O}", at(TORQUE + 0.1, lever + 1.55)));
    if lever.abs() > 0.05 {
        layers.extend(arrow(THETA, 0.0, lever - 0.05 * lever.signum(), style::single(style::GREY)));
        layers.push(text("*θ*", at(THETA + 0.02, lever / 2.0)));
    }
    layers.extend([disc(style::INK, 9.0), disc(style::PAPER, 4.0)]);
    layers.push(text("motor and brake", (0.0, -0.27)));
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Scene;

    fn study() -> Study {
        zwidth_testing::study()
    }

    fn texts(figure: &Figure) -> Vec<String> {
        let words =
            |layer: &Layer| if let Layer::Text(t) = layer { Some(t.lines.join(" ")) } else { None };
        figure.panels[0].layers.iter().filter_map(words).collect()
    }

    /// Angles from upright of the ends of every line that begins on the axis.
    fn radii_deg(figure: &Figure) -> Vec<f64> {
        let end = |layer: &Layer| match layer {
            Layer::Line(l) if l.x[0] == 0.0 && l.y[0] == 0.0 => {
                Some(libm::atan2(*l.x.last()?, *l.y.last()?).to_degrees())
            }
            _ => None,
        };
        figure.panels[0].layers.iter().filter_map(end).collect()
    }

    #[test]
    fn the_drawing_stands_at_the_study_s_own_angles() {
        let mut study = study();
        let figure = environment(&Placement::of(&study, &study.environments[1])).unwrap();
        let labels = texts(&figure);
        for label in ["−45°", "45°", "0°", "wall 26.6°", "*K* = 4 N/rad"] {
            assert!(labels.iter().any(|l| l == label), "{label} is not in {labels:?}");
        }
        study.environments[1].scene =
            Scene::Spring(Spring { stiffness_n_per_rad: 3.0, rest_rad: -0.5 });
        let figure = environment(&Placement::of(&study, &study.environments[1])).unwrap();
        assert!(!texts(&figure).iter().any(|l| l.starts_with("wall")));
        assert!(radii_deg(&figure).iter().any(|deg| (deg + 0.5_f64.to_degrees()).abs() < 1e-9));
    }

    #[test]
    fn the_footnotes_say_what_the_spring_has_at_the_wall() {
        let study = study();
        let figure = environment(&Placement::of(&study, &study.environments[1])).unwrap();
        // 4 N/rad from −45° on: 4 · 71.6° = 5.00 N at the wall, 4 · 90° = 6.28 N at the upper stop.
        assert!(
            figure.footnotes[0].contains("at rest at −45°, 6.28 N at 45°"),
            "{:?}",
            figure.footnotes
        );
        assert!(figure.footnotes[1].contains("from 26.6° on (where the spring has 5 N)"));
    }

    #[test]
    fn a_slide_free_motion_and_a_device_without_stops_are_not_drawn() {
        let drawn = |change: fn(&mut Study)| {
            let mut study = study();
            change(&mut study);
            environment(&Placement::of(&study, &study.environments[0])).is_some()
        };
        assert!(drawn(|_| ()));
        assert!(!drawn(|s| s.coordinate = Coordinate::Linear { lever_m: 1.0 }));
        assert!(!drawn(|s| s.environments[0].scene = Scene::Free));
        assert!(!drawn(|s| s.device.theta_max_rad = None));
    }
}
