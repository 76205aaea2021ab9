//! Whole characterisations over each link, in simulated time: the board in software, behind it the
//! simulated rig, and at the bench an operator by script.

mod walls;

use super::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;
use zwidth_device::{
    Attendant, Device, Faults, Fixture, Guard, Hands, HandsHandle, Limits, Ramp, Station,
    TwinParameters,
};
use zwidth_link::simulated::{Bench as Wires, Trouble, Way};
use zwidth_link::{Board, Drive, LINKS, Settings, over};
use zwidth_store::{Layout, RealFiles, Sweep, read_sweep};
use zwidth_study::{ActuatorKind, Calibration, Check, Source};

/// Readings per second of a link that streams, and the loop's ticks for it.
const STREAM_HZ: f64 = 100.0;
const LOOP_HZ: f64 = 125.0;
/// Ticks a second over frames.
const FRAMED_HZ: f64 = 500.0;
/// A winding that hardly gets warm: no test waits for it.
const COOL: Winding = Winding { resistance_ohm: 1e6, mass_kg: 1.0, cooling_s: 60.0 };
const MASSES_KG: [f64; 2] = [0.1, 0.2];

/// What goes wrong in a run.
#[derive(Clone, Copy, Default)]
struct Wrong {
    /// Of the device's noise.
    seed: u64,
    faults: Faults,
    /// Before this question, counted from 1, the board's cable is pulled for a moment…
    pulled_at: Option<usize>,
    /// …or so many messages after it was answered.
    messages: u64,
    /// At this question the program is gone.
    gone_at: Option<usize>,
    /// What the masses are called, where that is wrong.
    called_kg: Option<[f64; 2]>,
}

/// A study's folder, and what is at the bench.
struct Desk {
    folder: TempDir,
    link: &'static str,
    plan: Plan,
}

impl Desk {
    fn new(link: &'static str, actuator: ActuatorKind) -> Self {
        let top_v = if actuator == ActuatorKind::Motor { 16.0 } else { 8.0 };
        let plan = Plan {
            ramp: Ramp { actuator, top_v, lasts_s: 8.0 },
            sweeps: 3,
            masses_kg: MASSES_KG.to_vec(),
            winding: COOL,
            stop_rad: -std::f64::consts::FRAC_PI_4,
            newtons_per_count: 1e-4,
        };
        Self { folder: tempfile::tempdir().unwrap(), link, plan }
    }

    fn layout(&self) -> Layout {
        Layout::new(self.folder.path(), "demo".parse().unwrap())
    }

    /// The sweeps of an actuator.
    fn sweeps(&self, actuator: &str) -> Vec<Sweep> {
        let id = actuator.parse().unwrap();
        (1..)
            .map(|number| self.layout().sweep(&id, number))
            .take_while(|path| path.exists())
            .map(|path| read_sweep(&path).unwrap())
            .collect()
    }

    fn recorded(&self) -> Recorded {
        let sweeps = self.sweeps(self.plan.ramp.actuator.as_str());
        Recorded { kept: sweeps.iter().filter_map(kept_sweep).collect(), rested_s: 0.0 }
    }

    /// One life of the program that sweeps an actuator.
    fn run(&self, wrong: Wrong) -> Life {
        let mut plan = self.plan.clone();
        if let Some(called_kg) = wrong.called_kg {
            plan.masses_kg = called_kg.to_vec();
        }
        self.carry_out(wrong, &mut Flow::new(plan, self.recorded()))
    }

    /// One life of the program that looks at the sensors, and what it found.
    fn look(&self, wrong: Wrong) -> (Life, Vec<Check>) {
        let mut sensors = Sensors::new(SensorPlan {
            masses_kg: MASSES_KG.to_vec(),
            newtons_per_count: 1e-4,
            creep_s: 20.0,
            stops_rad: [self.plan.stop_rad, -self.plan.stop_rad],
        });
        let life = self.carry_out(wrong, &mut sensors);
        (life, sensors.found().to_vec())
    }

