//! Wrong trajectories are made by formula, and measured.

use crate::made::{Truth, changed};
use crate::scenes;
use zwidth_judge::Candidate;
use zwidth_results::{LeverEvent, TrajectoryVerdict};

/// Two numbers agree to this share.
const SHARE: f64 = 1e-6;

fn close(found: f64, expect: f64, what: &str) {
    assert!((found / expect - 1.0).abs() < SHARE, "{what}: {found} for {expect}");
}

#[test]
fn a_creep_of_a_known_speed_is_measured() {
    let speeds = [1e-4, 1e-2, 1.0, 3.0, 10.0];
    for scene in
        [scenes::stick(), scenes::stop(), scenes::hybrid(), scenes::let_go(), scenes::slip_stick()]
    {
        let truth = Truth::of(&scene);
        let [from_s, to_s] = truth.longest_rest_s();
        for step_s in [1e-4, 1e-3] {
            for speed in speeds {
                // Back from a stop, so that the lever does not pass through it.
                let back = scene.name == "stop under a steady push";
                let v = f64::to_radians(speed) * if back { -1.0 } else { 1.0 };
                let creeping = changed(&truth.every(step_s), |t, [theta, omega]| {
                    let since = t.clamp(from_s, to_s) - from_s;
                    let is_held = (from_s..=to_s).contains(&t);
                    [theta + v * since, omega + if is_held { v } else { 0.0 }]
                });
                let fault = truth.fault(&creeping, TrajectoryVerdict::Creeps);
                let what = format!("{}, {speed} °/s every {step_s} s", scene.name);
                close(fault.creep_rad_s.unwrap(), v, &what);
            }
        }
    }
}

#[test]
fn of_few_decimals_a_creep_shows_as_far_as_they_can_show_it() {
    let truth = Truth::of(&scenes::stick());
    let v = 1_f64.to_radians();
    let creeping = changed(&truth.every(1e-3), |t, [theta, _]| [theta + v * t, v]);
    let six = |x: f64| (x * 1e6).round() / 1e6;
    let printed = changed(&creeping, |_, [theta, omega]| [six(theta), six(omega)]);
    let fault = truth.fault(&printed, TrajectoryVerdict::Creeps);
    assert!((fault.creep_rad_s.unwrap() / v - 1.0).abs() < 1e-4, "{fault:?}");
    // A millionth of a degree per second moves by less than a step of the sixth decimal.
    let v = 2e-5_f64.to_radians();
    let creeping = changed(&truth.every(1e-3), |t, [theta, _]| [six(theta + v * t), 0.0]);
    let judged = truth.judge(&creeping).unwrap();
    assert_eq!(judged.trajectory.verdict, TrajectoryVerdict::Stands, "{judged:?}");
}

/// The same motion, from a time on, at which the lever rests, so much later.
fn delayed(truth: &Truth, right: &Candidate, from_s: f64, late_s: f64) -> Candidate {
    let times: Vec<f64> =
        right.t_s.iter().map(|t| if *t <= from_s { *t } else { from_s.max(*t - late_s) }).collect();
    // Times at which it waits are all the same: each is looked up once.
    let mut different = times.clone();
    different.dedup();
    let values = truth.values(&different);
    let place = |t: f64| different.partition_point(|d| *d < t);
    let values: Vec<[f64; 2]> = times.iter().map(|t| values[place(*t)]).collect();
    Candidate {
        theta_rad: values.iter().map(|v| v[0]).collect(),
        theta_dot_rad_s: values.iter().map(|v| v[1]).collect(),
        ..right.clone()
    }
}

#[test]
fn an_event_that_is_late_by_a_known_time_is_measured() {
    for (scene, event, from_s) in [
        (scenes::stop(), LeverEvent::BrokeLoose, 0.15),
        (scenes::let_go(), LeverEvent::ActuatorLetGo, 0.8),
        (scenes::slip_stick(), LeverEvent::BrokeLoose, 0.0),
        (scenes::hybrid(), LeverEvent::BrokeLoose, f64::NAN),
    ] {
        let truth = Truth::of(&scene);
        let from_s = if from_s.is_nan() { truth.longest_rest_s()[0] + 0.01 } else { from_s };
        for late_s in [0.0071, 0.0207] {
            let late = delayed(&truth, &truth.every(1e-4), from_s, late_s);
            let judged = truth.judge(&late).unwrap();
            let what = format!("{}, {late_s} s: {judged:#?}", scene.name);
            assert_eq!(judged.trajectory.verdict, TrajectoryVerdict::Late, "{what}");
            let fault = &judged.faults[0];
            assert!((fault.late_s.unwrap() - late_s).abs() < 1e-6, "{what}");
            if scene.name != "slip and stick" {
                assert!(
                    fault.event == Some(event) || fault.event == Some(LeverEvent::StopReached),
                    "{what}"
                );
            }
            assert_eq!(judged.faults.len(), 1, "{what}");
        }
        // Late by nothing.
        let same = delayed(&truth, &truth.every(1e-4), from_s, 0.0);
        assert_eq!(truth.judge(&same).unwrap().faults.len(), 0);
    }
}

