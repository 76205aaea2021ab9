//! Calibration: from a voltage to the force that it stands for, and back.

use serde::{Deserialize, Serialize};

/// No voltage (V) and no force (N) of a characteristic is larger.
const LARGEST: f64 = 1e6;

/// What is wrong with a calibration, and how to correct it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("calibration: {actuator}: {problem}")]
pub struct CalibrationError {
    /// `motor` or `brake`.
    pub actuator: &'static str,
    /// What is wrong, with the value and the remedy.
    pub problem: String,
}

/// The characteristic of one actuator: straight lines between knots, flat beyond the last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Characteristic {
    /// Voltages of the knots, V, rising; the first is where force begins (0 V, or the end of a
    /// dead zone).
    pub voltage_v: Vec<f64>,
    /// Forces at the lever's end there, N, rising; the first is 0.
    pub force_n: Vec<f64>,
}

/// Both actuators' characteristics: the map from force to voltage that a controller uses, and back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// The motor; odd in the voltage.
    pub motor: Characteristic,
    /// The brake; only the size of the voltage matters.
    pub brake: Characteristic,
}

/// Where a calibration that was made at a rig comes from. Forces do not depend on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationOrigin {
    /// When its last sweep ended, UTC, RFC 3339.
    pub utc: String,
    /// The device, as it names itself.
    pub device: String,
    /// Confidence level of the intervals.
    pub level: f64,
    /// Of the motor.
    pub motor: ForceInterval,
    /// Of the brake.
    pub brake: ForceInterval,
}

/// The interval of the force at each knot of a characteristic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceInterval {
    /// How many sweeps it rests on.
    pub sweeps: u32,
    /// Its lower end, N.
    pub low_n: Vec<f64>,
    /// Its upper end, N.
    pub high_n: Vec<f64>,
}

/// The content of `calibration.toml`: a calibration and, where it was made at a rig, its origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// The motor.
    pub motor: Characteristic,
    /// The brake.
    pub brake: Characteristic,
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<CalibrationOrigin>,
}

impl CalibrationFile {
    /// Reads the file's text.
    ///
    /// # Errors
    /// Text that is not a calibration, or a characteristic that cannot be inverted.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        let read: Self = toml::from_str(text)
            .map_err(|e| CalibrationError { actuator: "file", problem: e.to_string() })?;
        read.motor.check("motor")?;
        read.brake.check("brake")?;
        Ok(read)
    }

    /// The file's text.
    ///
    /// # Errors
    /// A value that cannot be written.
    pub fn to_toml(&self) -> Result<String, CalibrationError> {
        toml::to_string(self)
            .map_err(|e| CalibrationError { actuator: "file", problem: e.to_string() })
    }

    /// The calibration alone: sessions are recorded with it, and name it by its hash.
    pub fn calibration(self) -> Calibration {
        Calibration { motor: self.motor, brake: self.brake }
    }
}

impl Characteristic {
    /// Force of a voltage, N, with the voltage's sign.
    pub fn force_n(&self, voltage_v: f64) -> f64 {
        along(&self.voltage_v, &self.force_n, voltage_v.abs()).copysign(voltage_v)
    }

    /// Voltage for a force, V, with the force's sign: 0 V for no force, and the end of the dead
    /// zone for the smallest; the last knot's voltage for more than the actuator can give.
    pub fn voltage_v(&self, force_n: f64) -> f64 {
        if force_n == 0.0 {
            // And not the voltage at which force begins.
            0.0
        } else {
            along(&self.force_n, &self.voltage_v, force_n.abs()).copysign(force_n)
        }
    }

    fn check(&self, actuator: &'static str) -> Result<(), CalibrationError> {
        let Self { voltage_v, force_n } = self;
        let problem = if voltage_v.len() < 2 || voltage_v.len() != force_n.len() {
            "voltage_v and force_n need the same number of values, at least 2"
        } else if !voltage_v.iter().chain(force_n).all(|x| x.abs() <= LARGEST) {
            // Asked so that a NaN is refused: it is not at most anything.
            "a value is not a finite number of at most 1e6"
        } else if ![voltage_v, force_n].iter().all(|v| v.windows(2).all(|w| w[1] > w[0])) {
            "voltage_v and force_n must rise, else no voltage belongs to a force"
        } else if voltage_v[0] < 0.0 || force_n[0] != 0.0 {
            "the first knot is where force begins: a voltage of at least 0 V, and 0 N"
        } else {
            return Ok(());
        };
        Err(CalibrationError { actuator, problem: problem.to_owned() })
    }
}

impl Calibration {
    /// The prototype's nominal characteristics: 0.26 N/V up to 16 V (thesis §5.1), and a brake that
    /// begins at about 1 V and gives 13 N at 8 V (§5.1, App. D).
    pub fn thesis() -> Self {
        Self {
            motor: Characteristic { voltage_v: vec![0.0, 16.0], force_n: vec![0.0, 4.16] },
            brake: Characteristic { voltage_v: vec![1.0, 8.0], force_n: vec![0.0, 13.0] },
        }
    }

