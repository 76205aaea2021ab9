//! Stage: the figures, each described from derived tables and recorded trials; `zwidth-draw` draws them.
//!
//! One file a figure kind; each is a pure function from data to a [`zwidth_draw::Figure`]:
//!
//! | file | thesis | shows |
//! |---|---|---|
//! | `modes` | 28, 29 | four panels: mean of the repeats of each mode, every repeat faint behind |
//! | `repeats` | 36–41 | every repeat of one condition, the commanded force dotted |
//! | `loops` | 31 | force against angle for every environment |
//! | `characteristic` | 22, 23 | an actuator's response to its command, with the chosen fit |
//! | `likert` | 30 | answers, diverging bars with counts |
//! | `freemotion` | – | plane-fit coefficients with intervals, by session and mode |

mod characteristic;
mod data;
mod export;
mod freemotion;
mod likert;
mod loops;
mod modes;
mod panels;
mod repeats;
#[cfg(test)]
mod tests;
mod words;

pub use characteristic::characteristic;
pub use data::{ModeData, Repeat, Scene};
pub use export::data_table;
pub use freemotion::free_motion;
pub use likert::{LikertPanel, likert};
pub use loops::loops;
pub use modes::modes;
pub use repeats::repeats;
pub use words::{Words, mark};

/// Version of the figures' form: raised when a figure would look different from the same data.
pub const VERSION: u32 = 1;
