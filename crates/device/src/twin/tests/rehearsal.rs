//! Trials as they are run: the real loop, controller and guard, with an eye on what no sensor sees.

use super::super::{Twin, TwinParameters};
use crate::participant::draw::{Draw, Purpose};
pub(super) use crate::participant::intent::tests::SPRING;
pub(super) use crate::trial::tests::environment;
use crate::{
    Capabilities, Controller, Cue, Device, DeviceError, Guard, Intent, Limits, Person, Reading,
    SimulatedClock, TrialEnd, TrialPlan, run_trial,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use zwidth_dynamics::DrivenState;
use zwidth_study::{
    AnswerScale, Calibration, Environment, ModeLaw, Sample, Scene, Study, StudyId, Voltages,
    template,
};

pub(super) const WALL_RAD: f64 = 26.6 * std::f64::consts::PI / 180.0;
/// What a count of the angle sensor is at the lever, rad.
pub(super) const COUNT_RAD: f64 = TAU / 4096.0 * 11.0 / 75.0;
/// Below this force the brake lets go, N.
pub(super) const LET_GO_N: f64 = 2.0;

/// The laws of the template's modes.
pub(super) const LAWS: [ModeLaw; 3] = [ModeLaw::Active, ModeLaw::Passive, ModeLaw::Hybrid];

/// One tick: the plant's true state when it was read, and the sample made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RehearsedTick {
    pub(super) state: DrivenState,
    pub(super) sample: Sample,
}

pub(super) struct Rehearsal {
    pub(super) rows: Vec<RehearsedTick>,
    pub(super) intent: Intent,
    pub(super) answer: i16,
}

impl Rehearsal {
    /// Index of the last row at the largest angle.
    pub(super) fn top(&self) -> usize {
        let highest = self.rows.iter().map(|row| row.state.theta_rad).fold(f64::MIN, f64::max);
        self.rows.iter().rposition(|row| row.state.theta_rad >= highest).unwrap()
    }

    pub(super) fn top_rad(&self) -> f64 {
        self.rows[self.top()].state.theta_rad
    }

    pub(super) fn last(&self) -> &DrivenState {
        &self.rows[self.rows.len() - 1].state
    }

    pub(super) fn peak_n(&self) -> f64 {
        self.rows.iter().map(|row| row.state.contact_n).fold(0.0, f64::max)
    }

    /// Force going in less force coming back, both 3° below the largest angle, N.
    pub(super) fn step_at_reversal_n(&self) -> f64 {
        let below = self.top_rad() - 3.0_f64.to_radians();
        let going = self.rows.iter().find(|row| row.state.theta_rad >= below).unwrap();
        let coming =
            self.rows[self.top()..].iter().find(|row| row.state.theta_rad <= below).unwrap();
        going.state.contact_n - coming.state.contact_n
    }
}

pub(super) fn spring() -> Environment {
    environment(Scene::Spring(SPRING))
}

pub(super) fn wall() -> Environment {
    environment(Scene::SpringWall { spring: SPRING, wall_rad: WALL_RAD })
}

/// A twin that remembers its true state at each reading.
struct Watched<'a> {
    twin: &'a mut Twin,
    states: Vec<DrivenState>,
}

impl Device for Watched<'_> {
    fn capabilities(&self) -> &Capabilities {
        self.twin.capabilities()
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.twin.home(now_s)
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let reading = self.twin.read(now_s);
        self.states.push(self.twin.truth());
        reading
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.twin.write(now_s, voltages)
    }

    fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
        self.twin.begin(now_s, cue);
    }
}

/// One trial as a session would run it, from homing to the answer.
pub(super) fn rehearse(
    twin: &mut Twin,
    law: ModeLaw,
    place: &Environment,
    rate_hz: f64,
    trial: u32,
) -> Rehearsal {
    let study = Study::from_toml(&template(&StudyId::new("rehearsal").unwrap())).unwrap();
    let (mode, calibration) =
        (study.modes.iter().find(|mode| mode.law() == Some(law)).unwrap(), Calibration::thesis());
    let mut device = Watched { twin, states: Vec::new() };
    let mut guard = Guard::new(device.capabilities(), Limits::of(&study).unwrap(), false);
    guard.home(&mut device, 0.0).unwrap();
    guard.arm(mode, &calibration).unwrap();
    let plan = TrialPlan::new(&study, place, trial, device.capabilities()).unwrap();
    let plan = TrialPlan { rate_hz, ..plan };
    let mut controller = Controller::new(&study.control, place, mode, &calibration);
    let mut samples = Vec::new();
    let mut sink = |sample: &Sample| {
        samples.push(*sample);
        ControlFlow::Continue(())
    };
    let (mut clock, stop) = (SimulatedClock::new(u64::from(trial)), AtomicBool::new(false));
    let run =
        run_trial(&mut device, &mut clock, &mut controller, &mut guard, &plan, &stop, &mut sink);
    assert!(matches!(run.end, TrialEnd::Limit | TrialEnd::LetGo), "{:?}", run.end);
    let rows = device
        .states
        .iter()
        .zip(&samples)
        .map(|(&state, &sample)| RehearsedTick { state, sample })
        .collect();
    Rehearsal {
        rows,
        intent: *twin.intent(),
        answer: twin.answer(&AnswerScale::FivePoint).unwrap(),
    }
}

/// A device drawn from the whole range, every third number from an end of it, and a participant.
pub(super) fn drawn(seed: u64) -> (TwinParameters, Person) {
    let mut draw = Draw::new(seed, Purpose::Board, 2);
    let mut device = TwinParameters::default();
    for parameter in TwinParameters::table() {
        let share = draw.unit();
        let share = if draw.unit() < 1.0 / 3.0 { share.round() } else { share };
        *(parameter.field)(&mut device) =
            parameter.range[0] + share * (parameter.range[1] - parameter.range[0]);
    }
    (device, Person::draw(seed))
}