    /// Whether both characteristics can be inverted.
    ///
    /// # Errors
    /// The first characteristic that cannot, and why.
    pub fn check(&self) -> Result<(), CalibrationError> {
        self.motor.check("motor")?;
        self.brake.check("brake")
    }

    /// Reads a calibration from TOML text.
    ///
    /// # Errors
    /// Text that is not a calibration, or a characteristic that cannot be inverted.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        CalibrationFile::from_toml(text).map(|file| file.calibration())
    }

    /// The calibration as TOML text, which [`Calibration::from_toml`] reads back.
    ///
    /// # Errors
    /// A value that cannot be written.
    pub fn to_toml(&self) -> Result<String, CalibrationError> {
        toml::to_string(self)
            .map_err(|e| CalibrationError { actuator: "file", problem: e.to_string() })
    }
}

/// y(x) along straight lines; the first y below the first x, the last beyond the last.
fn along(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let above = xs.iter().take_while(|knot| **knot <= x).count();
    match (above.checked_sub(1), ys.get(above)) {
        (None, _) => ys.first().copied().unwrap_or(0.0),
        // Flat, not straight on: the actuator gives no more than at its last knot.
        (Some(i), None) => ys[i],
        (Some(i), Some(next)) => ys[i] + (next - ys[i]) * ((x - xs[i]) / (xs[above] - xs[i])),
    }
}

/// Where the calibration of a study's forces comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// The thesis: motor and brake of the study were not both swept.
    Thesis,
    /// The study's own sweeps.
    Swept,
    /// The study's own sweeps, of which one at least is simulated.
    Simulated,
}

impl Basis {
    /// A sentence that says so, for a footnote.
    pub fn footnote(self) -> &'static str {
        match self {
            Self::Thesis => {
                "Forces by the thesis' nominal characteristics: motor and brake of this study were \
                 not both swept."
            }
            Self::Swept => "Forces by the calibration from this study's sweeps of motor and brake.",
            Self::Simulated => {
                "Forces by the calibration from this study's simulated sweeps of motor and brake."
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expect: f64) {
        assert!((found - expect).abs() < 1e-12, "{found} instead of {expect}");
    }

    #[test]
    fn the_prototypes_motor_gives_4_16_n_at_16_v_and_2_08_n_at_8_v() {
        let motor = Calibration::thesis().motor;
        close(motor.force_n(16.0), 4.16);
        close(motor.force_n(8.0), 2.08);
        close(motor.force_n(-8.0), -2.08);
        close(motor.force_n(20.0), 4.16);
        close(motor.voltage_v(-2.08), -8.0);
        close(motor.voltage_v(9.0), 16.0);
    }

    #[test]
    fn a_dead_zone_is_jumped_for_any_force_but_none() {
        let brake = Calibration::thesis().brake;
        close(brake.force_n(1.0), 0.0);
        close(brake.force_n(0.5), 0.0);
        close(brake.force_n(8.0), 13.0);
        close(brake.voltage_v(0.0), 0.0);
        close(brake.voltage_v(1e-13), 1.0);
        close(brake.voltage_v(6.5), 4.5);
    }

    #[test]
    fn forward_and_inverse_undo_each_other() {
        let Calibration { motor, brake } = Calibration::thesis();
        for i in 1..40 {
            let force_n = 0.1 * f64::from(i);
            close(motor.force_n(motor.voltage_v(force_n)), force_n);
            close(brake.force_n(brake.voltage_v(force_n)), force_n);
        }
    }

    #[test]
    fn its_origin_changes_no_force_and_no_hash() {
        let interval = ForceInterval { sweeps: 15, low_n: vec![0.0, 4.1], high_n: vec![0.0, 4.2] };
        let Calibration { motor, brake } = Calibration::thesis();
        let file = CalibrationFile {
            motor,
            brake,
            origin: Some(CalibrationOrigin {
                utc: "2026-11-30T12:00:00Z".to_owned(),
                device: "board".to_owned(),
                level: 0.95,
                motor: interval.clone(),
                brake: interval,
            }),
        };
        let text = file.to_toml().unwrap();
        assert_eq!(CalibrationFile::from_toml(&text).unwrap(), file);
        let read = Calibration::from_toml(&text).unwrap();
        assert_eq!(read.to_toml().unwrap(), Calibration::thesis().to_toml().unwrap());
    }

    #[test]
    fn toml_brings_it_back_and_a_falling_characteristic_is_refused() {
        let text = Calibration::thesis().to_toml().unwrap();
        assert_eq!(Calibration::from_toml(&text).unwrap(), Calibration::thesis());
        let error = Calibration::from_toml(&text.replace("4.16", "-4.16")).unwrap_err().to_string();
        assert!(error.contains("motor") && error.contains("must rise"), "{error}");
    }
}
