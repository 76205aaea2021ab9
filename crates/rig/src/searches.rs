//! A search of a Z-width test as a sweep, and back: stiffness commanded, swing in response.

use std::collections::BTreeMap;
use zwidth_dynamics::DriveMode;
use zwidth_stability::impedance::{ACTUATOR, Ending, Found, Probe, Tried};
use zwidth_store::{Quantity, Sweep};
use zwidth_study::{IdError, Source};

const MODES: [DriveMode; 3] = [DriveMode::Active, DriveMode::Hybrid, DriveMode::Passive];

/// A search as a sweep of that number; `about` is what its file says of study, device and software.
///
/// # Errors
/// Never: [`ACTUATOR`] is an id.
pub fn search_sweep(
    probe: &Probe,
    found: &Found,
    number: u32,
    source: Source,
    about: BTreeMap<String, String>,
) -> Result<Sweep, IdError> {
    let mut file = about;
    for (key, value) in [
        ("mode", probe.mode.as_str().to_owned()),
        ("push_m", probe.push_m.to_string()),
        ("wall_damping_ns_per_m", probe.damping_ns_per_m.to_string()),
        ("repeat", probe.repeat.to_string()),
        ("ending", found.ending.as_str().to_owned()),
        ("went_on", found.tried.iter().map(|t| if t.goes_on { '1' } else { '0' }).collect()),
    ] {
        file.insert(key.to_owned(), value);
    }
    Ok(Sweep {
        actuator: ACTUATOR.parse()?,
        sweep: number,
        source,
        command: Quantity { name: "wall stiffness".to_owned(), unit: "N/m".to_owned() },
        response: Quantity { name: "swing that goes on".to_owned(), unit: "m".to_owned() },
        t_s: None,
        command_values: found.tried.iter().map(|t| t.stiffness_n_per_m).collect(),
        response_values: found.tried.iter().map(|t| t.swing_m).collect(),
        file,
    })
}

/// The search that a sweep holds.
///
/// # Errors
/// The key of its file that cannot be read.
pub fn search_of(sweep: &Sweep) -> Result<(Probe, Found), &'static str> {
    let key = |name: &'static str| sweep.file.get(name).ok_or(name);
    let number = |name: &'static str| key(name)?.parse::<f64>().map_err(|_| name);
    let mode = key("mode")?;
    let ending = key("ending")?;
    let probe = Probe {
        mode: MODES.into_iter().find(|own| own.as_str() == mode).ok_or("mode")?,
        push_m: number("push_m")?,
        damping_ns_per_m: number("wall_damping_ns_per_m")?,
        repeat: key("repeat")?.parse().map_err(|_| "repeat")?,
    };
    let ending = Ending::ALL.into_iter().find(|own| own.as_str() == ending).ok_or("ending")?;
    // A letter per value.
    let went_on = key("went_on")?;
    if went_on.len() != sweep.command_values.len() {
        return Err("went_on");
    }
    let values = sweep.command_values.iter().zip(&sweep.response_values).zip(went_on.chars());
    let tried = values.map(|((stiffness_n_per_m, swing_m), on)| Tried {
        stiffness_n_per_m: *stiffness_n_per_m,
        swing_m: *swing_m,
        goes_on: on == '1',
    });
    Ok((probe, Found { tried: tried.collect(), ending }))
}
