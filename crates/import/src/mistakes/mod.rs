//! Common faults of recordings, and files of other kinds: each is read correctly, refused with a
//! remedy, or flagged.
//!
//! The table in `docs/mistakes.md` is this one; each row is a fixture and the program's message
//! about it.

mod cells;
mod containers;
mod motion;
mod studies;
mod texts;
mod theirs;

use super::world::{FORCE, ONE, World, template_once, trials_map};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zwidth_store::Signal;

/// What becomes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Becomes {
    /// Read as if nothing were odd about it; the forces are those of [`PLAIN`].
    Read,
    /// Imported, and the report says what was noted.
    Flagged,
    /// Not imported.
    Refused,
}
use Becomes::{Flagged, Read, Refused};

/// A mistake, and what is said of it.
struct Row {
    /// For people.
    what: &'static str,
    becomes: Becomes,
    /// What the report or the error says, among other things.
    said: &'static str,
    map: String,
    files: Vec<(&'static str, Vec<u8>)>,
    /// Whether the first file is imported in a command before.
    is_twice: bool,
}

/// A question beside those of the template, which is answered on a slider.
const LINE: &str =
    "\n[[questions]]\nid = \"line\"\ntext = \"How real was it?\"\npoints = 101\nfrom = 0\n";

/// Times in s and forces in N as everybody should write them.
const PLAIN: &str = "t,f\n0,1.5\n0.5,-2\n1,4\n";

/// A file read by the usual mapping, with more keys in `[file]`.
fn file(
    what: &'static str,
    (becomes, said): (Becomes, &'static str),
    keys: &str,
    name: &'static str,
    content: impl AsRef<[u8]>,
) -> Row {
    let map = trials_map(&[&format!("[file]\n{keys}\n"), ONE, FORCE]);
    mapped(what, (becomes, said), map, name, content)
}

/// A file read by a mapping of its own.
fn mapped(
    what: &'static str,
    (becomes, said): (Becomes, &'static str),
    map: String,
    name: &'static str,
    content: impl AsRef<[u8]>,
) -> Row {
    let files = vec![(name, content.as_ref().to_vec())];
    Row { what, becomes, said, map, files, is_twice: false }
}

/// [`PLAIN`] with a text changed.
fn plain(
    what: &'static str,
    said: (Becomes, &'static str),
    keys: &str,
    from: &str,
    to: &str,
) -> Row {
    assert!(PLAIN.contains(from), "{from}");
    file(what, said, keys, "a.csv", PLAIN.replace(from, to))
}

fn rows() -> Vec<Row> {
    [
        texts::texts(),
        texts::cells(),
        theirs::mappings(),
        theirs::kinds(),
        studies::clocks(),
        studies::zeros(),
        studies::plans(),
        cells::cells_of_others(),
        motion::units(),
        motion::answers(),
        containers::containers(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What the program says of a row: the report, or every error.
fn told(row: &Row) -> (Becomes, String, World) {
    let world = World::with(&format!("{}{LINE}", template_once()));
    let files: Vec<PathBuf> =
        row.files.iter().map(|(name, bytes)| world.file(name, bytes)).collect();
    let rest = if row.is_twice {
        world.import(&row.map, &files[..1]).unwrap();
        &files[1..]
    } else {
        &files[..]
    };
    let (becomes, said) = match world.import(&row.map, rest) {
        Ok(report) => {
            let is_odd = report.files.iter().any(|file| {
                !(file.care.is_empty() && file.told.is_empty() && file.rows_dropped.is_empty())
            });
            let is_odd = is_odd || report.trials > 1 || !report.against_plan.is_empty();
            (if is_odd { Flagged } else { Read }, report.to_string())
        }
        Err(errors) => {
            (Refused, errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
        }
    };
    (becomes, said, world)
}

#[test]
fn every_common_mistake_is_read_right_refused_with_the_remedy_or_flagged() {
    let mut wrong = String::new();
    for row in rows() {
        let (becomes, said, world) = told(&row);
        if becomes != row.becomes || !said.contains(row.said) {
            let _ = writeln!(wrong, "{}: {becomes:?}\n{said}\n", row.what);
        }
        if row.becomes == Read && row.map.contains("from = \"f\"") && !row.map.contains("\"x\"") {
            assert_eq!(world.column(1, Signal::ForceEx), [1.5, -2.0, 4.0], "{}", row.what);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn the_table_in_the_documentation_is_this_one() {
    let mut table = String::from("| mistake or file | becomes | what is said |\n|---|---|---|\n");
    for Row { what, becomes, said, .. } in rows() {
        let becomes = match becomes {
            Read => "read",
            Flagged => "flagged",
            Refused => "refused",
        };
        let said =
            if said.is_empty() { String::new() } else { format!("`{}`", said.replace('`', "'")) };
        let _ = writeln!(table, "| {what} | {becomes} | {said} |");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/mistakes.md");
    let text = std::fs::read_to_string(path).unwrap();
    assert!(rows().len() >= 40);
    assert!(text.contains(&table), "docs/mistakes.md lacks this table:\n{table}");
}
