//! The board as a device: it moves plant and participant up to the requested moment.

use super::parameters::{STOPS_RAD, TwinParameters, impossible};
use super::sensors::{AngleSensor, COUNTS_PER_TURN, FORCE_RATE_HZ, ForceSensor, SHAFT_PER_LEVER};
use super::trial::{Trial, WAITING_GAP_M};
use crate::participant::draw::{Draw, Purpose};
use crate::participant::{Person, STEP_S};
use crate::{Angle, Capabilities, Cue, Device, DeviceError, Judged, Reading};
use zwidth_dynamics::{Command, Driven};
use zwidth_study::{AnswerScale, CURRENT_MOTOR, Channel, ChannelId, Extra, Source, Voltages};

/// Version of the simulation: another one makes other numbers of the same seed.
const VERSION: u32 = 2;
/// Without a write for this long the board goes to 0 V, s.
const WATCHDOG_S: f64 = 0.05;
/// Rate at which it is asked by default, Hz.
const RATE_HZ: f64 = 1000.0;
/// Steps of the participant between two force values: 12.5 ms.
const STEPS_PER_FORCE: u64 = 5;
/// Speed at which the lever is carried back after a trial, rad/s.
const CARRY_RAD_S: f64 = 1.0;
/// Largest deviation of the board's clock, parts per million; a crystal's.
const DRIFT_PPM: f64 = 50.0;

/// The simulated device with its participant.
#[derive(Debug, Clone)]
pub struct Twin {
    capabilities: Capabilities,
    parameters: TwinParameters,
    person: Person,
    seed: u64,
    plant: Driven,
    angle: AngleSensor,
    force: ForceSensor,
    clock_offset_s: f64,
    clock_rate: f64,
    now_s: f64,
    /// The participant's last step: when, and how many there were.
    step_s: f64,
    steps: u64,
    voltages: Voltages,
    written_s: f64,
    trial: Trial,
}

impl Twin {
    /// A device of these parameters with this participant at it. The seed is the board's: its
    /// magnet, clock and noise.
    ///
    /// # Errors
    /// A parameter that makes no sense, by name.
    pub fn new(parameters: TwinParameters, person: Person, seed: u64) -> Result<Self, DeviceError> {
        parameters.check()?;
        let plant = Driven::new(parameters.plant(Some(person.hand))).map_err(|e| impossible(&e))?;
        let mut board = Draw::new(seed, Purpose::Board, 0);
        let force =
            ForceSensor::new(parameters.force_noise_n, Draw::new(seed, Purpose::Sensors, 0), 0.0);
        let mut twin = Self {
            capabilities: capabilities(&parameters),
            plant,
            angle: AngleSensor::new(board.between([0.0, f64::from(COUNTS_PER_TURN)])),
            force,
            clock_offset_s: board.between([0.0, 60.0]),
            clock_rate: 1.0 + 1e-6 * board.between([-DRIFT_PPM, DRIFT_PPM]),
            // Not known before it is first asked.
            now_s: f64::NEG_INFINITY,
            step_s: 0.0,
            steps: 0,
            voltages: Voltages::OFF,
            written_s: f64::NEG_INFINITY,
            trial: Trial::idle(&person, &parameters),
            parameters,
            person,
            seed,
        };
        twin.rest_at(STOPS_RAD[0])?;
        Ok(twin)
    }

    /// What no sensor sees: the plant's true state.
    #[cfg(test)]
    pub(crate) fn truth(&self) -> zwidth_dynamics::DrivenState {
        self.plant.state()
    }

    /// What the board puts out: what was written last, until the watchdog takes it away.
    pub fn voltages(&self) -> Voltages {
        self.voltages
    }

    /// What the participant means to do in the current trial.
    #[cfg(test)]
    pub(crate) fn intent(&self) -> &crate::Intent {
        self.trial.course.intent()
    }

    /// Puts the lever at rest at an angle with the hand waiting just before it.
    fn rest_at(&mut self, theta_rad: f64) -> Result<(), DeviceError> {
        self.plant.place(theta_rad, WAITING_GAP_M).map_err(|e| impossible(&e))
    }

    /// Moves everything up to a moment, step by step of the participant, the watchdog in between.
    fn advance_to(&mut self, now_s: f64) -> Result<(), DeviceError> {
        if self.now_s < f64::MIN {
            // A host's clock may begin anywhere.
            self.start(now_s, 0);
        }
        while self.now_s < now_s {
            let next_step_s = self.step_s + STEP_S;
            let expiry_s = self.written_s + WATCHDOG_S;
            let pending = self.voltages != Voltages::OFF;
            // Up to the watchdog's moment exactly, which may lie within a step.
            let until_s =
                if pending { expiry_s.clamp(self.now_s, now_s) } else { now_s }.min(next_step_s);
            let aims = [self.now_s, until_s].map(|t_s| self.trial.aim(t_s, self.step_s));
            let command = self.command();
            self.plant
                .advance(until_s - self.now_s, command, aims)
                .map_err(|error| impossible(&error))?;
            self.now_s = until_s;
            if pending && until_s >= expiry_s {
                self.voltages = Voltages::OFF;
            }
            if until_s >= next_step_s {
                self.step(next_step_s)?;
            }
        }
        Ok(())
    }

