//! What can go wrong with a device.

/// A fault of a device, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// The device does not answer any more.
    #[error("{device}: lost: {what}; check the cable and the power, then home again")]
    Lost {
        /// Which device.
        device: String,
        /// What was seen.
        what: String,
    },
    /// The device cannot do what is asked.
    #[error("{device}: {what}; {remedy}")]
    Unable {
        /// Which device.
        device: String,
        /// What it cannot do.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// A parameter makes no sense.
    #[error("{name} is {value}; it must be {allowed}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The study does not say what is needed.
    #[error("study.toml does not say {key}; a device cannot be driven without it")]
    Missing {
        /// The key.
        key: &'static str,
    },
}

/// A device that cannot do what is asked.
pub(crate) fn unable(device: &str, what: &str, remedy: &str) -> DeviceError {
    let [device, what, remedy] = [device, what, remedy].map(str::to_owned);
    DeviceError::Unable { device, what, remedy }
}

/// A parameter that must be above 0 and finite.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, DeviceError> {
    let allowed = "above 0 and finite";
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(DeviceError::Parameter { name, value, allowed })
    }
}
