//! What a stretch of readings says about a device.

use super::finding::Finding;
use crate::angle::{rad_per_count, shortest, unwrap_margin};
use crate::{Angle, Capabilities, Limits, Reading, Timing, Unwrap};
use std::collections::BTreeSet;
use zwidth_numerics::moments::Moments;

/// A reading and when it was requested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Host time, s.
    pub t_s: f64,
    /// What was read.
    pub reading: Reading,
}

/// Ages closer than this are of one and the same value, s.
const SAME_S: f64 = 1e-6;

/// A sensor gives at least this share of the values it claims.
const LEAST_RATE: f64 = 0.98;

/// The load cell's noise may be so large, N rms: ten times what the HX711 is expected to show.
const FORCE_NOISE_N: f64 = 0.02;

/// A lever at rest may flicker by so much from one side to the other, rad: some four counts of the
/// prototype's sensor.
const ANGLE_NOISE_RAD: f64 = 1e-3;

/// The force at rest may be off by so much, N: a trial's end is found by a force below it.
const TARE_N: f64 = 0.2;
/// What the force at rest is called.
const TARE: &str = "tare";

/// A known weight may be shown wrong by this share.
const SCALE_ERROR: f64 = 0.03;

/// Standard gravity, m/s² (CGPM 1901).
const GRAVITY_M_S2: f64 = 9.806_65;

/// No more than this share of the values may be the lowest or the highest one.
const SATURATED: f64 = 0.05;

/// Only forces beyond this are looked at for saturation, N: at rest they may well repeat.
const PUSHED_N: f64 = 1.0;

/// At least this share of half a turn must be left between two readings.
const LEAST_MARGIN: f64 = 0.5;

/// The lever must have gone over at least this share of its work space, else it was not moved.
const LEAST_STROKE: f64 = 0.3;

/// A lever cannot go further than its work space; stops give a little, rad (2°).
const STROKE_RAD: f64 = 0.035;

/// How the loop kept its time at such a rate.
pub fn timing(timing: &Timing, rate_hz: f64) -> Vec<Finding> {
    let half_s = 0.5 * (1.0 / rate_hz);
    let missed = timing.missed as f64 / (timing.missed + timing.ticks).max(1) as f64;
    let late_s = timing.lateness.percentile_s(99.0);
    let took_s = timing.work.percentile_s(99.0);
    let late = "99 % of the ticks are late by less; above half a period close other programs or lower the rate";
    let took = "99 % of reads and writes together take less; above half a period check the link, or lower the rate";
    let share =
        "share of deadlines missed; above 1 % close other programs, or ask for a lower rate";
    vec![
        Finding::new("jitter, 99 %", late_s, "s", late_s < half_s, late),
        Finding::new("latency, 99 %", took_s, "s", took_s < half_s, took),
        Finding::new("missed deadlines", missed, "1", missed < 0.01, share),
    ]
}

/// A lever at rest, read at this rate: the sensors' rates, noise and zero.
pub fn at_rest(capabilities: &Capabilities, rate_hz: f64, looks: &[Look]) -> Vec<Finding> {
    let span_s = span_s(looks);
    let nominal_hz = capabilities.rate_hz.min(rate_hz);
    let angle_hz = find_taken(looks, |r| Some(r.angle_age_s)).len() as f64 / span_s;
    let mut findings = vec![
        Finding::new(
            "angle rate",
            angle_hz,
            "Hz",
            angle_hz >= LEAST_RATE * nominal_hz,
            "new angles per second; if too few, check the link and the board's sampling interval",
        ),
        noise(capabilities, looks),
    ];
    let forces = new_forces_n(looks);
    // A force of unknown age would count as new at each look, whatever its sensor does.
    if looks.iter().all(|look| look.reading.force_age_s.is_some()) {
        let force_hz = forces.len() as f64 / span_s;
        let nominal_hz = capabilities.force_rate_hz.min(rate_hz);
        let is_fast = force_hz >= LEAST_RATE * nominal_hz;
        let about = "new forces per second; if too few, check the amplifier's rate switch";
        findings.push(Finding::new("force rate", force_hz, "Hz", is_fast, about));
    }
    let mean_n = mean_n(&forces);
    let sd_n = Moments::of(&forces).sd().unwrap_or(0.0);
    let noise =
        "standard deviation of the force at rest; if too large, check cable, shield and supply";
    let tare = "force at rest; if it is not near zero, tare the load cell with nothing on it";
    findings.push(Finding::new("force noise", sd_n, "N", sd_n <= FORCE_NOISE_N, noise));
    findings.push(Finding::new(TARE, mean_n, "N", mean_n.abs() <= TARE_N, tare));
    findings
}

/// The measured force at rest, N; 0 if it was not measured.
pub fn tare_n(findings: &[Finding]) -> f64 {
    findings.iter().find(|finding| finding.check.name == TARE).map_or(0.0, |tare| tare.check.value)
}

