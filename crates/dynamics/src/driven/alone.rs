//! A lever that no hand holds, over a short step: its motion as a power series in time.
//!
//! Without a hand little is left of the equations (see the head of [`super`]): two lags, and a
//! velocity that follows them. A few powers are exact to rounding, and a bound on those from the
//! second on proves that a step has no event. Where it does not, the regions' flows take over.

use super::parameters::DrivenParameters;
use super::region::{BRAKE, BRAKE_COMMAND, MOTOR, MOTOR_COMMAND, N, OMEGA, Region, THETA};
use crate::scene::friction::Friction;
use crate::system::region::Motion;

/// The longest step, in time constants of the fastest part.
const REACH: f64 = 0.125;

/// Powers that are left out change a step by less than this part of its change.
const TOLERANCE: f64 = 1e-18;

/// 1/k for the power k; (1/8)¹¹/11! is below the tolerance.
const SHARES: [f64; 13] = {
    let mut shares = [1.0; 13];
    let mut k = 1;
    while k < 13 {
        shares[k] = 1.0 / k as f64;
        k += 1;
    }
    shares
};

/// The parameters of such a lever.
#[derive(Debug, Clone)]
pub(super) struct Alone {
    mass_kg_m: f64,
    friction: Friction,
    viscous_ns_per_rad: f64,
    stops_rad: Option<[f64; 2]>,
    /// 1/τ_m; 0 for a motor without lag, whose force is the command already.
    motor_per_s: f64,
    /// 1/τ_b while the brake grips and while it lets go; 0 without lag.
    brake_per_s: [f64; 2],
    /// The longest step, s.
    pub(super) reach_s: f64,
}

impl Alone {
    /// `None` for a plant with a hand.
    pub(super) fn of(parameters: &DrivenParameters) -> Option<Self> {
        if parameters.hand.is_some() {
            return None;
        }
        let mass_kg_m = parameters.mass_kg_m();
        let viscous_ns_per_rad = parameters.viscous_ns_per_rad();
        let motor_per_s = parameters.motor_lag_s.map_or(0.0, |lag| 1.0 / lag);
        let brake_per_s =
            parameters.brake_lag_on_off_s.map_or([0.0; 2], |lags| lags.map(|s| 1.0 / s));
        let [on, off] = brake_per_s;
        let fastest = motor_per_s.max(on).max(off).max(viscous_ns_per_rad / mass_kg_m);
        Some(Self {
            mass_kg_m,
            friction: parameters.dry(),
            viscous_ns_per_rad,
            stops_rad: parameters.stops_rad,
            motor_per_s,
            brake_per_s,
            reach_s: REACH / fastest,
        })
    }

    /// Moves the state by a step of at most [`Self::reach_s`] if nothing happens within it; else
    /// leaves it as it is and says so.
    pub(super) fn step(&self, z: &mut [f64; N], region: Region, dt_s: f64) -> bool {
        let sign = region.motion.sign();
        let brake_per_s = self.brake_per_s[usize::from(region.letting_go)];
        let (motor_rate, brake_rate) = (dt_s * self.motor_per_s, dt_s * brake_per_s);
        let (push, drag) = (dt_s / self.mass_kg_m, dt_s * self.viscous_ns_per_rad / self.mass_kg_m);
        // The terms of power 1, and the sums up to it; θ is summed as its mean rate.
        let mut motor = motor_rate * (z[MOTOR_COMMAND] - z[MOTOR]);
        let mut brake = brake_rate * (z[BRAKE_COMMAND] - z[BRAKE]);
        let resisting_n = sign * (z[BRAKE] + self.friction.kinetic_n);
        let mut speed = push * (z[MOTOR] - resisting_n) - drag * z[OMEGA];
        let (mut motor_n, mut brake_n) = (z[MOTOR] + motor, z[BRAKE] + brake);
        let (mut omega, mut mean_omega) = (z[OMEGA] + speed, z[OMEGA] + speed / 2.0);
        let least_straight = sign * z[OMEGA] + (sign * speed).min(0.0);
        let mut bend = 0.0;
        let rate = motor_rate.max(brake_rate).max(drag);
        let mut size = 1.0;
        for k in 2..SHARES.len() - 1 {
            size *= rate * SHARES[k];
            if size < TOLERANCE {
                break;
            }
            speed = SHARES[k] * (push * (motor - sign * brake) - drag * speed);
            motor *= -motor_rate * SHARES[k];
            brake *= -brake_rate * SHARES[k];
            motor_n += motor;
            brake_n += brake;
            omega += speed;
            mean_omega += speed * SHARES[k + 1];
            bend += speed.abs();
        }
        if region.motion == Motion::Rest {
            // Both lags are monotone: their ends bound them.
            let [low, high] = self.stops_rad.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let forward_n = if z[THETA] >= high { 0.0 } else { z[MOTOR].max(motor_n) };
            let backward_n = if z[THETA] <= low { 0.0 } else { -z[MOTOR].min(motor_n) };
            let holding_n = z[BRAKE].min(brake_n) + self.friction.static_n;
            if forward_n.max(backward_n) > holding_n {
                return false;
            }
        } else {
            let theta = z[THETA] + dt_s * mean_omega;
            let is_inside = self.stops_rad.is_none_or(|[low, high]| low < theta && theta < high);
            if least_straight <= bend || !is_inside {
                return false;
            }
            (z[THETA], z[OMEGA]) = (theta, omega);
        }
        (z[MOTOR], z[BRAKE]) = (motor_n, brake_n);
        true
    }
}