    fn carry_out(&self, wrong: Wrong, steps: &mut dyn Steps) -> Life {
        let (fixture, hands) =
            Fixture::new(TwinParameters::default(), wrong.faults, wrong.seed).unwrap();
        let (_, link, angle) = LINKS.into_iter().find(|(word, ..)| *word == self.link).unwrap();
        let cell = Path::new("/dev/cell");
        let settings = Settings::of_board(link, angle, STREAM_HZ, fixture.capabilities(), cell);
        let environments = zwidth_testing::study().environments;
        let board = Board::by(&settings, fixture, environments.clone()).unwrap();
        let wires = Wires::new(board, settings.baud(), 115_200, 0.0);
        let ids = environments.into_iter().map(|environment| environment.id).collect();
        let own_port = settings.hx711.is_some().then(|| wires.cell());
        let mut device = over(wires.wire(), own_port, &settings, ids).unwrap();
        let limits = Limits {
            theta_min_rad: self.plan.stop_rad,
            theta_max_rad: -self.plan.stop_rad,
            force_n: 20.0,
        };
        let rate_hz = if self.link == "framed" { FRAMED_HZ } else { LOOP_HZ };
        let guard = Guard::new(device.capabilities(), limits, true);
        let mut clock = wires.clone();
        let (stop, calibration) = (AtomicBool::new(false), Calibration::thesis());
        let mut script = Script {
            hands,
            wires: &wires,
            wrong,
            asked: 0,
            told: Vec::new(),
            has_watchdog: self.link == "framed",
        };
        let layout = self.layout();
        let bench = Bench {
            files: &RealFiles,
            layout: &layout,
            utc: &|| "2026-11-30T12:00:00Z".to_owned(),
            about: BTreeMap::new(),
            source: Source::Twin,
            calibration: &calibration,
            rate_hz,
            stop: &stop,
            watched: &|| true,
        };
        let station = Station::new(&mut *device, &mut clock, guard, rate_hz);
        let mut attendant = Attendant::here(station);
        let left = run(&mut attendant, &bench, steps, &mut script).unwrap();
        let (told, asked) = (script.told, script.asked);
        drop(attendant);
        // The last 0 V is on its way.
        wires.wait(0.1);
        Life { left, told, asked, drive: wires.drive() }
    }
}

struct Life {
    left: Left,
    told: Vec<Remark>,
    asked: usize,
    drive: Drive,
}

/// The operator by script: does what is asked for, whatever it is.
struct Script<'a> {
    hands: HandsHandle,
    wires: &'a Wires,
    wrong: Wrong,
    asked: usize,
    told: Vec<Remark>,
    has_watchdog: bool,
}

impl Script<'_> {
    /// Has the cable pulled, if it is to be now.
    fn pull(&self) -> Reply {
        if self.wrong.pulled_at == Some(self.asked) {
            let nth = self.wires.said(Way::ToHost) + self.wrong.messages;
            self.wires.trouble(Way::ToHost, nth, Trouble::Unplug(0.4));
        }
        Reply::Go
    }
}

