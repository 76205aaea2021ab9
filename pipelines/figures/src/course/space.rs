//! Paths in space, in three planes of one scale; and how hard was pushed, whatever the direction.

use crate::FigureKind;
use crate::course::data::{EnvironmentData, ModeData, Repeat};
use crate::words::{keep_together, mark, plain, time_axis};
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Layer, LegendPlace, Line, Panel, Points, Range, Reference, Text,
    TextPlace,
};
use zwidth_numerics::series::ends;
use zwidth_store::Signal;
use zwidth_study::{Axes, in_a_sentence};

/// The figure [`space`].
pub const SPACE: FigureKind =
    FigureKind::new("space", "paths in space, in three planes of one scale", "trial");

/// The figure [`force_magnitude`].
pub const FORCE_MAGNITUDE: FigureKind = FigureKind::new(
    "force_magnitude",
    "magnitude of the force in all axes against time, with that at rest",
    "trial",
);

/// The signals that both show besides time.
pub const SPACE_SIGNALS: [Signal; 6] =
    [Signal::X, Signal::Y, Signal::Z, Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// Positions, with their names on axes.
const POSITIONS: [(Signal, &str); 3] = [(Signal::X, "*x*"), (Signal::Y, "*y*"), (Signal::Z, "*z*")];
/// The axes of each plane, across and up: y and z stand upright wherever they can.
const PLANES: [[usize; 2]; 3] = [[0, 1], [2, 1], [0, 2]];
/// Height of a plane's panel, mm: about its width.
const PLANE_MM: f64 = 44.0;
/// Height of a panel of the force, mm.
const FORCE_MM: f64 = 34.0;
/// Room around the longest path, as a share of half its extent.
const ROOM: f64 = 0.12;
/// Half of the least extent that is drawn, mm: a device at rest has noise alone.
const LEAST_MM: f64 = 1.0;
/// Diameters of the discs where a path begins and where it ends, pt: the large one is the beginning.
const START_PT: f64 = 6.0;
const END_PT: f64 = 3.4;
/// Length of the arrow of the push, as a share of a panel, and what its corner takes.
const ARROW: f64 = 0.2;
const CORNER: f64 = 0.36;
/// A push that has less than this of its length in a plane is across it.
const ACROSS: f64 = 0.1;
/// Metres in mm.
const MM: f64 = 1e3;

/// Where the panels begin and end along an axis, mm: all as long.
struct Extent {
    middle: [f64; 3],
    half: f64,
}

impl Extent {
    /// That of all positions; `None` if there is none.
    fn of(scene: &EnvironmentData) -> Option<Self> {
        let mut middle = [0.0; 3];
        let mut half = LEAST_MM;
        let mut is_any = false;
        for (k, (signal, _)) in POSITIONS.into_iter().enumerate() {
            let all: Vec<f64> = scene
                .repeats()
                .filter_map(|r| r.signal(signal))
                .flatten()
                .map(|x| MM * x)
                .collect();
            let (low, high) = ends(&all);
            if low <= high {
                is_any = true;
                middle[k] = (low + high) / 2.0;
                half = f64::max(half, (high - low) / 2.0 * (1.0 + ROOM));
            }
        }
        is_any.then_some(Self { middle, half })
    }

    fn axis(&self, k: usize) -> Axis {
        let (low, high) = (self.middle[k] - self.half, self.middle[k] + self.half);
        Axis::new(POSITIONS[k].1, "mm").ranged(Range::OneScale(low, high))
    }
}

/// The paths of all repeats in the planes x–y, z–y and x–z, one unit as long in all of them; modes by
/// colour and dash, start and end marked, and the direction of the push.
pub fn space(scene: &EnvironmentData, axes: &Axes) -> Figure {
    let extent = Extent::of(scene);
    let panels = PLANES.into_iter().enumerate().map(|(column, plane)| {
        let cell = Cell::at(0, column);
        match &extent {
            Some(extent) => plane_panel(scene, axes, extent, plane, cell),
            None => {
                let [x, y] = plane.map(|k| Axis::new(POSITIONS[k].1, "mm"));
                Panel::with_note(cell, x, y, "no position was recorded").tall(PLANE_MM)
            }
        }
    });
    let modes: Vec<String> = scene
        .modes
        .iter()
        .map(|mode| format!("{} {}", mode.repeats.len(), in_a_sentence(mode.label)))
        .collect();
    Figure {
        title: Some(title(scene, "paths")),
        description: format!(
            "{}, environment {}: paths in the planes x–y, z–y and x–z, in mm of one scale ({}). Repeats: {}. The large disc \
             is where a path begins, the small one where it ends, and the arrow the direction of the push.",
            scene.who,
            scene.environment.label,
            axes.frame,
            modes.join(", "),
        ),
        panels: panels.collect(),
        legend: LegendPlace::Below,
        footnotes: vec![plain(&format!(
            "Axes: {}. Positions as recorded; path lengths are taken behind a low-pass of {} Hz.",
            axes.frame, axes.low_pass_hz
        ))],
        mark: mark(scene.sources()),
        ..Figure::default()
    }
}

fn title(scene: &EnvironmentData, what: &str) -> String {
    plain(&format!("{}: {what} ({})", scene.environment.label, keep_together(&scene.who)))
}

/// The pen of a mode: thin, for paths cross themselves.
fn pen(mode: &ModeData) -> Stroke {
    style::single(style::mode_colour(mode.index)).dashed(style::dash(mode.index))
}

fn in_mm(repeat: &Repeat, k: usize) -> Option<Vec<f64>> {
    let values = repeat.signal(POSITIONS[k].0)?;
    Some(values.iter().map(|x| MM * x).collect())
}

fn plane_panel(
    scene: &EnvironmentData,
    axes: &Axes,
    extent: &Extent,
    plane: [usize; 2],
    cell: Cell,
) -> Panel {
    let mut layers = Vec::new();
    let mut begins: [Vec<f64>; 2] = Default::default();
    let mut stops: [Vec<f64>; 2] = Default::default();
    for mode in &scene.modes {
        for repeat in &mode.repeats {
            let [Some(x), Some(y)] = plane.map(|k| in_mm(repeat, k)) else { continue };
            for (values, (first, last)) in
                [&x, &y].into_iter().zip(begins.iter_mut().zip(&mut stops))
            {
                first.extend(values.first());
                last.extend(values.last());
            }
            let name = Some(mode.name());
            layers.push(Layer::Line(Line { x, y, stroke: pen(mode), name, ..Line::default() }));
        }
    }
    let [x, y] = plane.map(|k| extent.axis(k));
    if layers.is_empty() {
        let missing = plane.map(|k| POSITIONS[k].1.replace('*', "")).join(" and ");
        return Panel::with_note(cell, x, y, format!("{missing} were not recorded together"))
            .tall(PLANE_MM);
    }
    let arrow = push_arrow(&layers, axes, extent, plane);
    layers.push(marks(begins, START_PT, "start"));
    layers.push(marks(stops, END_PT, "end"));
    let is_across = arrow.is_empty();
    layers.extend(arrow);
    let panel = Panel::new(cell, x, y, layers).tall(PLANE_MM);
    if is_across { panel.titled("push: across this plane") } else { panel }
}

/// Discs in ink: they stand for all modes.
fn marks([x, y]: [Vec<f64>; 2], diameter_pt: f64, name: &str) -> Layer {
    Layer::Points(Points { x, y, diameter_pt, name: Some(name.to_owned()), ..Points::default() })
}

/// The direction of the push in the emptiest corner of a plane; nothing if it is across it.
fn push_arrow(paths: &[Layer], axes: &Axes, extent: &Extent, plane: [usize; 2]) -> Vec<Layer> {
    let side = 2.0 * extent.half;
    let lows = plane.map(|k| extent.middle[k] - extent.half);
    let [dx, dy] = plane.map(|k| axes.push[k] * ARROW * side);
    if libm::hypot(dx, dy) < ACROSS * ARROW * side {
        return Vec::new();
    }
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let covered = |[right, top]: &[f64; 2]| {
        let lines = paths.iter().filter_map(|layer| match layer {
            Layer::Line(line) => Some(line),
            _ => None,
        });
        let is_in = |value: f64, low: f64, end: f64| {
            let share = (value - low) / side;
            if end > 0.5 { share > 1.0 - CORNER } else { share < CORNER }
        };
        let points = lines.flat_map(|line| line.x.iter().zip(&line.y));
        points.filter(|(x, y)| is_in(**x, lows[0], *right) && is_in(**y, lows[1], *top)).count()
    };
    let [right, top] = corners.into_iter().min_by_key(covered).unwrap_or([0.0, 0.0]);
    let middle = |end: f64, low: f64| low + side * (CORNER / 2.0 + end * (1.0 - CORNER));
    let (cx, cy) = (middle(right, lows[0]), middle(top, lows[1]));
    let (x0, y0) = (cx - dx / 2.0, cy - dy / 2.0);
    let (x1, y1) = (cx + dx / 2.0, cy + dy / 2.0);
    // Two barbs, a quarter as long, at 25° to the shaft.
    let barb = |angle: f64| {
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let scale = 0.25 * ARROW * side / libm::hypot(dx, dy);
        (x1 - scale * (dx * cosine - dy * sine), y1 - scale * (dx * sine + dy * cosine))
    };
    let [left, other] = [25_f64, -25.0].map(|degrees| barb(degrees.to_radians()));
    let stroke = style::mean(style::INK);
    let shaft = Line { x: vec![x0, x1], y: vec![y0, y1], stroke, ..Line::default() };
    let head = Line {
        x: vec![left.0, x1, other.0],
        y: vec![left.1, y1, other.1],
        stroke,
        ..Line::default()
    };
    // Beside the shaft: over a flat one, to the side of a steep one that faces the panel's middle.
    let place = match (dx.abs() > dy.abs(), right > 0.5) {
        (true, _) => TextPlace::Over(cx, y0.max(y1) + 0.02 * side),
        (false, true) => TextPlace::LeftOf(cx - 0.03 * side, cy),
        (false, false) => TextPlace::RightOf(cx + 0.03 * side, cy),
    };
    let word = Text { lines: vec!["push".to_owned()], place };
    vec![Layer::Line(shaft), Layer::Line(head), Layer::Text(word)]
}

/// |F| of every repeat against time, a panel for each mode, with what it is at rest: `rest_n` by the
/// trial's number, as metrics have it.
pub fn force_magnitude(scene: &EnvironmentData, rest_n: &BTreeMap<u32, f64>) -> Figure {
    let n = scene.modes.len();
    let panels = scene.modes.iter().enumerate().map(|(row, mode)| {
        let label = if row + 1 == n { "time" } else { "" };
        force_panel(mode, rest_n, Cell::at(row, 0), time_axis(label))
    });
    Figure {
        title: Some(title(scene, "magnitude of the force")),
        description: format!(
            "{}, environment {}: magnitude of the force in all recorded axes against time, a panel for \
             each mode, every repeat; the dashed line is its mean at rest, before and after the movement in space.",
            scene.who, scene.environment.label,
        ),
        panels: panels.collect(),
        legend: LegendPlace::Below,
        footnotes: vec![plain(
            "|F| is never below 0, so noise alone has a mean above it: what |F| is at rest (force_magnitude_rest_n) stands beside it.",
        )],
        mark: mark(scene.sources()),
        ..Figure::default()
    }
}

fn force_panel(mode: &ModeData, rest_n: &BTreeMap<u32, f64>, cell: Cell, time: Axis) -> Panel {
    let colour = style::mode_colour(mode.index);
    let n = mode.repeats.len();
    let y = Axis::new("|*F*|", "N").linked("force magnitude");
    let mut layers = Vec::new();
    for (i, repeat) in mode.repeats.iter().enumerate() {
        let Some(y) = magnitude(repeat) else { continue };
        let x = repeat.trial.samples.get(Signal::Time).unwrap_or_default().to_vec();
        let stroke = style::single(style::repeat_colour(colour, i, n)).dashed(style::dash(i % 2));
        layers.push(Layer::Line(Line { x, y, stroke, ..Line::default() }));
    }
    let title = mode.name();
    if layers.is_empty() {
        let note = "no force was recorded in two axes or more";
        return Panel::with_note(cell, time, y, note).titled(title).tall(FORCE_MM);
    }
    let rest: Vec<f64> =
        mode.repeats.iter().filter_map(|r| rest_n.get(&r.trial.meta.trial).copied()).collect();
    if !rest.is_empty() {
        let mean_n = rest.iter().sum::<f64>() / rest.len() as f64;
        let line = Reference::new(Direction::Horizontal, mean_n, style::reference());
        let name = Some("mean at rest".to_owned());
        layers.push(Layer::Reference(Reference {
            name,
            label: Some(format!("{mean_n:.2} N")),
            ..line
        }));
    }
    // The axis begins at no force.
    let y = y.ranged(Range::Holding(0.0, 0.0));
    Panel::new(cell, time, y, layers).titled(title).tall(FORCE_MM)
}

/// |F| in the axes that were recorded, two at least.
fn magnitude(repeat: &Repeat) -> Option<Vec<f64>> {
    let forces = [Signal::ForceX, Signal::ForceY, Signal::ForceZ];
    let forces: Vec<&[f64]> =
        forces.into_iter().filter_map(|signal| repeat.signal(signal)).collect();
    let (first, others) = forces.split_first().filter(|(_, others)| !others.is_empty())?;
    let mut magnitude: Vec<f64> = first.iter().map(|f| f.abs()).collect();
    for force in others {
        for (magnitude, f) in magnitude.iter_mut().zip(*force) {
            *magnitude = libm::hypot(*magnitude, *f);
        }
    }
    Some(magnitude)
}
