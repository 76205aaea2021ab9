//! Draws one of every kind of figure, from made-up numbers, into the folder named on the command
//! line.
//!
//! `cargo run -p zwidth-draw --example gallery -- target/gallery`

use std::error::Error;
use std::f64::consts::TAU;
use std::path::PathBuf;

use zwidth_draw::{
    Axis, Band, Cell, DEFAULT_DPI, Direction, Figure, Intervals, Layer, Likert, LikertScale, Line,
    ONE_COLUMN_MM, Panel, Points, Range, Reference, Text, TextPlace, Ticks, dodge, draw, style,
};

const MODES: [&str; 3] = ["active", "passive", "hybrid"];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target/gallery".into()));
    std::fs::create_dir_all(&folder)?;
    for (name, figure) in figures() {
        let drawing = draw(&figure)?;
        std::fs::write(folder.join(format!("{name}.svg")), drawing.svg()?)?;
        std::fs::write(folder.join(format!("{name}.png")), drawing.png(DEFAULT_DPI)?)?;
        std::fs::write(folder.join(format!("{name}.pdf")), drawing.pdf()?)?;
    }
    Ok(())
}

/// Every figure of the gallery with its name.
pub fn figures() -> Vec<(&'static str, Figure)> {
    vec![
        ("four-panels", four_panels()),
        ("one-mode", one_mode()),
        ("characteristic", characteristic()),
        ("likert", likert()),
        ("intervals", intervals()),
        ("note", note()),
        ("powers", powers()),
        ("places", places()),
    ]
}

/// Reproducible noise, −1 … 1.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
    }
}

/// The quantities of one push against a spring with a wall at 26.6°: time, s, angle, °, force, N, and
/// velocity, °/s.
type Push = [Vec<f64>; 4];
const QUANTITIES: [&str; 4] = ["t", "θ", "F", "θ̇"];

const WALL_DEG: f64 = 26.6;

fn push(mode: usize, repeat: u32) -> Push {
    let mut noise = Noise(repeat * 97 + mode as u32 * 13 + 5);
    let reach = [36.0, 27.4, 27.0][mode] + 0.8 * noise.next();
    let drop = [0.0, 5.0, 2.2][mode];
    let period = 2.6 + 0.15 * noise.next();
    let lag = 0.05 * noise.next();
    let phase = TAU * noise.next();
    let depth = [0.05, 0.12, 0.03][mode];
    let mut run = Push::default();
    for i in 0..3000 {
        let t = f64::from(i) / 1000.0;
        let way = (TAU * (t - lag) / period / 2.0).sin().max(0.0);
        let turning = (TAU * (t - lag) / period / 2.0).cos() * TAU / period / 2.0;
        let speed = if way > 0.0 { turning } else { 0.0 };
        let theta = reach * way;
        let wall = if theta > WALL_DEG { (theta - WALL_DEG) * [0.2, 4.0, 4.2][mode] } else { 0.0 };
        let spring = 0.14 * theta - if speed < 0.0 { drop * way.min(0.4) } else { 0.0 };
        let force = spring + wall + depth * (40.0 * t + phase).sin() + 0.04 * noise.next();
        let velocity = reach * speed + 1.5 * noise.next();
        for (values, value) in run.iter_mut().zip([t, theta, force.max(0.0), velocity]) {
            values.push(value);
        }
    }
    run
}

fn quantity<'a>(run: &'a Push, name: &str) -> &'a [f64] {
    &run[QUANTITIES.iter().position(|own| *own == name).unwrap_or(3)]
}

/// Mean and standard deviation over the repeats, sample by sample.
fn mean_sd(runs: &[Push], name: &str) -> Vec<(f64, f64)> {
    (0..runs[0][0].len())
        .map(|i| {
            let values: Vec<f64> = runs.iter().map(|run| quantity(run, name)[i]).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let sum2 = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
            (mean, (sum2 / (values.len() - 1) as f64).sqrt())
        })
        .collect()
}

