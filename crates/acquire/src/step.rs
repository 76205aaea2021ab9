//! What a person must do before a step of the device check, in words.

use zwidth_device::check::Step;

/// What the person must do, and whether the lever will then move by itself: that needs a consent.
pub fn step_words(step: Step) -> (String, bool) {
    match step {
        Step::Rest => ("Lever against its lower stop, hands off.".to_owned(), false),
        Step::Load(mass_kg) => (
            format!("Hang {mass_kg} kg from the load cell so that it pulls towards the wall, and let it hang still."),
            false,
        ),
        Step::Hand => (
            "Lever against its lower stop. Once this begins, move it all the way to the upper stop and back, within 4 s.".to_owned(),
            false,
        ),
        Step::Actuators => (
            "Lever against its lower stop, hands off: motor and brake are switched on for a moment, and the lever moves.".to_owned(),
            true,
        ),
    }
}
