//! Virtual environments: zones of angle, each with the resisting force u(θ, θ̇) that is demanded
//! of the actuators.
//!
//! A new environment is a new value: spring, damper, sponge, detent, free space, one wall or two.

use serde::{Deserialize, Serialize};

use super::numbers;
use crate::error::{DynamicsError, Result, check, finite, not_negative};

/// The force commanded in a zone; u > 0 resists a push into the object (+θ).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Demand {
    /// u = K (θ − θ_rest) + B θ̇, equation (8).
    Spring {
        /// K_O, N at the lever's end per rad.
        stiffness_n_per_rad: f64,
        /// B_O, N s/rad.
        damping_ns_per_rad: f64,
        /// θ_rest, rad.
        rest_rad: f64,
    },
    /// u = F, the same everywhere.
    Force {
        /// F, N.
        force_n: f64,
    },
    /// All the actuators have, pushing towards −θ: a wall.
    Full,
    /// All the actuators have, pushing towards +θ: a wall below.
    FullUp,
}

/// A zone reaches from its angle to the next zone's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Where it begins, rad; the first zone extends down without end, whatever this value is.
    #[serde(default)]
    pub from_rad: f64,
    /// The force that is commanded.
    pub demand: Demand,
}

/// Zones in order of angle, at least one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// What a listing calls it, for instance `spring_wall`.
    pub name: String,
    /// The zones, lowest first.
    pub zones: Vec<Zone>,
}

impl Environment {
    /// A spring of stiffness K_O (N/rad) and damping B_O (N s/rad) that rests at `rest_rad`.
    pub fn spring(stiffness_n_per_rad: f64, damping_ns_per_rad: f64, rest_rad: f64) -> Self {
        let demand = Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, rest_rad };
        Self { name: "spring".to_owned(), zones: vec![Zone { from_rad: 0.0, demand }] }
    }

    /// A constant force, N.
    pub fn force(force_n: f64) -> Self {
        let demand = Demand::Force { force_n };
        Self { name: "force".to_owned(), zones: vec![Zone { from_rad: 0.0, demand }] }
    }

    /// Nothing is rendered.
    pub fn free() -> Self {
        Self { name: "free".to_owned(), ..Self::spring(0.0, 0.0, 0.0) }
    }

    /// The same with a wall from `wall_rad` on.
    pub fn with_wall(mut self, wall_rad: f64) -> Self {
        self.name.push_str("_wall");
        self.zones.push(Zone { from_rad: wall_rad, demand: Demand::Full });
        self
    }

    /// Adds name, value and usual size of the springs' parameters.
    pub(crate) fn list(&self, list: &mut Vec<(&'static str, f64, f64)>) {
        for zone in &self.zones {
            list.push(("environment.zones.from_rad", zone.from_rad, numbers::HALF_STROKE_RAD));
            match zone.demand {
                Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad } => {
                    let usual =
                        [numbers::OBJECT_STIFFNESS_N_PER_RAD, numbers::OBJECT_DAMPING_NS_PER_RAD];
                    list.push(("environment.zones.stiffness_n_per_rad", k, usual[0]));
                    list.push(("environment.zones.damping_ns_per_rad", b, usual[1]));
                    list.push(("environment.zones.rest_rad", rest_rad, numbers::HALF_STROKE_RAD));
                }
                // A spring of the usual stiffness, pressed through half the usual stroke.
                Demand::Force { force_n } => {
                    let usual_n = numbers::OBJECT_STIFFNESS_N_PER_RAD * numbers::HALF_STROKE_RAD;
                    list.push(("environment.zones.force_n", force_n, usual_n));
                }
                Demand::Full | Demand::FullUp => {}
            }
        }
    }

    pub(crate) fn check(&self) -> Result<()> {
        if self.zones.is_empty() {
            let what = "the environment has no zone";
            let remedy = "give it one, for instance a spring";
            return Err(DynamicsError::Combination { what, remedy });
        }
        for (i, zone) in self.zones.iter().enumerate() {
            let name = format_args!("environment.zones[{i}]");
            finite(format_args!("{name}.from_rad"), zone.from_rad)?;
            match zone.demand {
                Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, rest_rad } => {
                    not_negative(format_args!("{name}.stiffness_n_per_rad"), stiffness_n_per_rad)?;
                    not_negative(format_args!("{name}.damping_ns_per_rad"), damping_ns_per_rad)?;
                    finite(format_args!("{name}.rest_rad"), rest_rad)?;
                }
                Demand::Force { force_n } => finite(format_args!("{name}.force_n"), force_n)?,
                Demand::Full | Demand::FullUp => {}
            }
        }
        // The first zone's angle is not used: it extends down without end.
        for (i, pair) in self.zones.windows(2).enumerate().skip(1) {
            let ordered = pair[0].from_rad < pair[1].from_rad;
            let name = format_args!("environment.zones[{}].from_rad", i + 1);
            check(name, pair[1].from_rad, ordered, "above the zone's before it")?;
        }
        Ok(())
    }
}