fn mode_layers(x: &str, y: &str) -> Vec<Layer> {
    let mut layers = Vec::new();
    let all: Vec<Vec<Push>> =
        (0..3).map(|mode| (0..6).map(|repeat| push(mode, repeat)).collect()).collect();
    for (mode, runs) in all.iter().enumerate() {
        let colour = style::mode_colour(mode);
        layers.extend(runs.iter().map(|run| {
            let x = quantity(run, x).to_vec();
            let y = quantity(run, y).to_vec();
            Layer::Line(Line { x, y, stroke: style::faint(colour), ..Line::default() })
        }));
    }
    for (mode, runs) in all.iter().enumerate() {
        let colour = style::mode_colour(mode);
        let name = Some(MODES[mode].to_owned());
        let along = mean_sd(runs, x);
        let across = mean_sd(runs, y);
        let x: Vec<f64> = along.iter().map(|(mean, _)| *mean).collect();
        let y: Vec<f64> = across.iter().map(|(mean, _)| *mean).collect();
        if along[1].1 == 0.0 {
            let half = |sd: &f64| 2.57 * sd / 2.45;
            let low = across.iter().map(|(mean, sd)| mean - half(sd)).collect();
            let high = across.iter().map(|(mean, sd)| mean + half(sd)).collect();
            layers.push(Layer::Band(Band { x: x.clone(), low, high, colour, name: name.clone() }));
        }
        let dotted = mean_sd(runs, "θ").iter().map(|(theta, _)| *theta > WALL_DEG).collect();
        layers.push(Layer::Line(Line { x, y, dotted, stroke: style::mean(colour), name }));
    }
    layers
}

fn wall(direction: Direction, label: Option<&str>) -> Layer {
    let line = Reference::new(direction, WALL_DEG, style::reference());
    Layer::Reference(Reference { label: label.map(str::to_owned), ..line })
}

/// Time, shared by all panels of a figure.
fn time() -> Axis {
    Axis::new("*t*", "s").ranged(Range::Tight).linked("t")
}

fn four_panels() -> Figure {
    let theta = Axis::new("*θ*", "°").linked("θ");
    let force = Axis::new("*F*_{ex}", "N").linked("F");
    let mut angle = mode_layers("t", "θ");
    angle.push(wall(Direction::Horizontal, None));
    let mut loops = mode_layers("θ", "F");
    loops.push(wall(Direction::Vertical, Some("wall 26.6°")));
    Figure {
        description: "Angle, force and velocity against time, and force against angle, mean of six per mode".into(),
        panels: vec![
            Panel::new(Cell::at(0, 0), time(), theta.clone(), angle).titled("**a**"),
            Panel::new(Cell::at(1, 0), time(), force.clone(), mode_layers("t", "F")).titled("**b**"),
            Panel::new(Cell::at(2, 0), time(), Axis::new("*θ̇*", "°/s"), mode_layers("t", "θ̇")).titled("**c**"),
            Panel::new(Cell::at(0, 1).spanning(3, 1), theta, force, loops).titled("**d**"),
        ],
        footnotes: vec![
            "Mean of *n* = 6 repeats with pointwise 95 % band; every repeat faint behind. Dotted: past the wall. \
             Within this participant."
                .into(),
        ],
        mark: Some("SYNTHETIC".into()),
        provenance: Some("zwidth gallery".into()),
        ..Figure::default()
    }
}

fn one_mode() -> Figure {
    let mut force = repeat_layers("θ", "F");
    force.push(Layer::Line(Line {
        x: vec![0.0, WALL_DEG, WALL_DEG, 28.0],
        y: vec![0.0, 0.14 * WALL_DEG, 10.0, 10.0],
        stroke: style::commanded(),
        name: Some("commanded".into()),
        ..Line::default()
    }));
    Figure {
        title: Some("Hybrid, spring + wall: all repeats".into()),
        width_mm: ONE_COLUMN_MM,
        panels: vec![
            Panel::new(Cell::at(0, 0), Axis::new("*θ*", "°"), Axis::new("*F*", "N"), force),
            Panel::new(Cell::at(1, 0), time(), Axis::new("*θ*", "°"), repeat_layers("t", "θ")),
            Panel::new(Cell::at(2, 0), time(), Axis::new("*θ̇*", "°/s"), repeat_layers("t", "θ̇")),
        ],
        mark: Some("SYNTHETIC".into()),
        ..Figure::default()
    }
}

/// Six repeats of the hybrid mode, in shades of its colour.
fn repeat_layers(x: &str, y: &str) -> Vec<Layer> {
    let mut layers = Vec::new();
    for i in 0..6 {
        let run = push(2, i);
        let x = quantity(&run, x).to_vec();
        let y = quantity(&run, y).to_vec();
        let stroke = style::single(style::repeat_colour(style::mode_colour(2), i as usize, 6));
        let name = Some(format!("repeat {}", i + 1));
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
    }
    layers
}

