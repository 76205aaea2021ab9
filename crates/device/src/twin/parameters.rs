//! The twin's numbers: default, range and source of each. No one measured the prototype's plant, so
//! most are assumed, and whatever the twin shows must hold over the whole range.

use super::sensors::SHAFT_PER_LEVER;
use crate::DeviceError;
use crate::error::unable;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;
use zwidth_dynamics::{DrivenParameters, Friction, Hand};
use zwidth_study::Calibration;

/// No number is larger, in its unit.
const LARGEST: f64 = 1e9;

/// The mechanical stops, rad (thesis Table 3).
pub(crate) const STOPS_RAD: [f64; 2] = [-FRAC_PI_4, FRAC_PI_4];

/// The plant, its actuators and its sensors. [`TwinParameters::table`] lists default, range and
/// source of each number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TwinParameters {
    /// Lever length L, m.
    pub lever_m: f64,
    /// Resistance of the motor's winding R, Ω.
    pub resistance_ohm: f64,
    /// Its inductance L_m, H.
    pub inductance_h: f64,
    /// Torque constant k_t, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Inertia of the motor's rotor, about the shaft, kg m².
    pub rotor_kg_m2: f64,
    /// Inertia of lever and wheel, about the lever's axis, kg m².
    pub lever_kg_m2: f64,
    /// Inertia of the brake's disc, as felt at the lever's axis, kg m².
    pub brake_kg_m2: f64,
    /// Capstan friction at rest, at the lever's end, N.
    pub friction_static_n: f64,
    /// Capstan friction in motion, as a share of that at rest.
    pub friction_kinetic_share: f64,
    /// Viscous friction at the lever's end, N s/rad.
    pub friction_viscous_ns_per_rad: f64,
    /// Time constant with which the brake takes hold, s.
    pub brake_on_s: f64,
    /// Time constant with which it lets go, s.
    pub brake_off_s: f64,
    /// Noise of a force value, N rms.
    pub force_noise_n: f64,
    /// Force of a voltage, at the lever's end.
    pub actuators: Calibration,
}

/// One number of [`TwinParameters`]: its known facts.
#[derive(Debug, Clone, Copy)]
pub struct TwinParameter {
    /// Its field, which ends in its unit.
    pub name: &'static str,
    /// Value of the prototype's twin.
    pub default: f64,
    /// Within which every story the twin tells must hold.
    pub range: [f64; 2],
    /// Where it comes from, or that it is assumed.
    pub source: &'static str,
    /// The number itself.
    pub field: fn(&mut TwinParameters) -> &mut f64,
}

/// A row of the table; the field gives it its name.
macro_rules! row {
    ($field:ident, $default:expr, $range:expr, $source:expr) => {
        TwinParameter {
            name: stringify!($field),
            default: $default,
            range: $range,
            source: $source,
            field: |parameters| &mut parameters.$field,
        }
    };
}

/// The estimate of the motor's constants, which the data sheet of the 48 V winding was not at hand
/// for.
const WINDING: &str = "estimate: 2342S012CR scaled by turns ×4, ±20 %";

impl Default for TwinParameters {
    fn default() -> Self {
        let mut twin = Self {
            lever_m: 0.0,
            resistance_ohm: 0.0,
            inductance_h: 0.0,
            torque_constant_nm_per_a: 0.0,
            rotor_kg_m2: 0.0,
            lever_kg_m2: 0.0,
            brake_kg_m2: 0.0,
            friction_static_n: 0.0,
            friction_kinetic_share: 0.0,
            friction_viscous_ns_per_rad: 0.0,
            brake_on_s: 0.0,
            brake_off_s: 0.0,
            force_noise_n: 0.0,
            actuators: Calibration::thesis(),
        };
        // The table alone has the numbers, so that it cannot differ from them.
        for parameter in Self::table() {
            *(parameter.field)(&mut twin) = parameter.default;
        }
        twin
    }
}

impl TwinParameters {
    /// Every number with its range and source (`docs/twin.md`).
    pub const fn table() -> [TwinParameter; 13] {
        [
            row!(
                lever_m,
                0.045,
                [0.040, 0.10],
                "inferred: 4.16 N at 16 V from the scaled stall torque, lossless"
            ),
            row!(resistance_ohm, 30.4, [24.32, 36.48], WINDING),
            row!(inductance_h, 1.6e-3, [1.28e-3, 1.92e-3], WINDING),
            row!(torque_constant_nm_per_a, 0.0536, [0.042_88, 0.064_32], WINDING),
            row!(rotor_kg_m2, 5.8e-7, [4.06e-7, 7.54e-7], "motor series, assumed, ±30 %"),
            row!(lever_kg_m2, 1.5e-4, [0.5e-4, 5e-4], "assumed: printed PLA, 75 mm"),
            row!(brake_kg_m2, 2e-5, [0.5e-5, 5e-5], "assumed"),
            row!(friction_static_n, 0.20, [0.0, 0.40], "assumed"),
            row!(friction_kinetic_share, 0.75, [0.5, 1.0], "assumed: 0.15 N in motion"),
            row!(friction_viscous_ns_per_rad, 0.02, [0.0, 0.05], "assumed"),
            row!(brake_on_s, 0.015, [0.003, 0.040], "assumed: the magnet slides over an air gap"),
            row!(brake_off_s, 0.010, [0.003, 0.040], "assumed: the magnet slides over an air gap"),
            row!(
                force_noise_n,
                0.002,
                [0.0005, 0.020],
                "90 nV input noise of the HX711 (OpenScale), 5 kg cell assumed"
            ),
        ]
    }

