//! JSON that may have been changed by hand, or made to do harm.
//!
//! If a key occurs twice, readers differ in which value they use, so an object with such a key is
//! refused. So is a text with more keys, or deeper nesting, than any file of ours.

use serde::de::{DeserializeOwned, DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};
use std::cell::Cell;
use std::collections::HashSet;
use std::fmt;

/// Keys of all objects of one text together: ten for each of the trials of the largest session
/// record.
pub const MOST_KEYS: usize = 1 << 20;
/// Objects and lists within each other; ours go down to five.
const MOST_NESTED: usize = 16;

/// Reads JSON of ours.
///
/// # Errors
/// Text that is not JSON, or not of this form; a key that occurs twice in an object; more than
/// [`MOST_KEYS`] keys; objects and lists nested more than 16 deep. With line and column.
pub fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    let keys = Cell::new(0);
    let mut reader = serde_json::Deserializer::from_str(text);
    // A pass of its own: the reader of a map takes the last of two equal keys in silence.
    Look { keys: &keys, depth: 0 }.deserialize(&mut reader)?;
    reader.end()?;
    serde_json::from_str(text)
}

/// Looks at a value and keeps nothing of it.
#[derive(Clone, Copy)]
struct Look<'c> {
    /// Keys seen so far.
    keys: &'c Cell<usize>,
    depth: usize,
}

impl Look<'_> {
    /// The same, one level further down.
    fn inside<E: Error>(self) -> Result<Self, E> {
        if self.depth == MOST_NESTED {
            return Err(E::custom(format!("nested more than {MOST_NESTED} deep")));
        }
        Ok(Self { depth: self.depth + 1, ..self })
    }
}

impl<'de> DeserializeSeed<'de> for Look<'_> {
    type Value = ();

    fn deserialize<D: serde::Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Look<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let inside = self.inside()?;
        while list.next_element_seed(inside)?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut object: A) -> Result<(), A::Error> {
        let inside = self.inside()?;
        let mut seen = HashSet::new();
        while let Some(key) = object.next_key::<String>()? {
            if self.keys.replace(self.keys.get() + 1) == MOST_KEYS {
                return Err(A::Error::custom(format!("more than {MOST_KEYS} keys")));
            }
            if let Some(twice) = seen.replace(key) {
                return Err(A::Error::custom(format!("the key {twice:?} stands twice")));
            }
            object.next_value_seed(inside)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    type Map = BTreeMap<String, serde_json::Value>;

    fn refused(text: &str) -> String {
        from_json::<Map>(text).unwrap_err().to_string()
    }

    #[test]
    fn a_key_that_stands_twice_is_refused_at_any_depth_and_said_with_its_place() {
        let twice = refused(r#"{"a": 1, "a": 1}"#);
        assert_eq!(twice, r#"the key "a" stands twice at line 1 column 12"#);
        let deep = refused("{\"a\": [{\"b\": {}},\n{\"c\": 1, \"d\": 2, \"c\": 3}]}");
        assert!(deep.contains("\"c\" stands twice"), "{deep}");
        let escaped = refused(r#"{"a": 1, "\u0061": 2}"#);
        assert!(escaped.contains("\"a\" stands twice"), "however it is written: {escaped}");
        let apart = r#"{"a": {"a": [1, -2.5, null, true, "x"]}, "b": {"a": 1}}"#;
        assert_eq!(from_json::<Map>(apart).unwrap().len(), 2);
    }

    #[test]
    fn what_is_nested_deeper_than_anything_of_ours_is_refused() {
        let nested =
            |depth: usize| format!("{{\"a\": {}{}}}", "[".repeat(depth), "]".repeat(depth));
        assert!(from_json::<Map>(&nested(MOST_NESTED - 1)).is_ok());
        assert!(refused(&nested(MOST_NESTED)).contains("nested more than 16 deep"));
        assert!(refused(&nested(1 << 20)).contains("nested more than 16 deep"));
    }

    #[test]
    fn more_keys_than_any_file_of_ours_has_are_refused_and_thirty_thousand_are_not_too_many() {
        let keys = |n: usize| {
            format!("{{{}}}", (0..n).map(|i| format!("\"{i}\":0")).collect::<Vec<_>>().join(","))
        };
        assert_eq!(from_json::<Map>(&keys(30_000)).unwrap().len(), 30_000);
        assert!(refused(&keys(MOST_KEYS + 1)).contains("more than 1048576 keys"));
    }

    #[test]
    fn text_behind_the_value_is_refused() {
        assert!(refused("{} {}").contains("trailing characters"));
        assert!(refused("{\"a\": }").contains("line 1"));
    }
}
