//! Whatever an import skips or loses of a recording is shown afterwards: in the report, in the
//! resulting files, in the log, and by `verify`.

use super::workbook::tests::{archive, xlsx};
use super::world::{FORCE, ONE, World, trials_map};
use super::{Report, xdf};
use std::fmt::Write as _;
use zwidth_store::{GAPS, LOST, Signal, StoreError, verify};
use zwidth_study::Event;

/// Force at 10 Hz, without a time.
const AT_A_RATE: &str = "
[time]
rate_hz = 10.0
[[column]]
to = \"force_ex_n\"
from = \"f\"
unit = \"N\"
";

/// Forces 1, 2 and 3 with two empty rows behind the first and one behind the second, and more at the
/// end, in every format that can have them; texts come block by block too.
fn with_empty_rows() -> Vec<(&'static str, Vec<u8>)> {
    let row = |line: u32, f: u32| format!("<row r=\"{line}\"><c><v>{f}</v></c></row>");
    let rows = "<row r=\"1\"><c t=\"inlineStr\"><is><t>f</t></is></c></row>".to_owned()
        + &row(2, 1)
        + "<row r=\"3\"><c t=\"inlineStr\"><is><t> </t></is></c></row>"
        + &row(5, 2)
        + &row(7, 3)
        + "<row r=\"8\"/>";
    let cell = |f: u32| {
        format!(
            "<table:table-row><table:table-cell office:value-type=\"float\" office:value=\"{f}\"/></table:table-row>"
        )
    };
    let empty = |n: u32| {
        format!(
            "<table:table-row table:number-rows-repeated=\"{n}\"><table:table-cell/></table:table-row>"
        )
    };
    let head = "<table:table-row><table:table-cell office:value-type=\"string\"><text:p>f</text:p></table:table-cell></table:table-row>";
    let sheet =
        [head, &cell(1), &empty(2), &cell(2), &empty(1), &cell(3), &empty(1_048_570)].concat();
    let content = format!(
        "<office:document-content><table:table table:name=\"a\">{sheet}</table:table></office:document-content>"
    );
    let ods = archive(&[
        ("mimetype", "application/vnd.oasis.opendocument.spreadsheet"),
        ("content.xml", &content),
    ]);
    vec![
        ("blank.csv", b"f,x\n1,\n\n\n2,\n\n3,\n\n\n".to_vec()),
        ("cells.csv", b"f,x\n1,\n,\n , \n2,\n\"\",\n3,\n,\n,\n".to_vec()),
        ("windows.csv", b"f,x\r\n1,0\r\n\r\n,\r\n2,0\r\n\r\n3,0\r\n\r\n".to_vec()),
        ("old.csv", b"f,x\r1,0\r\r\r2,0\r\r3,0\r\r".to_vec()),
        ("quoted.csv", b"f,x\n1,\"a\n\n\nb\"\n\n \n2,0\n# a remark\n\n3,0".to_vec()),
        ("a.tsv", b"f\tx\n1\t0\n\t\n\n2\t0\n\t\n3\t0\n\t\n".to_vec()),
        ("a.txt", b"f x\n1  0\n  \n\n2 0\n\n3 0\n\n".to_vec()),
        (
            "a.jsonl",
            b"{\"f\":1}\n{}\n{\"f\":null,\"x\":\"\",\"y\":\" \"}\n{\"f\":2}\n\n{\"f\":3}\n{}\n"
                .to_vec(),
        ),
        ("a.xlsx", xlsx(&[("data", &rows)])),
        ("a.ods", ods),
    ]
}

pub(super) type Imported = Result<Report, Vec<StoreError>>;

/// The same import whole and block by block, each into a study of its own.
pub(super) fn both(map: &str, name: &str, content: &[u8]) -> [(World, Imported); 2] {
    [false, true].map(|streamed| {
        let world = World::new();
        let files = [world.file(name, content)];
        let imported = match streamed {
            true => world.import_streamed(map, &files),
            false => world.import(map, &files),
        };
        (world, imported)
    })
}

