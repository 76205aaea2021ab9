//! What calibration and masses say about the thesis' statements.

use crate::evidence::{Derived, Place, Stop, Verdict};
use crate::gallery::Shown;
use crate::thesis::estimate::{Estimated, Spread, mean};
use crate::thesis::judged::{condition, judged, not_measured, people, trials, unjudged};
use crate::thesis::rule::{Case, FORCE_JND, From, Quantity, Range};
use crate::weight::{RATED_V, masses_g};
use zwidth_results::JudgedStatement;
use zwidth_study::{Basis, ModeLaw};

/// Voltage of the thesis' motor alone, V, and its force there, N (§4.2, §5.3.2.1).
const MOTOR: (f64, f64) = (16.0, 4.16);

pub(crate) const WALL_FORCE: Quantity = Quantity {
    words: "largest force past the wall",
    from: From::Metrics,
    column: "wall_force_max_n",
    less: None,
    unit: "N",
};

/// The brake alone at the wall: it is what held.
const HELD: Case = (ModeLaw::Passive, Place::Wall);

/// The motor's force at the thesis' 16 V, N, by this study's own calibration.
fn motor_n(derived: &Derived) -> Result<f64, Stop> {
    let (_, mode) = condition(derived.known, (ModeLaw::Active, Place::Wall))?;
    if derived.basis == Basis::Thesis {
        return not_measured("motor and brake of this study were not both swept");
    }
    match mode.motor_max_v {
        Some(v) if (v - MOTOR.0).abs() < 1e-9 => Ok(derived.known.calibration.motor.force_n(v)),
        _ => not_measured("this study's motor is not used at the thesis' 16 V"),
    }
}

/// The motor's force at its rated voltage, N: it goes with the voltage.
fn rated_n(derived: &Derived) -> Result<f64, Stop> {
    Ok(motor_n(derived)? * RATED_V / MOTOR.0)
}

/// The brake's force at its highest voltage, N.
fn brake_n(derived: &Derived) -> Result<f64, Stop> {
    let (_, mode) = condition(derived.known, HELD)?;
    match mode.brake_max_v {
        Some(v) => Ok(derived.known.calibration.brake.force_n(v)),
        None => not_measured("the brake's voltage is not known"),
    }
}

/// One number of the calibration, or of the study's plan, which has no interval.
fn single(
    metric: &str,
    value: f64,
    unit: &str,
    supported: bool,
    required: String,
) -> JudgedStatement {
    JudgedStatement {
        verdict: Verdict::of(supported),
        metric: Some(metric.to_owned()),
        value: Some(value),
        unit: Some(unit.to_owned()),
        asked: Some(required.into()),
        remark: Some("no interval: one number, not a mean".into()),
        ..unjudged()
    }
}

/// The motor's at its highest voltage is that of the thesis.
pub(crate) fn motor_as_in_the_thesis(derived: &Derived) -> Result<JudgedStatement, Stop> {
    let force_n = motor_n(derived)?;
    let [low, high] = [1.0 - FORCE_JND, 1.0 + FORCE_JND].map(|share| share * MOTOR.1);
    let why = "7 %, the just noticeable difference (Pang 1991)";
    let required = format!("{low:.2} to {high:.2}\u{a0}N: {why}");
    let is_same = low < force_n && force_n < high;
    let judged = single("motor's force at 16 V, calibrated", force_n, "N", is_same, required);
    Ok(JudgedStatement { shown: Some(derived.gallery.file(&Shown::Forces)), ..judged })
}

/// The motor's at its rated voltage is below the brake's.
pub(crate) fn below_brake(derived: &Derived) -> Result<JudgedStatement, Stop> {
    let motor = rated_n(derived)?;
    let brake = brake_n(derived)?;
    let required = format!("below {brake:.2}\u{a0}N: the brake's at its highest voltage");
    let words = "motor's force at 48 V, by the voltage";
    let judged = single(words, motor, "N", motor < brake, required);
    Ok(JudgedStatement { shown: Some(derived.gallery.file(&Shown::Forces)), ..judged })
}

/// The motor's at its rated voltage is below what people put on a wall that held.
pub(crate) fn below_wall(derived: &Derived) -> Result<JudgedStatement, Stop> {
    let low = rated_n(derived)?;
    let (environment, _) = condition(derived.known, HELD)?;
    let Some(estimated) = mean(&people(derived, HELD, WALL_FORCE)?, derived.level) else {
        return not_measured("no trial has a force past the wall");
    };
    let why = "what the motor would give at 48 V; up to that it would hold";
    let range = Range { low, high: f64::INFINITY, why };
    let judged = judged(WALL_FORCE, &estimated, &range, derived.known.study.coordinate);
    let shown = derived.gallery.file(&Shown::Modes(environment.id.clone()));
    Ok(JudgedStatement { shown: Some(shown), ..judged })
}

/// The largest of all that people put on the wall stays below the brake's.
pub(crate) fn wall_below_brake(derived: &Derived) -> Result<JudgedStatement, Stop> {
    let brake = brake_n(derived)?;
    let trials = trials(derived, HELD, From::Metrics)?;
    let forces = trials.floats(WALL_FORCE.column)?;
    let Some(most) = forces.iter().copied().reduce(f64::max) else {
        return not_measured("no trial has a force past the wall");
    };
    // A largest value has no interval: it is judged as it stands.
    let largest =
        Estimated { value: most, spread: Spread::Equal, n: forces.len(), over: trials.whose() };
    let why = "the brake's at its highest voltage, calibrated";
    let range = Range { low: f64::NEG_INFINITY, high: brake, why };
    Ok(JudgedStatement {
        remark: Some("no interval: the largest of all trials".into()),
        shown: Some(derived.gallery.file(&Shown::Metrics)),
        ..judged(WALL_FORCE, &largest, &range, derived.known.study.coordinate)
    })
}

/// Brake and a motor of the size that is used are lighter than the motor.
pub(crate) fn weight(derived: &Derived) -> Result<JudgedStatement, Stop> {
    let Some([hybrid, motor]) = masses_g(derived.known.study) else {
        return not_measured(
            "the study gives no masses of motor and brake, or has no mode with both",
        );
    };
    let required = format!("below {motor:.0}\u{a0}g: the motor's");
    let words = "mass of the brake and a motor of the size that is used";
    let remark = "if a motor's force goes with its volume; transmission and housing left out";
    Ok(JudgedStatement {
        remark: Some(remark.into()),
        shown: Some(derived.gallery.file(&Shown::Weight)),
        ..single(words, hybrid, "g", hybrid < motor, required)
    })
}
