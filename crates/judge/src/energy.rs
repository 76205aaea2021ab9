//! The energy balance of a trajectory: what no force gave or took.

use crate::Yardstick;
use crate::sides::{Side, Sides, right_at};
use zwidth_dynamics::{DynamicsError, Trajectory};

/// What the right motion's balance misses, by its sampling alone, counts so many times.
const TIMES: f64 = 4.0;
/// In the end energy counts that is this share of what the motion has and the user gives.
const SHARE: f64 = 0.05;

/// An energy balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Balance {
    /// Energy at the end that no force gave, J; below 0 that none took.
    pub(crate) residual_j: f64,
    /// The mean of it over the last third, J: it counts only if it stays.
    pub(crate) mean_j: f64,
    /// How much of it the sampling may make, J.
    pub(crate) bound_j: f64,
    /// The largest kinetic energy and the user's work of the right motion, J.
    pub(crate) scale_j: f64,
}

impl Balance {
    /// Whether energy was made or lost: beyond what the sampling may make, and lastingly.
    pub(crate) fn is_broken(&self) -> bool {
        // A right lever that never moves has no energy to compare with.
        if self.scale_j <= 0.0 {
            return false;
        }
        let bound_j = self.bound_j.max(SHARE * self.scale_j);
        self.residual_j.abs() > bound_j
            && self.mean_j.abs() > bound_j
            && self.residual_j * self.mean_j > 0.0
    }
}

/// The balance of a trajectory: the change of ½ M L² θ̇² less the work of all forces on the lever, by
/// the scene's laws at the trajectory's own states. Between two samples θ is the cubic through both
/// and their velocities, and the power's integral is Simpson's. At a stop energy may be lost.
/// `except` are steps over which the state was reset.
///
/// None where the forces depend on more than θ, θ̇ and time: a finger, lagging actuators.
///
/// # Errors
/// A right run that fails between the samples.
pub(crate) fn balance(
    yardstick: &Yardstick,
    sides: &Sides<'_>,
    near_rad: f64,
    except: &[usize],
) -> Result<Option<Balance>, DynamicsError> {
    let scene = sides.system.scene();
    let layout = &sides.right.run.layout;
    if layout.finger.is_some() || layout.motor.is_some() || layout.brake.is_some() {
        return Ok(None);
    }
    let t = &sides.t_s;
    let middles = t.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
    let times: Vec<f64> = middles.chain(t.last().copied()).collect();
    let right = right_at(yardstick, &times)?;
    // The right motion is put together from its samples too: its balance then misses what they hide.
    let [own, right] = [&sides.own, &sides.right].map(|side| {
        let [theta, omega] = between(sides, side);
        right.with_motion(sides.system, &theta, &omega, sides.rest_rad_s)
    });
    let inertia = scene.plant.mass_kg * scene.plant.lever_m * scene.plant.lever_m;
    let account = |run: &Trajectory, except: &[usize]| {
        let theta: Vec<f64> = run.theta_rad().collect();
        let omega: Vec<f64> = run.theta_dot_rad_s().collect();
        let kinetic = |i: usize| 0.5 * inertia * omega[i] * omega[i];
        // Of a lever that is held the forces add up to nothing.
        let power = |i: usize| {
            let forces = run.forces(sides.system, i);
            (forces.tip_n + forces.device_n()) * scene.plant.lever_m * omega[i]
        };
        let mut sum_j = 0.0;
        let mut doubt_j = 0.0;
        let mut residuals = vec![0.0];
        for k in (2..run.len()).step_by(2) {
            let h = times[k] - times[k - 2];
            let [a, m, b] = [power(k - 2), power(k - 1), power(k)];
            let is_reset = except.contains(&(k / 2));
            let work = if is_reset { 0.5 * h * (a + b) } else { h / 6.0 * (a + 4.0 * m + b) };
            let change = kinetic(k) - kinetic(k - 2);
            let at_stop = scene.plant.stops_rad.is_some_and(|stops| {
                let reach = near_rad + h * omega[k - 2].abs();
                stops.iter().any(|stop| (theta[k] - stop).abs() <= reach)
            });
            let more = change - work;
            sum_j += if at_stop { more.max(0.0) } else { more };
            // Where a law switches between two samples nobody knows when it does.
            if run.region[k] != run.region[k - 2] {
                doubt_j += h * (a.abs() + b.abs());
            }
            residuals.push(sum_j);
        }
        (residuals, doubt_j)
    };
    let (own_j, doubt_j) = account(&own, except);
    let (right_j, _) = account(&right, &[]);
    let sampling_j = right_j.iter().map(|j| j.abs()).fold(0.0, f64::max);
    let fastest = sides.right.fastest_rad_s();
    let given: f64 = (1..sides.len())
        .map(|i| {
            let forces = sides.right.run.forces(sides.system, i);
            let speed = sides.right.theta_dot_rad_s[i].abs();
            (t[i] - t[i - 1]) * forces.external_n.abs() * scene.plant.lever_m * speed
        })
        .sum();
    let last_third = &own_j[2 * own_j.len() / 3..];
    let rounding_j =
        inertia * fastest.max(sides.own.fastest_rad_s()) * TIMES * sides.omega_step_rad_s;
    Ok(Some(Balance {
        residual_j: own_j.last().copied().unwrap_or(0.0),
        mean_j: last_third.iter().sum::<f64>() / last_third.len() as f64,
        bound_j: TIMES * sampling_j + doubt_j + rounding_j,
        scale_j: 0.5 * inertia * fastest * fastest + given,
    }))
}

/// θ and θ̇ of one of the two at its samples and in the middle between them: of the cubic through two
/// samples and their velocities. Where the angles have few digits their differences would shake the
/// velocity: then that is of the cubic through four velocities.
fn between(sides: &Sides<'_>, side: &Side) -> [Vec<f64>; 2] {
    /// Steps of the velocity that are as good as none, as a share of the largest.
    const FINE: f64 = 1e-6;
    let [theta, omega] = [&side.theta_rad, &side.theta_dot_rad_s];
    let t = &sides.t_s;
    let fine_rad_s = sides.omega_step_rad_s.max(FINE * sides.own.fastest_rad_s());
    let by_angles = sides.theta_step_rad <= fine_rad_s * sides.step_s;
    let mut all = [Vec::with_capacity(2 * t.len()), Vec::with_capacity(2 * t.len())];
    for i in 0..t.len() {
        all[0].push(theta[i]);
        all[1].push(omega[i]);
        if i + 1 < t.len() {
            let h = t[i + 1] - t[i];
            let mean = 0.5 * (omega[i] + omega[i + 1]);
            all[0].push(0.5 * (theta[i] + theta[i + 1]) + h / 8.0 * (omega[i] - omega[i + 1]));
            all[1].push(match (by_angles, i.checked_sub(1), omega.get(i + 2)) {
                (true, ..) => 1.5 * (theta[i + 1] - theta[i]) / h - 0.5 * mean,
                (false, Some(before), Some(behind)) => {
                    1.125 * mean - (omega[before] + behind) / 16.0
                }
                _ => mean,
            });
        }
    }
    all
}
