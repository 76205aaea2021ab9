//! Labels: where a participant, a session, a mode, … of a recording comes from.

use super::spelling::{find, plain};
use super::table::ColumnRef;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The source of a label, and its translation.
#[derive(Debug, Clone)]
pub(super) struct Label {
    pub(super) from: From,
    /// Their word → ours. Where there is a table, every word must stand in it.
    pub(super) translate: BTreeMap<String, String>,
    /// Set before the word.
    pub(super) prefix: String,
    /// Whole numbers are filled with zeros to this many digits.
    pub(super) digits: usize,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum From {
    /// The same for all files.
    Fixed(String),
    /// A column.
    Column(ColumnRef),
    /// A named group of the pattern on the file's path.
    Name(String),
}

/// A label as it stands in a mapping file: `"P01"`, `3`, `{ column = "mode", translate = {…} }`.
#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a fixed value, or { column = … } or { name = … }, with translate, prefix, digits"
)]
pub(super) enum LabelShape {
    Text(String),
    Number(u32),
    From(FromShape),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FromShape {
    column: Option<ColumnRef>,
    name: Option<String>,
    #[serde(default)]
    translate: BTreeMap<String, String>,
    #[serde(default)]
    prefix: String,
    #[serde(default)]
    digits: usize,
}

/// Most digits a number is filled to: an id has at most 32 characters.
const MAX_DIGITS: usize = 32;

impl LabelShape {
    /// The checked label; `Err` says what is wrong. `groups` are those of the pattern on the path.
    pub(super) fn check(self, groups: &[&str]) -> Result<Label, String> {
        let FromShape { column, name, translate, prefix, digits } = match self {
            Self::Text(text) => return Ok(Label::fixed(text)),
            Self::Number(number) => return Ok(Label::fixed(number.to_string())),
            Self::From(shape) => shape,
        };
        let from = match (column, name) {
            (Some(column), None) => From::Column(column),
            (None, Some(name)) if groups.contains(&name.as_str()) => From::Name(name),
            (None, Some(name)) => {
                return Err(format!(
                    "'{name}' is not a named group (?<{name}>…) of the pattern in [name]"
                ));
            }
            _ => return Err("needs either column or name".to_owned()),
        };
        if digits > MAX_DIGITS {
            return Err(format!("digits = {digits} is more than an id can hold ({MAX_DIGITS})"));
        }
        Ok(Label { from, translate, prefix, digits })
    }
}

impl Label {
    /// The same for all files.
    pub(super) fn fixed(text: impl Into<String>) -> Self {
        let from = From::Fixed(text.into());
        Self { from, translate: BTreeMap::new(), prefix: String::new(), digits: 0 }
    }

    /// The column it comes from, where it comes from one.
    pub(super) fn column(&self) -> Option<&ColumnRef> {
        match &self.from {
            From::Column(column) => Some(column),
            _ => None,
        }
    }

    /// Their word as ours.
    pub(super) fn ours(&self, theirs: &str) -> Result<String, String> {
        if !self.translate.is_empty() {
            return find(&self.translate, theirs).cloned().ok_or_else(|| {
                let words =
                    self.translate.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                format!("'{theirs}' is not in the translation table, which has {words}")
            });
        }
        // Of a truth value the study may have the very spelling: its ids are compared later.
        let whole = plain(theirs);
        let digits = whole.bytes().all(|b| b.is_ascii_digit());
        let theirs = if digits { whole.as_ref() } else { theirs };
        if self.digits > 0 && !digits {
            return Err(format!(
                "'{theirs}' is not a whole number, which digits = {} asks for",
                self.digits
            ));
        }
        Ok(format!("{}{theirs:0>width$}", self.prefix, width = self.digits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(toml: &str) -> Result<Label, String> {
        #[derive(Deserialize)]
        struct File {
            x: LabelShape,
        }
        let file: File = toml::from_str(toml).map_err(|e| e.to_string())?;
        file.x.check(&["mode"])
    }

    fn check(toml: &str, theirs: &str, expect: Result<&str, &str>) {
        match (label(toml).unwrap().ours(theirs), expect) {
            (Ok(found), Ok(expect)) => assert_eq!(found, expect),
            (Err(found), Err(words)) => assert!(found.contains(words), "{found}"),
            (found, _) => panic!("{found:?}"),
        }
    }

    #[test]
    fn a_word_is_translated_prefixed_and_filled_with_zeros_and_a_whole_number_may_have_decimals() {
        check("x = { column = \"p\", prefix = \"P\", digits = 2 }", "7", Ok("P07"));
        check("x = { column = 2, prefix = \"P\" }", "120", Ok("P120"));
        check("x = { name = \"mode\", translate = { A = \"active\" } }", "A", Ok("active"));
        check("x = { name = \"mode\", translate = { A = \"active\" } }", "B", Err("which has A"));
        check("x = { column = 2, digits = 2 }", "x", Err("not a whole number"));
        check("x = { column = \"p\", prefix = \"P\", digits = 2 }", "1.0", Ok("P01"));
        check("x = { column = \"p\" }", "12.00", Ok("12"));
        check("x = { column = \"p\" }", "3,0", Ok("3"));
        check("x = { column = \"m\", translate = { 1 = \"active\" } }", "1.0", Ok("active"));
        check("x = { column = \"p\", digits = 2 }", "1.5", Err("'1.5' is not a whole number"));
    }

    #[test]
    fn fixed_values_are_text_or_numbers() {
        assert_eq!(label("x = \"P01\"").unwrap().from, From::Fixed("P01".to_owned()));
        assert_eq!(label("x = 3").unwrap().from, From::Fixed("3".to_owned()));
    }

    #[test]
    fn a_label_that_comes_from_nowhere_is_refused() {
        for (toml, words) in [
            ("x = { prefix = \"P\" }", "either column or name"),
            ("x = { column = 1, name = \"mode\" }", "either column or name"),
            ("x = { column = 1, digits = 99 }", "digits"),
        ] {
            let error = label(toml).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
