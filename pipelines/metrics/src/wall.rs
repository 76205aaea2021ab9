//! What happened at the wall.

use crate::MetricsError;
use crate::compliance::range;
use crate::part::{Part, Piece};
use crate::resolution::resolution_rad;
use crate::signals::Signals;
use zwidth_numerics::phases::first_passing;
use zwidth_numerics::series::{ends, interpolate};
use zwidth_stats::interval::Estimate;
use zwidth_stats::recording::recording_line;
use zwidth_store::Values;
use zwidth_study::Analysis;

/// A rebound is a retreat from the wall by more than this share of the angles travelled; less is
/// taken for the angle sensor's jitter.
pub(crate) const REBOUND_SHARE: f64 = 0.01;

/// Angles are one step apart, give or take their arithmetic, in steps.
const SAME: f64 = 1.001;

/// What happened at a wall that begins at θ_wall; over the whole recording. All null where the
/// environment has no wall or θ is not recorded; all but `reached` null where θ never exceeds
/// θ_wall.
///
/// Between samples θ and F are taken as straight lines, and only the part of an interval with θ >
/// θ_wall counts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WallContact {
    /// Whether θ exceeds θ_wall.
    pub reached: Option<bool>,
    /// Largest θ − θ_wall, rad.
    pub past_max_rad: Option<f64>,
    /// The same at the lever, L (θ − θ_wall), m. Null without a lever length.
    pub past_max_m: Option<f64>,
    /// Time with θ > θ_wall, s.
    pub dwell_s: Option<f64>,
    /// ∫F dt past the wall, N·s.
    pub impulse_n_s: Option<f64>,
    /// ∫F dx past the wall, J: what the wall takes from the user in all; below 0 it gives energy
    /// out. Null without a lever length.
    pub energy_j: Option<f64>,
    /// θ̇ where θ first passes θ_wall, rad/s. Null if the recording begins past it.
    pub impact_velocity_rad_s: Option<f64>,
    /// How often the lever passes the wall again after a retreat of more than 1 % of the angles
    /// travelled.
    pub rebounds: Option<i64>,
    /// How often the brake goes off, from one sample to the next, while the lever is past the
    /// wall. One is how a hybrid drive lets a finger go; more are the anomaly of thesis
    /// §6.2.1. Null where the recording does not say when the brake is on (`flags` or
    /// `voltage_brake_v`).
    pub brake_releases: Option<i64>,
    /// Longest time without a break past the wall with |θ̇| below `analysis.offset_rad_s`, s, from
    /// sample to sample; 0 where the lever only turns there. Null without θ̇.
    pub still_s: Option<f64>,
    /// Largest F past the wall, N. Null without force.
    pub force_max_n: Option<f64>,
    /// Largest F past the wall less F where θ first passes θ_wall, N: by how much the user's force
    /// grows against the wall. Null without force, or if the recording begins past the wall.
    pub force_rise_n: Option<f64>,
    /// Rigidity: what F grows by from where θ first passes θ_wall to its largest value past the
    /// wall, over how far the lever is moved past θ_wall until then, N/rad. It tells a wall that
    /// holds, too, where no slope can be: one that moves the lever by no more than the smallest
    /// step between recorded angles δ has ΔF / δ, a lower bound. Null where F does not grow,
    /// without force, or if the recording begins past the wall.
    pub rigidity_n_per_rad: Option<f64>,
    /// Whether the rigidity is a lower bound: the lever moved by no more than δ. Null with it.
    pub rigidity_at_least: Option<bool>,
    /// Rigidity once the lever is held, at least, N/rad: what F grows by from where the lever is
    /// first within δ of its farthest angle past the wall to the largest F after that, over δ: it
    /// moved by no more. Null where F does not grow there, or without force.
    pub hold_rigidity_min_n_per_rad: Option<f64>,
    /// Slope of F on θ past the wall, N/rad: the wall's rendered stiffness. Least squares over the
    /// samples with θ > θ_wall from the first of them to the largest θ. Null for fewer than
    /// three samples, for one angle (see `rigidity_n_per_rad`), or without force.
    pub stiffness_n_per_rad: Option<f64>,
    /// Lower end of its interval, N/rad, as that of [`SpringRendering`](crate::SpringRendering).
    pub stiffness_ci_low_n_per_rad: Option<f64>,
    /// Upper end of its interval, N/rad.
    pub stiffness_ci_high_n_per_rad: Option<f64>,
}

