//! A run of a model of the family.

use crate::model::{Loop, Model};
use crate::sensors::{Seen, Sensors};
use std::collections::VecDeque;
use zwidth_device::{FORWARD_RAD_S, HOLDING_RAD_S};
use zwidth_dynamics::{
    DriveMode, DynamicsError, Exact, Grid, HeldCommand, HeldRun, HeldScene, Solver, System,
    WorkCounts,
};
use zwidth_results::LadderTerm;

/// Width of the chords of a weight, rad: 10°, which miss it by 0.4 % of its largest force.
const CHORD_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Ticks of about this length, s, make a controller as good as continuous: no hand tells a command
/// that is held so long from one that follows.
const FINE_S: f64 = 0.0005;
/// The least and the largest number of these ticks in a period.
const FINE: (f64, f64) = (2.0, 8.0);

/// Motion and force of a run against time: all as long as `t_s`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Times, s, evenly apart.
    pub t_s: Vec<f64>,
    /// θ, rad.
    pub theta_rad: Vec<f64>,
    /// θ̇, rad/s.
    pub theta_dot_rad_s: Vec<f64>,
    /// F_ex, N: the user's force.
    pub force_ex_n: Vec<f64>,
    /// The actuators' force against the user, N.
    pub feedback_n: Vec<f64>,
    /// Lever length, m.
    pub lever_m: f64,
}

/// The cost of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// The solver's own counts.
    pub work: WorkCounts,
    /// Number of times that the controller measured and decided.
    pub decisions: u64,
    /// Entries of the state.
    pub entries: u64,
}

impl Cost {
    /// One number by which to compare models: evaluations, as [`WorkCounts::in_evaluations`] counts
    /// them (an exponential of n entries counts as n products), and one per decision. It does not
    /// depend on the machine, and is not a time.
    pub fn in_evaluations(&self) -> u64 {
        self.work.evaluations + self.work.factorisations * self.entries + self.decisions
    }
}

/// The times at which courses are kept: every `every` periods of the loop, `steps` times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) every: usize,
    pub(crate) steps: usize,
    pub(crate) period_s: f64,
}

impl Frame {
    /// About every 2 ms, or every period where that is longer.
    pub(crate) fn of(duration_s: f64, period_s: f64) -> Self {
        const KEPT_S: f64 = 0.002;
        let every = (KEPT_S / period_s).round().max(1.0) as usize;
        let steps = (duration_s / (every as f64 * period_s) * (1.0 + 1e-9)) as usize;
        Self { every, steps, period_s }
    }

    pub(crate) fn step_s(&self) -> f64 {
        self.every as f64 * self.period_s
    }
}

/// Runs a model.
pub(crate) fn run(
    model: &Model,
    looped: &Loop,
    frame: &Frame,
) -> Result<(Course, Cost), DynamicsError> {
    let digital = [LadderTerm::Sampling, LadderTerm::Delay, LadderTerm::Sensors];
    if digital.iter().any(|term| model.set.has(*term)) {
        ticked(model, looped, frame)
    } else {
        continuous(model, frame)
    }
}

/// Runs a model whose law acts at every instant.
fn continuous(model: &Model, frame: &Frame) -> Result<(Course, Cost), DynamicsError> {
    let system = System::by_chords(model.scene.clone(), CHORD_RAD)?;
    let grid = Grid::Even { step_s: frame.step_s(), steps: frame.steps };
    let run = Exact::default().run(&system, &grid)?;
    let mut course = Course { lever_m: model.scene.plant.lever_m, ..Course::default() };
    for i in 0..run.len() {
        let forces = run.forces(&system, i);
        course.force_ex_n.push(forces.external_n);
        course.feedback_n.push(-(forces.motor_n + forces.brake_n));
    }
    course.theta_rad = run.theta_rad().collect();
    course.theta_dot_rad_s = run.theta_dot_rad_s().collect();
    let entries = run.layout.n as u64;
    course.t_s = run.t_s;
    Ok((course, Cost { work: run.work, decisions: 0, entries }))
}

