//! The Z-width of a rig as a pure state machine: for each mode and damping the stiffest wall in which a free lever comes to
//! rest after a push.
//!
//! ```text
//! Home → Middle → Walls → (cooling →) rest → push → rest → push → … → kept → Walls → … → Done
//!   ↑      ↑_____________________________│ the lever has left the middle
//!   └──────────────────── cable pulled, safety, motor held back, stopped
//! ```
//!
//! A search is kept when it ends. What was tried of one that was stopped stays known until the program ends.

use crate::lever::stands;
use crate::step::{Action, Ask, Input, Remark, Steps};
use crate::{Heat, Winding};
use zwidth_device::{Push, PushEnd, PushRun, Trip, Weighed};
use zwidth_dynamics::Pushed;
use zwidth_stability::impedance::{Probe, Search};
use zwidth_study::Voltages;

/// A lever that was carried to the middle is looked at for so long, s.
const LEVER_S: f64 = 1.0;
/// Before each push the lever is looked at for so long, s.
const REST_S: f64 = 0.3;
/// The middle is this share of the work space.
const MIDDLE_SHARE: f64 = 0.5;
/// A lever that does not come to rest is looked at so often, until somebody is asked to bring it to the middle.
const MOST_LOOKS: u32 = 10;
/// A push that goes on moves by more than this share of itself, as the simulated device's does.
const GOES_ON_SHARE: f64 = 0.1;

/// A search of the stiffest wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallSearch {
    /// What is searched.
    pub probe: Probe,
    /// What its mode's motor and brake may have, V.
    pub most: Voltages,
}

/// What is to be done.
#[derive(Debug, Clone, PartialEq)]
pub struct WallPlan {
    /// The searches that are not there yet, in their order.
    pub searches: Vec<WallSearch>,
    /// How many are there.
    pub done: usize,
    /// How long each push is followed, s.
    pub lasts_s: f64,
    /// Length of the lever, m.
    pub lever_m: f64,
    /// A step of the angle at its end, m.
    pub count_m: f64,
    /// The motor's winding.
    pub winding: Winding,
    /// The work space, rad.
    pub stops_rad: [f64; 2],
}

/// Where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Home,
    Middle,
    Walls,
    Cooling,
    Rest { looks: u32 },
    Push,
    Stopped,
    Done,
}

/// A Z-width test.
#[derive(Debug, Clone)]
pub struct Walls {
    plan: WallPlan,
    phase: Phase,
    heat: Heat,
    /// Searches of the plan that are kept.
    kept: usize,
    search: Search,
    is_homed: bool,
    /// From which side the next push comes: each brings the lever back to where the one before it took it from.
    side: f64,
    /// Whether the guard stopped the last push against the same wall.
    has_tripped: bool,
}

impl Walls {
    /// A test that makes the searches of a plan.
    pub fn new(plan: WallPlan) -> Self {
        let heat = Heat::at_most(plan.winding, 0.0);
        Self {
            plan,
            phase: Phase::Home,
            heat,
            kept: 0,
            search: Search::default(),
            is_homed: false,
            side: 1.0,
            has_tripped: false,
        }
    }

    /// Searches that are there.
    pub fn done(&self) -> usize {
        self.plan.done + self.kept
    }

    fn ask(&mut self, phase: Phase, ask: Ask) -> Vec<Action> {
        self.phase = phase;
        vec![Action::Ask(ask)]
    }

    fn go_on(&mut self) -> Vec<Action> {
        match self.is_homed {
            true => self.ask(Phase::Middle, Ask::Middle),
            false => self.ask(Phase::Home, Ask::Home),
        }
    }

    /// Asks for somebody who watches the walls of the next search, or ends.
    fn walls(&mut self) -> Vec<Action> {
        let Some(WallSearch { probe, .. }) = self.plan.searches.get(self.kept) else {
            self.phase = Phase::Done;
            return vec![Action::Finish];
        };
        let of = self.plan.done + self.plan.searches.len();
        let ask = Ask::Walls { probe: *probe, number: self.done() + 1, of };
        self.ask(Phase::Walls, ask)
    }

    /// Whether the lever is at rest in the middle.
    fn is_in_middle(&self, values: &[Weighed]) -> bool {
        let [from_rad, to_rad] = self.plan.stops_rad;
        let off_rad = stands(values).map(|theta_rad| theta_rad - 0.5 * (from_rad + to_rad));
        off_rad.is_some_and(|off_rad| off_rad.abs() <= 0.5 * MIDDLE_SHARE * (to_rad - from_rad))
    }

    fn in_middle(&mut self, values: &[Weighed]) -> Vec<Action> {
        self.rested(values);
        match self.is_in_middle(values) {
            true => self.walls(),
            false => vec![Action::Tell(Remark::LeverElsewhere), Action::Ask(Ask::Middle)],
        }
    }

    fn rested(&mut self, values: &[Weighed]) {
        self.heat.rest(values.last().map_or(0.0, |value| value.t_s));
    }

    /// Waits until the motor may be driven for a whole push, then until the lever is at rest.
    fn next_push(&mut self) -> Vec<Action> {
        if self.search.next_n_per_m().is_err() {
            return self.keep();
        }
        let WallSearch { most, .. } = self.plan.searches[self.kept];
        let pause_s = self.heat.pause_s(most.motor_v * most.motor_v * self.plan.lasts_s);
        if pause_s > 0.0 {
            self.phase = Phase::Cooling;
            return vec![Action::Tell(Remark::Cooling(pause_s)), Action::Weigh(pause_s)];
        }
        self.phase = Phase::Rest { looks: 0 };
        vec![Action::Weigh(REST_S)]
    }

