//! Devices behind one trait: the simulated one, playback, and the guard between them and the
//! control of a trial.
//!
//! A [`Device`] is an instrument: it reads a sample and takes two voltages. It knows no scene and
//! no study folder. Time belongs to a [`Clock`]: the same loop runs in real time and faster.
//!
//! [`run_trial`] is that loop: the [`Guard`] judges each reading, the [`Controller`] decides, the
//! guard clamps, the device is written to, and the sample is handed over. [`run_live`] runs it on a
//! thread of its own; an [`Attendant`] holds the device for a whole session, and keeps reading
//! between trials.
//!
//! ```
//! use std::{ops::ControlFlow, sync::atomic::AtomicBool};
//! use zwidth_device::{Controller, Guard, Limits, SimulatedClock, TrialEnd, TrialPlan, mock::Mock, run_trial};
//! use zwidth_study::{Calibration, Study};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let study = Study::from_toml(&zwidth_study::template(&zwidth_study::StudyId::new("demo")?)).unwrap();
//! let (environment, mode, calibration) = (&study.environments[0], &study.modes[0], Calibration::thesis());
//! let mut device = Mock::default();
//! let mut guard = Guard::new(&device.capabilities, Limits::of(&study)?, false);
//! guard.home(&mut device, 0.0)?;
//! guard.arm(mode, &calibration)?;
//! let plan = TrialPlan::new(&study, environment, 1, &device.capabilities)?;
//! let mut controller = Controller::new(&study.control, environment, mode, &calibration);
//! let mut samples = Vec::new();
//! let mut sink = |sample: &_| {
//!     samples.push(*sample);
//!     ControlFlow::Continue(())
//! };
//! let (mut clock, stop) = (SimulatedClock::new(1), AtomicBool::new(false));
//! let run = run_trial(&mut device, &mut clock, &mut controller, &mut guard, &plan, &stop, &mut sink);
//! assert_eq!(run.end, TrialEnd::LetGo);
//! # Ok(())
//! # }
//! ```

mod angle;
mod attend;
pub mod check;
mod clock;
mod control;
mod device;
mod digits;
mod error;
mod guard;
#[cfg(any(test, feature = "testing"))]
pub mod mock;
mod participant;
mod playback;
mod priority;
mod push;
mod ramp;
mod signals;
mod timing;
mod trial;
mod twin;
mod velocity;

pub use angle::{AngleFault, Homed, Unwrap};
pub use attend::{Attendant, Station, TrialTask};
pub use clock::{Clock, RealClock, SimulatedClock};
pub use control::{Controller, FORWARD_RAD_S, HOLDING_RAD_S};
pub use device::{Angle, Capabilities, Cue, Device, Reading};
pub use error::DeviceError;
pub use guard::{AWAY_S, FORCE_RATE_HZ, Guard, Limits, MOTOR_FORCE_N, Refusal, Seen, Trip};
pub use participant::{Felt, Goal, HAND_RANGES, Intent, Judged, Person, Task, Truth};
pub use playback::Playback;
pub use priority::Priority;
pub use push::{Push, PushEnd, PushRun};
pub use ramp::{Ramp, RampEnd, Ramped, Weighed};
pub use signals::stop_on_signals;
pub use timing::{Histogram, Timing};
pub use trial::{
    BatchSink, LiveRun, Moments, Sink, TrialEnd, TrialPlan, TrialRun, run_live, run_trial, watch,
};
pub use twin::{
    COUNTS_PER_TURN, Faults, Fixture, Hands, HandsHandle, SHAFT_PER_LEVER, SweepPoint, Twin,
    TwinParameter, TwinParameters, brake_sweep, motor_sweep,
};
pub use velocity::Velocity;
