//! A simulated rig at a bench: plant, actuators, sensors and board of the twin, and in the place of
//! a participant the hands of somebody who characterises it.
//!
//! The hands hang masses on the load cell, carry the lever, clamp it, and push it through its
//! brake. They are stiff beside a finger: the pusher of [`super::sweep`]. What can go wrong at a
//! bench is a [`Faults`].

use super::parameters::{STOPS_RAD, TwinParameters, impossible};
use super::sensors::{AngleSensor, COUNTS_PER_TURN, FORCE_RATE_HZ, ForceSensor, SHAFT_PER_LEVER};
use super::sweep::{CLEARANCE_RAD, PUSHER, SWEEP_S};
use crate::participant::draw::{Draw, Purpose};
use crate::{Angle, Capabilities, Device, DeviceError, Reading};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use zwidth_dynamics::{Aim, Command, Driven};
use zwidth_study::{Extra, Source, Voltages};

/// Without a write for this long the board goes to 0 V, s.
const WATCHDOG_S: f64 = 0.05;
/// The plant is followed in steps no longer than this, s.
const STEP_S: f64 = 2.5e-3;
/// Speed at which hands carry the lever, rad/s.
const CARRY_RAD_S: f64 = 0.5;
/// How far from the lever idle hands are, m.
const GAP_M: f64 = 5e-4;
/// Standard gravity, m/s² (CGPM 1901).
const GRAVITY_M_S2: f64 = 9.806_65;
/// How far a clamp slips, rad: 1°.
const SLIP_RAD: f64 = std::f64::consts::PI / 180.0;
/// How far a clamp that lets go lets the lever go, rad.
const OFF_RAD: f64 = 0.2;
/// A lever this near to its clamp is in it, rad.
const THERE_RAD: f64 = 2e-3;

/// What the hands do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hands {
    /// Nothing touches the lever or its load cell.
    Away,
    /// This mass hangs from the load cell, kg; below 0 it pulls the other way.
    Hang(f64),
    /// The lever is held at this angle, rad, against the load cell.
    Clamp(f64),
    /// The lever is pushed from its lower stop to its upper one, slowly and evenly.
    Push,
    /// The lever is carried back to its lower stop.
    Back,
    /// The lever is carried against its upper stop.
    Up,
}

/// What goes wrong at the bench.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// The clamp slips by a degree once, as soon as it has to hold more than this, N.
    pub slips_above_n: Option<f64>,
    /// It lets the lever go.
    pub loose_above_n: Option<f64>,
    /// The load cell drifts, N/s.
    pub drift_n_per_s: f64,
    /// The load cell ends here, N.
    pub cell_ends_n: Option<f64>,
    /// A newton is shown as so many more, as a share.
    pub gain_error: f64,
}

/// The hands at a fixture, for whoever plays them.
#[derive(Debug, Clone)]
pub struct HandsHandle(Arc<Mutex<Hands>>);

impl HandsHandle {
    /// From now on they do this.
    pub fn set(&self, hands: Hands) {
        *self.lock() = hands;
    }

