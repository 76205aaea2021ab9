//! What a trajectory is worth: its faults in order, and how far it is from the right motion.

use crate::changes::{Change, Compared, cause, compared};
use crate::creep::{Held, held};
use crate::energy::{Balance, balance};
use crate::errors::{Right, errors_at, peak_rad};
use crate::growth::growth;
use crate::jumps::{Jump, jumps};
use crate::sides::Sides;
use crate::{Candidate, EXACT, JudgeError, Story, Yardstick, places};
use serde::Serialize;
use std::sync::Arc;
use zwidth_dynamics::{FeltMotion, FeltReference, own_swings};
use zwidth_results::{JudgedTrajectory, LeverEvent, Proof, TrajectoryFault, TrajectoryVerdict};
use zwidth_study::Perception;

/// A swing of less than this is none, rad.
const SMALLEST_SWING_RAD: f64 = 1e-7;
/// An event that is missing shows where the trajectory is off by this share of the right motion's
/// range, or by the tolerance.
const SHOWS: f64 = 0.05;
/// One that is late, where it is off by this share of the range, or of the tolerance.
const LATE_SHOWS: [f64; 2] = [0.01, 0.2];
/// Events whose lateness differs by less are equally late, s.
const SAME_S: f64 = 1e-6;
/// Of a motion that `exact` cannot run two other solvers must agree to this share of what is
/// allowed.
const KNOWN_SHARE: f64 = 1e-3;
/// Motion at a speed above this share of the right motion's largest is no creep.
const FASTEST_CREEP: f64 = 0.2;
/// Above the speed of its creep by this factor a lever moves: by so much that one that came to rest
/// moves on no longer ([`crate::changes`]).
const BEYOND_CREEP: f64 = 2.5;

/// How far a trajectory may be from the right motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Allowed {
    /// Of θ, rad.
    pub theta_rad: f64,
    /// Of the time of an event, s, beyond the time between two samples.
    pub event_s: f64,
    /// Speed of a lever that is held, rad/s.
    pub creep_rad_s: f64,
}

impl Default for Allowed {
    /// Half a degree, a quarter of what a person can tell; a millisecond, the tick of most control
    /// loops; and 10⁻⁵ °/s, a degree in a day.
    fn default() -> Self {
        Self { theta_rad: 0.5_f64.to_radians(), event_s: 1e-3, creep_rad_s: 1e-5_f64.to_radians() }
    }
}

/// What is known of a trajectory, and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The trajectory beside the right motion. Scene, trajectory, engine, setting and cost are left
    /// to whoever knows their names.
    pub trajectory: JudgedTrajectory,
    /// Its faults, the gravest first.
    pub faults: Vec<TrajectoryFault>,
}

impl Judged {
    /// With the trajectory's name, and what is said of it: what made it, its setting, its cost in s.
    #[must_use]
    pub fn named(
        mut self,
        name: &str,
        engine: Option<&str>,
        setting: Option<&str>,
        cost_s: Option<f64>,
    ) -> Self {
        let name: Arc<str> = name.into();
        for fault in &mut self.faults {
            fault.trajectory = name.clone();
        }
        let trajectory = JudgedTrajectory {
            trajectory: name,
            engine: engine.map(Arc::from),
            setting: setting.map(Arc::from),
            cost_s,
            ..self.trajectory
        };
        Self { trajectory, ..self }
    }
}

/// Judges a trajectory of a scene.
///
/// # Errors
/// A trajectory that cannot be compared with the scene: see [`JudgeError`].
pub fn judge(
    yardstick: &Yardstick,
    candidate: &Candidate,
    allowed: &Allowed,
    perception: &Perception,
) -> Result<Judged, JudgeError> {
    let scene = yardstick.system.scene();
    let within = candidate.within(scene.duration_s)?;
    let force_ex_n = within.force_ex_n.clone();
    let sides = Sides::of(yardstick, within)?;
    let held = held(&sides);
    // A slower lever stands.
    let sides = sides.resting_below(allowed.creep_rad_s);
    let steady = held.iter().map(|held| held.creep_rad_s);
    let creep_rad_s = steady.reduce(|most, next| if next.abs() > most.abs() { next } else { most });
    let sides = match creep_rad_s.map(f64::abs) {
        Some(creep) if is_slow(&sides, creep) => sides.resting_below(BEYOND_CREEP * creep),
        _ => sides,
    };
    let jumps = jumps(&sides, allowed.theta_rad);
    let reset: Vec<usize> = jumps.iter().map(|jump| jump.at).collect();
    let balance = balance(yardstick, &sides, allowed.theta_rad, &reset)?;
    let events = compared(&sides, allowed.theta_rad);
    let is_known = is_known(yardstick, allowed);
    let faults = match is_known {
        // Whether it is wrong or the yardstick, nobody knows.
        false => Vec::new(),
        true => {
            let seen = Seen {
                held: &held,
                jumps: &jumps,
                balance: balance.as_ref(),
                events: events.as_ref(),
            };
            faults(&sides, allowed, &seen)
        }
    };
    let stands = (0..sides.len()).all(|i| sides.is_held(i));
    let verdict = match (faults.first(), is_known) {
        (_, false) => TrajectoryVerdict::Unproven,
        (Some(first), _) => first.fault,
        (None, _) if stands => TrajectoryVerdict::Stands,
        (None, _) => TrajectoryVerdict::Right,
    };
    let late_s = events
        .iter()
        .flat_map(|events| &events.both)
        .map(|(right, own)| (own.t_s - right.t_s).abs());
    let trajectory = JudgedTrajectory {
        verdict,
        faults: faults.len(),
        event_error_s: late_s.reduce(f64::max),
        creep_rad_s,
        energy_residual_j: balance.map(|balance| balance.residual_j),
        energy_bound_j: balance.map(|balance| balance.bound_j),
        energy_scale_j: balance.map(|balance| balance.scale_j),
        input_error_max_n: force_ex_n.map(|force_n| input_error_n(&sides, &force_n)),
        ..measured(yardstick, &sides, perception)
    };
    Ok(Judged { trajectory, faults })
}

