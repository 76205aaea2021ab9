//! What several figures share: curves of repeats and means, wall lines, axes of the force.

use crate::course::data::{EnvironmentData, ModeData, Repeat, mean_curve, mean_loop_of};
use crate::words::Words;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Axis, Band, Direction, Layer, Line, Reference};
use zwidth_results::AveragedTime;
use zwidth_store::Signal;
use zwidth_study::Environment;
use zwidth_tables::TableError;

/// A signal as it stands on its axis: angles in degrees or millimetres, everything else as it is.
pub(crate) fn on_axis(words: Words, signal: Signal, values: &[f64]) -> Vec<f64> {
    match signal {
        Signal::Theta | Signal::ThetaDot => words.positions(values.iter().copied().map(Some)),
        _ => values.to_vec(),
    }
}

/// Axis of a signal.
pub(crate) fn axis(words: Words, signal: Signal) -> Axis {
    match signal {
        Signal::Theta => words.position_axis(),
        Signal::ThetaDot => words.velocity_axis(),
        Signal::TorqueEx => Axis::new("*T*_{ex}", "N·m"),
        Signal::ForceCmd => Axis::new("*F*_{cmd}", "N"),
        _ => Axis::new("*F*_{ex}", "N"),
    }
}

/// Which samples lie at or past the wall; empty without a wall or an angle.
fn past_wall(scene: &EnvironmentData, theta_rad: &[f64]) -> Vec<bool> {
    let wall = scene.environment.scene.wall_rad();
    wall.map_or(Vec::new(), |wall| theta_rad.iter().map(|theta| *theta >= wall).collect())
}

/// One repeat's signal against time.
pub(crate) fn repeat_over_time(
    scene: &EnvironmentData,
    repeat: &Repeat,
    signal: Signal,
    stroke: Stroke,
) -> Option<Line> {
    if scene.aligned() && repeat.onset_s.is_none() {
        return None; // it never moved: it has no place on this axis
    }
    let y = on_axis(scene.words(), signal, repeat.signal(signal)?);
    Some(Line { x: repeat.time(), y, stroke, ..Line::default() })
}

/// One repeat's force against position.
pub(crate) fn repeat_loop(
    scene: &EnvironmentData,
    repeat: &Repeat,
    stroke: Stroke,
) -> Option<Line> {
    let x = on_axis(scene.words(), Signal::Theta, repeat.signal(Signal::Theta)?);
    Some(Line { x, y: repeat.signal(scene.load())?.to_vec(), stroke, ..Line::default() })
}

/// The mean of a mode's repeats against time, with its band; dotted past the wall.
pub(crate) fn mean_over_time(
    scene: &EnvironmentData,
    mode: &ModeData,
    signal: Signal,
) -> Result<Vec<Layer>, TableError> {
    let Some(average) = mode.average else { return Ok(Vec::new()) };
    let Some(curve) = mean_curve(average, signal)? else { return Ok(Vec::new()) };
    let times: Vec<AveragedTime> = average.to_rows()?;
    let x: Vec<f64> = times.iter().map(|time| time.t_s).collect();
    let colour = style::mode_colour(mode.index);
    // Whether a sample lies past the wall its mean angle says, whatever signal is drawn.
    let dotted = mean_curve(average, Signal::Theta)?
        .map_or(Vec::new(), |[mean, ..]| past_wall(scene, &mean));
    let [y, low, high] = curve.map(|values| on_axis(scene.words(), signal, &values));
    let name = Some(mode.name());
    let mut layers = Vec::new();
    // The mean of one repeat has no band.
    if low.iter().any(|v| v.is_finite()) {
        layers.push(Layer::Band(Band { x: x.clone(), low, high, colour, name: name.clone() }));
    }
    let stroke = style::mean(colour).dashed(style::dash(mode.index));
    layers.push(Layer::Line(Line { x, y, dotted, stroke, name }));
    Ok(layers)
}

/// The mean force of a mode's repeats at each position, drawn with `stroke`; dotted past the wall.
pub(crate) fn mean_loop(
    scene: &EnvironmentData,
    mode: &ModeData,
    stroke: Stroke,
) -> Result<Option<Line>, TableError> {
    let Some(average) = mode.loop_average else { return Ok(None) };
    let Some([theta, y]) = mean_loop_of(average, scene.load())? else { return Ok(None) };
    Ok(Some(Line {
        x: on_axis(scene.words(), Signal::Theta, &theta),
        y,
        dotted: past_wall(scene, &theta),
        stroke,
        name: Some(mode.name()),
    }))
}

/// The line where the wall begins, across an axis that shows positions.
pub(crate) fn wall_line(
    environment: &Environment,
    words: Words,
    direction: Direction,
) -> Option<Layer> {
    let wall = environment.scene.wall_rad()?;
    let line = Reference::new(direction, words.position(wall), style::reference());
    let label = match direction {
        Direction::Vertical => Some(format!("wall {}", words.place(wall))),
        Direction::Horizontal => None,
    };
    Some(Layer::Reference(Reference { label, ..line }))
}

/// What a signal is called where it is missing.
pub(crate) fn recorded_word(words: Words, signal: Signal) -> &'static str {
    match signal {
        Signal::Theta => words.position_word(),
        Signal::ThetaDot => "velocity",
        Signal::TorqueEx => "torque",
        _ => "force",
    }
}
