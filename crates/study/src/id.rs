//! Checked ids: nothing a user types becomes a path or a column value unchecked.

use crate::printable;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

/// Longest id allowed, in characters.
const MAX_LENGTH: usize = 32;

/// An id that does not match `[A-Za-z0-9_-]{1,32}`, or that no folder of Windows can have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{}' is not a valid {what} id: {why}", printable(value))]
pub struct IdError {
    /// Which kind of id it should have been.
    pub what: &'static str,
    /// The text that was refused.
    pub value: String,
    /// Why, and what to do.
    pub why: &'static str,
}

/// Why a text cannot be an id of any kind.
fn refused(text: &str) -> Option<&'static str> {
    let good = (1..=MAX_LENGTH).contains(&text.len())
        && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    (!good).then_some("use 1 to 32 of the letters A-Z a-z, digits, '_' and '-'")
}

/// Why a text cannot be a level: it can be a number, too.
fn refused_as_level(text: &str) -> Option<&'static str> {
    refused(&text.replacen('.', "_", 1))
}

/// Why a text cannot be an id that files and folders are named after.
fn refused_as_name(text: &str) -> Option<&'static str> {
    refused(text).or_else(|| {
        // With whatever extension: `aux.parquet` cannot be written there either.
        let text = text.to_ascii_uppercase();
        let port = text.strip_prefix("COM").or(text.strip_prefix("LPT")).map(str::as_bytes);
        let is_device = ["CON", "PRN", "AUX", "NUL"].contains(&text.as_str())
            || matches!(port, Some([b'1'..=b'9']));
        is_device.then_some("Windows keeps this name for a device; choose another")
    })
}

/// Columns that trial files have anyhow, or had, and folders that they lie in.
const COLUMNS: [&str; 23] = [
    "t_s",
    "t_device_s",
    "theta_rad",
    "theta_dot_rad_s",
    "theta_ddot_rad_s2",
    "force_ex_n",
    "torque_ex_nm",
    "voltage_motor_v",
    "voltage_brake_v",
    "force_age_s",
    "theta_raw",
    "force_cmd_n",
    "flags",
    "state_bits",
    "trial",
    "repeat",
    "kind",
    "status",
    "environment",
    "mode",
    "likert",
    "participant",
    "session",
];

/// Columns that trial files have from schema 3 on. Studies of schema 2 may have channels of these names.
pub(crate) const COLUMNS_OF_THREE: [&str; 9] =
    ["interval", "level", "task", "x_m", "y_m", "z_m", "force_x_n", "force_y_n", "force_z_n"];

/// Whether trial files have a column of samples of that name.
pub(crate) fn is_of_samples(name: &str) -> bool {
    let (_of_presentations, in_space) = COLUMNS_OF_THREE.split_at(3);
    let in_all = COLUMNS.iter().take_while(|column| **column != "flags");
    in_all.chain(in_space).any(|column| *column == name) || name == "state_bits"
}

/// Why a text cannot be the name of a metric.
fn refused_as_metric(text: &str) -> Option<&'static str> {
    let is_plain = text.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
        && text.starts_with(|c: char| c.is_ascii_lowercase());
    refused(text)
        .or_else(|| (!is_plain).then_some("use lower case, digits and '_', a letter first"))
}

/// Why a text cannot be the name of a study's own column.
fn refused_as_column(text: &str) -> Option<&'static str> {
    refused_as_metric(text)
        .or_else(|| COLUMNS.contains(&text).then_some("it is a column of every trial file"))
}

/// Texts that a thread remembers: more than the ids of one session have.
const REMEMBERED: usize = 64;

/// The text as ids hold it. What is read one after the other has the same few ids again and again, and a
/// study has them a million times: those that a thread met last share their text.
fn shared(text: &str) -> Arc<str> {
    thread_local! {
        static LAST: RefCell<VecDeque<Arc<str>>> = const { RefCell::new(VecDeque::new()) };
    }
    LAST.with_borrow_mut(|last| {
        let at = last.iter().position(|id| **id == *text);
        let id = at.and_then(|at| last.remove(at)).unwrap_or_else(|| text.into());
        last.truncate(REMEMBERED - 1);
        last.push_front(id.clone());
        id
    })
}

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident = $what:literal, unless $refused:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(Arc<str>);

        impl $name {
            /// Checks `text`; the error shows the text and what is allowed.
            pub fn new(text: impl Into<String>) -> Result<Self, IdError> {
                let value = text.into();
                match $refused(&value) {
                    None => Ok(Self(shared(&value))),
                    Some(why) => Err(IdError { what: $what, value, why }),
                }
            }

            /// The id as text.
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                // Not `write_str`, which passes over the width that a table asks for.
                f.pad(&self.0)
            }
        }

        impl TryFrom<String> for $name {
            type Error = IdError;
            fn try_from(text: String) -> Result<Self, IdError> {
                Self::new(text)
            }
        }

        impl std::str::FromStr for $name {
            type Err = IdError;
            fn from_str(text: &str) -> Result<Self, IdError> {
                Self::new(text)
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> String {
                id.as_str().to_owned()
            }
        }
    )*};
}

