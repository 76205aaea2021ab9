//! No right trajectory is condemned.

use crate::made::{Truth, changed, rounded};
use crate::scenes;
use zwidth_dynamics::{Grid, ModelScene, NAMED_SOLVERS, System};
use zwidth_judge::Candidate;
use zwidth_results::TrajectoryVerdict;

/// Passes, and stands where the lever stands.
fn passes(truth: &Truth, candidate: &Candidate, what: &str) {
    let scene = truth.0.system.scene();
    let judged = truth.judge(candidate).unwrap();
    let stands = scene.name.starts_with("stick");
    let expect = if stands { TrajectoryVerdict::Stands } else { TrajectoryVerdict::Right };
    assert_eq!(judged.trajectory.verdict, expect, "{}, {what}: {judged:#?}", scene.name);
}

#[test]
fn the_right_motion_on_any_grid_is_right_whatever_its_digits() {
    for scene in scenes::all() {
        let truth = Truth::of(&scene);
        for step_s in [1e-4, 1e-3, 2.3e-3, 1e-2, 2e-2] {
            let right = truth.every(step_s);
            passes(&truth, &right, &format!("every {step_s} s"));
            passes(&truth, &rounded(&right), &format!("every {step_s} s, six decimals"));
            let single = |x: f64| f64::from(x as f32);
            let short = changed(&right, |_, [theta, omega]| [single(theta), single(omega)]);
            passes(&truth, &short, &format!("every {step_s} s, floats of four bytes"));
        }
        // Steps that grow to a hundred times the first, as an adaptive method's do.
        let mut t_s = vec![0.0];
        let mut step_s = 1e-4;
        while t_s[t_s.len() - 1] + step_s < scene.duration_s {
            t_s.push(t_s[t_s.len() - 1] + step_s);
            step_s = if step_s > 1e-2 { 1e-4 } else { 1.07 * step_s };
        }
        t_s.push(scene.duration_s);
        passes(&truth, &truth.at(t_s), "uneven steps");
    }
}

/// Programs that solve for the friction leave velocities of 1e-20 rad/s of either sign.
#[test]
fn a_rest_that_trembles_in_its_last_digits_is_a_rest() {
    let scene = ModelScene { duration_s: 12.0, ..scenes::slip_stick() };
    let truth = Truth::of(&scene);
    let right = truth.every(1e-3);
    let turns = right.theta_dot_rad_s.windows(2).filter(|v| v[0] != 0.0 && v[1] == 0.0).count();
    assert!(turns > 8, "{turns} slips");
    let trembling = changed(&right, |t, [theta, omega]| {
        let sign = if (t * 1e3).round() as i64 % 2 == 0 { 1.0 } else { -1.0 };
        [theta, if omega == 0.0 { sign * 1e-20 } else { omega }]
    });
    passes(&truth, &trembling, "trembling");
}

#[test]
fn a_hundred_thousand_samples_a_second_are_right() {
    for scene in [scenes::stop(), ModelScene { duration_s: 1.0, ..scenes::hybrid() }] {
        let truth = Truth::of(&scene);
        let right = truth.every(1e-5);
        passes(&truth, &right, "every 10 µs");
        passes(&truth, &rounded(&right), "every 10 µs, six decimals");
    }
}

#[test]
fn a_file_that_begins_after_the_first_step_or_goes_on_is_right() {
    for scene in scenes::all() {
        let truth = Truth::of(&scene);
        let right = truth.every(1e-3);
        let later = Candidate {
            t_s: right.t_s[1..].to_vec(),
            theta_rad: right.theta_rad[1..].to_vec(),
            theta_dot_rad_s: right.theta_dot_rad_s[1..].to_vec(),
            ..right.clone()
        };
        passes(&truth, &later, "from the first step on");
        let mut longer = right;
        for k in 1..=100 {
            longer.t_s.push(scene.duration_s + 1e-3 * f64::from(k));
            longer.theta_rad.push(0.0);
            longer.theta_dot_rad_s.push(0.0);
        }
        passes(&truth, &longer, "longer than the scene");
    }
}

#[test]
fn a_velocity_that_was_computed_from_the_angles_does_no_harm() {
    for scene in scenes::all() {
        let truth = Truth::of(&scene);
        let right = truth.every(1e-3);
        let n = right.t_s.len();
        let omega = (0..n).map(|i| {
            let [a, b] = [i.saturating_sub(1), (i + 1).min(n - 1)];
            (right.theta_rad[b] - right.theta_rad[a]) / (right.t_s[b] - right.t_s[a])
        });
        let theta_dot_rad_s = omega.collect();
        passes(
            &truth,
            &Candidate { theta_dot_rad_s, velocity_computed: true, ..right },
            "no velocity",
        );
    }
}

#[test]
fn our_own_solvers_are_right_at_small_steps() {
    for scene in scenes::all() {
        let truth = Truth::of(&scene);
        let system = System::new(scene.clone()).unwrap();
        for solver in NAMED_SOLVERS {
            // Methods of a fixed step that switch on the sign of the velocity cannot rest.
            let rests = !matches!(scene.name.as_str(), "undamped spring" | "pendulum");
            let switches = solver.name.starts_with("rk4") || solver.name == "symplectic_euler";
            if rests && switches {
                continue;
            }
            let grid = Grid::filling(scene.duration_s, 1e-4);
            let Ok(run) = (solver.make)(1e-8).run(&system, &grid) else { continue };
            let candidate = Candidate {
                theta_rad: run.theta_rad().collect(),
                theta_dot_rad_s: run.theta_dot_rad_s().collect(),
                t_s: run.t_s,
                ..Candidate::default()
            };
            passes(&truth, &candidate, solver.name);
        }
    }
}
