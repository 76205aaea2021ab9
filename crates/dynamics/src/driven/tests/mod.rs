//! What the solution must satisfy as mathematics: closed forms, steps that do not matter, the other
//! solver.

use zwidth_numerics::series::interpolate;

mod physics;

use super::*;
use crate::{
    Brake, BrakeLaw, Demand, DriveMode, Environment, Exact, Finger, FingerLaw, Friction, Grid,
    Input, ModelScene, Motor, Plant, Series, Solver, System, Zone, table3,
};

/// The twin's defaults (physics.md).
pub(super) fn prototype() -> DrivenParameters {
    DrivenParameters {
        inertia_kg_m2: 1.97e-4,
        lever_m: 0.045,
        stops_rad: Some([-std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_4]),
        friction: Some(Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.02 }),
        back_emf_ns_per_rad: Some(0.0976),
        motor_lag_s: Some(53e-6),
        brake_lag_on_off_s: Some([0.015, 0.010]),
        hand: Some(Hand {
            mass_kg: 0.08,
            stiffness_n_per_m: 290.0,
            damping_ns_per_m: 3.0,
            tissue: Tissue { stiffness_n_per_m: 584.6, damping_ns_per_m: 1.53 },
        }),
    }
}

/// A lever that nobody touches and nothing stops or rubs.
fn bare() -> DrivenParameters {
    DrivenParameters {
        stops_rad: None,
        friction: None,
        back_emf_ns_per_rad: None,
        motor_lag_s: None,
        brake_lag_on_off_s: None,
        hand: None,
        ..prototype()
    }
}

/// A forward–backward press: aim at a time, for a lever of 45 mm that starts at −45°.
pub(super) fn press(t_s: f64) -> Aim {
    let (middle, half, w) = (-0.0353, 0.035, std::f64::consts::PI);
    let (sin, cos) = (libm::sin(w * t_s), libm::cos(w * t_s));
    Aim { position_m: middle + half * (1.0 - cos), velocity_m_s: half * w * sin }
}

/// Runs `steps` advances of `h_s` with a command as a function of time and state.
pub(super) fn drive(
    plant: &mut Driven,
    h_s: f64,
    steps: usize,
    mut command: impl FnMut(f64, &DrivenState) -> Command,
) -> Vec<DrivenState> {
    (0..steps)
        .map(|i| {
            let t = i as f64 * h_s;
            let now = command(t, &plant.state());
            plant.advance(h_s, now, [press(t), press(t + h_s)]).unwrap();
            plant.state()
        })
        .collect()
}

fn motor(motor_n: f64) -> Command {
    Command { motor_n, brake_n: 0.0 }
}

#[test]
fn a_bare_lever_falls_as_half_a_t_squared() {
    let mut plant = Driven::new(bare()).unwrap();
    let acceleration = 2.0 * 0.045 / 1.97e-4;
    for dt in [1e-3, 3.3e-4, 7e-5] {
        plant.place(0.0, 0.0).unwrap();
        plant.advance(dt, motor(2.0), [Aim::default(); 2]).unwrap();
        let state = plant.state();
        assert!((state.theta_rad - 0.5 * acceleration * dt * dt).abs() < 1e-16, "{state:?}");
        assert!((state.theta_dot_rad_s - acceleration * dt).abs() < 1e-13, "{state:?}");
    }
}

#[test]
fn a_voltage_driven_motor_reaches_its_speed_as_an_exponential() {
    let mut plant =
        Driven::new(DrivenParameters { back_emf_ns_per_rad: Some(0.1), ..bare() }).unwrap();
    plant.advance(0.05, motor(2.0), [Aim::default(); 2]).unwrap();
    let rate = 0.1 * 0.045 / 1.97e-4;
    let expected = 20.0 * (1.0 - libm::exp(-rate * 0.05));
    assert!((plant.state().theta_dot_rad_s - expected).abs() < 1e-12);
}

#[test]
fn the_winding_and_the_air_gap_lag_by_their_time_constants() {
    let mut plant = Driven::new(DrivenParameters { hand: None, ..prototype() }).unwrap();
    let command = Command { motor_n: -2.0, brake_n: 8.0 };
    plant.advance(1e-4, command, [Aim::default(); 2]).unwrap();
    assert!((plant.state().motor_n + 2.0 * (1.0 - libm::exp(-1e-4 / 53e-6))).abs() < 1e-14);
    assert!((plant.state().brake_n - 8.0 * (1.0 - libm::exp(-1e-4 / 0.015))).abs() < 1e-14);
    let before = plant.state().brake_n;
    plant.advance(0.004, Command::default(), [Aim::default(); 2]).unwrap();
    assert!((plant.state().brake_n - before * libm::exp(-0.4)).abs() < 1e-14);
}

