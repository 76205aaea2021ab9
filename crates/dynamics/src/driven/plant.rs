//! The plant itself: its state, and how commands and intent move it.

use super::alone::Alone;
use super::parameters::DrivenParameters;
use super::region::{
    self, BRAKE, BRAKE_COMMAND, CONTACT, DEPTH, FIRST, GAP, HAND_V, INTENT, INTENT_RATE, MOTOR,
    MOTOR_COMMAND, N, OMEGA, ONE, ReadyFlow, Region, SECOND, THETA,
};
use crate::affine::Fall;
use crate::error::{DynamicsError, Result, check, finite, in_bounds, not_negative};
use crate::system::region::Motion;

/// The commands to the actuators, held over an advance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// Force of the motor at the lever's end, N; above 0 drives to +θ.
    pub motor_n: f64,
    /// Level of the brake at the lever's end, N; not below 0.
    pub brake_n: f64,
}

/// Where the hand means to be, along the arc of the lever's end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aim {
    /// Position, m: L times an angle.
    pub position_m: f64,
    /// Velocity, m/s.
    pub velocity_m_s: f64,
}

/// What can be seen of the plant at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenState {
    /// θ, rad.
    pub theta_rad: f64,
    /// θ̇, rad/s; exactly 0 at rest.
    pub theta_dot_rad_s: f64,
    /// F_m: motor force, N.
    pub motor_n: f64,
    /// b: brake level, N. At rest the brake gives what it must, up to this.
    pub brake_n: f64,
    /// F_ex: force of the hand on the lever, N; never below 0.
    pub contact_n: f64,
    /// s_h: where the hand is along the arc, m; 0 without hand.
    pub hand_m: f64,
    /// v_h, m/s.
    pub hand_m_s: f64,
}

/// Longest step that is tried in one piece, s, a power of two: the flow is exact over any, but the
/// bounds that prove it free of events grow with its square.
const REACH_S: f64 = 1.0 / 1024.0;

/// Short steps of a lever alone that take less time than the flow over all of them.
const MOST_STEPS: f64 = 16.0;

/// Events within one advance after which the plant must be chattering, which its set-valued forces
/// exclude.
const MOST_EVENTS: u64 = 100_000;

/// A plant that is moved by commands.
#[derive(Debug, Clone)]
pub struct Driven {
    parameters: DrivenParameters,
    /// In the order of [`Region::index`]; none for a region this plant is never in.
    regions: Vec<Option<ReadyFlow>>,
    /// The shorter way of a lever that no hand holds.
    alone: Option<Alone>,
    region: Region,
    z: [f64; N],
}

impl Driven {
    /// The plant at rest on its lower stop (at θ = 0 without stops), all forces 0, the hand just
    /// touching.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`], which names the parameter.
    pub fn new(parameters: DrivenParameters) -> Result<Self> {
        Self::with_reach(parameters, REACH_S)
    }

    /// The same with another longest step.
    pub(super) fn with_reach(parameters: DrivenParameters, reach_s: f64) -> Result<Self> {
        parameters.check()?;
        let regions = Region::all()
            .map(|region| {
                region.exists(&parameters).then(|| region::flow(&parameters, region, reach_s))
            })
            .collect();
        let alone = Alone::of(&parameters);
        let mut plant = Self { parameters, regions, alone, region: Region::START, z: [0.0; N] };
        plant.place(parameters.stops_rad.map_or(0.0, |[low, _]| low), 0.0)?;
        Ok(plant)
    }

