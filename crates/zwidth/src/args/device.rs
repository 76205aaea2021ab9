//! A device as it is named on the command line.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// How devices are written on the command line.
pub(super) const DEVICES: &str = "twin|playback:FILE";

/// A device by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DeviceSpec {
    /// The simulated device.
    Twin,
    /// A recorded trial.
    Playback(PathBuf),
}

impl fmt::Display for DeviceSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Twin => f.write_str("twin"),
            Self::Playback(file) => write!(f, "playback:{}", file.display()),
        }
    }
}

impl FromStr for DeviceSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "twin" => Ok(Self::Twin),
            Some(("playback", file)) if !file.is_empty() => Ok(Self::Playback(file.into())),
            _ => Err(format!("it must be {DEVICES}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_named_by_its_kind_and_what_belongs_to_it() {
        assert_eq!("twin".parse(), Ok(DeviceSpec::Twin));
        assert_eq!("playback:a:b".parse(), Ok(DeviceSpec::Playback("a:b".into())));
        for bad in ["", "twin:1", "playback", "playback:", "rig:/dev/x,/dev/y", "Twin"] {
            assert!(bad.parse::<DeviceSpec>().unwrap_err().contains("playback:FILE"), "{bad}");
        }
    }
}
