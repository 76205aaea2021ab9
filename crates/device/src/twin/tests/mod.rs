//! The observations of thesis §5.3 on the twin, over the whole range of what is assumed: with the
//! real loop, controller and guard, judged by the plant's true state.

mod days;
mod rehearsal;

use super::{Twin, TwinParameters};
use crate::participant::intent::tests::task;
use crate::participant::{Course, STEP_S};
use crate::{Intent, Person, Task};
use rehearsal::*;
use std::f64::consts::FRAC_PI_4;
use zwidth_dynamics::{Aim, Command, Driven, DrivenParameters, DrivenState};
use zwidth_study::{ModeLaw, Scene};

/// Devices and participants: drawn from the whole range, and each number at either end of its
/// range.
fn everyone() -> Vec<(TwinParameters, Person)> {
    let ends = TwinParameters::table().into_iter().enumerate().flat_map(|(i, parameter)| {
        parameter.range.into_iter().enumerate().map(move |(k, value)| {
            let mut device = TwinParameters::default();
            *(parameter.field)(&mut device) = value;
            (device, Person::draw(1000 + 2 * i as u64 + k as u64))
        })
    });
    (0..12).map(drawn).chain(ends).collect()
}

/// Rehearses an environment in a mode with everyone, at 1 kHz and the thesis' 120 Hz.
fn with_everyone(
    mode: ModeLaw,
    place: &zwidth_study::Environment,
    check: impl Fn(&TwinParameters, &Rehearsal, f64),
) {
    for (i, (device, person)) in everyone().into_iter().enumerate() {
        let rate_hz = if i % 2 == 1 { 120.0 } else { 1000.0 };
        let mut twin = Twin::new(device.clone(), person, i as u64).unwrap();
        check(&device, &rehearse(&mut twin, mode, place, rate_hz, 1 + i as u32), rate_hz);
    }
}

/// What friction leaves between the lever and the spring's rest when nobody pushes, rad; and 3° for
/// a hand that is slow.
fn residue_rad(device: &TwinParameters) -> f64 {
    device.friction_static_n / SPRING.stiffness_n_per_rad + 3.0_f64.to_radians()
}

#[test]
fn active_spring_saturates_at_4_16_n_and_returns() {
    with_everyone(ModeLaw::Active, &spring(), |device, trial, _| {
        let highest_n = trial.rows.iter().map(|row| row.sample.force_cmd_n).fold(0.0, f64::max);
        assert!((highest_n - 4.16).abs() < 1e-12);
        assert!(trial.last().theta_rad < -FRAC_PI_4 + residue_rad(device), "{:?}", trial.last());
    });
}

/// J/L θ̈ = F_ex − 4.16 N − friction: what is left of the user's force is above the motor's going,
/// below returning.
#[test]
fn at_saturation_the_users_force_is_the_motors_within_friction_and_inertia() {
    for (device, person) in everyone().into_iter().take(20) {
        let plant = device.plant(None);
        let friction = plant.friction.unwrap();
        let viscous = friction.viscous_ns_per_rad + plant.back_emf_ns_per_rad.unwrap();
        let trial = rehearse(
            &mut Twin::new(device, person, 1).unwrap(),
            ModeLaw::Active,
            &spring(),
            1000.0,
            5,
        );
        let (mut going, mut returning) = (0, 0);
        for rows in trial.rows.windows(3).filter(|rows| saturated(rows)) {
            let [before, now, after] = [0, 1, 2].map(|i| rows[i].state);
            let bent = (after.theta_dot_rad_s - before.theta_dot_rad_s)
                / (rows[2].sample.t_s - rows[0].sample.t_s);
            let left_n = now.contact_n - 4.16 - plant.inertia_kg_m2 / plant.lever_m * bent;
            let velocity = now.theta_dot_rad_s;
            let expected_n = friction.kinetic_n.copysign(velocity) + viscous * velocity;
            assert!(
                (left_n - expected_n).abs() < 0.05,
                "{left_n} instead of {expected_n} at {}",
                rows[1].sample.t_s
            );
            (going, returning) =
                (going + u32::from(velocity > 0.0), returning + u32::from(velocity < 0.0));
        }
        assert!(going > 50 && returning > 50, "{going} {returning}");
    }
}

/// The motor gives all it has, and the lever moves one way and is at no stop.
fn saturated(rows: &[RehearsedTick]) -> bool {
    let way = rows[0].state.theta_dot_rad_s;
    rows.iter().all(|row| {
        let one_way = row.state.theta_dot_rad_s * way > 0.0;
        one_way
            && row.state.theta_rad < FRAC_PI_4
            && row.sample.voltages.motor_v <= -16.0
            && row.state.motor_n < -4.159
    })
}

#[test]
fn passive_spring_stays_at_its_largest_angle_while_the_force_falls_to_0() {
    with_everyone(ModeLaw::Passive, &spring(), |_, trial, _| {
        assert_eq!(trial.last().theta_rad.to_bits(), trial.top_rad().to_bits());
        assert_eq!(trial.last().contact_n.to_bits(), 0);
        assert!(trial.top_rad() > 20.0_f64.to_radians() && trial.peak_n() > 4.16);
    });
}