#[test]
fn at_a_rate_each_empty_row_is_a_missing_sample_and_those_at_the_end_are_nothing() {
    let map = trials_map(&["[file]\ncomment = \"#\"\n", ONE, AT_A_RATE]);
    for (name, content) in with_empty_rows() {
        for (world, report) in both(&map, name, &content) {
            let report = report.unwrap_or_else(|errors| panic!("{name}: {errors:?}"));
            assert_eq!(world.column(1, Signal::ForceEx), [1.0, 2.0, 3.0], "{name}");
            assert_eq!(world.column(1, Signal::Time), [0.0, 0.3, 0.5], "{name}");
            let file = &report.files[0];
            assert_eq!((file.rows_read, file.rows_kept), (6, 3), "{name}");
            let dropped: Vec<_> = file.rows_dropped.iter().map(|d| (d.rows, &d.why[..5])).collect();
            assert_eq!(dropped, [(3, "empty")], "{name}");
            let gaps = &world.trial("P01", "S01", 1).file[GAPS];
            assert_eq!(gaps, "missing samples: 3 of 6 (empty rows: 3)", "{name}");
            assert!(!report.is_doubtful());
            world.load();
        }
    }
}

#[test]
fn with_a_time_an_empty_row_changes_nothing_and_is_told() {
    let map = trials_map(&[ONE, FORCE]);
    for (world, report) in both(&map, "a.csv", b"t,f\n\n0,1\n\n,\n0.5,2\n1,3\n\n") {
        let report = report.unwrap();
        assert_eq!(world.column(1, Signal::Time), [0.0, 0.5, 1.0]);
        assert!(report.to_string().contains("dropped   2 rows: empty\n"), "{report}");
        assert!(!world.trial("P01", "S01", 1).file.contains_key(GAPS));
    }
}

#[test]
fn empty_rows_wherever_blocks_end_give_the_same_times_as_in_a_short_text() {
    let mut text = "f,m\n".to_owned();
    for i in 0..3000 {
        let mode = if i < 1700 { "active" } else { "passive" };
        let value = if i % 11 == 3 { String::new() } else { i.to_string() };
        let _ = writeln!(text, "{value},{mode}{}", "\n".repeat(usize::from(i % 7 == 0) * (i % 5)));
    }
    text += &"\n".repeat(9000);
    text += "5,passive\n";
    let labels = ONE.replace("\"hybrid\"", "{ column = \"m\" }");
    let map = trials_map(&["[file]\nmissing = \"drop\"\n", &labels, AT_A_RATE]);
    let [(whole, of_whole), (streamed, of_streamed)] = both(&map, "a.csv", text.as_bytes());
    let [of_whole, of_streamed] = [of_whole, of_streamed].map(|report| report.unwrap());
    assert_eq!(of_whole.files[0].rows_dropped, of_streamed.files[0].rows_dropped);
    assert_eq!(of_whole.files[0].rows_read, of_streamed.files[0].rows_read);
    for trial in [1, 2] {
        let [a, b] = [&whole, &streamed].map(|world| world.trial("P01", "S01", trial));
        assert_eq!((&a.samples, &a.file), (&b.samples, &b.file));
        assert!(
            a.file[GAPS].contains("; rows without a value in a mapped column: "),
            "{}",
            a.file[GAPS]
        );
    }
    let t = whole.column(2, Signal::Time);
    assert!(t[t.len() - 1] - t[t.len() - 2] > 900.0, "{:?}", &t[t.len() - 2..]);
}

#[test]
fn rows_between_two_trials_are_missing_from_neither() {
    let labels = ONE.replace("\"hybrid\"", "{ column = \"m\" }");
    let map = trials_map(&["[file]\nmissing = \"drop\"\n", &labels, AT_A_RATE]);
    let text = "f,m\n1,active\n2,active\n,active\n\n\n3,passive\n\n4,passive\n";
    for (world, report) in both(&map, "a.csv", text.as_bytes()) {
        report.unwrap();
        assert!(!world.trial("P01", "S01", 1).file.contains_key(GAPS));
        assert_eq!(world.column(2, Signal::Time), [0.0, 0.2]);
    }
}

/// What is said of trial 1 of P01 S01 after its import: by its file, its log, and `verify`.
fn said_afterwards(world: &World) -> [String; 3] {
    let file = world.trial("P01", "S01", 1).file.remove(LOST).unwrap_or_default();
    let events = world.events("P01", "S01");
    let noted = events.into_iter().find_map(|event| match event {
        Event::Note { trial: Some(1), text } => Some(text),
        _ => None,
    });
    let found: Vec<String> = verify(&world.layout).iter().map(ToString::to_string).collect();
    [file, noted.unwrap_or_default(), found.join("\n")]
}

