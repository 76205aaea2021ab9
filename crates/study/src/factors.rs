//! Factors: what several modes, environments or sessions of a study have in common.

use crate::{EnvironmentId, FactorId, IdError, LevelId, ModeId, SessionId};
use serde::{Deserialize, Serialize};
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
    /// Its levels; every later one is compared with the first.
    pub levels: Vec<LevelId>,
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
