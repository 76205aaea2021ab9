//! A cluster on this machine: a scheduler and executors as processes of their own. What they make of
//! the study that comes with the software has the bytes of a run without them, and whatever goes
//! wrong with them ends in a result or in a clear error.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "tests")]

mod faults;
mod hosts;
mod locks;
mod same;
mod store;
mod stored;
mod studies;
