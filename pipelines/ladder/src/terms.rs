//! The terms that a scene can have, and those for which it gives numbers.

use zwidth_dynamics::ModelScene;
use zwidth_results::{LadderTerm, TermSet};

/// The terms that a scene can have: a finger only if something is between hand and lever, a
/// lag only of an actuator that its mode uses. A scene without the part cannot need the term.
pub fn possible(scene: &ModelScene) -> TermSet {
    let by_motor = scene.mode.by_motor();
    let mut set = TermSet::ALL;
    if scene.finger.is_none() {
        set = set.without(LadderTerm::Finger);
    }
    if !by_motor.contains(&true) {
        set = set.without(LadderTerm::MotorLag);
    }
    if !by_motor.contains(&false) {
        set = set.without(LadderTerm::BrakeLag);
    }
    set
}

/// The terms whose numbers a scene gives, and those of the digital loop, which has the period
/// that the settings give. The numbers of the others are the simulated device's.
pub(crate) fn in_scene(scene: &ModelScene) -> TermSet {
    let terms = TermSet::ALL.terms().filter(|term| match term {
        LadderTerm::Gravity => scene.terms.iter().any(|term| term.name() == "gravity"),
        LadderTerm::Finger => scene.finger.is_some(),
        LadderTerm::Friction => scene.friction.is_some(),
        LadderTerm::MotorLag => scene.motor.lag_s.is_some(),
        LadderTerm::BrakeLag => scene.brake.lag_on_off_s.is_some(),
        LadderTerm::Sampling | LadderTerm::Delay | LadderTerm::Sensors => true,
    });
    terms.fold(TermSet::NONE, TermSet::with)
}
