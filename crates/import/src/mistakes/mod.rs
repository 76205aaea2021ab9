//! Common faults of recordings, and files of other kinds: each is read correctly, refused with a
//! remedy, or flagged.
//!
//! The table in `docs/mistakes.md` says what becomes of each and what the program says of it; each row
//! here is the fixture.

mod cells;
mod containers;
mod laboratories;
mod motion;
mod space;
mod studies;
mod texts;
mod theirs;

use super::world::{FORCE, ONE, World, template_once, trials_map};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zwidth_store::Signal;

/// A mistake: what is imported, and by which mapping. The documentation says what becomes of it.
struct Row {
    /// As the documentation calls it.
    what: &'static str,
    map: String,
    files: Vec<(&'static str, Vec<u8>)>,
    /// Whether the first file is imported in a command before.
    is_twice: bool,
    /// Whether the study has axes.
    has_axes: bool,
}

/// A question beside those of the template, which is answered on a slider.
const LINE: &str =
    "\n[[questions]]\nid = \"line\"\ntext = \"How real was it?\"\npoints = 101\nfrom = 0\n";

/// Times in s and forces in N as everybody should write them.
const PLAIN: &str = "t,f\n0,1.5\n0.5,-2\n1,4\n";

/// A mapping of a table with a column of answers.
const LIKERT: &str = "kind = \"likert\"\n[trial]\nparticipant = { column = \"who\" }\nsession = \"S01\"\nenvironment = \"spring\"\n\
                      mode = { column = \"mode\" }\n[questions.columns]\nfelt_spring = \"q\"\n";

/// A file read by the usual mapping.
fn file(what: &'static str, name: &'static str, content: impl AsRef<[u8]>) -> Row {
    mapped(what, trials_map(&[ONE, FORCE]), name, content)
}

/// A CSV file read by the usual mapping, with more keys in `[file]`.
fn csv(what: &'static str, keys: &str, content: impl AsRef<[u8]>) -> Row {
    mapped_csv(what, trials_map(&[&format!("[file]\n{keys}\n"), ONE, FORCE]), content)
}

/// [`PLAIN`] with a text changed.
fn plain(what: &'static str, keys: &str, from: &str, to: &str) -> Row {
    assert!(PLAIN.contains(from), "{from}");
    csv(what, keys, PLAIN.replace(from, to))
}

/// A CSV file read by a mapping of its own.
fn mapped_csv(what: &'static str, map: String, content: impl AsRef<[u8]>) -> Row {
    mapped(what, map, "a.csv", content)
}

/// A file read by a mapping of its own.
fn mapped(what: &'static str, map: String, name: &'static str, content: impl AsRef<[u8]>) -> Row {
    Row {
        what,
        map,
        files: vec![(name, content.as_ref().to_vec())],
        is_twice: false,
        has_axes: false,
    }
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
        space::axes(),
        motion::answers(),
        containers::containers(),
        laboratories::laboratories(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What becomes of a row, and what the program says of it: the report, or every error.
fn told(row: &Row) -> (&'static str, String, World) {
    let study = format!("{}{LINE}", template_once());
    let world = match row.has_axes {
        true => World::with(&(study.replacen("schema = 2", "schema = 3", 1) + space::AXES)),
        false => World::with(&study),
    };
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
                !(file.care.is_empty()
                    && file.told.is_empty()
                    && file.lost.is_none()
                    && file.rows_dropped.is_empty())
            });
            let is_odd = is_odd || report.trials > 1 || !report.against_plan.is_empty();
            (if is_odd { "flagged" } else { "read" }, report.to_string())
        }
        Err(errors) => {
            ("refused", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
        }
    };
    (becomes, said, world)
}

/// Each row of the documentation's table: the mistake, what becomes of it (`read` as if nothing were odd
/// about it, `flagged` or `refused`), and what is said, among other things.
fn documented(text: &str) -> Vec<[&str; 3]> {
    let rows = text.lines().skip_while(|line| *line != "|---|---|---|").skip(1);
    let rows = rows.map_while(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
    let cells = rows.map(|row| {
        let cells: Vec<&str> = row.split(" | ").collect();
        <[&str; 3]>::try_from(cells).unwrap()
    });
    cells.collect()
}

#[test]
fn every_common_mistake_in_the_documentation_is_read_right_refused_with_the_remedy_or_flagged() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/mistakes.md");
    let text = std::fs::read_to_string(path).unwrap();
    let expected = documented(&text);
    let rows = rows();
    assert!(rows.len() >= 40);
    let listed: Vec<&str> = expected.iter().map(|[what, ..]| *what).collect();
    assert_eq!(rows.iter().map(|row| row.what).collect::<Vec<_>>(), listed);
    let mut wrong = String::new();
    for (row, [_, expect, words]) in rows.iter().zip(expected) {
        let (becomes, said, world) = told(row);
        // The table has its words between backticks, and apostrophes for those within them.
        let words = words.trim_matches('`');
        let is_said = said.replace('`', "'").contains(words);
        // Only of what is read there may be nothing to say.
        if becomes != expect || !is_said || (words.is_empty() && expect != "read") {
            let _ = writeln!(wrong, "{}: {becomes}\n{said}\n", row.what);
        }
        if expect == "read" && row.map.contains("from = \"f\"") && !row.map.contains("\"x\"") {
            // The forces are those of `PLAIN`.
            assert_eq!(world.column(1, Signal::ForceEx), [1.5, -2.0, 4.0], "{}", row.what);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
