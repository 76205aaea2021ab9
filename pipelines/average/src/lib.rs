//! Stage: the mean of the repeats of a condition, aligned at movement onset or by landmarks, with
//! its band.
//!
//! [`average`] takes the repeats of one condition by one participant in one session and gives their
//! mean course in time, or the reason why there is none; [`table`] puts the means of many
//! conditions together.
//!
//! * **Alignment at onset**: t = 0 is each repeat's movement onset, its first sample with |θ̇|
//!   above `analysis.onset_rad_s`. A repeat lasts from there to its last sample; what lies before
//!   is left out.
//! * **Alignment by landmarks**: in addition, the time of each repeat is warped, piecewise
//!   linearly, so that its start, wall contact, reversal, return and end meet the mean times of these over
//!   the repeats (Kneip & Gasser 1992, Ann. Stat. 20:1266). After the end it is shifted. A landmark
//!   that one repeat does not pass, or not in this order, is not a landmark of the condition.
//!   Values are not changed, only their times: the mean of θ̇ is not the derivative of the mean of
//!   θ.
//! * **Grid**: `analysis.grid_points` even times from 0 to where the average ends: the longest time
//!   that at least half of the repeats reach. Values between samples are on the straight line
//!   between them.
//! * **Mean, SD and band**: at each time over the n repeats that reach it. n is a column; where n
//!   falls, the mean may jump, and the notes say where. The band is the mean's Student-t interval
//!   with n − 1 degrees of freedom at `analysis.confidence`. It is pointwise: it covers each time,
//!   not the whole curve. One repeat has a mean and no band.
//! * A quantity that is not recorded in every repeat is null.
//! * **Force against position** is averaged by branch at the angle ([`mean_loop`]): the way in, held at the
//!   turn, the way out, on the angles that all repeats cover. Such a mean lies between the least
//!   and the largest of its repeats; a mean at equal phases does not.
//!
//! A mean aligned at onset smears events that happen at different times in different repeats (the
//! reversal, the contact with a wall): peaks of the mean are lower than the mean of the peaks. The
//! mean aligned by landmarks keeps peaks, but its time scale is not that of any repeat. The metrics
//! table has the mean of the peaks.
//!
//! Pure: trials in memory, tables out; the same trials give the same bits. Only trials that count
//! may come in (`StudyData::counting`): the caller filters.

mod align;
mod average;
mod error;
mod landmarks;
mod loops;
mod notes;
mod people;
mod table;
#[cfg(test)]
mod testing;

pub use average::{Average, Course, LeftOut, Parameters, Repeat, SIGNALS, average, times_s};
pub use error::{AverageError, WhyNot};
pub use landmarks::Landmark;
pub use loops::{MeanBranch, MeanLoop, mean_loop};
pub use people::{SessionLoop, looked_at, over_participants};
pub use table::{loop_table, no_average, no_loop, table};
pub use zwidth_study::Alignment;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 9;
