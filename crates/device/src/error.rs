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
}