/// Whether the right motion is known well enough: proven, or with curved terms, for which there is no
/// exact solver, to a small share of what is allowed.
fn is_known(yardstick: &Yardstick, allowed: &Allowed) -> bool {
    let within = |apart: Option<f64>, allowed: f64| {
        apart.is_some_and(|apart| apart <= KNOWN_SHARE * allowed)
    };
    yardstick.proof != Proof::Unproven
        || yardstick.by != EXACT
            && within(yardstick.apart_rad, allowed.theta_rad)
            && within(yardstick.apart_s, allowed.event_s)
}

/// Whether a steady motion of a lever that is held counts as creep: one that is nearly as fast as the
/// right motion is a motion that did not end.
fn is_slow(sides: &Sides<'_>, creep_rad_s: f64) -> bool {
    let fastest = sides.right.fastest_rad_s();
    fastest <= 0.0 || creep_rad_s <= FASTEST_CREEP * fastest
}

/// The largest difference of the user's force in the file from the scene's, N.
fn input_error_n(sides: &Sides<'_>, force_n: &[f64]) -> f64 {
    let run = &sides.right.run;
    let right = (0..run.len()).map(|i| run.forces(sides.system, i).external_n);
    force_n.iter().zip(right).map(|(own, right)| (own - right).abs()).fold(0.0, f64::max)
}

/// The errors, compared with the right motion at the same samples, and as finely seen as these are.
fn measured(yardstick: &Yardstick, sides: &Sides<'_>, perception: &Perception) -> JudgedTrajectory {
    let system = sides.system;
    let right = &sides.right.run;
    let motion = FeltMotion::of(system, right);
    let felt = FeltReference::new(&motion, system.scene().plant.lever_m, perception);
    let story = Story::of(system, right);
    let places = places(right, right.len());
    let right = Right {
        run: right,
        story: &story,
        impulse_ns: motion.impulse_ns(),
        peak_rad: peak_rad(right),
        felt: &felt,
    };
    let errors = errors_at(system, &sides.own.run, &places, &right);
    let name: Arc<str> = system.scene().name.as_str().into();
    JudgedTrajectory {
        scene: name,
        trajectory: "".into(),
        engine: None,
        setting: None,
        cost_s: None,
        verdict: TrajectoryVerdict::Right,
        faults: 0,
        yardstick: yardstick.proof,
        by: yardstick.by.into(),
        samples: sides.len(),
        step_s: sides.step_s,
        theta_resolution_rad: sides.theta_step_rad,
        theta_dot_resolution_rad_s: sides.omega_step_rad_s,
        velocity_computed: sides.velocity_computed,
        theta_error_max_rad: errors.theta_rad.largest,
        theta_error_rms_rad: errors.theta_rad.rms,
        theta_dot_error_max_rad_s: errors.theta_dot_rad_s.largest,
        theta_dot_error_rms_rad_s: errors.theta_dot_rad_s.rms,
        force_error_max_n: errors.force_n.largest,
        force_error_rms_n: errors.force_n.rms,
        impulse_error_ns: errors.impulse_ns,
        peak_error_rad: errors.peak_rad,
        input_error_max_n: None,
        event_error_s: None,
        felt_force_share: errors.felt.force_share,
        felt_angle_share: errors.felt.angle_share,
        felt_vibration_share: errors.felt.vibration_share,
        is_felt: errors.felt.is_felt(),
        creep_rad_s: None,
        energy_residual_j: None,
        energy_bound_j: None,
        energy_scale_j: None,
    }
}

