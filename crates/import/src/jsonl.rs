//! JSON lines: one object per line; keys are columns.

use super::limits::{MOST_LINE, MOST_WHOLE_ROWS, Take, check_columns, check_name, more_rows};
use super::spelling::shown;
use super::table::{Cells, EmptyRows, Table};
use super::text::{Encoding, decode};
use arrow::array::{ArrayBuilder as _, LargeStringBuilder};
use serde::Deserializer as _;
use serde::de::{MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use zwidth_store::StoreError;

/// Reads JSON lines. Numbers keep the text they were written with, strings lose their quotes,
/// `null`, Python's `NaN` and a missing key are empty cells. A blank line, and an object without a value, are empty
/// rows.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    encoding: Encoding,
    take: &Take,
) -> Result<Table, StoreError> {
    let text = decode(path, bytes, encoding)?;
    let text = text.as_ref();
    // All keys before any value: the last object may have one that no other has.
    let (names, lines) = keys(path, text)?;
    let numbered = names.iter().enumerate();
    let mut columns: Vec<Option<LargeStringBuilder>> = numbered
        .map(|(place, name)| take.wants(place, Some(name)).then(LargeStringBuilder::new))
        .collect();
    take.room(path, lines.len().saturating_mul(columns.iter().flatten().count()))?;
    for (row, (number, line)) in
        full_lines(text).filter(|(number, _)| lines.binary_search(number).is_ok()).enumerate()
    {
        walk(path, number, line, &mut |key, raw| {
            // The names are sorted: they come out of a set.
            let column = names.binary_search(&key).ok().and_then(|place| columns[place].as_mut());
            let Some(column) = column else { return Ok(()) };
            let cell = text_of(raw.get())?;
            column.append_option(Some(cell).filter(|cell| !cell.is_empty()));
            Ok(())
        })?;
        // A key that this object lacks.
        for column in columns.iter_mut().flatten().filter(|column| column.len() == row) {
            column.append_null();
        }
    }
    let columns = columns.into_iter().map(Cells::of_text).collect();
    let empty = EmptyRows::between(&lines);
    Ok(Table { columns, names: Some(names), lines, empty, ..Table::default() })
}

/// The lines that are not blank, with their numbers.
fn full_lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty())
}

/// Every key of the file, sorted, and the number of the line of each row.
fn keys(path: &Path, text: &str) -> Result<(Vec<String>, Vec<u64>), StoreError> {
    let mut names = BTreeSet::new();
    let mut lines = Vec::new();
    for (number, line) in full_lines(text) {
        if line.len() > MOST_LINE {
            let what =
                format!("line {number} has {} bytes, and at most {MOST_LINE} are read", line.len());
            let remedy = "write one object a line, without what is not needed";
            return Err(StoreError::new(path, what, remedy));
        }
        if lines.len() == MOST_WHOLE_ROWS {
            return Err(more_rows(path));
        }
        let mut has_value = false;
        walk(path, number, line, &mut |key, raw| {
            names.insert(key);
            has_value = has_value || !text_of(raw.get())?.is_empty();
            Ok(())
        })?;
        check_columns(path, names.len())?;
        if has_value {
            lines.push(number);
        }
    }
    names.iter().try_for_each(|name| check_name(path, name))?;
    Ok((names.into_iter().collect(), lines))
}

/// Takes a key and its value.
type Each<'a> = &'a mut dyn FnMut(String, &RawValue) -> Result<(), serde_json::Error>;

/// Walks through the keys of one object. A key that comes twice is an error: nobody knows which
/// value is meant.
fn walk(path: &Path, number: u64, line: &str, each: Each) -> Result<(), StoreError> {
    let line = without_nan(line);
    let mut reader = serde_json::Deserializer::from_str(&line);
    let walked = reader.deserialize_map(Keys(each)).and_then(|()| reader.end());
    walked.map_err(|error| {
        let what = format!(
            "line {number} is not a JSON object with each key once (JSON lines are one object a line, without infinities): {error}"
        );
        StoreError::new(path, what, "the file may be cut off; mend or remove the line")
    })
}

/// A line with `null` for every `NaN` outside its texts: Python's `json.dumps` writes that for a missing
/// number, and it is not JSON.
fn without_nan(line: &str) -> Cow<'_, str> {
    if !line.contains("NaN") {
        return Cow::Borrowed(line);
    }
    let mut plain = String::new();
    // A quote behind a backslash does not end a text; a backslash behind one is a letter.
    let mut in_text = false;
    let mut escaped = false;
    let mut from = 0;
    for (at, letter) in line.char_indices() {
        if !in_text && at >= from && line[at..].starts_with("NaN") {
            plain.push_str(&line[from..at]);
            plain.push_str("null");
            from = at + "NaN".len();
        }
        in_text ^= letter == '"' && !escaped;
        escaped = letter == '\\' && !escaped;
    }
    Cow::Owned(plain + &line[from..])
}

struct Keys<'a>(Each<'a>);