#[test]
fn a_braked_lever_stops_where_its_energy_is_spent_and_stays_there_bit_for_bit() {
    let mut plant = Driven::new(bare()).unwrap();
    plant.advance(0.02, motor(0.5), [Aim::default(); 2]).unwrap();
    let (theta, omega) = (plant.state().theta_rad, plant.state().theta_dot_rad_s);
    let braked = Command { motor_n: 0.0, brake_n: 4.0 };
    plant.advance(0.1, braked, [Aim::default(); 2]).unwrap();
    let stopped = plant.state();
    let expected = theta + 0.5 * omega * omega * 1.97e-4 / (4.0 * 0.045);
    assert!((stopped.theta_rad - expected).abs() < 1e-13, "{stopped:?}");
    assert_eq!(stopped.theta_dot_rad_s.to_bits(), 0);
    for i in 0..1000 {
        let below = Command { motor_n: 3.99 * libm::sin(f64::from(i)), brake_n: 4.0 };
        plant.advance(1e-3, below, [Aim::default(); 2]).unwrap();
        assert_eq!(plant.state().theta_rad.to_bits(), stopped.theta_rad.to_bits());
    }
}

#[test]
fn static_friction_is_passed_at_its_level_and_not_before() {
    let friction = Some(Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.0 });
    let mut plant = Driven::new(DrivenParameters { friction, ..bare() }).unwrap();
    plant.advance(1.0, motor(0.2), [Aim::default(); 2]).unwrap();
    assert_eq!(plant.state().theta_rad.to_bits(), 0);
    plant.advance(0.01, motor(0.200_001), [Aim::default(); 2]).unwrap();
    let expected = 0.5 * 0.050_001 * 0.045 / 1.97e-4 * 1e-4;
    assert!((plant.state().theta_rad - expected).abs() < 1e-15);
}

#[test]
fn a_stop_is_met_exactly_and_left_again() {
    let mut plant = Driven::new(DrivenParameters { hand: None, ..prototype() }).unwrap();
    plant.advance(1.0, motor(4.0), [Aim::default(); 2]).unwrap();
    assert_eq!(plant.state().theta_rad.to_bits(), std::f64::consts::FRAC_PI_4.to_bits());
    assert_eq!(plant.state().theta_dot_rad_s.to_bits(), 0);
    plant.advance(0.01, motor(-1.0), [Aim::default(); 2]).unwrap();
    assert!(plant.state().theta_dot_rad_s < 0.0);
}

#[test]
fn a_held_lever_is_pushed_by_tissue_and_hand_in_series() {
    let mut plant = Driven::new(prototype()).unwrap();
    let held = Command { motor_n: 0.0, brake_n: 13.0 };
    plant.place(0.0, 0.0).unwrap();
    let aim = Aim { position_m: 0.02, velocity_m_s: 0.0 };
    plant.advance(0.2, held, [Aim::default(); 2]).unwrap(); // the brake engages first
    plant.advance(0.1, held, [Aim::default(), aim]).unwrap();
    plant.advance(3.0, held, [aim; 2]).unwrap();
    let expected = 0.02 * 290.0 * 584.6 / (290.0 + 584.6);
    assert!((plant.state().contact_n - expected).abs() < 1e-9, "{:?}", plant.state());
    assert!((plant.state().hand_m - expected / 584.6).abs() < 1e-12);
}

#[test]
fn the_tissue_touches_with_its_damping_and_springs_back_by_itself() {
    let mut plant = Driven::new(prototype()).unwrap();
    plant.place(0.0, 0.001).unwrap();
    let held = Command { motor_n: 0.0, brake_n: 13.0 };
    let speed = Aim { position_m: 0.0, velocity_m_s: 0.0 };
    plant.advance(1.0, held, [Aim { position_m: -0.001, ..speed }; 2]).unwrap();
    let (mut least, mut touches, mut touching) = (f64::INFINITY, 0, false);
    for i in 0..20_000 {
        let at =
            |t: f64| Aim { position_m: 0.004 * libm::sin(40.0 * t) - 0.001, velocity_m_s: 0.0 };
        let t = f64::from(i) * 1e-4;
        plant.advance(1e-4, held, [at(t), at(t + 1e-4)]).unwrap();
        let state = plant.state();
        touches += u32::from(!touching && state.contact_n > 0.0);
        touching = state.contact_n > 0.0;
        least = least.min(state.contact_n);
    }
    assert!(least >= 0.0);
    assert_eq!(touches, 13); // 2 s at 40 rad/s are 12.7 turns
}

