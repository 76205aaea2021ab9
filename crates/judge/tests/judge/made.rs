//! Trajectories made of the right motion, and what the judge says of them.

use zwidth_dynamics::ModelScene;
use zwidth_judge::{Allowed, Candidate, JudgeError, Judged, Yardstick, judge};
use zwidth_results::{TrajectoryFault, TrajectoryVerdict};
use zwidth_study::Perception;

/// A scene's right motion.
pub(crate) struct Truth(pub(crate) Yardstick);

impl Truth {
    pub(crate) fn of(scene: &ModelScene) -> Self {
        Self(Yardstick::of(scene, &Perception::default()).unwrap())
    }

    pub(crate) fn duration_s(&self) -> f64 {
        self.0.system.scene().duration_s
    }

    /// The right motion at these times.
    pub(crate) fn at(&self, t_s: Vec<f64>) -> Candidate {
        let run = self.0.at(t_s).unwrap();
        Candidate {
            theta_rad: run.theta_rad().collect(),
            theta_dot_rad_s: run.theta_dot_rad_s().collect(),
            t_s: run.t_s,
            ..Candidate::default()
        }
    }

    /// The right motion in steps.
    pub(crate) fn every(&self, step_s: f64) -> Candidate {
        let steps = (self.duration_s() / step_s).round() as usize;
        self.at((0..=steps).map(|i| i as f64 * step_s).collect())
    }

    /// θ, rad, and θ̇, rad/s, at increasing times.
    pub(crate) fn values(&self, t_s: &[f64]) -> Vec<[f64; 2]> {
        let mut times: Vec<f64> = t_s.iter().copied().filter(|t| *t > 0.0).collect();
        times.insert(0, 0.0);
        let run = self.at(times);
        // A time that is not above 0 has the start's values.
        let before = t_s.len() + 1 - run.t_s.len();
        (0..t_s.len())
            .map(|i| {
                let k = (i + 1).saturating_sub(before);
                [run.theta_rad[k], run.theta_dot_rad_s[k]]
            })
            .collect()
    }

    pub(crate) fn judge(&self, candidate: &Candidate) -> Result<Judged, JudgeError> {
        judge(&self.0, candidate, &Allowed::default(), &Perception::default())
    }

    /// The first fault of a trajectory, which must be this.
    pub(crate) fn fault(&self, candidate: &Candidate, fault: TrajectoryVerdict) -> TrajectoryFault {
        let judged = self.judge(candidate).unwrap();
        let name = &self.0.system.scene().name;
        assert_eq!(judged.trajectory.verdict, fault, "{name}: {judged:?}");
        judged.faults[0].clone()
    }

    /// Times between which the right lever is held, the longest stretch, s.
    pub(crate) fn longest_rest_s(&self) -> [f64; 2] {
        let run = self.every(1e-4);
        let samples: Vec<usize> = (0..run.t_s.len()).collect();
        let rests = |i: usize| run.theta_dot_rad_s[i] == 0.0;
        let stretches = samples.chunk_by(|a, b| rests(*a) && rests(*b));
        let longest = stretches.max_by_key(|stretch| stretch.len()).unwrap();
        [run.t_s[longest[0]], run.t_s[longest[longest.len() - 1]]]
    }
}

/// The same trajectory with other angles and velocities: those of a function of time, angle and
/// velocity.
pub(crate) fn changed(
    candidate: &Candidate,
    change: impl Fn(f64, [f64; 2]) -> [f64; 2],
) -> Candidate {
    let samples = candidate.t_s.iter().zip(&candidate.theta_rad).zip(&candidate.theta_dot_rad_s);
    let changed = samples.map(|((t, theta), omega)| change(*t, [*theta, *omega]));
    let (theta_rad, theta_dot_rad_s) = changed.map(|[theta, omega]| (theta, omega)).unzip();
    Candidate { theta_rad, theta_dot_rad_s, ..candidate.clone() }
}

/// Rounded to six decimals, as programs print.
pub(crate) fn rounded(candidate: &Candidate) -> Candidate {
    let six = |x: f64| (x * 1e6).round() / 1e6;
    changed(candidate, |_, [theta, omega]| [six(theta), six(omega)])
}
