//! The answer, and its grounds.

use super::course::{Loop, SwingCourse, scene, slow_part};
use super::recorded::{RecordedSwings, bound_rad, swings};
use crate::scene::{Parameters, Rendering};
use crate::{Drive, ReplayError, WhyNot};
use zwidth_dynamics::{Exact, Model, MoreauJean, Reference, RunVerdict, TickedLoop, Trajectory};
use zwidth_numerics::series::{central_differences, interpolate_all};
use zwidth_store::Trial;
use zwidth_study::{Study, worded};

/// A cycle of fewer ticks than this may be one that is faster than half the ticks' rate.
const TICKS_A_CYCLE: f64 = 4.0;
/// The model's swing is the recorded one where it is at least a third as large …
const SIZE: f64 = 1.0 / 3.0;
/// … its frequency is the recorded one to this factor …
const SPEED: f64 = 1.5;
/// … and it has at least half as many swings: one that merely dies out has fewer.
const LASTS: usize = 2;
/// Beyond this |cos φ| the user's force feeds the swing, or is fed by it; below it the force
/// sensor's delay decides the sign.
const PHASE: f64 = 0.1;
/// Shares of a tick that `moreau_jean` takes as steps: one, halved twice.
const STEPS: [f64; 3] = [0.25, 0.125, 0.0625];
/// Samples per tick of a run of `exact`.
const SAMPLES: f64 = 4.0;

/// Where an oscillation comes from, or why this is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// There is no oscillation above the resolution.
    None,
    /// The loop of device and controller keeps it up.
    Loop,
    /// The user's force does.
    User,
    /// Fewer than four ticks in a cycle: a faster swing looks like it.
    TooFewTicks,
    /// What a model of the loop needs was not recorded.
    NoModel(WhyNot),
    /// The model failed, or two solvers do not agree on it.
    NotKnown,
    /// The model does not swing like this, with the user's force or without its fast part.
    NotReproduced,
    /// The model swings by itself, and yet the user's force feeds the recorded swing.
    BothCould,
    /// The model swings by the user's force alone, and yet the recorded swing feeds the user.
    NeitherCould,
}

worded! {
    /// The answer in one word.
    SwingAnswer {
        /// Nothing oscillates.
        Calm = "no oscillation",
        /// The device's own.
        Real = "real",
        /// The user's.
        Forced = "forced by the user",
        /// It cannot be told.
        CannotTell = "cannot tell",
    }
}

impl Origin {
    /// The answer.
    pub fn answer(self) -> SwingAnswer {
        match self {
            Self::None => SwingAnswer::Calm,
            Self::Loop => SwingAnswer::Real,
            Self::User => SwingAnswer::Forced,
            _ => SwingAnswer::CannotTell,
        }
    }

    /// Why, in words.
    pub fn why(self) -> String {
        match self {
            Self::None => "fewer than six swings in a row are above the resolution".to_owned(),
            Self::Loop => {
                "the loop of device and controller keeps it up without the fast part of the user's force".to_owned()
            }
            Self::User => "the loop swings with the user's force, and without its fast part it does not".to_owned(),
            Self::TooFewTicks => "fewer than four ticks in a cycle: a faster swing looks like it".to_owned(),
            Self::NoModel(why) => format!("the loop cannot be run again: {why}"),
            Self::NotKnown => "the model's own motion is not known: it failed, or two solvers disagree".to_owned(),
            Self::NotReproduced => {
                "the model does not swing like this: what makes the swing is not in it".to_owned()
            }
            Self::BothCould => {
                "the model swings by itself, and yet the user's force feeds the recorded swing".to_owned()
            }
            Self::NeitherCould => {
                "the model swings by the user's force alone, and yet the recorded swing feeds the user".to_owned()
            }
        }
    }
}

