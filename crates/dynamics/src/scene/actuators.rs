//! The two actuators and the three ways of using them.

use serde::{Deserialize, Serialize};

use super::numbers;
use crate::error::{Result, finite, not_negative, positive};

/// Which actuators render the environment (§5.2.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveMode {
    /// The motor alone, in both directions.
    Active,
    /// The brake alone: it resists in both directions and drives in none.
    Passive,
    /// The brake while compressing (θ̇ > 0), the motor while holding or releasing (θ̇ ≤ 0).
    Hybrid,
}

impl DriveMode {
    /// Every mode.
    pub const ALL: [Self; 3] = [Self::Active, Self::Passive, Self::Hybrid];

    /// Whether the motor is in charge, not the brake: while compressing, and while holding or
    /// releasing.
    pub const fn by_motor(self) -> [bool; 2] {
        match self {
            Self::Active => [true, true],
            Self::Passive => [false, false],
            Self::Hybrid => [false, true],
        }
    }

    /// Its word in scene files and tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Active => "active",
            Self::Passive => "passive",
            Self::Hybrid => "hybrid",
        }
    }

    /// Whether the motor takes over from the brake when the lever no longer goes forward.
    pub(crate) fn takes_over(self) -> bool {
        self.by_motor() == [false, true]
    }
}

/// A DC motor as a force at the lever's end: −clamp(u, −max, max), behind its electrical lag if it
/// has one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Largest force F_m, N.
    pub max_n: f64,
    /// Electrical time constant L/R, s; the force follows its command as τ Ḟ = F_cmd − F.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
}

impl Motor {
    /// Adds name, value and usual size of each parameter.
    pub(crate) fn list(&self, list: &mut Vec<(&'static str, f64, f64)>) {
        list.push(("motor.max_n", self.max_n, numbers::MOTOR_N));
        list.extend(self.lag_s.map(|lag| ("motor.lag_s", lag, numbers::STEP_S)));
    }

    pub(crate) fn check(&self) -> Result<()> {
        not_negative("motor.max_n", self.max_n)?;
        self.lag_s.map_or(Ok(()), |lag| positive("motor.lag_s", lag))
    }
}

/// How the brake's force depends on the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BrakeLaw {
    /// F ∈ −level · Sgn(θ̇): any value in [−level, level] at rest. It never adds energy.
    Coulomb,
    /// The thesis' (8): −clamp(u, −max, max) while θ̇ > 0, off otherwise. It may add energy.
    Thesis,
}

/// The electromagnetic brake as a force at the lever's end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Brake {
    /// Largest force F_b, N.
    pub max_n: f64,
    /// How the force depends on the motion.
    pub law: BrakeLaw,
    /// Command that is lost before any force appears, N: level = clamp(u − dead zone, 0, max).
    #[serde(default)]
    pub dead_zone_n: f64,
    /// Time constants of engaging and of letting go, s; the level b follows its command as τ ḃ =
    /// b_cmd − b.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_on_off_s: Option<[f64; 2]>,
    /// User force below which a brake that holds may let go, N (§6.2.1); without it the brake
    /// lets go whenever θ̇ ≤ 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub let_go_n: Option<f64>,
}

impl Brake {
    /// Adds name, value and usual size of each parameter.
    pub(crate) fn list(&self, list: &mut Vec<(&'static str, f64, f64)>) {
        list.push(("brake.max_n", self.max_n, numbers::BRAKE_N));
        list.push(("brake.dead_zone_n", self.dead_zone_n, numbers::FORCE_N));
        if let Some([on, off]) = self.lag_on_off_s {
            list.push(("brake.lag_on_off_s[0]", on, numbers::BRAKE_LAGS_S[0]));
            list.push(("brake.lag_on_off_s[1]", off, numbers::BRAKE_LAGS_S[1]));
        }
        list.extend(self.let_go_n.map(|force| ("brake.let_go_n", force, numbers::FORCE_N)));
    }

    pub(crate) fn check(&self) -> Result<()> {
        not_negative("brake.max_n", self.max_n)?;
        not_negative("brake.dead_zone_n", self.dead_zone_n)?;
        if let Some([on, off]) = self.lag_on_off_s {
            positive("brake.lag_on_off_s[0]", on)?;
            positive("brake.lag_on_off_s[1]", off)?;
        }
        self.let_go_n.map_or(Ok(()), |force| finite("brake.let_go_n", force))
    }
}