/// A known mass on the load cell: is a newton a newton? `tare_n` is the force without it. The mass
/// is given beside the scale, so that a reader knows what the scale is based on.
pub fn loaded(looks: &[Look], tare_n: f64, mass_kg: f64) -> Vec<Finding> {
    let scale = (mean_n(&new_forces_n(looks)) - tare_n) / (mass_kg * GRAVITY_M_S2);
    let about = "force shown per force there, with the known mass; if it is not near 1, calibrate the load cell \
                 (below 0: it is mounted the wrong way round)";
    let mass = "the mass that hung there";
    vec![
        Finding::new("known mass", mass_kg, "kg", true, mass),
        Finding::new("load cell scale", scale, "1", (scale - 1.0).abs() <= SCALE_ERROR, about),
    ]
}

/// A lever moved all the way by hand from its lower stop: is every code there, is any stuck, and is
/// the motion slow enough to count turns?
pub fn by_hand(capabilities: &Capabilities, limits: &Limits, looks: &[Look]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let forces = new_forces_n(looks);
    let pushed: Vec<f64> = forces.into_iter().filter(|n| n.abs() > PUSHED_N).collect();
    let about = "share of the forces above 1 N that equal the lowest or the highest; if many do, the amplifier is at the end of its range";
    let share = at_ends(&pushed);
    findings.push(Finding::new("force saturation", share, "1", share <= SATURATED, about));
    if let Some(counts_per_turn) = capabilities.counts_per_turn {
        findings.extend(codes(counts_per_turn, looks));
        findings.extend(turns(counts_per_turn, capabilities.shaft_per_lever, limits, looks));
    }
    findings
}

/// The codes of a counting sensor.
fn codes(counts_per_turn: u32, looks: &[Look]) -> Vec<Finding> {
    let raw: Vec<u16> = looks.iter().filter_map(|look| look.reading.raw()).collect();
    let distinct: BTreeSet<u16> = raw.iter().copied().collect();
    let used = u16::try_from(counts_per_turn.saturating_sub(1)).unwrap_or(u16::MAX);
    // All bits that the largest code needs; each must have been seen both as 1 and as 0.
    let bits = (1_u32 << (u16::BITS - used.leading_zeros())) - 1;
    let (ones, zeros) =
        raw.iter().fold((0_u16, 0_u16), |(ones, zeros), raw| (ones | raw, zeros | !raw));
    let lively = u32::from(ones & zeros) & bits == bits;
    let share = at_ends(&moving(&raw));
    let unique = "different codes of the angle sensor; not good if any of its bits never changed: check cable and magnet";
    let ends = "share of the codes that are the lowest or the highest; if many are, the sensor's output is cut off";
    vec![
        Finding::new("unique codes", distinct.len() as f64, "1", lively, unique),
        Finding::new("angle saturation", share, "1", share <= SATURATED, ends),
    ]
}

/// The codes from the first change to the last: a lever that rests at its stop repeats one, which
/// may be the lowest.
fn moving(raw: &[u16]) -> Vec<f64> {
    let first = raw.windows(2).position(|w| w[0] != w[1]).unwrap_or(0);
    let last = raw.windows(2).rposition(|w| w[0] != w[1]).unwrap_or(0);
    raw[first..last].iter().map(|raw| f64::from(*raw)).collect()
}

/// Turns counted over the whole stroke.
fn turns(
    counts_per_turn: u32,
    shaft_per_lever: f64,
    limits: &Limits,
    looks: &[Look],
) -> Vec<Finding> {
    let Some(followed) = follow(counts_per_turn, looks) else { return Vec::new() };
    let largest = followed.windows(2).map(|w| (w[1] - w[0]).abs()).max().unwrap_or(0);
    let (low, high) =
        followed.iter().fold((i64::MAX, i64::MIN), |(low, high), c| (low.min(*c), high.max(*c)));
    let stroke_rad = (high - low) as f64 * rad_per_count(counts_per_turn, shaft_per_lever);
    let whole_rad = limits.theta_max_rad - limits.theta_min_rad;
    let stroke_ok = stroke_rad >= LEAST_STROKE * whole_rad && stroke_rad <= whole_rad + STROKE_RAD;
    let margin = unwrap_margin(largest, counts_per_turn);
    let left =
        "share of half a turn never used between two readings; below a half, ask for a higher rate";
    let stroke = "how far the lever went; too little: move it further; more than its work space: check the ratio and the magnet";
    vec![
        Finding::new("unwrap margin", margin, "1", margin >= LEAST_MARGIN, left),
        Finding::new("stroke", stroke_rad, "rad", stroke_ok, stroke),
    ]
}

