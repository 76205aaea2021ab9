//! Figures 36–41: every repeat of one condition; the commanded force is dotted.

use crate::FigureKind;
use crate::course::data::{EnvironmentData, ModeData, Repeat};
use crate::course::panels::{
    axis, on_axis, recorded_word, repeat_loop, repeat_over_time, wall_line,
};
use crate::extent::{at_wall, without_excess};
use crate::words::{Words, keep_together, mark, plain, time_axis};
use zwidth_draw::{
    Cell, Direction, Figure, Layer, LegendPlace, Line, Panel, Range, Text, TextPlace, style,
};
use zwidth_store::Signal;
use zwidth_study::in_a_sentence;

/// The figure [`repeats`].
pub const REPEATS: FigureKind =
    FigureKind::new("repeats", "every repeat of one condition", "trial");

/// Height of a panel, mm.
const PANEL_MM: f64 = 45.0;

/// Force against position, position and velocity against time, of every repeat of `mode`.
pub fn repeats(scene: &EnvironmentData, mode: &ModeData) -> Figure {
    let words = scene.words();
    let alone = EnvironmentData { modes: vec![mode.clone()], ..scene.clone() };
    let near = at_wall(&alone).filter(|_| scene.has(scene.load()));
    // Four panels find no room in a row.
    let places = match near {
        Some(_) => [Cell::at(0, 0), Cell::at(1, 0), Cell::at(1, 1)],
        None => [Cell::at(0, 0), Cell::at(0, 1), Cell::at(0, 2)],
    };
    let mut panels = vec![
        force_panel(scene, mode, places[0]),
        time_panel(scene, mode, places[1], Signal::Theta),
        time_panel(scene, mode, places[2], Signal::ThetaDot),
    ];
    panels.extend(near.map(|(from, to)| {
        let mut panel = force_panel(scene, mode, Cell::at(0, 1)).titled("at the wall");
        panel.x.range = Range::Fixed(from, to);
        panel.layers.retain(|layer| !matches!(layer, Layer::Text(_)));
        panel
    }));
    let dotted = match alone.has(Signal::ForceCmd) {
        true => " Dotted: the commanded feedback force of the repeat that goes furthest.",
        false => "",
    };
    Figure {
        title: Some(plain(&format!(
            "{}: every repeat, {} ({})",
            scene.environment.label,
            in_a_sentence(mode.label),
            keep_together(&scene.who),
        ))),
        description: format!(
            "{}, environment {}, mode {}: all {} repeats. Force against {}, then {} and velocity against time.{dotted}",
            scene.who,
            scene.environment.label,
            mode.label,
            mode.repeats.len(),
            words.position_word(),
            words.position_word(),
        ),
        panels,
        legend: LegendPlace::Below, // beside the mark seven entries find no room in a row
        mark: mark(alone.sources()),
        ..Figure::default()
    }
}

fn strokes(mode: &ModeData) -> Vec<style::Stroke> {
    let colour = style::mode_colour(mode.index);
    let n = mode.repeats.len();
    (0..n)
        // Every other one dashed: shades that follow each other are hard to tell apart.
        .map(|i| style::single(style::repeat_colour(colour, i, n)).dashed(style::dash(i % 2)))
        .collect()
}

/// Force against position. A command far beyond what was felt is cut, and said in words.
fn force_panel(scene: &EnvironmentData, mode: &ModeData, cell: Cell) -> Panel {
    let words = scene.words();
    let load = scene.load();
    let x = words.position_axis();
    let y = axis(words, load).linked("force");
    let [felt, commands] = [load, Signal::ForceCmd].map(|signal| {
        let signals = mode.repeats.iter().filter_map(move |repeat| repeat.signal(signal));
        signals.flat_map(|values| values.iter().copied())
    });
    let cut = without_excess(felt, commands);
    let mut layers = Vec::from_iter(wall_line(scene.environment, words, Direction::Vertical));
    for (repeat, stroke) in mode.repeats.iter().zip(strokes(mode)) {
        layers.extend(named(repeat, repeat_loop(scene, repeat, stroke)));
    }
    layers.extend(commanded(words, mode));
    layers.extend(cut.map(|(_, most)| {
        let lines = vec![format!("commanded: up to {most:.1} N")];
        Layer::Text(Text { lines, place: TextPlace::EmptiestCorner })
    }));
    let y = y.ranged(cut.map_or(Range::Auto, |(range, _)| range));
    let missing = if scene.has(Signal::Theta) { load } else { Signal::Theta };
    finished(Panel::new(cell, x, y, layers), words, missing)
}