    /// From here on it is `now_s`; the force sensor is `phase` steps into its period.
    fn start(&mut self, now_s: f64, phase: u64) {
        (self.now_s, self.step_s, self.steps) = (now_s, now_s, phase);
    }

    fn command(&self) -> Command {
        let Voltages { motor_v, brake_v } = self.voltages;
        Command {
            motor_n: self.parameters.actuators.motor.force_n(motor_v),
            brake_n: self.parameters.actuators.brake.force_n(brake_v.abs()),
        }
    }

    /// One step of the participant and, every fifth time, of the force sensor.
    fn step(&mut self, at_s: f64) -> Result<(), DeviceError> {
        (self.step_s, self.steps) = (at_s, self.steps + 1);
        if at_s >= self.trial.over_s {
            // Somebody moves the lever back to its start, which pushing alone cannot.
            let theta_rad = self.plant.state().theta_rad;
            let is_back = theta_rad <= STOPS_RAD[0];
            if !is_back {
                self.rest_at((theta_rad - CARRY_RAD_S * STEP_S).max(STOPS_RAD[0]))?;
            }
        }
        let state = self.plant.state();
        self.trial.step(&self.person, self.parameters.lever_m, at_s, &state);
        if self.steps.is_multiple_of(STEPS_PER_FORCE) {
            self.force.take(at_s, state.contact_n);
        }
        Ok(())
    }

    fn reading(&mut self) -> Reading {
        let state = self.plant.state();
        let current_a = self.parameters.motor_current_a(state.motor_n, state.theta_dot_rad_s);
        self.angle.take(self.now_s, state.theta_rad);
        Reading {
            t_device_s: Some(self.clock_offset_s + self.clock_rate * self.now_s),
            angle: Angle::Counts(self.angle.counts),
            angle_age_s: self.now_s - self.angle.taken_s,
            force_n: self.force.value_n,
            force_age_s: Some(self.now_s - self.force.taken_s),
            extra: Extra::new(&[state.theta_rad, current_a]),
        }
    }
}

impl Device for Twin {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.voltages = Voltages::OFF;
        self.trial = Trial::idle(&self.person, &self.parameters);
        self.rest_at(STOPS_RAD[0])?;
        self.start(now_s, 0);
        self.force.take(now_s, 0.0);
        Ok(self.reading())
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.advance_to(now_s)?;
        Ok(self.reading())
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.advance_to(now_s)?;
        (self.voltages, self.written_s) = (voltages, now_s);
        Ok(())
    }

    fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
        // The stop is always a place to rest at, so there is no error to tell.
        let _ = self.rest_at(STOPS_RAD[0]);
        self.trial = Trial::begin(&self.person, &self.parameters, now_s, cue);
        // A stream of its own, so that a trial does not depend on those before it.
        let mut noise = Draw::new(self.seed, Purpose::Sensors, u64::from(cue.trial));
        let phase = noise.between([0.0, STEPS_PER_FORCE as f64]) as u64;
        self.force = ForceSensor::new(self.parameters.force_noise_n, noise, now_s);
        self.start(now_s, phase);
    }

    fn answer(&mut self, on: &AnswerScale) -> Option<i16> {
        // A question ends the trial: what comes after it is not felt.
        self.trial.over_s = self.trial.over_s.min(self.now_s);
        self.trial.answer(&self.person, on)
    }

    fn judge(&mut self, judged: &Judged) -> Option<i16> {
        self.trial.over_s = self.trial.over_s.min(self.now_s);
        let answers = !self.person.is_silent(judged.trial);
        answers.then(|| self.person.judge(judged))
    }
}

fn capabilities(parameters: &TwinParameters) -> Capabilities {
    let actuators = &parameters.actuators;
    Capabilities {
        name: format!("twin {VERSION}"),
        rate_hz: RATE_HZ,
        force_rate_hz: FORCE_RATE_HZ,
        counts_per_turn: Some(COUNTS_PER_TURN),
        shaft_per_lever: SHAFT_PER_LEVER,
        motor_max_v: actuators.motor.voltage_v.last().copied().unwrap_or(0.0),
        brake_max_v: actuators.brake.voltage_v.last().copied().unwrap_or(0.0),
        watchdog_s: Some(WATCHDOG_S),
        shows_moments: false,
        source: Source::Twin,
        channels: channels(),
    }
}

/// What no sensor of the prototype sees, in the order of a reading's: the lever's angle as it is,
/// and the current in the motor's winding.
fn channels() -> Vec<Channel> {
    let all = [
        ("theta_true_rad", "rad", "lever angle of the simulated plant, without its sensor"),
        (CURRENT_MOTOR, "A", "current in the simulated motor's winding"),
    ];
    all.into_iter()
        .filter_map(|(id, unit, description)| {
            // Always: both are valid ids.
            let id = ChannelId::new(id).ok()?;
            Some(Channel { id, unit: unit.to_owned(), description: description.to_owned() })
        })
        .collect()
}

#[cfg(test)]
mod tests;
