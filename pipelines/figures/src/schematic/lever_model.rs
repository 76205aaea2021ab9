//! Figures 9 and 10: the model of the device: a lever with the object at its axis and the finger at
//! its end, and the forces on both.

use super::model::{Body, FORCE, Modelled, Part};
use crate::FigureKind;
use crate::schematic::sketch::{
    Lever, Point, UPRIGHT_MM, Way, amid, arrow, damper, disc, ground, left_of, line, over, panel,
    right_of, spring,
};
use zwidth_draw::style;
use zwidth_draw::{Cell, Figure, Layer};
use zwidth_dynamics::FingerLaw;

/// The figure [`lever_model`].
pub(crate) const LEVER_MODEL: FigureKind = FigureKind::new(
    "schematic.lever_model",
    "the model of the device: lever, object and finger",
    "scene",
);
/// The figure [`lever_model_forces`].
pub(crate) const LEVER_MODEL_FORCES: FigureKind = FigureKind::new(
    "schematic.lever_model_forces",
    "the forces on lever and finger of the model",
    "scene",
);

/// Corners of the drawings, mm.
const WHOLE: [Point; 2] = [(-50.0, -3.5), (33.5, 37.0)];
const FORCES: [Point; 2] = [(-27.0, -12.0), (56.5, 33.5)];
/// The middle of the finger alone, mm.
const AT_MM: Point = (36.0, 23.0);
/// Where the lever's work space ends if the scene does not say, rad.
const STOPS_RAD: [f64; 2] = [-std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_4];
// Distances from the axis, in lengths of the lever.
/// The object's spring and damper, and what they stand against.
const SPRING: f64 = 0.78;
const DAMPER: f64 = 0.56;
const GROUND: (f64, f64) = (0.45, 0.88);
/// The arrows of angle and torque.
const ANGLE: f64 = 0.38;
const TORQUE: f64 = 0.2;
// Lengths along the finger, from the lever's end, mm.
/// The plate at the lever, the near and the far side of the mass, the arrow's two ends.
const FINGER_MM: [f64; 5] = [2.5, 16.5, 25.5, 26.5, 38.0];
/// Half the width of plate and mass, and how far spring and damper stand off the middle.
const PLATE_MM: f64 = 4.5;
const OFF_MM: f64 = 3.0;

/// What the lever's model is drawn of: each part with its number, or by its symbol alone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LeverModel {
    pub(crate) lever: Lever,
    pub(crate) length: Part,
    pub(crate) object: Body,
    pub(crate) finger: Option<Body>,
    /// Upper end of the work space, rad.
    pub(crate) high_rad: f64,
}

impl LeverModel {
    fn of(modelled: &Modelled, length_mm: f64) -> Self {
        let [low, high_rad] = modelled.scene.plant.stops_rad.unwrap_or(STOPS_RAD);
        Self {
            lever: Lever::between(length_mm, low, high_rad),
            length: modelled.lever(),
            object: modelled.object(),
            finger: modelled.finger(),
            high_rad,
        }
    }

    /// Object, lever, finger and the user's force.
    pub(crate) fn layers(&self) -> Vec<Layer> {
        let Self { lever, object, .. } = self;
        // The object's spring and damper, about the axis.
        let [outer, inner] =
            [SPRING, DAMPER].map(|distance| lever.arc(distance, lever.theta_rad, self.high_rad));
        let mut layers = vec![spring(&outer, object.pen)];
        layers.extend(damper(&inner, object.pen));
        layers.extend(ground(&lever.ray(GROUND, self.high_rad), style::mean(style::INK)));
        for (distance, part) in [(SPRING, &object.stiffness), (DAMPER - 0.06, &object.damping)] {
            let (x, y) = lever.at(distance, self.high_rad);
            layers.push(right_of(part.lines(), (x + 3.2, y - 1.8)));
        }
        layers.extend(lever.torque(TORQUE));
        layers.push(line([(0.0, 0.0), lever.at(ANGLE + 0.08, 0.0)], style::reference()));
        layers.extend(lever.angle(ANGLE));
        layers.push(left_of(self.length.lines(), lever.at(0.34, lever.theta_rad)));
        layers.extend(lever.bar());
        // The mass at the lever's end, and what pushes it.
        let (x, y) = lever.tip();
        layers.push(disc((x, y), 8.0, style::GREY));
        layers.push(right_of(vec![object.mass.line()], (x + 0.8, y + 1.8)));
        let along = across(lever, -1.0);
        match &self.finger {
            Some(finger) => layers.extend(finger_layers(finger, &along)),
            None => layers.extend(pushed(&along, 2.0)),
        }
        layers
    }
}