impl<'de> Visitor<'de> for Keys<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut object: M) -> Result<(), M::Error> {
        use serde::de::Error as _;
        let mut seen = BTreeSet::new();
        while let Some(key) = object.next_key::<String>()? {
            if !seen.insert(key.clone()) {
                return Err(M::Error::custom(format!("the key '{}' comes twice", shown(&key))));
            }
            let value: &RawValue = object.next_value()?;
            self.0(key, value).map_err(M::Error::custom)?;
        }
        Ok(())
    }
}

fn text_of(raw: &str) -> Result<String, serde_json::Error> {
    match raw.as_bytes().first() {
        Some(b'"') => serde_json::from_str::<String>(raw).map(|s| s.trim().to_owned()),
        _ if raw == "null" => Ok(String::new()),
        _ => Ok(raw.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::limits::MOST_COLUMNS;
    use super::super::limits::tests::{everything, only};
    use super::super::table::Cell;
    use super::*;

    fn read(text: &str) -> Result<Table, StoreError> {
        let path = Path::new("a.jsonl");
        everything(|take| super::read(path, text.as_bytes(), Encoding::Utf8, take))
    }

    #[test]
    fn keys_are_columns_and_numbers_keep_their_digits() {
        let text = "{\"t\": 0.1, \"mode\": \"act\\u0069ve\"}\n\n{\"t\": 1e-321, \"f\": null}\r\n";
        let table = read(text).unwrap();
        assert_eq!(table.names.as_ref().unwrap(), &["f", "mode", "t"]);
        let cell = |c: usize, r: usize| table.columns[c].cell(r);
        assert_eq!((cell(2, 0), cell(2, 1)), (Cell::Text("0.1"), Cell::Text("1e-321")));
        assert_eq!((cell(1, 0), cell(1, 1)), (Cell::Text("active"), Cell::Empty));
        assert_eq!((cell(0, 0), cell(0, 1)), (Cell::Empty, Cell::Empty));
        assert_eq!(table.lines, [1, 3]);
    }

    #[test]
    fn a_nan_of_python_is_missing_and_one_in_a_text_is_a_word() {
        let text = "{\"t\": NaN, \"NaN\": \"a \\\"NaN\\\\\", \"f\": NaN}\n{\"t\": 1}\n";
        let table = read(text).unwrap();
        assert_eq!(table.names.as_ref().unwrap(), &["NaN", "f", "t"]);
        assert_eq!(table.columns[0].cell(0), Cell::Text("a \"NaN\\"));
        assert_eq!(
            (table.columns[1].cell(0), table.columns[2].cell(0)),
            (Cell::Empty, Cell::Empty)
        );
        for bad in ["{\"t\": Infinity}\n", "{\"t\": NaNaN}\n"] {
            let error = read(bad).unwrap_err();
            assert!(error.what.contains("without infinities"), "{error}");
        }
    }

    #[test]
    fn a_cut_line_and_a_line_that_is_no_object_are_refused_with_the_line() {
        for bad in ["{\"t\": 1}\n{\"t\": ", "{\"t\": 1}\n[1, 2]\n"] {
            let error = read(bad).unwrap_err();
            assert!(error.what.contains("line 2 is not a JSON object"), "{error}");
        }
    }

    #[test]
    fn a_key_that_comes_twice_in_an_object_is_refused_however_it_is_written() {
        for bad in ["{\"t\": 1, \"f\": 2, \"t\": 3}\n", "{\"t\": 1, \"\\u0074\": 3}\n"] {
            let error = read(&format!("{{\"t\": 0}}\n{bad}")).unwrap_err();
            assert!(
                error.what.contains("line 2") && error.what.contains("the key 't' comes twice"),
                "{error}"
            );
        }
    }

    #[test]
    fn thirty_thousand_keys_are_refused_in_one_line_or_in_many() {
        let one: String = (0..30_000).map(|i| format!("\"k{i}\":1,")).collect();
        let many: String = (0..30_000).map(|i| format!("{{\"k{i}\":1}}\n")).collect();
        for text in [format!("{{{}}}", one.trim_end_matches(',')), many] {
            let error = read(&text).unwrap_err();
            assert!(
                error.what.contains(&format!("and at most {MOST_COLUMNS} are read")),
                "{error}"
            );
        }
    }

    #[test]
    fn an_enormous_line_is_refused_and_deep_nesting_is_no_matter() {
        let long = format!("{{\"t\": 1}}\n{{\"t\": \"{}\"}}", "x".repeat(MOST_LINE));
        let error = read(&long).unwrap_err();
        assert!(
            error.what.contains("line 2 has") && error.what.contains("at most 1048576"),
            "{error}"
        );
        let deep = format!("{{\"t\": 1, \"x\": {}{}}}", "[".repeat(500_000), "]".repeat(500_000));
        let path = Path::new("a.jsonl");
        let read = |take: &Take| super::read(path, deep.as_bytes(), Encoding::Utf8, take);
        let table = only(&["t"], read).unwrap();
        assert_eq!(table.columns[0].cell(0), Cell::Text("1"));
        assert!(matches!(table.columns[1], Cells::Unread));
    }
}
