//! The per-sample columns of a trial file: one table, read by the writer, the reader, `verify` and
//! `import` alike.

use arrow::datatypes::DataType;
use zwidth_study::Schema;

/// A per-sample quantity of a trial. SI units; angles in radians.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Signal {
    /// Time since the trial's start, host's clock, as measured, never resampled.
    Time,
    /// The device's own clock.
    DeviceTime,
    /// Lever angle.
    Theta,
    /// Lever velocity, as the controller used it.
    ThetaDot,
    /// Lever acceleration, where a recording brings one.
    ThetaDdot,
    /// User force, perpendicular to the lever; > 0 pushes into the object.
    ForceEx,
    /// User torque, where no lever length turns it into a force.
    TorqueEx,
    /// Commanded motor voltage.
    VoltageMotor,
    /// Commanded brake voltage.
    VoltageBrake,
    /// Age of the force value.
    ForceAge,
    /// The angle sensor's own count.
    ThetaRaw,
    /// Feedback force the voltages stand for, by the calibration in force.
    ForceCmd,
    /// Status bits of the sample.
    StateBits,
    /// Position along the study's axis x.
    X,
    /// Position along y.
    Y,
    /// Position along z.
    Z,
    /// User force along x.
    ForceX,
    /// User force along y.
    ForceY,
    /// User force along z.
    ForceZ,
}

/// How a column is stored in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// 64-bit float.
    F64,
    /// 32-bit float.
    F32,
    /// 16-bit unsigned integer.
    U16,
}

impl Storage {
    /// The type in Arrow.
    pub(crate) fn data_type(self) -> DataType {
        match self {
            Self::F64 => DataType::Float64,
            Self::F32 => DataType::Float32,
            Self::U16 => DataType::UInt16,
        }
    }
}

/// One row of the schema: what the Arrow field says about itself.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// The signal.
    pub signal: Signal,
    /// The column's name, with its unit.
    pub name: &'static str,
    /// Unit, as in the field's metadata.
    pub unit: &'static str,
    /// Description, as in the field's metadata.
    pub description: &'static str,
    /// Type in the file. In memory every signal is `f64`, which holds all three exactly.
    pub storage: Storage,
}

const fn column(
    signal: Signal,
    name: &'static str,
    unit: &'static str,
    storage: Storage,
    description: &'static str,
) -> Column {
    Column { signal, name, unit, description, storage }
}

use Storage::{F32, F64, U16};

/// Every signal, in file order.
pub const COLUMNS: [Column; 19] = [
    column(Signal::Time, "t_s", "s", F64, "time since the trial's start, host clock, as measured"),
    column(Signal::DeviceTime, "t_device_s", "s", F64, "the device's own clock"),
    column(Signal::Theta, "theta_rad", "rad", F64, "lever angle"),
    column(
        Signal::ThetaDot,
        "theta_dot_rad_s",
        "rad/s",
        F64,
        "lever velocity as the controller used it",
    ),
    column(Signal::ThetaDdot, "theta_ddot_rad_s2", "rad/s²", F64, "lever acceleration"),
    column(
        Signal::ForceEx,
        "force_ex_n",
        "N",
        F64,
        "user force perpendicular to the lever, > 0 pushes into the object",
    ),
    column(
        Signal::TorqueEx,
        "torque_ex_nm",
        "N·m",
        F64,
        "user torque, where no lever length is known, > 0 pushes into the object",
    ),
    column(Signal::VoltageMotor, "voltage_motor_v", "V", F32, "commanded motor voltage"),
    column(Signal::VoltageBrake, "voltage_brake_v", "V", F32, "commanded brake voltage"),
    column(
        Signal::ForceAge,
        "force_age_s",
        "s",
        F32,
        "age of the force value (held between updates)",
    ),
    column(Signal::ThetaRaw, "theta_raw", "counts", U16, "the angle sensor's own count"),
    column(
        Signal::ForceCmd,
        "force_cmd_n",
        "N",
        F64,
        "feedback force the commands stand for, by the calibration in force",
    ),
    column(
        Signal::StateBits,
        "state_bits",
        "bits",
        U16,
        "1 saturated, 2 stale force, 4 stale angle, 8 dropout, 16 clipped, 32 past wall, 64 outside work space, 128 brake on, 256 motor on",
    ),
    column(Signal::X, "x_m", "m", F64, "position along x, by the frame in study.toml"),
    column(Signal::Y, "y_m", "m", F64, "position along y, by the frame in study.toml"),
    column(Signal::Z, "z_m", "m", F64, "position along z, by the frame in study.toml"),
    column(Signal::ForceX, "force_x_n", "N", F64, "user force along x, by the frame in study.toml"),
    column(Signal::ForceY, "force_y_n", "N", F64, "user force along y, by the frame in study.toml"),
    column(Signal::ForceZ, "force_z_n", "N", F64, "user force along z, by the frame in study.toml"),
];

impl Signal {
    /// How many signals there are.
    pub const COUNT: usize = COLUMNS.len();

    /// Every signal, in file order.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        COLUMNS.iter().map(|c| c.signal)
    }

    /// The signals that trial files of a schema have columns for, in file order.
    pub fn of(schema: Schema) -> impl Iterator<Item = Self> + Clone {
        Self::all().filter(move |signal| signal.schema() <= schema)
    }

    /// The first schema whose trial files have the signal's column.
    pub fn schema(self) -> Schema {
        match self {
            Self::X | Self::Y | Self::Z | Self::ForceX | Self::ForceY | Self::ForceZ => {
                Schema::Three
            }
            _ => Schema::Two,
        }
    }

    /// The signal's row of the schema.
    pub fn column(self) -> &'static Column {
        // A test holds the table to the order of the signals.
        &COLUMNS[self as usize]
    }

    /// The column's name.
    pub fn name(self) -> &'static str {
        self.column().name
    }

    /// The column's name without its unit: `theta_dot`.
    pub fn stem(self) -> &'static str {
        let name = self.name();
        let without = name.strip_suffix(self.suffix()).and_then(|stem| stem.strip_suffix('_'));
        without.unwrap_or(name)
    }

    /// The unit as it ends names of columns: `rad_s`; nothing where there is none.
    pub fn suffix(self) -> &'static str {
        match self.column().unit {
            "rad" => "rad",
            "rad/s" => "rad_s",
            "rad/s^2" | "rad/s²" => "rad_s2",
            "m" => "m",
            "N" => "n",
            "N·m" => "nm",
            "V" => "v",
            "s" => "s",
            _ => "",
        }
    }

    /// The signal whose column has this name.
    pub fn from_name(name: &str) -> Option<Self> {
        COLUMNS.iter().find(|c| c.name == name).map(|c| c.signal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_its_stem_and_its_unit() {
        for signal in Signal::all() {
            let name = match signal.suffix() {
                "" => signal.stem().to_owned(),
                suffix => format!("{}_{suffix}", signal.stem()),
            };
            assert_eq!(name, signal.name());
        }
        assert_eq!((Signal::ThetaDot.stem(), Signal::ThetaDot.suffix()), ("theta_dot", "rad_s"));
        assert_eq!((Signal::StateBits.suffix(), Signal::ThetaRaw.suffix()), ("", ""));
    }

    #[test]
    fn the_table_stands_in_the_order_of_the_signals() {
        for (i, column) in COLUMNS.iter().enumerate() {
            assert_eq!(column.signal as usize, i, "{}", column.name);
        }
    }
}
