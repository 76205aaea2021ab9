//! The balance of forces in weak form: what the recorded motion needs, without differentiating it.
//!
//! The equation of motion times a hat φ (1 at the middle of three nodes a < b < c, 0 at the outer
//! two), integrated over time and by parts twice while the lever moves in one direction s, is
//!
//! ```text
//! M_O L [θ] + B_O [∫θ] + s F_C (c − a)/2 + s ∫φ b dt − ∫φ F_m dt = ∫φ F_ex dt
//! [y] = (y_c − y_b)/(c − b) − (y_b − y_a)/(b − a)
//! ```
//!
//! with the motor's force F_m and the brake's level b as they follow the recorded commands with
//! their lags. All that is noisy stands on the right: the force sensor's noise is the error of what
//! is explained, for which least squares is not biased, and the angle, which is nearly free of it,
//! explains. Driven the other way, by force, the noise would be in what explains. Hats are the test
//! functions of finite elements; on weak forms against noise see Messenger & Bortz (2021),
//! J. Comput. Phys. 443:110525.
//!
//! A lever that reverses, sticks or lies on a stop is held by forces that nobody recorded, so such
//! times have no hats.

use crate::scene::Rendering;
use crate::{Parameters, ReplayError, WhyNot};
use zwidth_numerics::cubic;
use zwidth_numerics::updates::{Updates, updates};
use zwidth_store::{Signal, Trial};

/// Nodes are samples at least this far apart, s: a count of the angle sensor is then a small part
/// of the motion between two.
const NODE_S: f64 = 0.008;
/// Half of a hat's base, s: short against the movement of a hand, long against the counts of the
/// angle sensor.
const HALF_S: f64 = 0.05;
/// A lever faster than this between two nodes moves, rad/s: several counts of the prototype's angle
/// sensor.
const MOVING_RAD_S: f64 = 0.1;
/// Points and weights of the Gauss–Legendre rule on (0, 1): exact for a cubic times a hat.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// A trial's motion and commands, ready to say what force they need.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    lever_m: f64,
    /// Of every sample, s.
    t_s: Vec<f64>,
    /// Commands of motor (above 0 pushes to +θ) and brake (its level) from each sample to the
    /// next, N.
    motor_n: Vec<f64>,
    brake_n: Vec<f64>,
    hats: Vec<Hat>,
    measured_ns: Vec<f64>,
}

/// One hat, and what it makes of the recorded angle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hat {
    /// Samples at its nodes.
    nodes: [usize; 3],
    /// Which way the lever moves: 1 or −1.
    direction: f64,
    /// [θ], rad/s.
    turned_rad_s: f64,
    /// [∫θ], rad.
    moved_rad: f64,
    /// (c − a)/2, s.
    half_base_s: f64,
}

impl Balance {
    /// Makes a trial ready. A trial in which the lever never moves long enough has no hats.
    ///
    /// # Errors
    /// [`ReplayError::WhyNot`] where the recording or what is known of it lacks what the balance
    /// needs; columns of unequal length.
    pub fn new(trial: &Trial, rendering: &Rendering) -> Result<Self, ReplayError> {
        let lever_m = rendering.lever_m.ok_or(WhyNot::NoLever)?;
        let t_s = trial.samples.get(Signal::Time).unwrap_or_default().to_vec();
        if t_s.len() < 3 {
            return Err(WhyNot::TooShort.into());
        }
        let column = |signal| crate::drive::column(trial, signal, t_s.len());
        let theta = column(Signal::Theta)?.ok_or(WhyNot::NoAngle)?;
        let force = column(Signal::ForceEx)?.ok_or(WhyNot::NoForce)?;
        let voltages = [column(Signal::VoltageMotor)?, column(Signal::VoltageBrake)?];
        let [motor_n, brake_n] = rendering.commands_n(t_s.len(), voltages)?;
        let updates = match column(Signal::ForceAge)? {
            Some(age) => updates(&t_s, force, age),
            None => Updates { t: t_s.clone(), values: force.to_vec() },
        };
        let hats = hats(&t_s, theta, &updates);
        let impulse = Impulse::of_force(&t_s, &updates);
        let measured_ns = hats.iter().map(|hat| impulse.through(hat, &t_s)).collect();
        Ok(Self { lever_m, t_s, motor_n, brake_n, hats, measured_ns })
    }

