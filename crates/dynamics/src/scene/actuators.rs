//! The two actuators and the three ways of using them.

use serde::{Deserialize, Serialize};

use super::numbers;
use super::parameter::Parameter;
use zwidth_study::worded;

worded! {
    /// Which actuators render the environment (§5.2.2).
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    DriveMode {
        /// The motor alone, in both directions.
        Active = "active",
        /// The brake alone: it resists in both directions and drives in none.
        Passive = "passive",
        /// The brake while compressing (θ̇ > 0), the motor while holding or releasing (θ̇ ≤ 0).
        Hybrid = "hybrid",
    }
}

impl DriveMode {
    /// Whether the motor is in charge, not the brake: while compressing, and while holding or
    /// releasing.
    pub const fn by_motor(self) -> [bool; 2] {
        match self {
            Self::Active => [true, true],
            Self::Passive => [false, false],
            Self::Hybrid => [false, true],
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
    /// Every number of it.
    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let largest = Parameter::not_negative("motor.max_n", self.max_n, numbers::MOTOR_N);
        let lag = self.lag_s.map(|lag| Parameter::positive("motor.lag_s", lag, numbers::STEP_S));
        [Some(largest), lag].into_iter().flatten().collect()
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
    /// Every number of it.
    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let mut list = vec![
            Parameter::not_negative("brake.max_n", self.max_n, numbers::BRAKE_N),
            Parameter::not_negative("brake.dead_zone_n", self.dead_zone_n, numbers::FORCE_N),
        ];
        if let Some([on, off]) = self.lag_on_off_s {
            let usual = numbers::BRAKE_LAGS_S;
            list.push(Parameter::positive("brake.lag_on_off_s[0]", on, usual[0]));
            list.push(Parameter::positive("brake.lag_on_off_s[1]", off, usual[1]));
        }
        list.extend(self.let_go_n.map(|n| Parameter::any("brake.let_go_n", n, numbers::FORCE_N)));
        list
    }
}