impl Operator for Script<'_> {
    fn ask(&mut self, ask: &Ask) -> Reply {
        self.asked += 1;
        assert!(self.asked < 200, "it asks for ever: {:.300}", format!("{:?}", self.told));
        // Whenever somebody is asked to touch it, nothing is on. A watchdog has had its time by then. Without one a voltage stays on while the cable is
        // out, until the lever is homed.
        let is_lost = matches!(ask, Ask::GoOn | Ask::Home);
        self.wires.wait(if is_lost { 0.06 } else { 0.01 });
        if !is_lost || self.has_watchdog {
            assert_eq!(self.wires.drive(), Drive::default(), "a voltage is on at {ask:?}");
        }
        if self.wrong.gone_at == Some(self.asked) {
            return Reply::Quit;
        }
        self.hands.set(match *ask {
            Ask::Zero | Ask::GoOn | Ask::Walls { .. } => Hands::Away,
            Ask::Middle => Hands::Clamp(0.0),
            Ask::Mass(mass_kg) => {
                let called_kg = self.wrong.called_kg.unwrap_or(MASSES_KG);
                let place = called_kg
                    .iter()
                    .position(|called| called.to_bits() == mass_kg.to_bits())
                    .unwrap();
                Hands::Hang(MASSES_KG[place])
            }
            Ask::Home | Ask::Back => Hands::Back,
            Ask::Up => Hands::Up,
            // It hangs there already.
            Ask::Hang(_) => return self.pull(),
            // Never quite where it was.
            Ask::Clamp => Hands::Clamp(1e-4 * self.asked as f64),
            Ask::Sweep { ramp, .. } if ramp.actuator == ActuatorKind::Brake => Hands::Push,
            Ask::Sweep { .. } => return self.pull(),
        });
        if matches!(ask, Ask::Home) {
            // It takes a while to carry it there.
            self.wires.wait(4.0);
        }
        self.pull()
    }

    fn tell(&mut self, remark: &Remark) {
        self.told.push(remark.clone());
    }

    fn wrote(&mut self, _: &Path) {}
}

/// Force per voltage of a sweep's upper half, N/V.
fn gain(sweep: &Sweep) -> f64 {
    sweep.file["gain_n_per_v"].parse().unwrap()
}

fn check_whole(desk: &Desk, life: &Life) {
    assert_eq!((life.left, life.drive), (Left::Finished, Drive::default()));
    let sweeps = desk.sweeps(desk.plan.ramp.actuator.as_str());
    assert_eq!(sweeps.len(), 3);
    // The twin's own numbers: 0.26 N/V, and 13 N over 7 V above the brake's dead zone.
    let truth = if desk.plan.ramp.actuator == ActuatorKind::Motor { 0.26 } else { 13.0 / 7.0 };
    for sweep in &sweeps {
        assert!((gain(sweep) / truth - 1.0).abs() < 0.01, "{} {}", gain(sweep), life.told.len());
    }
    assert!(!desk.sweeps("load_cell").is_empty());
}

#[test]
fn a_motor_is_swept_over_each_link() {
    for (link, ..) in LINKS {
        let desk = Desk::new(link, ActuatorKind::Motor);
        let life = desk.run(Wrong::default());
        check_whole(&desk, &life);
    }
}

#[test]
fn a_brake_is_swept_over_each_link() {
    for (link, ..) in LINKS {
        let desk = Desk::new(link, ActuatorKind::Brake);
        let life = desk.run(Wrong::default());
        check_whole(&desk, &life);
    }
}

#[test]
fn a_program_that_is_gone_at_any_question_loses_nothing_that_was_kept() {
    for actuator in [ActuatorKind::Motor, ActuatorKind::Brake] {
        let desk = Desk::new("framed", actuator);
        let whole = desk.run(Wrong::default()).asked;
        let mut most = 0;
        for gone_at in 1..=whole {
            let desk = Desk::new("framed", actuator);
            let life = desk.run(Wrong { gone_at: Some(gone_at), ..Wrong::default() });
            assert_eq!(life.left, Left::Open);
            let before = desk.sweeps(actuator.as_str());
            most = most.max(before.len());
            check_whole(&desk, &desk.run(Wrong::default()));
            assert_eq!(desk.sweeps(actuator.as_str())[..before.len()], before);
        }
        assert_eq!(most, 2, "the last question comes after two sweeps");
    }
}

#[test]
fn a_cable_that_is_pulled_in_any_phase_ends_at_0_v_and_the_rest_follows() {
    for (link, messages) in
        [("framed", 0), ("framed", 1500), ("firmata", 0), ("firmata", 300), ("text", 300)]
    {
        let whole = Desk::new(link, ActuatorKind::Motor).run(Wrong::default()).asked;
        let mut stopped = 0;
        for pulled_at in 1..=whole {
            let desk = Desk::new(link, ActuatorKind::Motor);
            let life = desk.run(Wrong { pulled_at: Some(pulled_at), messages, ..Wrong::default() });
            stopped += life.told.iter().filter(|r| matches!(r, Remark::Stopped(_))).count();
            check_whole(&desk, &life);
        }
        assert!(stopped > 0, "{link}: no pull was noticed");
    }
}

