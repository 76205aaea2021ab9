//! The sensors of a rig as a pure state machine: its link and noise at rest, the load cell by masses,
//! its creep under the last of them, and the angle from stop to stop and back.
//!
//! ```text
//! Home → (rest) → Zero → Mass … → Hang → Home → Up → Back → Done
//! ```

use crate::LoadCell;
use crate::cell::SCALE_ERROR;
use crate::lever::stands;
use crate::step::{Action, Ask, Input, Remark, Steps};
use crate::weighing::{LOAD_S, Weighing};
use zwidth_device::Weighed;
use zwidth_numerics::moments::Moments;
use zwidth_study::Check;

/// A lever against a stop is looked at for so long, s.
const STOP_S: f64 = 1.0;

/// Stops may lie this far from where study.toml says, rad: 2°, what a session allows.
const STROKE_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// A lever that is back at its stop is seen there, rad: 0.3°. More is play, slack, or a miscount.
const RETURN_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;

/// A cell under a load may creep by this share of it.
const CREEP_SHARE: f64 = 0.01;

/// Of a load that hangs for long, the first and the last values that are compared, s.
const CREEP_ENDS_S: f64 = 2.0;

/// What the creep is called.
const CREEP: &str = "load cell creep";

/// What is to be done.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorPlan {
    /// The known masses, kg.
    pub masses_kg: Vec<f64>,
    /// The load cell's scale in `rig.toml`, N.
    pub newtons_per_count: f64,
    /// How long the last mass hangs, s.
    pub creep_s: f64,
    /// Where the stops are by study.toml, rad.
    pub stops_rad: [f64; 2],
}

/// Where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Home,
    Rest,
    Cell,
    Hang,
    HomeAgain,
    Up,
    Back,
    Stopped,
    Done,
}

/// The characterisation of the sensors.
#[derive(Debug, Clone)]
pub struct Sensors {
    plan: SensorPlan,
    phase: Phase,
    weighing: Weighing,
    cell: Option<LoadCell>,
    found: Vec<Check>,
}

impl Sensors {
    /// A characterisation from the beginning.
    pub fn new(plan: SensorPlan) -> Self {
        let weighing = Weighing::new(plan.masses_kg.clone(), plan.newtons_per_count);
        Self { plan, phase: Phase::Home, weighing, cell: None, found: Vec::new() }
    }

    /// What was found.
    pub fn found(&self) -> &[Check] {
        &self.found
    }

    fn find(&mut self, name: &str, value: f64, unit: &str, ok: bool) {
        // Found again after a stop: the newer value counts.
        self.found.retain(|check| check.name != name);
        self.found.push(Check { name: name.to_owned(), value, unit: unit.to_owned(), ok });
    }

    fn ask(&mut self, phase: Phase, ask: Ask) -> Vec<Action> {
        self.phase = phase;
        vec![Action::Ask(ask)]
    }

    /// After homing: on with what was under way.
    fn homed(&mut self) -> Vec<Action> {
        let has_crept = self.found.iter().any(|check| check.name == CREEP);
        if has_crept {
            return self.ask(Phase::Up, Ask::Up);
        }
        self.phase = Phase::Rest;
        vec![Action::Rest]
    }

    fn loaded(&mut self, values: &[Weighed]) -> Vec<Action> {
        let (mut actions, cell) = self.weighing.take(values);
        let Some(cell) = cell else { return actions };
        self.cell = Some(cell);
        self.find("load cell scale", cell.scale, "1", (cell.scale - 1.0).abs() <= SCALE_ERROR);
        self.find("load cell scale, standard error", cell.scale_error, "1", true);
        self.find("load cell zero", cell.zero_n, "N", true);
        actions.extend(self.ask(Phase::Hang, Ask::Hang(self.plan.creep_s)));
        actions
    }

