//! Checks of the numbers of `rig.toml`.

use zwidth_device::DeviceError;

/// Whether a rate is one that a line carries.
///
/// # Errors
/// Why not, and what it carries.
pub(crate) fn within(
    what: &str,
    rate_hz: f64,
    most_hz: f64,
    baud: u32,
    key: &str,
) -> Result<(), DeviceError> {
    if rate_hz <= most_hz {
        return Ok(());
    }
    let most = most_hz.floor();
    Err(unable(
        format!(
            "{what} come {rate_hz} times per second, and {baud} baud carry at most {most} of them"
        ),
        &format!("lower the rate, or raise {key} in rig.toml and on the board"),
    ))
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), DeviceError> {
    require(value.is_finite() && value > 0.0, name, value, "above 0 and finite")
}

pub(crate) fn not_below_0(name: &'static str, value: f64) -> Result<(), DeviceError> {
    require(value.is_finite() && value >= 0.0, name, value, "0 or more, and finite")
}

/// An error about a number, unless it is fine.
pub(crate) fn require(
    is_fine: bool,
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), DeviceError> {
    if is_fine { Ok(()) } else { Err(DeviceError::Parameter { name, value, allowed }) }
}

pub(crate) fn unable(what: String, remedy: &str) -> DeviceError {
    DeviceError::Unable { device: "rig.toml".to_owned(), what, remedy: remedy.to_owned() }
}
