//! Factors: what several modes, environments or sessions of a study have in common.

use crate::{EnvironmentId, FactorId, IdError, LevelId, ModeId, SessionId};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// A factor, an entry of `[[factors]]` of `study.toml`: every mode, every environment, or every session, has
/// one of its levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
// What was expected is told in the same words as for [`crate::Design`].
#[serde(deny_unknown_fields, expecting = "struct FactorTable")]
pub struct Factor {
    /// Its id.
    pub id: FactorId,
    /// Its levels; every later one is compared with the first. Of a dose: its numbers, ascending.
    #[serde(deserialize_with = "words_or_numbers")]
    pub levels: Vec<LevelId>,
    /// The unit of a dose; none of levels that are words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What has the levels.
    #[serde(default)]
    pub of: FactorOf,
}

/// What has the levels of a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FactorOf {
    /// Modes.
    #[default]
    Modes,
    /// Environments.
    Environments,
    /// Sessions: the levels are their ids.
    Sessions,
}

/// The level of each factor that a mode or an environment has.
pub type Levels = BTreeMap<FactorId, LevelId>;

/// A level as study.toml has it: a word, or the number of a dose.
struct WordOrNumber(LevelId);

impl<'de> Deserialize<'de> for WordOrNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl Visitor<'_> for Read {
            type Value = WordOrNumber;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a level: a word, or a number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<WordOrNumber, E> {
                LevelId::new(text).map(WordOrNumber).map_err(E::custom)
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<WordOrNumber, E> {
                self.visit_str(&number.to_string())
            }

            fn visit_f64<E: de::Error>(self, number: f64) -> Result<WordOrNumber, E> {
                self.visit_str(&number.to_string())
            }
        }
        deserializer.deserialize_any(Read)
    }
}

fn words_or_numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<LevelId>, D::Error> {
    let levels = Vec::<WordOrNumber>::deserialize(deserializer)?;
    Ok(levels.into_iter().map(|level| level.0).collect())
}

/// The levels of a mode or an environment.
pub(crate) fn levels<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Levels, D::Error> {
    let levels = BTreeMap::<FactorId, WordOrNumber>::deserialize(deserializer)?;
    Ok(levels.into_iter().map(|(factor, level)| (factor, level.0)).collect())
}

impl Factor {
    /// The doses, ascending; `None` if the levels are words.
    pub fn doses(&self) -> Option<Vec<f64>> {
        self.unit.as_ref()?;
        self.levels.iter().map(|level| level.as_str().parse().ok()).collect()
    }
}

/// How the doses of a factor are compared: an entry of `[compare.trend]` of `study.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct TrendTable")]
pub struct Trend {
    /// 1: a line; 2: its bend, too.
    #[serde(default = "one")]
    pub degree: u8,
    /// Over what the line is drawn.
    #[serde(default)]
    pub scale: DoseScale,
}

fn one() -> u8 {
    1
}

impl Default for Trend {
    fn default() -> Self {
        Self { degree: 1, scale: DoseScale::Linear }
    }
}

/// Over what a dose's line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DoseScale {
    /// The dose.
    #[default]
    Linear,
    /// Its doublings.
    Log2,
}

/// What an effect is of: a factor, or several whose interaction it is. A weighted contrast has its own name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Term(pub Vec<FactorId>);

impl Term {
    const CROSSED: char = ':';
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ids: Vec<&str> = self.0.iter().map(FactorId::as_str).collect();
        f.pad(&ids.join(&Self::CROSSED.to_string()))
    }
}

impl FromStr for Term {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        text.split(Self::CROSSED).map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}

impl TryFrom<String> for Term {
    type Error = IdError;

    fn try_from(text: String) -> Result<Self, IdError> {
        text.parse()
    }
}

impl From<Term> for String {
    fn from(term: Term) -> Self {
        term.to_string()
    }
}

/// A contrast between any conditions, an entry of `[[compare.weighted]]` of `study.toml`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Weighted {
    /// Its name.
    pub id: FactorId,
    /// The conditions that it weighs; the weights add up to 0.
    pub weights: Vec<Weight>,
}

/// What a condition's mean counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Weight {
    /// The session in which the condition counts; `None` where everybody's sessions are averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<SessionId>,
    /// The condition's environment.
    pub environment: EnvironmentId,
    /// Its mode.
    pub mode: ModeId,
    /// Its weight.
    pub weight: f64,
}
