//! Figures 4 and 5: the model as a chain of masses, springs and dampers along a straight line, and
//! the forces on each of its masses.

use super::model::{Body, FORCE, MASS, Modelled};
use crate::FigureKind;
use crate::schematic::sketch::{
    Block, Point, Way, amid, arrow, damper, ground, line, over, panel, right_of, spring,
};
use zwidth_draw::style;
use zwidth_draw::{Cell, Figure, Layer};

/// The figure [`model`].
pub(crate) const MODEL: FigureKind = FigureKind::new(
    "schematic.model",
    "the model as a chain of masses, springs and dampers",
    "scene",
);
/// The figure [`model_forces`].
pub(crate) const MODEL_FORCES: FigureKind =
    FigureKind::new("schematic.model_forces", "the forces on each mass of the model", "scene");

/// Corners of the drawings, mm.
const CHAIN: [Point; 2] = [(0.0, 0.0), (83.5, 35.0)];
const FORCES: [Point; 2] = [(0.0, 0.0), (83.5, 27.5)];
/// Where the chain begins, and its middle line, mm.
const WALL: Point = (4.0, 22.0);
/// Length of a spring, and how far it and the damper stand off the middle, mm.
const SPRING_MM: f64 = 20.0;
const OFF_MM: f64 = 4.5;
/// Width and height of a mass, mm.
const MASS_MM: (f64, f64) = (12.0, 16.0);
/// Length of an arrow of a force, mm.
const ARROW_MM: f64 = 12.0;
/// Heights of the arrows of x1 and x2, mm.
const PLACES: [(&str, f64); 2] = [("*x*_{1}", 5.5), ("*x*_{2}", 2.0)];

/// The model as a chain: wall, rendered object, finger where the scene has one, and the user's
/// force (thesis (1) to (4)).
pub(crate) fn model(modelled: &Modelled) -> Figure {
    let bodies: Vec<Body> = [modelled.object()].into_iter().chain(modelled.finger()).collect();
    let pitch = SPRING_MM + MASS_MM.0;
    let wall = Way::through([(WALL.0, WALL.1 + 9.0), (WALL.0, WALL.1 - 9.0)]);
    let mut layers = ground(&wall, style::mean(style::INK));
    for (i, body) in bodies.iter().enumerate() {
        let from = WALL.0 + i as f64 * pitch;
        let to = from + SPRING_MM;
        // Spring and damper side by side, and the mass at their end.
        let [upper, lower] =
            [OFF_MM, -OFF_MM].map(|off| Way::through([(from, WALL.1 + off), (to, WALL.1 + off)]));
        layers.push(spring(&upper, body.pen));
        layers.extend(damper(&lower, body.pen));
        let middle = f64::midpoint(from, to);
        layers.push(over(body.stiffness.line(), (middle, WALL.1 + OFF_MM + 2.0)));
        layers.push(amid(vec![body.damping.line()], (middle, WALL.1 - OFF_MM - 5.0)));
        layers.extend(mass(body, (to + MASS_MM.0 / 2.0, WALL.1)).layers());
        // There are two bodies at most, object and finger.
        let (symbol, height) = PLACES[i];
        layers.extend(place(symbol, height, from + pitch - MASS_MM.0 / 2.0));
    }
    let end = WALL.0 + bodies.len() as f64 * pitch;
    let push = Way::through([(end + ARROW_MM, WALL.1), (end, WALL.1)]);
    layers.extend(arrow(&push, FORCE));
    layers.push(over("*F*_{ex}", (end + ARROW_MM / 2.0 + 1.0, WALL.1)));
    let notes = [format!(
        "*K*_{{O}} and *B*_{{O}} hold at the end of a lever of {}: *x*_{{1}} is *L* *θ*.{}",
        modelled.lever().line(),
        modelled.pressed(),
    )];
    // In the middle, also where there is no finger.
    let aside = (2 - bodies.len()) as f64 * pitch / 2.0;
    let [low, high] = CHAIN.map(|(x, y)| (x - aside, y));
    let panel = panel(Cell::at(0, 0), low, high, layers);
    let finger = match modelled.scene.finger {
        Some(_) => ", then the finger's spring, damper and mass",
        None => "",
    };
    let description = format!(
        "From a wall on: the rendered object's spring and damper side by side, its mass{finger}; \
         the user's force pushes towards the wall."
    );
    modelled.figure("The model as a chain", &description, vec![panel], notes)
}

fn mass(body: &Body, at: Point) -> Block {
    Block::new(at, MASS_MM, body.mass.lines()).coloured(MASS)
}

/// How far a mass is from the wall.
fn place(symbol: &str, height: f64, x: f64) -> Vec<Layer> {
    let pen = style::single(style::GREY);
    let mut layers = arrow(&Way::through([(WALL.0, height), (x, height)]), pen);
    layers.push(line([(WALL.0, height - 1.2), (WALL.0, height + 1.2)], pen));
    layers.push(line([(x, height), (x, WALL.1 - MASS_MM.1 / 2.0)], style::reference()));
    layers.push(right_of(vec![symbol.to_owned()], (x, height)));
    layers
}

/// The forces on each mass of the chain, and what they come to.
pub(crate) fn model_forces(modelled: &Modelled) -> Figure {
    // Each mass with its place, the forces from the wall's side and from the user's, and its equation.
    let object = modelled.object();
    let bodies = match modelled.finger() {
        Some(finger) => vec![
            (object, 21.0, ["*F*_{O}", "*F*_{F}"], "*M*_{O} *ẍ*_{1} = *F*_{O} − *F*_{F}"),
            (finger, 62.5, ["*F*_{F}", "*F*_{ex}"], "*M*_{F} *ẍ*_{2} = *F*_{F} − *F*_{ex}"),
        ],
        None => {
            vec![(object, 41.7, ["*F*_{O}", "*F*_{ex}"], "*M*_{O} *ẍ*_{1} = *F*_{O} − *F*_{ex}")]
        }
    };
    let mut layers = Vec::new();
    for (body, x, [wall, user], equation) in bodies {
        let block = mass(&body, (x, 18.0));
        layers.extend(block.layers());
        for (edge, out, symbol) in
            [(block.left(), -ARROW_MM, wall), (block.right(), ARROW_MM, user)]
        {
            layers.extend(arrow(&Way::through([(edge.0 + out, edge.1), edge]), FORCE));
            layers.push(over(symbol, (edge.0 + out / 2.0, edge.1)));
        }
        layers.push(amid(vec![equation.to_owned()], (x, 4.0)));
    }
    let notes = [
        "*F*_{O}: motor or brake, up to what they have. Lengths count from the wall on; every arrow \
         shows a force above 0."
            .to_owned(),
    ];
    let panel = panel(Cell::at(0, 0), FORCES[0], FORCES[1], layers);
    let description = "Each mass alone with the forces on it: what is towards the wall pushes it away \
                       from the wall, what is behind it pushes it there.";
    modelled.figure("The forces on each mass", description, vec![panel], notes)
}
