//! The balance of forces in weak form: the forces that the recorded motion needs, without
//! differentiating it.
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
//! their lags. All noisy terms are on the right. The force sensor's noise is the error of the
//! dependent variable, which does not bias least squares, and the angle, which is nearly free of
//! noise, is the explanatory variable. If the model were driven by force instead, the noise would
//! be in the explanatory variable. Hats are the test functions of finite elements; on weak forms
//! against noise see Messenger & Bortz (2021), J. Comput. Phys. 443:110525.
//!
//! A lever that reverses, sticks or rests on a stop is held by unrecorded forces, so such times
//! have no hats.

use crate::scene::Rendering;
use crate::{Parameters, ReplayError, WhyNot};
use std::rc::Rc;
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
    clock: Clock,
    /// Commands of motor (above 0 pushes to +θ) and brake (its level) from each sample to the
    /// next, N; none of an actuator that is commanded nothing.
    motor_n: Vec<f64>,
    brake_n: Vec<f64>,
    hats: Vec<Hat>,
    measured_ns: Vec<f64>,
}

/// One hat, and the terms of the recorded angle over it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hat {
    /// Samples at its nodes.
    nodes: [usize; 3],
    /// The direction in which the lever moves: 1 or −1.
    direction: f64,
    /// [θ], rad/s.
    turned_rad_s: f64,
    /// [∫θ], rad.
    moved_rad: f64,
    /// (c − a)/2, s.
    half_base_s: f64,
}

impl Balance {
    /// Prepares a trial. A trial in which the lever never moves long enough has no hats.
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
        let [motor_n, brake_n] = rendering.commands_n(t_s.len(), voltages)?.map(unless_idle);
        let updates = match column(Signal::ForceAge)? {
            Some(age) => updates(&t_s, force, age),
            None => Updates { t: t_s.clone(), values: force.to_vec() },
        };
        let hats = hats(&t_s, theta, &updates);
        let impulse = Impulse::of_force(&t_s, &updates);
        let measured_ns = hats.iter().map(|hat| impulse.through(hat, &t_s)).collect();
        Ok(Self { lever_m, clock: Clock::of(t_s), motor_n, brake_n, hats, measured_ns })
    }

    /// ∫φ F_ex dt of every hat, N·s, as the force sensor has it.
    pub fn measured_ns(&self) -> &[f64] {
        &self.measured_ns
    }

    /// ∫φ F_ex dt of every hat, N·s, as motion and commands need it, for each of some plants.
    /// Plants with the same lags share the actuators' forces, which take long to compute.
    pub fn needed_ns(&self, plants: &[Parameters]) -> Vec<Vec<f64>> {
        let motor_lags = plants.iter().map(|plant| [plant.motor_lag_s; 2]);
        let brake_lags = plants.iter().map(|plant| [plant.brake_on_s, plant.brake_off_s]);
        let motors = self.of_lags(&self.motor_n, motor_lags);
        let brakes = self.of_lags(&self.brake_n, brake_lags);
        let mut needed_ns = Vec::with_capacity(plants.len());
        for ((plant, motor), brake) in plants.iter().zip(motors).zip(brakes) {
            let hats = self.hats.iter().zip(motor.iter().zip(brake.iter()));
            let needed = hats.map(|(hat, (motor, brake))| {
                let inertia = plant.mass_kg * self.lever_m * hat.turned_rad_s;
                let viscous = plant.damping_ns_per_rad * hat.moved_rad;
                let dry = plant.friction_n * hat.half_base_s + brake;
                inertia + viscous + hat.direction * dry - motor
            });
            needed_ns.push(needed.collect());
        }
        needed_ns
    }

    /// ∫φ F dt of every hat, for each pair of lags by which a force follows its commands; computed
    /// once for equal pairs.
    fn of_lags(&self, commands: &[f64], lags: impl Iterator<Item = [f64; 2]>) -> Vec<Through> {
        let mut distinct: Vec<([u64; 2], Through)> = Vec::new();
        let mut all = Vec::new();
        for lags in lags {
            let bits = lags.map(f64::to_bits);
            if let Some((_, through)) = distinct.iter().find(|(other, _)| *other == bits) {
                all.push(through.clone());
                continue;
            }
            let through: Through = match commands {
                [] => self.hats.iter().map(|_| 0.0).collect(),
                _ => {
                    let impulse = Impulse::of_lagging(&self.clock, commands, lags);
                    self.hats.iter().map(|hat| impulse.through(hat, &self.clock.t_s)).collect()
                }
            };
            distinct.push((bits, through.clone()));
            all.push(through);
        }
        all
    }
}