    fn lock(&self) -> MutexGuard<'_, Hands> {
        // Whatever panicked left hands that do something.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The simulated rig at a bench.
#[derive(Debug)]
pub struct Fixture {
    capabilities: Capabilities,
    parameters: TwinParameters,
    faults: Faults,
    hands: HandsHandle,
    doing: Hands,
    /// Since when, s.
    doing_s: f64,
    /// Where the lever was then, rad.
    from_rad: f64,
    /// Where a clamp that gave way lets the lever go, rad.
    slipped_rad: Option<f64>,
    plant: Driven,
    angle: AngleSensor,
    force: ForceSensor,
    force_due_s: f64,
    now_s: Option<f64>,
    began_s: f64,
    voltages: Voltages,
    written_s: f64,
}

impl Fixture {
    /// A rig with these parameters, and the hands at it. The seed is that of its noise.
    ///
    /// # Errors
    /// A parameter that makes no sense, by name.
    pub fn new(
        parameters: TwinParameters,
        faults: Faults,
        seed: u64,
    ) -> Result<(Self, HandsHandle), DeviceError> {
        parameters.check()?;
        let plant = Driven::new(parameters.plant(Some(PUSHER))).map_err(|e| impossible(&e))?;
        let mut board = Draw::new(seed, Purpose::Board, 0);
        let hands = HandsHandle(Arc::new(Mutex::new(Hands::Away)));
        let mut fixture = Self {
            capabilities: capabilities(&parameters),
            plant,
            faults,
            hands: hands.clone(),
            doing: Hands::Away,
            doing_s: 0.0,
            from_rad: STOPS_RAD[0],
            slipped_rad: None,
            angle: AngleSensor::new(board.between([0.0, f64::from(COUNTS_PER_TURN)])),
            force: ForceSensor::new(
                parameters.force_noise_n,
                Draw::new(seed, Purpose::Sensors, 0),
                0.0,
            ),
            force_due_s: 0.0,
            now_s: None,
            began_s: 0.0,
            voltages: Voltages::OFF,
            written_s: 0.0,
            parameters,
        };
        fixture.rest_at(STOPS_RAD[0])?;
        Ok((fixture, hands))
    }

    /// What the board puts out.
    pub fn voltages(&self) -> Voltages {
        self.voltages
    }

    fn rest_at(&mut self, theta_rad: f64) -> Result<(), DeviceError> {
        self.plant.place(theta_rad, GAP_M).map_err(|e| impossible(&e))
    }

    fn advance_to(&mut self, now_s: f64) -> Result<(), DeviceError> {
        // A host's clock may begin anywhere.
        let mut at_s = *self.now_s.get_or_insert_with(|| {
            (self.force_due_s, self.doing_s, self.began_s) = (now_s, now_s, now_s);
            now_s
        });
        while at_s < now_s {
            let hands = *self.hands.lock();
            if hands != self.doing {
                (self.doing, self.doing_s) = (hands, at_s);
                self.from_rad = self.plant.state().theta_rad;
                self.slipped_rad = None;
            }
            let expiry_s = self.written_s + WATCHDOG_S;
            let mut until_s = now_s.min(at_s + STEP_S);
            if self.force_due_s > at_s {
                until_s = until_s.min(self.force_due_s);
            }
            if self.voltages != Voltages::OFF && expiry_s > at_s {
                until_s = until_s.min(expiry_s);
            }
            self.step(at_s, until_s)?;
            at_s = until_s;
            self.now_s = Some(at_s);
            if self.voltages != Voltages::OFF && at_s >= expiry_s {
                self.voltages = Voltages::OFF;
            }
            if at_s >= self.force_due_s {
                self.weigh(at_s);
                self.force_due_s += 1.0 / FORCE_RATE_HZ;
            }
        }
        Ok(())
    }

    /// Moves plant and hands on.
    fn step(&mut self, at_s: f64, until_s: f64) -> Result<(), DeviceError> {
        let dt_s = until_s - at_s;
        if self.doing == Hands::Back {
            // Pushing alone cannot carry it back.
            let theta_rad = self.plant.state().theta_rad;
            return self.rest_at((theta_rad - CARRY_RAD_S * dt_s).max(STOPS_RAD[0]));
        }
        let Voltages { motor_v, brake_v } = self.voltages;
        let command = Command {
            motor_n: self.parameters.actuators.motor.force_n(motor_v),
            brake_n: self.parameters.actuators.brake.force_n(brake_v.abs()),
        };
        self.slip(at_s);
        let aims = [at_s, until_s].map(|t_s| self.aim(t_s));
        self.plant.advance(dt_s, command, aims).map_err(|e| impossible(&e))
    }

    /// A clamp that has too much to hold gives way.
    fn slip(&mut self, at_s: f64) {
        let held_n = self.plant.state().contact_n;
        let exceeds = |limit_n: Option<f64>| limit_n.is_some_and(|limit_n| held_n > limit_n);
        let Hands::Clamp(theta_rad) = self.doing else { return };
        // What it takes to carry the lever there does not count.
        let is_there = (self.plant.state().theta_rad - theta_rad).abs() < THERE_RAD;
        if self.slipped_rad.is_some() || !is_there {
            return;
        }
        let by_rad = if exceeds(self.faults.loose_above_n) {
            OFF_RAD
        } else if exceeds(self.faults.slips_above_n) {
            SLIP_RAD
        } else {
            return;
        };
        self.slipped_rad = Some(theta_rad - by_rad);
        (self.from_rad, self.doing_s) = (theta_rad, at_s);
    }

