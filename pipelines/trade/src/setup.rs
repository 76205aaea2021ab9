//! The simulated device with another loop or other sensors: what a study would have recorded.
//!
//! A degraded recording leaves the motion as it was; here the controller acts on what the setup
//! lets it see, and the hand feels the result. Person, board and intent stay the same: a trial at
//! another setup is the same trial.

use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use zwidth_device::{
    Angle, Capabilities, Controller, Cue, Device, DeviceError, Guard, Limits, Reading, Refusal,
    SimulatedClock, TrialEnd, TrialPlan, Trip, Twin, run_trial,
};
use zwidth_results::LessKind;
use zwidth_store::Samples;
use zwidth_study::{
    AnswerScale, Calibration, Environment, Mode, Sample, Study, VelocityFilter, Voltages,
};
use zwidth_tables::Table;

/// What differs from the study's own device and loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Setup {
    /// Nothing.
    Own,
    /// Ticks of the loop, and samples, per second.
    SampleRateHz(f64),
    /// An angle of so many bits in a turn of the shaft; the simulated device's has 12.
    AngleBits(u32),
    /// New values of the force so often, Hz, held between them.
    ForceRateHz(f64),
    /// The velocity's low-pass at this frequency, Hz.
    VelocityCutoffHz(f64),
    /// A velocity that is the difference of two angles.
    VelocityDifference,
}

impl Setup {
    /// All that are tried, those of a kind together. No rate below 30 Hz: the board would take the
    /// voltages away between two ticks.
    pub const ALL: [Self; 12] = [
        Self::SampleRateHz(1000.0),
        Self::SampleRateHz(500.0),
        Self::SampleRateHz(60.0),
        Self::SampleRateHz(30.0),
        Self::AngleBits(11),
        Self::AngleBits(10),
        Self::AngleBits(8),
        Self::ForceRateHz(10.0),
        Self::VelocityCutoffHz(20.0),
        Self::VelocityCutoffHz(10.0),
        Self::VelocityCutoffHz(5.0),
        Self::VelocityDifference,
    ];

    /// The kind of change that it is a degree of.
    pub fn kind(self) -> LessKind {
        match self {
            Self::Own => LessKind::AsItIs,
            Self::SampleRateHz(_) => LessKind::Rate,
            Self::AngleBits(_) => LessKind::Angle,
            Self::ForceRateHz(_) => LessKind::Force,
            Self::VelocityCutoffHz(_) | Self::VelocityDifference => LessKind::Filter,
        }
    }

    /// In words.
    pub fn words(self) -> String {
        match self {
            Self::Own => "as it is".to_owned(),
            Self::SampleRateHz(rate) => format!("loop at {rate} Hz"),
            Self::AngleBits(bits) => format!("angle of {bits} bits"),
            Self::ForceRateHz(rate) => format!("force at {rate} Hz"),
            Self::VelocityCutoffHz(cutoff) => format!("velocity filtered at {cutoff} Hz"),
            Self::VelocityDifference => "velocity unfiltered".to_owned(),
        }
    }

    /// The study with it.
    pub fn of(self, study: &Study) -> Study {
        let mut study = study.clone();
        match self {
            Self::Own | Self::AngleBits(_) => {}
            Self::SampleRateHz(rate_hz) => study.control.rate_hz = rate_hz,
            Self::ForceRateHz(rate_hz) => study.device.force_rate_hz = Some(rate_hz),
            Self::VelocityCutoffHz(cutoff_hz) => {
                study.control.velocity = VelocityFilter::SecondOrder { cutoff_hz };
            }
            Self::VelocityDifference => study.control.velocity = VelocityFilter::Difference,
        }
        study
    }

    /// Those that a study does not have already.
    pub fn others(study: &Study) -> Vec<Self> {
        Self::ALL
            .into_iter()
            // The bits of an angle are the device's alone: no study states them.
            .filter(|setup| setup.of(study) != *study || matches!(setup, Self::AngleBits(_)))
            .collect()
    }
}

