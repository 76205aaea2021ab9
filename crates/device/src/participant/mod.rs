//! The simulated participant: what the twin's hand means to do, how it gives way, and what it
//! answers.
//!
//! **A stand-in with stated limits, not a claim about people.** It exists so that a study can be
//! rehearsed, software tested and a protocol's power planned before anyone is asked to push. It
//! consists of:
//!
//! * **Intent**: a forward movement of least jerk (Flash & Hogan 1985, J. Neurosci. 5:1688) to a
//!   goal: an angle of the lever, and at a wall a force ([`Goal`]). It is planned before the trial
//!   from what the participant knows: the environment and the lever, never the mode. The same
//!   intent in three modes gives three trajectories through contact alone.
//! * **Course**: how the intent is carried out, depending on what is felt. The hand turns where the
//!   goal is reached, lets go of its force, and goes back with the lever.
//! * **Impedance**: a mass on a spring and a damper towards the intent; it pushes through a
//!   fingertip and never pulls. It is constant: people stiffen when they are surprised, this
//!   participant does not.
//! * **Giving way**: above a comfortable force, and near the end of the work space, the intent
//!   retreats, a reaction time late.
//! * **Variation**: participants differ by their [`Person`], sessions by what a day brings
//!   ([`Person::in_session`]), repeats by their draw of the [`Intent`]; over the first trials of
//!   the first session both the spread and the duration shrink a little.
//! * **Answer**: a written rule from what was felt ([`Felt`]), with a bias of the person and noise.
//!   It was made so that the three modes rank as in thesis Fig. 30, so **no finding about
//!   perception can come from it**. Tasks are answered by a psychometric function that is known
//!   ([`Truth`]), whatever was felt.
//!
//! It lacks tremor, fatigue, attention, strategies that change with what is felt, grip, arm
//! posture, and any knowledge measured on the thesis' participant, because there is none.

mod answer;
mod course;
pub(crate) mod draw;
mod felt;
pub(crate) mod intent;
mod judge;
mod person;
mod reaction;

pub(crate) use course::Course;
pub use felt::Felt;
pub use intent::{Goal, Intent, Task};
pub use judge::{Judged, Truth};
pub use person::{HAND_RANGES, Person};
pub(crate) use reaction::Reaction;

/// Time step of what the participant senses and does, s; far below any reaction time. Five of them
/// are a period of the force sensor at 80/s, which is why the twin goes by them too.
pub(crate) const STEP_S: f64 = 0.002_5;
