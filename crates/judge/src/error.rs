//! Why a trajectory cannot be judged.

use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, Clone, thiserror::Error)]
pub enum JudgeError {
    /// Columns of different lengths.
    #[error(
        "it has {times} times, {angles} angles and {velocities} velocities; give one of each per row"
    )]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of angles.
        angles: usize,
        /// Number of velocities.
        velocities: usize,
    },
    /// Too few samples.
    #[error(
        "it has {samples} samples within the scene, and at least {least} are needed; write one per millisecond"
    )]
    TooShort {
        /// How many there are.
        samples: usize,
        /// How many are needed.
        least: usize,
    },
    /// Something that is no number.
    #[error("row {row}: {what} is {value}; leave out what comes after the simulation failed")]
    NotFinite {
        /// The row, from 1.
        row: usize,
        /// The quantity.
        what: &'static str,
        /// What stands there.
        value: f64,
    },
    /// Times that stand still or run backwards.
    #[error(
        "row {row}: the time {t_s} s does not come after {before_s} s; sort the rows, and write each time once"
    )]
    NotIncreasing {
        /// The row, from 1.
        row: usize,
        /// Its time, s.
        t_s: f64,
        /// That of the row before, s.
        before_s: f64,
    },
    /// A beginning after the scene's.
    #[error(
        "it begins at {t_s} s, and the scene at 0 s; let its times count from the scene's start"
    )]
    BeginsLate {
        /// Its first time, s.
        t_s: f64,
    },
    /// A beginning before the scene's.
    #[error(
        "it begins at {t_s} s, before the scene; let its times count from the scene's start, 0 s"
    )]
    BeginsEarly {
        /// Its first time, s.
        t_s: f64,
    },
    /// An end before the scene's.
    #[error(
        "it ends at {end_s} s, and the scene at {duration_s} s; simulate all of it, or set duration_s of the scene"
    )]
    EndsEarly {
        /// Its last time, s.
        end_s: f64,
        /// The scene's length, s.
        duration_s: f64,
    },
    /// Times that seem to be in milliseconds.
    #[error(
        "its times end at {end_s} s, and the scene at {duration_s} s: are they milliseconds? Then call the column t_ms, or name the unit in a mapping (--map)"
    )]
    Milliseconds {
        /// Its last time, s.
        end_s: f64,
        /// The scene's length, s.
        duration_s: f64,
    },
    /// Angles that seem to be in degrees.
    #[error(
        "its angles look like degrees: as such they follow the scene; call the columns theta_deg and theta_dot_deg_s, or name the unit in a mapping (--map)"
    )]
    Degrees,
    /// Another start.
    #[error(
        "it starts with {what} = {found} {unit}, and the scene with {right} {unit}; start it as the scene does ([start] of the scene's file)"
    )]
    OtherStart {
        /// The quantity.
        what: &'static str,
        /// What it is in the trajectory.
        found: f64,
        /// What it is in the scene.
        right: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// The scene makes no sense, or no solver could run it.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}