    /// Puts the lever at rest at an angle, all forces 0, and the hand at rest that far away from it
    /// (m).
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] for an angle outside the stops or a gap below 0.
    pub fn place(&mut self, theta_rad: f64, gap_m: f64) -> Result<()> {
        let inside =
            self.parameters.stops_rad.is_none_or(|[low, high]| (low..=high).contains(&theta_rad));
        let ok = theta_rad.is_finite() && inside;
        check("theta_rad", theta_rad, ok, "finite and between the stops")?;
        not_negative("gap_m", gap_m)?;
        self.z = [0.0; N];
        (self.z[THETA], self.z[GAP], self.z[ONE]) = (theta_rad, gap_m, 1.0);
        self.region = Region::START;
        Ok(())
    }

    /// What can be seen of it now.
    pub fn state(&self) -> DrivenState {
        let z = &self.z;
        let force = region::contact_force(&self.parameters, self.region.contact).dot(z);
        let hand = self.parameters.hand.map_or(0.0, |_| self.hand_m());
        DrivenState {
            theta_rad: z[THETA],
            theta_dot_rad_s: z[OMEGA],
            motor_n: z[MOTOR],
            brake_n: z[BRAKE],
            contact_n: force.max(0.0), // below is the margin at lift-off
            hand_m: hand,
            hand_m_s: z[HAND_V],
        }
    }

    /// Moves the plant over `dt_s` seconds with the commands held and the hand's aim going from
    /// `aims[0]` to `aims[1]` in straight lines (position and velocity each). Without a hand the
    /// aims are not used.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] if an argument is not finite, the time or the brake's level
    /// below 0; [`DynamicsError::NotFinite`] and [`DynamicsError::TooMuchWork`] if extreme
    /// parameters lead there.
    pub fn advance(&mut self, dt_s: f64, command: Command, aims: [Aim; 2]) -> Result<()> {
        not_negative("dt_s", dt_s)?;
        finite("command.motor_n", command.motor_n)?;
        not_negative("command.brake_n", command.brake_n)?;
        if dt_s <= 0.0 {
            return Ok(());
        }
        self.z[MOTOR_COMMAND] = command.motor_n;
        self.z[BRAKE_COMMAND] = command.brake_n;
        // An actuator without lag follows at once.
        if self.parameters.motor_lag_s.is_none() {
            self.z[MOTOR] = command.motor_n;
        }
        if self.parameters.brake_lag_on_off_s.is_none() {
            self.z[BRAKE] = command.brake_n;
        }
        let lags = self.parameters.brake_lag_on_off_s.is_some();
        self.region.letting_go = lags && command.brake_n < self.z[BRAKE];
        if let Some(hand) = self.parameters.hand {
            // The intent as a force K p + B ṗ, linear in time.
            let [from, to] = aims.map(|aim| {
                hand.stiffness_n_per_m * aim.position_m + hand.damping_ns_per_m * aim.velocity_m_s
            });
            finite("aims[0]", from)?;
            finite("aims[1]", to)?;
            (self.z[INTENT], self.z[INTENT_RATE]) = (from, (to - from) / dt_s);
        }
        let mut rest_s = dt_s;
        if let Some(alone) = &self.alone {
            let steps = (dt_s / alone.reach_s).ceil().max(1.0);
            let step_s = dt_s / steps;
            let mut done = 0.0;
            while steps <= MOST_STEPS
                && done < steps
                && alone.step(&mut self.z, self.region, step_s)
            {
                done += 1.0;
            }
            rest_s = if done < steps { dt_s - done * step_s } else { 0.0 };
        }
        // From event to event.
        // Counted over one advance: real events are few within a tick of a controller.
        let mut events = 0;
        while rest_s > 0.0 {
            let propped = self.propped();
            let Some(flow) = &self.regions[self.region.index()] else { break };
            let fall = flow.scan(&mut self.z, rest_s, propped, &mut 0, u64::MAX);
            let Some(Fall { after_s, guard }) = fall else { break };
            rest_s -= after_s;
            self.pass(guard);
            events += 1;
            if events > MOST_EVENTS {
                let limit = MOST_EVENTS;
                let t_s = dt_s - rest_s;
                let suspect = self.suspect();
                return Err(DynamicsError::TooMuchWork { limit, what: "events", t_s, suspect });
            }
        }
        if in_bounds(&self.z) {
            return Ok(());
        }
        Err(DynamicsError::NotFinite { t_s: dt_s, suspect: self.suspect() })
    }

    /// Carries an event out.
    fn pass(&mut self, guard: usize) {
        match (self.region.motion, guard) {
            (_, CONTACT) => self.region.contact = !self.region.contact,
            (Motion::Rest, FIRST) => self.region.motion = Motion::Forward,
            (Motion::Rest, _) => self.region.motion = Motion::Backward,
            (moving, SECOND) => {
                // An inelastic impact: the lever stands on the stop, exactly.
                if let Some([low, high]) = self.parameters.stops_rad {
                    self.z[THETA] = if moving == Motion::Forward { high } else { low };
                }
                self.come_to_rest();
            }
            _ => self.come_to_rest(),
        }
        if guard == CONTACT {
            self.z[GAP] = 0.0; // a touch closes it, and a lift-off starts from nothing
        }
    }

    /// A lever whose velocity has reached zero; whether it stays is for the guards of rest to say.
    fn come_to_rest(&mut self) {
        self.z[OMEGA] = 0.0;
        self.region.motion = Motion::Rest;
    }

    /// The guard that cannot end a rest, because a stop stands in the way.
    fn propped(&self) -> Option<usize> {
        let [low, high] =
            self.parameters.stops_rad.filter(|_| self.region.motion == Motion::Rest)?;
        let theta = self.z[THETA];
        if theta >= high { Some(FIRST) } else { (theta <= low).then_some(SECOND) }
    }

    fn hand_m(&self) -> f64 {
        self.parameters.lever_m * self.z[THETA] + self.z[DEPTH] - self.z[GAP]
    }

    fn suspect(&self) -> String {
        self.parameters.suspect([self.z[MOTOR_COMMAND], self.z[BRAKE_COMMAND], self.z[INTENT]])
    }
}
