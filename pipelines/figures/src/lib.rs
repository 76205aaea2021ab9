//! Stage: the figures, each described from derived tables and recorded trials; `zwidth-draw` draws
//! them.
//!
//! One file per figure kind; each is a pure function from data to a [`zwidth_draw::Figure`]:
//!
//! | file | thesis | shows |
//! |---|---|---|
//! | `modes` | 28, 29 | four panels: mean of the repeats of each mode, every repeat faint behind |
//! | `rendering_range` | 25 | forces that each mode can render, by command and way |
//! | `environment` | 26, 27 | device, spring and wall, at the study's own angles |
//! | `schematic` | 4–7, 9, 10, 20, 21, 32 | model, device and control loop, from the study's own numbers |
//! | `replay` | 24 | forces, position and velocity of recorded trials and of the model, by eye and fitted |
//! | `repeats` | 36–41 | every repeat of one condition, the commanded force dotted |
//! | `loops` | 31 | force against angle for every environment |
//! | `characteristic` | 22, 23 | an actuator's response to its command: sweeps, mean, first-order and chosen fit |
//! | `likert` | 30 | answers, diverging bars with counts |
//! | `ratings` | – | answers on scales of many points: each, with median, quartiles and mean |
//! | `compared` | – | modes, participants and repeats compared, one metric a figure |
//! | `freemotion` | – | plane-fit coefficients with intervals, by session and mode |
//! | `simulation` | 11, 12, 33–35; 8 | model runs: forces against angle and time, angle against time; their inputs |
//! | `bow_tie` | 31 | brake and motor of a lever whose motion is given |
//! | `chattering` | – | swings of solvers against their step |
//! | `work_precision` | – | error against work of every solver and step |
//! | `less` | – | what less of the recordings does to metrics |
//! | `finding` | – | that an oscillation is the method's, at a glance |
//! | `impedance` | – | the Z-width of a device: the stiffest wall against its damping |
//! | `stability` | – | which walls a sampled device bears: each limit a line with its name |
//! | `ladder` | – | models of a scene: cost against error, and what each term does |

mod about;
mod answers;
mod bow_tie;
mod caption;
mod captions;
mod care;
mod characteristic;
mod chattering;
mod compared;
mod data;
mod environment;
mod export;
mod extent;
mod finding;
mod freemotion;
mod frequency;
mod impedance;
mod ladder;
mod less;
mod likert;
mod loaded;
mod loops;
mod modes;
mod oscillation;
mod panels;
mod people;
mod ratings;
mod rendering_range;
mod repeats;
mod replay;
mod schematic;
mod simulation;
mod sketch;
mod stability;
#[cfg(test)]
mod tests;
mod words;
mod work_precision;

pub use about::{About, Caption, FigureKind};
pub use answers::{ANSWERS_COMPARED, AnswersPage, answers_compared, answers_pages};
pub use bow_tie::{SCENE_BOW_TIE, bow_tie};
pub use caption::caption_text;
pub use captions::{CAPTION_FORMATS, NamedCaption, captions_text};
pub use care::{Found, with_care, with_thinned};
pub use characteristic::{CHARACTERISTIC, Characterised, characteristic};
pub use chattering::chattering;
pub use compared::{
    MODES_COMPARED, MetricResults, PARTICIPANTS_COMPARED, REPEATS_COMPARED, SESSIONS_COMPARED,
    modes_compared, participants_compared, repeats_compared, sessions_compared,
};
pub use data::{EnvironmentData, ModeData, Repeat, SIGNALS, average_columns, loop_columns};
pub use environment::{ENVIRONMENT, Placement, environment};
pub use export::data_table;
pub use finding::{Felt, finding};
pub use freemotion::{FREE_MOTION, free_motion};
pub use frequency::impedance_frequency;
pub use impedance::impedance;
pub use ladder::{LADDER, LadderRows, ladder};
pub use less::{LESS, less};
pub use likert::{LIKERT, LIKERT_ITEMS, LikertPage, likert, likert_items, likert_overview};
pub use loaded::{Averages, Loaded, Of};
pub use loops::{LOOPS, loops};
pub use modes::{MODES, modes};
pub use oscillation::oscillation;
pub use people::{EnvironmentOfPeople, MEAN_LOOPS, ModeOfPeople, draws_each, mean_loops};
pub use ratings::{RATINGS, RatingsPage, ratings, ratings_pages};
pub use rendering_range::{RENDERING_RANGE, rendering_range};
pub use repeats::{REPEATS, repeats};
pub use replay::{REPLAY, replay};
pub use schematic::{Modelled, OF_DEVICE, OF_MODEL, OfDevice, OfModel};
pub use simulation::{MOST_SIDE_BY_SIDE, SCENE_INPUTS, SCENE_RUNS, inputs, simulation};
pub use stability::{BoundaryOf, Side, StabilityPanel, StableArea, boundaries, stability};
pub use words::{Words, mark};
pub use work_precision::{WORK_PRECISION, work_precision, work_precision_of};

/// Version of the figures' form: raised when a figure would look different from the same data.
pub const VERSION: u32 = 28;
