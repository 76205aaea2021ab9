//! A sweep over parameters of which only summaries are kept: its memory does not grow with the
//! number of trials.

use rayon::prelude::*;
use zwidth_dynamics::{
    DriveMode, DynamicsError, Environment, Exact, Input, ModelScene, Trajectory, table3,
};

/// What is kept of all trials. Whole numbers and extremes only, so that the order of the trials
/// does not matter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// Number of trials.
    pub trials: u32,
    /// Lowest of the trials' highest angles, rad.
    pub least_rad: f64,
    /// Highest of them, rad.
    pub most_rad: f64,
    /// Changes of motion (forward, backward, rest), all trials together.
    pub motion_changes: u64,
}

impl Summary {
    fn of(run: &Trajectory) -> Self {
        let highest_rad = run.theta_rad().fold(f64::MIN, f64::max);
        let motion_changes = run.motion_changes() as u64;
        Self { trials: 1, least_rad: highest_rad, most_rad: highest_rad, motion_changes }
    }

    fn with(self, other: Self) -> Self {
        match (self.trials, other.trials) {
            (0, _) => other,
            (_, 0) => self,
            _ => Self {
                trials: self.trials + other.trials,
                least_rad: self.least_rad.min(other.least_rad),
                most_rad: self.most_rad.max(other.most_rad),
                motion_changes: self.motion_changes + other.motion_changes,
            },
        }
    }
}

/// The hybrid spring of Table 3 with stiffness, damping and push of trial `i`: multiples of
/// irrational numbers fill the ranges evenly without a random generator (Weyl 1916).
fn scene(i: u32) -> ModelScene {
    let spread = |irrational: f64, low: f64, high: f64| {
        low + (high - low) * (f64::from(i) * irrational).fract()
    };
    let stiffness_n_per_rad = spread(std::f64::consts::SQRT_2, 2.0, 8.0);
    let damping_ns_per_rad = spread(std::f64::consts::LN_2, 0.5, 2.0);
    let magnitude_n = spread(std::f64::consts::E, 1.0, 3.0);
    let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(magnitude_n));
    scene.environment =
        Environment::spring(stiffness_n_per_rad, damping_ns_per_rad, -table3::HALF_STROKE_RAD);
    scene
}

/// So many trials of 4 s in samples of 8.3 ms, on the threads of the pool this is called in.
///
/// # Errors
/// A trial that fails.
pub fn sweep(trials: u32) -> Result<Summary, DynamicsError> {
    let scenes = (0..trials).into_par_iter().map(scene);
    let solver = Exact::default();
    let summaries = zwidth_dynamics::sweep(&solver, scenes, |_, run| Summary::of(run));
    summaries.try_reduce(Summary::default, |a, b| Ok(a.with(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_and_many_give_the_same_summary() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sweep(64)).unwrap()
        };
        assert_eq!(on(1), on(3));
        assert_eq!(on(1).trials, 64);
    }
}
