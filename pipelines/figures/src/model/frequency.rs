//! Impedance against frequency with its coherence, one column per environment.

use crate::words::{distinct, lettered, logarithm, plain, powers_axis};
use zwidth_draw::style;
use zwidth_draw::{Axis, Band, Cell, Figure, Layer, Line, Panel, Range};
use zwidth_results::{ImpedancePoint, Row};

/// Height of a panel, mm.
const PANEL_MM: f64 = 46.0;

/// What a panel shows.
#[derive(Clone, Copy, PartialEq)]
enum Shows {
    Magnitude,
    Phase,
    Coherence,
}

/// One mode of an environment, as it stands on the axes.
#[derive(Default)]
struct Curve {
    mode: String,
    frequency: Vec<f64>,
    /// NaN where the coherence may be chance.
    magnitude: Vec<[f64; 3]>,
    phase: Vec<[f64; 3]>,
    coherence: Vec<f64>,
    chance: Vec<f64>,
}

/// |Z|, phase and coherence against frequency. Where the coherence may be chance, |Z| and phase are
/// not drawn.
pub fn impedance_frequency(
    points: &[ImpedancePoint],
    notes: &[String],
    mark: Option<String>,
) -> Figure {
    let environments = distinct(points.iter().map(|point| &point.environment));
    let mut panels = Vec::new();
    for (column, environment) in environments.iter().enumerate() {
        let own: Vec<&ImpedancePoint> =
            points.iter().filter(|point| point.environment == *environment).collect();
        let modes = distinct(own.iter().map(|point| &point.mode));
        let curves: Vec<Curve> = modes.iter().map(|mode| Curve::of(mode, &own)).collect();
        let all = [Shows::Magnitude, Shows::Phase, Shows::Coherence];
        panels.extend(all.into_iter().enumerate().map(|(row, shows)| {
            let name = if row == 0 { plain(environment) } else { String::new() };
            let title = lettered(row * environments.len() + column, &name);
            panel(&curves, shows, Cell::at(row, column)).titled(title)
        }));
    }
    Figure {
        title: Some(plain(ImpedancePoint::TITLE)),
        description: "Size and phase of the impedance that a user feels at the lever's end, force over velocity, and \
                      their coherence, against frequency, for each mode; bands are intervals."
            .to_owned(),
        panels,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark,
        ..Figure::default()
    }
}

impl Curve {
    /// That of a mode, from the points of its environment.
    fn of(mode: &str, points: &[&ImpedancePoint]) -> Self {
        let mut curve = Self { mode: plain(mode), ..Self::default() };
        for point in points.iter().filter(|point| *point.mode == *mode) {
            curve.frequency.push(logarithm(point.frequency_hz));
            curve.coherence.push(point.coherence);
            curve.chance.push(point.chance);
            if point.coherence > point.chance {
                let ends = [Some(point.magnitude_ns_per_m), point.ci_low, point.ci_high];
                curve.magnitude.push(ends.map(|value| value.map_or(f64::NAN, logarithm)));
                let half = point.phase_half_interval_rad.map_or(f64::NAN, f64::to_degrees);
                let at = point.phase_rad.to_degrees();
                // No interval of an angle is wider than the circle.
                let by = half.min(180.0);
                curve.phase.push([at, at - by, at + by]);
            } else {
                curve.magnitude.push([f64::NAN; 3]);
                curve.phase.push([f64::NAN; 3]);
            }
        }
        curve
    }
}

fn panel(curves: &[Curve], shows: Shows, cell: Cell) -> Panel {
    let mut layers = Vec::new();
    for (i, curve) in curves.iter().enumerate() {
        let colour = style::mode_colour(i);
        let name = Some(curve.mode.clone());
        let x = curve.frequency.clone();
        let stroke = style::mean(colour);
        let values = match shows {
            Shows::Magnitude => &curve.magnitude,
            Shows::Phase => &curve.phase,
            Shows::Coherence => {
                let y = curve.coherence.clone();
                let of_mode = Line { x: x.clone(), y, stroke, name, ..Line::default() };
                let stroke = style::single(colour).dashed(style::Dash::Dotted);
                let chance = Line { x, y: curve.chance.clone(), stroke, ..Line::default() };
                layers.extend([of_mode, chance].map(Layer::Line));
                continue;
            }
        };
        let [y, low, high] = [0, 1, 2].map(|at| values.iter().map(|v| v[at]).collect());
        layers.push(Layer::Band(Band { x: x.clone(), low, high, colour, name: name.clone() }));
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
    }
    let x = powers_axis("frequency", "Hz").linked("frequency");
    let y = match shows {
        Shows::Magnitude => powers_axis("|*Z*|", "N s/m").linked("magnitude"),
        // A little beyond ±180°, so that points at either end are seen whole.
        Shows::Phase => Axis::new("phase of *Z*", "°").ranged(Range::Fixed(-200.0, 200.0)),
        Shows::Coherence => Axis::new("coherence *γ*²", "").ranged(Range::Fixed(0.0, 1.0)),
    };
    Panel::new(cell, x, y, layers).tall(PANEL_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;

    #[test]
    fn three_panels_an_environment_and_chance_is_not_drawn() {
        let point = |environment: &str, mode: &str, frequency_hz, magnitude_ns_per_m, coherence| {
            ImpedancePoint {
                environment: environment.into(),
                mode: mode.into(),
                frequency_hz,
                magnitude_ns_per_m,
                ci_low: Some(magnitude_ns_per_m - 1.0),
                ci_high: Some(magnitude_ns_per_m + 1.0),
                phase_rad: -1.0,
                phase_half_interval_rad: Some(0.1),
                real_ns_per_m: 1.0,
                imaginary_ns_per_m: -1.0,
                coherence,
                chance: 0.2,
                velocity_density: 1.0,
                force_density: 1.0,
                averages: 20.0,
                segments: 28,
                segment_samples: 128,
                rate_hz: 80.0,
            }
        };
        let points = [
            point("spring", "active", 1.0, 10.0, 0.9),
            point("spring", "active", 2.0, 5.0, 0.1),
            ImpedancePoint { ci_low: Some(0.0), ..point("spring", "hybrid", 1.0, 8.0, 0.8) },
            point("wall", "active", 1.0, 9.0, 0.7),
        ];
        let figure = impedance_frequency(&points, &[], None);
        assert_eq!(figure.panels.len(), 6);
        let Layer::Line(line) = &figure.panels[0].layers[1] else { panic!("no line") };
        assert!((line.y[0] - 1.0).abs() < 1e-12 && line.y[1].is_nan());
        draw(&figure).unwrap();
    }
}
