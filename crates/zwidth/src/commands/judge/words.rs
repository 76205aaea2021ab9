//! A judgement in sentences: degrees, milliseconds.

use super::advice::advice;
use zwidth_judge::{Allowed, Judged, Yardstick};
use zwidth_results::{JudgedTrajectory, TrajectoryFault, TrajectoryVerdict};

/// What a person wants to know of a trajectory.
pub(super) fn lines(
    judged: &Judged,
    yardstick: &Yardstick,
    allowed: &Allowed,
    converted: &[String],
    verbose: bool,
) -> Vec<String> {
    let t = &judged.trajectory;
    let mut lines = vec![format!("{} ({}): {}", t.trajectory, t.scene, verdict(t, allowed))];
    for fault in &judged.faults {
        lines.push(format!("  {}", fault_words(fault)));
        lines.extend(advice(fault, t.engine.as_deref()).map(|text| format!("    {text}")));
    }
    lines.push(format!(
        "  θ is off by at most {} (root mean square {}), θ̇ by at most {}/s, the device's force by at most {:.3} N",
        degrees(t.theta_error_max_rad),
        degrees(t.theta_error_rms_rad),
        degrees(t.theta_dot_error_max_rad_s),
        t.force_error_max_n,
    ));
    lines
        .extend(t.event_error_s.map(|late_s| {
            format!("  events that happen in both are at most {} apart", ms(late_s))
        }));
    let felt = if t.is_felt { "can" } else { "cannot" };
    let vibration = t
        .felt_vibration_share
        .map_or("cannot be compared".to_owned(), |share| format!("{share:.2}"));
    lines.push(format!(
        "  a person {felt} tell it from the right motion: of what is just felt, force {:.2}, angle {:.2}, vibration {vibration}",
        t.felt_force_share, t.felt_angle_share
    ));
    if let Some(creep) =
        t.creep_rad_s.filter(|creep| creep.abs() < allowed.creep_rad_s && *creep != 0.0)
    {
        lines.push(format!(
            "  where the lever is held it moves by {}/s, which counts as none",
            degrees(creep)
        ));
    }
    if let (Some(residual), Some(bound)) = (t.energy_residual_j, t.energy_bound_j) {
        lines.push(format!("  energy that no force gave: {residual:.2e} J, of which the sampling may make {bound:.1e} J"));
    }
    if let Some(error) = t.input_error_max_n.filter(|error| *error > 1e-6) {
        lines.push(format!("  the user's force in the file differs from the scene's by up to {error:.3e} N: is it the same input?"));
    }
    let how = if t.velocity_computed { ", velocities computed from the angles" } else { "" };
    lines.push(format!(
        "  {} samples, one every {}, angles in steps of {:.1e}°{how}",
        t.samples,
        ms(t.step_s),
        t.theta_resolution_rad.to_degrees()
    ));
    let apart =
        yardstick.apart_rad.map_or("an unknown angle".to_owned(), |rad| format!("{rad:.1e} rad"));
    lines.push(format!(
        "  the right answer is {}: {} and {} differ by {apart}",
        t.yardstick.as_str(),
        t.by,
        yardstick.against
    ));
    if verbose {
        lines.extend(converted.iter().map(|line| format!("  {line}")));
    }
    lines
}

fn verdict(t: &JudgedTrajectory, allowed: &Allowed) -> String {
    match t.verdict {
        TrajectoryVerdict::Right => format!("right within {}", degrees(t.theta_error_max_rad)),
        TrajectoryVerdict::Stands => {
            format!("stands, right within {}", degrees(t.theta_error_max_rad))
        }
        TrajectoryVerdict::Unproven => {
            "unproven: two solvers do not agree on the right answer, and nothing is said against it"
                .to_owned()
        }
        TrajectoryVerdict::Inaccurate => {
            format!("inaccurate: off by more than {}", degrees(allowed.theta_rad))
        }
        other => other.as_str().to_owned(),
    }
}

/// A fault with its sizes.
fn fault_words(fault: &TrajectoryFault) -> String {
    let at = format!("{:.6} s", fault.t_s);
    let event = fault.event.map_or("", |event| event.as_str());
    let times = if fault.times > 1 { format!(", {} times", fault.times) } else { String::new() };
    let angle = fault.theta_rad.map_or(String::new(), degrees);
    match fault.fault {
        TrajectoryVerdict::Unstable => format!(
            "its error grows by a factor of e every {}, and is too large from {at} on",
            ms(1.0 / fault.growth_per_s.unwrap_or(f64::NAN))
        ),
        TrajectoryVerdict::BeyondStop => {
            format!("it goes beyond the stop by {angle}, from {at} on")
        }
        TrajectoryVerdict::Reset => {
            let theta = fault.theta_rad.map(|rad| format!("θ by {}", degrees(rad)));
            let omega = fault.theta_dot_rad_s.map(|rad_s| format!("θ̇ by {}/s", degrees(rad_s)));
            let which: Vec<String> = [theta, omega].into_iter().flatten().collect();
            let zero = if fault.to_zero { ", to 0" } else { "" };
            format!("the state jumps just before {at}: {}{zero}{times}", which.join(" and "))
        }
        TrajectoryVerdict::Missed => format!("missed at {at}: {event}{times}"),
        TrajectoryVerdict::Extra => {
            format!("at {at}: {event}, which does not happen in the scene{times}")
        }
        TrajectoryVerdict::Chatters => format!(
            "it makes {} swings that the scene does not have, half of one {angle}, at {:.1} Hz",
            fault.times,
            fault.frequency_hz.unwrap_or(f64::NAN)
        ),
        TrajectoryVerdict::Creeps => format!(
            "it moves on steadily at {}/s where the lever is held, from {at} on{times}",
            degrees(fault.creep_rad_s.unwrap_or(f64::NAN))
        ),
        TrajectoryVerdict::Late | TrajectoryVerdict::Early => {
            let late_s = fault.late_s.unwrap_or(f64::NAN);
            let way = if late_s > 0.0 { "late" } else { "early" };
            format!("{event}, at {at}, comes {} {way}{times}", ms(late_s.abs()))
        }
        TrajectoryVerdict::EnergyMade => {
            format!("it gains {:.3e} J that no force gives", fault.energy_j.unwrap_or(f64::NAN))
        }
        TrajectoryVerdict::EnergyLost => {
            format!("it loses {:.3e} J that no force takes", -fault.energy_j.unwrap_or(f64::NAN))
        }
        TrajectoryVerdict::Inaccurate => format!("θ is off by {angle} at {at}"),
        TrajectoryVerdict::Unproven | TrajectoryVerdict::Stands | TrajectoryVerdict::Right => {
            String::new()
        }
    }
}

/// An angle in degrees, to four digits.
pub(in super::super) fn degrees(rad: f64) -> String {
    let degrees = rad.to_degrees();
    if degrees != 0.0 && degrees.abs() < 1e-3 {
        format!("{degrees:.2e}°")
    } else {
        format!("{degrees:.4}°")
    }
}

/// A time in milliseconds.
fn ms(s: f64) -> String {
    let ms = 1e3 * s;
    if ms != 0.0 && ms < 1e-3 { format!("{ms:.1e} ms") } else { format!("{ms:.4} ms") }
}
