//! Stage: drives the model with recorded forces, and measures how far it departs from the recording
//! (thesis §4.3, Fig. 24).
//!
//! [`replay`] turns one trial into three rows of its table, one per
//! [`Causality`](zwidth_results::Causality), and [`agreement`]
//! says for all trials together how far peaks and times agree (Bland & Altman). [`Drive`] is a
//! trial prepared for replay with any [`Parameters`], for figures and for judging fits; [`Balance`]
//! gives the force that the recorded motion of a trial needs, for fits. Pure: trials in memory,
//! rows out; only trials that count may come in (`StudyData::counting`): the caller filters.
//!
//! # The model
//! M_O L θ̈ = F_O + F_ex − B_O θ̇ − friction, equation (10) without finger, solved exactly between
//! events. M_O and B_O are the thesis' ([`Parameters::BY_EYE`]), L, environment, mode and work
//! space those of `study.toml`; the session's calibration limits the actuators' forces. The brake
//! is a set-valued force. B_O acts on the lever beside the actuators and is not limited by them:
//! the prototype commands the spring alone (§4.3, F = −k u), so the simulation's B_O stands for the
//! plant's own damping.
//!
//! The user's force counts at the times at which its sensor gave new values, with straight lines
//! between them, if the recording gives their age (`force_age_s`); else at the samples' times.
//!
//! [`oscillation`] finds out whether the swings in one trial are the device's own.
//!
//! Errors are model minus recording: above 0 the model's peak is higher, its time later.

mod agreement;
mod balance;
mod closed_loop;
mod compare;
mod courses;
mod drive;
mod error;
mod lag;
mod oscillation;
mod replay;
mod runs;
mod scene;
mod table;
#[cfg(test)]
mod testing;
mod updates;

pub use agreement::{agreement, agreement_table};
pub use balance::Balance;
pub use courses::{course_notes, courses, typical};
pub use drive::{Course, Drive, Judged};
pub use error::{ReplayError, WhyNot};
pub use oscillation::{
    Origin, Oscillation, RecordedSwings, SwingAnswer, SwingCourse, oscillation, trial_oscillation,
};
pub use replay::{replay, replay_with};
pub use runs::runs;
pub use scene::{Parameters, Rendering};
pub use table::{in_order, own_model};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 10;