/// The oscillation of one trial, and its judgement.
#[derive(Debug, Clone, PartialEq)]
pub struct Oscillation {
    /// Its origin.
    pub origin: Origin,
    /// Half the peak-to-peak angle from which on a swing exists, rad.
    pub bound_rad: f64,
    /// The recorded oscillation.
    pub recorded: Option<RecordedSwings>,
    /// The oscillation of the model with the user's force, where and when it was recorded.
    pub with_force: Option<RecordedSwings>,
    /// The oscillation of the model with the slow part of the user's force, from when the swings
    /// begin.
    pub alone: Option<RecordedSwings>,
    /// Sizes of the model's swings alone by `moreau_jean`, at a quarter of a tick, half and a
    /// quarter of that, rad; 0 where it does not swing.
    pub stepped_rad: [f64; 3],
    /// The nature of the model's motion alone, by its reference.
    pub nature: Option<RunVerdict>,
    /// cos φ: above 0 the fast part of the user's force feeds the swing.
    pub power_factor: Option<f64>,
    /// θ as recorded, of the model with the user's force, and with its slow part alone.
    pub courses: Vec<SwingCourse>,
}

impl Oscillation {
    fn without_model(origin: Origin, bound_rad: f64, recorded: Option<RecordedSwings>) -> Self {
        Self {
            origin,
            bound_rad,
            recorded,
            with_force: None,
            alone: None,
            stepped_rad: [0.0; 3],
            nature: None,
            power_factor: None,
            courses: Vec::new(),
        }
    }
}

/// Whether the oscillation of a trial is the device's own.
///
/// # Errors
/// Columns of unequal length, or parameters that make no model; what merely was not recorded is an
/// [`Origin`].
pub fn oscillation(
    trial: &Trial,
    study: &Study,
    rendering: &Rendering,
    plant: &Parameters,
) -> Result<Oscillation, ReplayError> {
    let drive = match Drive::new(trial, rendering) {
        Err(ReplayError::WhyNot(why)) => {
            return Ok(Oscillation::without_model(Origin::NoModel(why), 0.0, None));
        }
        other => other?,
    };
    let course = drive.recorded();
    let bound_rad = bound_rad(course, &study.analysis);
    let all_s = [f64::NEG_INFINITY, f64::INFINITY];
    let without = |origin, recorded| Ok(Oscillation::without_model(origin, bound_rad, recorded));
    let Some(recorded) = swings(&course.t_s, &course.theta_rad, bound_rad, all_s) else {
        return without(Origin::None, None);
    };
    let ticks = (course.t_s.len() - 1) as f64;
    let tick_s = course.t_s[course.t_s.len() - 1] / ticks; // recorded ticks are not quite even
    if recorded.period_s() < TICKS_A_CYCLE * tick_s {
        return without(Origin::TooFewTicks, Some(recorded));
    }
    let controller = match Loop::of(study, rendering, trial, &drive, plant) {
        Err(why) => return without(Origin::NoModel(why), Some(recorded)),
        Ok(controller) => controller,
    };
    let slow_n = slow_part(&course.t_s, &course.force_ex_n, recorded.period_s());
    // What begins a swing may be a quick push, and friction holds a lever that is pushed slowly.
    let forces = course.t_s.iter().zip(course.force_ex_n.iter().zip(&slow_n));
    let kicked_n: Vec<f64> = forces
        .map(|(t, (force, slow))| if *t < recorded.from_s { *force } else { *slow })
        .collect();
    let scene = scene(&drive, plant);
    let [with_force, alone] = [&course.force_ex_n, &kicked_n].map(|force_n| {
        let ticks = (course.t_s.clone(), force_n.clone());
        TickedLoop::new(scene.clone(), ticks, controller.clone())
    });
    let with_force = with_force?;
    let alone = alone?;
    let runs =
        [&with_force, &alone].map(|model| model.run(&Exact::default(), tick_s / SAMPLES).ok());
    let [Some(run_with), Some(run_alone)] = runs else {
        return without(Origin::NotKnown, Some(recorded));
    };
    let seen_in = |run: &Trajectory| seen(run, &course.t_s, &recorded, bound_rad);
    let judged = Reference::of(&alone).judge(&MoreauJean::default(), STEPS[0] * tick_s);
    let power_factor = power_factor(&drive, &slow_n, &recorded)?;
    let mut all = Oscillation {
        with_force: seen_in(&run_with),
        alone: seen_in(&run_alone),
        stepped_rad: STEPS.map(|share| -> f64 {
            let run = alone.run(&MoreauJean::default(), share * tick_s);
            run.ok().and_then(|run| seen_in(&run)).map_or(0.0, |swings| swings.amplitude_rad)
        }),
        nature: judged.reference.map(|reference| reference.nature),
        power_factor,
        courses: vec![
            SwingCourse { t_s: course.t_s.clone(), theta_rad: course.theta_rad.clone() },
            course_of(&run_with),
            course_of(&run_alone),
        ],
        ..Oscillation::without_model(Origin::NotKnown, bound_rad, Some(recorded))
    };
    all.origin = origin(&all, &recorded);
    Ok(all)
}