/// ∫φ F dt of every hat, N·s.
type Through = Rc<[f64]>;

/// The commands of an actuator; none if all are 0, which spares the integrals.
fn unless_idle(commands: Vec<f64>) -> Vec<f64> {
    if commands.iter().all(|command| *command == 0.0) { Vec::new() } else { commands }
}

/// The times of the samples.
#[derive(Debug, Clone, PartialEq)]
struct Clock {
    t_s: Vec<f64>,
    /// Mean interval, s.
    usual_s: f64,
    /// By how much an interval differs from it at most, s.
    jitter_s: f64,
}

impl Clock {
    /// The clock of two samples at least.
    fn of(t_s: Vec<f64>) -> Self {
        let usual_s = (t_s[t_s.len() - 1] - t_s[0]) / (t_s.len() - 1) as f64;
        let jitter = t_s.windows(2).map(|t| (t[1] - t[0] - usual_s).abs());
        let jitter_s = jitter.fold(0.0, f64::max);
        Self { t_s, usual_s, jitter_s }
    }

    /// 1 − e^(−h/lag) for each interval h: what of a step is gone after it. Intervals are nearly alike:
    /// e^(−h/lag) is that of the usual one times e^x of a small x, which has a short series.
    fn gone(&self, lag_s: f64) -> Vec<f64> {
        if self.usual_s - self.jitter_s > ALL_GONE * lag_s {
            return vec![1.0; self.t_s.len() - 1];
        }
        let intervals = self.t_s.windows(2).map(|t| t[1] - t[0]);
        let farthest = self.jitter_s / lag_s;
        let Some(halvings) = (0..=MOST_HALVINGS).find(|n| farthest < NEAR * 2_f64.powi(*n)) else {
            return intervals.map(|h| -libm::expm1(-h / lag_s)).collect();
        };
        // e^x − 1 of halves of halves of x, then e^2x − 1 = y (2 + y) of y = e^x − 1.
        let scale = 0.5_f64.powi(halvings) / lag_s;
        let off = intervals.map(|h| (self.usual_s - h) * scale);
        let mut gone: Vec<f64> = match farthest < NEARER {
            true => off.map(near_expm1::<FEWER_TERMS>).collect(),
            false => off.map(near_expm1::<TERMS>).collect(),
        };
        for _ in 0..halvings {
            gone.iter_mut().for_each(|y| *y *= 2.0 + *y);
        }
        let usual = -self.usual_s / lag_s;
        if self.usual_s > lag_s {
            let left = libm::exp(usual);
            gone.iter_mut().for_each(|y| *y = 1.0 - left * (1.0 + *y));
        } else {
            // Where little is gone, without a 1 that takes its digits.
            let less = libm::expm1(usual);
            gone.iter_mut().for_each(|y| *y = -(less + *y + less * *y));
        }
        gone
    }
}

/// After this many lags nothing is left that a number near 1 could show: e^−40 is 4e-18.
const ALL_GONE: f64 = 40.0;
/// Below this the series of e^x − 1 is cut off after so many terms: what follows is below 1e-17 of it.
const NEAR: f64 = 0.25;
const TERMS: usize = 12;
/// The same for most lags, which are hundreds of times as long as intervals differ.
const NEARER: f64 = 5e-3;
const FEWER_TERMS: usize = 6;
/// Each halving costs a fraction of a digit: intervals that differ by more than 16 lags are taken
/// one by one.
const MOST_HALVINGS: i32 = 6;

