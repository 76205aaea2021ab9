//! Stage: the mean of the repeats of a condition, aligned at movement onset, with its band.
//!
//! [`average`] takes the repeats of one condition by one participant in one session and gives their mean course in
//! time, or the reason why there is none; [`table`] puts the means of many conditions together.
//!
//! * **Alignment**: t = 0 is each repeat's movement onset, its first sample with |θ̇| above
//!   `analysis.onset_rad_s`. A repeat lasts from there to its last sample; what lies before is left out.
//! * **Grid**: `analysis.grid_points` even times from 0 to where the average ends: the longest time that at least
//!   half of the repeats reach. Values between samples are on the straight line between them.
//! * **Mean, SD and band**: at each time over the n repeats that reach it; the band is the mean's Student-t
//!   interval with n − 1 degrees of freedom at `analysis.confidence`. It is pointwise: it covers each
//!   time, not the whole curve. One repeat has a mean and no band.
//! * A quantity that is not recorded in every repeat is null.
//!
//! A mean over time smears what repeats do at different times (the reversal, the contact with a wall): peaks of the mean
//! are lower than the mean of the peaks. The metrics table has the latter.
//!
//! Pure: trials in memory, tables out; the same trials give the same bits. Only trials that count may come in
//! (`StudyData::counting`): the caller filters.

mod align;
mod average;
mod error;
mod table;
#[cfg(test)]
mod testing;

pub use average::{Average, Course, ENDS_AT, LeftOut, QUANTITIES, Quantity, Repeat, average};
pub use error::{AverageError, WhyNot};
pub use table::table;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 1;