    fn at_rest(&mut self, looks: u32, values: &[Weighed]) -> Vec<Action> {
        self.rested(values);
        let Ok(stiffness_n_per_m) = self.search.next_n_per_m() else { return self.keep() };
        if !self.is_in_middle(values) {
            if looks >= MOST_LOOKS {
                let mut actions = vec![Action::Tell(Remark::LeverElsewhere)];
                actions.extend(self.ask(Phase::Middle, Ask::Middle));
                return actions;
            }
            self.phase = Phase::Rest { looks: looks + 1 };
            return vec![Action::Weigh(REST_S)];
        }
        let WallSearch { probe, most } = self.plan.searches[self.kept];
        self.phase = Phase::Push;
        vec![Action::Push(Push {
            stiffness_n_per_m,
            damping_ns_per_m: probe.damping_ns_per_m,
            push_m: self.side * probe.push_m,
            lever_m: self.plan.lever_m,
            most,
            lasts_s: self.plan.lasts_s,
        })]
    }

    fn pushed(&mut self, run: &PushRun) -> Vec<Action> {
        self.heat.drive(run.motor_v2_s);
        self.side = -self.side;
        let pushed = match &run.end {
            PushEnd::Followed | PushEnd::Grew => self.judged(run),
            PushEnd::Stopped => return self.stop("stopped".to_owned()),
            PushEnd::Unwatched => {
                let mut actions = vec![Action::Tell(Remark::Unwatched)];
                actions.extend(self.walls());
                return actions;
            }
            PushEnd::HeldBack => {
                self.is_homed = false;
                let mut actions = vec![Action::Tell(Remark::HeldBack)];
                actions.extend(self.go_on());
                return actions;
            }
            // A lever that swings so fast that its turns cannot be counted, out of its work space, or beyond the
            // force limit, swings.
            PushEnd::Tripped(
                trip @ (Trip::Angle(_) | Trip::Outside { .. } | Trip::Force { .. }),
            ) if is_across(run) => {
                let swing_m = self.judged(run).swing_m;
                self.search.take(Pushed { swing_m, goes_on: true, saturates: run.saturates });
                return self.stop(trip.to_string());
            }
            // A wall that the guard stops twice is as far as this rig goes: at least so stiff.
            PushEnd::Tripped(Trip::Force { .. }) if self.has_tripped => {
                Pushed { swing_m: 0.0, goes_on: false, saturates: true }
            }
            PushEnd::Tripped(trip) => {
                self.has_tripped = true;
                return self.stop(trip.to_string());
            }
        };
        self.has_tripped = false;
        self.search.take(pushed);
        self.next_push()
    }

    /// What a push did: as the simulated device's, by the last sixth of its course.
    fn judged(&self, run: &PushRun) -> Pushed {
        let WallSearch { probe, .. } = self.plan.searches[self.kept];
        let last_s = run.course.last().map_or(0.0, |[t_s, _]| *t_s);
        let has_grown = run.end == PushEnd::Grew;
        let tail = run.course.iter().filter(|[t_s, _]| has_grown || 6.0 * t_s >= 5.0 * last_s);
        let (low, high) = tail.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, x_m]| {
            (low.min(*x_m), high.max(*x_m))
        });
        let swing_m = 0.5 * (high - low).max(0.0);
        let goes_on =
            has_grown || (swing_m > GOES_ON_SHARE * probe.push_m && swing_m > self.plan.count_m);
        Pushed { swing_m, goes_on, saturates: run.saturates }
    }

    fn keep(&mut self) -> Vec<Action> {
        let WallSearch { probe, .. } = self.plan.searches[self.kept];
        let Some(found) = std::mem::take(&mut self.search).found() else { return self.walls() };
        self.kept += 1;
        // Told when it is safe.
        let mut actions = vec![
            Action::KeepSearch(probe, found.clone()),
            Action::Tell(Remark::Found(probe, found)),
        ];
        actions.extend(self.walls());
        actions
    }

    fn stop(&mut self, why: String) -> Vec<Action> {
        self.is_homed = false;
        let mut actions = vec![Action::Tell(Remark::Stopped(why))];
        actions.extend(self.ask(Phase::Stopped, Ask::GoOn));
        actions
    }
}

/// Whether the lever came out of the wall on its other side.
fn is_across(run: &PushRun) -> bool {
    let [_, first_m] = run.course.first().copied().unwrap_or_default();
    run.course.iter().any(|[_, x_m]| x_m * first_m < -GOES_ON_SHARE * first_m * first_m)
}

impl Steps for Walls {
    fn begin(&mut self) -> Vec<Action> {
        if self.plan.searches.is_empty() {
            return self.walls();
        }
        self.go_on()
    }

    fn step(&mut self, input: Input) -> Vec<Action> {
        match (self.phase, input) {
            (_, Input::Failed(why)) => self.stop(why),
            (Phase::Home, Input::Go) => vec![Action::Home],
            (Phase::Home, Input::Homed) => {
                self.is_homed = true;
                self.go_on()
            }
            (Phase::Middle, Input::Go) => vec![Action::Weigh(LEVER_S)],
            (Phase::Middle, Input::Weighed(values)) => self.in_middle(&values),
            (Phase::Walls, Input::Go) => self.next_push(),
            (Phase::Cooling, Input::Weighed(values)) => {
                self.rested(&values);
                // Nobody holds a key down for so long.
                self.walls()
            }
            (Phase::Rest { looks }, Input::Weighed(values)) => self.at_rest(looks, &values),
            (Phase::Push, Input::Pushed(run)) => self.pushed(&run),
            (Phase::Stopped, Input::Go) => self.go_on(),
            _ => Vec::new(),
        }
    }
}