fn characteristic() -> Figure {
    let mut noise = Noise(3);
    let voltage: Vec<f64> = (0..1600).map(|i| 16.0 * f64::from(i % 320) / 319.0).collect();
    let force = voltage.iter().map(|v| (0.26 * v - 0.05).max(0.0) + 0.12 * noise.next()).collect();
    let line: Vec<f64> = (0..=160).map(|i| f64::from(i) / 10.0).collect();
    let fit = |off: f64| -> Vec<f64> { line.iter().map(|v| 0.26 * v - 0.05 + off).collect() };
    let colour = style::mode_colour(0);
    let layers = vec![
        Layer::Points(Points {
            x: voltage,
            y: force,
            colour,
            opacity: 0.35,
            diameter_pt: 1.6,
            name: Some("measured, 5 sweeps".into()),
        }),
        Layer::Band(Band {
            x: line.clone(),
            low: fit(-0.14),
            high: fit(0.14),
            colour: style::INK,
            name: Some("95 % prediction".into()),
        }),
        Layer::Line(Line {
            x: line.clone(),
            y: fit(0.0),
            name: Some("first-order fit".into()),
            ..Line::default()
        }),
        Layer::Text(Text {
            lines: vec!["*F* = 0.260 *U* − 0.05".into(), "*R*² = 0.998".into()],
            place: TextPlace::EmptiestCorner,
        }),
    ];
    let x = Axis::new("*U*", "V").ranged(Range::Fixed(0.0, 16.0));
    let panel = Panel::new(Cell::at(0, 0), x, Axis::new("*F*", "N"), layers);
    Figure { width_mm: ONE_COLUMN_MM, panels: vec![panel], ..Figure::default() }
}

fn likert() -> Figure {
    let counts = [
        ("**a**  Spring", [[0, 1, 2, 5, 4], [5, 4, 2, 1, 0], [0, 0, 1, 6, 5]]),
        ("**b**  Spring + wall", [[7, 4, 0, 1, 0], [1, 3, 4, 3, 1], [0, 1, 1, 4, 6]]),
    ];
    let mut panels = Vec::new();
    for (column, (title, rows)) in counts.into_iter().enumerate() {
        let answers = ["strongly disagree", "disagree", "neutral", "agree", "strongly agree"];
        let layer = Layer::Likert(Likert {
            answers: answers.map(String::from).to_vec(),
            rows: rows.map(|row| vec![row.to_vec()]).to_vec(),
            scale: LikertScale::Counts,
        });
        let mut x = Axis::new("← negative     answers     positive →", "").linked("answers");
        x.ticks = Ticks::Magnitudes;
        let modes = Axis::categories(MODES).linked("modes");
        panels.push(Panel::new(Cell::at(0, column), x, modes, vec![layer]).titled(title));
    }
    Figure {
        description: "Answers to two statements by mode".into(),
        panels,
        mark: Some("SYNTHETIC".into()),
        ..Figure::default()
    }
}

fn intervals() -> Figure {
    let sessions = ["session 9", "session 10", "session 11", "session 12"];
    let parameters = [
        ("offset *c*", "N·m", 0.004, 1),
        ("inertia *I*", "kg·m²", 1.7e-4, 2),
        ("damping *b*", "N·m·s/rad", 0.0021, 3),
    ];
    let mut panels = Vec::new();
    for (column, (label, unit, size, seed)) in parameters.into_iter().enumerate() {
        let mut noise = Noise(seed);
        let zero = Reference::new(Direction::Horizontal, 0.0, style::zero());
        let mut layers = vec![Layer::Reference(zero)];
        for (mode, name) in ["none", "feedforward", "closed loop"].into_iter().enumerate() {
            let at: Vec<f64> = (0..4).map(|i| f64::from(i) + dodge(mode, 3)).collect();
            let estimate: Vec<f64> =
                at.iter().map(|_| size * (1.0 - 0.4 * mode as f64 + 0.15 * noise.next())).collect();
            let half: Vec<f64> = at.iter().map(|_| size * (0.12 + 0.08 * noise.next())).collect();
            let low = estimate.iter().zip(&half).map(|(e, h)| e - h).collect();
            let high = estimate.iter().zip(&half).map(|(e, h)| e + h).collect();
            layers.push(Layer::Intervals(Intervals {
                colour: style::mode_colour(mode),
                marker: style::marker(mode),
                name: Some(name.to_owned()),
                ..Intervals::new(Direction::Vertical, at, [estimate, low, high])
            }));
        }
        let (x, y) = (Axis::categories(sessions), Axis::new(label, unit));
        panels.push(Panel::new(Cell::at(0, column), x, y, layers));
    }
    Figure {
        panels,
        footnotes: vec![
            "Plane fit torque = *c* + *I*·acceleration + *b*·velocity, 95 % block-bootstrap intervals."
                .into(),
        ],
        ..Figure::default()
    }
}

