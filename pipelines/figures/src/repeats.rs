//! Figures 36–41: every repeat of one condition; the commanded force dotted.

use crate::data::{ModeData, Scene};
use crate::panels::{axis, on_axis, repeat_loop, repeat_over_time, wall_line};
use crate::words::{Words, mark, plain, time_axis};
use zwidth_draw::{Cell, Direction, Figure, Layer, Line, Panel, style};
use zwidth_store::Signal;

/// Height of a panel, mm.
const PANEL_MM: f64 = 45.0;

/// Force against position, position and velocity against time, of every repeat of `mode`.
pub fn repeats(scene: &Scene, mode: &ModeData) -> Figure {
    let words = Words::new(scene.study.coordinate);
    let load = scene.load();
    let panels = vec![
        force_panel(scene, words, mode, load),
        time_panel(scene, words, mode, Cell::at(0, 1), Signal::Theta),
        time_panel(scene, words, mode, Cell::at(0, 2), Signal::ThetaDot),
    ];
    Figure {
        title: Some(plain(&format!(
            "{}: every repeat, {} ({})",
            scene.environment.label,
            mode.label.to_lowercase(),
            scene.who,
        ))),
        description: format!(
            "{}, environment {}, mode {}: all {} repeats. Force against {}, then {} and velocity against time. Dotted: \
             the commanded feedback force.",
            scene.who,
            scene.environment.label,
            mode.label,
            mode.repeats.len(),
            words.position_word(),
            words.position_word(),
        ),
        panels,
        mark: mark(mode.repeats.iter().map(|r| r.trial.meta.source)),
        ..Figure::default()
    }
}

fn strokes(mode: &ModeData) -> Vec<style::Stroke> {
    let colour = style::mode_colour(mode.index);
    let n = mode.repeats.len();
    (0..n).map(|i| style::single(style::repeat_colour(colour, i, n))).collect()
}

fn name(mode: &ModeData, i: usize) -> String {
    format!("repeat {}", mode.repeats[i].trial.meta.repeat)
}

fn force_panel(scene: &Scene, words: Words, mode: &ModeData, load: Signal) -> Panel {
    let (x, y) = (words.position_axis(), axis(words, load));
    let mut layers = Vec::new();
    for (i, (repeat, stroke)) in mode.repeats.iter().zip(strokes(mode)).enumerate() {
        if let Some(line) = repeat_loop(words, repeat, load, stroke) {
            layers.push(Layer::Line(Line { name: Some(name(mode, i)), ..line }));
        }
    }
    for (i, repeat) in mode.repeats.iter().enumerate() {
        let (Some(theta), Some(force)) = (repeat.signal(Signal::Theta), repeat.signal(Signal::ForceCmd))
        else {
            continue;
        };
        let name = (i == 0).then(|| "commanded force".to_owned());
        let x = on_axis(words, Signal::Theta, theta);
        let stroke = style::commanded();
        layers.push(Layer::Line(Line { x, y: force.to_vec(), stroke, name, ..Line::default() }));
    }
    layers.extend(wall_line(scene, words, Direction::Vertical));
    finished(Panel::new(Cell::at(0, 0), x, y, layers), words)
}

fn time_panel(scene: &Scene, words: Words, mode: &ModeData, cell: Cell, signal: Signal) -> Panel {
    let lines = mode.repeats.iter().zip(strokes(mode)).enumerate().filter_map(|(i, (repeat, stroke))| {
        let line = repeat_over_time(scene, words, repeat, signal, stroke)?;
        Some(Layer::Line(Line { name: Some(name(mode, i)), ..line }))
    });
    let mut layers: Vec<Layer> = lines.collect();
    if signal == Signal::Theta && !layers.is_empty() {
        layers.extend(wall_line(scene, words, Direction::Horizontal));
    }
    finished(Panel::new(cell, time_axis(scene.time_label()), axis(words, signal), layers), words)
}

/// A panel without data says so.
fn finished(panel: Panel, words: Words) -> Panel {
    let note = panel.layers.iter().all(|l| matches!(l, Layer::Reference(_)));
    let note = note.then(|| format!("no {} was recorded", words.position_word()));
    Panel { height_mm: Some(PANEL_MM), note, ..panel }
}
