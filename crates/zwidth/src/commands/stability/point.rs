//! The device and the wall that a command names.

use super::super::impedance::{bare, count_m};
use super::args::StabilityArgs;
use anyhow::Context as _;
use zwidth_device::TwinParameters;
use zwidth_dynamics::{DryLimits, ModelScene};
use zwidth_stability::{Point, of_scene};

/// T: the thesis' controller, s (Table 3).
const PERIOD_S: f64 = 0.0083;

/// The name of the point in files, and the point.
pub(super) fn from_args(command: &StabilityArgs) -> anyhow::Result<(String, Point)> {
    let (name, point) = match &command.scene {
        Some(path) => {
            let text = crate::text::scene(path)?;
            let scene = ModelScene::from_toml(&text).with_context(|| path.display().to_string())?;
            (super::super::simulate::stem(path), of_scene(&scene, PERIOD_S))
        }
        None => ("twin".to_owned(), twin()),
    };
    // In the order of the command line: of one quantity the last value counts.
    let with =
        command.at.iter().fold(point, |point, (quantity, value)| point.with(*quantity, *value));
    Ok((name, with))
}

/// The simulated device, whose closed winding damps; its friction and its counts for the formulas
/// that ask for them.
fn twin() -> Point {
    let twin = TwinParameters::default();
    let lever_m = twin.lever_m;
    let dry = DryLimits {
        friction_n: twin.friction_static_n * twin.friction_kinetic_share,
        count_m: count_m(lever_m),
    };
    Point { wall: bare(&twin, PERIOD_S), lever_m, step_s: PERIOD_S, dry: Some(dry) }
}