/// Metrics of the same trials at the study's own setup and at another, one row per trial.
#[derive(Debug, Clone)]
pub struct Rehearsed {
    /// The other setup.
    pub setup: Setup,
    /// As it is.
    pub own: Table,
    /// With the setup.
    pub changed: Table,
}

/// Why a simulated trial gives no recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Stopped {
    /// The mode is not allowed on such a device.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// Safety took the voltages away.
    #[error(transparent)]
    Tripped(#[from] Trip),
    /// The device or the study makes no sense.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// One trial of a study on the simulated device with another setup, from homing to letting go.
///
/// # Errors
/// Safety refuses the mode or ends the trial; a study that does not say what a device needs.
pub fn rehearse(
    twin: Twin,
    setup: Setup,
    study: &Study,
    (environment, mode, trial): (&Environment, &Mode, u32),
    calibration: &Calibration,
) -> Result<Samples, Stopped> {
    let study = setup.of(study);
    let mut device = Coarse::new(twin, setup);
    let capabilities = device.capabilities.clone();
    let mut guard = Guard::new(&capabilities, Limits::of(&study)?, false);
    guard.home(&mut device, 0.0)?;
    guard.arm(mode, calibration)?;
    let plan = TrialPlan::new(&study, environment, trial, &capabilities)?;
    let mut controller = Controller::new(&study.control, environment, mode, calibration);
    let mut rows: Vec<Sample> = Vec::new();
    let mut clock = SimulatedClock::new(u64::from(trial));
    let stop = AtomicBool::new(false);
    let run = run_trial(
        &mut device,
        &mut clock,
        &mut controller,
        &mut guard,
        &plan,
        &stop,
        &mut |sample: &Sample| {
            rows.push(*sample);
            ControlFlow::Continue(())
        },
    );
    match run.end {
        TrialEnd::Tripped(trip) => Err(trip.into()),
        TrialEnd::Limit | TrialEnd::LetGo | TrialEnd::Stopped => Ok(Samples::from_rows(&rows)),
    }
}

/// The simulated device seen through coarser sensors.
struct Coarse {
    twin: Twin,
    capabilities: Capabilities,
    /// Bits of a count that are not there.
    missing_bits: u32,
    force_rate_hz: Option<f64>,
    /// When the trial began, s.
    begun_s: f64,
    held: Option<HeldForce>,
}

/// The force that the coarser sensor shows.
#[derive(Clone, Copy)]
struct HeldForce {
    /// When it was taken, s.
    since_s: f64,
    force_n: f64,
}

impl Coarse {
    fn new(twin: Twin, setup: Setup) -> Self {
        let mut capabilities = twin.capabilities().clone();
        let mut missing_bits = 0;
        if let (Setup::AngleBits(bits), Some(counts)) = (setup, capabilities.counts_per_turn) {
            // Shifted out of a count, as a coarser sensor would give it, not rounded.
            missing_bits = counts.ilog2().saturating_sub(bits);
            capabilities.counts_per_turn = Some(counts >> missing_bits);
        }
        let force_rate_hz = if let Setup::ForceRateHz(rate_hz) = setup {
            capabilities.force_rate_hz = rate_hz.min(capabilities.force_rate_hz);
            Some(rate_hz)
        } else {
            None
        };
        Self { twin, capabilities, missing_bits, force_rate_hz, begun_s: 0.0, held: None }
    }

    fn seen(&mut self, now_s: f64, reading: Reading) -> Reading {
        let angle = match reading.angle {
            Angle::Counts(counts) => Angle::Counts(counts >> self.missing_bits),
            angle @ Angle::Lever(_) => angle,
        };
        let (Some(rate_hz), Some(age_s)) = (self.force_rate_hz, reading.force_age_s) else {
            return Reading { angle, ..reading };
        };
        let taken_s = now_s - age_s;
        let periods = |t_s: f64| ((t_s - self.begun_s) * rate_hz).floor();
        let fresh = HeldForce { since_s: taken_s, force_n: reading.force_n };
        if self.held.is_none_or(|held| periods(taken_s) > periods(held.since_s)) {
            self.held = Some(fresh);
        }
        let HeldForce { since_s, force_n } = self.held.unwrap_or(fresh);
        Reading { angle, force_n, force_age_s: Some(now_s - since_s), ..reading }
    }
}

impl Device for Coarse {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.held = None;
        let reading = self.twin.home(now_s)?;
        Ok(self.seen(now_s, reading))
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let reading = self.twin.read(now_s)?;
        Ok(self.seen(now_s, reading))
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.twin.write(now_s, voltages)
    }

    fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
        (self.begun_s, self.held) = (now_s, None);
        self.twin.begin(now_s, cue);
    }

    fn answer(&mut self, on: &AnswerScale) -> Option<i16> {
        self.twin.answer(on)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use zwidth_device::{Person, SHAFT_PER_LEVER, TwinParameters};
    use zwidth_store::Signal;
    use zwidth_study::{StudyId, template};

    fn study() -> Study {
        let text = template(&StudyId::new("setups").unwrap());
        let mut study = Study::from_toml(&text).unwrap();
        study.control.rate_hz = 120.0;
        study
    }

    /// The template's first environment in its mode of a number.
    fn trial(setup: Setup, mode: usize) -> Result<Samples, Stopped> {
        let (study, person) = (study(), Person::typical(7));
        let twin = Twin::new(TwinParameters::default(), person, 3).unwrap();
        let what = (&study.environments[0], &study.modes[mode], 1);
        rehearse(twin, setup, &study, what, &Calibration::thesis())
    }

    #[test]
    fn a_trial_is_the_same_every_time_and_goes_the_person_s_way() {
        let own = trial(Setup::Own, 0).unwrap();
        assert_eq!(own, trial(Setup::Own, 0).unwrap());
        let top = own.get(Signal::Theta).unwrap().iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((20.0..45.0).contains(&top.to_degrees()), "{top}");
    }

    #[test]
    fn the_same_intent_at_another_rate_reaches_the_same_angle_with_other_samples() {
        let top = |samples: &Samples| {
            samples.get(Signal::Theta).unwrap().iter().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        let (own, fast) =
            (trial(Setup::Own, 0).unwrap(), trial(Setup::SampleRateHz(1000.0), 0).unwrap());
        assert!(fast.len() > 8 * own.len());
        assert!((top(&own) - top(&fast)).abs() < 2_f64.to_radians());
    }

    #[test]
    fn an_angle_of_8_bits_has_steps_of_a_256th_of_the_shaft_s_turn() {
        let samples = trial(Setup::AngleBits(8), 0).unwrap();
        let count_rad = TAU / SHAFT_PER_LEVER / 256.0;
        let theta = samples.get(Signal::Theta).unwrap();
        let steps = theta.windows(2).map(|pair| (pair[1] - pair[0]) / count_rad);
        let off = steps.map(|step| (step - step.round()).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{off}");
    }

    #[test]
    fn a_force_of_10_hz_is_held_for_a_tenth_of_a_second_and_is_no_force_to_switch_on() {
        let samples = trial(Setup::ForceRateHz(10.0), 0).unwrap();
        let (t, force) =
            (samples.get(Signal::Time).unwrap(), samples.get(Signal::ForceEx).unwrap());
        let changes = force.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 0.0).count();
        let most = 10.0 * t[t.len() - 1] + 1.0;
        assert!(changes as f64 <= most && changes > 10, "{changes} of {most}");
        let oldest = samples.get(Signal::ForceAge).unwrap().iter().copied().fold(0.0, f64::max);
        assert!((0.08..0.13).contains(&oldest), "{oldest}");
        assert!(matches!(trial(Setup::ForceRateHz(10.0), 2), Err(Stopped::Refused(_))));
    }

    #[test]
    fn a_study_is_not_compared_with_what_it_has_already() {
        let mut study = study();
        study.control.rate_hz = 500.0;
        let others = Setup::others(&study);
        assert_eq!(others.len(), Setup::ALL.len() - 1);
        assert!(!others.contains(&Setup::SampleRateHz(500.0)));
    }
}
