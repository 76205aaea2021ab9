//! Stage: the figures, each described from derived tables and recorded trials; `zwidth-draw` draws
//! them.
//!
//! Four rooms: `course` (recorded trials), `comparison` (metrics and answers compared), `model`
//! (actuators, plants, runs of the model) and `schematic` (drawings of what was planned). One file
//! per figure kind; each is a pure function from rows to a [`zwidth_draw::Figure`]:
//!
//! | file | thesis | shows |
//! |---|---|---|
//! | `modes` | 28, 29 | four panels: mean of the repeats of each mode, every repeat faint behind |
//! | `rendering_range` | 25 | forces that each mode can render, by command and way |
//! | `environment` | 26, 27 | device, spring and wall, at the study's own angles |
//! | `schematic` | 4–7, 9, 10, 20, 21, 32 | model, device and control loop, from the study's own numbers |
//! | `replay` | 24 | forces, position and velocity of recorded trials and of the model, by eye and fitted |
//! | `repeats` | 36–41 | every repeat of one condition, the commanded force dotted |
//! | `space` | – | paths in three planes of one scale; the magnitude of the force against time |
//! | `loops` | 31 | force against angle for every environment |
//! | `characteristic` | 22, 23 | an actuator's response to its command: sweeps, mean, first-order and chosen fit |
//! | `likert` | 30 | answers, diverging bars with counts |
//! | `ratings` | – | answers on scales of many points: each, with median, quartiles and mean |
//! | `compared` | – | modes, participants and repeats compared, one metric per figure |
//! | `freemotion` | – | plane-fit coefficients with intervals, by session and mode |
//! | `simulation` | 11, 12, 33–35; 8 | model runs: forces against angle and time, angle against time; their inputs |
//! | `bow_tie` | 31 | brake and motor of a lever whose motion is given |
//! | `chattering` | – | swings of solvers against their step |
//! | `work_precision` | – | error against work of every solver and step |
//! | `others` | – | error against time of other programs, beside every solver and step |
//! | `less` | – | the effect of fewer recorded data on metrics |
//! | `finding` | – | that an oscillation is the method's, at a glance |
//! | `impedance` | – | the Z-width of a device: the stiffest wall against its damping |
//! | `stability` | – | which walls a sampled device can render: each limit a line with its name |
//! | `ladder` | – | models of a scene: cost against error, and what each term does |

mod about;
mod caption;
mod captions;
mod care;
mod comparison;
mod course;
mod export;
mod extent;
mod model;
mod schematic;
#[cfg(test)]
mod tests;
mod words;

pub use about::{About, Caption, FigureKind};
pub use caption::caption_text;
pub use captions::{CAPTION_FORMATS, NamedCaption, captions_text};
pub use care::{Found, with_care, with_push, with_thinned};
pub use comparison::*;
pub use course::*;
pub use export::data_table;
pub use model::*;
pub use schematic::*;
pub use words::{Words, mark};

/// Version of the figures: raised when one would look different from the same data, or there is a new one.
pub const VERSION: u32 = 38;
