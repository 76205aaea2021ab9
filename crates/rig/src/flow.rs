//! A characterisation as a pure state machine: inputs in, actions out. No clock, no device, no file.
//!
//! ```text
//! Home → Zero → Mass … → Clamp → (cooling →) Sweep → … → Done     motor
//! Home → Zero → Mass … → Back  → (cooling →) Sweep → Back → …     brake
//!   ↑      ↑               ↑______ clamp slipped, lever loose
//!   │      └────────────────────── cell drifts, masses wrong
//!   └───────────────────────────── cable pulled, safety, motor held back, stopped
//! ```
//!
//! Each step waits for a person, then for the device. A sweep that is whole and sound is kept at
//! once; what was kept is never asked for again. One that does not agree with those before is held
//! back and repeated: the next one decides which of both was odd.

use crate::lever::stands;
use crate::step::{Action, Ask, Input, Remark, Steps, SweepRun};
use crate::weighing::{LOAD_S, Weighing};
use crate::{Heat, LoadCell, SweepFault, Winding, judged};
use zwidth_device::{Ramp, RampEnd, Ramped, Weighed};
use zwidth_numerics::order::median;
use zwidth_study::ActuatorKind;

/// A lever that was moved is looked at for so long, s.
const LEVER_S: f64 = 1.0;

/// A lever in the fixture is at least this far from its stop, rad: 2°. Its sensor has proved itself.
const OFF_STOP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// A lever that was carried back is at least this near its stop, rad: 5°.
const AT_STOP_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Sweeps whose gains differ by more than this share do not agree.
const AGREE_SHARE: f64 = 0.03;

/// So many sweeps in a row that do not count need a person.
const MOST_IN_A_ROW: u32 = 5;

/// What is to be done.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How each sweep goes.
    pub ramp: Ramp,
    /// How many sweeps there are to be in the end.
    pub sweeps: u32,
    /// The known masses, kg.
    pub masses_kg: Vec<f64>,
    /// The winding that gets warm.
    pub winding: Winding,
    /// Where the lower stop is, rad.
    pub stop_rad: f64,
    /// The load cell's scale in `rig.toml`, N.
    pub newtons_per_count: f64,
}

/// A sweep that was kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kept {
    /// Its force per voltage, N/V.
    pub gain_n_per_v: f64,
}

/// What is there already.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recorded {
    /// The sweeps of this actuator.
    pub kept: Vec<Kept>,
    /// How long ago the last one ended, s; 0 where that is not known.
    pub rested_s: f64,
}

/// Where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// The load cell without a load, and with each mass in turn.
    Cell,
    Home,
    /// The lever to its place: into the clamp, or back to the stop.
    Place,
    Cooling,
    Sweep,
    Stopped,
    Done,
}

/// A characterisation.
#[derive(Debug, Clone)]
pub struct Flow {
    plan: Plan,
    phase: Phase,
    heat: Heat,
    weighing: Weighing,
    cell: Option<LoadCell>,
    is_homed: bool,
    kept: Vec<Kept>,
    /// A sound sweep that does not agree with those that are kept.
    odd: Option<SweepRun>,
    /// Force at 0 V at the end of the last sweep since the lever was clamped, N.
    rest_n: Option<f64>,
    in_a_row: u32,
}

impl Flow {
    /// A characterisation that goes on with what is there.
    pub fn new(plan: Plan, recorded: Recorded) -> Self {
        let heat = Heat::at_most(plan.winding, recorded.rested_s);
        let weighing = Weighing::new(plan.masses_kg.clone(), plan.newtons_per_count);
        Self {
            plan,
            phase: Phase::Cell,
            heat,
            weighing,
            cell: None,
            is_homed: false,
            kept: recorded.kept,
            odd: None,
            rest_n: None,
            in_a_row: 0,
        }
    }

