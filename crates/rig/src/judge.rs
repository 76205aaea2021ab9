//! A sweep, judged as soon as it has ended.

use crate::LoadCell;
use zwidth_device::{Ramp, Weighed};
use zwidth_numerics::moments::Moments;
use zwidth_numerics::order::median;
use zwidth_study::ActuatorKind;

/// A clamped lever that is elsewhere after a sweep has slipped, rad: 0.3°, six counts of an Arduino's
/// analog input.
const SLIP_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;

/// A lever that is pushed goes at least this fast, rad/s.
const SLIPPING_RAD_S: f64 = 0.05;

/// The gain of each way is taken between these shares of the highest voltage: below lie dead zones,
/// and what friction holds back after a turn.
const GAIN_RANGE: [f64; 2] = [0.25, 0.95];

/// A motor's two ways may differ by this share of their gain: more is a cell that drifts, or a motor
/// that heats up.
const WAYS_SHARE: f64 = 0.03;

/// Force at the end of a sweep may differ from that of earlier ones by this share of the largest.
const REST_SHARE: f64 = 0.02;

/// So many values in a sweep that are exactly its largest are a cell at its end.
const AT_END: usize = 6;

/// An actuator whose gain near its highest voltage is less than this share of the whole gives no
/// more there.
const FULL_SHARE: f64 = 0.25;

/// …within the highest part of the voltages, as a share.
const FULL_RANGE: f64 = 0.9;

/// Less force than this at the highest voltage is none, N.
const NO_FORCE_N: f64 = 0.05;

/// A brake must slip in at least this share of the values of each quarter of its sweep.
const PUSHED_SHARE: f64 = 0.5;

/// Values at rest at either end of a sweep.
const REST_VALUES: usize = 5;

/// A line needs so many values of a way.
const LEAST_VALUES: usize = 8;

/// What a sweep says.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The values that count: all of a motor's, those of a brake that slips. Forces are those that
    /// are there, by the load cell's zero and scale.
    pub values: Vec<Weighed>,
    /// Force per voltage, mean of both ways, N/V.
    pub gain_n_per_v: f64,
    /// Difference of both ways at half the highest voltage, N.
    pub hysteresis_n: f64,
    /// Force at 0 V when it ended, N.
    pub rest_n: f64,
    /// Largest force, N.
    pub largest_n: f64,
    /// The actuator gives no more near the highest voltage.
    pub is_full: bool,
}

/// Why a sweep does not count.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepFault {
    /// The clamp slipped.
    #[error(
        "the clamp slipped: the lever stands {:.2} degrees from where it was. Clamp it anew, and tighter",
        by_rad.abs().to_degrees()
    )]
    Slip {
        /// By how much, rad.
        by_rad: f64,
    },
    /// The cell drifts, or the motor heats up.
    #[error(
        "the load cell drifts, or the {} gets warm: {what}. Let both rest, and zero the cell anew",
        actuator.as_str()
    )]
    Drift {
        /// Which actuator.
        actuator: ActuatorKind,
        /// How that shows.
        what: String,
    },
    /// The cell can show no more.
    #[error(
        "the load cell is at the end of its range at {largest_n:.2} N: give a lower voltage with --to, or mount a larger cell"
    )]
    CellEnds {
        /// Where, N.
        largest_n: f64,
    },
    /// No force came.
    #[error(
        "at {top_v} V there is no force: check the supply and the cables of the {}, and that the lever is held against the load cell",
        actuator.as_str()
    )]
    NoForce {
        /// Which actuator.
        actuator: ActuatorKind,
        /// At which voltage, V.
        top_v: f64,
    },
    /// Force falls while the voltage rises.
    #[error(
        "force falls while the voltage rises ({gain_n_per_v:.3} N/V): the motor's leads are swapped, or the load cell is on the other \
         side of the lever"
    )]
    Reversed {
        /// Force per voltage, N/V.
        gain_n_per_v: f64,
    },
    /// The lever was not pushed.
    #[error(
        "the lever was not pushed evenly: in a quarter of the sweep it moved in {} % of the time. A brake shows its force only while \
         it slips: push through the load cell from stop to stop in {lasts_s} s",
        (100.0 * share).round()
    )]
    NotPushed {
        /// Share of the time of that quarter.
        share: f64,
        /// How long a push takes, s.
        lasts_s: f64,
    },
    /// Too few values.
    #[error("only {count} values of the load cell came: check its amplifier's rate and its cable")]
    Few {
        /// How many.
        count: usize,
    },
}

