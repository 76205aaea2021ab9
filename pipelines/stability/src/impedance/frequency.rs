//! Impedance against frequency: the Z = F / ẋ that a user feels at the lever's end, from
//! recordings.

use zwidth_numerics::order::upper_median;
use zwidth_numerics::series::interpolate_all;
use zwidth_numerics::updates::{Updates, updates};
use zwidth_numerics::welch::{CrossPoint, CrossSpectra};
use zwidth_stats::{StatsError, student_t};

/// About so long is a segment, s: as many samples as the power of two that is nearest.
const SEGMENT_S: f64 = 2.0;
/// From the second bin on: under a Hann window the first has what is left of the mean.
const FIRST: usize = 2;
/// Up to this share of half the force sensor's rate.
const TOP: f64 = 0.8;
/// Fewer independent segments say nothing of coherence.
const FEWEST: f64 = 4.0;

/// Angle and force of one recording; all as long as `t_s`.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// Time, s.
    pub t_s: &'a [f64],
    /// θ, rad.
    pub theta_rad: &'a [f64],
    /// F_ex, N; above 0 pushes to +θ.
    pub force_n: &'a [f64],
    /// How old each value of it is, s; `None` where that was not recorded.
    pub force_age_s: Option<&'a [f64]>,
}

/// Impedance against frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Rate of the even samples, Hz: that of the force sensor's new values.
    pub rate_hz: f64,
    /// Samples of a segment.
    pub length: usize,
    /// Segments.
    pub segments: usize,
    /// As many independent ones would have the same variance.
    pub averages: f64,
    /// Coherence from which on, at the level, it is none by chance: 1 − (1 − level)^(1/(n − 1)).
    pub chance: f64,
    /// By frequency.
    pub points: Vec<ResponsePoint>,
}

/// One frequency of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponsePoint {
    /// f, Hz.
    pub frequency_hz: f64,
    /// Re Z and Im Z, N s/m.
    pub impedance_ns_per_m: [f64; 2],
    /// Half of the interval of |Z|, as a share of it, and of the phase, rad; `None` for no
    /// coherence.
    pub half_interval: Option<f64>,
    /// γ².
    pub coherence: f64,
    /// S_vv, (m/s)²/Hz.
    pub velocity_density: f64,
    /// S_FF, N²/Hz.
    pub force_density: f64,
}

impl ResponsePoint {
    /// |Z|, N s/m.
    pub fn magnitude(&self) -> f64 {
        libm::hypot(self.impedance_ns_per_m[0], self.impedance_ns_per_m[1])
    }

    /// Its phase, rad: +90° of a mass, 0 of a damper, −90° of a spring.
    pub fn phase_rad(&self) -> f64 {
        libm::atan2(self.impedance_ns_per_m[1], self.impedance_ns_per_m[0])
    }

    /// The interval of |Z|, N s/m; not below 0.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let z = self.magnitude();
        let half = self.half_interval?;
        Some([(z * (1.0 - half)).max(0.0), z * (1.0 + half)])
    }
}

