//! A trial's loop again: the controller of the study with the model's plant.

use super::recorded::count_rad;
use crate::scene::{Parameters, Rendering};
use crate::{Drive, WhyNot};
use zwidth_device::{Controller, Velocity};
use zwidth_dynamics::{HeldForces, ModelScene, TickController};
use zwidth_numerics::series::{cumulative_trapezoid, interpolate};
use zwidth_store::{Signal, Trial};
use zwidth_study::{Calibration, Study};

/// θ of a trial against time: as it was recorded, and of its loop run again.
#[derive(Debug, Clone, PartialEq)]
pub struct SwingCourse {
    /// Time since the first sample, s.
    pub t_s: Vec<f64>,
    /// θ, rad.
    pub theta_rad: Vec<f64>,
}

/// The controller of a trial and the actuators behind it; it sees the angle in counts.
#[derive(Debug, Clone)]
pub(super) struct Loop {
    controller: Controller,
    velocity: Velocity,
    calibration: Calibration,
    /// Ticks since the first sample, s, and the user's force as the controller read it, N.
    t_s: Vec<f64>,
    read_n: Vec<f64>,
    first_rad: f64,
    count_rad: f64,
    motor: Lag,
    brake: Lag,
}

impl Loop {
    /// The loop of a trial, at the ticks of its recording.
    pub(super) fn of(
        study: &Study,
        rendering: &Rendering,
        trial: &Trial,
        drive: &Drive,
        plant: &Parameters,
    ) -> Result<Self, WhyNot> {
        let calibration = rendering.calibration.clone().ok_or(WhyNot::NoCalibration)?;
        let environment = study.environment(&trial.meta.environment).ok_or(WhyNot::NotRendered)?;
        let mode = study.mode(&trial.meta.mode).ok_or(WhyNot::NotRendered)?;
        let read_n = trial.samples.get(Signal::ForceEx).ok_or(WhyNot::NoForce)?.to_vec();
        // A cut-off that is none was refused with the study.
        let velocity = Velocity::new(study.control.velocity).map_err(|_| WhyNot::NotRendered)?;
        let recorded = drive.recorded();
        let motor_lag_s = plant.motor_lag_s().unwrap_or(0.0);
        let mut controller = Controller::new(&study.control, environment, mode, &calibration);
        // A device may be slower than the study's loop: what is late is so by ticks of the recording.
        let ticks = (recorded.t_s.len() - 1) as f64;
        controller.begin(ticks / recorded.t_s[recorded.t_s.len() - 1]);
        Ok(Self {
            controller,
            velocity,
            calibration,
            t_s: recorded.t_s.clone(),
            read_n,
            first_rad: recorded.theta_rad[0],
            count_rad: count_rad(&recorded.theta_rad),
            motor: Lag { on_s: motor_lag_s, off_s: motor_lag_s, now: 0.0 },
            brake: Lag { on_s: plant.brake_on_s, off_s: plant.brake_off_s, now: 0.0 },
        })
    }
}

impl TickController for Loop {
    /// A force that lags is held at its mean over the tick, which has the same impulse.
    fn tick(&mut self, number: usize, theta_rad: f64) -> HeldForces {
        let t_s = self.t_s[number];
        let dt_s = self.t_s.get(number + 1).map_or(0.0, |next| next - t_s);
        let seen_rad = match self.count_rad > 0.0 {
            // Counted from the first sample, which is a whole count of the device's.
            true => {
                let counts = ((theta_rad - self.first_rad) / self.count_rad).round();
                self.first_rad + counts * self.count_rad
            }
            false => theta_rad,
        };
        let rate = self.velocity.step(t_s, seen_rad);
        let (voltages, _) = self.controller.step(seen_rad, rate, self.read_n[number]);
        let motor_n = self.calibration.motor.force_n(voltages.motor_v);
        let brake_n = self.calibration.brake.force_n(voltages.brake_v).abs();
        HeldForces {
            pushing_n: self.motor.mean(motor_n, dt_s),
            brake_n: self.brake.mean(brake_n, dt_s).max(0.0),
        }
    }
}