impl SweepFault {
    /// Whether the cell must be zeroed anew.
    pub fn needs_zero(&self) -> bool {
        matches!(self, Self::Drift { .. })
    }

    /// Whether another sweep would end alike, so that a person must change something first.
    pub fn is_lasting(&self) -> bool {
        matches!(self, Self::CellEnds { .. } | Self::NoForce { .. } | Self::Reversed { .. })
    }
}

/// Judges the values of a sweep that ran to its end; `rest_n` is the force at 0 V with which the
/// earlier ones ended.
///
/// # Errors
/// The first reason for which it does not count.
pub fn judged(
    values: &[Weighed],
    ramp: &Ramp,
    cell: &LoadCell,
    rest_n: Option<f64>,
) -> Result<Judged, SweepFault> {
    let (shown_least_n, shown_most_n) =
        values.iter().fold((f64::MAX, f64::MIN), |(least, most), value| {
            (least.min(value.force_n), most.max(value.force_n))
        });
    let at = |end_n: f64| {
        values.iter().filter(|value| value.force_n.to_bits() == end_n.to_bits()).count()
    };
    if values.len() < 2 * LEAST_VALUES {
        return Err(SweepFault::Few { count: values.len() });
    }
    // A held value is there once, and noise lets no other be the largest again and again.
    if at(shown_most_n) >= AT_END || at(shown_least_n) >= AT_END {
        return Err(SweepFault::CellEnds { largest_n: cell.force_n(shown_most_n) });
    }
    let corrected: Vec<Weighed> = values
        .iter()
        .map(|value| Weighed { force_n: cell.force_n(value.force_n), ..*value })
        .collect();
    let counted = match ramp.actuator {
        ActuatorKind::Motor => {
            slipped(&corrected)?;
            corrected
        }
        ActuatorKind::Brake => pushed(&corrected, ramp)?,
    };
    let half_s = 0.5 * ramp.lasts_s;
    let (up, down): (Vec<Weighed>, Vec<Weighed>) =
        counted.iter().copied().partition(|value| value.t_s <= half_s);
    let [up_line, down_line] = [line(&up, ramp)?, line(&down, ramp)?];
    let gain_n_per_v = 0.5 * (up_line[1] + down_line[1]);
    let largest_n = counted.iter().map(|value| value.force_n).fold(f64::MIN, f64::max);
    // The force of its voltages, without what the clamp or a hand adds.
    let own_n = gain_n_per_v * ramp.top_v;
    if own_n.abs() < NO_FORCE_N.max(3.0 * cell.noise_n) {
        return Err(SweepFault::NoForce { actuator: ramp.actuator, top_v: ramp.top_v });
    }
    if gain_n_per_v < 0.0 {
        return Err(SweepFault::Reversed { gain_n_per_v });
    }
    let mid_v = 0.5 * ramp.top_v;
    let at_mid = |[intercept, slope]: [f64; 2]| intercept + slope * mid_v;
    let judged = Judged {
        gain_n_per_v,
        hysteresis_n: at_mid(down_line) - at_mid(up_line),
        rest_n: rest(&counted),
        largest_n,
        is_full: is_full(&counted, ramp, gain_n_per_v),
        values: counted,
    };
    if ramp.actuator == ActuatorKind::Motor {
        steady(&judged, [up_line[1], down_line[1]], rest_n)?;
    }
    Ok(judged)
}

/// Whether a clamped lever stands where it stood.
fn slipped(values: &[Weighed]) -> Result<(), SweepFault> {
    let ends = [&values[..REST_VALUES], &values[values.len() - REST_VALUES..]];
    let [Some(first), Some(last)] =
        ends.map(|end| median(end.iter().filter_map(|value| value.theta_rad)))
    else {
        return Ok(());
    };
    let by_rad = last - first;
    if by_rad.abs() > SLIP_RAD { Err(SweepFault::Slip { by_rad }) } else { Ok(()) }
}

