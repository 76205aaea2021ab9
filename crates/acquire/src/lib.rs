//! A session of trials: its flow, the runner that binds it to a device and the store, and the
//! screens.

mod auto;
mod careful;
mod course;
mod error;
pub mod flow;
mod folder;
mod front;
mod markers;
mod number;
mod outlets;
mod own;
mod participant;
mod plain;
mod plan;
mod run;
mod screen;
mod session;
mod tape;
mod tasks;
mod told;
mod unsynced;
pub mod vault;
mod view;

pub use auto::{Auto, Nobody};
pub use careful::Careful;
pub use error::AcquireError;
pub use flow::{About, Input};
pub use front::Front;
pub use markers::Target;
pub use number::number;
pub use outlets::StreamName;
pub use own::own_study;
#[cfg(any(test, feature = "testing"))]
pub use participant::hostile;
pub use participant::{
    Beside, Door, Guest, Knock, Nonce, Reception, Secret, SentAway, Teller, Visit, place_of,
    show_lines, show_screen,
};
pub use plain::Plain;
pub use plan::Plan;
pub use run::{Options, Outcome, Parts, run};
pub use screen::{Look, Screen, terminal_width};
pub use session::{Session, left_to_do, seed_of};
pub use tasks::{Counted, Progress, TaskNow};
pub use told::{check_value, step_words};
pub use unsynced::Unsynced;
pub use view::{
    Cell, CheckLine, Course, Current, EARLIER, Earlier, Labels, MESSAGES, Phase, Point, TRACE_HZ,
    TRACE_POINTS, Timing, Verdict, View,
};