#[test]
fn an_event_that_is_early_is_measured_and_one_that_never_comes_is_missed() {
    let truth = Truth::of(&scenes::stop());
    let right = truth.every(1e-4);
    // The lever would move on as it does, but it began 5 ms before the push.
    let shifted: Vec<f64> =
        right.t_s.iter().map(|t| if *t < 0.195 { *t } else { (t + 0.005).min(1.0) }).collect();
    let mut different = shifted.clone();
    different.dedup();
    let values = truth.values(&different);
    let values: Vec<[f64; 2]> =
        shifted.iter().map(|t| values[different.partition_point(|d| d < t)]).collect();
    let early = Candidate {
        theta_rad: values.iter().map(|v| v[0]).collect(),
        theta_dot_rad_s: values.iter().map(|v| v[1]).collect(),
        ..right.clone()
    };
    let fault = truth.fault(&early, TrajectoryVerdict::Early);
    assert!((fault.late_s.unwrap() + 0.005).abs() < 1e-6, "{fault:?}");
    // In the stop a loop presses on: it adds to the velocity, which the stop then takes away.
    let pressed = changed(&early, |t, [theta, omega]| {
        let is_odd = (t * 1e4).round() as i64 % 2 == 1;
        [theta, if theta >= 0.3 && is_odd { 0.05 } else { omega }]
    });
    let trembling = truth.fault(&pressed, TrajectoryVerdict::Early);
    assert_eq!((trembling.times, trembling.event), (2, Some(LeverEvent::BrokeLoose)));
    assert_eq!(trembling.late_s, fault.late_s);
    let still = changed(&right, |_, _| [0.0, 0.0]);
    let fault = truth.fault(&still, TrajectoryVerdict::Missed);
    assert_eq!(fault.event, Some(LeverEvent::BrokeLoose));
    assert!((fault.t_s - 0.2).abs() < 1e-4, "{fault:?}");
}

#[test]
fn energy_of_a_known_size_and_sign_is_measured() {
    let scene = scenes::spring();
    let truth = Truth::of(&scene);
    let omega = 30.0_f64; // ω² = K / (M L) = 4.5 / 0.005
    let (start, inertia) = (0.2, 0.1 * 0.05 * 0.05);
    for rate in [0.4, 0.1, -0.1, -0.4] {
        let made = changed(&truth.every(1e-3), |t, _| {
            let (size, phase) = (start * (rate * t).exp(), omega * t);
            [size * phase.cos(), size * (rate * phase.cos() - omega * phase.sin())]
        });
        // ½ M L² θ̇² + ½ K L θ² in the end, less that at the start; the spring's forces are its work.
        let energy = |c: &Candidate, i: usize| {
            0.5 * inertia * (c.theta_dot_rad_s[i].powi(2) + (omega * c.theta_rad[i]).powi(2))
        };
        let expect = energy(&made, made.t_s.len() - 1) - energy(&made, 0);
        let judged = truth.judge(&made).unwrap();
        let found = judged.trajectory.energy_residual_j.unwrap();
        close(found, expect, &format!("growth {rate} 1/s"));
        let verdict =
            if rate > 0.0 { TrajectoryVerdict::EnergyMade } else { TrajectoryVerdict::EnergyLost };
        assert_eq!(judged.trajectory.verdict, verdict, "{judged:#?}");
        assert_eq!(judged.faults[0].energy_j, Some(found));
    }
}

