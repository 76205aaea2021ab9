//! Figure 20: the device from the front and from the side: a lever on a wheel, which is driven by a
//! capstan on the shaft of motor and brake.

use super::setup::{brake, force_sensor, motor, name, words};
use crate::FigureKind;
use crate::schematic::sketch::{
    Block, Lever, Point, Way, amid, arrow, disc, ground, left_of, line, over, panel, polar,
    right_of, ring,
};
use std::f64::consts::{FRAC_PI_2, PI};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Figure, Layer, LegendPlace, TWO_COLUMNS_MM};
use zwidth_study::{ActuatorKind, Setup};

/// The figure [`device`].
pub(crate) const DEVICE: FigureKind =
    FigureKind::new("schematic.device", "the device from the front and from the side", "trial");

/// Corners of each of the two views, mm.
const VIEW: [Point; 2] = [(-42.0, -21.0), (42.0, 37.0)];
/// Length of the lever, radii of wheel and capstan, mm: as seen, not to scale.
const LEVER_MM: f64 = 28.0;
const WHEEL_MM: f64 = 8.0;
const CAPSTAN_MM: f64 = 2.6;
/// Height of the shaft, mm.
const SHAFT_MM: f64 = -13.0;
/// Size of the sensor at the lever's end, mm.
const CELL_MM: f64 = 2.2;

/// The device, drawn from what the study knows of it; `None` without a lever between stops.
pub(crate) fn device(setup: &Setup) -> Option<Figure> {
    let front = front(setup, LEVER_MM, setup.stops_rad()?);
    let front = panel(Cell::at(0, 0), VIEW[0], VIEW[1], front);
    let side = panel(Cell::at(0, 1), VIEW[0], VIEW[1], side(setup));
    Some(Figure {
        title: Some(name(setup)),
        description: "From the front: the lever on its wheel, the user's force at its end, and below \
                      it the capstan on the shaft with the torques of motor and brake. From the side: \
                      the shaft with motor, capstan, brake and angle sensor, above it wheel and lever."
            .to_owned(),
        width_mm: TWO_COLUMNS_MM,
        panels: vec![front.titled("**a**  from the front"), side.titled("**b**  from the side")],
        legend: LegendPlace::Hidden,
        footnotes: vec![
            "Built as the thesis' device: the study knows the numbers, and not how its parts lie. Angles \
             are true, lengths are not to scale. *F*_{ex}: the user's force. *T*_{m}, *T*_{b}: torques of \
             motor and brake on the shaft."
                .to_owned(),
        ],
        ..Figure::default()
    })
}

/// Lever, wheel, capstan, and the forces on them.
pub(crate) fn front(setup: &Setup, length_mm: f64, [low, high]: [f64; 2]) -> Vec<Layer> {
    let lever = Lever::between(length_mm, low, high);
    let mut layers = transmission();
    layers.extend(lever.work_space(words(setup), low, high));
    layers.extend(lever.angle(0.68));
    layers.extend(lever.bar());
    // The force sensor, a box in the lever's end.
    let along = lever.ray((1.0, 1.1), lever.theta_rad);
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
        .map(|(up, left)| along.at(up * CELL_MM - CELL_MM, left * CELL_MM / 1.4));
    layers.push(line(corners, Stroke { width_pt: 1.2, ..style::mean(style::FINGER) }));
    layers.extend(lever.push());
    layers.extend(torques(setup));
    let length =
        setup.device.lever_m.map(|m| zwidth_tables::given(m * 1e3, "mm", setup.coordinate));
    layers.extend(length.map(|length| left_of(vec![length], lever.at(0.47, lever.theta_rad))));
    layers
}

/// The wheel on the lever's axis, the capstan on the shaft, and the cable between them.
fn transmission() -> Vec<Layer> {
    let pen = Stroke { width_pt: 0.9, ..style::mean(style::GREY) };
    let shaft = (0.0, SHAFT_MM);
    // The cable crosses over, so that it touches both at its own sides.
    let lean = libm::acos((WHEEL_MM + CAPSTAN_MM) / SHAFT_MM.abs());
    let cable = [1.0, -1.0].map(|side| {
        let wheel = polar((0.0, 0.0), WHEEL_MM, PI - side * lean);
        let capstan = polar(shaft, CAPSTAN_MM, -side * lean);
        line([wheel, capstan], style::single(style::INK))
    });
    let mut layers = ring((0.0, 0.0), WHEEL_MM, pen).to_vec();
    layers.extend(ring(shaft, CAPSTAN_MM, Stroke { width_pt: 1.4, ..pen }));
    layers.push(disc(shaft, 2.6, style::INK));
    layers.extend(cable);
    layers.push(right_of(vec!["wheel".to_owned()], (WHEEL_MM * 0.85, -6.5)));
    layers
}

