//! Figure 25: the forces that each mode can render, compression and decompression apart, and the
//! force that each command gives.

use crate::words::{mark, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Dash, Stroke};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Layer, Line, Panel, Points, Range, Reference, Text,
    TextPlace,
};
use zwidth_study::{ActuatorKind, Calibration, Characteristic, Mode, Source};

/// The figure [`rendering_range`].
pub const RENDERING_RANGE: FigureKind = FigureKind::new(
    "rendering_range",
    "forces that each mode can render, compressing and decompressing",
    "trial",
);

/// Height of a panel, mm.
const PANEL_MM: f64 = 55.0;
/// Pieces of a curve between the voltage where force begins and the highest.
const PIECES: usize = 200;
/// A gap of less than this share of an actuator's highest voltage is not named.
const NAMED_GAP: f64 = 0.02;
/// Half the width of a bar, in modes.
const HALF_BAR: f64 = 0.3;
/// The axis goes so much beyond the largest force.
const ROOM: f64 = 1.1;

/// Why the force at the end of a sweep is not the one that its load cell reads.
const FROM_SWEEPS: &str = "Near the highest voltage of a sweep, where the command turns, the load cell (figures of the characteristic) \
                           reads less: friction turns with the command. Here the force goes on along the tangent.";

/// Which way the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Compression,
    Decompression,
}

