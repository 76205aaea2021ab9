//! The calibration that follows from sweeps, with the interval of its force.

use zwidth_characterise::models::Model;
use zwidth_characterise::{CharacteriseError, Chosen, Settings, calibrated, characterise};
use zwidth_store::Sweep;
use zwidth_study::{ActuatorKind, Characteristic, ForceInterval};

/// Bootstrap resamples and their seed: those of the stage `characterise`, so that both find the
/// same.
const RESAMPLES: usize = 400;
const SEED: u64 = 1;

/// Standard errors to either side in which a normal quantity lies with 95 %.
const NORMAL_95: f64 = 1.959_964;

/// What sweeps say of an actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedActuator {
    /// Force against voltage.
    pub characteristic: Characteristic,
    /// The interval of the force at each of its knots.
    pub interval: ForceInterval,
    /// Why this curve was chosen, in words.
    pub reason: String,
}

/// Share of a rectangular distribution's half width that 95 % of it lie within.
const RECTANGULAR_95: f64 = 0.95;

/// The characteristic of an actuator by its sweeps, and an interval for each knot, to either side
/// √(h² + (1.96 F s)² + (0.95 H/2)²):
///
/// * h: by the curves of resampled sweeps at the knot's voltage;
/// * s: the relative standard error of the load cell's scale;
/// * H: the hysteresis. The force lies between those of both ways, because friction and a late
///   actuator resist either; the calibration is their mean. How far it is off no sweep tells, so it
///   counts as anywhere between them (a rectangular distribution: JCGM 100:2008, 4.3.7).
///
/// # Errors
/// Sweeps that show no characteristic, or one that does not rise.
pub fn calibrated_actuator(
    actuator: ActuatorKind,
    sweeps: &[Sweep],
    level: f64,
) -> Result<CalibratedActuator, CharacteriseError> {
    let name = actuator.as_str();
    let settings = Settings {
        resamples: RESAMPLES,
        seed: SEED,
        level,
        command_unit: "V".to_owned(),
        response_unit: "N".to_owned(),
    };
    let samples: Vec<_> = sweeps
        .iter()
        .map(|sweep| zwidth_characterise::Sweep {
            command: &sweep.command_values,
            response: &sweep.response_values,
        })
        .collect();
    let found = characterise(&samples, &settings)?;
    let candidate = &found.candidates[found.chosen];
    let model = Model::of(candidate.name);
    let curve = |parameters: Vec<f64>| {
        let voltage_v = (found.command_min, found.command_max);
        calibrated(name, &Chosen { model, parameters, voltage_v })
    };
    let characteristic =
        curve(candidate.parameters.iter().map(|parameter| parameter.estimate).collect())?;
    // A resample whose curve does not rise says nothing about the others.
    let resampled: Vec<Characteristic> = candidate
        .resampled
        .iter()
        .filter_map(|parameters| curve(parameters.clone()).ok())
        .collect();
    let scale_error = scale_error(sweeps);
    let between_n = RECTANGULAR_95 * 0.5 * hysteresis_n(sweeps);
    let mut low_n = Vec::new();
    let mut high_n = Vec::new();
    for (voltage_v, force_n) in characteristic.voltage_v.iter().zip(&characteristic.force_n) {
        let forces: Vec<f64> = resampled.iter().map(|curve| curve.force_n(*voltage_v)).collect();
        let interval = candidate.interval(&forces, level)?;
        let (low, high) = interval.unwrap_or((*force_n, *force_n));
        let scale_n = NORMAL_95 * scale_error * force_n;
        let joined =
            |half_n: f64| (half_n * half_n + scale_n * scale_n + between_n * between_n).sqrt();
        low_n.push(force_n - joined((force_n - low).max(0.0)));
        high_n.push(force_n + joined((high - force_n).max(0.0)));
    }
    let interval =
        ForceInterval { sweeps: u32::try_from(sweeps.len()).unwrap_or(u32::MAX), low_n, high_n };
    Ok(CalibratedActuator { characteristic, interval, reason: found.reason })
}

/// The largest relative standard error of the scales that the sweeps were measured with.
fn scale_error(sweeps: &[Sweep]) -> f64 {
    let errors = sweeps.iter().filter_map(|sweep| {
        let scale = number(sweep, "cell_scale")?;
        Some((number(sweep, "cell_scale_error")? / scale).abs())
    });
    errors.filter(|error| error.is_finite()).fold(0.0, f64::max)
}

/// The largest hysteresis of the sweeps, N.
fn hysteresis_n(sweeps: &[Sweep]) -> f64 {
    let all = sweeps.iter().filter_map(|sweep| number(sweep, "hysteresis_n"));
    all.map(f64::abs).filter(|n| n.is_finite()).fold(0.0, f64::max)
}

/// What a sweep's file says of it.
fn number(sweep: &Sweep, key: &str) -> Option<f64> {
    sweep.file.get(key)?.parse().ok()
}
