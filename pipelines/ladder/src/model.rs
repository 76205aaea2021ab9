//! The family of models: a scene with any set of the eight terms, at a point of the parameters.
//!
//! Without sampling, delay and sensors, the environment's law acts at every instant, and `exact`
//! runs the scene as it is. With any of them, a controller acts at ticks, and its command is held
//! ([`zwidth_dynamics::HeldScene`]). Without sampling the ticks are a small part of a period, and a
//! delay is shortened by half a tick, because the hold itself delays by that much.

use crate::ranges::Point;
use zwidth_device::Velocity;
use zwidth_dynamics::{Brake, Finger, FingerLaw, Friction, Gravity, ModelScene, Motor, Plant};
use zwidth_results::{LadderTerm, TermSet};

/// Distance of the weight's centre from the axis, m: assumed.
const WEIGHT_RADIUS_M: f64 = 0.04;
/// L_F0, m (thesis Table 3).
const FINGER_LENGTH_M: f64 = 0.006;

/// The digital loop of a scene: the numbers of its terms besides the twin's.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// T: the controller's period, s.
    pub period_s: f64,
    /// The velocity filter at its beginning, used where there are sensors.
    pub velocity: Velocity,
}

/// A model of the family.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub(crate) scene: ModelScene,
    pub(crate) set: TermSet,
    /// The delay of a command, s; 0 without the term.
    pub(crate) delay_s: f64,
    pub(crate) noise_n: f64,
    pub(crate) zero_counts: f64,
    pub(crate) seed: u64,
}

/// A scene's model with a set of terms at a point. What a scene gives itself is scaled as the
/// twin's number is from its default; what it does not give is the twin's.
pub(crate) fn model(base: &ModelScene, set: TermSet, point: &Point, period_s: f64) -> Model {
    let usual = Point::usual();
    let mut scene = ModelScene { plant: plant(base, point, &usual), ..base.clone() };
    scene.friction = set.has(LadderTerm::Friction).then(|| friction(base, point, &usual));
    scene.finger = set.has(LadderTerm::Finger).then(|| finger(base, point, &usual));
    let lag_s = set.has(LadderTerm::MotorLag).then(|| {
        let [value, default] =
            [&point.twin, &usual.twin].map(|twin| twin.inductance_h / twin.resistance_ohm);
        scaled(base.motor.lag_s, value, default)
    });
    scene.motor = Motor { lag_s, ..base.motor };
    let lag_on_off_s = set.has(LadderTerm::BrakeLag).then(|| {
        let own = base.brake.lag_on_off_s;
        let (twin, usual) = (&point.twin, &usual.twin);
        [
            scaled(own.map(|[on, _]| on), twin.brake_on_s, usual.brake_on_s),
            scaled(own.map(|[_, off]| off), twin.brake_off_s, usual.brake_off_s),
        ]
    });
    scene.brake = Brake { lag_on_off_s, ..base.brake };
    if !set.has(LadderTerm::Gravity) {
        scene.terms.remove("gravity");
    } else if !base.terms.iter().any(|term| term.name() == "gravity") {
        scene.terms.set(Gravity { mass_kg: point.weight_kg, radius_m: WEIGHT_RADIUS_M });
    }
    let delays = set.has(LadderTerm::Delay);
    Model {
        scene,
        set,
        delay_s: if delays { point.delay_periods * period_s } else { 0.0 },
        noise_n: point.twin.force_noise_n,
        zero_counts: point.angle_zero_counts,
        seed: point.seed,
    }
}

/// The scene's own number scaled as the twin's is from its default; the twin's if the scene gives
/// none.
fn scaled(own: Option<f64>, value: f64, default: f64) -> f64 {
    own.map_or(value, |own| own * value / default)
}

/// L scaled, and the mass so that the moment of inertia is scaled as the twin's.
fn plant(base: &ModelScene, point: &Point, usual: &Point) -> Plant {
    let lever = point.twin.lever_m / usual.twin.lever_m;
    let inertia = point.twin.plant(None).inertia_kg_m2 / usual.twin.plant(None).inertia_kg_m2;
    Plant {
        mass_kg: base.plant.mass_kg * inertia / (lever * lever),
        lever_m: base.plant.lever_m * lever,
        ..base.plant
    }
}

fn friction(base: &ModelScene, point: &Point, usual: &Point) -> Friction {
    let (twin, usual) = (&point.twin, &usual.twin);
    let own = base.friction;
    let static_n = scaled(own.map(|f| f.static_n), twin.friction_static_n, usual.friction_static_n);
    // Dry friction in motion is kept as a share of that at rest, as the twin has it.
    let share = own.filter(|f| f.static_n > 0.0).map(|f| f.kinetic_n / f.static_n);
    // Scaled, the share may exceed 1, but dry friction in motion is never above that at rest.
    let share = scaled(share, twin.friction_kinetic_share, usual.friction_kinetic_share).min(1.0);
    let winding = twin.plant(None).back_emf_ns_per_rad.unwrap_or(0.0);
    let viscous = own.map(|f| f.viscous_ns_per_rad);
    Friction {
        static_n,
        kinetic_n: share * static_n,
        viscous_ns_per_rad: match viscous {
            Some(own) => own * twin.friction_viscous_ns_per_rad / usual.friction_viscous_ns_per_rad,
            // The twin's closed winding damps besides; a scene's own number has it already.
            None => twin.friction_viscous_ns_per_rad + winding,
        },
    }
}

fn finger(base: &ModelScene, point: &Point, usual: &Point) -> Finger {
    let own = base.finger;
    Finger {
        law: own.map_or(FingerLaw::Consistent, |f| f.law),
        mass_kg: scaled(own.map(|f| f.mass_kg), point.finger_mass_kg, usual.finger_mass_kg),
        stiffness_n_per_m: scaled(
            own.map(|f| f.stiffness_n_per_m),
            point.finger_stiffness_n_per_m,
            usual.finger_stiffness_n_per_m,
        ),
        damping_ns_per_m: scaled(
            own.map(|f| f.damping_ns_per_m),
            point.finger_damping_ns_per_m,
            usual.finger_damping_ns_per_m,
        ),
        length_m: own.map_or(Some(FINGER_LENGTH_M), |f| f.length_m),
    }
}