#[test]
fn a_jump_of_a_known_size_is_measured() {
    for scene in
        [scenes::stop(), scenes::hybrid(), scenes::spring(), scenes::let_go(), scenes::pendulum()]
    {
        let truth = Truth::of(&scene);
        let right = truth.every(1e-4);
        let fastest = right.theta_dot_rad_s.iter().map(|omega| omega.abs()).fold(0.0, f64::max);
        // In the middle of the fastest motion, far from events.
        let at =
            right.theta_dot_rad_s.iter().position(|omega| omega.abs() > 0.7 * fastest).unwrap();
        let jump_s = right.t_s[at] + 0.5e-4;
        // Away from a stop.
        let sign = if scene.name == "stop under a steady push" { -1.0 } else { 1.0 };
        for size in [0.01 * sign, 0.1 * sign] {
            let jumped = changed(&right, |t, [theta, omega]| {
                [theta + if t > jump_s { size } else { 0.0 }, omega]
            });
            let fault = truth.fault(&jumped, TrajectoryVerdict::Reset);
            close(fault.theta_rad.expect(&scene.name), size, &scene.name);
            assert!((fault.t_s - jump_s).abs() < 1e-4 && !fault.to_zero, "{fault:?}");
            // For 20 ms: there and back.
            let (rate, end_s) = (size * 10.0 * fastest, jump_s + 0.02);
            let jumped = changed(&right, |t, [theta, omega]| {
                let inside = t > jump_s && t < end_s;
                let since = t.clamp(jump_s, end_s) - jump_s;
                [theta + rate * since, omega + if inside { rate } else { 0.0 }]
            });
            let fault = truth.fault(&jumped, TrajectoryVerdict::Reset);
            close(fault.theta_dot_rad_s.unwrap().abs(), rate.abs(), &scene.name);
        }
        let zeroed = changed(&right, |t, values| if t > jump_s { [0.0; 2] } else { values });
        let fault = truth.fault(&zeroed, TrajectoryVerdict::Reset);
        assert!(fault.to_zero, "{fault:?}");
    }
}

#[test]
fn an_error_that_grows_exponentially_is_measured() {
    for scene in [scenes::stick(), scenes::spring(), scenes::hybrid(), scenes::pendulum()] {
        let truth = Truth::of(&scene);
        for rate in [12.0, 30.0] {
            let rate = rate / scene.duration_s;
            let size = 2.0 * (-rate * scene.duration_s).exp();
            let grown = changed(&truth.every(1e-3), |t, [theta, omega]| {
                let error = size * (rate * t).exp();
                [theta + error, omega + rate * error]
            });
            let fault = truth.fault(&grown, TrajectoryVerdict::Unstable);
            close(fault.growth_per_s.unwrap(), rate, &scene.name);
        }
    }
}

#[test]
fn a_fall_through_the_stop_is_measured() {
    let truth = Truth::of(&scenes::stop());
    let right = truth.every(1e-3);
    let stop = 0.3;
    let before = right.theta_rad.iter().position(|theta| *theta >= stop).unwrap() - 1;
    let speed = right.theta_dot_rad_s[before];
    let hit_s = right.t_s[before] + (stop - right.theta_rad[before]) / speed;
    let through = changed(&right, |t, [theta, omega]| match t >= hit_s {
        true => [stop + speed * (t - hit_s), speed],
        false => [theta, omega],
    });
    let fault = truth.fault(&through, TrajectoryVerdict::BeyondStop);
    close(fault.theta_rad.unwrap(), speed * (1.0 - hit_s), "depth");
    // In a stop that gives way by less than the tolerance the lever may stand.
    let soft = changed(&right, |t, [theta, omega]| {
        let left = (-(t - hit_s) / 2e-3).exp();
        match t >= hit_s {
            true => [stop + speed * 2e-3 * (1.0 - left), speed * left],
            false => [theta, omega],
        }
    });
    assert_eq!(truth.judge(&soft).unwrap().faults, []);
}

#[test]
fn swings_that_the_scene_does_not_have_are_measured() {
    for scene in [scenes::stick(), scenes::stop(), scenes::let_go()] {
        let truth = Truth::of(&scene);
        let [from_s, to_s] = truth.longest_rest_s();
        let (size, omega) = (1e-4, std::f64::consts::TAU * 50.0);
        // Whole periods, so that nothing jumps.
        let to_s = from_s + (50.0 * (to_s - from_s)).floor() / 50.0;
        let shaken = changed(&truth.every(1e-4), |t, [theta, rate]| {
            let inside = (from_s..=to_s).contains(&t);
            let phase = omega * (t - from_s);
            match inside {
                true => [theta - size * (1.0 - phase.cos()), rate - size * omega * phase.sin()],
                false => [theta, rate],
            }
        });
        let fault = truth.fault(&shaken, TrajectoryVerdict::Chatters);
        assert!((fault.theta_rad.unwrap() / size - 1.0).abs() < 1e-3, "{fault:?}");
        assert!((fault.frequency_hz.unwrap() / 50.0 - 1.0).abs() < 1e-2, "{fault:?}");
    }
}