    /// How much the last load changed while it hung.
    fn hung(&mut self, values: &[Weighed]) -> Vec<Action> {
        let end_s = values.last().map_or(0.0, |value| value.t_s);
        let mean = |from_s: f64, to_s: f64| {
            let inside = values.iter().filter(|value| (from_s..=to_s).contains(&value.t_s));
            let forces: Vec<f64> = inside.map(|value| value.force_n).collect();
            (!forces.is_empty()).then(|| Moments::of(&forces).mean)
        };
        let ends = mean(0.0, CREEP_ENDS_S).zip(mean(end_s - CREEP_ENDS_S, end_s));
        let load_n = self.cell.zip(ends).map(|(cell, (first_n, _))| cell.force_n(first_n));
        if let (Some((first_n, last_n)), Some(load_n)) = (ends, load_n) {
            let share = (last_n - first_n) / load_n.abs().max(f64::MIN_POSITIVE);
            self.find(CREEP, share, "1", share.abs() <= CREEP_SHARE);
            self.find("load cell creep, watched for", end_s, "s", true);
        }
        self.ask(Phase::HomeAgain, Ask::Home)
    }

    fn up(&mut self, values: &[Weighed]) -> Vec<Action> {
        let [low_rad, high_rad] = self.plan.stops_rad;
        let whole_rad = high_rad - low_rad;
        // Somebody has yet to bring it there.
        let stroke_rad = stands(values).map(|theta_rad| theta_rad - low_rad);
        let Some(stroke_rad) = stroke_rad.filter(|stroke| stroke.abs() > 0.5 * whole_rad) else {
            return vec![Action::Tell(Remark::LeverElsewhere), Action::Ask(Ask::Up)];
        };
        let is_whole = (stroke_rad - whole_rad).abs() <= STROKE_RAD;
        self.find("stroke", stroke_rad, "rad", is_whole);
        self.ask(Phase::Back, Ask::Back)
    }

    fn back(&mut self, values: &[Weighed]) -> Vec<Action> {
        let [low_rad, high_rad] = self.plan.stops_rad;
        let off_rad = stands(values).map(|theta_rad| theta_rad - low_rad);
        let Some(off_rad) = off_rad.filter(|off| off.abs() < 0.5 * (high_rad - low_rad)) else {
            return vec![Action::Tell(Remark::LeverElsewhere), Action::Ask(Ask::Back)];
        };
        self.find("angle after the way up and back", off_rad, "rad", off_rad.abs() <= RETURN_RAD);
        self.phase = Phase::Done;
        vec![Action::Finish]
    }
}

impl Steps for Sensors {
    fn begin(&mut self) -> Vec<Action> {
        self.ask(Phase::Home, Ask::Home)
    }

    fn step(&mut self, input: Input) -> Vec<Action> {
        match (self.phase, input) {
            (_, Input::Failed(why)) => {
                self.phase = Phase::Stopped;
                vec![Action::Tell(Remark::Stopped(why)), Action::Ask(Ask::GoOn)]
            }
            (Phase::Stopped, Input::Go) => self.ask(Phase::Home, Ask::Home),
            (Phase::Home | Phase::HomeAgain, Input::Go) => vec![Action::Home],
            (Phase::Home | Phase::HomeAgain, Input::Homed) => self.homed(),
            (Phase::Rest, Input::Rested(checks)) => {
                for check in checks {
                    self.find(&check.name, check.value, &check.unit, check.ok);
                }
                self.phase = Phase::Cell;
                self.weighing.begin()
            }
            (Phase::Cell, Input::Go) => vec![Action::Weigh(LOAD_S)],
            (Phase::Cell, Input::Weighed(values)) => self.loaded(&values),
            (Phase::Hang, Input::Go) => vec![Action::Weigh(self.plan.creep_s)],
            (Phase::Hang, Input::Weighed(values)) => self.hung(&values),
            (Phase::Up | Phase::Back, Input::Go) => vec![Action::Weigh(STOP_S)],
            (Phase::Up, Input::Weighed(values)) => self.up(&values),
            (Phase::Back, Input::Weighed(values)) => self.back(&values),
            _ => Vec::new(),
        }
    }
}