/// From the lever's end across it: towards +θ, or with −1 away from there.
fn across(lever: &Lever, towards: f64) -> Way {
    let (x, y) = lever.tip();
    let theta = lever.theta_rad;
    let unit = (towards * libm::cos(theta), -towards * libm::sin(theta));
    Way::through([(x, y), (x + unit.0, y + unit.1)])
}

/// The user's force along a way, up to so far from its beginning.
fn pushed(along: &Way, to: f64) -> Vec<Layer> {
    let from = to + FINGER_MM[4] - FINGER_MM[3];
    let mut layers = arrow(&Way::through([along.at(from, 0.0), along.at(to, 0.0)]), FORCE);
    layers.push(over("*F*_{ex}", along.at(f64::midpoint(from, to), -0.5)));
    layers
}

/// Plate, spring, damper and mass of the finger, away from the lever, and the user's force on it.
fn finger_layers(finger: &Body, along: &Way) -> Vec<Layer> {
    let [plate, near, far, tip, _] = FINGER_MM;
    let [right, left] =
        [-OFF_MM, OFF_MM].map(|off| Way::through([plate, near].map(|at| along.at(at, off))));
    let mut layers = vec![
        line([along.at(0.0, 0.0), along.at(plate, 0.0)], finger.pen),
        line([along.at(plate, PLATE_MM), along.at(plate, -PLATE_MM)], finger.pen),
        spring(&right, finger.pen),
    ];
    layers.extend(damper(&left, finger.pen));
    layers.extend(slab(finger, along, near, far));
    let middle = f64::midpoint(plate, near);
    layers.push(over(finger.stiffness.line(), along.at(middle - 1.0, -OFF_MM - 2.0)));
    layers.push(amid(vec![finger.damping.line()], along.at(middle + 1.5, OFF_MM + 6.5)));
    layers.extend(pushed(along, tip));
    layers
}

/// A mass across a way, with its words.
fn slab(body: &Body, along: &Way, near: f64, far: f64) -> Vec<Layer> {
    let corners = [(near, 1.0), (far, 1.0), (far, -1.0), (near, -1.0), (near, 1.0)]
        .map(|(at, side)| along.at(at, side * (PLATE_MM + 0.8)));
    let words = amid(body.mass.lines(), along.at(f64::midpoint(near, far), 0.0));
    vec![line(corners, style::mean(style::GREY)), words]
}

/// The model that is solved: the object turns about the lever's axis, the finger rides on its end
/// (thesis (8) to (11)).
pub(crate) fn lever_model(modelled: &Modelled) -> Figure {
    let layers = LeverModel::of(modelled, UPRIGHT_MM).layers();
    let panel = panel(Cell::at(0, 0), WHOLE[0], WHOLE[1], layers);
    let notes = [format!(
        "*θ* = 0 is upright, and *θ* > 0 compresses. *F*_{{ex}}{} square to the lever.{}",
        if modelled.finger().is_some() { " and the finger stay" } else { " stays" },
        modelled.pressed()
    )];
    let finger = if modelled.finger().is_some() { ", at its end the finger" } else { "" };
    let description = format!(
        "A lever on an axis, between it and a stop the rendered object's spring and damper{finger}; \
         the user's force pushes its end."
    );
    modelled.figure("The model of the device", &description, vec![panel], notes)
}

