//! The form of a study's trial files: which columns they have. `study.toml` names it, so that all
//! of a study's files are alike and open as one data set, and the study keeps the form with which
//! it began.

use crate::{AnswerScale, ChannelId, Study};
use serde::{Deserialize, Serialize};

/// A version of the form of trial files: `schema` of `study.toml`.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(try_from = "u32", into = "u32")]
pub enum Schema {
    /// Answers are events, and stand in the trial file too where the study has one question;
    /// channels of its own; a row group per 2²⁰ rows. Version 1 was never released.
    #[default]
    Two,
    /// What a trial of a task presented, and positions and forces in three axes, stand in the trial file, too.
    Three,
}

impl Schema {
    /// Its number.
    pub fn number(self) -> u32 {
        self.into()
    }

    /// The version of this number, if it is known.
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Two, Self::Three].into_iter().find(|schema| schema.number() == number)
    }
}

impl From<Schema> for u32 {
    fn from(schema: Schema) -> u32 {
        match schema {
            Schema::Two => 2,
            Schema::Three => 3,
        }
    }
}

impl TryFrom<u32> for Schema {
    type Error = String;

    fn try_from(number: u32) -> Result<Self, String> {
        Self::from_number(number)
            .ok_or_else(|| format!("version {number} is unknown; this software reads 2 and 3"))
    }
}

/// A quantity of a study's own that is recorded per sample: a column of its trial files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Its name: the column's.
    pub id: ChannelId,
    /// Its unit, as in the column's metadata; `1` for a pure number.
    pub unit: String,
    /// What it is, as in the column's metadata.
    pub description: String,
}

/// The channel of the current in the motor's winding, above 0 where it flows as a voltage above 0
/// drives it: the power U I that the motor takes from its supply is then above 0.
pub const CURRENT_MOTOR: &str = "current_motor_a";
/// The same of the brake's coil.
pub const CURRENT_BRAKE: &str = "current_brake_a";
/// The channel of the angle's set-point, in the coordinate of the angle.
pub const REFERENCE: &str = "reference_rad";
/// The channels that a stage reads, and the unit that they must have.
pub(crate) const READ_CHANNELS: [(&str, &str); 3] =
    [(CURRENT_MOTOR, "A"), (CURRENT_BRAKE, "A"), (REFERENCE, "rad")];

/// The form of a study's trial files.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialForm {
    /// The version.
    pub schema: Schema,
    /// Whether there is a column `likert`.
    pub likert: bool,
    /// The study's own channels, in the order of their columns.
    pub channels: Vec<Channel>,
}

impl Study {
    /// The form of this study's trial files. There is a column `likert` only if the study has one
    /// question, on a scale that has a name, so that its meaning is clear.
    pub fn trial_form(&self) -> TrialForm {
        let schema = self.schema;
        let channels = self.channels.clone();
        // The questions of tasks have no such column: their answers are events.
        let mut questions = self.questions.iter().filter(|question| !question.is_of_task());
        let one =
            questions.next().is_some_and(|question| AnswerScale::NAMED.contains(&question.scale))
                && questions.next().is_none();
        TrialForm { schema, likert: one, channels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{check_round_trip, demo, text};

    const GRIP: &str = "[[channels]]\nid = \"grip_n\"\nunit = \"N\"\n\
                        description = \"force of the grip\"\n";

    #[test]
    fn a_version_that_is_not_read_is_named_with_the_one_that_is() {
        let other = text().replace("schema = 2", "schema = 1");
        let error = Study::from_toml(&other).unwrap_err()[0].to_string();
        assert!(error.contains("version 1 is unknown; this software reads 2 and 3"), "{error}");
    }

    #[test]
    fn in_version_2_an_answer_has_a_column_only_where_there_is_one_question() {
        let several = demo();
        assert!(several.questions.len() > 1 && !several.trial_form().likert);
        let one = Study { questions: several.questions[..1].to_vec(), ..several };
        assert!(one.trial_form().likert);
        let seven = text().replacen("[[questions]]", "[[questions]]\npoints = 7", 1);
        let seven = Study::from_toml(&seven).unwrap();
        let one = Study { questions: seven.questions[..1].to_vec(), ..seven };
        assert!(!one.trial_form().likert);
    }

    #[test]
    fn channels_are_read_written_and_part_of_the_form() {
        let study = Study::from_toml(&format!("{}\n{GRIP}", text())).unwrap();
        assert_eq!(study.trial_form().channels[0].id.as_str(), "grip_n");
        check_round_trip(&study);
    }

    #[test]
    fn a_channel_that_is_none_is_refused_with_its_key() {
        let text = text();
        let refused = |text: String| Study::from_toml(&text).unwrap_err()[0].to_string();
        let with = |from: &str, to: &str| format!("{text}\n{}", GRIP.replace(from, to));
        assert!(refused(with("grip_n", "t_s")).contains("a column of every trial file"));
        assert!(refused(with("grip_n", "Grip")).contains("lower case"));
        assert!(refused(with("\"N\"", "\"\"")).contains("channels[0].unit"));
        let current = refused(with("\"grip_n\"", "\"current_motor_a\""));
        assert!(current.contains("channels[0].unit"), "{current}");
        assert!(current.contains("unit = \"A\""), "{current}");
        assert!(refused(format!("{text}\n{GRIP}\n{GRIP}")).contains("stands twice"));
        let three = with("grip_n", "force_x_n").replacen("schema = 2", "schema = 3", 1);
        assert!(refused(three).contains("of every trial file of schema 3"));
        assert!(Study::from_toml(&with("grip_n", "force_x_n")).is_ok());
        let many: String = (0..9).map(|i| GRIP.replace("grip_n", &format!("g{i}"))).collect();
        assert!(refused(format!("{text}\n{many}")).contains("at most 8"));
    }
}
