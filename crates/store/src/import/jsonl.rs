//! JSON lines: one object a line, keys are columns.

use super::table::{Cells, Table};
use super::text::decode;
use crate::StoreError;
use arrow::array::LargeStringArray;
use serde_json::value::RawValue;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Reads JSON lines. Numbers keep the text they were written with, strings lose their quotes, `null`
/// and a missing key are empty cells.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Table, StoreError> {
    let text = decode(path, bytes)?;
    let mut lines = Vec::new();
    let mut rows: Vec<BTreeMap<String, String>> = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        rows.push(row(line).map_err(|e| {
            let what = format!("line {} is not a JSON object: {e}", i + 1);
            StoreError::new(path, what, "the file may be cut off; mend or remove the line")
        })?);
        lines.push(i as u64 + 1);
    }
    let names: BTreeSet<&String> = rows.iter().flat_map(BTreeMap::keys).collect();
    let names: Vec<String> = names.into_iter().cloned().collect();
    let column = |name: &String| {
        let cell = |row: &BTreeMap<String, String>| row.get(name).filter(|t| !t.is_empty()).cloned();
        Cells::Text(rows.iter().map(cell).collect::<LargeStringArray>())
    };
    let columns = names.iter().map(column).collect();
    Ok(Table { names: Some(names), columns, lines })
}

/// One object, its values as text.
fn row(line: &str) -> Result<BTreeMap<String, String>, serde_json::Error> {
    let object: BTreeMap<String, &RawValue> = serde_json::from_str(line)?;
    object.into_iter().map(|(key, value)| Ok((key, text(value.get())?))).collect()
}

fn text(raw: &str) -> Result<String, serde_json::Error> {
    match raw.as_bytes().first() {
        Some(b'"') => serde_json::from_str::<String>(raw).map(|s| s.trim().to_owned()),
        _ if raw == "null" => Ok(String::new()),
        _ => Ok(raw.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Cell;
    use super::*;

    #[test]
    fn keys_are_columns_and_numbers_keep_their_digits() {
        let text = "{\"t\": 0.1, \"mode\": \"act\\u0069ve\"}\n\n{\"t\": 1e-321, \"f\": null}\r\n";
        let table = read(Path::new("a.jsonl"), text.as_bytes()).unwrap();
        assert_eq!(table.names.as_ref().unwrap(), &["f", "mode", "t"]);
        let cell = |c: usize, r: usize| table.columns[c].cell(r);
        assert_eq!((cell(2, 0), cell(2, 1)), (Cell::Text("0.1"), Cell::Text("1e-321")));
        assert_eq!((cell(1, 0), cell(1, 1)), (Cell::Text("active"), Cell::Empty));
        assert_eq!((cell(0, 0), cell(0, 1)), (Cell::Empty, Cell::Empty));
        assert_eq!(table.lines, [1, 3]);
    }

    #[test]
    fn a_cut_line_and_a_line_that_is_no_object_are_refused_with_the_line() {
        for bad in ["{\"t\": 1}\n{\"t\": ", "{\"t\": 1}\n[1, 2]\n"] {
            let error = read(Path::new("a.jsonl"), bad.as_bytes()).unwrap_err();
            assert!(error.what.contains("line 2 is not a JSON object"), "{error}");
        }
    }
}
