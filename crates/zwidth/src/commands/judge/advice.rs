//! What to change, where that is known: of any program by the fault alone, and in a program's own words
//! where somebody says which it is.

use zwidth_results::{LeverEvent, TrajectoryFault, TrajectoryVerdict};

/// What to change because of a fault; the program's own word for it behind.
pub(super) fn advice(fault: &TrajectoryFault, engine: Option<&str>) -> Option<String> {
    let own = engine.and_then(|engine| of_engine(fault, &engine.to_lowercase()));
    let general = general(fault)?;
    Some(match own {
        Some(own) => format!("{general} {own}"),
        None => general.to_owned(),
    })
}

fn general(fault: &TrajectoryFault) -> Option<&'static str> {
    let text = match fault.fault {
        TrajectoryVerdict::Unstable => {
            "The step is too long for the method: shorten it, or take an implicit method."
        }
        TrajectoryVerdict::BeyondStop => {
            "A stop is a one-sided constraint: let the solver find when it is reached (a signed function that is 0 there), set the velocity to 0, and go on with the lever at the stop as a state of its own; one that gives way must be stiffer."
        }
        TrajectoryVerdict::Reset if fault.to_zero => {
            "Behind the event every value is 0: return the whole state where the event is handled."
        }
        TrajectoryVerdict::Reset => "Look at what the handler of an event does to the state.",
        TrajectoryVerdict::Missed if fault.event == Some(LeverEvent::BrokeLoose) => {
            "Look at the static friction and at what ends the rest; floats of four bytes round small motions away."
        }
        TrajectoryVerdict::Missed => {
            "Let the solver look for the event by a function that changes its sign there, and take steps that are shorter than what it is to find."
        }
        TrajectoryVerdict::Extra => {
            "Look at what ends a rest or turns the lever round: static friction, a threshold, a stop that gives back energy."
        }
        TrajectoryVerdict::Chatters => {
            "A force that switches on the sign of the velocity cannot hold a lever: let rest be a state of its own, or solve for the friction within the step."
        }
        TrajectoryVerdict::Creeps => {
            "Dry friction or a stop that is smoothed (a force that grows with the velocity) never holds: give friction as a constraint with a bound; a smaller step alone does not help."
        }
        TrajectoryVerdict::Late => {
            "Let the solver find the event within its step (a root finder on a signed function); a smaller step makes it less late."
        }
        TrajectoryVerdict::Early => {
            "Look at the threshold of the event, and whether it is looked at before the step that reaches it."
        }
        TrajectoryVerdict::EnergyMade | TrajectoryVerdict::EnergyLost => {
            "Take a smaller step, or a method that keeps energy, and evaluate forces at the time of the state that they act on."
        }
        TrajectoryVerdict::Inaccurate => {
            "Take a smaller step or tolerance, and compare the parameters: the mass is felt at the lever's end, so that the inertia is M L²."
        }
        TrajectoryVerdict::Unproven | TrajectoryVerdict::Stands | TrajectoryVerdict::Right => {
            return None;
        }
    };
    Some(text)
}

/// What is known of a program; its name is in small letters.
fn of_engine(fault: &TrajectoryFault, engine: &str) -> Option<&'static str> {
    let is = |name: &str| engine.contains(name);
    match fault.fault {
        TrajectoryVerdict::Creeps if is("mujoco") => Some(
            "MuJoCo: set noslip_iterations in <option>; its constraints are soft, whatever the time step.",
        ),
        TrajectoryVerdict::BeyondStop if is("mujoco") => {
            Some("MuJoCo: solreflimit and solimplimit of the joint say how stiff its limit is.")
        }
        TrajectoryVerdict::Creeps if is("bullet") => Some(
            "PyBullet: give the friction as the force of the joint's motor in VELOCITY_CONTROL with targetVelocity 0.",
        ),
        TrajectoryVerdict::Creeps | TrajectoryVerdict::Extra if is("newton") => Some(
            "Newton: not every solver of its knows the friction of joints; take one that does.",
        ),
        TrajectoryVerdict::Late if is("diffrax") => Some(
            "diffrax: give Event a root_finder; without one the solve ends at the end of the step.",
        ),
        TrajectoryVerdict::Missed if is("diffrax") || is("jax") || is("mjx") => {
            Some("JAX: it computes with floats of four bytes unless jax_enable_x64 is set.")
        }
        TrajectoryVerdict::Missed | TrajectoryVerdict::BeyondStop | TrajectoryVerdict::Extra
            if is("scipy") =>
        {
            Some(
                "SciPy: an event's function must change its sign, as theta - stop does and max(0, theta - stop) does not.",
            )
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_s_own_words_stand_behind_the_general_ones_only_where_it_is_named() {
        let creeps = fault(TrajectoryVerdict::Creeps);
        let plain = advice(&creeps, None).unwrap();
        assert!(!plain.contains("noslip"), "{plain}");
        let named = advice(&creeps, Some("MuJoCo 3.9")).unwrap();
        assert!(named.starts_with(&plain) && named.contains("noslip_iterations"), "{named}");
        assert_eq!(advice(&creeps, Some("my own loop")).unwrap(), plain);
        assert_eq!(advice(&fault(TrajectoryVerdict::Right), Some("mujoco")), None);
    }

    fn fault(fault: TrajectoryVerdict) -> TrajectoryFault {
        TrajectoryFault {
            scene: "s".into(),
            trajectory: "t".into(),
            fault,
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
}
