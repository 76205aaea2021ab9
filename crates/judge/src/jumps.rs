//! Jumps of the state that no motion makes: a reset.

use crate::sides::{Side, Sides};

/// What the right motion shows at its own kinks counts so many times.
const TIMES: f64 = 4.0;
/// A velocity that jumps by less than this share of the largest one has a kink.
const SHARE: f64 = 0.05;

/// A jump between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jump {
    /// The first sample behind it.
    pub(crate) at: usize,
    /// Jump of θ, rad; 0 if there is none.
    pub(crate) theta_rad: f64,
    /// Jump of θ̇, rad/s; 0 if there is none.
    pub(crate) theta_dot_rad_s: f64,
    /// Whether both are 0 behind it.
    pub(crate) to_zero: bool,
}

/// How far each step of θ, and each of θ̇, is from what a smooth motion would make it: θ moves by the
/// mean of the velocities at both ends, θ̇ by the mean of its slopes before and behind.
struct Excess {
    theta_rad: Vec<f64>,
    omega_rad_s: Vec<f64>,
}

impl Excess {
    fn of(t_s: &[f64], side: &Side, velocity_computed: bool) -> Self {
        let Side { theta_rad, theta_dot_rad_s, .. } = side;
        // A velocity that was made of the angles has their jump in it.
        let theta = match velocity_computed {
            true => beyond_slopes(t_s, theta_rad),
            false => {
                let steps = t_s.windows(2).enumerate();
                let moved = steps.map(|(i, t)| {
                    let mean = 0.5 * (theta_dot_rad_s[i] + theta_dot_rad_s[i + 1]);
                    theta_rad[i + 1] - theta_rad[i] - mean * (t[1] - t[0])
                });
                moved.collect()
            }
        };
        let omega = match velocity_computed {
            true => vec![0.0; theta.len()],
            false => beyond_slopes(t_s, theta_dot_rad_s),
        };
        Self { theta_rad: theta, omega_rad_s: omega }
    }
}

/// Each step of a quantity less what the mean of the slopes before and behind it makes of it; 0 for
/// the first and the last step.
fn beyond_slopes(t_s: &[f64], x: &[f64]) -> Vec<f64> {
    let slope = |i: usize| (x[i + 1] - x[i]) / (t_s[i + 1] - t_s[i]);
    let steps = t_s.len() - 1;
    let beyond = (0..steps).map(|i| {
        if i == 0 || i + 1 == steps {
            return 0.0;
        }
        x[i + 1] - x[i] - 0.5 * (slope(i - 1) + slope(i + 1)) * (t_s[i + 1] - t_s[i])
    });
    beyond.collect()
}

/// The jumps that the right motion does not have, in order of time. At a stop θ̇ may jump.
pub(crate) fn jumps(sides: &Sides<'_>, near_rad: f64) -> Vec<Jump> {
    let Sides { t_s, own, right, theta_step_rad, omega_step_rad_s, .. } = sides;
    let excess = Excess::of(t_s, own, sides.velocity_computed);
    let expected = Excess::of(t_s, right, sides.velocity_computed);
    let at_stop = |side: &Side, i: usize| {
        let h = t_s[i + 1] - t_s[i];
        let reach = near_rad + h * side.theta_dot_rad_s[i].abs();
        sides.stops_rad().is_some_and(|stops| {
            stops.iter().any(|stop| (i..=i + 1).any(|k| (side.theta_rad[k] - stop).abs() <= reach))
        })
    };
    let largest = |values: &[f64], except_stops: bool| {
        let kept = values.iter().enumerate();
        let kept = kept
            .filter(|(i, _)| !except_stops || !is_near(&|k| at_stop(right, k), *i, values.len()));
        kept.map(|(_, value)| value.abs()).fold(0.0, f64::max)
    };
    let theta_kinks = largest(&expected.theta_rad, true);
    let omega_kinks = largest(&expected.omega_rad_s, true);
    let fastest = own.fastest_rad_s().max(right.fastest_rad_s());
    // What the forces of the scene can do from one sample to the next is no jump.
    let hardest = hardest_rad_s2(sides);
    let mut jumps = Vec::new();
    for i in 0..t_s.len() - 1 {
        let h = t_s[i + 1] - t_s[i];
        let turn = (own.theta_dot_rad_s[i + 1] - own.theta_dot_rad_s[i]).abs();
        let theta_bound = sides.unseen_rad()
            + TIMES * theta_kinks
            + h * (turn + excess.omega_rad_s[i].abs() + TIMES * omega_step_rad_s + h * hardest);
        let omega_bound =
            TIMES * (omega_kinks + omega_step_rad_s) + (SHARE * fastest).max(h * hardest);
        let theta_rad = excess.theta_rad[i];
        let omega_rad_s = excess.omega_rad_s[i];
        let theta_jumps = theta_rad.abs() > theta_bound;
        let omega_jumps = omega_rad_s.abs() > omega_bound
            && !(i..=i + 1).all(|k| own.theta_dot_rad_s[k].abs() <= sides.rest_rad_s)
            && !is_near(&|k| at_stop(own, k), i, t_s.len() - 1)
            && !is_near(&|k| at_stop(right, k), i, t_s.len() - 1)
            && is_peak(&excess.omega_rad_s, i);
        if theta_jumps && (!sides.velocity_computed || is_peak(&excess.theta_rad, i)) || omega_jumps
        {
            let is_zero = |x: f64, step: f64| x.abs() <= 1e-9 + 4.0 * step;
            let was_zero = is_zero(own.theta_rad[i], *theta_step_rad);
            jumps.push(Jump {
                at: i + 1,
                theta_rad: if theta_jumps { theta_rad - expected.theta_rad[i] } else { 0.0 },
                theta_dot_rad_s: if omega_jumps {
                    omega_rad_s - expected.omega_rad_s[i]
                } else {
                    0.0
                },
                to_zero: !was_zero
                    && is_zero(own.theta_rad[i + 1], *theta_step_rad)
                    && is_zero(own.theta_dot_rad_s[i + 1], *omega_step_rad_s),
            });
        }
    }
    jumps
}

/// Whether it holds for a step, or for one of the two before and behind: the slopes there are part of
/// its excess.
fn is_near(holds: &dyn Fn(usize) -> bool, i: usize, steps: usize) -> bool {
    (i.saturating_sub(2)..=(i + 2).min(steps - 1)).any(holds)
}

/// Whether a step has the largest excess of itself and its neighbours, which a jump disturbs too.
fn is_peak(excess: &[f64], i: usize) -> bool {
    let near = i.saturating_sub(2)..=(i + 2).min(excess.len() - 1);
    near.filter(|k| *k != i).all(|k| {
        let [own, other] = [excess[i].abs(), excess[k].abs()];
        own > other || (own >= other && i < k)
    })
}

/// The largest acceleration that the right motion's forces could give together, rad/s².
fn hardest_rad_s2(sides: &Sides<'_>) -> f64 {
    let plant = &sides.system.scene().plant;
    let run = &sides.right.run;
    let forces = (0..run.len()).map(|i| {
        let f = run.forces(sides.system, i);
        [f.tip_n, f.motor_n, f.brake_n, f.friction_n, f.terms_n, f.stop_n]
            .iter()
            .map(|n| n.abs())
            .sum::<f64>()
    });
    forces.fold(0.0, f64::max) / (plant.mass_kg * plant.lever_m)
}