/// A value that follows its command with a time constant, rising or falling, s.
#[derive(Debug, Clone, Copy)]
struct Lag {
    on_s: f64,
    off_s: f64,
    now: f64,
}

impl Lag {
    /// Its mean over a time in which a command holds: c + (y₀ − c) (τ/Δt) (1 − e^(−Δt/τ)).
    fn mean(&mut self, command: f64, dt_s: f64) -> f64 {
        let lag_s = if command.abs() >= self.now.abs() { self.on_s } else { self.off_s };
        if lag_s <= 0.0 || dt_s <= 0.0 {
            self.now = command;
            return command;
        }
        let off = self.now - command;
        let left = libm::exp(-dt_s / lag_s);
        self.now = command + off * left;
        command + off * lag_s / dt_s * (1.0 - left)
    }
}

/// The scene of a trial with the plant's mass and friction, for a loop that has its lags itself.
pub(super) fn scene(drive: &Drive, plant: &Parameters) -> ModelScene {
    plant.without_lags().put(drive.scene())
}

/// The mean of a signal over `width_s` about each of its times, taken twice; at the ends over what
/// is there.
pub(super) fn slow_part(t: &[f64], y: &[f64], width_s: f64) -> Vec<f64> {
    mean_about(t, &mean_about(t, y, width_s), width_s)
}

fn mean_about(t: &[f64], y: &[f64], width_s: f64) -> Vec<f64> {
    let integral = cumulative_trapezoid(t, y).unwrap_or_default(); // equally long
    let (Some(first), Some(last)) = (t.first(), t.last()) else { return Vec::new() };
    let until = |at: f64| {
        let k = t.partition_point(|t| *t <= at).max(1) - 1;
        let value = interpolate(t, y, at).unwrap_or(y[k]);
        integral[k] + (at - t[k]) * 0.5 * (y[k] + value)
    };
    let mut means = Vec::with_capacity(t.len());
    for at in t {
        // As far to one side as to the other, so that a slope stays what it is.
        let half_s = (0.5 * width_s).min(at - first).min(last - at);
        means.push(match half_s > 0.0 {
            true => (until(at + half_s) - until(at - half_s)) / (2.0 * half_s),
            false => interpolate(t, y, *at).unwrap_or_default(),
        });
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn the_slow_part_keeps_a_line_and_takes_every_harmonic_away() {
        let t: Vec<f64> = (0..4000).map(|i| f64::from(i) * 1e-3).collect();
        let slow = |t: f64| 1.0 + 0.5 * t;
        let fast = |t: f64| libm::sin(TAU * 8.0 * t) + 0.3 * libm::cos(TAU * 16.0 * t);
        let y: Vec<f64> = t.iter().map(|t| slow(*t) + fast(*t)).collect();
        let found = slow_part(&t, &y, 0.125);
        for (t, found) in t.iter().zip(&found).filter(|(t, _)| (0.3..3.7).contains(*t)) {
            assert!((found - slow(*t)).abs() < 1e-4, "{t}: {found}");
        }
        assert_eq!(slow_part(&[], &[], 1.0).len(), 0);
    }

    #[test]
    fn a_lag_s_mean_over_many_ticks_is_its_integral() {
        let mut lag = Lag { on_s: 0.015, off_s: 0.01, now: 0.0 };
        let sum: f64 = (0..6).map(|_| 8.3e-3 * lag.mean(2.0, 8.3e-3)).sum();
        let t = 6.0 * 8.3e-3;
        let expect = 2.0 * (t - 0.015 * (1.0 - libm::exp(-t / 0.015)));
        assert!((sum - expect).abs() < 1e-14, "{sum} {expect}");
        assert!(lag.mean(0.0, 8.3e-3) < 1.6 && (Lag { on_s: 0.0, ..lag }).mean(2.0, 1.0) >= 2.0);
    }
}