#[test]
fn a_clamp_that_slips_or_lets_go_is_found_and_its_sweep_is_not_kept() {
    for (faults, is_found) in [
        (
            Faults { slips_above_n: Some(2.0), ..Faults::default() },
            (|r: &Remark| matches!(r, Remark::SweepFault(SweepFault::Slip { .. })))
                as fn(&Remark) -> bool,
        ),
        (Faults { loose_above_n: Some(2.0), ..Faults::default() }, |r| matches!(r, Remark::Loose)),
    ] {
        let desk = Desk::new("framed", ActuatorKind::Motor);
        // It goes on until somebody gives up.
        let life = desk.run(Wrong { faults, gone_at: Some(25), ..Wrong::default() });
        assert!(life.told.iter().filter(|remark| is_found(remark)).count() > 1);
        assert_eq!((desk.sweeps("motor").len(), life.drive), (0, Drive::default()));
    }
}

#[test]
fn a_cell_that_drifts_or_ends_is_found() {
    let run = |faults| {
        let desk = Desk::new("framed", ActuatorKind::Motor);
        let life = desk.run(Wrong { faults, gone_at: Some(12), ..Wrong::default() });
        assert_eq!((desk.sweeps("motor").len(), life.drive), (0, Drive::default()));
        life.told
    };
    // Faster than a load may move: at the first look.
    let told = run(Faults { drift_n_per_s: 0.03, ..Faults::default() });
    assert!(matches!(told[0], Remark::CellFault(CellFault::NotStill { .. })));
    // Slower: by the two ways of a sweep.
    let told = run(Faults { drift_n_per_s: 0.018, ..Faults::default() });
    let drifts = |r: &Remark| matches!(r, Remark::SweepFault(SweepFault::Drift { .. }));
    assert!(told.iter().any(drifts));
    let told = run(Faults { cell_ends_n: Some(3.0), ..Faults::default() });
    let ends = |r: &Remark| matches!(r, Remark::Stopped(why) if why.contains("end of its range"));
    assert!(told.iter().any(ends));
}

#[test]
fn a_wrong_mass_is_found_before_anything_is_on() {
    let desk = Desk::new("framed", ActuatorKind::Motor);
    let wrong = Wrong { called_kg: Some([0.1, 0.25]), gone_at: Some(5), ..Wrong::default() };
    let life = desk.run(wrong);
    assert!(
        matches!(life.told[..], [Remark::CellFault(CellFault::TwoMasses { .. })]),
        "{:?}",
        life.told
    );
    assert_eq!(desk.sweeps("load_cell").len(), 0);
}

#[test]
fn a_scale_that_is_off_is_told_and_the_forces_are_right() {
    let desk = Desk::new("framed", ActuatorKind::Motor);
    let faults = Faults { gain_error: 0.1, ..Faults::default() };
    let life = desk.run(Wrong { faults, ..Wrong::default() });
    check_whole(&desk, &life);
    let off = life.told.iter().find_map(|remark| match remark {
        Remark::Cell { newtons_per_count, .. } => *newtons_per_count,
        _ => None,
    });
    assert!((off.unwrap() - 1e-4 / 1.1).abs() < 1e-7, "{off:?}");
}

/// The value of what was found under a name, and whether it is good enough.
#[track_caller]
fn value(found: &[Check], name: &str) -> (f64, bool) {
    let check = found.iter().find(|check| check.name == name);
    let check = check.unwrap_or_else(|| panic!("{name} is not in {found:#?}"));
    (check.value, check.ok)
}

