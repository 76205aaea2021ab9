//! Figure 25: the forces that each mode can render, compression and decompression apart.

use crate::words::{mark, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Dash};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Layer, LegendPlace, Line, Panel, Range, Reference, Text,
    TextPlace,
};
use zwidth_study::{ActuatorKind, Calibration, Characteristic, Mode, Source};

/// The figure [`rendering_range`].
pub const RENDERING_RANGE: FigureKind = FigureKind {
    stem: "rendering_range",
    shows: "forces that each mode can render, compressing and decompressing",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 34.0;
/// Pieces of a curve between no voltage and the highest.
const PIECES: usize = 200;
/// The axis goes this much beyond the highest voltage of any mode.
const AXIS: f64 = 1.05;
/// A gap of less than this share of a mode's highest voltage is not named.
const NAMED_GAP: f64 = 0.02;
/// Up to this share of the axis an area leaves room for words beside it.
const BESIDE: f64 = 0.6;

/// Which way the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Compression,
    Decompression,
}

/// An actuator of a mode at work: its curve, its highest voltage, and which signs of force it can
/// make.
struct Acting<'a> {
    curve: &'a Characteristic,
    max_v: f64,
    /// Least and largest force as shares of the curve: −1 and 1 for either sign, one of them 0 for
    /// one sign alone.
    shares: (f64, f64),
}