    /// ∫φ F_ex dt of every hat, N·s, as the force sensor has it.
    pub fn measured_ns(&self) -> &[f64] {
        &self.measured_ns
    }

    /// The same, as motion and commands need it from a plant.
    pub fn needed_ns(&self, plant: &Parameters) -> Vec<f64> {
        let motor = Impulse::of_lagging(&self.t_s, &self.motor_n, [plant.motor_lag_s; 2]);
        let brake =
            Impulse::of_lagging(&self.t_s, &self.brake_n, [plant.brake_on_s, plant.brake_off_s]);
        let needed = |hat: &Hat| {
            let inertia = plant.mass_kg * self.lever_m * hat.turned_rad_s;
            let viscous = plant.damping_ns_per_rad * hat.moved_rad;
            let dry = plant.friction_n * hat.half_base_s + brake.through(hat, &self.t_s);
            inertia + viscous + hat.direction * dry - motor.through(hat, &self.t_s)
        };
        self.hats.iter().map(needed).collect()
    }
}

/// [y] for values at three nodes.
fn bent(t: [f64; 3], y: [f64; 3]) -> f64 {
    (y[2] - y[1]) / (t[2] - t[1]) - (y[1] - y[0]) / (t[1] - t[0])
}

/// Every hat that fits into a stretch of motion and between the first and the last value of the
/// force; each begins a quarter of a base after the one before.
fn hats(t: &[f64], theta: &[f64], force: &Updates) -> Vec<Hat> {
    let (Some(first), Some(last)) = (force.t.first(), force.t.last()) else { return Vec::new() };
    if force.t.len() < cubic::SAMPLES {
        return Vec::new();
    }
    let nodes = nodes(t);
    let spacing_s = (t[nodes[nodes.len() - 1]] - t[0]) / (nodes.len() - 1) as f64;
    let quarter = ((HALF_S / 2.0 / spacing_s).round() as usize).max(1);
    let mut integral = vec![0.0];
    integral.extend(cubic::integrals(t, theta).iter().scan(0.0, |sum, part| {
        *sum += part;
        Some(*sum)
    }));
    let hat = |at: usize, direction: f64| {
        let nodes = [0, 2, 4].map(|k| nodes[at + k * quarter]);
        let times = nodes.map(|i| t[i]);
        Hat {
            nodes,
            direction,
            turned_rad_s: bent(times, nodes.map(|i| theta[i])),
            moved_rad: bent(times, nodes.map(|i| integral[i])),
            half_base_s: (times[2] - times[0]) / 2.0,
        }
    };
    let in_force = |hat: &Hat| t[hat.nodes[0]] >= *first && t[hat.nodes[2]] <= *last;
    let of = |run: Run| {
        let starts = (run.from..).step_by(quarter).take_while(move |at| at + 4 * quarter <= run.to);
        starts.map(move |at| (at, run.direction))
    };
    runs(t, theta, &nodes)
        .into_iter()
        .flat_map(of)
        .map(|(at, s)| hat(at, s))
        .filter(in_force)
        .collect()
}

/// Samples that serve as nodes.
fn nodes(t: &[f64]) -> Vec<usize> {
    let mut nodes = vec![0];
    for i in 1..t.len() {
        if t[i] - t[nodes[nodes.len() - 1]] >= NODE_S {
            nodes.push(i);
        }
    }
    nodes
}

/// A stretch of motion in one direction, between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Run {
    from: usize,
    to: usize,
    direction: f64,
}

/// The stretches of motion, less the spacing at either end: there the lever may still, or again,
/// have been at rest.
fn runs(t: &[f64], theta: &[f64], nodes: &[usize]) -> Vec<Run> {
    let direction = |pair: &[usize]| {
        let velocity = (theta[pair[1]] - theta[pair[0]]) / (t[pair[1]] - t[pair[0]]);
        i8::from(velocity > MOVING_RAD_S) - i8::from(velocity < -MOVING_RAD_S)
    };
    let directions: Vec<i8> = nodes.windows(2).map(direction).collect();
    let (mut runs, mut from) = (Vec::new(), 0);
    for stretch in directions.chunk_by(|a, b| a == b) {
        let to = from + stretch.len();
        if stretch[0] != 0 && stretch.len() > 2 {
            runs.push(Run { from: from + 1, to: to - 1, direction: f64::from(stretch[0]) });
        }
        from = to;
    }
    runs
}

