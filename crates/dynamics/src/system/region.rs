//! The regions of a system: in each, the motion is smooth.

use zwidth_study::worded;

/// Up is +θ, into the object; down is back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// θ̇ > 0.
    Up,
    /// θ̇ < 0, and for laws that switch on the sign θ̇ ≤ 0.
    Down,
}

impl Side {
    /// Sign of the velocity on this side.
    #[inline]
    pub(crate) fn sign(self) -> f64 {
        match self {
            Side::Up => 1.0,
            Side::Down => -1.0,
        }
    }
}

/// How the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// θ̇ > 0.
    Forward,
    /// θ̇ < 0.
    Backward,
    /// θ̇ = 0, held by a set-valued force: brake, friction, a stop, or the switching of the
    /// actuators.
    Rest,
}

impl Motion {
    /// Sign of θ̇.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Motion::Forward => 1.0,
            Motion::Backward => -1.0,
            Motion::Rest => 0.0,
        }
    }
}

/// Which of its three lines a clamped value is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// At its lower limit.
    Low,
    /// Between the limits.
    Linear,
    /// At its upper limit.
    High,
}

worded! {
    /// Whether the finger's tissue is fully pressed.
    Contact {
        /// |x2| < L_F0, or no finger.
        Free = "free",
        /// x2 = L_F0: the user's force passes through a rigid stop.
        Pressed = "fully pressed",
        /// x2 = −L_F0.
        Stretched = "fully stretched",
    }
}

/// A region: everything that decides which equations hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// How the lever moves.
    pub motion: Motion,
    /// Environment zone whose law holds above the angle; in motion both are the same.
    pub zone_up: u16,
    /// Zone whose law holds below it; differs from `zone_up` only for a lever at rest on a zone's
    /// edge.
    pub zone_down: u16,
    /// Line of the clamped command for upward motion.
    pub branch_up: Branch,
    /// Line of the clamped command for downward motion.
    pub branch_down: Branch,
    /// The finger.
    pub contact: Contact,
    /// The stop a lever at rest leans on.
    pub stop: Option<Side>,
    /// At rest, the user's force is above the brake's let-go threshold.
    pub held: bool,
    /// At rest in a hybrid drive, the motor that is commanded to hold pushes towards −θ.
    pub motor_holds: bool,
    /// At rest in a hybrid drive whose motor lags: how much less force the motor is asked for, per
    /// newton that the brake holds. Motor and brake share as infinitely fast switching would
    /// make them (Filippov).
    pub motor_share: f64,
}

impl Region {
    /// The side to which the lever moves, if it moves.
    pub(crate) fn side(&self) -> Option<Side> {
        match self.motion {
            Motion::Forward => Some(Side::Up),
            Motion::Backward => Some(Side::Down),
            Motion::Rest => None,
        }
    }

    /// The same region, at whatever angle the lever rests.
    pub(crate) fn resembles(&self, other: &Region) -> bool {
        Region { motor_share: 0.0, ..*self } == Region { motor_share: 0.0, ..*other }
    }
}
