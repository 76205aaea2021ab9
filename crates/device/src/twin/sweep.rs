//! Characterisation: the twin's pusher holds or drives the lever while one actuator's voltage goes
//! up and down.
//!
//! A motor is measured at a held lever. A brake gives no force unless someone pushes past slip, so
//! its lever is driven from stop to stop at a slow, constant velocity. Both are felt through the
//! load cell, capstan friction included: the measured force is a little low while the motor's rises
//! and a little high while it falls.

use super::parameters::{STOPS_RAD, TwinParameters, impossible};
use super::sensors::{FORCE_RATE_HZ, ForceSensor};
use crate::DeviceError;
use crate::participant::draw::{Draw, Purpose};
use zwidth_dynamics::{Aim, Command, Driven, Hand, Tissue};

/// How long a sweep takes, s: up in half of it, and down.
pub(super) const SWEEP_S: f64 = 8.0;
/// Highest voltages of a sweep, V (thesis App. D).
const MOTOR_V: f64 = 16.0;
const BRAKE_V: f64 = 8.0;
/// The voltage is set anew so many times between two force values.
const STEPS_PER_VALUE: u32 = 5;
/// Where a driven lever starts above its lower stop, and how far from the upper one it ends, rad.
pub(super) const CLEARANCE_RAD: f64 = 0.05;
/// The pusher: heavy and stiff beside a finger, so that it holds a place and not a force. Ours.
pub(super) const PUSHER: Hand = Hand {
    mass_kg: 0.5,
    stiffness_n_per_m: 2e5,
    damping_ns_per_m: 600.0,
    tissue: Tissue { stiffness_n_per_m: 2e5, damping_ns_per_m: 200.0 },
};

/// One value of the force sensor in a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepPoint {
    /// Time since the sweep's start, s.
    pub t_s: f64,
    /// Size of the commanded voltage, V; a motor's pushes against the pusher, towards −θ.
    pub voltage_v: f64,
    /// Measured force, N.
    pub force_n: f64,
    /// Whether the lever was moving forward; only then a brake's force is its level.
    pub slipping: bool,
}

/// Motor, 0 → 16 → 0 V at a held lever; `number` from 1.
///
/// # Errors
/// A parameter that makes no sense, by name.
pub fn motor_sweep(
    parameters: &TwinParameters,
    seed: u64,
    number: u32,
) -> Result<Vec<SweepPoint>, DeviceError> {
    Sweep {
        top_v: MOTOR_V,
        from_rad: 0.0,
        speed_rad_s: 0.0,
        draw: Draw::new(seed, Purpose::Sweep, u64::from(number)),
    }
    .run(parameters, |v| Command { motor_n: parameters.actuators.motor.force_n(-v), brake_n: 0.0 })
}

/// Brake, 0 → 8 → 0 V at a lever driven at constant velocity; `number` from 1.
///
/// # Errors
/// A parameter that makes no sense, by name.
pub fn brake_sweep(
    parameters: &TwinParameters,
    seed: u64,
    number: u32,
) -> Result<Vec<SweepPoint>, DeviceError> {
    let from_rad = STOPS_RAD[0] + CLEARANCE_RAD;
    let speed_rad_s = (STOPS_RAD[1] - CLEARANCE_RAD - from_rad) / SWEEP_S;
    /// Streams of the brake's sweeps lie above those of the motor's.
    const BRAKES: u64 = 1 << 32;
    let draw = Draw::new(seed, Purpose::Sweep, BRAKES + u64::from(number));
    Sweep { top_v: BRAKE_V, from_rad, speed_rad_s, draw }.run(parameters, |v| Command {
        motor_n: 0.0,
        brake_n: parameters.actuators.brake.force_n(v),
    })
}

/// How a sweep goes.
struct Sweep {
    top_v: f64,
    from_rad: f64,
    speed_rad_s: f64,
    draw: Draw,
}