/// A force's running integrals ∫F dt and ∫t F dt at every sample, from the first on: they give its
/// integral over any hat.
struct Impulse {
    force_ns: Vec<f64>,
    moment_ns2: Vec<f64>,
}

impl Impulse {
    /// From the integrals ∫F dt and ∫(t − tᵢ) F dt over each interval between samples.
    fn new(t: &[f64], parts: impl Iterator<Item = [f64; 2]>) -> Self {
        let (mut force_ns, mut moment_ns2) = (vec![0.0], vec![0.0]);
        let (mut force, mut moment) = (0.0, 0.0);
        for ([part, lever], from) in parts.zip(t) {
            force += part;
            moment += lever + from * part;
            force_ns.push(force);
            moment_ns2.push(moment);
        }
        Self { force_ns, moment_ns2 }
    }

    /// Of a sensor's values, joined by cubics.
    fn of_force(t: &[f64], force: &Updates) -> Self {
        let part = |pair: &[f64]| {
            let h = pair[1] - pair[0];
            GAUSS.iter().fold([0.0; 2], |sum, (place, weight)| {
                let value =
                    cubic::value(&force.t, &force.values, pair[0] + place * h).unwrap_or(0.0);
                [sum[0] + weight * h * value, sum[1] + weight * h * place * h * value]
            })
        };
        Self::new(t, t.windows(2).map(part))
    }

    /// Of a force that follows held commands with a time constant each for rising and falling, from
    /// 0 on; 0 s is at once.
    fn of_lagging(t: &[f64], commands: &[f64], [rising_s, falling_s]: [f64; 2]) -> Self {
        let mut level = 0.0;
        let part = |(pair, command): (&[f64], &f64)| {
            let (h, off) = (pair[1] - pair[0], level - command);
            level = *command;
            let held = [command * h, command * h * h / 2.0];
            if off == 0.0 {
                return held; // as most of the time for the actuator that the mode does not use
            }
            let lag = if off > 0.0 { falling_s } else { rising_s };
            let gone = -libm::expm1(-h / lag);
            let left = 1.0 - gone;
            level += off * left;
            [held[0] + off * lag * gone, held[1] + off * lag * (lag * gone - h * left)]
        };
        Self::new(t, t.windows(2).zip(commands).map(part))
    }

    /// ∫φ F dt.
    fn through(&self, hat: &Hat, t: &[f64]) -> f64 {
        let [a, b, c] = hat.nodes;
        let over = |from: usize, to: usize| {
            [self.force_ns[to] - self.force_ns[from], self.moment_ns2[to] - self.moment_ns2[from]]
        };
        let ([up, up_moment], [down, down_moment]) = (over(a, b), over(b, c));
        (up_moment - t[a] * up) / (t[b] - t[a]) + (t[c] * down - down_moment) / (t[c] - t[b])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, trial, without};
    use zwidth_store::Samples;

    const PLANT: Parameters = Parameters {
        mass_kg: 0.1,
        damping_ns_per_rad: 0.12,
        friction_n: 0.15,
        motor_lag_s: 0.002,
        brake_on_s: 0.015,
        brake_off_s: 0.01,
    };

    /// Half a second at rest, and a movement there and back; no voltages. The force is that of the
    /// equation of motion.
    fn moved(rate_hz: f64, plant: &Parameters) -> Samples {
        let lever_m = rendering("hybrid").lever_m.unwrap();
        let t: Vec<f64> = (0..(3.0 * rate_hz) as u32).map(|i| f64::from(i) / rate_hz).collect();
        let phase = |t: f64| 2.5 * (t - 0.5).max(0.0);
        let theta = t.iter().map(|t| -0.7 + 0.6 * (1.0 - libm::cos(phase(*t)))).collect();
        let force = |t: &f64| {
            let (rate, bend) = (1.5 * libm::sin(phase(*t)), 3.75 * libm::cos(phase(*t)));
            let dry = plant.friction_n * if rate == 0.0 { 0.0 } else { rate.signum() };
            plant.mass_kg * lever_m * bend + plant.damping_ns_per_rad * rate + dry
        };
        let mut samples = Samples::default();
        samples.set(Signal::ForceEx, t.iter().map(force).collect());
        samples.set(Signal::Theta, theta);
        for voltage in [Signal::VoltageMotor, Signal::VoltageBrake] {
            samples.set(voltage, vec![0.0; t.len()]);
        }
        samples.set(Signal::Time, t);
        samples
    }

