//! What is fixed about a session when it is set up.

use crate::{
    Calibration, EnvironmentId, Kind, ModeId, OrderScheme, ParticipantId, Person, PersonColumnId,
    QuestionId, RECORD_VERSION, SessionId, Source, TaskPlace,
};
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;

/// `sessions/<participant>_<session>.json`: the session as it was set up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionRecord {
    /// Version of this file's form.
    pub schema_version: u32,
    /// Who.
    pub participant: ParticipantId,
    /// Which session.
    pub session: SessionId,
    /// Measured, simulated or imported.
    pub source: Source,
    /// Software that wrote the session, with its version.
    pub software: String,
    /// BLAKE3 of the `study.toml` in force, hexadecimal.
    pub study_blake3: String,
    /// The trials, in order. A questionnaire has trials without samples.
    pub trials: Vec<PlannedTrial>,
    /// The device, as it names itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// The calibration in force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// BLAKE3 of the calibration's file, hexadecimal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_blake3: Option<String>,
    /// Rate of the control loop, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The seed the order was drawn with; absent from a sealed session, because it would give the
    /// order away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How the order was drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<OrderRecord>,
    /// The commitment to the sealed order, hexadecimal ([`crate::Seal::commitment`]). With it the
    /// modes of `trials` are codes, and the session is sealed until an event opens it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commitment: Option<String>,
    /// The device check before the session.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checks: Vec<Check>,
    /// BLAKE3 of each recording that a questionnaire's session was imported from, hexadecimal,
    /// sorted. Files of samples say it themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub imported_from: Vec<String>,
    /// The columns of these recordings, counted from 1, whose answers the session has: another session
    /// may have others of them. Empty: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answer_columns: Vec<usize>,
    /// Whether the recordings count their trials from 0: a trial's number is one more than theirs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub counted_from_zero: bool,
    /// What was known of the person when the session began: their row of the participants' file, and what was drawn.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub person: Person,
    /// The columns of `person` whose level chance gave when this session began, or an earlier one of the person, and the
    /// block of the drawing, from 0.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drawn: BTreeMap<PersonColumnId, u32>,
    /// The pairs of scores, in the order in which the session asks for them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<AskedPair>,
}

/// A pair of a score, as a session asks for it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedPair {
    /// The question about it.
    pub question: QuestionId,
    /// Whether the second of the two is shown first. The answer is the number of the one that was chosen all the same.
    pub is_turned: bool,
}

/// How a session's order was drawn: together with the seed, everything that [`crate::order::draw`]
/// needs besides the study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderRecord {
    /// The scheme.
    pub scheme: OrderScheme,
    /// The participant's number in the counterbalancing.
    pub participant_number: u32,
    /// The session's number in the counterbalancing.
    pub session_number: u32,
}

/// One measurement of a device check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// What was measured.
    pub name: String,
    /// The value, a finite number.
    #[serde(serialize_with = "finite")]
    pub value: f64,
    /// Its unit; "1" for a plain number.
    pub unit: String,
    /// Whether it is good enough.
    pub ok: bool,
}

/// One trial of a session, recorded or only with questions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedTrial {
    /// Number within the session, from 1.
    pub trial: u32,
    /// Repeat of the condition, from 1; in a sealed session the place among the trials of its kind
    /// and environment, because a repeat tells which modes are alike.
    pub repeat: u32,
    /// Experiment or familiarisation.
    pub kind: Kind,
    /// Environment.
    pub environment: EnvironmentId,
    /// Mode (its sealed code until the session is unsealed).
    pub mode: ModeId,
    /// Whether a file of samples belongs to it.
    pub samples: bool,
    /// Its place in a task, if it is of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<TaskPlace>,
}

/// JSON has no other numbers; written as `null` they could not be read again.
fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if !value.is_finite() {
        return Err(serde::ser::Error::custom(format!(
            "{value} is not a finite number; leave the check out"
        )));
    }
    serializer.serialize_f64(*value)
}

impl SessionRecord {
    /// A record of nothing but its trials: device, calibration, order and checks are unknown or do
    /// not apply.
    pub fn new(
        participant: ParticipantId,
        session: SessionId,
        source: Source,
        software: impl Into<String>,
        study_blake3: impl Into<String>,
        trials: Vec<PlannedTrial>,
    ) -> Self {
        Self {
            schema_version: RECORD_VERSION,
            participant,
            session,
            source,
            software: software.into(),
            study_blake3: study_blake3.into(),
            trials,
            device: None,
            calibration: None,
            calibration_blake3: None,
            rate_hz: None,
            seed: None,
            order: None,
            commitment: None,
            checks: Vec::new(),
            imported_from: Vec::new(),
            answer_columns: Vec::new(),
            counted_from_zero: false,
            person: Person::new(),
            drawn: BTreeMap::new(),
            pairs: Vec::new(),
        }
    }

    /// The record as the text of its file.
    ///
    /// # Errors
    /// A check whose value is not a finite number.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> SessionRecord {
        let (participant, session) = ("P01".parse().unwrap(), "S01".parse().unwrap());
        SessionRecord::new(participant, session, Source::Recorded, "tests", "", Vec::new())
    }

    #[test]
    fn a_record_of_before_there_were_devices_is_read() {
        let old = r#"{ "schema_version": 1, "participant": "P01", "session": "S01", "source": "recorded",
            "software": "tests", "study_blake3": "", "trials": [] }"#;
        assert_eq!(serde_json::from_str::<SessionRecord>(old).unwrap(), record());
        assert!(!record().to_json().unwrap().contains("null"), "what is unknown is not written");
    }

    #[test]
    fn a_whole_record_comes_back() {
        let order =
            OrderRecord { scheme: OrderScheme::Williams, participant_number: 1, session_number: 2 };
        let check =
            Check { name: "rate".to_owned(), value: 119.9, unit: "Hz".to_owned(), ok: true };
        let whole = SessionRecord {
            device: Some("twin 1".to_owned()),
            calibration: Some(Calibration::thesis()),
            calibration_blake3: Some("00".to_owned()),
            rate_hz: Some(1000.0),
            seed: Some(u64::MAX),
            order: Some(order),
            pairs: vec![AskedPair { question: "a_or_b".parse().unwrap(), is_turned: true }],
            commitment: Some("11".to_owned()),
            checks: vec![check],
            ..record()
        };
        let again: SessionRecord = serde_json::from_str(&whole.to_json().unwrap()).unwrap();
        assert_eq!(again, whole);
    }

    #[test]
    fn a_check_without_a_number_is_refused_and_not_written_as_null() {
        let check =
            Check { name: "rate".to_owned(), value: f64::NAN, unit: "Hz".to_owned(), ok: false };
        let error = SessionRecord { checks: vec![check], ..record() }.to_json().unwrap_err();
        assert!(error.to_string().contains("NaN is not a finite number"), "{error}");
    }
}