/// What was looked at.
struct Seen<'a> {
    held: &'a [Held],
    jumps: &'a [Jump],
    balance: Option<&'a Balance>,
    events: Option<&'a Compared>,
}

/// The faults, the gravest first. What follows from a graver one is not a fault of its own: where
/// the state was reset or a stop passed, the energy is wrong too, and of an unstable trajectory
/// nothing else is said.
fn faults(sides: &Sides<'_>, allowed: &Allowed, seen: &Seen<'_>) -> Vec<TrajectoryFault> {
    let none = none(sides);
    if let Some((growth_per_s, t_s)) = growth(sides, allowed.theta_rad) {
        let growth_per_s = Some(growth_per_s);
        return vec![TrajectoryFault {
            fault: TrajectoryVerdict::Unstable,
            t_s,
            growth_per_s,
            ..none
        }];
    }
    let mut faults = Vec::new();
    faults.extend(beyond_stop(sides, allowed.theta_rad));
    let passed = !faults.is_empty();
    faults.extend(reset(sides, seen.jumps));
    let swings_rad = SMALLEST_SWING_RAD.max(sides.unseen_rad());
    let swings = own_swings(&sides.own.run, &sides.right.run, swings_rad);
    if let Some(events) = seen.events.filter(|_| faults.is_empty()) {
        faults.extend(missed(sides, allowed, &events.missed));
        // A lever that swings breaks loose more often than it can be said.
        faults.extend(extra(sides, allowed, &events.extra).filter(|_| swings.is_none()));
    }
    if let Some(swings) = swings {
        faults.push(TrajectoryFault {
            fault: TrajectoryVerdict::Chatters,
            times: swings.count,
            theta_rad: Some(swings.amplitude_rad),
            frequency_hz: Some(swings.frequency_hz),
            ..none.clone()
        });
    }
    // A lever that fell through its stop moves on, and does not creep.
    let creeps = |held: &&Held| {
        held.creep_rad_s.abs() > allowed.creep_rad_s && is_slow(sides, held.creep_rad_s.abs())
    };
    let creeping: Vec<&Held> = seen.held.iter().filter(creeps).filter(|_| !passed).collect();
    let fastest =
        creeping.iter().max_by(|a, b| a.creep_rad_s.abs().total_cmp(&b.creep_rad_s.abs()));
    faults.extend(fastest.map(|held| TrajectoryFault {
        fault: TrajectoryVerdict::Creeps,
        t_s: held.from_s,
        times: creeping.len(),
        creep_rad_s: Some(held.creep_rad_s),
        ..none.clone()
    }));
    if let Some(events) = seen.events.filter(|_| !passed && seen.jumps.is_empty()) {
        faults.extend(late(sides, allowed, &events.both));
    }
    if let Some(balance) = seen.balance.filter(|balance| faults.is_empty() && balance.is_broken()) {
        let is_made = balance.residual_j > 0.0;
        faults.push(TrajectoryFault {
            fault: if is_made {
                TrajectoryVerdict::EnergyMade
            } else {
                TrajectoryVerdict::EnergyLost
            },
            energy_j: Some(balance.residual_j),
            ..none.clone()
        });
    }
    let worst = (0..sides.len()).max_by(|a, b| sides.apart_rad(*a).total_cmp(&sides.apart_rad(*b)));
    let worst = worst.filter(|i| faults.is_empty() && sides.apart_rad(*i) > allowed.theta_rad);
    faults.extend(worst.map(|i| TrajectoryFault {
        fault: TrajectoryVerdict::Inaccurate,
        t_s: sides.t_s[i],
        theta_rad: Some(sides.apart_rad(i)),
        ..none
    }));
    faults
}

/// A fault that has nothing yet.
fn none(sides: &Sides<'_>) -> TrajectoryFault {
    TrajectoryFault {
        scene: sides.system.scene().name.as_str().into(),
        trajectory: "".into(),
        fault: TrajectoryVerdict::Right,
        event: None,
        t_s: 0.0,
        times: 1,
        late_s: None,
        creep_rad_s: None,
        theta_rad: None,
        theta_dot_rad_s: None,
        to_zero: false,
        frequency_hz: None,
        energy_j: None,
        growth_per_s: None,
    }
}

/// The stop that the lever passes by more than the tolerance, and how far.
fn beyond_stop(sides: &Sides<'_>, tolerance_rad: f64) -> Option<TrajectoryFault> {
    let [low, high] = sides.stops_rad()?;
    let depth = |theta: &f64| (theta - high).max(low - theta);
    let theta = &sides.own.theta_rad;
    let deepest_rad = theta.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
    let first = theta.iter().position(|theta| depth(theta) > tolerance_rad)?;
    Some(TrajectoryFault {
        fault: TrajectoryVerdict::BeyondStop,
        t_s: sides.t_s[first],
        theta_rad: Some(deepest_rad),
        ..none(sides)
    })
}

