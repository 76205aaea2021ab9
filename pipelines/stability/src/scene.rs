//! A scene's device and spring as a sampled wall.

use crate::quantity::Point;
use zwidth_dynamics::{Demand, ModelScene, RidingFinger, SampledWall};

/// The spring that a scene begins with, on its plant: at the lever's end, and with the controller's
/// period. Dry friction, actuators' limits, stops and terms are left out; a wall that is all the
/// actuators have has no stiffness.
pub fn of_scene(scene: &ModelScene, period_s: f64) -> Point {
    let lever_m = scene.plant.lever_m;
    let spring = scene.environment.zones.iter().find_map(|zone| match zone.demand {
        Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, .. } => {
            Some([stiffness_n_per_rad, damping_ns_per_rad])
        }
        _ => None,
    });
    let [stiffness, damping] = spring.unwrap_or_default().map(|per_rad| per_rad / lever_m);
    let viscous = scene.friction.map_or(0.0, |friction| friction.viscous_ns_per_rad);
    let finger = scene.finger.map(|finger| RidingFinger {
        mass_kg: finger.mass_kg,
        stiffness_n_per_m: finger.stiffness_n_per_m,
        damping_ns_per_m: finger.damping_ns_per_m,
    });
    let wall = SampledWall {
        stiffness_n_per_m: stiffness,
        wall_damping_ns_per_m: damping,
        motor_lag_s: scene.motor.lag_s,
        finger,
        ..SampledWall::bare(scene.plant.mass_kg, viscous / lever_m, period_s)
    };
    Point { wall, lever_m, step_s: scene.step_s, dry: None }
}
