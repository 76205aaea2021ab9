//! What is no trajectory of the scene is refused in words.

use crate::made::{Truth, changed};
use crate::scenes;
use zwidth_judge::Candidate;

fn refuses(truth: &Truth, candidate: &Candidate, words: &str) {
    let error = truth.judge(candidate).unwrap_err().to_string();
    assert!(error.contains(words), "{error}");
}

#[test]
fn angles_in_degrees_and_another_start_are_recognised() {
    for scene in scenes::all() {
        let truth = Truth::of(&scene);
        let right = truth.every(1e-3);
        let degrees = changed(&right, |_, [theta, omega]| [theta.to_degrees(), omega.to_degrees()]);
        refuses(&truth, &degrees, "look like degrees");
        let elsewhere = changed(&right, |_, [theta, omega]| [theta + 0.3, omega]);
        refuses(&truth, &elsewhere, "it starts with θ = ");
    }
    let moving = zwidth_dynamics::Start { theta_rad: 0.2, theta_dot_rad_s: 2.0 };
    let truth = Truth::of(&zwidth_dynamics::ModelScene { start: moving, ..scenes::spring() });
    let slower = changed(&truth.every(1e-3), |_, [theta, omega]| [theta, 0.5 * omega]);
    refuses(&truth, &slower, "it starts with θ̇ = 1 rad/s, and the scene with 2 rad/s");
}