    fn balance(samples: Samples) -> Result<Balance, ReplayError> {
        Balance::new(&trial("hybrid", samples), &rendering("hybrid"))
    }

    #[test]
    fn the_motion_needs_the_force_that_made_it() {
        let found = balance(moved(1000.0, &PLANT)).unwrap();
        let (needed, measured) = (found.needed_ns(&PLANT), found.measured_ns());
        assert!(measured.len() > 80, "{}", measured.len());
        for (needed, measured) in needed.iter().zip(measured) {
            assert!((needed - measured).abs() < 1e-11, "{needed} instead of {measured}");
        }
        let heavy = Parameters { mass_kg: 0.2, ..PLANT };
        assert!(found.needed_ns(&heavy).iter().zip(measured).any(|(n, m)| (n - m).abs() > 5e-4));
    }

    #[test]
    fn no_hat_reaches_into_rest_or_over_a_reversal() {
        let found = balance(moved(120.0, &PLANT)).unwrap();
        let reversal_s = 0.5 + core::f64::consts::PI / 2.5;
        assert!(
            found.hats.iter().any(|h| h.direction > 0.0)
                && found.hats.iter().any(|h| h.direction < 0.0)
        );
        for hat in &found.hats {
            let [from, _, to] = hat.nodes.map(|i| found.t_s[i]);
            assert!(from > 0.5 && (to < reversal_s || from > reversal_s), "{from} to {to}");
            assert!((hat.half_base_s - HALF_S).abs() < NODE_S);
        }
    }

    /// b(t) = c (1 − e^(−t/τ)) from rest: ∫b and ∫t b in closed form, with the command in two
    /// pieces.
    #[test]
    fn a_lag_is_followed_exactly() {
        let (lag, command, end) = (0.015_f64, 3.0, 0.05_f64);
        let found = Impulse::of_lagging(&[0.0, 0.02, end], &[command; 3], [lag, 0.5]);
        let e = (-end / lag).exp();
        let force = command * (end - lag * (1.0 - e));
        let moment = command * (end * end / 2.0 - lag * lag * (1.0 - e) + lag * end * e);
        assert!((found.force_ns[2] - force).abs() < 1e-15, "{} {force}", found.force_ns[2]);
        assert!((found.moment_ns2[2] - moment).abs() < 1e-15, "{} {moment}", found.moment_ns2[2]);
        let at_once = Impulse::of_lagging(&[0.0, 0.02, end], &[command; 3], [0.0; 2]);
        assert!((at_once.force_ns[2] - command * end).abs() < 1e-15);
    }

    #[test]
    fn a_falling_level_has_its_own_lag() {
        let t = [0.0, 1.0, 2.0];
        let [slow, quick] =
            [0.5, 0.01].map(|off| Impulse::of_lagging(&t, &[4.0, 0.0, 0.0], [1e-3, off]));
        assert!((slow.force_ns[1] - quick.force_ns[1]).abs() < 1e-12);
        let fallen = |impulse: &Impulse| impulse.force_ns[2] - impulse.force_ns[1];
        assert!((fallen(&quick) - 0.04).abs() < 1e-9 && fallen(&slow) > 1.5);
    }

    #[test]
    fn without_voltages_of_an_actuator_in_use_there_is_no_balance() {
        let samples = without(&moved(120.0, &PLANT), Signal::VoltageBrake);
        assert!(matches!(balance(samples), Err(ReplayError::WhyNot(WhyNot::NoVoltages))));
    }

    #[test]
    fn a_lever_that_never_moves_has_no_hats() {
        let mut samples = moved(120.0, &PLANT);
        samples.set(Signal::Theta, vec![-0.7; samples.get(Signal::Time).unwrap().len()]);
        assert!(balance(samples).unwrap().measured_ns().is_empty());
    }
}
