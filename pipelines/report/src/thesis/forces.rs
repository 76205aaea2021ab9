//! What calibration and masses say about the thesis' statements.

use crate::evidence::{Evidence, Verdict};
use crate::gallery::Shown;
use crate::thesis::estimate::{Estimated, Spread, mean, trials_of};
use crate::thesis::judged::{Derived, Judged, Stop, condition, judged, people, trials};
use crate::thesis::rule::{Case, FORCE_JND, Force, From, Place, Quantity, Range};
use crate::weight::{RATED_V, masses_g};
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

pub(crate) fn judge(force: Force, derived: &Derived) -> Result<Judged, Stop> {
    match force {
        Force::OfMotor => motor_as_in_the_thesis(derived),
        Force::BelowBrake => below_brake(derived),
        Force::BelowWall => below_wall(derived),
        Force::WallBelowBrake => wall_below_brake(derived),
        Force::Weight => weight(derived),
    }
}

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

/// The brake's force at its highest voltage, N.
fn brake_n(derived: &Derived) -> Result<f64, Stop> {
    let (_, mode) = condition(derived.known, HELD)?;
    match mode.brake_max_v {
        Some(v) => Ok(derived.known.calibration.brake.force_n(v)),
        None => not_measured("the brake's voltage is not known"),
    }
}

fn not_measured<T>(why: &str) -> Result<T, Stop> {
    Err(Stop::NotMeasured(why.to_owned()))
}

/// One number of the calibration, or of the study's plan, which has no interval.
fn single(
    metric: &str,
    value: f64,
    unit: &str,
    verdict: Verdict,
    required: String,
    shown: Shown,
) -> Judged {
    Judged {
        evidence: Evidence {
            metric: metric.to_owned(),
            value: Some(value),
            unit: unit.to_owned(),
            remark: "no interval: one number, not a mean".to_owned(),
            verdict,
        },
        required,
        interval: None,
        n: None,
        over: String::new(),
        shown,
    }
}

fn motor_as_in_the_thesis(derived: &Derived) -> Result<Judged, Stop> {
    let force_n = motor_n(derived)?;
    let [low, high] = [1.0 - FORCE_JND, 1.0 + FORCE_JND].map(|share| share * MOTOR.1);
    let why = "7 %, the just noticeable difference (Pang 1991)";
    let required = format!("{low:.2} to {high:.2}\u{a0}N: {why}");
    let verdict = Verdict::of(low < force_n && force_n < high);
    let words = "motor's force at 16 V, calibrated";
    Ok(single(words, force_n, "N", verdict, required, Shown::Forces))
}

/// The motor's force at its rated voltage, N: it goes with the voltage.
fn rated_n(derived: &Derived) -> Result<f64, Stop> {
    Ok(motor_n(derived)? * RATED_V / MOTOR.0)
}

fn below_brake(derived: &Derived) -> Result<Judged, Stop> {
    let motor = rated_n(derived)?;
    let brake = brake_n(derived)?;
    let required = format!("below {brake:.2}\u{a0}N: the brake's at its highest voltage");
    let words = "motor's force at 48 V, by the voltage";
    Ok(single(words, motor, "N", Verdict::of(motor < brake), required, Shown::Forces))
}

/// Whether what people put on the wall that held is more than the motor would give.
fn below_wall(derived: &Derived) -> Result<Judged, Stop> {
    let low = rated_n(derived)?;
    let (environment, _) = condition(derived.known, HELD)?;
    let Some(estimated) = mean(&people(derived, HELD, WALL_FORCE)?, derived.level) else {
        return not_measured("no trial has a force past the wall");
    };
    let why = "what the motor would give at 48 V; up to that it would hold".to_owned();
    let range = Range { low, high: f64::INFINITY, why };
    let shown = Shown::Modes(environment.id.clone());
    Ok(judged(WALL_FORCE, &estimated, &range, derived.known.study.coordinate, shown))
}

/// Whether the largest of all trials' forces on the wall is below the brake's.
fn wall_below_brake(derived: &Derived) -> Result<Judged, Stop> {
    let brake = brake_n(derived)?;
    let trials = trials(derived, HELD, From::Metrics)?;
    let forces = trials.floats(WALL_FORCE.column)?;
    let Some(most) = forces.iter().copied().reduce(f64::max) else {
        return not_measured("no trial has a force past the wall");
    };
    let people = trials.participants();
    let coordinate = derived.known.study.coordinate;
    let over = match people.first() {
        Some(who) if people.len() == 1 => trials_of(who),
        _ => format!("trials of {} participants", people.len()),
    };
    // A largest value has no interval: it is judged as it stands.
    let largest = Estimated { value: most, spread: Spread::Equal, n: forces.len(), over };
    let why = "the brake's at its highest voltage, calibrated".to_owned();
    let range = Range { low: f64::NEG_INFINITY, high: brake, why };
    let judged = judged(WALL_FORCE, &largest, &range, coordinate, Shown::Metrics);
    let remark = "no interval: the largest of all trials".to_owned();
    Ok(Judged { evidence: Evidence { remark, ..judged.evidence }, ..judged })
}

fn weight(derived: &Derived) -> Result<Judged, Stop> {
    let Some([hybrid, motor]) = masses_g(derived.known.study) else {
        return not_measured(
            "the study gives no masses of motor and brake, or has no mode with both",
        );
    };
    let required = format!("below {motor:.0}\u{a0}g: the motor's");
    let words = "mass of the brake and a motor of the size that is used";
    let judged = single(words, hybrid, "g", Verdict::of(hybrid < motor), required, Shown::Weight);
    let remark = "if a motor's force goes with its volume; transmission and housing left out";
    Ok(Judged { evidence: Evidence { remark: remark.to_owned(), ..judged.evidence }, ..judged })
}
