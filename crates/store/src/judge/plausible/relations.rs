//! Whether the signals of a trial fit each other: velocity and angle, force and motion, force and
//! the commanded spring.

use super::asked::Asked;
use super::doubt::{Doubt, LEAST_SAMPLES, range};
use crate::{Columns, Signal};
use core::f64::consts::TAU;
use zwidth_numerics::series::ends;

/// A trial is looked at in this many stretches, each long against noise and delay of a velocity.
const STRETCHES: usize = 200;
/// Samples of a stretch, at least.
const LEAST_STRETCH: usize = 5;
/// From this correlation on two signals tell of one movement, and their ratio means something.
const ALIKE: f64 = 0.9;
/// A ratio within this factor of 1 is a filter's or a calibration's.
const NEAR: f64 = 2.0;
/// A ratio within this share of a known one is that one.
const CLOSE: f64 = 0.2;
/// Least movement, rad (1°): below, noise is all there is.
const LEAST_MOVED_RAD: f64 = 0.017_453_292_519_943_295;
/// The user's work on the way out is of the wrong sign where it is below −this share of ∫ |F dθ|.
const AGAINST: f64 = 0.5;
/// A turn of the lever is larger than this share of its range …
const TURN: f64 = 0.05;
/// … and a swing whose turns are closer than this, s, is none of a hand (`fast_swings` of the
/// metrics).
const FAST_S: f64 = 0.1;

pub(super) fn doubts(expected: &Asked, samples: &dyn Columns) -> Vec<Doubt> {
    let turn = expected.scene.spring().and_then(|_| way_out(&samples.column(Signal::Theta)?));
    let sign = turn.and_then(|turn| sign_of_force(samples, turn));
    let size = turn.and_then(|turn| size_of_force(expected, samples, turn));
    [velocity(samples), sign, size].into_iter().flatten().collect()
}

/// Ratios of a velocity to the angle's derivative that a wrong unit makes.
const VELOCITIES: [(f64, &str); 8] = [
    (360.0 / TAU, "deg/s taken for rad/s, or an angle in rad taken for degrees"),
    (TAU / 360.0, "rad/s taken for deg/s, or an angle in degrees taken for rad"),
    (1e3, "a time in ms taken for s, or a velocity in mm/s for m/s"),
    (1e-3, "a time in s taken for ms, or a velocity in m/s for mm/s"),
    (60.0 / TAU, "rpm taken for rad/s"),
    (TAU / 60.0, "rad/s taken for rpm"),
    (TAU, "rad/s taken for turns per second"),
    (1.0 / TAU, "turns per second taken for rad/s"),
];

/// θ̇ against θ: how far the one says that the lever went, in each stretch, over how far the other
/// does.
fn velocity(samples: &dyn Columns) -> Option<Doubt> {
    if !(samples.has(Signal::Theta) && samples.has(Signal::ThetaDot)) {
        return None;
    }
    // Two columns at a time.
    let (length, ways): (usize, Vec<f64>) = {
        let t = samples.column(Signal::Time)?;
        let theta_dot = samples.column(Signal::ThetaDot)?;
        if t.len() < LEAST_SAMPLES {
            return None;
        }
        let length = (t.len() / STRETCHES).max(LEAST_STRETCH);
        let ways = stretches(t.len(), length)
            .map(|(from, to)| integral(&t[from..=to], &theta_dot[from..=to]));
        (length, ways.collect())
    };
    let theta = samples.column(Signal::Theta)?;
    let moved = stretches(theta.len(), length).map(|(from, to)| theta[to] - theta[from]);
    let (ratio, correlation) = ratio(moved, ways.into_iter())?;
    if correlation < ALIKE || (1.0 / NEAR..NEAR).contains(&ratio) {
        return None;
    }
    let why = named(&VELOCITIES, ratio.abs()).map(|why| format!(": {why}?")).unwrap_or_default();
    let sign = if ratio < 0.0 { ", with the opposite sign" } else { "" };
    let what =
        format!("the velocity is {} times the angle's derivative{sign}{why}", digits(ratio.abs()));
    let remedy = "mend unit or sign of angle, velocity or time in the mapping, or derive the velocity from the angle";
    Some(Doubt::new(Signal::ThetaDot, what, remedy))
}

/// First and last sample of each whole stretch of `length` samples.
fn stretches(samples: usize, length: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..samples.saturating_sub(1) / length).map(move |i| (i * length, (i + 1) * length))
}

/// ∫ y dt by the trapezoidal rule.
fn integral(t: &[f64], y: &[f64]) -> f64 {
    t.windows(2).zip(y.windows(2)).map(|(t, y)| (t[1] - t[0]) * (y[0] + y[1]) / 2.0).sum()
}

/// b over a by least squares through 0, and how alike they are (|correlation|); `None` where one of
/// them is 0 throughout.
fn ratio(a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (aa, bb, ab) =
        a.zip(b).fold((0.0, 0.0, 0.0), |(aa, bb, ab), (a, b)| (aa + a * a, bb + b * b, ab + a * b));
    (aa > 0.0 && bb > 0.0).then(|| (ab / aa, ab.abs() / (aa.sqrt() * bb.sqrt())))
}

