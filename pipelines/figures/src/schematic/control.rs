//! Figures 6 and 7: what goes into a step of the model and what comes out, with the force given and
//! with the motion given.

use super::model::Modelled;
use crate::FigureKind;
use crate::schematic::sketch::{Block, Point, flow, over, panel, right_of};
use crate::words::plain;
use zwidth_draw::style;
use zwidth_draw::{Cell, Figure, Layer};
use zwidth_dynamics::solver_label;

/// The figure [`force_control`].
pub(crate) const FORCE_CONTROL: FigureKind =
    FigureKind::new("schematic.force_control", "a step of the model with the force given", "scene");
/// The figure [`displacement_control`].
pub(crate) const DISPLACEMENT_CONTROL: FigureKind = FigureKind::new(
    "schematic.displacement_control",
    "a step of the model with the motion given",
    "scene",
);

/// Corners of the drawings, mm.
const FORCE: [Point; 2] = [(0.0, 0.0), (83.5, 36.0)];
const DISPLACEMENT: [Point; 2] = [(0.0, 8.0), (83.5, 27.0)];
/// Height of the boxes' middle, and their height, mm.
const ROW_MM: f64 = 18.0;
const HIGH_MM: f64 = 13.0;
/// Where a step leads back to, mm.
const BACK_MM: f64 = 5.0;

/// A line from one box to the next, with words over it.
fn between(from: &Block, to: &Block, words: &str) -> Vec<Layer> {
    let mut layers = flow([from.right(), to.left()]);
    let middle = f64::midpoint(from.right().0, to.left().0) - 0.6;
    layers.push(over(words, (middle, from.right().1)));
    layers
}

fn block(x: f64, width: f64, lines: impl IntoIterator<Item = String>) -> Block {
    Block::new((x, ROW_MM), (width, HIGH_MM), lines)
}

/// The box of the forces: of the object, and of the finger where the scene has one.
fn forces(modelled: &Modelled, x: f64) -> Block {
    let finger = modelled.scene.finger.map(|_| "finger: *F*_{F}");
    let lines = ["object: *F*_{O}"].into_iter().chain(finger).map(str::to_owned);
    block(x, 20.0, lines).coloured(style::BRAKE)
}

fn equations(x: f64) -> Block {
    block(x, 18.0, ["equations of motion".to_owned()])
}

/// Forces that go into the equations of motion.
fn both_forces(modelled: &Modelled) -> &'static str {
    if modelled.scene.finger.is_some() { "*F*_{O}, *F*_{F}" } else { "*F*_{O}" }
}

/// What a state is made of.
fn state(modelled: &Modelled) -> &'static str {
    match modelled.scene.finger {
        Some(_) => "*x*_{1}, *ẋ*_{1}, *x*_{2}, *ẋ*_{2}",
        None => "*x*_{1}, *ẋ*_{1}",
    }
}

/// The loop that is solved: the forces depend on the state of the step before, and so does what
/// comes out (thesis §2.3).
pub(crate) fn force_control(modelled: &Modelled) -> Figure {
    let forces = forces(modelled, 11.0);
    let equations = equations(43.0);
    let step = block(66.5, 15.0, ["one step".to_owned(), modelled.step().line()]);
    let step = step.coloured(style::FINGER);
    let mut layers: Vec<Layer> = [&forces, &equations, &step].map(Block::layers).concat();
    layers.extend(between(&forces, &equations, both_forces(modelled)));
    layers.extend(between(&equations, &step, "*ẍ*"));
    let top = equations.top();
    let out = step.right();
    layers.extend(flow([(top.0, top.1 + 10.0), top]));
    layers.push(right_of(vec!["*F*_{ex}, given".to_owned()], (top.0, top.1 + 6.5)));
    let corner = (out.0 + 2.8, out.1);
    let back = [corner, (corner.0, BACK_MM), (forces.at.0, BACK_MM), forces.bottom()];
    layers.extend(flow([out, (83.0, out.1)]));
    layers.extend(flow(back));
    let words = format!("{} of the step before", state(modelled));
    layers.push(over(words, (f64::midpoint(forces.at.0, corner.0), BACK_MM - 0.6)));
    let panel = panel(Cell::at(0, 0), FORCE[0], FORCE[1], layers);
    let notes =
        [format!("Solver: {}. *x*_{{1}} = *L* *θ*.", plain(solver_label(&modelled.solver)))];
    let description = "A loop: the forces of object and finger and the given user's force go into \
                       the equations of motion, these into one step, and its state back into the \
                       forces.";
    modelled.figure("Force control: the force is given", description, vec![panel], notes)
}

/// Without a loop: where the motion is given, the forces follow from it at once.
pub(crate) fn displacement_control(modelled: &Modelled) -> Figure {
    let forces = forces(modelled, 31.0);
    let equations = equations(65.0);
    let mut layers: Vec<Layer> = [&forces, &equations].map(Block::layers).concat();
    let from = forces.left();
    let out = equations.right();
    layers.extend(flow([(1.0, from.1), from]));
    layers.push(over(state(modelled), (10.0, from.1)));
    layers.extend(between(&forces, &equations, both_forces(modelled)));
    layers.extend(flow([out, (83.0, out.1)]));
    layers.push(over("*F*_{ex}", (f64::midpoint(out.0, 83.0) - 0.5, out.1)));
    let panel = panel(Cell::at(0, 0), DISPLACEMENT[0], DISPLACEMENT[1], layers);
    let notes =
        ["The motion is given: what comes out depends on nothing else, and there is no step."
            .to_owned()];
    let description = "A chain: the given motion goes into the forces of object and finger, these \
                       into the equations of motion, and out comes the user's force.";
    modelled.figure("Displacement control: the motion is given", description, vec![panel], notes)
}