/// Impedance of the recordings of one condition; `None` if they are too short for four independent
/// segments.
///
/// Even samples at the rate at which the force sensor gives new values; Hann windows of about 2 s
/// that overlap by half; ẋ = jω L θ. The estimator is H1, Z = S_vF / S_vv, which noise of the force
/// does not bias; noise of the angle makes |Z| too small. With n independent segments the interval
/// is
/// |Z| (1 ± t √((1 − γ²)/(2 (n − 1) γ²))), t of 2 (n − 1) degrees of freedom: Bendat & Piersol's random
/// error √((1 − γ²)/(2 n γ²)) with the correction for an estimated γ².
///
/// # Errors
/// A level that is not between 0 and 1.
pub fn response(
    recordings: &[Recording<'_>],
    lever_m: f64,
    level: f64,
) -> Result<Option<Response>, StatsError> {
    // The force where it was new.
    let forces: Vec<Updates> = recordings
        .iter()
        .map(|recording| match recording.force_age_s {
            Some(age) => updates(recording.t_s, recording.force_n, age),
            None => Updates { t: recording.t_s.to_vec(), values: recording.force_n.to_vec() },
        })
        .collect();
    let Some(rate_hz) = rate_hz(&forces) else { return Ok(None) };
    let Some(mut spectra) = CrossSpectra::new(rate_hz, length(rate_hz)) else { return Ok(None) };
    for (recording, force) in recordings.iter().zip(&forces) {
        let [theta, force] = even(recording, force, rate_hz);
        spectra.add(&theta, &force);
    }
    let averages = spectra.averages();
    if averages < FEWEST {
        return Ok(None);
    }
    let t = student_t::critical_value(level, 2.0 * (averages - 1.0))?;
    let top_hz = TOP * 0.5 * rate_hz;
    let points = spectra.points();
    let shown = points.iter().skip(FIRST).take_while(|point| point.frequency_hz <= top_hz);
    Ok(Some(Response {
        rate_hz,
        length: spectra.length(),
        segments: spectra.segments(),
        averages,
        chance: 1.0 - libm::pow(1.0 - level, 1.0 / (averages - 1.0)),
        points: shown.map(|at| point(at, lever_m, averages, t)).collect(),
    }))
}

/// F = Z ẋ with ẋ = jω L θ: Z = S_θF / (jω L S_θθ).
fn point(at: &CrossPoint, lever_m: f64, averages: f64, t: f64) -> ResponsePoint {
    let omega_m = core::f64::consts::TAU * at.frequency_hz * lever_m;
    let scale = omega_m * at.xx;
    // Divided by j, real and imaginary part change places, and one its sign.
    let impedance_ns_per_m =
        [at.xy[1], -at.xy[0]].map(|part| if scale > 0.0 { part / scale } else { 0.0 });
    let coherence = at.coherence();
    let error = ((1.0 - coherence) / (2.0 * (averages - 1.0) * coherence)).sqrt();
    ResponsePoint {
        frequency_hz: at.frequency_hz,
        impedance_ns_per_m,
        half_interval: (coherence > 0.0).then_some(t * error),
        coherence,
        velocity_density: omega_m * omega_m * at.xx,
        force_density: at.yy,
    }
}

/// 1 / the median time between new values, Hz.
fn rate_hz(forces: &[Updates]) -> Option<f64> {
    let steps = forces.iter().flat_map(|force| force.t.windows(2).map(|pair| pair[1] - pair[0]));
    upper_median(steps.filter(|step| *step > 0.0)).map(|step| 1.0 / step)
}

fn length(rate_hz: f64) -> usize {
    /// So that no rate asks for more than memory has.
    const MOST: f64 = 20.0;
    let exponent = libm::round(libm::log2(SEGMENT_S * rate_hz)).clamp(3.0, MOST);
    1 << exponent as u32
}

/// θ and force at even times from the first new value on that the angle was known at.
fn even(recording: &Recording<'_>, force: &Updates, rate_hz: f64) -> [Vec<f64>; 2] {
    let t_s = recording.t_s;
    let theta_rad = recording.theta_rad;
    let (Some(began), Some(ended)) = (t_s.first(), t_s.last()) else { return Default::default() };
    let first = force.t.iter().find(|t| *t >= began);
    let last = force.t.last().map(|last| last.min(*ended));
    let (Some(first), Some(last)) = (first, last) else { return Default::default() };
    // A last sample that falls on the end but for rounding counts, and is not put beyond it below.
    let samples = ((last - first) * rate_hz * (1.0 + 1e-9)).max(0.0) as usize + 1;
    let times: Vec<f64> = (0..samples).map(|i| (first + i as f64 / rate_hz).min(last)).collect();
    [(t_s, theta_rad), (&force.t[..], &force.values[..])].map(|(t, y)| {
        interpolate_all(t, y, &times).into_iter().map(Option::unwrap_or_default).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use zwidth_dynamics::{
        DriveMode, Environment, Exact, Friction, Grid, Input, Series, Solver, Start, System, table3,
    };

    const LEVER_M: f64 = 0.045;

    /// SplitMix64 (Steele, Lea & Flood 2014), from 0 to below 1.
    fn shares(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Box & Muller.
    fn normal(share: &mut impl FnMut() -> f64) -> f64 {
        let (a, b) = (1.0 - share(), share());
        (-2.0 * libm::log(a)).sqrt() * libm::cos(TAU * b)
    }

    /// Lines up to 40 Hz in random phase, N.
    fn multisine(t: f64, phases: &[f64]) -> f64 {
        let lines = phases.iter().zip(1_u32..);
        lines.map(|(phase, k)| 0.1 * libm::sin(TAU * (0.37 * f64::from(k) * t + phase))).sum()
    }

    /// m s + b + k/s of a lever of 0.0972 kg and 2.6 N s/m with a spring of 100 N/m, without
    /// friction: the force is known at 1 kHz and runs in straight lines, which takes (π f/f_s)²/3
    /// from it.
    #[test]
    fn the_impedance_of_a_linear_device_is_its_closed_form() {
        let (mass_kg, b, k) = (0.0972, 2.6, 100.0);
        let mut share = shares(3);
        let phases: Vec<f64> = (0..108).map(|_| share()).collect();
        let t_s: Vec<f64> = (0..30_000).map(|i| f64::from(i) * 1e-3).collect();
        let force: Vec<f64> = t_s.iter().map(|t| multisine(*t, &phases)).collect();
        let series = Series { t_s: t_s.clone(), value: force.clone() };
        let mut scene = table3::scene(DriveMode::Active, Input::Series(series));
        scene.environment = Environment::spring(k * LEVER_M, 0.0, 0.0);
        (scene.plant.mass_kg, scene.plant.lever_m) = (mass_kg, LEVER_M);
        (scene.plant.stops_rad, scene.motor.max_n) = (None, 1e9);
        let viscous_ns_per_rad = b * LEVER_M;
        scene.friction = Some(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad });
        scene.start = Start { theta_rad: 0.0, theta_dot_rad_s: 0.0 };
        scene.duration_s = 29.999;
        let system = System::new(scene).unwrap();
        let run = Exact::default().run(&system, &Grid::Times(t_s.clone())).unwrap();
        let theta: Vec<f64> = run.theta_rad().collect();
        let recording =
            Recording { t_s: &t_s, theta_rad: &theta, force_n: &force, force_age_s: None };
        let found = response(&[recording], LEVER_M, 0.95).unwrap().unwrap();
        assert_eq!((found.length, found.segments), (2048, 28));
        for point in found.points.iter().filter(|p| (1.5..38.0).contains(&p.frequency_hz)) {
            let omega = TAU * point.frequency_hz;
            let expect = [b, omega * mass_kg - k / omega];
            let off = libm::hypot(
                point.impedance_ns_per_m[0] - expect[0],
                point.impedance_ns_per_m[1] - expect[1],
            );
            let size = libm::hypot(expect[0], expect[1]);
            // Over a bin the impedance is not one number: the estimate is a mean of what lies
            // within a quarter of it, and its change takes from the coherence.
            let bin = TAU * found.rate_hz / found.length as f64;
            let change = (mass_kg + k / (omega * omega)) * bin / size;
            let within = 0.01 + 0.25 * change;
            assert!(off < within * size, "{}: {point:?} is not {expect:?}", point.frequency_hz);
            assert!(point.coherence > 0.995 - change * change, "{point:?}");
        }
    }

    /// A spring with noise in its force: how often intervals of |Z| hold k/ω.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let (k, rate_hz, n) = (50.0, 80.0, 2000_u32);
        let t_s: Vec<f64> = (0..n).map(|i| f64::from(i) / rate_hz).collect();
        for (noise_n, coherent) in [(1.0, 0.7), (0.3, 0.95)] {
            let (mut held, mut all, mut coherence) = (0.0, 0.0, 0.0);
            for seed in 0..60 {
                let mut share = shares(seed * 977 + 11);
                let theta: Vec<f64> = t_s.iter().map(|_| 0.68 * normal(&mut share)).collect();
                let force: Vec<f64> =
                    theta.iter().map(|x| k * LEVER_M * x + noise_n * normal(&mut share)).collect();
                let recording =
                    Recording { t_s: &t_s, theta_rad: &theta, force_n: &force, force_age_s: None };
                let found = response(&[recording], LEVER_M, 0.95).unwrap().unwrap();
                for point in &found.points {
                    let truth = k / (TAU * point.frequency_hz);
                    let [low, high] = point.interval().unwrap();
                    held += f64::from(u8::from(low <= truth && truth <= high));
                    all += 1.0;
                    coherence += point.coherence;
                    assert!(point.coherence > found.chance, "{point:?} {}", found.chance);
                }
            }
            let (share, coherence) = (held / all, coherence / all);
            assert!((0.93..0.97).contains(&share), "{noise_n}: {share} of {all}");
            assert!((coherence - coherent).abs() < 0.03, "{coherence}");
        }
    }

    /// Chance exceeds the limit once in twenty.
    #[test]
    fn a_force_of_its_own_is_above_chance_once_in_twenty() {
        let t_s: Vec<f64> = (0..2000).map(|i| f64::from(i) / 80.0).collect();
        let (mut above, mut all) = (0.0, 0.0);
        for seed in 0..60 {
            let mut share = shares(seed + 5);
            let mut noise = || t_s.iter().map(|_| normal(&mut share)).collect::<Vec<f64>>();
            let (theta, force) = (noise(), noise());
            let recording =
                Recording { t_s: &t_s, theta_rad: &theta, force_n: &force, force_age_s: None };
            let found = response(&[recording], LEVER_M, 0.95).unwrap().unwrap();
            let is = |point: &&ResponsePoint| point.coherence > found.chance;
            above += found.points.iter().filter(is).count() as f64;
            all += found.points.len() as f64;
        }
        assert!((0.035..0.065).contains(&(above / all)), "{above} of {all}");
    }

    #[test]
    fn too_little_is_none_and_a_force_that_is_held_counts_where_it_was_new() {
        let t_s: Vec<f64> = (0..4000).map(|i| f64::from(i) * 1e-3).collect();
        let theta: Vec<f64> = t_s.iter().map(|t| libm::sin(30.0 * t * t)).collect();
        let last = |t: f64| (t * 80.0 + 1e-9).floor() / 80.0;
        let force: Vec<f64> = t_s.iter().map(|t| libm::sin(30.0 * last(*t) * last(*t))).collect();
        let age: Vec<f64> = t_s.iter().map(|t| t - last(*t)).collect();
        let recording =
            Recording { t_s: &t_s, theta_rad: &theta, force_n: &force, force_age_s: Some(&age) };
        assert_eq!(response(&[recording], 1.0, 0.95).unwrap(), None, "two segments");
        let found = response(&[recording; 3], 1.0, 0.95).unwrap().unwrap();
        assert!((found.rate_hz - 80.0).abs() < 1e-6, "{}", found.rate_hz);
        // F = θ: a spring of 1 N/m, in phase whatever the sensor's hold.
        for point in found.points.iter().filter(|p| p.coherence > 0.99) {
            let [re, im] = point.impedance_ns_per_m.map(|z| z * TAU * point.frequency_hz);
            assert!((im + 1.0).abs() < 0.03 && re.abs() < 0.03, "{point:?}");
        }
        assert_eq!(response(&[], 1.0, 0.95).unwrap(), None);
    }
}