/// The values at which the lever went forward: only then is a brake's force its level.
fn pushed(values: &[Weighed], ramp: &Ramp) -> Result<Vec<Weighed>, SweepFault> {
    let mut counted = Vec::new();
    let mut quarters = [[0_usize; 2]; 4];
    for pair in values.windows(2) {
        let [before, value] = [pair[0], pair[1]];
        let quarter = ((4.0 * value.t_s / ramp.lasts_s) as usize).min(3);
        quarters[quarter][1] += 1;
        let Some((from_rad, to_rad)) = before.theta_rad.zip(value.theta_rad) else { continue };
        if to_rad - from_rad > SLIPPING_RAD_S * (value.t_s - before.t_s) {
            counted.push(value);
            quarters[quarter][0] += 1;
        }
    }
    let shares = quarters.map(|[moved, all]| moved as f64 / all.max(1) as f64);
    let share = shares.into_iter().fold(1.0, f64::min);
    if share < PUSHED_SHARE {
        return Err(SweepFault::NotPushed { share, lasts_s: ramp.lasts_s });
    }
    Ok(counted)
}

/// Intercept and slope of the force over the voltage, by least squares.
fn line(values: &[Weighed], ramp: &Ramp) -> Result<[f64; 2], SweepFault> {
    let range = GAIN_RANGE[0] * ramp.top_v..=GAIN_RANGE[1] * ramp.top_v;
    let inside: Vec<&Weighed> =
        values.iter().filter(|value| range.contains(&value.voltage_v)).collect();
    if inside.len() < LEAST_VALUES {
        return Err(SweepFault::Few { count: inside.len() });
    }
    let voltages: Vec<f64> = inside.iter().map(|value| value.voltage_v).collect();
    let forces: Vec<f64> = inside.iter().map(|value| value.force_n).collect();
    let [mean_v, mean_n] = [&voltages, &forces].map(|values| Moments::of(values).mean);
    let (mut together, mut alone) = (0.0, 0.0);
    for (voltage_v, force_n) in voltages.iter().zip(&forces) {
        together += (voltage_v - mean_v) * (force_n - mean_n);
        alone += (voltage_v - mean_v) * (voltage_v - mean_v);
    }
    let slope = if alone > 0.0 { together / alone } else { 0.0 };
    Ok([mean_n - slope * mean_v, slope])
}

fn rest(values: &[Weighed]) -> f64 {
    let last = &values[values.len().saturating_sub(REST_VALUES)..];
    median(last.iter().map(|value| value.force_n)).unwrap_or(0.0)
}

/// Whether the actuator gives no more near its highest voltage: on the way up, where it was not
/// there yet.
fn is_full(values: &[Weighed], ramp: &Ramp, gain_n_per_v: f64) -> bool {
    let up: Vec<&Weighed> = values.iter().filter(|value| value.t_s <= 0.5 * ramp.lasts_s).collect();
    let near = |from: f64, to: f64| {
        let range = from * ramp.top_v..to * ramp.top_v;
        let inside = up.iter().filter(|value| range.contains(&value.voltage_v));
        let values: Vec<[f64; 2]> = inside.map(|value| [value.voltage_v, value.force_n]).collect();
        let mean = |of: usize| values.iter().map(|v| v[of]).sum::<f64>() / values.len() as f64;
        (!values.is_empty()).then(|| [mean(0), mean(1)])
    };
    let middle = 0.5 * (FULL_RANGE + 1.0);
    let Some(([below_v, below_n], [above_v, above_n])) =
        near(FULL_RANGE, middle).zip(near(middle, 1.01))
    else {
        return false;
    };
    (above_n - below_n) / (above_v - below_v) < FULL_SHARE * gain_n_per_v
}

