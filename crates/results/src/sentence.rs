//! Finished sentences.

use serde::Serialize;
use std::fmt;

/// A finished sentence in a row. It can be printed, and nothing else: what it says stands in the
/// row's other fields, and nobody takes it apart to learn that.
///
/// ```
/// # use zwidth_results::Sentence;
/// let sentence = Sentence::from("Primary metric: there are too few people");
/// assert_eq!(format!("{sentence}."), "Primary metric: there are too few people.");
/// ```
///
/// What would read it does not compile:
///
/// ```compile_fail
/// # use zwidth_results::Sentence;
/// Sentence::from("Primary metric").starts_with("Primary");
/// ```
///
/// ```compile_fail
/// # use zwidth_results::Sentence;
/// Sentence::from("P01 S01 trial 2: too short").split_once(": ");
/// ```
///
/// ```compile_fail
/// # use zwidth_results::Sentence;
/// let text: &str = &Sentence::from("different, but below what is felt");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct Sentence(String);

impl From<String> for Sentence {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl From<&str> for Sentence {
    fn from(text: &str) -> Self {
        Self(text.to_owned())
    }
}

impl fmt::Display for Sentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl std::str::FromStr for Sentence {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.into())
    }
}

crate::value::texts!(Sentence);