/// The forces on lever and finger, and what they come to.
pub(crate) fn lever_model_forces(modelled: &Modelled) -> Figure {
    let LeverModel { lever, object, finger, .. } = LeverModel::of(modelled, 26.0);
    let (at_end, sign) = if finger.is_some() { ("*F*_{F}", '−') } else { ("*F*_{ex}", '+') };
    let mut layers = lever.torque(0.24);
    layers.push(line([(0.0, 0.0), lever.at(0.52, 0.0)], style::reference()));
    layers.extend(lever.angle(0.42));
    layers.extend(lever.bar());
    let (x, y) = lever.tip();
    layers.push(disc((x, y), 8.0, style::GREY));
    layers.push(left_of(vec![object.mass.line()], lever.at(0.62, lever.theta_rad)));
    layers.extend(from_both_sides(&across(&lever, 1.0), 2.0, [at_end, "*F*_{O} = *T*_{O} / *L*"]));
    let equation = format!("*M*_{{O}} *L* *θ̈* = *F*_{{O}} {sign} {at_end}");
    layers.push(amid(vec![equation], (0.0, -9.5)));
    let alone = finger.zip(modelled.scene.finger.map(|finger| finger.law));
    let (title, more, which, corners) = match &alone {
        Some((finger, law)) => {
            layers.extend(finger_alone(&lever, finger, *law));
            let more = " The finger alone, between the user's force and its tissue.";
            let which = "Forces and *x*_{2} count towards +*θ*: *F*_{O} and *F*_{F} are below 0 while they resist.";
            ("The forces on lever and finger", more, which, FORCES)
        }
        None => {
            let which = "Forces count towards +*θ*: *F*_{O} is below 0 while it resists.";
            ("The forces on the lever", "", which, FORCES.map(|(x, y)| (x - AT_MM.0 / 2.0, y)))
        }
    };
    let notes = [format!("{which} Arrows point as the forces act then, square to the lever.")];
    let panel = panel(Cell::at(0, 0), corners[0], corners[1], layers);
    let description =
        format!("The lever alone, with the torque at its axis and the forces at its end.{more}");
    modelled.figure(title, &description, vec![panel], notes)
}

/// The finger's mass between the user's force and its tissue, and its equation by the scene's law.
fn finger_alone(lever: &Lever, finger: &Body, law: FingerLaw) -> Vec<Layer> {
    let direction = across(lever, 1.0);
    let from = direction.at(0.0, 0.0);
    let to = direction.at(1.0, 0.0);
    let along = Way::through([AT_MM, (AT_MM.0 + to.0 - from.0, AT_MM.1 + to.1 - from.1)]);
    let mut layers = slab(finger, &along, -4.5, 4.5);
    layers.extend(from_both_sides(&along, 4.5, ["*F*_{ex}", "*F*_{F}"]));
    let equation = match law {
        FingerLaw::Thesis => "*M*_{F} *ẍ*_{2} = *F*_{F} + *F*_{ex}",
        FingerLaw::Consistent => "*M*_{F} (*ẍ*_{2} + *L* *θ̈*) = *F*_{F} + *F*_{ex}",
    };
    layers.push(amid(vec![equation.to_owned()], (AT_MM.0, -9.5)));
    layers
}

/// Arrows to a body from behind and from before it along a way, each `off` from its middle.
fn from_both_sides(along: &Way, off: f64, [behind, before]: [&str; 2]) -> Vec<Layer> {
    /// Length of an arrow, mm.
    const LENGTH: f64 = 12.0;
    let mut layers = Vec::new();
    for (side, symbol) in [(-1.0, behind), (1.0, before)] {
        let [far, near] = [off + LENGTH, off].map(|at| along.at(side * at, 0.0));
        layers.extend(arrow(&Way::through([far, near]), FORCE));
        layers.push(over(symbol, along.at(side * (off + 0.6 * LENGTH), 0.5)));
    }
    layers
}