pub(crate) fn wall_contact(
    signals: &Signals,
    wall_rad: f64,
    analysis: &Analysis,
) -> Result<WallContact, MetricsError> {
    let Some(theta) = signals.theta() else {
        return Ok(WallContact::default());
    };
    let (_, highest) = ends(&theta);
    if highest <= wall_rad {
        return Ok(WallContact { reached: Some(false), ..WallContact::default() });
    }
    // Angle and force, then time and force, then time and velocity: two columns at a time.
    let past = Part::past(&theta, wall_rad);
    let count_rad = resolution_rad(&theta);
    // The first contact is no rebound.
    let rebounds = contacts(&theta, wall_rad).len() as i64 - 1;
    let by_way = signals.force().map(|f| {
        past.over_pieces(|p| p.mean(&f) * (p.to - p.from) * (theta[p.i + 1] - theta[p.i]))
    });
    let hold =
        signals.force().and_then(|f| hold_rigidity(&theta, &f, wall_rad, highest, count_rad));
    let stiffness = match signals.force() {
        Some(f) => stiffness(&theta, &f, wall_rad, highest, analysis.confidence)?,
        None => None,
    };
    let at_wall = first_passing(&signals.t()?, &theta, wall_rad);
    let when_passing = |y: Option<Values>| interpolate(&signals.t().ok()?, &y?, at_wall?);
    let first_n = when_passing(signals.force());
    let rigidity = signals
        .force()
        .zip(first_n)
        .and_then(|(f, first_n)| rigidity(&theta, &f, wall_rad, first_n, count_rad));
    drop(theta);
    let force_max_n = signals.force().and_then(|f| past.largest(&f));
    let t = signals.t()?;
    let duration = |p: &Piece| (p.to - p.from) * (t[p.i + 1] - t[p.i]);
    let impulse_n_s = signals.force().map(|f| past.over_pieces(|p| p.mean(&f) * duration(p)));
    let still_s = signals
        .theta_dot()
        .map(|v| longest(&t, |i| past.samples[i] && v[i].abs() < analysis.offset_rad_s));
    let brake_releases = signals.brake_on.as_deref().map(|on| {
        let steps = on.windows(2).zip(&past.samples);
        steps.map(|(on, past)| i64::from(*past && on[0] && !on[1])).sum()
    });
    Ok(WallContact {
        reached: Some(true),
        past_max_rad: Some(highest - wall_rad),
        past_max_m: signals.lever_m.map(|lever_m| lever_m * (highest - wall_rad)),
        dwell_s: Some(past.over_pieces(duration)),
        impulse_n_s,
        energy_j: signals.lever_m.zip(by_way).map(|(lever_m, integral)| lever_m * integral),
        impact_velocity_rad_s: when_passing(signals.theta_dot()),
        rebounds: Some(rebounds),
        brake_releases,
        still_s,
        force_max_n,
        force_rise_n: force_max_n.zip(first_n).map(|(most, first)| most - first),
        rigidity_n_per_rad: rigidity.map(|r| r.0),
        rigidity_at_least: rigidity.map(|r| r.1),
        hold_rigidity_min_n_per_rad: hold,
        stiffness_n_per_rad: stiffness.map(|s| s.estimate),
        stiffness_ci_low_n_per_rad: stiffness.map(|s| s.ci_low),
        stiffness_ci_high_n_per_rad: stiffness.map(|s| s.ci_high),
    })
}

