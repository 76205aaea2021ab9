//! Figures 28 and 29: position, force and velocity against time, force against position; the mean
//! of each mode's repeats with its 95 % band, every repeat faint behind; dotted past the wall.

use crate::FigureKind;
use crate::data::{EnvironmentData, ModeData, aligned};
use crate::panels::{
    axis, mean_loop, mean_over_time, recorded_word, repeat_loop, repeat_over_time, wall_line,
};
use crate::words::{Words, keep_together, mark, plain, time_axis};
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Panel, style};
use zwidth_store::Signal;
use zwidth_study::Alignment;
use zwidth_tables::TableError;

/// The figure [`modes`].
pub const MODES: FigureKind = FigureKind {
    stem: "modes",
    shows: "position, force and velocity against time, force against position",
    drawn_from: "trial",
};

/// Height of one of the three panels against time, mm.
const PANEL_MM: f64 = 30.0;

/// The four-panel figure of one environment.
pub fn modes(scene: &EnvironmentData) -> Result<Figure, TableError> {
    let words = Words::new(scene.about.coordinate);
    let load = scene.load();
    let mut panels = Vec::new();
    for (row, signal) in [Signal::Theta, load, Signal::ThetaDot].into_iter().enumerate() {
        let time = time_axis(if row == 2 { scene.time_label() } else { "" });
        panels.push(over_time(scene, words, Cell::at(row, 0), time, signal)?);
    }
    panels.push(loop_panel(scene, words, load)?);
    Ok(Figure {
        title: Some(plain(&format!(
            "{}: {} ({})",
            scene.about.title,
            scene.environment.label,
            keep_together(&scene.who)
        ))),
        description: describe(scene, words),
        panels,
        column_weights: vec![1.15, 1.0],
        footnotes: footnotes(scene),
        mark: mark(scene.sources()),
        ..Figure::default()
    })
}

fn describe(scene: &EnvironmentData, words: Words) -> String {
    let counts: Vec<String> = scene
        .modes
        .iter()
        .map(|m| format!("{} {}", m.repeats.len(), m.label.to_lowercase()))
        .collect();
    format!(
        "{}, environment {}: {}, force and velocity against time, and force against {}. Repeats: {}. Thick: {}, \
         {}, with its pointwise {} band; thin: every repeat.",
        scene.who,
        scene.environment.label,
        words.position_word(),
        words.position_word(),
        counts.join(", "),
        thick(scene),
        aligned(scene.alignment),
        scene.level(),
    )
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
        legend += &format!("Thick: {}, {}", thick(scene), aligned(scene.alignment));
        if scene.modes.iter().any(|m| m.average.is_some() && m.repeats.len() > 1) {
            legend += &format!(", with its pointwise {} band", scene.level());
        }
        legend += match scene.alignment {
            Alignment::Onset => "; thin: every repeat",
            Alignment::Landmarks => {
                "; thin: every repeat, stretched so that its landmarks stand at theirs"
            }
        };
        if scene.environment.scene.wall_rad().is_some() {
            legend += "; dotted: at the wall or past it";
        }
        legend += ".";
    }
    let legend = (!legend.is_empty()).then_some(legend);
    legend.into_iter().chain(scene.notes.iter().map(|n| plain(n))).collect()
}

fn over_time(
    scene: &EnvironmentData,
    words: Words,
    cell: Cell,
    time: Axis,
    signal: Signal,
) -> Result<Panel, TableError> {
    let y = axis(words, signal);
    if !scene.has(signal) {
        let note = format!("no {} was recorded", recorded_word(words, signal));
        return Ok(Panel { height_mm: Some(PANEL_MM), ..Panel::with_note(cell, time, y, note) });
    }
    let at_wall =
        (signal == Signal::Theta).then(|| wall_line(scene, words, Direction::Horizontal)).flatten();
    let mut layers: Vec<Layer> = at_wall.into_iter().collect();
    for mode in &scene.modes {
        let single = mode.average.is_none();
        let colour = style::mode_colour(mode.index);
        let stroke = if single { style::single(colour) } else { style::faint(colour) };
        let lines =
            mode.repeats.iter().filter_map(|r| repeat_over_time(scene, words, r, signal, stroke));
        layers.extend(lines.enumerate().map(|(i, mut line)| {
            line.name = (single && i == 0).then(|| mode.name());
            Layer::Line(line)
        }));
    }
    for mode in &scene.modes {
        layers.extend(mean_over_time(scene, words, mode, signal)?);
    }
    Ok(Panel { height_mm: Some(PANEL_MM), ..Panel::new(cell, time, y, layers) })
}

fn loop_panel(scene: &EnvironmentData, words: Words, load: Signal) -> Result<Panel, TableError> {
    let cell = Cell::at(0, 1).spanning(3, 1);
    let (x, y) = (words.position_axis(), axis(words, load));
    if !(scene.has(Signal::Theta) && scene.has(load)) {
        let missing = if scene.has(Signal::Theta) { load } else { Signal::Theta };
        let note = format!("no {} was recorded", recorded_word(words, missing));
        return Ok(Panel::with_note(cell, x, y, note));
    }
    // first, so that what lies along the wall is seen on it
    let mut layers: Vec<Layer> = wall_line(scene, words, Direction::Vertical).into_iter().collect();
    for mode in &scene.modes {
        let colour = style::mode_colour(mode.index);
        let stroke =
            if mode.average.is_none() { style::single(colour) } else { style::faint(colour) };
        layers.extend(
            mode.repeats
                .iter()
                .filter_map(|r| repeat_loop(words, r, load, stroke))
                .map(Layer::Line),
        );
    }
    for mode in &scene.modes {
        layers.extend(
            mean_loop(scene, words, mode, load, style::mode_colour(mode.index))?.map(Layer::Line),
        );
    }
    Ok(Panel::new(cell, x, y, layers))
}