/// For each mode a panel a way: the device's force on the lever, positive against a push into the
/// object, that any command up to the mode's own voltage can make. `calibration` gives forces for
/// voltages, `footnote` says where it is from, and `sources` where the sweeps behind it are from.
/// None where no mode has an actuator.
///
/// A motor makes either sign on either way. A brake makes a force against the motion alone: against
/// the push while compressing, against the return while decompressing. A mode of both has the brake
/// on the way in and the motor on the way back (thesis §2.2).
pub fn rendering_range(
    about: &About,
    calibration: &Calibration,
    footnote: &str,
    sources: &[Source],
) -> Option<Figure> {
    let modes: Vec<(usize, &Mode)> = about
        .modes
        .iter()
        .enumerate()
        .filter(|(_, m)| m.motor_max_v.or(m.brake_max_v).is_some())
        .collect();
    let most =
        |get: fn(&Mode) -> Option<f64>| modes.iter().filter_map(|(_, m)| get(m)).reduce(f64::max);
    let max_v =
        most(|m| m.motor_max_v).into_iter().chain(most(|m| m.brake_max_v)).reduce(f64::max)?;
    let mut panels = Vec::new();
    for (row, way) in [Way::Compression, Way::Decompression].into_iter().enumerate() {
        for (column, (index, mode)) in modes.iter().enumerate() {
            panels.push(panel(Cell::at(row, column), mode, *index, way, calibration, max_v));
        }
    }
    Some(Figure {
        title: Some(plain(&format!("{}: forces that each mode can render", about.title))),
        description: "For each mode the device's force on the lever that commands up to its own voltage can make, while \
                      compressing and while decompressing."
            .to_owned(),
        panels,
        legend: LegendPlace::Hidden,
        footnotes: vec![
            "Area: every force that a command up to this voltage can make, at any angle; above 0 against a push into \
             the object. The friction of the transmission, which adds to it on the way in and takes from it on the way \
             back, is left out."
                .to_owned(),
            plain(footnote),
        ],
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// What acts, and what it can.
fn acting<'a>(mode: &Mode, way: Way, calibration: &'a Calibration) -> Option<Acting<'a>> {
    let [compressing, releasing] = mode.law()?.drives();
    let (drive, of_brake) = match way {
        Way::Compression => (compressing, (0.0, 1.0)),
        Way::Decompression => (releasing, (-1.0, 0.0)),
    };
    let (curve, max_v, shares) = match drive {
        ActuatorKind::Motor => (&calibration.motor, mode.motor_max_v, (-1.0, 1.0)),
        ActuatorKind::Brake => (&calibration.brake, mode.brake_max_v, of_brake),
    };
    Some(Acting { curve, max_v: max_v?, shares })
}

fn panel(
    cell: Cell,
    mode: &Mode,
    index: usize,
    way: Way,
    calibration: &Calibration,
    max_v: f64,
) -> Panel {
    let axis_v = AXIS * max_v;
    let x = Axis::new("command", "V").ranged(Range::Fixed(0.0, axis_v)).linked("command");
    let y = Axis::new(
        if way == Way::Compression { "*F*, compressing" } else { "*F*, decompressing" },
        "N",
    );
    let layers =
        acting(mode, way, calibration).map(|a| area(&a, index, axis_v)).unwrap_or_default();
    let panel = Panel::new(cell, x, y.linked(format!("{way:?}")), layers);
    let title = (way == Way::Compression).then(|| plain(&mode.label));
    Panel { title, height_mm: Some(PANEL_MM), ..panel }
}

/// The area, its edges, the extremes in words, and the gap before the force begins.
fn area(acting: &Acting, index: usize, axis_v: f64) -> Vec<Layer> {
    let colour = style::mode_colour(index);
    let gap_v = acting.curve.voltage_v.first().copied().unwrap_or(0.0);
    let from_v = gap_v.min(acting.max_v);
    let x: Vec<f64> =
        (0..=PIECES).map(|i| from_v + (acting.max_v - from_v) * i as f64 / PIECES as f64).collect();
    let edge =
        |share: f64| x.iter().map(|v| share * acting.curve.force_n(*v)).collect::<Vec<f64>>();
    let (low, high) = (edge(acting.shares.0), edge(acting.shares.1));
    let close = Line {
        x: vec![acting.max_v; 2],
        y: vec![low[PIECES], high[PIECES]],
        stroke: style::mean(colour),
        ..Line::default()
    };
    let outline = |y: &Vec<f64>| {
        Layer::Line(Line {
            x: x.clone(),
            y: y.clone(),
            stroke: style::mean(colour),
            ..Line::default()
        })
    };
    let mut layers = vec![
        reference(Direction::Horizontal, 0.0),
        Layer::Band(Band {
            x: x.clone(),
            low: low.clone(),
            high: high.clone(),
            colour,
            name: None,
        }),
        outline(&low),
        outline(&high),
        Layer::Line(close),
    ];
    let gap_v = Some(gap_v).filter(|gap_v| *gap_v > NAMED_GAP * acting.max_v);
    layers.extend(gap_v.map(|at| reference(Direction::Vertical, at)));
    let mut lines = extremes(acting, low[PIECES], high[PIECES]);
    lines.extend(gap_v.map(|gap_v| format!("dead zone: {gap_v:.2} V")));
    let beside = acting.max_v < BESIDE * axis_v;
    let place = match beside {
        true => TextPlace::Over((acting.max_v + axis_v) / 2.0, (low[PIECES] + high[PIECES]) / 2.0),
        false => TextPlace::EmptiestCorner,
    };
    layers.push(Layer::Text(Text { lines, place }));
    layers
}

fn reference(direction: Direction, at: f64) -> Layer {
    let stroke = style::reference().dashed(Dash::Dotted);
    Layer::Reference(Reference { direction, at, label: None, stroke, name: None })
}

/// What the mode reaches, in words.
fn extremes(acting: &Acting, low_n: f64, high_n: f64) -> Vec<String> {
    match (acting.shares.0 < 0.0, acting.shares.1 > 0.0) {
        (true, true) => vec![format!("motor: ±{high_n:.2} N")],
        (false, _) => vec![format!("brake: 0 … {high_n:.1} N")],
        (true, false) => {
            vec![format!("brake: 0 … −{:.1} N,", -low_n), "against the return".to_owned()]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about() -> About {
        let study = zwidth_testing::study();
        About::of(&study)
    }

    fn figure(sources: &[Source]) -> Figure {
        rendering_range(&about(), &Calibration::thesis(), "from the thesis", sources).unwrap()
    }

    /// Least and largest force of a panel, and the voltage from which on there is an area.
    fn check(panel: usize, low_n: f64, high_n: f64, from_v: f64) {
        let figure = figure(&[]);
        let band = |layer: &Layer| if let Layer::Band(b) = layer { Some(b.clone()) } else { None };
        let band = figure.panels[panel].layers.iter().find_map(band).unwrap();
        let least = band.low.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = band.high.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(
            (least - low_n).abs() < 1e-9 && (largest - high_n).abs() < 1e-9,
            "{panel}: {least} {largest}"
        );
        assert!((band.x[0] - from_v).abs() < 1e-12, "{panel}: from {} V", band.x[0]);
    }

    /// The thesis' §5.1: 4.16 N at 16 V, 2.08 N at 8 V, 13 N from the brake, which begins at 1 V.
    #[test]
    fn the_areas_end_at_the_forces_of_the_modes_own_voltages() {
        check(0, -4.16, 4.16, 0.0);
        check(1, 0.0, 13.0, 1.0);
        check(2, 0.0, 13.0, 1.0);
        check(3, -4.16, 4.16, 0.0);
        check(4, -13.0, 0.0, 1.0);
        check(5, -2.08, 2.08, 0.0);
    }

    #[test]
    fn the_gap_of_the_brake_is_named_and_the_motor_has_none() {
        let named: Vec<bool> = figure(&[])
            .panels
            .iter()
            .map(|p| p.layers.iter().any(|l| matches!(l, Layer::Text(t) if t.lines.iter().any(|line| line.starts_with("dead zone")))))
            .collect();
        assert_eq!(named, [false, true, true, false, true, false]);
    }

    #[test]
    fn a_calibration_of_simulated_sweeps_marks_the_figure() {
        assert!(figure(&[Source::Recorded, Source::Twin]).mark.is_some());
        assert!(figure(&[]).mark.is_none(), "the thesis' own numbers are no data of a twin");
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