#[test]
fn the_sensors_are_looked_at_over_each_link() {
    for (link, ..) in LINKS {
        let desk = Desk::new(link, ActuatorKind::Motor);
        let (life, found) = desk.look(Wrong::default());
        assert_eq!((life.left, life.drive), (Left::Finished, Drive::default()), "{link}");
        let (scale, ok) = value(&found, "load cell scale");
        assert!(ok && (scale - 1.0).abs() < 1e-3, "{link}: {scale}");
        let (stroke_rad, ok) = value(&found, "stroke");
        assert!(ok && (stroke_rad - std::f64::consts::FRAC_PI_2).abs() < 0.01, "{stroke_rad}");
        assert!(value(&found, "load cell creep").1 && value(&found, "angle noise").1, "{link}");
        assert!(value(&found, "angle after the way up and back").1, "{link}");
        for timed in ["jitter, 99 %", "latency, 99 %", "angle rate", "force noise"] {
            value(&found, timed);
        }
        assert_eq!(desk.sweeps("load_cell").len(), 1);
    }
}

#[test]
fn a_cell_that_creeps_and_a_scale_that_is_off_are_not_good_enough() {
    let desk = Desk::new("framed", ActuatorKind::Motor);
    let faults = Faults { drift_n_per_s: 0.003, gain_error: 0.1, ..Faults::default() };
    let (_, found) = desk.look(Wrong { faults, ..Wrong::default() });
    let (creep, ok) = value(&found, "load cell creep");
    // 18 s of it, of 0.2 kg as this cell shows them.
    assert!(!ok && (creep - 0.003 * 18.0 / 1.96).abs() < 0.003, "{creep}");
    assert!(!value(&found, "load cell scale").1);
}

#[test]
fn a_cable_that_is_pulled_while_the_sensors_are_looked_at_costs_a_homing() {
    for link in ["framed", "text"] {
        let whole = Desk::new(link, ActuatorKind::Motor).look(Wrong::default()).0.asked;
        for pulled_at in 1..=whole {
            let desk = Desk::new(link, ActuatorKind::Motor);
            let wrong = Wrong { pulled_at: Some(pulled_at), messages: 30, ..Wrong::default() };
            let (life, found) = desk.look(wrong);
            assert_eq!(life.left, Left::Finished, "{link} {pulled_at}");
            assert!(value(&found, "stroke").1 && value(&found, "load cell scale").1);
        }
    }
}

/// How many of `seeds` whole characterisations have the simulated truth in every interval, for each
/// actuator; and, of all knots that were looked at, the share that is in its own.
fn coverage(seeds: std::ops::Range<u64>) -> [(usize, f64); 2] {
    let truth = TwinParameters::default().actuators;
    [ActuatorKind::Motor, ActuatorKind::Brake].map(|actuator| {
        let (mut all, mut inside, mut looked) = (0, 0, 0);
        for seed in seeds.clone() {
            let desk = Desk::new("framed", actuator);
            desk.run(Wrong { seed, ..Wrong::default() });
            let found =
                calibrated_actuator(actuator, &desk.sweeps(actuator.as_str()), 0.95).unwrap();
            let own = if actuator == ActuatorKind::Motor { &truth.motor } else { &truth.brake };
            let mut is_whole = true;
            for (i, voltage_v) in found.characteristic.voltage_v.iter().enumerate().skip(1) {
                let force_n = own.force_n(*voltage_v);
                let interval = found.interval.low_n[i]..=found.interval.high_n[i];
                let is_in = interval.contains(&force_n);
                (looked, inside) = (looked + 1, inside + usize::from(is_in));
                is_whole &= is_in;
            }
            all += usize::from(is_whole);
        }
        (all, inside as f64 / looked as f64)
    })
}

#[test]
#[ignore = "200 characterisations of each actuator take ten minutes; the numbers stand in docs/rig.md"]
fn the_calibration_holds_the_simulated_truth_in_93_of_100_seeds() {
    let seeds: u64 = std::env::var("ZWIDTH_SEEDS").map_or(200, |n| n.parse().unwrap());
    for (held, knots) in coverage(1..seeds + 1) {
        println!("{held} of {seeds} hold at every knot; {:.1} % of the knots", 100.0 * knots);
        assert!(held as f64 >= 0.93 * seeds as f64, "{held} of {seeds}");
    }
}
