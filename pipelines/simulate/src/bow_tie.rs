//! The bow tie of Fig. 31: force against angle if the lever's motion is given (Fig. 7), so that
//! nothing can swing.

use crate::SimulateError;
use zwidth_dynamics::{ModelScene, System};
use zwidth_results::BowTieSample;

/// Steps of the stroke there, and of the one back.
const STEPS: usize = 360;

/// The forces of a stroke from the lower stop to the upper one and back, at constant speed over the
/// scene's duration: time, angle, velocity, the user's force that the motion needs, and what brake
/// and motor make together and apart (N, above 0 they push into the object, +θ).
///
/// There is no finger, nothing lags, and turning takes no force. Where the lever turns there are
/// two rows with one time and one angle, the last of the way there and the first of the way back: a
/// curve through them is vertical there.
///
/// # Errors
/// A scene that makes no sense, or one without stops.
pub fn bow_tie(scene: &ModelScene) -> Result<Vec<BowTieSample>, SimulateError> {
    let system = System::new(scene.clone())?;
    let [low, high] = scene.plant.stops_rad.ok_or(SimulateError::NoStops)?;
    let half_s = scene.duration_s / 2.0;
    let mut samples = Vec::with_capacity(2 * (STEPS + 1));
    for way in [1.0, -1.0] {
        let (from, start_s) = if way > 0.0 { (low, 0.0) } else { (high, half_s) };
        let theta_dot_rad_s = way * (high - low) / half_s;
        for i in 0..=STEPS {
            let done = i as f64 / STEPS as f64;
            let theta_rad = from + way * done * (high - low);
            // Without acceleration: what turning at the ends would take is left out.
            let forces = system.prescribed(theta_rad, theta_dot_rad_s, 0.0);
            samples.push(BowTieSample {
                t_s: start_s + done * half_s,
                theta_rad,
                theta_dot_rad_s,
                force_ex_n: forces.external_n,
                force_total_n: forces.brake_n + forces.motor_n,
                force_brake_n: forces.brake_n,
                force_motor_n: forces.motor_n,
            });
        }
    }
    Ok(samples)
}

/// The note below a bow tie.
pub const BOW_TIE_NOTE: &str =
    "A model with a given motion, not a measurement: no finger, and nothing lags.";

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_dynamics::{BrakeLaw, DriveMode, Environment, Input, table3};

    /// A spring at rest in the middle, a brake that makes all of its force and a motor that makes 1
    /// N.
    fn scene() -> ModelScene {
        let mut scene = table3::scene(DriveMode::Hybrid, Input::constant(0.0));
        scene.environment = Environment::spring(4.0, 0.0, 0.0);
        scene.brake.law = BrakeLaw::Thesis;
        scene.motor.max_n = 1.0;
        scene
    }

    fn column(of: fn(&BowTieSample) -> f64) -> Vec<f64> {
        bow_tie(&scene()).unwrap().iter().map(of).collect()
    }

    #[test]
    fn the_brake_follows_the_spring_and_the_motor_stops_at_its_limit() {
        let (theta, velocity) = (column(|s| s.theta_rad), column(|s| s.theta_dot_rad_s));
        let (total, motor) = (column(|s| s.force_total_n), column(|s| s.force_motor_n));
        for i in 0..theta.len() {
            let spring = -4.0 * theta[i];
            let expect = if velocity[i] > 0.0 { spring } else { spring.clamp(-1.0, 1.0) };
            assert!((total[i] - expect).abs() < 1e-12, "{i}: {} instead of {expect}", total[i]);
            assert!(velocity[i] <= 0.0 || motor[i] == 0.0);
        }
    }

    #[test]
    fn the_area_of_the_bow_tie_is_that_of_its_two_triangles() {
        let (theta, total) = (column(|s| s.theta_rad), column(|s| s.force_total_n));
        let next = |i: usize| (i + 1) % theta.len();
        let area: f64 = (0..theta.len())
            .map(|i| 0.5 * (total[i] + total[next(i)]) * (theta[next(i)] - theta[i]))
            .sum();
        // Above 1 N the two branches part: K (π/4 − 1/K)² / 2 on either side, in opposite turns, so
        // that they cancel.
        assert!(area.abs() < 1e-9, "{area}");
        let triangle = 4.0 * (std::f64::consts::FRAC_PI_4 - 0.25).powi(2) / 2.0;
        let right: f64 = (0..theta.len())
            .filter(|&i| theta[i] > 1e-9 || theta[next(i)] > 1e-9)
            .map(|i| 0.5 * (total[i] + total[next(i)]) * (theta[next(i)] - theta[i]))
            .sum();
        assert!((right.abs() - triangle).abs() < 1e-4 * triangle, "{right} instead of {triangle}");
    }

    #[test]
    fn a_lever_without_stops_has_no_bow_tie() {
        let mut scene = scene();
        scene.plant.stops_rad = None;
        assert!(matches!(bow_tie(&scene), Err(SimulateError::NoStops)));
    }
}