/// Runs a model whose controller decides at ticks.
fn ticked(model: &Model, looped: &Loop, frame: &Frame) -> Result<(Course, Cost), DynamicsError> {
    let fine = match model.set.has(LadderTerm::Sampling) {
        true => 1,
        false => (looped.period_s / FINE_S).round().clamp(FINE.0, FINE.1) as usize,
    };
    let tick_s = looped.period_s / fine as f64;
    // Half a fine tick is what the hold delays by itself.
    let own_s = if fine == 1 { 0.0 } else { 0.5 * tick_s };
    let delay_s = (model.delay_s - own_s).max(0.0);
    let scene = HeldScene::new(&model.scene, CHORD_RAD)?;
    let mut run = scene.start(tick_s)?;
    let sees = model.set.has(LadderTerm::Sensors);
    let mut control = Control {
        sensors: sees.then(|| Sensors::new(model, &looped.velocity)),
        takes_over: model.scene.mode == DriveMode::Hybrid,
        let_go_n: model.scene.brake.let_go_n,
        forward: false,
        compressing: false,
    };
    let mut course = Course { lever_m: model.scene.plant.lever_m, ..Course::default() };
    let mut waiting: VecDeque<(f64, HeldCommand)> = VecDeque::new();
    let per_sample = frame.every * fine;
    let ticks = frame.steps * frame.every * fine;
    for k in 0..=ticks {
        let t_s = k as f64 * tick_s;
        run.advance(t_s)?;
        waiting.push_back((t_s + delay_s, control.decide(&scene, &run)));
        act(&mut run, &mut waiting, t_s)?;
        if k % per_sample == 0 {
            let forces = run.forces();
            // The times of a continuous run, to the bit: a tick's own time may be rounded
            // otherwise.
            course.t_s.push((k / per_sample) as f64 * frame.step_s());
            course.theta_rad.push(run.theta_rad());
            course.theta_dot_rad_s.push(run.theta_dot_rad_s());
            course.force_ex_n.push(forces.external_n);
            course.feedback_n.push(-(forces.motor_n + forces.brake_n));
        }
        // A delayed command acts between ticks, when its time comes.
        let next_s = (k + 1) as f64 * tick_s;
        while k < ticks && waiting.front().is_some_and(|(at_s, _)| *at_s < next_s) {
            if let Some((at_s, _)) = waiting.front() {
                run.advance(*at_s)?;
            }
            let now_s = run.t_s();
            act(&mut run, &mut waiting, now_s)?;
        }
    }
    let decisions = ticks as u64 + 1;
    let entries = scene.entries() as u64;
    Ok((course, Cost { work: run.work(), decisions, entries }))
}

/// Holds the last command whose time has come.
fn act(
    run: &mut HeldRun<'_>,
    waiting: &mut VecDeque<(f64, HeldCommand)>,
    now_s: f64,
) -> Result<(), DynamicsError> {
    let mut due = None;
    while waiting.front().is_some_and(|(at_s, _)| *at_s <= now_s) {
        due = waiting.pop_front();
    }
    due.map_or(Ok(()), |(_, command)| run.hold(command))
}

/// The prototype's rule for which actuator is in charge (thesis §6.2.1).
struct Control {
    sensors: Option<Sensors>,
    takes_over: bool,
    let_go_n: Option<f64>,
    forward: bool,
    compressing: bool,
}

impl Control {
    fn decide(&mut self, scene: &HeldScene, run: &HeldRun<'_>) -> HeldCommand {
        let truth = Seen {
            theta_rad: run.theta_rad(),
            theta_dot_rad_s: run.theta_dot_rad_s(),
            force_n: run.force_ex_n(),
        };
        let seen = match &mut self.sensors {
            Some(sensors) => sensors.see(run.t_s(), truth),
            None => truth,
        };
        // A counted angle makes a slow velocity flicker; a true one needs no hysteresis.
        let least = match (&self.sensors, self.forward) {
            (None, _) => 0.0,
            (Some(_), true) => HOLDING_RAD_S,
            (Some(_), false) => FORWARD_RAD_S,
        };
        self.forward = seen.theta_dot_rad_s > least;
        let keeps = self.let_go_n.is_some_and(|threshold| seen.force_n >= threshold);
        self.compressing = self.forward || (self.takes_over && self.compressing && keeps);
        scene.asked(seen.theta_rad, seen.theta_dot_rad_s, self.compressing)
    }
}
