//! A trajectory and the right motion, sample by sample.

use crate::resolution::resolution;
use crate::{Candidate, JudgeError, Yardstick};
use zwidth_dynamics::{DynamicsError, Motion, System, Trajectory};

/// The start may differ by this much, rad: more than any format rounds.
const START_RAD: f64 = 1e-3;
/// And by this share of the right motion's largest velocity.
const START_SHARE: f64 = 0.05;
/// Angles are degrees if, taken as such, they are off by less than this share of what they are off
/// by as they stand, and by less than this share of the right motion's own deviation.
const DEGREES_SHARE: f64 = 0.05;
const EXPLAINED: f64 = 0.05;
/// A lever that moves at less than this share of the right motion's largest velocity stands still.
const REST_SHARE: f64 = 1e-3;

/// To how much a proven answer is known, rad.
const KNOWN_RAD: f64 = 1e-9;

/// One of the two: a run, and its angles and velocities.
pub(crate) struct Side {
    pub(crate) run: Trajectory,
    pub(crate) theta_rad: Vec<f64>,
    pub(crate) theta_dot_rad_s: Vec<f64>,
}

impl Side {
    fn of(run: Trajectory) -> Self {
        let theta_rad = run.theta_rad().collect();
        let theta_dot_rad_s = run.theta_dot_rad_s().collect();
        Self { run, theta_rad, theta_dot_rad_s }
    }

    /// The largest speed, rad/s.
    pub(crate) fn fastest_rad_s(&self) -> f64 {
        self.theta_dot_rad_s.iter().map(|omega| omega.abs()).fold(0.0, f64::max)
    }

    /// Largest less smallest angle, rad.
    pub(crate) fn range_rad(&self) -> f64 {
        let (low, high) = zwidth_numerics::series::ends(&self.theta_rad);
        high - low
    }
}

/// The trajectory and the right motion at the same times.
pub(crate) struct Sides<'a> {
    pub(crate) system: &'a System,
    pub(crate) t_s: Vec<f64>,
    pub(crate) own: Side,
    pub(crate) right: Side,
    /// Median time between samples, s.
    pub(crate) step_s: f64,
    pub(crate) velocity_computed: bool,
    /// The smallest step between angles, rad, and between velocities, rad/s.
    pub(crate) theta_step_rad: f64,
    pub(crate) omega_step_rad_s: f64,
    /// A lever that moves no faster stands still, rad/s.
    pub(crate) rest_rad_s: f64,
    /// To how much the right answer is known, rad.
    known_rad: f64,
}

impl<'a> Sides<'a> {
    /// Puts a trajectory beside the right motion.
    ///
    /// # Errors
    /// Angles in degrees, another start, a right run that fails.
    pub(crate) fn of(yardstick: &'a Yardstick, candidate: Candidate) -> Result<Self, JudgeError> {
        let system = &yardstick.system;
        let right = Side::of(right_at(yardstick, &candidate.t_s)?);
        check_unit(&candidate, &right)?;
        check_start(&candidate, &right, system)?;
        let theta_step_rad = resolution(&candidate.theta_rad);
        let step_s = candidate.step_s();
        let omega_step_rad_s = match candidate.velocity_computed {
            // A step of the angle is one of the difference that the velocity is made of.
            true => 2.0 * theta_step_rad / step_s,
            false => resolution(&candidate.theta_dot_rad_s),
        };
        let rest_rad_s = (4.0 * omega_step_rad_s).max(REST_SHARE * right.fastest_rad_s());
        let Candidate { t_s, theta_rad, theta_dot_rad_s, velocity_computed, .. } = candidate;
        let run = right.run.with_motion(system, &theta_rad, &theta_dot_rad_s, rest_rad_s);
        Ok(Self {
            system,
            t_s,
            own: Side { run, theta_rad, theta_dot_rad_s },
            right,
            step_s,
            velocity_computed,
            theta_step_rad,
            omega_step_rad_s,
            rest_rad_s,
            known_rad: yardstick.apart_rad.unwrap_or(f64::INFINITY).max(KNOWN_RAD),
        })
    }

    /// The same where a faster motion counts as none: that of a lever that creeps.
    pub(crate) fn resting_below(self, rest_rad_s: f64) -> Self {
        if rest_rad_s <= self.rest_rad_s {
            return self;
        }
        let Side { theta_rad, theta_dot_rad_s, .. } = &self.own;
        let run = self.right.run.with_motion(self.system, theta_rad, theta_dot_rad_s, rest_rad_s);
        Self { own: Side { run, ..self.own }, rest_rad_s, ..self }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.t_s.len()
    }