/// Two seconds of a press against a spring, sampled at 1 kHz, with brake and motor in turn.
fn pressed(plant: &mut Driven) -> Vec<DrivenState> {
    drive(plant, 1e-3, 2000, |_, state| {
        let spring = 4.0 * (state.theta_rad + std::f64::consts::FRAC_PI_4);
        let forward = state.theta_dot_rad_s > 1e-3;
        Command {
            motor_n: if forward { 0.0 } else { -spring.min(2.08) },
            brake_n: if forward { spring } else { 0.0 },
        }
    })
}

#[test]
fn halving_the_step_leaves_the_angle_unchanged() {
    let run = |reach_s| pressed(&mut Driven::with_reach(prototype(), reach_s).unwrap());
    let whole = run(1e-3);
    for other in [run(5e-4), run(2.5e-4), run(3e-5)] {
        let apart = other.iter().zip(&whole).map(|(a, b)| (a.theta_rad - b.theta_rad).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-12);
    }
}

#[test]
fn a_split_advance_is_the_whole_advance() {
    let mut whole = Driven::new(prototype()).unwrap();
    let mut split = whole.clone();
    for i in 0..500 {
        let t = f64::from(i) * 4e-3;
        let (from, to) = (press(t), press(t + 4e-3));
        let command = Command { motor_n: -1.0 - t, brake_n: 0.2 };
        whole.advance(4e-3, command, [from, to]).unwrap();
        let at = |share: f64| Aim {
            position_m: from.position_m + share * (to.position_m - from.position_m),
            velocity_m_s: from.velocity_m_s + share * (to.velocity_m_s - from.velocity_m_s),
        };
        for shares in [[0.0, 0.3], [0.3, 0.55], [0.55, 1.0]] {
            split.advance((shares[1] - shares[0]) * 4e-3, command, shares.map(at)).unwrap();
        }
        assert!((whole.state().theta_rad - split.state().theta_rad).abs() < 1e-12, "{t}");
    }
}

/// The flows know it as a hand that nothing pulls, so far away that it never touches.
#[test]
fn a_lever_alone_moves_as_the_flows_say() {
    let hand = Hand { stiffness_n_per_m: 0.0, damping_ns_per_m: 0.0, ..prototype().hand.unwrap() };
    for (motor_lag_s, brake_lag_on_off_s) in [
        (None, None),
        (Some(53e-6), None),
        (None, Some([0.015, 0.010])),
        (Some(2e-3), Some([0.04, 0.01])),
    ] {
        let lonely =
            DrivenParameters { motor_lag_s, brake_lag_on_off_s, hand: None, ..prototype() };
        let mut alone = Driven::new(lonely).unwrap();
        let mut beside = Driven::new(DrivenParameters { hand: Some(hand), ..lonely }).unwrap();
        let (mut moved, mut rested, mut stopped) = (0, 0, 0);
        for (dt_s, steps) in [(1e-3, 4000), (8.3e-3, 400), (0.2, 20)] {
            alone.place(-0.5, 0.0).unwrap();
            beside.place(-0.5, 1e3).unwrap();
            for i in 0..steps {
                // Strong and weak, against the brake and without it, to both stops.
                let t = f64::from(i) * 4.0 / f64::from(steps);
                let motor_n = 1.5 * libm::sin(7.0 * t) + 0.5 * libm::sin(31.0 * t);
                let brake_n = (0.6 * libm::sin(5.0 * t)).max(0.0);
                let command = Command { motor_n, brake_n };
                for plant in [&mut alone, &mut beside] {
                    plant.advance(dt_s, command, [Aim::default(); 2]).unwrap();
                }
                let (a, b) = (alone.state(), beside.state());
                let apart = [
                    a.theta_rad - b.theta_rad,
                    (a.theta_dot_rad_s - b.theta_dot_rad_s) / 1e2,
                    a.motor_n - b.motor_n,
                    a.brake_n - b.brake_n,
                ];
                assert!(apart.iter().all(|x| x.abs() < 1e-12), "{dt_s} s, step {i}: {apart:?}");
                let is_at_stop = a.theta_rad.abs() >= std::f64::consts::FRAC_PI_4;
                moved += usize::from(a.theta_dot_rad_s != 0.0);
                rested += usize::from(a.theta_dot_rad_s == 0.0 && !is_at_stop);
                stopped += usize::from(is_at_stop);
            }
        }
        assert!(moved.min(rested).min(stopped) > 50, "{moved} {rested} {stopped}");
    }
}