/// The rigidity, and whether it is a bound; `first_n` is the force where the wall is passed.
fn rigidity(
    theta: &[f64],
    force: &[f64],
    wall: f64,
    first_n: f64,
    count_rad: f64,
) -> Option<(f64, bool)> {
    let past = (0..theta.len()).filter(|i| theta[*i] > wall);
    // Of equal forces the first: the lever has moved least by then.
    let most = past.reduce(|most, i| if force[i] > force[most] { i } else { most })?;
    let grown_n = force[most] - first_n;
    let until = ends(&theta[..=most]).1;
    let moved_rad = (until - wall).max(count_rad);
    (grown_n > 0.0 && moved_rad > 0.0).then(|| (grown_n / moved_rad, until - wall <= count_rad))
}

/// The least rigidity of a lever that is held at its farthest angle.
fn hold_rigidity(
    theta: &[f64],
    force: &[f64],
    wall: f64,
    highest: f64,
    count_rad: f64,
) -> Option<f64> {
    let held = |theta: &f64| *theta > wall && highest - theta <= SAME * count_rad;
    let first = theta.iter().position(held)?;
    let while_held =
        theta[first..].iter().zip(&force[first..]).take_while(|(theta, _)| held(theta));
    let grown_n = while_held.map(|(_, f)| f - force[first]).fold(0.0, f64::max);
    (grown_n > 0.0 && count_rad > 0.0).then(|| grown_n / count_rad)
}

/// The slope on the way in, up to the first sample at `highest`.
fn stiffness(
    theta: &[f64],
    force: &[f64],
    wall: f64,
    highest: f64,
    level: f64,
) -> Result<Option<Estimate>, MetricsError> {
    let deepest = theta.iter().position(|theta| *theta >= highest).unwrap_or_default();
    let way_in: Vec<u32> = (0..=deepest as u32).filter(|i| theta[*i as usize] > wall).collect();
    let line = recording_line(
        way_in.len(),
        |i| {
            let place = way_in[i] as usize;
            (theta[place] - wall, force[place])
        },
        0.0,
        level,
    )?;
    Ok(line.map(|line| line.slope))
}

/// The longest time, s, from the first to the last of neighbouring samples that are all `still`.
fn longest(t: &[f64], still: impl Fn(usize) -> bool) -> f64 {
    let mut since = None;
    let mut most = 0.0_f64;
    for (i, now) in t.iter().enumerate() {
        since = still(i).then(|| since.unwrap_or(*now));
        most = most.max(since.map_or(0.0, |since| now - since));
    }
    most
}

/// Samples past the wall: the first and the last of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Contact {
    pub(crate) first: usize,
    pub(crate) last: usize,
}