    /// How far the trajectory is from the right motion at a sample, rad.
    pub(crate) fn apart_rad(&self, i: usize) -> f64 {
        (self.own.theta_rad[i] - self.right.theta_rad[i]).abs()
    }

    /// The largest of that between two samples, both included.
    pub(crate) fn most_apart_rad(&self, from: usize, to: usize) -> f64 {
        (from..=to.min(self.len() - 1)).map(|i| self.apart_rad(i)).fold(0.0, f64::max)
    }

    /// What no angle of the file tells apart, rad: four of its steps, and what the right answer is
    /// known to.
    pub(crate) fn unseen_rad(&self) -> f64 {
        self.known_rad + 4.0 * self.theta_step_rad
    }

    /// Whether the right lever is held at a sample: at rest, by whatever holds it.
    pub(crate) fn is_held(&self, i: usize) -> bool {
        let run = &self.right.run;
        run.regions[usize::from(run.region[i])].motion == Motion::Rest
    }

    /// The stops, rad, if there are any.
    pub(crate) fn stops_rad(&self) -> Option<[f64; 2]> {
        self.system.scene().plant.stops_rad
    }
}

/// The right run at these times; of a file that begins after the scene's start too.
pub(crate) fn right_at(yardstick: &Yardstick, t_s: &[f64]) -> Result<Trajectory, DynamicsError> {
    if t_s.first().is_none_or(|first| *first <= 0.0) {
        return yardstick.at(t_s.to_vec());
    }
    // A run begins with its first sample, whatever its time.
    let mut run = yardstick.at(std::iter::once(0.0).chain(t_s.iter().copied()).collect())?;
    run.t_s.remove(0);
    run.region.remove(0);
    run.states.drain(..run.layout.n);
    Ok(run)
}

/// Whether angles are in degrees: then they follow the right motion all the way, and not only once
/// they have left it.
fn check_unit(candidate: &Candidate, right: &Side) -> Result<(), JudgeError> {
    /// Parts of the run, in each of which they must.
    const PARTS: usize = 4;
    let degree = std::f64::consts::PI / 180.0;
    let start_rad = right.theta_rad[0];
    let all: Vec<(f64, f64)> =
        candidate.theta_rad.iter().copied().zip(right.theta_rad.iter().copied()).collect();
    let squares = |samples: &[(f64, f64)], scale: f64| -> f64 {
        samples.iter().map(|(own, right)| (scale * own - right) * (scale * own - right)).sum()
    };
    let moved: f64 = all.iter().map(|(_, theta)| (theta - start_rad) * (theta - start_rad)).sum();
    let as_degrees = squares(&all, degree);
    let first = all[0].0;
    // Of a lever that stands still the start alone tells.
    let begins_so = start_rad != 0.0 && (first * degree / start_rad - 1.0).abs() < DEGREES_SHARE;
    let is_closer = as_degrees < DEGREES_SHARE * DEGREES_SHARE * squares(&all, 1.0);
    let explains = as_degrees < EXPLAINED * EXPLAINED * moved;
    let mut parts = all.chunks(all.len().div_ceil(PARTS));
    let throughout = parts.all(|part| squares(part, degree) <= squares(part, 1.0));
    if is_closer && throughout && (explains || begins_so) {
        Err(JudgeError::Degrees)
    } else {
        Ok(())
    }
}

/// Whether the first sample is the right motion's.
fn check_start(candidate: &Candidate, right: &Side, system: &System) -> Result<(), JudgeError> {
    let [theta, omega] = [candidate.theta_rad[0], candidate.theta_dot_rad_s[0]];
    let [right_theta, right_omega] = [right.theta_rad[0], right.theta_dot_rad_s[0]];
    let fastest = right.fastest_rad_s();
    // Behind the first step a program's error is that of a step.
    let step_s = candidate.t_s[0];
    let slack_rad = START_RAD + 4.0 * step_s * (omega.abs() + fastest);
    if (theta - right_theta).abs() > slack_rad.max(4.0 * resolution(&candidate.theta_rad)) {
        let [found, right] = [theta, right_theta];
        return Err(JudgeError::OtherStart { what: "θ", found, right, unit: "rad" });
    }
    // A lever that begins at rest may be one that creeps from its first sample on, and a velocity
    // that was computed is not the first sample's own.
    let begins_at_rest = system.scene().start.theta_dot_rad_s == 0.0;
    let apart = (omega - right_omega).abs();
    let is_known = step_s <= 0.0 && !candidate.velocity_computed && !begins_at_rest;
    if is_known && apart > START_SHARE * fastest {
        let [found, right] = [omega, right_omega];
        return Err(JudgeError::OtherStart { what: "θ̇", found, right, unit: "rad/s" });
    }
    Ok(())
}
