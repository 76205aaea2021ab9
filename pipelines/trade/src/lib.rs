//! Stage: speed against accuracy.
//!
//! [`trade`] runs a scene with every solver at every step or tolerance of a [`Fan`], compares each
//! run with the [`Yardstick`] and judges it, in this order:
//!
//! 1. **verdict** (`zwidth_dynamics::judge`): a run that chatters, is unstable or failed is out;
//! 2. **error**: whether a person could tell it from the right one
//!    (`zwidth_dynamics::FeltReference`);
//! 3. **cost**: work counts.
//!
//! For each solver, the coarsest setting counts for which every finer setting that was tried passes
//! too, because an error does not always fall with the step. The cheapest of these is recommended
//! if it passes on neighbours of the scene as well. Nothing is recommended if the right answer is
//! unproven. `docs/trade.md` has the definitions and their sources.
//!
//! Pure: a scene in memory, rows out. It reads no clock: its callers measure how long runs take.

mod cells;
mod choice;
mod condition;
mod course;
mod creep;
mod data;
mod degrade;
mod error;
mod measured;
mod metric_table;
mod perturb;
mod setting;
mod setup;
mod short;
mod table;
#[cfg(test)]
mod tests;
mod trade;

pub use cells::Cell;
pub use choice::Choice;
pub use condition::condition_scene;
pub use course::{courses, courses_table};
pub use creep::{creeps, creeps_table, half_friction};
pub use data::{Bounds, less_shifts, recordings_table, setup_shifts, twin_table};
pub use degrade::{LONGEST, Less, lessened};
pub use error::TradeError;
pub use measured::{Course, Measure, MetricChange, Metrics};
pub use metric_table::{metrics, metrics_table};
pub use perturb::neighbour;
pub use setting::{Fan, Fineness, Setting};
pub use setup::{Rehearsed, Setup, Stopped, rehearse};
pub use short::{Stops, twin_summary, twin_summary_table};
pub use table::{choice, choices_table, model_words, recommended_scene, settings, settings_table};
pub use trade::{Parameters, Trade, models, pareto_front, trade};
pub use zwidth_dynamics::{DynamicsError, ModelScene};
pub use zwidth_judge::{Errors, Size, Yardstick};

/// Version of the algorithms and of the tables' form.
pub const VERSION: u32 = 14;