/// The origin of the recorded swings, from everything else that is known of them.
pub(super) fn origin(all: &Oscillation, recorded: &RecordedSwings) -> Origin {
    let cos_phi = all.power_factor.unwrap_or(0.0);
    if resembles(all.alone, recorded) {
        // A swing of the model's is one that another solver has too, at its finest step.
        let persists = all.stepped_rad[2] >= SIZE * recorded.amplitude_rad;
        return match (all.nature.is_some() && persists, cos_phi > PHASE) {
            (false, _) => Origin::NotKnown,
            (true, true) => Origin::BothCould,
            (true, false) => Origin::Loop,
        };
    }
    match (resembles(all.with_force, recorded), cos_phi < -PHASE) {
        (true, false) => Origin::User,
        (true, true) => Origin::NeitherCould,
        (false, _) => Origin::NotReproduced,
    }
}

/// Whether a model swings, and like the recording.
fn resembles(model: Option<RecordedSwings>, recorded: &RecordedSwings) -> bool {
    model.is_some_and(|model| {
        let faster = model.frequency_hz / recorded.frequency_hz;
        model.amplitude_rad >= SIZE * recorded.amplitude_rad
            && LASTS * model.swings >= recorded.swings
            && (1.0 / SPEED..=SPEED).contains(&faster)
    })
}

/// The oscillation of a run about when it was recorded, a period either way; at the recording's
/// samples, so that what lies between them is as little seen.
fn seen(
    run: &Trajectory,
    t_s: &[f64],
    recorded: &RecordedSwings,
    bound_rad: f64,
) -> Option<RecordedSwings> {
    let all_rad: Vec<f64> = run.theta_rad().collect();
    let last_rad = all_rad.last().copied().unwrap_or(0.0);
    let at = interpolate_all(&run.t_s, &all_rad, t_s).into_iter();
    let theta_rad: Vec<f64> = at.map(|theta| theta.unwrap_or(last_rad)).collect();
    let period_s = recorded.period_s();
    let within_s = [recorded.from_s - period_s, recorded.to_s + period_s];
    swings(t_s, &theta_rad, bound_rad, within_s)
}

fn course_of(run: &Trajectory) -> SwingCourse {
    SwingCourse { t_s: run.t_s.clone(), theta_rad: run.theta_rad().collect() }
}

/// cos φ of the fast parts of force and velocity over the recorded swings; `None` where either is
/// 0.
fn power_factor(
    drive: &Drive,
    slow_n: &[f64],
    recorded: &RecordedSwings,
) -> Result<Option<f64>, ReplayError> {
    let course = drive.recorded();
    let rate = central_differences(&course.t_s, &course.theta_rad)?;
    let slow_rate = slow_part(&course.t_s, &rate, recorded.period_s());
    let mut fv = 0.0;
    let mut ff = 0.0;
    let mut vv = 0.0;
    for (i, t) in course.t_s.iter().enumerate() {
        if (recorded.from_s..=recorded.to_s).contains(t) {
            let f = course.force_ex_n[i] - slow_n[i];
            let v = rate[i] - slow_rate[i];
            fv += f * v;
            ff += f * f;
            vv += v * v;
        }
    }
    let scale = (ff * vv).sqrt();
    Ok((scale > 0.0).then(|| fv / scale))
}
