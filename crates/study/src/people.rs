//! What is known of the people of a study: columns that `study.toml` names, values of the participants'
//! file.

use crate::{LevelId, ParticipantId, PersonColumnId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A column of the participants' file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PersonColumn {
    /// Its name.
    pub id: PersonColumnId,
    /// What stands in it.
    pub known: Known,
}

/// What a column says of people.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum Known {
    /// One of some levels, such as a group.
    Level {
        /// The levels, in the order of `study.toml`.
        levels: Vec<LevelId>,
        /// Whether chance chose everybody's level.
        assigned: bool,
    },
    /// A number.
    Number {
        /// Its unit.
        unit: String,
    },
}

/// The forms of a participants' file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeopleForm {
    /// TOML, a table for each participant.
    Toml,
    /// CSV, a line for each participant.
    Csv,
}

/// What is known of one person in one column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PersonValue {
    /// The level.
    Level(LevelId),
    /// The number, in the column's unit.
    Number(f64),
}

/// The rows of a participants' file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct People(pub(crate) BTreeMap<ParticipantId, Person>);

/// A row of the participants' file: what is known of a person. What is not has no entry.
pub type Person = BTreeMap<PersonColumnId, PersonValue>;

impl fmt::Display for PersonValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level(level) => level.fmt(f),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl People {
    /// A number of this name has no decimals: with them it would be a date of birth.
    pub const AGE: &str = "age_years";

    /// The row of somebody, if they have one.
    pub fn row(&self, who: &ParticipantId) -> Option<&Person> {
        self.0.get(who)
    }

    /// Everybody who has a row, in the order of their codes.
    pub fn iter(&self) -> impl Iterator<Item = (&ParticipantId, &Person)> {
        self.0.iter()
    }

    /// The level of somebody in a column, if it is known.
    pub fn level(&self, who: &ParticipantId, column: &PersonColumnId) -> Option<&LevelId> {
        match self.0.get(who)?.get(column)? {
            PersonValue::Level(level) => Some(level),
            PersonValue::Number(_) => None,
        }
    }

    /// The number of somebody in a column, in its unit, if it is known.
    pub fn number(&self, who: &ParticipantId, column: &PersonColumnId) -> Option<f64> {
        match self.0.get(who)?.get(column)? {
            PersonValue::Number(number) => Some(*number),
            PersonValue::Level(_) => None,
        }
    }
}