#[test]
fn what_is_lost_of_a_damaged_xdf_is_known_to_file_log_and_verify() {
    let force = FORCE.replace("from = \"t\"", "from = \"time_s\"").replace("\"f\"", "\"F & x\"");
    let map = trials_map(&["[file]\nstream = \"rig\"\n", ONE, &force]);
    let mut parts = xdf::tests::parts();
    let whole = parts.concat();
    parts[4][0] = 3;
    let footless = parts[..8].concat();
    let mut foreign = xdf::tests::parts();
    foreign[5][0] = 3;
    for (bytes, expect) in [
        (whole, ""),
        // What its footer counts is there: another stream was damaged.
        (foreign.concat(), ""),
        (parts.concat(), "1 of 3 samples are read: the XDF file is damaged or was cut off"),
        (footless, "1 samples are read, and it is not known how many are lost"),
    ] {
        let world = World::new();
        let report = world.import(&map, &[world.file("a.xdf", bytes)]).unwrap();
        assert_eq!(report.is_doubtful(), !expect.is_empty(), "{report}");
        let [file, noted, found] = said_afterwards(&world);
        assert!(file.starts_with(expect), "{file}");
        assert_eq!(noted, file);
        assert!(found.contains(&file) && (found.is_empty() == file.is_empty()), "{found}");
        assert!(
            file.is_empty() || found.contains("import a whole copy of the recording"),
            "{found}"
        );
        assert!(report.to_string().contains(&file), "{report}");
    }
}

#[test]
fn a_line_that_is_cut_off_and_passed_by_is_known_afterwards() {
    let map = trials_map(&["[file]\nbad_lines = 2\n", ONE, FORCE]);
    let world = World::new();
    let report = world.import(&map, &[world.file("a.csv", "t,f\n0,1\n1\n2,2\n3,3\n4")]).unwrap();
    assert!(report.is_doubtful());
    let [file, noted, found] = said_afterwards(&world);
    assert_eq!(file, "line 3 and 1 more could not be read, and are left out (bad_lines)");
    assert_eq!(noted, file);
    assert!(found.contains(&file), "{found}");
}

#[test]
fn a_line_that_could_not_be_read_is_lost_of_the_trial_before_it() {
    let labels = ONE.replace("\"hybrid\"", "{ column = \"m\" }");
    let map = trials_map(&["[file]\nbad_lines = 1\n", &labels, FORCE]);
    let world = World::new();
    let text = "t,f,m\n0,1,active\n1,2,active\n2\n0,3,passive\n1,4,passive\n";
    world.import(&map, &[world.file("a.csv", text)]).unwrap();
    let lost = |trial| world.trial("P01", "S01", trial).file.remove(LOST);
    assert!(lost(1).unwrap().starts_with("line 4 could not be read"));
    assert_eq!(lost(2), None);
}

#[test]
fn a_sweep_and_a_table_of_answers_say_what_was_lost_of_them() {
    let sweep = "kind = \"sweeps\"\n[file]\nbad_lines = 1\n[sweep]\nactuator = \"motor\"\n\
        [time]\nrate_hz = 10.0\n[command]\nname = \"u\"\nunit = \"V\"\nfrom = \"u\"\n\
        [response]\nname = \"F\"\nunit = \"N\"\nfrom = \"f\"\n";
    let world = World::new();
    let file = world.file("a.csv", "u,f\n0,1\n\n1,2\n2\n");
    assert!(world.import(sweep, &[file]).unwrap().is_doubtful());
    let path = world.layout.sweep(&"motor".parse().unwrap(), 1);
    let made = zwidth_store::read_sweep(&path).unwrap();
    assert_eq!(made.t_s, Some(vec![0.0, 0.2]));
    assert!(made.file[GAPS].starts_with("missing samples: 1 of 3"), "{:?}", made.file);
    assert!(made.file[LOST].starts_with("line 5 could not be read"), "{:?}", made.file);
    let found = verify(&world.layout);
    assert!(found.iter().any(|e| e.path == path && e.what == made.file[LOST]), "{found:?}");

    let answers = "kind = \"likert\"\n[file]\nbad_lines = 1\n[trial]\nparticipant = { column = \"who\" }\n\
        session = \"S01\"\nenvironment = \"spring\"\nmode = \"hybrid\"\n[questions.columns]\nfelt_spring = \"q\"\n";
    let file = world.file("b.csv", "who,q\nP01,1\n\nP02,2\nP03\n");
    let report = world.import(answers, &[file]).unwrap();
    assert!(
        report.is_doubtful() && report.to_string().contains("dropped   1 row: empty"),
        "{report}"
    );
    for who in ["P01", "P02"] {
        let is_note = |event: &Event| matches!(event, Event::Note { trial: None, text } if text.contains("line 5 could not be read"));
        assert!(world.events(who, "S01").iter().any(is_note));
    }
}
