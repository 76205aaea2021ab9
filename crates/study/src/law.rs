//! Which actuator gives the force when: the one list of laws of a mode.

use crate::words::words;

words! {
    /// One of the two actuators.
    ActuatorKind {
        /// The motor: it resists and pushes.
        Motor = "motor",
        /// The brake: it resists.
        Brake = "brake",
    }

    /// Which actuator is in charge, by the way that the lever goes (thesis §5.2.2). A mode that
    /// does not name its law has the first one that uses its actuators.
    ModeLaw {
        /// The motor on both ways.
        Active = "active",
        /// The brake on both ways.
        Passive = "passive",
        /// The brake while compressing, the motor while holding and releasing.
        Hybrid = "hybrid",
    }
}

impl ModeLaw {
    /// Who is in charge while the lever goes forward (compressing), and while it holds or goes
    /// back.
    pub const fn drives(self) -> [ActuatorKind; 2] {
        match self {
            Self::Active => [ActuatorKind::Motor, ActuatorKind::Motor],
            Self::Passive => [ActuatorKind::Brake, ActuatorKind::Brake],
            Self::Hybrid => [ActuatorKind::Brake, ActuatorKind::Motor],
        }
    }

    /// Whether it uses an actuator.
    pub fn uses(self, drive: ActuatorKind) -> bool {
        self.drives().contains(&drive)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Levels, Mode};

    fn mode(motor_max_v: Option<f64>, brake_max_v: Option<f64>) -> Mode {
        let (id, label) = ("m".parse().unwrap(), String::new());
        Mode { id, label, motor_max_v, brake_max_v, law: None, factors: Levels::new() }
    }

    #[test]
    fn a_mode_that_names_no_law_has_that_of_its_actuators() {
        assert_eq!(mode(Some(16.0), None).law(), Some(ModeLaw::Active));
        assert_eq!(mode(None, Some(8.0)).law(), Some(ModeLaw::Passive));
        assert_eq!(mode(Some(8.0), Some(8.0)).law(), Some(ModeLaw::Hybrid));
        assert_eq!(mode(Some(8.0), Some(0.0)).law(), Some(ModeLaw::Active));
        assert_eq!(mode(None, Some(0.0)).law(), None);
    }
}
