//! The user's force against position, for every environment side by side: the user's force
//! discrepancy at a glance.

use crate::course::data::{AT_THE_ANGLE, EnvironmentData, ModeData, repeats_averaged};
use crate::course::panels::{axis, mean_loop, recorded_word, repeat_loop, wall_line};
use crate::words::{Words, keep_together, mark, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Direction, Figure, Layer, Line, Panel};
use zwidth_store::Signal;
use zwidth_tables::TableError;

/// The figure [`loops`].
pub const LOOPS: FigureKind =
    FigureKind::new("loops", "force against position, all environments", "trial");

/// Height of a panel, mm.
const PANEL_MM: f64 = 55.0;

/// One panel per mode, one loop per environment.
pub fn loops(about: &About, scenes: &[EnvironmentData]) -> Result<Figure, TableError> {
    let words = Words::new(about.coordinate);
    let load = scenes.first().map_or(Signal::ForceEx, EnvironmentData::load);
    let load_word = recorded_word(words, load);
    let who = scenes.first().map(|s| s.who.as_str()).unwrap_or_default();
    let mut panels = Vec::new();
    for (index, mode) in about.modes.iter().enumerate() {
        let mut layers = Vec::new();
        for (i, scene) in scenes.iter().enumerate() {
            let Some(data) = scene.modes.iter().find(|m| m.index == index) else { continue };
            let wall = wall_line(scene.environment, words, Direction::Vertical);
            layers.splice(0..0, wall); // behind the data
            let pen = style::mean(style::environment_colour(i)).dashed(style::dash(i));
            layers.extend(loop_layers(scene, data, pen)?);
        }
        if layers.is_empty() {
            continue;
        }
        let cell = Cell::at(0, panels.len());
        let y = axis(words, load).linked("force");
        let x = words.position_axis().linked("position");
        panels.push(Panel::new(cell, x, y, layers).titled(plain(&mode.label)).tall(PANEL_MM));
    }
    let footnotes = footnotes(scenes, &panels);
    Ok(Figure {
        title: Some(plain(&format!(
            "{}: {load_word} against {} ({})",
            about.title,
            words.position_word(),
            keep_together(who)
        ))),
        description: format!(
            "{who}: {load_word} against {} there and back, one panel per mode, one loop per environment.",
            words.position_word()
        ),
        width_mm: if panels.len() == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels,
        footnotes,
        mark: mark(scenes.iter().flat_map(EnvironmentData::sources)),
        ..Figure::default()
    })
}

/// Which means the loops are, and of how many repeats, where there is one; what dots mean, where
/// there are any.
fn footnotes(scenes: &[EnvironmentData], panels: &[Panel]) -> Vec<String> {
    let modes = scenes.iter().flat_map(|scene| &scene.modes);
    let averaged = repeats_averaged(modes.filter(|mode| mode.repeats.len() > 1));
    let means = averaged.map(|n| {
        let what = if n == "1 trial" {
            "the one repeat that could be placed"
        } else {
            "mean of the repeats"
        };
        format!("Lines: {what} ({n}), {AT_THE_ANGLE}")
    });
    let dotted = panels.iter().flat_map(Panel::lines).any(|line| line.dotted.contains(&true));
    let dots = dotted.then(|| "dotted: at the wall or past it".to_owned());
    let pens: Vec<String> = means.into_iter().chain(dots).collect();
    let pens = (!pens.is_empty()).then(|| format!("{}.", pens.join("; ")));
    let force = scenes.iter().any(|scene| scene.load() == Signal::ForceEx);
    let whose = force.then(|| WHOSE.to_owned());
    pens.into_iter().chain(whose).collect()
}

/// Whose force it is.
const WHOSE: &str = "*F*: the user's force. The gap between the two ways is also due to inertia, damping and friction.";

/// The mean loop, or every repeat's where there is no mean.
fn loop_layers(
    scene: &EnvironmentData,
    mode: &ModeData,
    pen: Stroke,
) -> Result<Vec<Layer>, TableError> {
    let name = plain(&scene.environment.label);
    // One repeat is no mean: it is drawn in the thin pen.
    let mean = match mode.repeats.len() {
        0 | 1 => None,
        _ => mean_loop(scene, mode, pen)?,
    };
    let single = style::single(pen.colour).dashed(pen.dash);
    let lines: Vec<Line> = match mean {
        Some(line) => vec![line],
        None => mode.repeats.iter().filter_map(|r| repeat_loop(scene, r, single)).collect(),
    };
    let named = lines.into_iter().map(|line| Line { name: Some(name.clone()), ..line });
    Ok(named.map(Layer::Line).collect())
}
