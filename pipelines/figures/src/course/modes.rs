//! Figures 28 and 29: position, force and velocity against time, force against position; the mean
//! of each mode's repeats with its 95 % band, with every repeat faint behind it; dotted past the
//! wall. If a mode stays near the wall, a panel shows its course there.

use crate::FigureKind;
use crate::course::data::{AT_THE_ANGLE, EnvironmentData, ModeData, aligned};
use crate::course::panels::{
    axis, mean_loop, mean_over_time, recorded_word, repeat_loop, repeat_over_time, wall_line,
};
use crate::extent::{at_wall, shared, shared_time};
use crate::words::{keep_together, mark, plain, time_axis};
use zwidth_draw::style::{self, Dash, Stroke};
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Panel, Range};
use zwidth_store::Signal;
use zwidth_study::{Alignment, in_a_sentence};
use zwidth_tables::TableError;

/// The figure [`modes`].
pub const MODES: FigureKind = FigureKind::new(
    "modes",
    "position, force and velocity against time, force against position",
    "trial",
);

/// The note below a figure of trials that have a set-point.
const UNDRAWN: &str = "The set-point (channel reference_rad) is not drawn, neither against time nor as a line or band on \
                       the right; the metrics of the step response measure against it.";

/// Height of one of the three panels against time, mm.
const PANEL_MM: f64 = 30.0;

/// The four-panel figure of one environment. Its axes also cover what was recorded in the
/// environments `beside` it, so that their figures can be compared.
pub fn modes(scene: &EnvironmentData, beside: &[EnvironmentData]) -> Result<Figure, TableError> {
    let words = scene.words();
    let load = scene.load();
    // A torque and a force have no axis in common.
    let all: Vec<&EnvironmentData> =
        [scene].into_iter().chain(beside.iter().filter(|other| other.load() == load)).collect();
    let mut panels = Vec::new();
    for (row, signal) in [Signal::Theta, load, Signal::ThetaDot].into_iter().enumerate() {
        let label = if row == 2 { scene.time_label() } else { "" };
        let axes = [
            time_axis(label).ranged(shared_time(&all)),
            axis(words, signal).ranged(shared(&all, signal)),
        ];
        panels.push(over_time(scene, Cell::at(row, 0), axes, signal)?);
    }
    let axes = [Signal::Theta, load].map(|s| axis(words, s).ranged(shared(&all, s)));
    let near = at_wall(scene).filter(|_| scene.has(load));
    // The panel at the wall takes the lowest of the three rows.
    let cell = Cell::at(0, 1).spanning(if near.is_some() { 2 } else { 3 }, 1);
    let [x, y] = axes;
    panels.push(match [Signal::Theta, load].into_iter().find(|signal| !scene.has(*signal)) {
        Some(missing) => {
            let note = format!("no {} was recorded", recorded_word(words, missing));
            Panel::with_note(cell, x.clone(), y.clone(), note)
        }
        None => Panel::new(cell, x.clone(), y.clone(), loop_layers(scene)?),
    });
    if let Some((from, to)) = near {
        let mut layers = loop_layers(scene)?;
        for layer in &mut layers {
            // In each mode's own dashes, not dotted: all of this panel is at the wall.
            if let Layer::Line(line) = layer {
                line.dotted.clear();
            }
        }
        let x = x.ranged(Range::Fixed(from, to));
        let panel = Panel::new(Cell::at(2, 1), x, y, layers).titled("at the wall");
        panels.push(panel.tall(PANEL_MM));
    }
    let counts: Vec<String> = scene
        .modes
        .iter()
        .map(|m| format!("{} {}", m.repeats.len(), in_a_sentence(m.label)))
        .collect();
    Ok(Figure {
        title: Some(plain(&format!(
            "{}: {} ({})",
            scene.about.title,
            scene.environment.label,
            keep_together(&scene.who)
        ))),
        description: format!(
            "{}, environment {}: {}, force and velocity against time, and force against {}. Repeats: {}.",
            scene.who,
            scene.environment.label,
            words.position_word(),
            words.position_word(),
            counts.join(", "),
        ),
        panels,
        column_weights: vec![1.15, 1.0],
        footnotes: footnotes(scene),
        mark: mark(scene.sources()),
        ..Figure::default()
    })
}

/// What a thick line is: a mean, or the only repeat there is to draw one of.
fn thick(scene: &EnvironmentData) -> &'static str {
    match scene.modes.iter().filter_map(ModeData::averaged).max() {
        Some(1) => "the one repeat of each mode that could be placed",
        _ => "mean of the repeats",
    }
}