/// The force that each actuator gives for a command, and for each mode and way the range of forces
/// from commands up to the mode's own voltage: the device's force on the lever, positive against a
/// push into the object. `calibration` gives forces for voltages, `footnote` says where it is from,
/// and `sources` where the sweeps behind it are from. None if no mode has an actuator.
///
/// A motor gives either sign on either way. A brake gives a force only against the motion: against
/// the push while compressing, against the return while decompressing. A mode with both has the
/// brake on the way in and the motor on the way back (thesis §2.2).
pub fn rendering_range(
    about: &About,
    calibration: &Calibration,
    footnote: &str,
    sources: &[Source],
) -> Option<Figure> {
    about.modes.iter().find(|mode| mode.motor_max_v.or(mode.brake_max_v).is_some())?;
    let mut footnotes = vec![
        "Bar: every force that some command up to the mode's own voltage makes, at any angle; above 0 against a push \
         into the object. The friction of the transmission, which adds to it on the way in and takes from it on \
         the way back, is left out."
            .to_owned(),
    ];
    if !sources.is_empty() {
        footnotes.push(FROM_SWEEPS.to_owned());
    }
    footnotes.push(plain(footnote));
    let panels = vec![
        commands(about, calibration),
        bars(about, Way::Compression, calibration, 1),
        bars(about, Way::Decompression, calibration, 2),
    ];
    Some(Figure {
        title: Some(plain(&format!("{}: forces that each mode can render", about.title))),
        description: "The force of motor and brake against their command, and for each mode the device's force on the \
                      lever that commands up to its own voltage can make, while compressing and while decompressing."
            .to_owned(),
        panels,
        column_weights: vec![1.2, 1.0, 1.0],
        footnotes,
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// The least and the largest force of what acts at the mode's highest voltage: of either sign, or one
/// of them 0 where it makes one sign alone.
fn reached_n(mode: &Mode, way: Way, calibration: &Calibration) -> Option<[f64; 2]> {
    let [compressing, releasing] = mode.law()?.drives();
    let (drive, brake_shares) = match way {
        Way::Compression => (compressing, [0.0, 1.0]),
        Way::Decompression => (releasing, [-1.0, 0.0]),
    };
    let (curve, max_v, shares) = match drive {
        ActuatorKind::Motor => (&calibration.motor, mode.motor_max_v, [-1.0, 1.0]),
        ActuatorKind::Brake => (&calibration.brake, mode.brake_max_v, brake_shares),
    };
    let full_n = curve.force_n(max_v?);
    Some(shares.map(|share| share * full_n))
}

/// The voltage that a mode goes up to with one actuator.
type Voltage = fn(&Mode) -> Option<f64>;

/// Force against command, one line per actuator, which begins where force does; a point at each
/// voltage that modes go up to.
fn commands(about: &About, calibration: &Calibration) -> Panel {
    let brake_pen = style::mean(style::BRAKE).dashed(Dash::Dashed);
    let actuators: [(&str, &Characteristic, Voltage, Stroke); 2] = [
        ("motor", &calibration.motor, |mode| mode.motor_max_v, style::mean(style::MOTOR)),
        ("brake", &calibration.brake, |mode| mode.brake_max_v, brake_pen),
    ];
    let mut layers = vec![reference(Direction::Horizontal, 0.0, None)];
    for (name, curve, max_v, stroke) in actuators {
        let Some(most_v) = about.modes.iter().filter_map(max_v).reduce(f64::max) else { continue };
        let gap_v = curve.voltage_v.first().copied().unwrap_or(0.0).min(most_v);
        if gap_v > NAMED_GAP * most_v {
            let words = format!("{name}: none below {gap_v:.2} V");
            layers.push(reference(Direction::Vertical, gap_v, Some(words)));
        }
        let x: Vec<f64> =
            (0..=PIECES).map(|i| gap_v + (most_v - gap_v) * i as f64 / PIECES as f64).collect();
        let y = x.iter().map(|v| curve.force_n(*v)).collect();
        let name = Some(name.to_owned());
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
        layers.extend(ends(about, curve, max_v));
    }
    let y = Axis::new("*F*", "N").linked("force");
    Panel::new(Cell::at(0, 0), Axis::new("command", "V"), y, layers).tall(PANEL_MM)
}

/// A point at each voltage that modes go up to, with their names.
fn ends(about: &About, curve: &Characteristic, max_v: Voltage) -> Vec<Layer> {
    let mut voltages: Vec<f64> = about.modes.iter().filter_map(max_v).collect();
    voltages.sort_by(f64::total_cmp);
    // Modes that go up to one voltage share a point, with all their names.
    voltages.dedup();
    let mut layers = Vec::new();
    for at in voltages {
        let force_n = curve.force_n(at);
        let modes = about.modes.iter().filter(|mode| max_v(mode) == Some(at));
        let names: Vec<String> = modes.map(|mode| plain(&mode.label)).collect();
        layers.push(Layer::Points(Points { x: vec![at], y: vec![force_n], ..Points::default() }));
        let lines = vec![format!("{}\u{a0}{at}\u{a0}V", names.join(", "))];
        layers.push(Layer::Text(Text { lines, place: TextPlace::Over(at, force_n) }));
    }
    layers
}

/// One bar per mode: what it reaches on that way.
fn bars(about: &About, way: Way, calibration: &Calibration, column: usize) -> Panel {
    let title = match way {
        Way::Compression => "compressing",
        Way::Decompression => "decompressing",
    };
    let mut names = Vec::new();
    let mut layers = vec![reference(Direction::Horizontal, 0.0, None)];
    let mut most_n: f64 = 0.0;
    for (index, mode) in about.modes.iter().enumerate() {
        let reaches = match reached_n(mode, way, calibration) {
            Some([low_n, high_n]) => {
                most_n = most_n.max(high_n).max(-low_n);
                layers.extend(bar(index, low_n, high_n));
                range(low_n, high_n)
            }
            None => "none".to_owned(),
        };
        // Under its bar a number has room in one column too; over the bars they meet.
        names.push(format!("{} {reaches}", plain(&mode.label)));
    }
    let x = Axis::categories(names);
    let y = Axis::new("*F*", "N").linked("force");
    let cell = Cell::at(0, column);
    if most_n == 0.0 {
        return Panel::with_note(cell, x, y, "no actuator on this way").titled(title);
    }
    let y = y.ranged(Range::Holding(-ROOM * most_n, ROOM * most_n));
    Panel::new(cell, x, y, layers).titled(title).tall(PANEL_MM)
}

/// The bar of a mode and its edge.
fn bar(index: usize, low_n: f64, high_n: f64) -> Vec<Layer> {
    let colour = style::mode_colour(index);
    let [left, right] = [-HALF_BAR, HALF_BAR].map(|aside| index as f64 + aside);
    let [low, high] = [low_n, high_n].map(|force_n| vec![force_n; 2]);
    let area = Band { x: vec![left, right], low, high, colour, name: None };
    let edge = Line {
        x: vec![left, right, right, left, left],
        y: vec![low_n, low_n, high_n, high_n, low_n],
        stroke: style::mean(colour).dashed(style::dash(index)),
        ..Line::default()
    };
    vec![Layer::Band(area), Layer::Line(edge)]
}

/// The ends of a bar in words, which no line break parts.
fn range(low_n: f64, high_n: f64) -> String {
    match (low_n < 0.0, high_n > 0.0) {
        (true, true) => format!("±{high_n:.2}\u{a0}N"),
        (false, _) => format!("0…{high_n:.1}\u{a0}N"),
        (true, false) => format!("0…−{:.1}\u{a0}N", -low_n),
    }
}

fn reference(direction: Direction, at: f64, label: Option<String>) -> Layer {
    let line = Reference::new(direction, at, style::reference().dashed(Dash::Dotted));
    Layer::Reference(Reference { label, ..line })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::Ticks;

    fn about() -> About {
        let study = zwidth_testing::study();
        About::of(&study)
    }

    fn figure(sources: &[Source]) -> Figure {
        rendering_range(&about(), &Calibration::thesis(), "from the thesis", sources).unwrap()
    }

    fn bands(figure: &Figure, panel: usize) -> Vec<(f64, f64)> {
        let band = |layer: &Layer| match layer {
            Layer::Band(band) => Some((band.low[0], band.high[0])),
            _ => None,
        };
        figure.panels[panel].layers.iter().filter_map(band).collect()
    }

    /// The thesis' §5.1: 4.16 N at 16 V, 2.08 N at 8 V, 13 N from the brake, which begins at 1 V.
    #[test]
    fn the_bars_end_at_the_forces_of_the_modes_own_voltages() {
        let figure = figure(&[]);
        let expect = [
            (1, [(-4.16, 4.16), (0.0, 13.0), (0.0, 13.0)]),
            (2, [(-4.16, 4.16), (-13.0, 0.0), (-2.08, 2.08)]),
        ];
        for (panel, bars) in expect {
            for (found, expect) in bands(&figure, panel).into_iter().zip(bars) {
                let off = (found.0 - expect.0).abs().max((found.1 - expect.1).abs());
                assert!(off < 1e-9, "{panel}: {found:?} for {expect:?}");
            }
        }
    }

    #[test]
    fn a_command_gives_one_force_and_below_the_gap_of_the_brake_none() {
        let figure = figure(&[]);
        let curves: Vec<&Line> = figure.panels[0].lines().collect();
        let [motor, brake] = curves[..] else { panic!("{curves:?}") };
        assert!((brake.x[0] - 1.0).abs() < 1e-12 && brake.y[0].abs() < 1e-12);
        assert_eq!((motor.x[0], motor.y[0]), (0.0, 0.0));
        assert!((motor.y[PIECES] - 4.16).abs() < 1e-9 && (brake.y[PIECES] - 13.0).abs() < 1e-9);
        let labels = figure.panels[0].layers.iter().filter_map(|layer| match layer {
            Layer::Reference(line) => line.label.as_deref(),
            _ => None,
        });
        let labels: Vec<&str> = labels.collect();
        assert_eq!(labels, ["brake: none below 1.00 V"], "the motor has no gap");
        assert!(zwidth_draw::draw(&figure).is_ok());
    }

    #[test]
    fn its_words_have_room_in_one_column_and_in_two() {
        for width_mm in [85.0, 170.0] {
            let figure = Figure { width_mm, ..figure(&[Source::Twin]) };
            let drawing = zwidth_draw::draw(&figure).unwrap();
            let overlapping = drawing.overlapping_words().unwrap();
            assert!(overlapping.is_empty(), "{width_mm} mm: {overlapping:?}");
        }
    }

    #[test]
    fn a_mode_without_an_actuator_has_no_bar_and_says_so() {
        let mut about = about();
        about.modes[0].motor_max_v = None;
        let figure = rendering_range(&about, &Calibration::thesis(), "", &[]).unwrap();
        assert_eq!(bands(&figure, 1).len(), 2);
        let Ticks::Categories(names) = &figure.panels[1].x.ticks else { panic!("no names") };
        assert!(names[0].ends_with(" none") && names[1].ends_with(" 0…13.0\u{a0}N"), "{names:?}");
        assert!(zwidth_draw::draw(&figure).is_ok());
    }

    #[test]
    fn a_calibration_of_simulated_sweeps_marks_the_figure() {
        assert!(figure(&[Source::Recorded, Source::Twin]).mark.is_some());
        assert!(figure(&[]).mark.is_none(), "the thesis' own numbers are no data of a twin");
        assert_eq!(figure(&[Source::Recorded]).footnotes.len(), 3, "why the load cell reads less");
        assert_eq!(figure(&[]).footnotes.len(), 2, "no sweep, no load cell");
    }

    #[test]
    fn a_study_without_voltages_has_no_such_figure() {
        let mut about = about();
        for mode in &mut about.modes {
            (mode.motor_max_v, mode.brake_max_v) = (None, None);
        }
        assert!(rendering_range(&about, &Calibration::thesis(), "", &[]).is_none());
    }
}