/// The torques of motor and brake on the shaft, one to either side.
fn torques(setup: &Setup) -> Vec<Layer> {
    /// Distance of an arrow from the shaft, mm.
    const AROUND: f64 = 5.6;
    /// Half of what it goes round, rad.
    const HALF_RAD: f64 = 0.7;
    let shaft = (0.0, SHAFT_MM);
    let mut layers = Vec::new();
    // Both resist the push, which turns the lever clockwise and the shaft the other way.
    let both = [
        (ActuatorKind::Motor, -1.0, "*T*_{m}", style::MOTOR),
        (ActuatorKind::Brake, 1.0, "*T*_{b}", style::BRAKE),
    ];
    for (_, side, symbol, colour) in both.into_iter().filter(|(drive, ..)| setup.uses(*drive)) {
        let middle = side * FRAC_PI_2;
        let way = Way::arc(shaft, AROUND, middle - HALF_RAD, middle + HALF_RAD);
        layers.extend(arrow(&way, style::mean(colour)));
        let beside = polar(shaft, AROUND, middle);
        let words = vec![symbol.to_owned()];
        layers.push(if side < 0.0 { left_of(words, beside) } else { right_of(words, beside) });
    }
    layers
}

/// The shaft with what sits on it, and the wheel and the lever above.
fn side(setup: &Setup) -> Vec<Layer> {
    /// Both ends of the shaft, mm.
    const SHAFT: [f64; 2] = [-18.5, 38.0];
    let thick = Stroke { width_pt: 2.2, ..style::mean(style::INK) };
    let mut layers = vec![line(SHAFT.map(|x| (x, SHAFT_MM)), thick)];
    if setup.uses(ActuatorKind::Motor) {
        let motor = Block::new((-29.0, SHAFT_MM), (21.0, 13.0), motor(setup));
        layers.extend(motor.coloured(style::MOTOR).layers());
    }
    if setup.uses(ActuatorKind::Brake) {
        // The disc on the shaft, and the magnet that holds it: what runs through the brake is not seen.
        let plate = Stroke { width_pt: 2.8, ..style::mean(style::BRAKE) };
        layers.push(line([(10.0, SHAFT_MM - 6.0), (10.0, SHAFT_MM + 6.0)], plate));
        layers.push(over("disc", (6.4, SHAFT_MM + 1.2)));
        let brake = Block::new((23.0, SHAFT_MM), (21.0, 13.0), brake(setup));
        let hidden = Stroke { width_pt: 4.0, ..style::mean(style::PAPER) };
        layers.push(line([brake.left(), brake.right()], hidden));
        layers.extend(brake.coloured(style::BRAKE).layers());
    }
    layers.extend(Block::new((-6.0, SHAFT_MM), (7.0, 2.0 * CAPSTAN_MM), [""; 0]).layers());
    layers.push(amid(vec!["capstan".to_owned()], (-6.0, SHAFT_MM - 5.2)));
    layers.extend(wheel_and_lever(setup));
    let angle = Block::new((39.0, SHAFT_MM), (3.0, 7.0), [""; 0]).coloured(style::FINGER);
    layers.extend(angle.layers());
    layers.push(left_of(vec!["angle sensor".to_owned()], (41.8, SHAFT_MM + 9.0)));
    layers.push(line([(39.0, SHAFT_MM + 7.4), angle.top()], style::single(style::GREY)));
    layers
}

/// The wheel edge on, above the capstan, and the lever with its sensor.
fn wheel_and_lever(setup: &Setup) -> Vec<Layer> {
    /// Where they stand, mm.
    const X: f64 = -6.0;
    let bar = Stroke { width_pt: 3.2, ..style::mean(style::INK) };
    let wheel = Block::new((X, 0.0), (4.0, 2.0 * WHEEL_MM), [""; 0]);
    let cell = Block::new((X, LEVER_MM - 1.0), (3.4, 4.6), [""; 0]).coloured(style::FINGER);
    let axis = Way::through([(X + 12.0, -3.0), (X + 12.0, 3.0)]);
    let mut layers = wheel.layers();
    // The cable, edge on.
    for x in [X - 1.0, X + 1.0] {
        let cable = [(x, -WHEEL_MM), (x, SHAFT_MM + CAPSTAN_MM)];
        layers.push(line(cable, style::single(style::INK)));
    }
    layers.push(line([(X - 4.0, 0.0), (X + 12.0, 0.0)], style::single(style::INK)));
    layers.extend(ground(&axis, style::mean(style::INK)));
    layers.push(line([(X, 0.0), cell.bottom()], bar));
    layers.extend(cell.layers());
    layers.push(right_of(force_sensor(setup), (X + 2.5, LEVER_MM - 1.0)));
    layers.push(right_of(vec!["lever".to_owned()], (X + 1.0, 16.0)));
    layers.push(left_of(vec!["wheel".to_owned()], (X - 2.5, 6.0)));
    // The push goes away from the reader: a circle with a cross in it, as the feathers of an arrow.
    let x = X - 8.0;
    let y = LEVER_MM - 1.0;
    layers.extend(ring((x, y), 1.7, style::mean(style::INK)));
    for r in [1.2, -1.2] {
        layers.push(line([(x - 1.2, y - r), (x + 1.2, y + r)], style::single(style::INK)));
    }
    layers.push(left_of(vec!["*F*_{ex}".to_owned()], (X - 9.8, LEVER_MM - 1.0)));
    layers
}
