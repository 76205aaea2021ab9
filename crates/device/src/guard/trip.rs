//! Why the voltages went to 0 V, or why they were never allowed: a sentence and a remedy for each
//! reason.

use crate::{AngleFault, DeviceError};

/// What took the voltages away.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Trip {
    /// The turn of the shaft is not known.
    #[error("the lever is not homed: hold it against its lower stop and home")]
    NotHomed,
    /// No mode was allowed.
    #[error(
        "the device was not made ready for this trial: this is a defect of zwidth, please report it"
    )]
    NotArmed,
    /// The mode is not to be used on this device.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The device does not answer.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The angle is not to be believed any more.
    #[error("{0}; the trial is marked: home again")]
    Angle(#[from] AngleFault),
    /// A sensor has stopped.
    #[error(
        "no new {sensor} for {age_s:.3} s, more than the {limit_s:.3} s allowed: check the sensor's cable, then home again"
    )]
    Stale {
        /// `angle` or `force`.
        sensor: &'static str,
        /// Age of its last value, s.
        age_s: f64,
        /// What is allowed, s.
        limit_s: f64,
    },
    /// Something that must be a number is none.
    #[error("{what} is not a finite number: check the sensor and its cable")]
    NotFinite {
        /// What.
        what: &'static str,
    },
    /// The lever cannot be where it seems to be.
    #[error(
        "the lever is at {:.1} degrees, outside its work space: the turns were miscounted or the lever came off; home again",
        theta_rad.to_degrees()
    )]
    Outside {
        /// Where it seems to be, rad.
        theta_rad: f64,
    },
    /// The user's force is above the limit.
    #[error(
        "a force of {force_n:.1} N, more than the {limit_n:.1} N allowed: let go; if nobody pushed, check the load cell"
    )]
    Force {
        /// The force, N.
        force_n: f64,
        /// The limit, N.
        limit_n: f64,
    },
    /// The loop was away for too long.
    #[error(
        "the control loop missed {lost_s:.3} s, more than the {limit_s:.3} s allowed: close other programs, or ask for a lower rate"
    )]
    Deadlines {
        /// What was missed of late, s.
        lost_s: f64,
        /// What is allowed, s.
        limit_s: f64,
    },
    /// What was recorded cannot be kept.
    #[error("the samples cannot be kept any more: is the disk full?")]
    Storage,
    /// The writer fell behind the loop.
    #[error("{lost} samples were lost: the disk or the screen is too slow; repeat the trial")]
    SamplesLost {
        /// How many.
        lost: u64,
    },
    /// The control loop itself failed.
    #[error("the control loop failed: {what}; please report this")]
    Panic {
        /// What it said.
        what: String,
    },
}

impl Trip {
    /// Whether the lever's turn may be lost, so that it must be homed again.
    pub fn needs_homing(&self) -> bool {
        // Whatever leaves a motion unseen, in which a turn may be lost.
        matches!(
            self,
            Self::NotHomed
                | Self::Device(_)
                | Self::Angle(_)
                | Self::Stale { sensor: "angle", .. }
                | Self::Outside { .. }
        )
    }
}

/// Why a mode is not allowed on a device, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub(super) String);