impl Sweep {
    fn run(
        self,
        parameters: &TwinParameters,
        command: impl Fn(f64) -> Command,
    ) -> Result<Vec<SweepPoint>, DeviceError> {
        parameters.check()?;
        let lever_m = parameters.lever_m;
        let mut plant = Driven::new(parameters.plant(Some(PUSHER))).map_err(|e| impossible(&e))?;
        plant.place(self.from_rad, 0.0).map_err(|e| impossible(&e))?;
        let values = (SWEEP_S * FORCE_RATE_HZ) as u32;
        let h_s = 1.0 / FORCE_RATE_HZ / f64::from(STEPS_PER_VALUE);
        let mut sensor = ForceSensor::new(parameters.force_noise_n, self.draw.clone(), 0.0);
        let mut points = Vec::with_capacity(values as usize);
        for i in 0..values * STEPS_PER_VALUE {
            let t_s = f64::from(i) * h_s;
            let end_s = f64::from(i + 1) * h_s;
            let voltage_v = self.voltage_v(t_s);
            let aims = [t_s, end_s].map(|t| Aim {
                position_m: lever_m * (self.from_rad + self.speed_rad_s * t),
                velocity_m_s: lever_m * self.speed_rad_s,
            });
            plant.advance(h_s, command(voltage_v), aims).map_err(|e| impossible(&e))?;
            if (i + 1) % STEPS_PER_VALUE == 0 {
                let state = plant.state();
                sensor.take(end_s, state.contact_n);
                let slipping = state.theta_dot_rad_s > 0.0;
                let force_n = sensor.value_n;
                points.push(SweepPoint { t_s: end_s, voltage_v, force_n, slipping });
            }
        }
        Ok(points)
    }

    /// Up in straight lines and down again.
    fn voltage_v(&self, t_s: f64) -> f64 {
        self.top_v * (1.0 - (2.0 * t_s / SWEEP_S - 1.0).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Least squares of force on voltage: slope and intercept.
    fn line(points: &[SweepPoint]) -> [f64; 2] {
        let n = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.voltage_v, y + p.force_n));
        let (xx, xy) = points.iter().fold((0.0, 0.0), |(xx, xy), p| {
            (xx + p.voltage_v * p.voltage_v, xy + p.voltage_v * p.force_n)
        });
        let slope = (n * xy - x * y) / (n * xx - x * x);
        [slope, (y - slope * x) / n]
    }

    #[test]
    fn a_motor_sweep_gives_0_26_n_per_volt_with_friction_as_its_hysteresis() {
        let twin = TwinParameters::default();
        let points = motor_sweep(&twin, 1, 1).unwrap();
        assert_eq!(points.len(), 640);
        let [up, down] = [&points[40..300], &points[340..600]].map(line);
        assert!((up[0] - 0.26).abs() < 0.002 && (down[0] - 0.26).abs() < 0.002, "{up:?} {down:?}");
        assert!((up[1] + 0.15).abs() < 0.06 && (down[1] - 0.15).abs() < 0.06, "{up:?} {down:?}");
    }

    #[test]
    fn a_brake_sweep_slips_and_gives_the_dead_zone_and_13_n() {
        let twin = TwinParameters::default();
        let points = brake_sweep(&twin, 1, 1).unwrap();
        assert!(points[8..].iter().all(|p| p.slipping));
        let above: Vec<_> = points.iter().copied().filter(|p| p.voltage_v > 1.2).collect();
        let [slope, intercept] = line(&above);
        assert!((slope - 13.0 / 7.0).abs() < 0.01, "{slope}");
        assert!((-intercept / slope - 0.92).abs() < 0.03, "{intercept}"); // 1 V less what friction adds
        let below = points.iter().filter(|p| p.voltage_v < 0.9 && p.t_s > 0.2);
        assert!(
            below.clone().count() > 50
                && below.into_iter().all(|p| (0.12..0.2).contains(&p.force_n))
        );
    }

    #[test]
    fn sweeps_differ_by_their_noise() {
        let twin = TwinParameters::default();
        let run = |seed, number| motor_sweep(&twin, seed, number).unwrap();
        let (first, second) = (run(1, 1), run(1, 2));
        let apart = first
            .iter()
            .zip(&second)
            .map(|(a, b)| (a.force_n - b.force_n) * (a.force_n - b.force_n));
        let rms = (apart.sum::<f64>() / first.len() as f64).sqrt();
        assert!((rms / (0.002 * 2.0_f64.sqrt()) - 1.0).abs() < 0.1, "{rms}");
    }
}
