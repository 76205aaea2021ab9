//! Schematics of model, device and control (thesis 4–7, 9, 10, 20, 21, 32), drawn from what was
//! planned: each is a pure function from the study's own numbers to a figure.

mod chain;
mod control;
mod control_loop;
mod device;
pub(crate) mod environment;
mod lever_model;
mod model;
mod setup;
pub(crate) mod sketch;
#[cfg(test)]
mod tests;
mod translation;

pub use environment::{ENVIRONMENT, Placement, environment};

use chain::{MODEL, MODEL_FORCES, model, model_forces};
use control::{DISPLACEMENT_CONTROL, FORCE_CONTROL, displacement_control, force_control};
use control_loop::{CONTROL_LOOP, control_loop};
use device::{DEVICE, device};
use lever_model::{LEVER_MODEL, LEVER_MODEL_FORCES, lever_model, lever_model_forces};
use translation::{TRANSLATION, translation};

pub use model::Modelled;

use crate::FigureKind;
use zwidth_draw::Figure;
use zwidth_study::Setup;

/// A schematic of the model.
pub type OfModel = fn(&Modelled) -> Figure;
/// A schematic of the device, where the study's lends itself to it.
pub type OfDevice = fn(&Setup) -> Option<Figure>;

/// The schematics of a scene of the model.
pub const OF_MODEL: [(FigureKind, OfModel); 6] = [
    (MODEL, model),
    (MODEL_FORCES, model_forces),
    (FORCE_CONTROL, force_control),
    (DISPLACEMENT_CONTROL, displacement_control),
    (LEVER_MODEL, lever_model),
    (LEVER_MODEL_FORCES, lever_model_forces),
];

/// The schematics of the device and of its control.
pub const OF_DEVICE: [(FigureKind, OfDevice); 3] = [
    (DEVICE, device),
    (TRANSLATION, translation),
    (CONTROL_LOOP, |setup| Some(control_loop(setup))),
];
