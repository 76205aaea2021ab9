//! What a session is made of.

use std::path::PathBuf;
use zwidth_store::Layout;
use zwidth_study::{Calibration, ParticipantId, SessionId, Study};

/// The parts of a session besides the device.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Where the study lies.
    pub layout: Layout,
    /// The study to record with: that of `study.toml`, or for a continued session its own
    /// ([`crate::own_study`]).
    pub study: Study,
    /// The text of the present `study.toml`, of which a session that begins keeps a copy.
    pub study_toml: Vec<u8>,
    /// A session whose copy differs from that in what is recorded continues with its copy; its log
    /// says so.
    pub accept_study_change: bool,
    /// The participant.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The calibration in force.
    pub calibration: Calibration,
    /// The software that records, with its version.
    pub software: String,
    /// Rate of the control loop, Hz.
    pub rate_hz: f64,
    /// The order's seed, if one is requested. A study has one seed: its participants are balanced
    /// under it.
    pub seed: Option<u64>,
    /// The folder of seals and of the seed that is not to be known.
    pub keys: PathBuf,
    /// Random bytes nobody can guess, from which a blinded session has its seal's nonce and its
    /// study the seed.
    pub secret: [u8; 32],
}