/// What the pens mean, and what is to be said of the means.
fn footnotes(scene: &EnvironmentData) -> Vec<String> {
    let mut legend = String::new();
    if scene.modes.iter().any(|m| m.average.is_some()) {
        let has_wall = scene.environment.scene.wall_rad().is_some();
        let how = aligned(scene.alignment, has_wall);
        legend += &format!("Thick: {}; against time {how}", thick(scene));
        if scene.modes.iter().any(|m| m.average.is_some() && m.repeats.len() > 1) {
            legend += &format!(", with its pointwise {} band", scene.level());
        }
        let position = scene.words().position_word();
        legend += &format!("; force against {position} {AT_THE_ANGLE}");
        legend += match scene.alignment {
            Alignment::Onset => "; thin: every repeat",
            Alignment::Landmarks => {
                "; thin: every repeat, stretched so that its landmarks stand at theirs"
            }
        };
        if has_wall {
            let past = rhythms(scene);
            legend += &format!(
                "; dotted{past}: at the wall or past it, but where the wall fills a panel"
            );
        }
        legend += ".";
    }
    let legend = (!legend.is_empty()).then_some(legend);
    let undrawn = scene.about.has_reference.then(|| UNDRAWN.to_owned());
    legend.into_iter().chain(undrawn).chain(scene.notes.iter().map(|n| plain(n))).collect()
}

/// How the dots of each mode stand, where there are several:
/// ` (active dot by dot, hybrid in threes)`.
fn rhythms(scene: &EnvironmentData) -> String {
    let mut all = Vec::new();
    for mode in scene.modes.iter().filter(|mode| mode.average.is_some()) {
        let dots = match style::dash(mode.index).dotted() {
            Dash::InTwos => "in twos",
            Dash::InThrees => "in threes",
            Dash::FarApart => "far apart",
            _ => "dot by dot",
        };
        all.push(format!("{} {dots}", plain(&in_a_sentence(mode.label))));
    }
    if all.len() < 2 { String::new() } else { format!(" ({})", all.join(", ")) }
}

fn over_time(
    scene: &EnvironmentData,
    cell: Cell,
    [time, y]: [Axis; 2],
    signal: Signal,
) -> Result<Panel, TableError> {
    if !scene.has(signal) {
        let note = format!("no {} was recorded", recorded_word(scene.words(), signal));
        return Ok(Panel::with_note(cell, time, y, note).tall(PANEL_MM));
    }
    let wall = wall_line(scene.environment, scene.words(), Direction::Horizontal);
    let mut layers = Vec::from_iter(wall.filter(|_| signal == Signal::Theta));
    // Every repeat before any mean: a mean lies over the repeats of all modes.
    for mode in &scene.modes {
        let single = mode.average.is_none();
        let stroke = pen(mode, single);
        let repeats = mode.repeats.iter();
        let lines = repeats.filter_map(|r| repeat_over_time(scene, r, signal, stroke));
        layers.extend(lines.enumerate().map(|(i, mut line)| {
            line.name = (single && i == 0).then(|| mode.name());
            Layer::Line(line)
        }));
    }
    for mode in &scene.modes {
        layers.extend(mean_over_time(scene, mode, signal)?);
    }
    Ok(Panel::new(cell, time, y, layers).tall(PANEL_MM))
}

/// The pen of a mode's repeats: faint behind a mean.
fn pen(mode: &ModeData, single: bool) -> Stroke {
    let colour = style::mode_colour(mode.index);
    match single {
        true => style::single(colour).dashed(style::dash(mode.index)),
        false => style::faint(colour),
    }
}

/// The wall, every repeat, and the means on them.
fn loop_layers(scene: &EnvironmentData) -> Result<Vec<Layer>, TableError> {
    // The wall first, so that what lies along it is seen on it.
    let wall = wall_line(scene.environment, scene.words(), Direction::Vertical);
    let mut layers = Vec::from_iter(wall);
    for mode in &scene.modes {
        let stroke = pen(mode, mode.loop_average.is_none());
        let loops = mode.repeats.iter().filter_map(|r| repeat_loop(scene, r, stroke));
        layers.extend(loops.map(Layer::Line));
    }
    for mode in &scene.modes {
        let stroke = style::mean(style::mode_colour(mode.index)).dashed(style::dash(mode.index));
        layers.extend(mean_loop(scene, mode, stroke)?.map(Layer::Line));
    }
    Ok(layers)
}
