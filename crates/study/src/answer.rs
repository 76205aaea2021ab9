//! The number of an answer.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A number that was answered: whole on most scales, any number on a line
/// ([`crate::AnswerScale::is_line`]). It is the `f64` that was written, never rounded.
///
/// It is finite, and zero has no sign, so that equal numbers are equal answers and all of them have
/// an order. A whole number is written as one (`47`), as it was before answers could have decimals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnswerValue(f64);

/// A text or a number that is not an answer on any scale.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not a number from {min} to {max}", min = AnswerValue::RANGE.start(), max = AnswerValue::RANGE.end())]
pub struct NoAnswer(String);

impl AnswerValue {
    /// The range of answers that are read: wider than any scale, and no wider than a journal can
    /// hold.
    pub const RANGE: RangeInclusive<i16> = i16::MIN..=i16::MAX;

    /// The answer of this number.
    ///
    /// # Errors
    /// A number that is not finite, or beyond [`AnswerValue::RANGE`].
    pub fn new(number: f64) -> Result<Self, NoAnswer> {
        let range = f64::from(*Self::RANGE.start())..=f64::from(*Self::RANGE.end());
        if range.contains(&number) {
            Ok(Self(number + 0.0)) // -0 + 0 is 0
        } else {
            Err(NoAnswer(number.to_string()))
        }
    }

    /// The number.
    pub const fn get(self) -> f64 {
        self.0
    }

    /// The whole number that it is; `None` if it has decimals.
    #[allow(clippy::cast_possible_truncation)]
    pub fn whole(self) -> Option<i16> {
        (self.0.fract() == 0.0).then_some(self.0 as i16)
    }

    /// As far from the one end of a scale as this answer is from the other, where `ends` is the sum
    /// of both.
    pub(crate) fn turned(self, ends: i16) -> Self {
        Self(f64::from(ends) - self.0)
    }
}

impl From<i16> for AnswerValue {
    fn from(whole: i16) -> Self {
        Self(whole.into())
    }
}

impl From<AnswerValue> for f64 {
    fn from(answer: AnswerValue) -> Self {
        answer.0
    }
}

impl FromStr for AnswerValue {
    type Err = NoAnswer;

    fn from_str(text: &str) -> Result<Self, NoAnswer> {
        let answer = text.parse().ok().and_then(|number| Self::new(number).ok());
        answer.ok_or_else(|| NoAnswer(text.to_owned()))
    }
}

impl fmt::Display for AnswerValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Eq for AnswerValue {}

impl Ord for AnswerValue {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for AnswerValue {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Hash for AnswerValue {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}

impl Serialize for AnswerValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.whole() {
            Some(whole) => serializer.serialize_i16(whole),
            None => serializer.serialize_f64(self.0),
        }
    }
}

impl<'de> Deserialize<'de> for AnswerValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(f64::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Event;
    use proptest::prelude::*;

    fn logged(value: AnswerValue) -> String {
        let question = "q".parse().unwrap();
        serde_json::to_string(&Event::Answer { trial: 1, question, value, time_ms: None }).unwrap()
    }

    #[test]
    fn a_whole_answer_is_logged_as_a_whole_number_and_another_with_its_decimals() {
        let line = |value: &str| {
            format!(r#"{{"event":"answer","trial":1,"question":"q","value":{value}}}"#)
        };
        for (text, written) in [("47", "47"), ("-3.0", "-3"), ("-0.0", "0"), ("47.273", "47.273")] {
            let value: AnswerValue = text.parse().unwrap();
            assert_eq!((logged(value), value.to_string()), (line(written), written.to_owned()));
            let read: Event = serde_json::from_str(&line(text)).unwrap();
            assert_eq!(serde_json::to_string(&read).unwrap(), line(written));
        }
    }

    #[test]
    fn what_is_no_number_of_any_scale_is_no_answer() {
        for text in ["NaN", "inf", "-inf", "1e999", "32768", "-32768.1", "", "x", "4,5", "4 5"] {
            assert_eq!(text.parse::<AnswerValue>(), Err(NoAnswer(text.to_owned())));
        }
        let told = "40000".parse::<AnswerValue>().unwrap_err().to_string();
        assert_eq!(told, "'40000' is not a number from -32768 to 32767");
        for json in ["1e999", "40000", "-32768.5", "null", "\"4\"", "true", "123456789012345678901"]
        {
            assert!(serde_json::from_str::<AnswerValue>(json).is_err(), "{json}");
        }
    }

    proptest! {
        #[test]
        fn an_answer_is_read_from_a_log_as_it_was_given_to_the_last_bit(number in -32_768.0..32_767.0) {
            let value = AnswerValue::new(number).unwrap();
            let Event::Answer { value: read, .. } = serde_json::from_str(&logged(value)).unwrap()
            else { panic!("another event") };
            prop_assert_eq!(read.get().to_bits(), value.get().to_bits());
            prop_assert_eq!(value.to_string().parse(), Ok(value));
        }

        #[test]
        fn whole_answers_are_equal_and_ordered_as_their_numbers(a: i16, b: i16) {
            let [x, y] = [a, b].map(AnswerValue::from);
            prop_assert_eq!((x.cmp(&y), x == y, x.whole()), (a.cmp(&b), a == b, Some(a)));
            prop_assert_eq!(serde_json::to_string(&x).unwrap(), a.to_string());
        }
    }
}