    /// Sweeps that are kept.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    fn is_complete(&self) -> bool {
        self.kept.len() >= self.plan.sweeps as usize
    }

    fn is_motor(&self) -> bool {
        self.plan.ramp.actuator == ActuatorKind::Motor
    }

    /// Where to go on after a stop: nothing that is known is asked for again.
    fn go_on(&mut self) -> Vec<Action> {
        // First, because homing connects a lost board anew, and from then on it is read without a gap.
        if !self.is_homed {
            self.phase = Phase::Home;
            return vec![Action::Ask(Ask::Home)];
        }
        if self.cell.is_none() {
            return self.cell_anew();
        }
        self.place()
    }

    /// The load cell from the beginning.
    fn cell_anew(&mut self) -> Vec<Action> {
        self.phase = Phase::Cell;
        (self.cell, self.rest_n) = (None, None);
        self.weighing.begin()
    }

    fn loaded(&mut self, values: &[Weighed]) -> Vec<Action> {
        let (mut actions, cell) = self.weighing.take(values);
        if cell.is_some() {
            self.cell = cell;
            actions.extend(self.go_on());
        }
        actions
    }

    /// Asks for the lever in its place.
    fn place(&mut self) -> Vec<Action> {
        self.phase = Phase::Place;
        self.rest_n = None;
        vec![Action::Ask(self.place_ask())]
    }

    fn place_ask(&self) -> Ask {
        if self.is_motor() { Ask::Clamp } else { Ask::Back }
    }

    fn placed(&mut self, values: &[Weighed]) -> Vec<Action> {
        let is_there = stands(values).is_some_and(|theta_rad| {
            let from_stop_rad = theta_rad - self.plan.stop_rad;
            if self.is_motor() { from_stop_rad > OFF_STOP_RAD } else { from_stop_rad < AT_STOP_RAD }
        });
        if !is_there {
            return vec![Action::Tell(Remark::LeverElsewhere), Action::Ask(self.place_ask())];
        }
        self.heat.rest(values.last().map_or(0.0, |value| value.t_s));
        self.cool()
    }

    /// Waits until a sweep is allowed.
    fn cool(&mut self) -> Vec<Action> {
        let pause_s = self.heat.pause_s(self.plan.ramp.v2_s());
        if pause_s > 0.0 {
            self.phase = Phase::Cooling;
            return vec![Action::Tell(Remark::Cooling(pause_s)), Action::Weigh(pause_s)];
        }
        self.ask_for_sweep()
    }

    fn ask_for_sweep(&mut self) -> Vec<Action> {
        self.phase = Phase::Sweep;
        let number = u32::try_from(self.kept.len()).unwrap_or(u32::MAX).saturating_add(1);
        vec![Action::Ask(Ask::Sweep { ramp: self.plan.ramp, number, of: self.plan.sweeps })]
    }

    fn ramped(&mut self, ramped: &Ramped) -> Vec<Action> {
        // A part of a ramp counts as whole.
        self.heat.drive(self.plan.ramp.v2_s());
        match &ramped.end {
            RampEnd::Whole => self.whole(&ramped.values),
            RampEnd::Stopped => self.stop("stopped".to_owned()),
            RampEnd::Unwatched => self.again(Remark::Unwatched),
            RampEnd::Loose => {
                let mut actions = self.again(Remark::Loose);
                if self.phase != Phase::Stopped {
                    actions.truncate(1);
                    actions.extend(self.place());
                }
                actions
            }
            RampEnd::HeldBack => {
                self.is_homed = false;
                let mut actions = vec![Action::Tell(Remark::HeldBack)];
                actions.extend(self.go_on());
                actions
            }
            // Whatever safety found, the lever is asked for at its stop again.
            RampEnd::Tripped(trip) => self.stop(trip.to_string()),
        }
    }

    fn whole(&mut self, values: &[Weighed]) -> Vec<Action> {
        let Some(cell) = self.cell else { return self.cell_anew() };
        match judged(values, &self.plan.ramp, &cell, self.rest_n) {
            Ok(judged) => {
                self.in_a_row = 0;
                self.rest_n = Some(judged.rest_n);
                self.sound(SweepRun { judged, ramp: self.plan.ramp, cell })
            }
            Err(fault) if fault.is_lasting() => self.stop(fault.to_string()),
            Err(fault) => {
                let needs_zero = fault.needs_zero();
                let is_slip = matches!(fault, SweepFault::Slip { .. });
                let mut actions = self.again(Remark::SweepFault(fault));
                if self.phase != Phase::Stopped && (needs_zero || is_slip) {
                    actions.truncate(1);
                    actions.extend(if needs_zero { self.cell_anew() } else { self.place() });
                }
                actions
            }
        }
    }

    /// Another try of the same sweep, until there were too many.
    fn again(&mut self, remark: Remark) -> Vec<Action> {
        self.in_a_row += 1;
        if self.in_a_row >= MOST_IN_A_ROW {
            let mut actions = vec![Action::Tell(remark)];
            actions.extend(self.stop(format!("{MOST_IN_A_ROW} sweeps in a row do not count")));
            return actions;
        }
        let mut actions = vec![Action::Tell(remark)];
        actions.extend(self.next_sweep());
        actions
    }

    /// A brake's lever comes back first.
    fn next_sweep(&mut self) -> Vec<Action> {
        if self.is_motor() {
            return self.cool();
        }
        self.phase = Phase::Place;
        vec![Action::Ask(Ask::Back)]
    }

    fn sound(&mut self, run: SweepRun) -> Vec<Action> {
        let gain = run.judged.gain_n_per_v;
        let earlier = median(self.kept.iter().map(|kept| kept.gain_n_per_v));
        let agrees = |with: f64| (gain - with).abs() <= AGREE_SHARE * with.abs();
        let odd = self.odd.take();
        let mut actions = Vec::new();
        match (earlier, odd) {
            (Some(earlier), None) if !agrees(earlier) => {
                actions.push(Action::Tell(Remark::Odd([gain, earlier])));
                self.odd = Some(run);
                actions.extend(self.next_sweep());
                return actions;
            }
            (Some(earlier), Some(odd)) if !agrees(earlier) => {
                if !agrees(odd.judged.gain_n_per_v) {
                    // Three that differ: the newest is the one to compare with.
                    actions.push(Action::Tell(Remark::Odd([gain, earlier])));
                    self.odd = Some(run);
                    self.in_a_row += 1;
                    if self.in_a_row >= MOST_IN_A_ROW {
                        actions.extend(self.stop("sweeps do not agree with each other".to_owned()));
                    } else {
                        actions.extend(self.next_sweep());
                    }
                    return actions;
                }
                actions.push(Action::Tell(Remark::Changed));
                self.keep(odd, &mut actions);
            }
            (_, Some(_)) => actions.push(Action::Tell(Remark::OddLeftOut)),
            _ => {}
        }
        self.keep(run, &mut actions);
        if self.is_complete() {
            self.phase = Phase::Done;
            actions.push(Action::Finish);
        } else {
            actions.extend(self.next_sweep());
        }
        actions
    }

    fn keep(&mut self, run: SweepRun, actions: &mut Vec<Action>) {
        self.kept.push(Kept { gain_n_per_v: run.judged.gain_n_per_v });
        // Told when it is safe.
        let kept = Remark::Kept(run.judged.clone());
        actions.extend([Action::Keep(run), Action::Tell(kept)]);
    }

    fn stop(&mut self, why: String) -> Vec<Action> {
        self.phase = Phase::Stopped;
        // Whoever mends something may have moved the lever.
        self.is_homed = false;
        vec![Action::Tell(Remark::Stopped(why)), Action::Ask(Ask::GoOn)]
    }
}

