//! The parts of the plant. A term that is `None` is left out: it gets no region, no event and no
//! exponential.

use serde::{Deserialize, Serialize};

use crate::error::{Result, check, finite, not_negative, positive};
use crate::scene::friction::Friction;

/// Plant, drive and hand. Forces, masses and damping are those felt at the lever's end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrivenParameters {
    /// J: moment of inertia of all that turns with the lever, about its axis, kg m².
    pub inertia_kg_m2: f64,
    /// L: lever length, m.
    pub lever_m: f64,
    /// Where the mechanical stops are, rad, lower first; inelastic.
    pub stops_rad: Option<[f64; 2]>,
    /// Dry and viscous friction of the capstan.
    pub friction: Option<Friction>,
    /// b_e: damping by the motor's own voltage, (N k_t)²/(R L), N s/rad. It is there at every
    /// command, because a voltage driver keeps the winding closed, also at 0 V (assumed; a
    /// driver that opens it has none).
    pub back_emf_ns_per_rad: Option<f64>,
    /// τ_m = L_m/R: time constant with which the motor's force follows its command, s.
    pub motor_lag_s: Option<f64>,
    /// τ_b: time constants with which the brake's level rises and falls to its command, s.
    pub brake_lag_on_off_s: Option<[f64; 2]>,
    /// The hand; without it nobody touches the lever.
    pub hand: Option<Hand>,
}

/// A hand as a mass that is pulled along by its intent, and the tissue through which it touches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hand {
    /// M: mass that moves with the fingertip, kg.
    pub mass_kg: f64,
    /// K: stiffness between the hand and where it means to be, N/m.
    pub stiffness_n_per_m: f64,
    /// B: damping between the hand and how fast it means to go, N s/m.
    pub damping_ns_per_m: f64,
    /// The fingertip.
    pub tissue: Tissue,
}

/// A fingertip that pushes and never pulls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tissue {
    /// K_F, N/m.
    pub stiffness_n_per_m: f64,
    /// B_F, N s/m; above 0, since a tissue without it would spring back in no time.
    pub damping_ns_per_m: f64,
}

/// A rate (1/s) up to which flows are made: time constants from 0.1 µs on.
const FASTEST_PER_S: f64 = 1e7;

/// What [`FASTEST_PER_S`] requires of a parameter, in words.
const TOO_FAST: &str =
    "such that no time constant is below 0.1 µs: larger masses and lags, or less stiffness";

impl DrivenParameters {
    /// Friction, or none of it.
    pub(super) fn dry(&self) -> Friction {
        self.friction.unwrap_or(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: 0.0 })
    }

    /// b_v + b_e, N s/rad.
    pub(super) fn viscous_ns_per_rad(&self) -> f64 {
        self.dry().viscous_ns_per_rad + self.back_emf_ns_per_rad.unwrap_or(0.0)
    }

    /// J/L: what θ̈ is multiplied with to give a force at the lever's end, kg m.
    pub(super) fn mass_kg_m(&self) -> f64 {
        self.inertia_kg_m2 / self.lever_m
    }

    /// The parameter (or command: motor, brake and intent, N) furthest, in powers of ten, from the
    /// prototype's, for errors of extreme runs.
    pub(super) fn suspect(&self, commands_n: [f64; 3]) -> String {
        let [motor, brake, intent] = commands_n;
        let mut list = vec![
            ("inertia_kg_m2", self.inertia_kg_m2, 2e-4),
            ("lever_m", self.lever_m, 0.045),
            ("command.motor_n", motor, 4.0),
            ("command.brake_n", brake, 10.0),
            ("aims (as force)", intent, 10.0),
        ];
        list.extend(self.hand.map(|hand| ("hand.mass_kg", hand.mass_kg, 0.1)));
        let distances = list.into_iter().map(|(name, value, usual)| {
            let is_zero = value == 0.0;
            let distance = if is_zero { 0.0 } else { libm::log10(value.abs() / usual).abs() };
            (distance, name, value)
        });
        let furthest = distances.max_by(|a, b| a.0.total_cmp(&b.0));
        furthest.map_or_else(String::new, |(_, name, value)| format!("{name} = {value}"))
    }

    /// Every parameter checked; the first that makes no sense is named.
    pub(super) fn check(&self) -> Result<()> {
        positive("inertia_kg_m2", self.inertia_kg_m2)?;
        positive("lever_m", self.lever_m)?;
        if let Some([low, high]) = self.stops_rad {
            finite("stops_rad[0]", low)?;
            finite("stops_rad[1]", high)?;
            check("stops_rad[1]", high, low < high, "above stops_rad[0]")?;
        }
        self.friction.as_ref().map_or(Ok(()), Friction::check)?;
        self.back_emf_ns_per_rad.map_or(Ok(()), |b| not_negative("back_emf_ns_per_rad", b))?;
        self.motor_lag_s.map_or(Ok(()), |lag| slow("motor_lag_s", lag, 1.0 / lag))?;
        if let Some([on, off]) = self.brake_lag_on_off_s {
            slow("brake_lag_on_off_s[0]", on, 1.0 / on)?;
            slow("brake_lag_on_off_s[1]", off, 1.0 / off)?;
        }
        let viscous = self.viscous_ns_per_rad();
        slow("inertia_kg_m2", self.inertia_kg_m2, viscous / self.mass_kg_m())?;
        self.hand
            .as_ref()
            .map_or(Ok(()), |hand| hand.check(self.inertia_kg_m2 / (self.lever_m * self.lever_m)))
    }
}

