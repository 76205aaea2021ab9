//! What was tried, and with which result: chores note it, and `cargo xtask reliability` makes
//! `docs/reliability.md` from it. A row of the page stays until a longer run of the same chore
//! replaces it: the notes are in a build folder, which may be emptied at any time.

use crate::shell::{files, target};
use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;
use zwidth_store::hex_blake3;

/// One thing that was tried many times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Tried {
    /// What, in words.
    what: String,
    /// How to try it again.
    command: String,
    /// How often.
    times: u64,
    /// How often a promise was broken.
    broken: u64,
    /// How long it took, s.
    seconds: f64,
}

/// Where the notes lie: beside what cargo builds, one file a thing.
fn folder() -> PathBuf {
    target().join("tried")
}

/// Notes how often something was tried since `began`, and how often a promise was broken, in the
/// place of an earlier, shorter try of the same.
pub(crate) fn note(
    what: &str,
    command: String,
    times: u64,
    broken: u64,
    began: Instant,
) -> anyhow::Result<()> {
    let path = folder().join(format!("{}.json", &hex_blake3(what.as_bytes())[..16]));
    let before: Option<Tried> =
        std::fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if before.is_some_and(|before| before.times > times && broken == 0) {
        return Ok(());
    }
    let seconds = began.elapsed().as_secs_f64();
    let tried = Tried { what: what.to_owned(), command, times, broken, seconds };
    std::fs::create_dir_all(folder())?;
    Ok(std::fs::write(&path, serde_json::to_vec_pretty(&tried)?)?)
}

/// Notes what was tried so often since `began` without a promise broken.
pub(crate) fn held(what: &str, command: String, times: u64, began: Instant) -> anyhow::Result<()> {
    note(what, command, times, 0, began)
}

/// Writes the table of all notes into `docs/reliability.md`, between its marks.
pub(crate) fn reliability() -> anyhow::Result<()> {
    const PATH: &str = "docs/reliability.md";
    let text = std::fs::read_to_string(PATH)?;
    let mut notes: Vec<Tried> = Vec::new();
    let paths = files(&folder())
        .context("nothing was tried yet: run `cargo xtask soak …` and `cargo xtask fuzz` first")?;
    for path in paths {
        let note = serde_json::from_slice(&std::fs::read(&path)?)
            .with_context(|| format!("{} is no note", path.display()))?;
        notes.push(note);
    }
    Ok(std::fs::write(PATH, put(&text, &notes)?)?)
}

const BEGIN: &str = "<!-- begin: cargo xtask reliability -->\n";
pub(crate) const END: &str = "<!-- end -->\n";

const HEAD: &str = "| tried | times | promises broken | took | again |\n|---|---|---|---|---|\n";

/// What stands before a mark, between it and the next end, and after that.
pub(crate) fn parts<'a>(text: &'a str, begin: &str) -> anyhow::Result<[&'a str; 3]> {
    let (before, rest) =
        text.split_once(begin).context("the page lost the mark at which its table begins")?;
    let (between, after) =
        rest.split_once(END).context("the page lost the mark at which its table ends")?;
    Ok([before, between, after])
}

/// The text with the notes in the table between its marks, in order of their words.
fn put(text: &str, notes: &[Tried]) -> anyhow::Result<String> {
    let [before, table, after] = parts(text, BEGIN)?;
    let earlier = table.strip_prefix(HEAD).unwrap_or_default().lines();
    let mut rows: BTreeMap<String, String> =
        earlier.map(|row| (cell(row, WHAT).to_owned(), row.to_owned())).collect();
    for tried in notes {
        let times = rows.get(&tried.what).map_or(0, |row| ungrouped(cell(row, TIMES)));
        if tried.broken > 0 || times <= tried.times {
            rows.insert(tried.what.clone(), row(tried));
        }
    }
    let table: String = rows.values().map(|row| format!("{row}\n")).collect();
    Ok(format!("{before}{BEGIN}{HEAD}{table}{END}{after}"))
}

/// Columns of the table.
const WHAT: usize = 0;
const TIMES: usize = 1;

fn cell(row: &str, column: usize) -> &str {
    row.trim_matches('|').split('|').nth(column).unwrap_or_default().trim()
}

fn row(Tried { what, command, times, broken, seconds }: &Tried) -> String {
    let times = grouped(*times);
    let took = match *seconds {
        seconds if seconds < 120.0 => format!("{seconds:.0} s"),
        seconds => format!("{:.0} min", seconds / 60.0),
    };
    format!("| {what} | {times} | {broken} | {took} | `{command}` |")
}

/// 1,000,000 as 1000000.
fn ungrouped(text: &str) -> u64 {
    text.replace(',', "").parse().unwrap_or(0)
}

/// 1000000 as 1,000,000.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kills(times: u64, broken: u64) -> Tried {
        let command = format!("cargo xtask soak kill {times}");
        Tried { what: "a kill".to_owned(), command, times, broken, seconds: 300.0 }
    }

    #[test]
    fn the_table_stands_between_its_marks_and_nothing_else_changes() {
        let page = format!("# Title\n{BEGIN}{HEAD}{END}rest\n");
        let row = "| a kill | 1,234,567 | 0 | 5 min | `cargo xtask soak kill 1234567` |\n";
        let made = put(&page, &[kills(1_234_567, 0)]).unwrap();
        assert_eq!(made, format!("# Title\n{BEGIN}{HEAD}{row}{END}rest\n"));
        assert!(put("no marks", &[]).is_err());
    }

    #[test]
    fn a_row_stays_until_a_longer_try_or_a_broken_promise_takes_its_place() {
        let page = put(&format!("{BEGIN}{HEAD}{END}"), &[kills(1000, 0)]).unwrap();
        assert_eq!(put(&page, &[]).unwrap(), page);
        assert_eq!(put(&page, &[kills(50, 0)]).unwrap(), page);
        assert!(put(&page, &[kills(2000, 0)]).unwrap().contains("| a kill | 2,000 | 0 |"));
        assert!(put(&page, &[kills(50, 1)]).unwrap().contains("| a kill | 50 | 1 |"));
    }
}