/// Counts without wraps, for as long as they are to be believed (the guard has seen to it that they
/// are).
fn follow(counts_per_turn: u32, looks: &[Look]) -> Option<Vec<i64>> {
    let first = looks.first()?;
    let start_s = first.t_s - first.reading.angle_age_s;
    let mut unwrap = Unwrap::start(counts_per_turn, start_s, first.reading.raw()?).ok()?;
    let mut counts = Vec::new();
    for Look { t_s, reading } in looks {
        let Some(raw) = reading.raw() else { continue };
        let Ok(count) = unwrap.follow(t_s - reading.angle_age_s, raw) else { break };
        counts.push(count);
    }
    Some(counts)
}

/// How far the angle flickers at rest.
fn noise(capabilities: &Capabilities, looks: &[Look]) -> Finding {
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for look in looks {
        let angle_rad = match look.reading.angle {
            Angle::Lever(theta_rad) => theta_rad,
            Angle::Counts(raw) => {
                // From the first code, the short way round: a lever may rest where the code wraps.
                let first = looks[0].reading.raw().unwrap_or(raw);
                let per_turn = i64::from(capabilities.counts_per_turn.unwrap_or(1));
                let from_first = shortest(i64::from(raw) - i64::from(first), per_turn);
                from_first as f64 * capabilities.resolution_rad()
            }
        };
        (low, high) = (low.min(angle_rad), high.max(angle_rad));
    }
    let spread_rad = (high - low).max(0.0);
    let about = "how far the angle flickers at rest; if too far, check the magnet's distance and the supply";
    Finding::new("angle noise", spread_rad, "rad", spread_rad <= ANGLE_NOISE_RAD, about)
}

/// The looks that show a new value. A value without an age counts as new at each look.
fn find_taken(looks: &[Look], age_s: impl Fn(&Reading) -> Option<f64>) -> Vec<&Look> {
    let mut last_s = f64::NEG_INFINITY;
    let new_looks = looks.iter().filter(|look| {
        let t_s = look.t_s - age_s(&look.reading).unwrap_or(0.0);
        let is_new = t_s > last_s + SAME_S;
        last_s = last_s.max(t_s);
        is_new
    });
    new_looks.collect()
}

fn new_forces_n(looks: &[Look]) -> Vec<f64> {
    find_taken(looks, |r| r.force_age_s).iter().map(|look| look.reading.force_n).collect()
}

/// Mean force, N; 0 of none.
fn mean_n(forces_n: &[f64]) -> f64 {
    match forces_n {
        [] => 0.0,
        _ => Moments::of(forces_n).mean,
    }
}

/// The time a stretch of evenly spaced looks stands for, s.
fn span_s(looks: &[Look]) -> f64 {
    match looks {
        // n looks stand for n periods, and the last is n − 1 of them after the first.
        [first, .., last] => (last.t_s - first.t_s) * looks.len() as f64 / (looks.len() - 1) as f64,
        _ => f64::INFINITY,
    }
}