impl Hand {
    /// `lever_kg`: the lever's mass at its end.
    fn check(&self, lever_kg: f64) -> Result<()> {
        positive("hand.mass_kg", self.mass_kg)?;
        not_negative("hand.stiffness_n_per_m", self.stiffness_n_per_m)?;
        not_negative("hand.damping_ns_per_m", self.damping_ns_per_m)?;
        let Tissue { stiffness_n_per_m: k_f, damping_ns_per_m: b_f } = self.tissue;
        not_negative("hand.tissue.stiffness_n_per_m", k_f)?;
        positive("hand.tissue.damping_ns_per_m", b_f)?;
        let k = self.stiffness_n_per_m;
        slow("hand.stiffness_n_per_m", k, (k / self.mass_kg).sqrt())?;
        slow("hand.damping_ns_per_m", self.damping_ns_per_m, self.damping_ns_per_m / self.mass_kg)?;
        // The tissue lies between the two masses: the lighter one swings the faster on it.
        let lightest = self.mass_kg.min(lever_kg);
        slow("hand.tissue.stiffness_n_per_m", k_f, (k_f / lightest).sqrt())?;
        slow("hand.tissue.damping_ns_per_m", b_f, b_f / lightest)?;
        slow("hand.tissue.damping_ns_per_m", b_f, k_f / b_f)
    }
}

/// `value` is above zero or not below it as its own check says, and the rate it causes is one that
/// can be solved.
fn slow(name: &str, value: f64, rate_per_s: f64) -> Result<()> {
    check(name, value, value.is_finite() && (0.0..=FASTEST_PER_S).contains(&rate_per_s), TOO_FAST)
}

#[cfg(test)]
mod tests {
    use super::super::tests::prototype;
    use super::*;

    fn check_named(change: impl Fn(&mut DrivenParameters), name: &str) {
        let mut parameters = prototype();
        change(&mut parameters);
        let error = parameters.check().unwrap_err().to_string();
        assert!(error.starts_with(&format!("{name} is ")), "{error}");
    }

    #[test]
    fn a_wrong_parameter_is_named() {
        check_named(|p| p.inertia_kg_m2 = 0.0, "inertia_kg_m2");
        check_named(|p| p.inertia_kg_m2 = 1e-300, "inertia_kg_m2");
        check_named(|p| p.lever_m = f64::NAN, "lever_m");
        check_named(|p| p.stops_rad = Some([0.5, 0.5]), "stops_rad[1]");
        check_named(|p| p.back_emf_ns_per_rad = Some(-1.0), "back_emf_ns_per_rad");
        check_named(|p| p.motor_lag_s = Some(0.0), "motor_lag_s");
        check_named(|p| p.motor_lag_s = Some(-1.0), "motor_lag_s");
        check_named(|p| p.brake_lag_on_off_s = Some([0.01, 1e-12]), "brake_lag_on_off_s[1]");
        check_named(|p| p.friction.as_mut().unwrap().static_n = 0.1, "friction.static_n");
        check_named(|p| p.hand.as_mut().unwrap().mass_kg = f64::INFINITY, "hand.mass_kg");
        check_named(
            |p| p.hand.as_mut().unwrap().stiffness_n_per_m = 1e18,
            "hand.stiffness_n_per_m",
        );
        check_named(
            |p| p.hand.as_mut().unwrap().tissue.damping_ns_per_m = 0.0,
            "hand.tissue.damping_ns_per_m",
        );
        check_named(
            |p| p.hand.as_mut().unwrap().tissue.damping_ns_per_m = 1e-6,
            "hand.tissue.damping_ns_per_m",
        );
    }

    #[test]
    fn the_prototype_passes_its_checks() {
        assert_eq!(prototype().check(), Ok(()));
    }
}