    /// Whether every number and both characteristics make sense.
    ///
    /// # Errors
    /// The first that does not, by name.
    pub fn check(&self) -> Result<(), DeviceError> {
        // A copy, because the table reaches its fields for writing only.
        let mut copy = self.clone();
        for parameter in Self::table() {
            let value = *(parameter.field)(&mut copy);
            if !(0.0..=LARGEST).contains(&value) {
                let allowed = "finite and not below 0 (at most 1e9)";
                return Err(DeviceError::Parameter { name: parameter.name, value, allowed });
            }
        }
        self.actuators.check().map_err(|error| impossible(&error))
    }

    /// The plant with a hand at it.
    ///
    /// All that turns with the shaft counts with the ratio squared: J = N² J_rotor + J_lever +
    /// J_brake (1.97e-4 kg m² by default). The closed winding damps with (N k_t)²/(R L) at the
    /// lever's end.
    pub fn plant(&self, hand: Option<Hand>) -> DrivenParameters {
        let torque_per_amp = SHAFT_PER_LEVER * self.torque_constant_nm_per_a;
        DrivenParameters {
            inertia_kg_m2: SHAFT_PER_LEVER * SHAFT_PER_LEVER * self.rotor_kg_m2
                + self.lever_kg_m2
                + self.brake_kg_m2,
            lever_m: self.lever_m,
            stops_rad: Some(STOPS_RAD),
            friction: Some(Friction {
                static_n: self.friction_static_n,
                kinetic_n: self.friction_static_n * self.friction_kinetic_share,
                viscous_ns_per_rad: self.friction_viscous_ns_per_rad,
            }),
            back_emf_ns_per_rad: Some(
                torque_per_amp * torque_per_amp / (self.resistance_ohm * self.lever_m),
            ),
            motor_lag_s: Some(self.inductance_h / self.resistance_ohm),
            brake_lag_on_off_s: Some([self.brake_on_s, self.brake_off_s]),
            hand,
        }
    }

    /// The current in the motor's winding, A: (U − e) / R, with U the voltage that the force F_m at
    /// the lever's end stands for (behind the winding's lag) and e = N k_t θ̇ the back-EMF. Above 0
    /// it drives to +θ, as a voltage above 0 does.
    pub(super) fn motor_current_a(&self, motor_n: f64, theta_dot_rad_s: f64) -> f64 {
        let back_emf_v = SHAFT_PER_LEVER * self.torque_constant_nm_per_a * theta_dot_rad_s;
        (self.actuators.motor.voltage_v(motor_n) - back_emf_v) / self.resistance_ohm
    }
}

/// A plant that cannot be simulated.
pub(super) fn impossible(error: &dyn std::error::Error) -> DeviceError {
    unable("twin", &error.to_string(), "correct the twin's parameters")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_tables_and_lie_in_their_ranges() {
        let mut twin = TwinParameters::default();
        for parameter in TwinParameters::table() {
            assert_eq!((parameter.field)(&mut twin).to_bits(), parameter.default.to_bits());
            assert!(
                parameter.range[0] <= parameter.default && parameter.default <= parameter.range[1]
            );
            assert!(!parameter.source.is_empty());
        }
        assert_eq!(serde_names(), TwinParameters::table().map(|parameter| parameter.name));
    }

    #[test]
    fn the_docs_list_every_number() {
        let docs = include_str!("../../../../docs/twin.md");
        for parameter in TwinParameters::table() {
            assert!(
                docs.contains(&format!("| `{}` |", parameter.name)),
                "{} is missing",
                parameter.name
            );
        }
    }

    /// The fields that hold one number, as they are written.
    fn serde_names() -> Vec<String> {
        let text = toml::to_string(&TwinParameters::default()).unwrap();
        text.lines()
            .take_while(|line| !line.is_empty())
            .map(|line| line.split(' ').next().unwrap().to_owned())
            .collect()
    }

    #[test]
    fn the_plant_is_that_of_the_design() {
        let plant = TwinParameters::default().plant(None);
        assert!((plant.inertia_kg_m2 - 1.97e-4).abs() < 1e-7);
        assert!((plant.motor_lag_s.unwrap() - 53e-6).abs() < 1e-6);
        assert!((plant.back_emf_ns_per_rad.unwrap() - 0.0976).abs() < 1e-4);
        assert!((plant.friction.unwrap().kinetic_n - 0.15).abs() < 1e-12);
    }

    #[test]
    fn the_estimated_winding_gives_the_measured_force_per_volt_within_three_percent() {
        let twin = TwinParameters::default();
        let ideal =
            SHAFT_PER_LEVER * twin.torque_constant_nm_per_a / (twin.resistance_ohm * twin.lever_m);
        assert!((ideal / 0.26 - 1.0).abs() < 0.03, "{ideal}");
    }

    #[test]
    fn a_number_or_a_characteristic_that_makes_no_sense_is_named() {
        let named = |twin: TwinParameters| twin.check().unwrap_err().to_string();
        let error = named(TwinParameters { force_noise_n: -1.0, ..TwinParameters::default() });
        assert!(error.starts_with("force_noise_n is -1"), "{error}");
        let mut twin = TwinParameters::default();
        twin.actuators.brake.force_n = vec![0.0, -1.0];
        assert!(named(twin).contains("brake"));
    }

    #[test]
    fn toml_brings_it_back_and_an_unknown_name_is_refused() {
        let twin = TwinParameters { brake_on_s: 0.02, ..TwinParameters::default() };
        let text = toml::to_string(&twin).unwrap();
        assert_eq!(toml::from_str::<TwinParameters>(&text).unwrap(), twin);
        assert_eq!(toml::from_str::<TwinParameters>("brake_on_s = 0.02").unwrap(), twin);
        assert!(toml::from_str::<TwinParameters>("brake_lag = 0.02").is_err());
    }
}
