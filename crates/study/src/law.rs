//! Which actuator gives the force when: the one list of laws of a mode.

use serde::{Deserialize, Serialize};

/// One of the two actuators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActuatorKind {
    /// The motor: it resists and pushes.
    Motor,
    /// The brake: it resists.
    Brake,
}

/// Which actuator is in charge, by the way that the lever goes (thesis §5.2.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModeLaw {
    /// The motor on both ways.
    Active,
    /// The brake on both ways.
    Passive,
    /// The brake while compressing, the motor while holding and releasing.
    Hybrid,
}

impl ActuatorKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Motor, Self::Brake];

    /// Its word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Motor => "motor",
            Self::Brake => "brake",
        }
    }
}

impl ModeLaw {
    /// Every law. A mode that does not name its law has the first one that uses its actuators.
    pub const ALL: [Self; 3] = [Self::Active, Self::Passive, Self::Hybrid];

    /// Who is in charge while the lever goes forward (compressing), and while it holds or goes
    /// back.
    pub const fn drives(self) -> [ActuatorKind; 2] {
        match self {
            Self::Active => [ActuatorKind::Motor, ActuatorKind::Motor],
            Self::Passive => [ActuatorKind::Brake, ActuatorKind::Brake],
            Self::Hybrid => [ActuatorKind::Brake, ActuatorKind::Motor],
        }
    }

    /// Its word in `study.toml`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Active => "active",
            Self::Passive => "passive",
            Self::Hybrid => "hybrid",
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
    use crate::Mode;

    fn mode(motor_max_v: Option<f64>, brake_max_v: Option<f64>) -> Mode {
        let (id, label) = ("m".parse().unwrap(), String::new());
        Mode { id, label, motor_max_v, brake_max_v, law: None }
    }

    #[test]
    fn a_mode_that_names_no_law_has_that_of_its_actuators() {
        assert_eq!(mode(Some(16.0), None).law(), Some(ModeLaw::Active));
        assert_eq!(mode(None, Some(8.0)).law(), Some(ModeLaw::Passive));
        assert_eq!(mode(Some(8.0), Some(8.0)).law(), Some(ModeLaw::Hybrid));
        assert_eq!(mode(Some(8.0), Some(0.0)).law(), Some(ModeLaw::Active));
        assert_eq!(mode(None, Some(0.0)).law(), None);
    }

    #[test]
    fn every_law_has_one_word_in_files_and_in_code() {
        for law in ModeLaw::ALL {
            assert_eq!(serde_json::to_string(&law).unwrap(), format!("\"{}\"", law.as_str()));
        }
    }
}