/// The largest jump of the state.
fn reset(sides: &Sides<'_>, jumps: &[Jump]) -> Option<TrajectoryFault> {
    let ranges = [sides.right.range_rad().max(sides.own.range_rad()), sides.own.fastest_rad_s()];
    let share = |jump: &Jump| {
        let [theta, omega] =
            [jump.theta_rad.abs() / ranges[0], jump.theta_dot_rad_s.abs() / ranges[1]];
        theta.max(omega)
    };
    let largest = jumps.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
    let some = |size: f64| (size != 0.0).then_some(size);
    Some(TrajectoryFault {
        fault: TrajectoryVerdict::Reset,
        t_s: sides.t_s[largest.at],
        times: jumps.len(),
        theta_rad: some(largest.theta_rad),
        theta_dot_rad_s: some(largest.theta_dot_rad_s),
        to_zero: largest.to_zero,
        ..none(sides)
    })
}

/// Whether the trajectory is off around a change by more than what may be called right.
fn shows(sides: &Sides<'_>, allowed: &Allowed, change: &Change) -> bool {
    let [from, to] = change.around;
    let least_rad = allowed.theta_rad.min(SHOWS * sides.right.range_rad()).max(sides.unseen_rad());
    sides.most_apart_rad(from, to) > least_rad
}

/// Events of the right motion that do not happen, one fault for each kind.
fn missed(sides: &Sides<'_>, allowed: &Allowed, missed: &[Change]) -> Vec<TrajectoryFault> {
    let missed = missed.iter().filter(|change| shows(sides, allowed, change));
    by_event(
        sides,
        TrajectoryVerdict::Missed,
        missed.map(|change| (cause(sides, change), change.t_s)),
    )
}

/// Events that do not happen in the right motion.
fn extra(
    sides: &Sides<'_>,
    allowed: &Allowed,
    extra: &[Change],
) -> impl Iterator<Item = TrajectoryFault> {
    let extra = extra.iter().filter(|change| shows(sides, allowed, change));
    by_event(sides, TrajectoryVerdict::Extra, extra.map(|change| (change.event(), change.t_s)))
        .into_iter()
}

/// A fault for each kind of event, with the first time and how often.
fn by_event(
    sides: &Sides<'_>,
    fault: TrajectoryVerdict,
    events: impl Iterator<Item = (LeverEvent, f64)>,
) -> Vec<TrajectoryFault> {
    let mut faults: Vec<TrajectoryFault> = Vec::new();
    for (event, t_s) in events {
        match faults.iter_mut().find(|known| known.event == Some(event)) {
            Some(known) => known.times += 1,
            None => faults.push(TrajectoryFault { fault, event: Some(event), t_s, ..none(sides) }),
        }
    }
    faults
}

/// The event that is latest, and the one that is earliest, beyond what the samples leave open and
/// what is allowed.
fn late(sides: &Sides<'_>, allowed: &Allowed, both: &[(Change, Change)]) -> Vec<TrajectoryFault> {
    let counts = both.iter().filter(|(right, own)| {
        let least_s = allowed.event_s.max(own.between_s).max(right.between_s);
        let [a, b] = [right.t_s.min(own.t_s), right.t_s.max(own.t_s)];
        let place = |t_s: f64| sides.t_s.partition_point(|t| *t < t_s);
        let [of_range, of_tolerance] = LATE_SHOWS;
        let least_rad = (of_range * sides.right.range_rad()).min(of_tolerance * allowed.theta_rad);
        let least_rad = least_rad.max(sides.unseen_rad());
        // Until the next event: a lever breaks loose slowly.
        b - a > least_s && sides.most_apart_rad(place(a), right.around[1].max(place(b))) > least_rad
    });
    let counts: Vec<(f64, &Change)> =
        counts.map(|(right, own)| (own.t_s - right.t_s, right)).collect();
    let worst = [1.0, -1.0].map(|sign| {
        let these = || counts.iter().filter(|(late_s, _)| sign * late_s > 0.0);
        // Of equally late ones the first: the others follow from it.
        let (late_s, right) = these()
            .reduce(|most, next| if sign * (next.0 - most.0) > SAME_S { next } else { most })?;
        Some(TrajectoryFault {
            fault: if sign > 0.0 { TrajectoryVerdict::Late } else { TrajectoryVerdict::Early },
            event: Some(cause(sides, right)),
            t_s: right.t_s,
            times: these().count(),
            late_s: Some(*late_s),
            ..none(sides)
        })
    });
    worst.into_iter().flatten().collect()
}