impl Steps for Flow {
    fn begin(&mut self) -> Vec<Action> {
        if self.is_complete() {
            self.phase = Phase::Done;
            return vec![Action::Finish];
        }
        self.go_on()
    }

    fn step(&mut self, input: Input) -> Vec<Action> {
        match (self.phase, input) {
            (_, Input::Failed(why)) => self.stop(why),
            (Phase::Cell, Input::Go) => vec![Action::Weigh(LOAD_S)],
            (Phase::Cell, Input::Weighed(values)) => self.loaded(&values),
            (Phase::Home, Input::Go) => vec![Action::Home],
            (Phase::Home, Input::Homed) => {
                self.is_homed = true;
                self.go_on()
            }
            (Phase::Place, Input::Go) => vec![Action::Weigh(LEVER_S)],
            (Phase::Place, Input::Weighed(values)) => self.placed(&values),
            (Phase::Cooling, Input::Weighed(values)) => {
                let rested_s = values.last().map_or(0.0, |value| value.t_s);
                self.heat.rest(rested_s);
                self.ask_for_sweep()
            }
            (Phase::Sweep, Input::Go) => vec![Action::Ramp(self.plan.ramp)],
            (Phase::Sweep, Input::Ramped(ramped)) => self.ramped(&ramped),
            (Phase::Stopped, Input::Go) => {
                self.in_a_row = 0;
                self.go_on()
            }
            _ => Vec::new(),
        }
    }
}
