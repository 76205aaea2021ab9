//! Closed loop: the plant alone, moved by the recorded commands and the recorded force of the user.

use crate::scene::Rendering;
use crate::{Parameters, WhyNot};
use zwidth_dynamics::{Aim, Command, Driven, DrivenParameters, DynamicsError, ModelScene, Series};
use zwidth_numerics::series::{cumulative_trapezoid, interpolate};

/// The force on the lever from each sample to the next.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Held {
    /// Motor by its voltage and calibration, and the user's mean force, N; above 0 pushes to +θ.
    pushing_n: Vec<f64>,
    /// The brake's level, N.
    brake_n: Vec<f64>,
}

/// Commands are held from sample to sample, and the user's force counts as its mean over the
/// interval: it has the same impulse, and displaces what it moves by at most its own change over
/// the interval.
pub(crate) fn held(
    rendering: &Rendering,
    t: &[f64],
    [motor_v, brake_v]: [Option<&[f64]>; 2],
    force: &Series,
) -> Result<Held, WhyNot> {
    let [motor_n, brake_n] = rendering.commands_n(t.len(), [motor_v, brake_v])?;
    let means = means(t, force);
    Ok(Held {
        pushing_n: motor_n.iter().zip(&means).map(|(motor, mean)| motor + mean).collect(),
        brake_n,
    })
}

/// Mean of a series over each interval between `t`.
fn means(t: &[f64], series: &Series) -> Vec<f64> {
    let impulse = cumulative_trapezoid(&series.t_s, &series.value).unwrap_or_default(); // equally long
    let mut until = Vec::with_capacity(t.len());
    for &at in t {
        let before = series.t_s.partition_point(|t| *t <= at).max(1) - 1;
        let last = series.value[series.value.len() - 1];
        let value = interpolate(&series.t_s, &series.value, at).unwrap_or(last);
        until.push(
            impulse[before] + (at - series.t_s[before]) * (series.value[before] + value) / 2.0,
        );
    }
    let intervals = t.windows(2).zip(until.windows(2));
    intervals.map(|(t, until)| (until[1] - until[0]) / (t[1] - t[0])).collect()
}

/// θ (rad) and θ̇ (rad/s) at every sample. The lever starts at rest.
pub(crate) fn run(
    held: &Held,
    t: &[f64],
    scene: &ModelScene,
    parameters: &Parameters,
) -> Result<(Vec<f64>, Vec<f64>), DynamicsError> {
    let lever_m = scene.plant.lever_m;
    let mut plant = Driven::new(DrivenParameters {
        inertia_kg_m2: parameters.mass_kg * lever_m * lever_m,
        lever_m,
        stops_rad: scene.plant.stops_rad,
        friction: Some(parameters.friction()),
        back_emf_ns_per_rad: None,
        motor_lag_s: None, // the user's force comes with the motor's, and does not lag
        brake_lag_on_off_s: parameters.brake_lag_on_off_s(),
        hand: None,
    })?;
    plant.place(scene.start.theta_rad, 0.0)?;
    let mut theta_rad = vec![plant.state().theta_rad];
    let mut theta_dot_rad_s = vec![0.0];
    for (i, pair) in t.windows(2).enumerate() {
        let command = Command { motor_n: held.pushing_n[i], brake_n: held.brake_n[i] };
        plant.advance(pair[1] - pair[0], command, [Aim::default(); 2])?;
        theta_rad.push(plant.state().theta_rad);
        theta_dot_rad_s.push(plant.state().theta_dot_rad_s);
    }
    Ok((theta_rad, theta_dot_rad_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_over_an_interval_is_that_of_the_straight_lines_within() {
        let series = Series { t_s: vec![0.0, 1.0, 2.0], value: vec![0.0, 2.0, 2.0] };
        let expect = [0.5, 1.75, 2.0, 2.0];
        for (found, expect) in means(&[0.0, 0.5, 1.5, 2.0, 4.0], &series).iter().zip(expect) {
            assert!((found - expect).abs() < 1e-15, "{found} instead of {expect}");
        }
    }
}