/// The contacts with the wall: each lasts until the lever has retreated from it by more than 1 % of
/// the angles travelled.
pub(crate) fn contacts(theta: &[f64], wall: f64) -> Vec<Contact> {
    let retreat = wall - REBOUND_SHARE * range(theta);
    let mut touches = false;
    let mut contacts = Vec::<Contact>::new();
    for (i, &theta) in theta.iter().enumerate() {
        if theta > wall {
            match contacts.last_mut().filter(|_| touches) {
                Some(contact) => contact.last = i,
                None => contacts.push(Contact { first: i, last: i }),
            }
            touches = true;
        } else if theta < retreat {
            touches = false;
        }
    }
    contacts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{LEVER_M, REST_RAD, at_wall, check, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::Signal;

    fn contact(
        points: &[(f64, f64, f64)],
        wall_rad: f64,
        force: impl Fn(f64, f64) -> f64,
    ) -> WallContact {
        trial_metrics(&trial(points, force), &at_wall(4.0, REST_RAD, wall_rad)).unwrap().wall
    }

    #[test]
    fn a_wall_not_reached_is_null_and_never_zero() {
        let found = contact(&stroke(1.0, 2.0), REST_RAD + 1.0 + 1e-9, |_, _| 1.0);
        assert_eq!(found, WallContact { reached: Some(false), ..WallContact::default() });
    }

    /// A mass m on a wall of stiffness k that arrives at speed v: θ − θ_wall = (v/ω) sin ωt for
    /// half a period.
    #[test]
    fn an_elastic_impact_has_the_numbers_of_its_half_sine() {
        let (wall, k, omega, v) = (0.5, 800.0, 40.0, 0.4);
        let (depth, contact_s) = (v / omega, core::f64::consts::PI / omega);
        let point = |i: u32| {
            let t = f64::from(i) * 1e-4;
            let s = t - 0.5;
            if (0.0..contact_s).contains(&s) {
                (t, wall + depth * libm::sin(omega * s), v * libm::cos(omega * s))
            } else if s < 0.0 {
                (t, wall + v * s, v)
            } else {
                (t, wall - v * (s - contact_s), -v)
            }
        };
        let points: Vec<_> = (0..10_000).map(point).collect();
        let found = contact(&points, wall, |theta, _| k * (theta - wall).max(0.0));
        check(found.past_max_rad, depth, 1e-7);
        check(found.past_max_m, LEVER_M * depth, 1e-8);
        check(found.dwell_s, contact_s, 1e-7);
        check(found.impulse_n_s, 2.0 * k * depth / omega, 1e-5);
        check(found.energy_j, 0.0, 1e-7);
        check(found.impact_velocity_rad_s, v, 1e-9);
        check(found.stiffness_n_per_rad, k, 1e-7);
        check(found.stiffness_ci_low_n_per_rad, k, 1e-7);
        assert_eq!((found.rebounds, found.brake_releases), (Some(0), None));
    }

    #[test]
    fn a_brake_that_lets_go_past_the_wall_is_counted_and_before_it_is_not() {
        let angles = [0.0, 0.5, 0.8, 0.9, 0.9, 0.8, 0.8, 0.5];
        let points: Vec<_> = (0..).zip(angles).map(|(i, a)| (f64::from(i), a, 1.0)).collect();
        let mut trial = trial(&points, |_, _| 0.0);
        trial.samples.set(Signal::VoltageBrake, vec![8.0, 0.0, 8.0, 0.0, 8.0, 8.0, 0.0, 0.0]);
        let found = trial_metrics(&trial, &at_wall(4.0, REST_RAD, 0.75)).unwrap().wall;
        assert_eq!(found.brake_releases, Some(2));
    }

    #[test]
    fn a_wall_that_holds_the_lever_at_one_angle_has_no_stiffness_that_could_be_told() {
        let points: Vec<_> =
            (0..20).map(|i| (f64::from(i), if i < 5 { 0.0 } else { 0.76 }, 0.0)).collect();
        assert_eq!(contact(&points, 0.75, |theta, _| theta).stiffness_n_per_rad, None);
    }

    /// A triangle at 2 rad/s up and 1 rad/s down, 0.25 rad past the wall, F = 5 N in and 3 N out.
    #[test]
    fn a_triangle_past_the_wall_has_the_numbers_of_its_geometry() {
        let points =
            [(0.0, 0.0, 2.0), (0.5, 1.0, 2.0), (0.5 + 1e-9, 1.0, -1.0), (1.5 + 1e-9, 0.0, -1.0)];
        let found = contact(&points, 0.75, |_, v| if v > 0.0 { 5.0 } else { 3.0 });
        check(found.past_max_rad, 0.25, 1e-15);
        check(found.past_max_m, LEVER_M * 0.25, 1e-15);
        check(found.dwell_s, 0.125 + 0.25, 1e-8);
        check(found.impulse_n_s, 5.0 * 0.125 + 3.0 * 0.25, 1e-7);
        check(found.energy_j, LEVER_M * (5.0 - 3.0) * 0.25, 1e-12);
        check(found.impact_velocity_rad_s, 2.0, 1e-15);
        assert_eq!(found.rebounds, Some(0));
    }

    /// Stands past the wall from 1.0 to 1.4 s and, after a jerk, from 1.5 to 1.7 s; F grows by 2
    /// N/s from 5 N where the wall is passed at 0.5 s.
    #[test]
    fn a_lever_that_stands_at_the_wall_is_still_for_its_longest_stand_while_the_force_rises() {
        let point = |i: u32| {
            let t = f64::from(i) * 0.01;
            let stands = (100..=140).contains(&i) || (150..=170).contains(&i);
            (t, t.min(1.0) * 1.5, if stands { 0.05 } else { 1.5 })
        };
        let points: Vec<_> = (0..=180).map(point).collect();
        let mut trial = trial(&points, |_, _| 0.0);
        trial.samples.set(Signal::ForceEx, points.iter().map(|p| 4.0 + 2.0 * p.0).collect());
        let found = trial_metrics(&trial, &at_wall(4.0, REST_RAD, 0.75)).unwrap().wall;
        check(found.still_s, 0.4, 1e-12);
        check(found.force_max_n, 4.0 + 2.0 * 1.8, 1e-12);
        check(found.force_rise_n, 2.0 * 1.8 - 2.0 * 0.5, 1e-12);
    }

    /// θ = a (1 − cos ωt)/2 turns past the wall with |θ̇| = (aω/2) |sin ωt|: below v for
    /// 2 asin(2v/(aω))/ω.
    #[test]
    fn a_lever_that_turns_past_the_wall_is_still_for_its_turn_alone() {
        let (stroke_rad, omega) = (1.4, core::f64::consts::PI);
        let found = contact(&stroke(stroke_rad, 2.0), REST_RAD + 1.0, |_, _| 1.0);
        let offset_rad_s = 5_f64.to_radians();
        let turn_s = 2.0 * libm::asin(2.0 * offset_rad_s / (stroke_rad * omega)) / omega;
        check(found.still_s, turn_s, 2e-3);
    }

    /// The lever stops 0.01 rad past the wall while the force grows from 5 to 13 N.
    #[test]
    fn a_wall_that_holds_has_the_rigidity_of_what_it_moves() {
        let angle = |i: i32| (0.76_f64).min(0.01 * f64::from(i));
        let points: Vec<_> = (0..200).map(|i| (f64::from(i) * 0.01, angle(i), 0.0)).collect();
        let force = |t: f64| if t <= 0.75 { 5.0 } else { (5.0 + 20.0 * (t - 0.75)).min(13.0) };
        let mut made = trial(&points, |_, _| 0.0);
        made.samples.set(Signal::ForceEx, points.iter().map(|p| force(p.0)).collect());
        let of = |wall| trial_metrics(&made, &at_wall(4.0, REST_RAD, wall)).unwrap().wall;
        // two counts of 0.01 rad past it
        let found = of(0.74);
        check(found.rigidity_n_per_rad, 8.0 / 0.02, 1e-6);
        assert_eq!(found.rigidity_at_least, Some(false));
        // less than a count: at least the force over the count
        let found = of(0.755);
        check(found.rigidity_n_per_rad, (13.0 - force(0.755)) / 0.01, 1e-6);
        assert_eq!((found.rigidity_at_least, found.stiffness_n_per_rad), (Some(true), None));
        // it stands at 0.76 rad from 0.76 s on, and is within a count of it from 0.75 s on
        let found = of(0.74);
        check(found.hold_rigidity_min_n_per_rad, (13.0 - force(0.75)) / 0.01, 1e-6);
    }

    #[test]
    fn a_wall_against_which_no_force_grows_has_no_rigidity() {
        let found = contact(&stroke(1.4, 2.0), REST_RAD + 1.0, |_, _| 1.0);
        assert_eq!((found.rigidity_n_per_rad, found.rigidity_at_least), (None, None));
        assert_eq!(found.hold_rigidity_min_n_per_rad, None);
    }

    #[test]
    fn rebounds_are_retreats_and_jitter_is_not() {
        let angles = [0.0, 0.8, 0.749, 0.8, 0.6, 0.9, 0.7, 0.8, 0.0];
        let points: Vec<_> = (0..).zip(angles).map(|(i, a)| (f64::from(i), a, 1.0)).collect();
        assert_eq!(contact(&points, 0.75, |_, _| 0.0).rebounds, Some(2));
    }

    #[test]
    fn a_recording_that_begins_past_the_wall_has_no_impact() {
        let points = [(0.0, 1.0, 0.0), (1.0, 0.0, -1.0)];
        let found = contact(&points, 0.5, |_, _| 1.0);
        assert_eq!((found.impact_velocity_rad_s, found.force_rise_n), (None, None));
        check(found.dwell_s, 0.5, 1e-15);
    }
}