/// Share of values that are the lowest or the highest, beyond the two there always are; 0 of fewer
/// than three.
fn at_ends(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    let ends = values.iter().filter(|x| **x <= low || **x >= high).count();
    ends.saturating_sub(2) as f64 / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock;
    use crate::trial::tests::LIMITS;

    /// Looks at 1 kHz for two seconds; `at` gives code and force, the force held for 12.5 ms.
    fn looks(at: impl Fn(f64) -> (u16, f64)) -> Vec<Look> {
        let look = |i: u32| {
            let t_s = f64::from(i) * 1e-3;
            let force_s = (t_s / 0.0125 + 1e-9).floor() * 0.0125;
            let reading = Reading {
                force_n: at(force_s).1,
                force_age_s: Some(t_s - force_s),
                ..mock::reading(Angle::Counts(at(t_s).0))
            };
            Look { t_s, reading }
        };
        (0..2000).map(look).collect()
    }

    /// Value and verdict of a finding.
    #[track_caller]
    fn check(found: &[Finding], name: &str, value: f64, tolerance: f64, ok: bool) {
        let check = &found.iter().find(|f| f.check.name == name).unwrap().check;
        assert!((check.value - value).abs() <= tolerance && check.ok == ok, "{check:?}");
    }

    fn rest(at: impl Fn(f64) -> (u16, f64)) -> Vec<Finding> {
        at_rest(&mock::capabilities(), 1000.0, &looks(at))
    }

    /// A force that is above and below its mean by `n` in turn, from value to value of the sensor.
    fn alternating(mean_n: f64, n: f64) -> impl Fn(f64) -> (u16, f64) {
        move |t_s| {
            (4095, mean_n + if ((t_s / 0.0125).round() as u32).is_multiple_of(2) { n } else { -n })
        }
    }

    #[test]
    fn a_sound_device_at_rest_has_its_rates_and_nothing_else() {
        let found = rest(alternating(0.05, 0.002));
        check(&found, "angle rate", 1000.0, 0.1, true);
        check(&found, "force rate", 80.0, 0.1, true);
        check(&found, "angle noise", 0.0, 0.0, true);
        check(&found, "force noise", 0.002, 1e-5, true);
        check(&found, "tare", 0.05, 1e-9, true);
    }

    #[test]
    fn a_sensor_that_is_slower_than_it_says_is_found() {
        let mut slow = looks(|_| (0, 0.0));
        slow.iter_mut().for_each(|look| look.reading.angle_age_s = look.t_s % 0.01);
        check(&at_rest(&mock::capabilities(), 1000.0, &slow), "angle rate", 100.0, 1.0, false);
        let capabilities = Capabilities { force_rate_hz: 160.0, ..mock::capabilities() };
        let found = at_rest(&capabilities, 1000.0, &looks(|_| (0, 0.0)));
        check(&found, "force rate", 80.0, 0.1, false);
    }

    #[test]
    fn noise_and_a_wrong_zero_are_found() {
        let found = rest(alternating(-0.3, 0.03));
        check(&found, "force noise", 0.03, 1e-3, false);
        check(&found, "tare", -0.3, 1e-9, false);
        let count_rad = mock::capabilities().resolution_rad();
        let flicker = |codes: [u16; 2]| rest(move |t_s| (codes[usize::from(t_s > 1.0)], 0.0));
        check(&flicker([4095, 1]), "angle noise", 2.0 * count_rad, 1e-12, true); // across the wrap
        check(&flicker([100, 110]), "angle noise", 10.0 * count_rad, 1e-12, false);
    }

    #[test]
    fn a_known_mass_tells_the_scale_and_the_side_of_the_load_cell() {
        let with = |force_n: f64| loaded(&looks(move |_| (0, force_n)), 0.1, 0.2);
        check(&with(0.1 + 1.961_33), "load cell scale", 1.0, 1e-9, true);
        check(&with(0.1 + 2.1), "load cell scale", 2.1 / 1.961_33, 1e-9, false);
        check(&with(0.1 - 1.961_33), "load cell scale", -1.0, 1e-9, false);
    }

    /// There and back over 90° of lever, with codes changed by `wrong`, and a push of up to 5 N.
    fn hand(wrong: impl Fn(u16) -> u16) -> Vec<Finding> {
        let whole = 4096.0 * 75.0 / 11.0 / 4.0;
        let at = |t_s: f64| {
            let there = 0.5 * (1.0 - (std::f64::consts::PI * t_s).cos());
            (wrong(((whole * there) as u32 % 4096) as u16), 5.0 * there)
        };
        by_hand(&mock::capabilities(), &LIMITS, &looks(at))
    }

    #[test]
    fn a_sound_sweep_has_lively_bits_room_to_unwrap_and_the_whole_stroke() {
        let found = hand(|code| code);
        assert!(found.iter().all(|f| f.check.ok), "{found:?}");
        // The fastest step: half the stroke in counts, times π, in a millisecond.
        let fastest = 4096.0 * 75.0 / 11.0 / 8.0 * std::f64::consts::PI * 1e-3;
        check(&found, "unwrap margin", 1.0 - fastest / 2048.0, 1e-3, true);
        check(&found, "stroke", std::f64::consts::FRAC_PI_2, 1e-3, true);
    }

    #[test]
    fn a_stuck_bit_and_a_cut_off_range_are_found() {
        let stuck = hand(|code| code | 4);
        assert!(!stuck.iter().find(|f| f.check.name == "unique codes").unwrap().check.ok);
        let cut = hand(|code| if code > 3000 { 3000 + code % 2 } else { code });
        assert!(!cut.iter().find(|f| f.check.name == "angle saturation").unwrap().check.ok);
    }

    #[test]
    fn an_amplifier_at_its_end_is_found_and_a_constant_zero_is_not_one() {
        check(&by_hand_force(|n| n.min(3.0)), "force saturation", 0.6, 0.2, false);
        check(&by_hand_force(|_| 0.0), "force saturation", 0.0, 0.0, true);
    }

    fn by_hand_force(shown_n: impl Fn(f64) -> f64) -> Vec<Finding> {
        by_hand(&mock::capabilities(), &LIMITS, &looks(|t_s| (0, shown_n(5.0 * t_s.sin()))))
    }

    #[test]
    fn a_loop_that_is_late_half_a_period_is_found() {
        let mut kept = Timing { ticks: 98, missed: 2, ..Timing::default() };
        (0..98).for_each(|_| kept.lateness.add(0.6e-3));
        let found = timing(&kept, 1000.0);
        check(&found, "jitter, 99 %", 0.6e-3, 0.02e-3, false);
        check(&found, "latency, 99 %", 0.0, 0.0, true);
        check(&found, "missed deadlines", 0.02, 1e-12, false);
    }
}