/// Time and size of a press and its release, N: piecewise linear, so that both solvers take it
/// exactly.
fn force(peak_n: f64) -> Series {
    Series { t_s: vec![0.0, 0.3, 0.4, 0.7], value: vec![0.0, peak_n, peak_n, 0.4] }
}

/// Angles at every millisecond of a press against brake or motor at full force, by the other
/// solver. Its finger is our hand without an impedance of its own, moved by the force itself.
fn other_solver(mode: DriveMode, mine: &DrivenParameters, peak_n: f64) -> Vec<f64> {
    let hand = mine.hand.unwrap();
    let scene = ModelScene {
        duration_s: 0.7,
        step_s: 1e-3,
        environment: Environment {
            name: "full".to_owned(),
            zones: vec![Zone { from_rad: 0.0, demand: Demand::Full }],
        },
        plant: Plant {
            mass_kg: mine.inertia_kg_m2 / mine.lever_m / mine.lever_m,
            lever_m: mine.lever_m,
            stops_rad: mine.stops_rad,
        },
        motor: Motor { max_n: 2.08, lag_s: mine.motor_lag_s },
        brake: Brake {
            max_n: 2.5,
            law: BrakeLaw::Coulomb,
            dead_zone_n: 0.0,
            lag_on_off_s: mine.brake_lag_on_off_s,
            let_go_n: None,
        },
        finger: Some(Finger {
            law: FingerLaw::Consistent,
            mass_kg: hand.mass_kg,
            stiffness_n_per_m: hand.tissue.stiffness_n_per_m,
            damping_ns_per_m: hand.tissue.damping_ns_per_m,
            length_m: None,
        }),
        friction: mine.friction,
        ..table3::scene(mode, Input::Series(force(peak_n)))
    };
    let system = System::new(scene).unwrap();
    Exact::default().run(&system, &Grid::of(&system)).unwrap().theta_rad().collect()
}

fn check_against_exact(mode: DriveMode, command: Command, peak_n: f64) {
    /// So soft that the hand's own position does not matter, and the force is what it aims for,
    /// N/m.
    const SOFT: f64 = 1e-12;
    let mut mine = DrivenParameters { back_emf_ns_per_rad: None, ..prototype() };
    let hand = mine.hand.as_mut().unwrap();
    (hand.stiffness_n_per_m, hand.damping_ns_per_m) = (SOFT, 0.0);
    let theirs = other_solver(mode, &mine, peak_n);
    let (force, mut plant) = (force(peak_n), Driven::new(mine).unwrap());
    let at = |t: f64| Aim {
        position_m: interpolate(&force.t_s, &force.value, t.min(0.7)).unwrap() / SOFT,
        velocity_m_s: 0.0,
    };
    let mut turned = 0.0_f64;
    for (i, theta) in theirs.iter().enumerate().skip(1) {
        plant.advance(1e-3, command, [at(i as f64 * 1e-3 - 1e-3), at(i as f64 * 1e-3)]).unwrap();
        let difference = plant.state().theta_rad - theta;
        assert!(difference.abs() < 1e-11, "{mode:?} {i}: {difference}");
        turned = turned.max(theta + std::f64::consts::FRAC_PI_4);
    }
    assert!(turned > 0.1, "{turned}");
}

#[test]
fn a_braked_press_agrees_with_the_exact_solver() {
    check_against_exact(DriveMode::Passive, Command { motor_n: 0.0, brake_n: 2.5 }, 3.0);
}

#[test]
fn a_driven_press_agrees_with_the_exact_solver() {
    check_against_exact(DriveMode::Active, Command { motor_n: -2.08, brake_n: 0.0 }, 2.6);
}