#[test]
fn hybrid_spring_returns_with_a_larger_step_at_the_reversal_than_active() {
    for (i, (device, person)) in everyone().into_iter().enumerate() {
        let mut twin = Twin::new(device.clone(), person, i as u64).unwrap();
        let active = rehearse(&mut twin, ModeLaw::Active, &spring(), 1000.0, 3);
        let hybrid = rehearse(&mut twin, ModeLaw::Hybrid, &spring(), 1000.0, 3);
        assert!(hybrid.last().theta_rad < -FRAC_PI_4 + residue_rad(&device), "{i}");
        let (more, less) = (hybrid.step_at_reversal_n(), active.step_at_reversal_n());
        assert!(more > less + 1.0, "{i}: {more} against {less}");
    }
}

#[test]
fn active_passes_the_wall_by_degrees() {
    with_everyone(ModeLaw::Active, &wall(), |_, trial, _| {
        assert!(
            trial.top_rad() > WALL_RAD + 2.0_f64.to_radians(),
            "{}",
            trial.top_rad().to_degrees()
        );
    });
}

/// The lever stops within approach velocity × (brake lag + 2 ticks) and one count, and stands while
/// the force rises.
fn stops_at_the_wall(device: &TwinParameters, trial: &Rehearsal, rate_hz: f64) {
    let met = trial.rows.iter().position(|row| row.state.theta_rad >= WALL_RAD).unwrap();
    let approach = trial.rows[met - 1].state.theta_dot_rad_s;
    let most_rad = approach * (device.brake_on_s + 2.0 / rate_hz) + COUNT_RAD;
    let past_rad = trial.top_rad() - WALL_RAD;
    assert!(past_rad <= most_rad, "{past_rad} rad past, {most_rad} allowed");
    let standing: Vec<_> =
        trial.rows.iter().filter(|row| row.state.theta_rad >= trial.top_rad()).collect();
    let force = |i: usize| standing[i].state.contact_n;
    let highest = standing.iter().map(|row| row.state.contact_n).fold(0.0, f64::max);
    assert!(standing.iter().all(|row| row.state.theta_dot_rad_s.to_bits() == 0));
    assert!(
        standing.len() > rate_hz as usize / 20
            && highest > force(0)
            && highest > force(standing.len() - 1) + 1.0
    );
}

#[test]
fn passive_stops_at_the_wall_and_stays_there() {
    with_everyone(ModeLaw::Passive, &wall(), |device, trial, rate_hz| {
        stops_at_the_wall(device, trial, rate_hz);
        assert_eq!(trial.last().theta_rad.to_bits(), trial.top_rad().to_bits());
    });
}

#[test]
fn hybrid_stops_at_the_wall_and_returns_when_the_force_has_fallen() {
    with_everyone(ModeLaw::Hybrid, &wall(), |device, trial, rate_hz| {
        stops_at_the_wall(device, trial, rate_hz);
        assert!(trial.rows[trial.top() + 1].state.contact_n < LET_GO_N);
        assert!(trial.last().theta_rad < -FRAC_PI_4 + residue_rad(device));
    });
}

#[test]
fn the_hand_never_pulls_and_stays_below_the_limit_of_a_finger() {
    for (i, (device, person)) in everyone().into_iter().enumerate() {
        let mut twin = Twin::new(device, person, i as u64).unwrap();
        for mode in LAWS {
            let trial = rehearse(&mut twin, mode, &wall(), 500.0, 2);
            assert!(trial.rows.iter().all(|row| row.state.contact_n >= 0.0));
            assert!(trial.peak_n() < 8.5, "{}", trial.peak_n()); // 10 N is the limit of safety
        }
    }
}

#[test]
fn one_intent_gives_three_trajectories_in_three_modes() {
    let (device, person) = drawn(5);
    let mut twin = Twin::new(device, person, 5).unwrap();
    let trials = LAWS.map(|mode| rehearse(&mut twin, mode, &spring(), 1000.0, 7));
    assert!(trials.iter().all(|trial| trial.intent == trials[0].intent));
    let peaks = trials.each_ref().map(Rehearsal::peak_n);
    assert!(peaks[1] > peaks[0] + 0.5, "{peaks:?}");
    let ends = trials.each_ref().map(|trial| trial.last().theta_rad);
    assert!(ends[1] > ends[0] + 0.5 && ends[1] > ends[2] + 0.5);
}

/// Maxima of a curve that stand out from both sides by a share of the highest (prominence).
fn peaks(curve: &[f64], share: f64) -> usize {
    let margin = share * curve.iter().copied().fold(0.0, f64::max);
    let (mut peaks, mut low, mut high, mut rising) = (0, 0.0, 0.0, true);
    for &x in curve {
        (low, high) = (f64::min(low, x), f64::max(high, x));
        if rising && x < high - margin {
            (peaks, low, rising) = (peaks + 1, x, false);
        } else if !rising && x > low + margin {
            (high, rising) = (x, true);
        }
    }
    peaks
}

