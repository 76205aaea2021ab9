//! A rig characterised by itself: what a person is asked to do, what is recorded, and how it is
//! judged.
//!
//! [`Flow`] is a characterisation of an actuator, [`Sensors`] that of the sensors, [`Walls`] a Z-width test, as a pure state machine, as a session's flow is one: inputs in,
//! actions out, without clock, device or file. [`run`] carries its actions out at a rig. What was
//! recorded is judged by pure functions: [`load_cell`] (masses, zero and creep), [`judged`] (a
//! sweep: slip of the clamp, drift, the cell's end, a supply that gives no more) and [`Heat`] (how
//! long the winding must cool). What comes of the sweeps is [`calibrated_actuator`]: the curve of the
//! stage `characterise` with the interval of its force at each knot.

mod calibration;
mod cell;
mod flow;
mod heat;
mod judge;
mod lever;
mod run;
mod searches;
mod sensors;
mod step;
#[cfg(test)]
mod tests;
mod walls;
mod weighing;

pub use calibration::{CalibratedActuator, calibrated_actuator};
pub use cell::{CellFault, Load, LoadCell, Still, load_cell, still};
pub use flow::{Flow, Kept, Plan, Recorded};
pub use heat::{Heat, Winding};
pub use judge::{Judged, SweepFault, judged};
pub use run::{Bench, Left, Operator, Reply, RigError, kept_sweep, run};
pub use searches::{search_of, search_sweep};
pub use sensors::{SensorPlan, Sensors};
pub use step::{Action, Ask, Input, Remark, Steps, SweepRun};
pub use walls::{WallPlan, WallSearch, Walls};