/// Errors that fall with the first and the fourth power of the step, on axes of logarithms.
fn powers() -> Figure {
    let steps: Vec<f64> = (0..9).map(|i| -1.0 - 0.25 * f64::from(i)).collect();
    let mut layers = Vec::new();
    for (i, (name, order)) in [("Euler", 1.0), ("Runge–Kutta", 4.0)].into_iter().enumerate() {
        let x = steps.clone();
        let y = steps.iter().map(|h| order * h - 1.0).collect::<Vec<f64>>();
        let colour = style::mode_colour(i);
        let points = Points { x: x.clone(), y: y.clone(), colour, ..Points::default() };
        layers.push(Layer::Points(points));
        let stroke = style::single(colour);
        let name = Some(name.to_owned());
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
    }
    let [x, y] = [("step *h*", "s"), ("largest error", "rad")]
        .map(|(label, unit)| Axis { ticks: Ticks::Powers, ..Axis::new(label, unit) });
    let panel = Panel::new(Cell::at(0, 0), x, y, layers);
    Figure { width_mm: ONE_COLUMN_MM, panels: vec![panel], ..Figure::default() }
}

/// Words at every kind of place, in a drawing of things.
fn places() -> Figure {
    let text = |lines: &[&str], place| {
        let lines = lines.iter().map(|line| (*line).to_owned()).collect();
        Layer::Text(Text { lines, place })
    };
    let line = |points: [(f64, f64); 2]| {
        let (x, y) = points.into_iter().unzip();
        Layer::Line(Line { x, y, ..Line::default() })
    };
    let mut layers = vec![
        line([(30.0, 10.0), (50.0, 10.0)]),
        text(&["over *x*"], TextPlace::Over(40.0, 10.0)),
        text(&["left of", "*x*_{1}"], TextPlace::LeftOf(30.0, 10.0)),
        text(&["right of", "*x*_{2}"], TextPlace::RightOf(50.0, 10.0)),
        text(&["amid"], TextPlace::Amid(40.0, 5.0)),
    ];
    let boxes = [
        (2.0, &["wide enough"][..]),
        (29.0, &["words that wrap in the box that they stand in"]),
        (
            56.0,
            &[
                "cut",
                "words of which there are more than any box of this size has room for, so \
                          that their end is not to be seen, and no letter of theirs stands outside",
            ],
        ),
    ];
    for (left, lines) in boxes {
        let (right, low, high) = (left + 24.0, 20.0, 32.0);
        let corners = [(left, low), (right, low), (right, high), (left, high), (left, low)];
        layers.extend((0..4).map(|i| line([corners[i], corners[i + 1]])));
        layers.push(text(lines, TextPlace::Within((left, low), (right, high))));
    }
    let x = Axis::bare(0.0, 82.0);
    let y = Axis::bare(0.0, 34.0);
    let panel = Panel::new(Cell::at(0, 0), x, y, layers).tall(34.0);
    Figure { width_mm: ONE_COLUMN_MM, panels: vec![panel], ..Figure::default() }
}

fn note() -> Figure {
    let force = Axis::new("torque", "N·m");
    let mut panel = Panel::new(Cell::at(1, 0), time(), force, mode_layers("t", "F"));
    panel.layers.truncate(6);
    let words = "no angle was recorded, and its integral drifts by a radian";
    let noted = Panel::with_note(Cell::at(0, 0), time(), Axis::new("*θ*", "°"), words);
    Figure { width_mm: ONE_COLUMN_MM, panels: vec![noted, panel], ..Figure::default() }
}
