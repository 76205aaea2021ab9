//! OpenSim's storage files (`.sto`, `.mot`): a head of keys, then columns of text.
//!
//! Source of the format: OpenSim documentation, "Storage (.sto) Files" and "Motion (.mot) Files"; the keys of old
//! `.mot` files, `datarows` and `datacolumns`, as SIMM wrote them. OpenSim's own `Storage` reads a file whose head
//! counts its rows or columns wrong, and shifts its numbers.

use super::csv::{self, Dialect, WHITE_SPACE};
use super::limits::Take;
use super::table::Table;
use super::text::decode;
use std::path::Path;
use zwidth_store::StoreError;

/// The last line of the head.
const END: &str = "endheader";
/// Lines of a head that are looked at.
const MOST_LINES: usize = 1_000;

/// What a head says.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Head {
    lines: usize,
    rows: Option<usize>,
    columns: Option<usize>,
    in_degrees: Option<bool>,
    /// Whether tabs part the names of the columns.
    has_tabs: bool,
}

/// Reads a file. One that has more or fewer rows or columns than its head says is refused.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    dialect: Dialect,
    take: &Take,
) -> Result<Table, StoreError> {
    let remedy = "export it again from OpenSim, or set format = \"txt\" in [file] with skip for the lines before the names";
    let wrong = |what: String| StoreError::new(path, what, remedy);
    let text = decode(path, bytes, dialect.encoding)?;
    let head = head(&text).ok_or_else(|| wrong(format!("no line '{END}' ends its head")))?;
    let dialect = Dialect {
        delimiter: if head.has_tabs { b'\t' } else { WHITE_SPACE },
        header: true,
        comment: None,
        skip: head.lines,
        ..dialect
    };
    let mut table = csv::read(path, bytes, dialect, take)?;
    let counts =
        [("rows", head.rows, table.lines.len()), ("columns", head.columns, table.columns.len())];
    for (what, named, there) in counts {
        if let Some(named) = named.filter(|named| *named != there) {
            return Err(wrong(format!(
                "its head says that it has {named} {what}, and it has {there}"
            )));
        }
    }
    table.angles =
        head.in_degrees.map(|degrees| if degrees { ["deg", "deg/s"] } else { ["rad", "rad/s"] });
    Ok(table)
}

/// The head of a text; nothing if it has none.
fn head(text: &str) -> Option<Head> {
    let mut head = Head::default();
    let mut lines = text.lines().take(MOST_LINES);
    let mut count = 0;
    while let Some(line) = lines.next() {
        let line = line.trim();
        count += 1;
        if line.eq_ignore_ascii_case(END) {
            let has_tabs = lines.next().is_some_and(|names| names.contains('\t'));
            return Some(Head { lines: count, has_tabs, ..head });
        }
        let Some((key, value)) = line.split_once(['=', ' ', '\t']) else { continue };
        let (key, value) = (key.trim().to_ascii_lowercase(), value.trim());
        match key.as_str() {
            "nrows" | "datarows" => head.rows = value.parse().ok(),
            "ncolumns" | "datacolumns" => head.columns = value.parse().ok(),
            "indegrees" => head.in_degrees = Some(value.eq_ignore_ascii_case("yes")),
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::world::{World, trials_map};
    use zwidth_store::Signal;

    const MAP: &str = "[time]\nfrom = \"time\"\nunit = \"s\"\n[[column]]\nto = \"theta_rad\"\nfrom = \"elbow\"\nunit = \"deg\"\n\
                       [[column]]\nto = \"force_ex_n\"\nfrom = \"hand_fx\"\nunit = \"N\"\n";

    fn file(head: &str, rows: &str) -> String {
        format!("Coordinates\nversion=1\n{head}endheader\ntime\telbow\thand_fx\n{rows}")
    }

    #[test]
    fn a_head_says_what_there_is_and_whether_angles_are_in_degrees() {
        let rows = "0.00\t90\t1.5\n   0.01\t45\t-2\n";
        let map = trials_map(&[super::super::world::ONE, MAP]);
        for (name, head) in [
            (
                "a.sto",
                "nRows=2\nnColumns=3\ninDegrees=yes\n\nUnits are S.I. units (second, meters, Newtons, ...)\n",
            ),
            ("a.mot", "datarows 2\ndatacolumns 3\n"),
            ("b.mot", ""),
        ] {
            let world = World::new();
            let report = world.import(&map, &[world.file(name, file(head, rows))]).unwrap();
            assert_eq!(world.column(1, Signal::Time), [0.0, 0.01], "{name}");
            assert_eq!(world.column(1, Signal::Theta)[0].to_bits(), 90_f64.to_radians().to_bits());
            let care = &report.files[0].care;
            assert!(!care.iter().any(|care| care.contains("unit")), "{name}: {care:?}");
        }
        // The mapping and the head have not the same unit.
        let world = World::new();
        let told = file("inDegrees=no\n", rows);
        let report = world.import(&map, &[world.file("a.sto", told)]).unwrap();
        assert!(
            report.files[0].care.iter().any(|care| care.contains("its unit is 'rad'")),
            "{report:?}"
        );
    }

    #[test]
    fn a_head_that_counts_wrong_or_is_none_is_refused() {
        let map = trials_map(&[super::super::world::ONE, MAP]);
        let rows = "0\t90\t1.5\n1\t45\t-2\n";
        for (text, words) in [
            (file("nRows=3\n", rows), "it has 3 rows, and it has 2"),
            (file("nRows=2\nnColumns=4\n", rows), "it has 4 columns, and it has 3"),
            ("time\telbow\thand_fx\n0\t90\t1\n".to_owned(), "no line 'endheader' ends its head"),
        ] {
            let world = World::new();
            world.refuses(&map, &world.file("a.sto", text), words, None);
        }
        let world = World::new();
        let gap = file("nRows=2\n", "0\t90\tNaN\n1\t45\t-2\n");
        world.refuses(&map, &world.file("a.sto", gap), "NaN is not a number", Some(("hand_fx", 1)));
    }
}