ids! {
    /// A study: the folder's name under `raw/`.
    StudyId = "study", unless refused_as_name;
    /// A participant's code. Names of people never enter a file.
    ParticipantId = "participant", unless refused_as_name;
    /// An experimenter's code. Names of people never enter a file.
    ExperimenterId = "experimenter", unless refused;
    /// A session of one participant.
    SessionId = "session", unless refused_as_name;
    /// An environment of the study, such as `spring_wall`.
    EnvironmentId = "environment", unless refused;
    /// A mode of the study, such as `hybrid`.
    ModeId = "mode", unless refused;
    /// A question of the study.
    QuestionId = "question", unless refused;
    /// A channel of a study: a column of its trial files.
    ChannelId = "channel", unless refused_as_column;
    /// A column of people, such as `group`.
    PersonColumnId = "column", unless refused_as_column;
    /// A level of a column of people or of a factor, such as `expert`, or a dose: `0.5`.
    LevelId = "level", unless refused_as_level;
    /// A factor of modes or environments, such as `brake`, or a weighted contrast.
    FactorId = "factor", unless refused;
    /// A metric, by the name of its column: it ends in its unit.
    MetricId = "metric", unless refused_as_metric;
    /// An actuator or sensor that was characterised, such as `motor`.
    ActuatorId = "actuator", unless refused;
    /// A stage of a study's own, such as `grip`, or what it reads: `samples`.
    StageId = "stage", unless refused_as_name;
    /// A stream that another program recorded beside a session, such as `emg`.
    StreamId = "stream", unless refused_as_name;
    /// A figure of scenes, such as `figure_8`.
    SceneFigureId = "figure of scenes", unless refused;
}

impl MetricId {
    /// The metric that is primary if a study does not name one: the mean of the user's force
    /// discrepancy.
    pub fn primary() -> Self {
        Self("discrepancy_user_mean_n".into())
    }
}

/// How the code of a sealed mode begins.
const CODE: &str = "sealed-";

impl ModeId {
    /// A code that stands in for a mode while it is sealed: `sealed-` and sixteen hexadecimal
    /// digits.
    pub(crate) fn code(digest: &blake3::Hash) -> Self {
        const DIGITS: usize = 16;
        Self(format!("{CODE}{}", &digest.to_hex()[..DIGITS]).into())
    }

    /// Whether it is such a code. No mode of a study may have a name like that.
    pub fn is_code(&self) -> bool {
        self.0.starts_with(CODE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_digits_underscore_and_hyphen_make_an_id() {
        for good in ["P01", "a", "spring_wall", "x-1", &"a".repeat(32)] {
            assert!(ParticipantId::new(good).is_ok(), "{good}");
        }
    }

    #[test]
    fn nothing_that_could_be_a_path_is_an_id() {
        for bad in ["", "../x", "a/b", "a\\b", ".", "a.b", "é", "a b", "a\0", "C:", &"a".repeat(33)]
        {
            let error = ParticipantId::new(bad).unwrap_err();
            assert!(error.to_string().contains("participant id"), "{error}");
        }
    }

    #[test]
    fn a_name_that_windows_keeps_for_a_device_is_no_study_participant_or_session() {
        for device in ["CON", "con", "Nul", "AUX", "prn", "COM1", "lpt9"] {
            let error = StudyId::new(device).unwrap_err().to_string();
            assert!(error.contains(device), "{error}");
            assert!(error.contains("a device; choose another"), "{error}");
            assert!(ParticipantId::new(device).is_err(), "{device}");
            assert!(SessionId::new(device).is_err(), "{device}");
            assert!(serde_json::from_str::<SessionId>(&format!("{device:?}")).is_err());
        }
        for name in ["CONE", "COM", "COM0", "COM10", "P_CON", "LPT"] {
            assert!(StudyId::new(name).is_ok(), "{name}");
        }
    }

    #[test]
    fn ids_that_are_read_one_after_the_other_share_their_text() {
        let read = || serde_json::from_str::<Vec<ModeId>>(r#"["active", "hybrid"]"#).unwrap();
        let place = |id: &ModeId| id.as_str().as_ptr();
        let [first, second] = [read(), read()];
        assert!(first.iter().map(place).eq(second.iter().map(place)));
        assert_ne!(place(&first[0]), place(&first[1]));
        for i in 0..10 * REMEMBERED {
            let id = ModeId::new(format!("m{i}")).unwrap();
            assert_eq!(id.as_str(), format!("m{i}"));
            assert_eq!(place(&ModeId::new("active").unwrap()), place(&first[0]));
        }
    }

    #[test]
    fn a_bad_id_is_refused_while_a_file_is_read_too() {
        assert!(serde_json::from_str::<SessionId>("\"../x\"").is_err());
    }
}
