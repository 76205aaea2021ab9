//! The simulated device: plant, actuators, sensors and board of the prototype, with a simulated
//! participant.
//!
//! The plant is [`zwidth_dynamics::Driven`] with the numbers of [`TwinParameters`]; voltages become
//! forces by the prototype's characteristics; the angle is seen by a sensor on the shaft that
//! wraps, the force by a load cell that is slow and noisy. The board takes the voltages away when
//! nothing is written for 50 ms. A seed gives the same bits on any machine, trial by trial: a
//! trial's numbers depend on its number, not on what went before.
//!
//! Signs: a motor voltage above 0 pushes towards +θ, as everywhere; rendering a spring takes a
//! voltage below 0.
//!
//! It leaves out slack and stretch of the capstan's cable, gravity, heating, the drivers' dead
//! times, noise and non-linearity of the angle sensor, the load cell's creep, and the settling time
//! of the HX711.

mod board;
mod fixture;
mod parameters;
mod sensors;
mod sweep;
#[cfg(test)]
mod tests;
mod trial;

pub use board::Twin;
pub use fixture::{Faults, Fixture, Hands, HandsHandle};
pub use parameters::{TwinParameter, TwinParameters};
pub use sensors::{COUNTS_PER_TURN, SHAFT_PER_LEVER};
pub use sweep::{SweepPoint, brake_sweep, motor_sweep};