#[test]
fn in_free_space_the_velocity_has_one_peak_each_way() {
    assert_eq!(peaks(&[0.0, 1.0, 0.8, 1.0, 0.0], 0.1), 2);
    for seed in 0..40 {
        let person = Person::draw(seed).in_session(seed, 0);
        let nothing = Task { resistance_n: 0.0, ..task(Scene::Free) };
        let hand = alone(&person, Intent::draw(&person, 2, &nothing));
        let ways =
            [1.0, -1.0].map(|way| hand.iter().map(|v| (way * v).max(0.0)).collect::<Vec<f64>>());
        assert_eq!(ways.map(|velocity| peaks(&velocity, 0.05)), [1, 1], "{seed}");
    }
}

/// Velocity of a hand that touches nothing; a lever without mass or friction goes along with it.
fn alone(person: &Person, intent: Intent) -> Vec<f64> {
    let hand = Some(person.hand);
    let parameters = DrivenParameters { stops_rad: None, ..TwinParameters::default().plant(hand) };
    let mut plant = Driven::new(parameters).unwrap();
    plant.place(0.0, 1.0).unwrap();
    let mut course = Course::new(intent, -FRAC_PI_4 * 0.045);
    let at = |course: &Course, t: f64| {
        let aim = course.aim(t);
        Aim { position_m: aim.position_m - 1.0, ..aim }
    };
    let steps = (0..1600).map(|i| STEP_S * f64::from(i));
    steps
        .map(|t| {
            let aims = [at(&course, t), at(&course, t + STEP_S)];
            plant.advance(STEP_S, Command::default(), aims).unwrap();
            let state = plant.state();
            let theta_rad = (state.hand_m + 1.0) / 0.045 - FRAC_PI_4;
            course.step(person, 0.045, t + STEP_S, &DrivenState { theta_rad, ..state });
            state.hand_m_s
        })
        .collect()
}

/// The lever's own friction lets it start with a jerk; that is no second movement.
#[test]
fn a_free_lever_follows_in_one_movement() {
    with_everyone(ModeLaw::Active, &environment(Scene::Free), |_, trial, _| {
        let velocity: Vec<f64> =
            trial.rows.iter().map(|row| row.state.theta_dot_rad_s.max(0.0)).collect();
        assert_eq!(peaks(&velocity, 0.15), 1);
    });
}

#[test]
fn participants_differ_in_peak_force_and_duration_and_so_do_repeats() {
    let measure = |person: Person, trial| {
        let mut twin = Twin::new(TwinParameters::default(), person, 1).unwrap();
        let trial = rehearse(&mut twin, ModeLaw::Hybrid, &spring(), 250.0, trial);
        let moving = |row: &RehearsedTick| row.state.theta_dot_rad_s.abs() > 0.1;
        let first = trial.rows.iter().position(moving).unwrap();
        let last = trial.rows.iter().rposition(moving).unwrap();
        [trial.peak_n(), trial.rows[last].sample.t_s - trial.rows[first].sample.t_s]
    };
    let spread = |values: &[[f64; 2]], i: usize| {
        let mean = values.iter().map(|v| v[i]).sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v[i] - mean) * (v[i] - mean)).sum::<f64>() / values.len() as f64)
            .sqrt()
    };
    let people: Vec<_> = (0..12).map(|seed| measure(Person::draw(seed), 10)).collect();
    assert!(spread(&people, 0) > 0.1 && spread(&people, 1) > 0.05, "{people:?}");
    let repeats: Vec<_> = (10..22).map(|trial| measure(Person::draw(1), trial)).collect();
    assert!(spread(&repeats, 0) > 0.02 && spread(&repeats, 1) > 0.02, "{repeats:?}");
    assert!(
        people.iter().chain(&repeats).all(|v| (1.8..3.6).contains(&v[1])),
        "{people:?} {repeats:?}"
    );
}

#[test]
fn answers_rank_as_in_the_thesis() {
    let mean = |mode, place: &zwidth_study::Environment| {
        let answers = (0..24).map(|seed| {
            let mut twin = Twin::new(TwinParameters::default(), Person::draw(seed), seed).unwrap();
            f64::from(rehearse(&mut twin, mode, place, 250.0, 4).answer)
        });
        answers.sum::<f64>() / 24.0
    };
    let [active, passive, hybrid] = LAWS.map(|mode| mean(mode, &spring()));
    assert!(active > hybrid && hybrid > passive + 1.0, "spring: {active} {passive} {hybrid}");
    let [active, passive, hybrid] = LAWS.map(|mode| mean(mode, &wall()));
    assert!(hybrid > active + 1.0 && hybrid > passive + 1.0, "wall: {active} {passive} {hybrid}");
}
