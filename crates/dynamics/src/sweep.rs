//! Many trials on all cores; only their summaries are kept.

use rayon::iter::IndexedParallelIterator;

use crate::error::DynamicsError;
use crate::scene::ModelScene;
use crate::solve::{Grid, Solver};
use crate::system::System;
use crate::trajectory::Trajectory;

/// Runs every scene over its own grid and maps the run to a summary, on all cores of rayon's pool.
///
/// Scenes are taken as they are needed and each trajectory is dropped once it is summed up, so that
/// with a source that makes scenes on the fly and a reduction at the end (`max`, `count`, …) memory
/// does not depend on the number of trials. The results keep the scenes' order and are the same
/// bits for any number of threads; a trial that cannot be run is an error in its place and does not
/// end the others.
///
/// ```
/// use rayon::prelude::*;
/// use zwidth_dynamics::{Exact, Input, DriveMode, sweep, table3};
///
/// let scenes = (0..100).into_par_iter().map(|i| table3::scene(DriveMode::Hybrid, Input::sine(0.03 * f64::from(i))));
/// let solver = Exact::default();
/// let highest_rad = sweep(&solver, scenes, |_, run| run.theta_rad().fold(f64::MIN, f64::max));
/// assert_eq!(highest_rad.filter(Result::is_ok).count(), 100);
/// ```
pub fn sweep<'a, T: Send + 'a>(
    solver: &'a dyn Solver,
    scenes: impl IndexedParallelIterator<Item = ModelScene> + 'a,
    summary: impl Fn(&System, &Trajectory) -> T + Sync + Send + 'a,
) -> impl IndexedParallelIterator<Item = Result<T, DynamicsError>> + 'a {
    scenes.map(move |scene| {
        let system = System::new(scene)?;
        let run = solver.run(&system, &Grid::of(&system))?;
        Ok(summary(&system, &run))
    })
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::table3;
    use crate::solve::exact::Exact;

    /// θ at the end of each trial, as bits; every tenth scene has a mass that makes no sense.
    fn ends(threads: usize) -> Vec<Result<u64, DynamicsError>> {
        let scenes = (0..200).into_par_iter().map(|i| {
            let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(0.01 * f64::from(i)));
            scene.plant.mass_kg *= f64::from(i % 10);
            scene
        });
        let solver = Exact::default();
        let last = |_: &System, run: &Trajectory| run.theta_rad().last().map_or(0, f64::to_bits);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sweep(&solver, scenes, last).collect())
    }

    #[test]
    fn one_thread_and_many_give_the_same_bits_in_the_same_order_and_a_bad_trial_is_reported_in_its_place()
     {
        let one = ends(1);
        assert_eq!(one, ends(4));
        assert!(one.iter().enumerate().all(|(i, end)| end.is_err() == (i % 10 == 0)));
    }
}