/// Whether a motor's sweep shows the same force per voltage on both ways, and ends at the force at
/// which others ended.
fn steady(judged: &Judged, [up, down]: [f64; 2], rest_n: Option<f64>) -> Result<(), SweepFault> {
    let drift = |what: String| SweepFault::Drift { actuator: ActuatorKind::Motor, what };
    let gain = judged.gain_n_per_v;
    if (up - down).abs() > WAYS_SHARE * gain {
        return Err(drift(format!(
            "{up:.4} N/V while the voltage rose and {down:.4} N/V while it fell"
        )));
    }
    let Some(earlier_n) = rest_n else { return Ok(()) };
    if (judged.rest_n - earlier_n).abs() > REST_SHARE * judged.largest_n {
        let now_n = judged.rest_n;
        return Err(drift(format!(
            "at 0 V it showed {now_n:.3} N at the end, and {earlier_n:.3} N after the sweep before"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAMP: Ramp = Ramp { actuator: ActuatorKind::Motor, top_v: 16.0, lasts_s: 8.0 };
    const CELL: LoadCell = LoadCell { zero_n: 0.0, scale: 1.0, scale_error: 0.0, noise_n: 0.002 };

    /// A sweep at 80 values per second whose force and angle follow from time and voltage, with a
    /// little that differs from value to value.
    fn sweep(ramp: &Ramp, at: impl Fn(f64, f64) -> (f64, f64)) -> Vec<Weighed> {
        let value = |i: u32| {
            let t_s = f64::from(i) / 80.0;
            let voltage_v = ramp.voltage_v(t_s);
            let (force_n, theta_rad) = at(t_s, voltage_v);
            let noise_n = 1e-3 * (f64::from(i) * 1.7).sin();
            Weighed { t_s, voltage_v, force_n: force_n + noise_n, theta_rad: Some(theta_rad) }
        };
        (0..=640).map(value).collect()
    }

    fn motor(at: impl Fn(f64, f64) -> (f64, f64)) -> Result<Judged, SweepFault> {
        judged(&sweep(&RAMP, at), &RAMP, &CELL, None)
    }

    #[test]
    fn a_linear_motor_has_its_gain_and_its_hysteresis() {
        let found = motor(|t_s, v| (0.26 * v + if t_s > 4.0 { 0.1 } else { -0.1 }, 0.0)).unwrap();
        assert!((found.gain_n_per_v - 0.26).abs() < 1e-4, "{found:?}");
        assert!((found.hysteresis_n - 0.2).abs() < 1e-3 && !found.is_full);
    }

    #[test]
    fn each_fault_is_found() {
        let slip = motor(|t_s, v| (0.26 * v, if t_s > 3.0 { 0.01 } else { 0.0 }));
        assert!(matches!(slip, Err(SweepFault::Slip { .. })), "{slip:?}");
        let drift = motor(|t_s, v| (0.26 * v + 0.05 * t_s, 0.0));
        assert!(matches!(drift, Err(SweepFault::Drift { .. })), "{drift:?}");
        let reversed = motor(|_, v| (-0.26 * v, 0.0));
        assert!(matches!(reversed, Err(SweepFault::Reversed { .. })), "{reversed:?}");
        let none = motor(|_, _| (0.0, 0.0));
        assert!(matches!(none, Err(SweepFault::NoForce { .. })), "{none:?}");
        let ends: Vec<Weighed> = sweep(&RAMP, |_, v| (0.26 * v, 0.0))
            .into_iter()
            .map(|value| Weighed { force_n: value.force_n.min(3.0), ..value })
            .collect();
        let ends = judged(&ends, &RAMP, &CELL, None);
        assert!(matches!(ends, Err(SweepFault::CellEnds { .. })), "{ends:?}");
        let rest = judged(&sweep(&RAMP, |_, v| (0.26 * v, 0.0)), &RAMP, &CELL, Some(0.3));
        assert!(matches!(rest, Err(SweepFault::Drift { .. })), "{rest:?}");
        assert!(matches!(judged(&[], &RAMP, &CELL, None), Err(SweepFault::Few { .. })));
    }

    #[test]
    fn a_supply_that_gives_no_more_is_seen() {
        assert!(motor(|_, v| (0.26 * v.min(12.0), 0.0)).unwrap().is_full);
    }

    #[test]
    fn a_brake_counts_only_while_it_slips_and_must_be_pushed() {
        let ramp = Ramp { actuator: ActuatorKind::Brake, top_v: 8.0, lasts_s: 8.0 };
        // It rests in every third stretch of a tenth of a second.
        let at = |t_s: f64, v: f64| {
            let rests = ((10.0 * t_s) as u32).is_multiple_of(3);
            (if rests { 0.0 } else { 1.5 * v }, 0.0)
        };
        let mut values = sweep(&ramp, at);
        let mut theta_rad = 0.0;
        for value in &mut values {
            if !((10.0 * value.t_s) as u32).is_multiple_of(3) {
                theta_rad += 0.003;
            }
            value.theta_rad = Some(theta_rad);
        }
        let found = judged(&values, &ramp, &CELL, None).unwrap();
        assert!((found.gain_n_per_v - 1.5).abs() < 0.02, "{}", found.gain_n_per_v);
        assert!(found.values.len() > 300 && found.values.len() < 440);
        let held = sweep(&ramp, |_, v| (1.5 * v, 0.0));
        let held = judged(&held, &ramp, &CELL, None);
        assert!(matches!(held, Err(SweepFault::NotPushed { .. })), "{held:?}");
    }
}
