//! The error of a run: how far it is from the right answer.

use crate::story::Story;
use crate::yardstick::Yardstick;
use serde::Serialize;
use zwidth_dynamics::{
    DynamicsError, FeltDifference, FeltMotion, FeltReference, System, Trajectory,
};

/// At most so many samples of a run are compared, evenly chosen.
const MOST_COMPARED: usize = 8_000;

/// The largest and the root mean square of a difference.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Size {
    /// The largest, either way.
    pub largest: f64,
    /// The root mean square.
    pub rms: f64,
}

impl Size {
    /// Of differences.
    fn of(differences: impl Iterator<Item = f64>) -> Self {
        let mut largest = 0.0_f64;
        let mut sum = 0.0;
        let mut n = 0.0;
        for x in differences {
            largest = largest.max(x.abs());
            sum += x * x;
            n += 1.0;
        }
        Self { largest, rms: if n > 0.0 { libm::sqrt(sum / n) } else { 0.0 } }
    }
}

/// The errors of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of θ, rad.
    pub theta_rad: Size,
    /// Of θ̇, rad/s.
    pub theta_dot_rad_s: Size,
    /// Of the device's force on the lever's end, N, more than 50 ms away from its jumps.
    pub force_n: Size,
    /// Of ∫ F dt over the run, N s.
    pub impulse_ns: f64,
    /// The largest of the times at which the lever changes its way of moving or passes an edge, s;
    /// none where something else happens.
    pub event_s: Option<f64>,
    /// Of the largest θ of the samples, rad.
    pub peak_rad: f64,
    /// What a person feels of it.
    pub felt: FeltDifference,
}

/// At most so many of a run's samples, evenly chosen.
pub fn places(run: &Trajectory, most: usize) -> Vec<usize> {
    (0..run.len()).step_by(run.len().div_ceil(most).max(1)).collect()
}

/// What a run is compared with.
pub(crate) struct Right<'a> {
    /// The right run, a sample for each of the places that are compared.
    pub(crate) run: &'a Trajectory,
    /// What happens in it.
    pub(crate) story: &'a Story,
    /// ∫ F dt of its device's force, N s.
    pub(crate) impulse_ns: f64,
    /// Its largest θ, rad.
    pub(crate) peak_rad: f64,
    /// What is felt of it.
    pub(crate) felt: &'a FeltReference,
}

/// The errors of a run, at its samples.
///
/// # Errors
/// A right run that fails at these times.
pub fn errors(yardstick: &Yardstick, run: &Trajectory) -> Result<Errors, DynamicsError> {
    let places = places(run, MOST_COMPARED);
    // Run again at the same times rather than interpolated: the comparison itself then adds no
    // error.
    let right = yardstick.at(places.iter().map(|i| run.t_s[*i]).collect())?;
    let right = Right {
        run: &right,
        story: &yardstick.story,
        impulse_ns: yardstick.impulse_ns,
        peak_rad: peak_rad(&yardstick.run),
        felt: &yardstick.felt,
    };
    Ok(errors_at(&yardstick.system, run, &places, &right))
}

/// The errors of a run at some of its samples, each of which has one of the right run.
pub(crate) fn errors_at(
    system: &System,
    run: &Trajectory,
    places: &[usize],
    right: &Right<'_>,
) -> Errors {
    let signals: [fn(&Trajectory) -> Vec<f64>; 2] =
        [|run| run.theta_rad().collect(), |run| run.theta_dot_rad_s().collect()];
    let [theta_rad, theta_dot_rad_s] = signals.map(|signal| {
        let own = signal(run);
        Size::of(places.iter().zip(signal(right.run)).map(|(i, right)| own[*i] - right))
    });
    let calm = places.iter().copied().enumerate();
    let calm = calm.filter(|(_, i)| !right.felt.is_disturbed(run.t_s[*i]));
    let motion = FeltMotion::of(system, run);
    let force_n = calm
        .map(|(k, i)| run.forces(system, i).device_n() - right.run.forces(system, k).device_n());
    Errors {
        theta_rad,
        theta_dot_rad_s,
        force_n: Size::of(force_n),
        impulse_ns: (motion.impulse_ns() - right.impulse_ns).abs(),
        event_s: right.story.apart_s(&Story::of(system, run)),
        peak_rad: (peak_rad(run) - right.peak_rad).abs(),
        felt: right.felt.compare(&motion),
    }
}

/// The largest θ of the samples, rad.
pub(crate) fn peak_rad(run: &Trajectory) -> f64 {
    run.theta_rad().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_3_and_minus_4_is_4_and_their_root_mean_square() {
        let size = Size::of([3.0, -4.0].into_iter());
        assert!((size.largest - 4.0).abs() < 1e-15 && (size.rms - 12.5_f64.sqrt()).abs() < 1e-15);
        assert!(Size::of(std::iter::empty()).rms.abs() < 1e-300);
    }
}