    /// Where the hands mean to be.
    fn aim(&self, t_s: f64) -> Aim {
        let lever_m = self.parameters.lever_m;
        let since_s = t_s - self.doing_s;
        let carried = |to_rad: f64, speed_rad_s: f64| {
            let way_rad = to_rad - self.from_rad;
            let left = way_rad.abs() > speed_rad_s * since_s;
            let gone_rad = if left { speed_rad_s * since_s * way_rad.signum() } else { way_rad };
            let velocity_rad_s = if left { speed_rad_s * way_rad.signum() } else { 0.0 };
            (self.from_rad + gone_rad, velocity_rad_s)
        };
        let away_rad = STOPS_RAD[0] - GAP_M / lever_m;
        let (theta_rad, speed_rad_s) = match self.doing {
            Hands::Clamp(theta_rad) => carried(self.slipped_rad.unwrap_or(theta_rad), CARRY_RAD_S),
            // A little against the stop.
            Hands::Up => carried(STOPS_RAD[1] + 1e-3, CARRY_RAD_S),
            Hands::Push => {
                let stroke_rad = STOPS_RAD[1] - STOPS_RAD[0] - 2.0 * CLEARANCE_RAD;
                carried(STOPS_RAD[1] - CLEARANCE_RAD, stroke_rad / SWEEP_S)
            }
            Hands::Away | Hands::Hang(_) | Hands::Back => (away_rad, 0.0),
        };
        Aim { position_m: lever_m * theta_rad, velocity_m_s: lever_m * speed_rad_s }
    }

    fn weigh(&mut self, at_s: f64) {
        let hung_n = match self.doing {
            Hands::Hang(mass_kg) => mass_kg * GRAVITY_M_S2,
            _ => 0.0,
        };
        let felt_n = self.plant.state().contact_n + hung_n;
        let shown_n = (1.0 + self.faults.gain_error) * felt_n
            + self.faults.drift_n_per_s * (at_s - self.began_s);
        self.force.take(at_s, shown_n);
        if let Some(ends_n) = self.faults.cell_ends_n {
            self.force.value_n = self.force.value_n.clamp(-ends_n, ends_n);
        }
    }

    fn reading(&mut self) -> Reading {
        let state = self.plant.state();
        let now_s = self.now_s.unwrap_or(0.0);
        self.angle.take(now_s, state.theta_rad);
        Reading {
            t_device_s: Some(now_s),
            angle: Angle::Counts(self.angle.counts),
            angle_age_s: 0.0,
            force_n: self.force.value_n,
            force_age_s: Some(now_s - self.force.taken_s),
            extra: Extra::default(),
        }
    }
}

impl Device for Fixture {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// Somebody holds it against its lower stop.
    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.voltages = Voltages::OFF;
        self.advance_to(now_s)?;
        self.rest_at(STOPS_RAD[0])?;
        self.hands.set(Hands::Away);
        self.doing = Hands::Away;
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
}

fn capabilities(parameters: &TwinParameters) -> Capabilities {
    let [motor_max_v, brake_max_v] = [&parameters.actuators.motor, &parameters.actuators.brake]
        .map(|characteristic| characteristic.voltage_v.last().copied().unwrap_or(0.0));
    Capabilities {
        name: "twin fixture 1".to_owned(),
        rate_hz: 1000.0,
        force_rate_hz: FORCE_RATE_HZ,
        counts_per_turn: Some(COUNTS_PER_TURN),
        shaft_per_lever: SHAFT_PER_LEVER,
        motor_max_v,
        brake_max_v,
        watchdog_s: Some(WATCHDOG_S),
        shows_moments: false,
        source: Source::Twin,
        channels: Vec::new(),
    }
}