/// The cause of a ratio, if it is close to one of these.
fn named(ratios: &[(f64, &'static str)], ratio: f64) -> Option<&'static str> {
    ratios.iter().find(|(other, _)| (ratio / other - 1.0).abs() < CLOSE).map(|(_, why)| *why)
}

/// Three digits, whatever the size.
fn digits(ratio: f64) -> String {
    let exact = format!("{ratio:.2e}").parse().unwrap_or(ratio);
    format!("{exact}")
}

/// Where the way out ends: at the sample farthest from the first; `None` without much of a
/// movement.
fn way_out(theta: &[f64]) -> Option<usize> {
    let first = *theta.first()?;
    let (low, high) = ends(theta);
    let farthest = (high - first).max(first - low);
    let turn = theta.iter().position(|theta| (theta - first).abs() >= farthest)?;
    let moved = range(&theta[..=turn]) > LEAST_MOVED_RAD && turn >= LEAST_STRETCH;
    (moved && theta.len() >= LEAST_SAMPLES).then_some(turn)
}

/// The number of turns of the angle by more than a share of its range.
fn turns(theta: &[f64]) -> usize {
    let least = TURN * range(theta);
    let Some(first) = theta.first() else { return 0 };
    let (turns, _, _) = theta.iter().fold((0, *first, 0.0), |(turns, end, way), value| {
        let step = value - end;
        if step * way >= 0.0 && way != 0.0 {
            (turns, *value, way)
        } else if step.abs() > least {
            (turns + usize::from(way != 0.0), *value, step.signum())
        } else {
            (turns, end, way)
        }
    });
    turns
}

/// Whether the way out swings back and forth faster than a hand does.
fn swings_fast(samples: &dyn Columns, turn: usize) -> bool {
    let turns = samples.column(Signal::Theta).map_or(0, |theta| turns(&theta[..=turn]));
    if turns < 2 {
        return false;
    }
    let t = samples.column(Signal::Time);
    let time_s = t.and_then(|t| Some(t.get(turn)? - t.first()?));
    time_s.is_some_and(|time_s| time_s < FAST_S * turns as f64)
}

/// A hand that moves a spring away from rest works on it: ∫ F dθ > 0 on the way out. Of a lever that
/// swings by itself the device does the work.
fn sign_of_force(samples: &dyn Columns, turn: usize) -> Option<Doubt> {
    let mut signals = [Signal::ForceEx, Signal::TorqueEx].into_iter();
    let signal = signals.find(|signal| samples.has(*signal))?;
    if swings_fast(samples, turn) {
        return None;
    }
    let theta = samples.column(Signal::Theta)?;
    let force = samples.column(signal)?;
    let theta = &theta[..=turn];
    let force = &force[..=turn];
    let steps =
        theta.windows(2).zip(force.windows(2)).map(|(x, f)| (x[1] - x[0]) * (f[0] + f[1]) / 2.0);
    let (work, all) = steps.fold((0.0, 0.0), |(work, all), step| (work + step, all + step.abs()));
    let is_against = work < -AGAINST * all;
    if !is_against {
        return None;
    }
    let what = format!(
        "the force points against the motion on the way out ({:.0} % of its work is negative): a user's force is positive \
         where it pushes into the object",
        50.0 * (1.0 - work / all)
    );
    let remedy = "set sign = -1 for the force, or for angle and velocity, in the mapping";
    Some(Doubt::new(signal, what, remedy))
}

/// The stiffness that the way out shows, over the one asked for: a unit that is wrong is off by a
/// known factor.
fn size_of_force(expected: &Asked, samples: &dyn Columns, turn: usize) -> Option<Doubt> {
    let spring = expected.scene.spring()?;
    let theta = samples.column(Signal::Theta)?;
    let force = samples.column(Signal::ForceEx)?;
    // The slope alone: where the angle's 0 lies may be wrong too.
    let commanded = from_mean(&theta[..=turn]).map(|x| x * spring.stiffness_n_per_rad);
    let (ratio, correlation) = ratio(commanded, from_mean(&force[..=turn]))?;
    if correlation < ALIKE || ratio <= 0.0 {
        return None;
    }
    let why = expected.lever_m.and_then(|lever_m| named(&torques(lever_m), ratio));
    let why = why.or_else(|| named(&FORCES, ratio))?;
    let what =
        format!("the force grows by {} times what the spring asks for: {why}?", digits(ratio));
    let remedy = "mend unit and scale of force and angle in the mapping, or stiffness and device.lever_m in study.toml";
    Some(Doubt::new(Signal::ForceEx, what, remedy))
}

/// Values less their mean.
fn from_mean(values: &[f64]) -> impl Iterator<Item = f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(move |value| value - mean)
}

/// What a torque makes of a force; nothing for a lever about 1 m long, which hardly changes the
/// number.
fn torques(lever_m: f64) -> Vec<(f64, &'static str)> {
    let ratios = [
        (lever_m, "a torque in N·m taken for a force in N"),
        (1.0 / lever_m, "a force in N taken for a torque in N·m"),
    ];
    ratios.into_iter().filter(|(ratio, _)| !(0.2..5.0).contains(ratio)).collect()
}

/// Ratios of a force to the one asked for that a wrong unit makes.
const FORCES: [(f64, &str); 4] = [
    (1e3, "mN taken for N, or an angle or length a thousand times too small"),
    (1e-3, "kN taken for N, or an angle or length a thousand times too large"),
    (360.0 / TAU, "an angle in rad taken for degrees"),
    (TAU / 360.0, "an angle in degrees taken for rad"),
];