/// e^x − 1 for a small x by its series: x (1 + x/2 (1 + x/3 (1 + …))).
fn near_expm1<const N: usize>(x: f64) -> f64 {
    /// 1/n! from 1 on.
    const SHARES: [f64; TERMS] = {
        let mut shares = [1.0; TERMS];
        let mut n = 1;
        while n < TERMS {
            shares[n] = shares[n - 1] / (n + 1) as f64;
            n += 1;
        }
        shares
    };
    SHARES[..N].iter().rev().fold(0.0, |sum, share| sum * x + share) * x
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
    // Samples come at the clock's pace, and nodes are seldom exactly `NODE_S` apart.
    let spacing_s = (t[nodes[nodes.len() - 1]] - t[0]) / (nodes.len() - 1) as f64;
    let quarter = ((HALF_S / 2.0 / spacing_s).round() as usize).max(1);
    let mut integral = vec![0.0];
    integral.extend(cubic::integrals(t, theta).iter().scan(0.0, |sum, part| {
        *sum += part;
        Some(*sum)
    }));
    let mut hats = Vec::new();
    for Run { from, to, direction } in runs(t, theta, &nodes) {
        for at in (from..).step_by(quarter).take_while(|at| at + 4 * quarter <= to) {
            let nodes = [0, 2, 4].map(|k| nodes[at + k * quarter]);
            let times = nodes.map(|i| t[i]);
            // Beyond its first and last value the force is not known.
            if times[0] >= *first && times[2] <= *last {
                hats.push(Hat {
                    nodes,
                    direction,
                    turned_rad_s: bent(times, nodes.map(|i| theta[i])),
                    moved_rad: bent(times, nodes.map(|i| integral[i])),
                    half_base_s: (times[2] - times[0]) / 2.0,
                });
            }
        }
    }
    hats
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
    let directions: Vec<i8> = nodes
        .windows(2)
        .map(|pair| {
            let velocity = (theta[pair[1]] - theta[pair[0]]) / (t[pair[1]] - t[pair[0]]);
            i8::from(velocity > MOVING_RAD_S) - i8::from(velocity < -MOVING_RAD_S)
        })
        .collect();
    let mut runs = Vec::new();
    let mut from = 0;
    for stretch in directions.chunk_by(|a, b| a == b) {
        let to = from + stretch.len();
        // Without both ends, where the lever may be at rest, something must be left.
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
        let [mut force_ns, mut moment_ns2] = [(); 2].map(|()| Vec::with_capacity(t.len()));
        force_ns.push(0.0);
        moment_ns2.push(0.0);
        let mut force = 0.0;
        let mut moment = 0.0;
        for ([part, lever], from) in parts.zip(t) {
            force += part;
            moment += lever + from * part;
            force_ns.push(force);
            moment_ns2.push(moment);
        }
        Self { force_ns, moment_ns2 }
    }

    /// The impulse of a sensor's values, joined by cubics.
    fn of_force(t: &[f64], force: &Updates) -> Self {
        let parts = t.windows(2).map(|pair| {
            let h = pair[1] - pair[0];
            GAUSS.iter().fold([0.0; 2], |sum, (place, weight)| {
                let value =
                    cubic::value(&force.t, &force.values, pair[0] + place * h).unwrap_or(0.0);
                [sum[0] + weight * h * value, sum[1] + weight * h * place * h * value]
            })
        });
        Self::new(t, parts)
    }

    /// The impulse of a force that follows held commands with a time constant each for rising and
    /// falling, from
    /// 0 on; 0 s is at once.
    fn of_lagging(clock: &Clock, commands: &[f64], [rising_s, falling_s]: [f64; 2]) -> Self {
        let t = &clock.t_s;
        let rising = clock.gone(rising_s);
        let is_one = falling_s.to_bits() == rising_s.to_bits();
        let falling = (!is_one).then(|| clock.gone(falling_s));
        let falling = falling.as_ref().unwrap_or(&rising);
        let mut level = 0.0;
        let gone = rising.iter().zip(falling);
        let intervals = t.windows(2).zip(commands).zip(gone);
        let parts = intervals.map(|((pair, command), (rising, falling))| {
            let h = pair[1] - pair[0];
            let off = level - command;
            level = *command;
            let held = [command * h, command * h * h / 2.0];
            if off == 0.0 {
                return held; // as soon as it has caught up
            }
            let (lag, gone) = if off > 0.0 { (falling_s, *falling) } else { (rising_s, *rising) };
            let left = 1.0 - gone;
            level += off * left;
            [held[0] + off * lag * gone, held[1] + off * lag * (lag * gone - h * left)]
        });
        Self::new(t, parts)
    }

    /// ∫φ F dt.
    fn through(&self, hat: &Hat, t: &[f64]) -> f64 {
        let [a, b, c] = hat.nodes;
        let [[up, up_moment], [down, down_moment]] = [[a, b], [b, c]].map(|[from, to]| {
            [self.force_ns[to] - self.force_ns[from], self.moment_ns2[to] - self.moment_ns2[from]]
        });
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
        let (needed, measured) = (&found.needed_ns(&[PLANT])[0], found.measured_ns());
        assert!(measured.len() > 80, "{}", measured.len());
        for (needed, measured) in needed.iter().zip(measured) {
            assert!((needed - measured).abs() < 1e-11, "{needed} instead of {measured}");
        }
        let heavy = Parameters { mass_kg: 0.2, ..PLANT };
        assert!(
            found.needed_ns(&[heavy])[0].iter().zip(measured).any(|(n, m)| (n - m).abs() > 5e-4)
        );
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
            let [from, _, to] = hat.nodes.map(|i| found.clock.t_s[i]);
            assert!(from > 0.5 && (to < reversal_s || from > reversal_s), "{from} to {to}");
            assert!((hat.half_base_s - HALF_S).abs() < NODE_S);
        }
    }

    /// b(t) = c (1 − e^(−t/τ)) from rest: ∫b and ∫t b in closed form, with the command in two
    /// pieces.
    #[test]
    fn a_lag_is_followed_exactly() {
        let (lag, command, end) = (0.015_f64, 3.0, 0.05_f64);
        let clock = Clock::of(vec![0.0, 0.02, end]);
        let found = Impulse::of_lagging(&clock, &[command; 3], [lag, 0.5]);
        let e = (-end / lag).exp();
        let force = command * (end - lag * (1.0 - e));
        let moment = command * (end * end / 2.0 - lag * lag * (1.0 - e) + lag * end * e);
        assert!((found.force_ns[2] - force).abs() < 1e-15, "{} {force}", found.force_ns[2]);
        assert!((found.moment_ns2[2] - moment).abs() < 1e-15, "{} {moment}", found.moment_ns2[2]);
        let at_once = Impulse::of_lagging(&clock, &[command; 3], [0.0; 2]);
        assert!((at_once.force_ns[2] - command * end).abs() < 1e-15);
    }

    /// Intervals that jitter, against the exponential of each.
    #[test]
    fn what_of_a_step_is_gone_is_that_of_each_interval() {
        let wobble = |i: u32| f64::from(i) * 1e-3 + 1e-4 * libm::sin(f64::from(i * i));
        for t_s in [(0..200).map(wobble).collect(), vec![0.0, 1.0, 2.0], vec![0.0, 0.1, 5.0]] {
            let clock = Clock::of(t_s);
            for lag_s in [0.0, 1e-9, 1e-5, 3e-5, 1e-4, 7e-4, 1.2e-3, 0.01, 0.2, 3.0] {
                for (gone, t) in clock.gone(lag_s).into_iter().zip(clock.t_s.windows(2)) {
                    let expect = -libm::expm1((t[0] - t[1]) / lag_s);
                    assert!((gone / expect - 1.0).abs() < 1e-14, "{lag_s}: {gone}, {expect}");
                }
            }
        }
    }

    #[test]
    fn plants_together_need_what_each_needs_alone() {
        let mut samples = moved(1000.0, &PLANT);
        let n = samples.get(Signal::Time).unwrap().len();
        samples.set(Signal::VoltageMotor, (0..n).map(|i| (i % 40) as f64 * 0.1).collect());
        let found = balance(samples).unwrap();
        let heavy = Parameters { mass_kg: 0.2, ..PLANT };
        let late = Parameters { motor_lag_s: 0.004, ..heavy };
        let all = [PLANT, heavy, late, PLANT];
        let together = found.needed_ns(&all);
        assert_eq!(together, all.map(|plant| found.needed_ns(&[plant]).concat()));
        assert!(together[1] != together[2] && together[0] == together[3]);
    }

    #[test]
    fn a_falling_level_has_its_own_lag() {
        let clock = Clock::of(vec![0.0, 1.0, 2.0]);
        let [slow, quick] =
            [0.5, 0.01].map(|off| Impulse::of_lagging(&clock, &[4.0, 0.0, 0.0], [1e-3, off]));
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