/// The commanded force of the repeat that goes furthest: before it turns it is every repeat's. Of
/// its way back what lies on the way there is left out, for dots on dots make a solid line.
fn commanded(words: Words, mode: &ModeData) -> Option<Layer> {
    let commands = mode.repeats.iter().filter_map(|r| {
        let theta = r.signal(Signal::Theta)?;
        let furthest = theta.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some((furthest, theta, r.signal(Signal::ForceCmd)?))
    });
    let (_, theta, force) = commands.max_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
    Some(Layer::Line(Line {
        x: on_axis(words, Signal::Theta, theta),
        y: once(theta, force),
        stroke: style::commanded(),
        name: Some("commanded force".to_owned()),
        ..Line::default()
    }))
}

/// `force` with gaps after the largest angle wherever it is what it was at the same angle before.
fn once(theta: &[f64], force: &[f64]) -> Vec<f64> {
    /// Share of the largest force within which two forces lie on each other in print.
    const SAME: f64 = 0.01;
    let turn = (0..theta.len()).max_by(|a, b| theta[*a].total_cmp(&theta[*b])).unwrap_or(0);
    let same_n = SAME * force.iter().copied().fold(0.0, f64::max);
    // Angles that only rise, whatever trembling there is in a recording: they can be searched.
    let way_there = theta.iter().take(turn + 1);
    let reached: Vec<f64> = way_there
        .scan(f64::NEG_INFINITY, |highest, theta| {
            *highest = highest.max(*theta);
            Some(*highest)
        })
        .collect();
    let mut drawn = force.to_vec();
    for i in turn + 1..force.len() {
        // Where the way there came to this angle first.
        let to = reached.partition_point(|t| *t < theta[i]);
        if to >= reached.len() {
            continue;
        }
        let from = to.saturating_sub(1);
        let share =
            if to > from { (theta[i] - theta[from]) / (theta[to] - theta[from]) } else { 0.0 };
        let before = force[from] + share * (force[to] - force[from]);
        if (before - force[i]).abs() <= same_n {
            drawn[i] = f64::NAN;
        }
    }
    drawn
}

fn time_panel(scene: &EnvironmentData, mode: &ModeData, cell: Cell, signal: Signal) -> Panel {
    let words = scene.words();
    let wall = wall_line(scene.environment, words, Direction::Horizontal);
    let mut layers = Vec::from_iter(wall.filter(|_| signal == Signal::Theta));
    for (repeat, stroke) in mode.repeats.iter().zip(strokes(mode)) {
        layers.extend(named(repeat, repeat_over_time(scene, repeat, signal, stroke)));
    }
    let panel = Panel::new(cell, time_axis(scene.time_label()), axis(words, signal), layers);
    finished(panel, words, signal)
}

/// The line of a repeat with its name.
fn named(repeat: &Repeat, line: Option<Line>) -> Option<Layer> {
    let name = Some(format!("repeat {}", repeat.trial.meta.repeat));
    line.map(|line| Layer::Line(Line { name, ..line }))
}

/// A panel without data says which signal is missing.
fn finished(panel: Panel, words: Words, missing: Signal) -> Panel {
    let note = panel.layers.iter().all(|l| matches!(l, Layer::Reference(_)));
    let note = note.then(|| format!("no {} was recorded", recorded_word(words, missing)));
    Panel { note, ..panel.tall(PANEL_MM) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commanded_force_that_comes_back_its_own_way_is_drawn_once() {
        let theta = [0.0, 1.0, 2.0, 1.5, 0.5];
        let back = once(&theta, &[0.0, 4.0, 8.0, 6.0, 2.0]);
        assert_eq!(back[..3], [0.0, 4.0, 8.0]);
        assert!(back[3..].iter().all(|f| f.is_nan()), "{back:?}");
        assert_eq!(
            once(&theta, &[0.0, 4.0, 8.0, 2.0, 1.0])[3..],
            [2.0, 1.0],
            "another force stays"
        );
    }
}
