//! Bad recordings and bad mappings, through the program: one clear error that says file, column,
//! row and remedy, and a study as it was before.

use crate::binary::{Ran, zwidth};
use crate::folders::{flip_bit, listing, truncate};
use crate::small::{Study, repeats};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;
use zwidth_store::{Signal, read_parquet, read_trial, write_parquet};

const LABELS: &str = r#"
kind = "trials"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "hybrid"
"#;
const COLUMNS: &str = r#"
[time]
from = "t"
unit = "s"
[[column]]
to = "theta_rad"
from = "angle"
unit = "deg"
[[column]]
to = "force_ex_n"
from = "f"
unit = "N"
"#;

/// Four samples as they should be.
pub(crate) const GOOD: &str = "t,angle,f\n0.00,-45,0.1\n0.01,-44,0.2\n0.02,-42,0.4\n0.03,-45,0.0\n";

/// A study that `zwidth new` made, a mapping, and a folder of recordings.
pub(crate) struct World {
    pub(crate) folder: TempDir,
    pub(crate) map: String,
}

impl World {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        zwidth(folder.path(), &["new", "rig"]).exits(0);
        let study = folder.path().join("raw/rig/study.toml");
        let text = fs::read_to_string(&study).unwrap().replace("repeats = 6", "repeats = 1");
        fs::write(&study, text).unwrap();
        Self { folder, map: format!("{LABELS}{COLUMNS}") }
    }

    /// The same world, its mapping with one text in place of another.
    pub(crate) fn mapping(mut self, from: &str, to: &str) -> Self {
        assert!(self.map.contains(from), "{}", self.map);
        self.map = self.map.replacen(from, to, 1);
        self
    }

    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.folder.path().join(name);
        fs::write(&path, content).unwrap();
        path
    }

    pub(crate) fn import(&self, files: &[PathBuf]) -> Ran {
        let map = self.file("map.toml", &self.map);
        let mut arguments = vec!["import", "rig", "--map", map.to_str().unwrap()];
        arguments.extend(files.iter().map(|f| f.to_str().unwrap()));
        zwidth(self.folder.path(), &arguments)
    }

    /// The import must fail with one error that says all of `words`, and leave the study as it is.
    #[track_caller]
    pub(crate) fn refuses(&self, files: &[PathBuf], words: &[&str]) {
        let raw = self.folder.path().join("raw");
        let before = listing(&raw);
        self.import(files).exits(1).one_error().says(words);
        assert_eq!(listing(&raw), before, "something was left behind");
    }

    /// The import must refuse this text as `bad.csv`.
    #[track_caller]
    pub(crate) fn refuses_text(&self, content: impl AsRef<[u8]>, words: &[&str]) {
        self.refuses(&[self.file("bad.csv", content)], words);
    }

    /// The import must take this text, and give these forces, bit for bit.
    #[track_caller]
    pub(crate) fn takes(&self, content: impl AsRef<[u8]>, forces_n: &[f64]) {
        self.import(&[self.file("good.csv", content)]).exits(0);
        let path =
            self.folder.path().join("raw/rig/trials/participant=P01/session=S01/trial-001.parquet");
        let trial = read_trial(&path, Signal::all()).unwrap();
        let found = trial.samples.get(Signal::ForceEx).unwrap();
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found), bits(forces_n), "{found:?}");
        zwidth(self.folder.path(), &["verify", "rig"]).exits(0);
    }
}

/// [`GOOD`], with one text in place of another.
pub(crate) fn good_but(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from));
    GOOD.replacen(from, to, 1)
}

#[test]
fn good_samples_are_taken() {
    World::new().takes(GOOD, &[0.1, 0.2, 0.4, 0.0]);
}

#[test]
fn a_wrong_unit_in_a_mapping_is_refused_with_its_line() {
    let volts = World::new().mapping("unit = \"deg\"", "unit = \"mV\"");
    volts.refuses_text(
        GOOD,
        &[
            "map.toml",
            "line 15",
            "column[0].unit",
            "mV",
            "theta_rad",
            "rad, mrad, deg",
            "mend the line",
        ],
    );
    let unknown = World::new().mapping("unit = \"deg\"", "unit = \"furlong\"");
    unknown.refuses_text(GOOD, &["map.toml", "line 15", "furlong", "mend the line"]);
    // Millimetres become an angle only where the study's coordinate is a length.
    let length = World::new().mapping("unit = \"deg\"", "unit = \"mm\"");
    length.refuses_text(
        GOOD,
        &["map.toml", "column angle", "coordinate.kind", "add it to study.toml"],
    );
}

#[test]
fn a_missing_column_is_refused_with_the_columns_there_are() {
    World::new().refuses_text(
        good_but("angle", "theta"),
        &["bad.csv", "column angle", "missing", "t, theta, f", "name the column as the file does"],
    );
}

#[test]
fn a_cell_that_is_no_number_is_refused_with_column_and_row() {
    let world = World::new();
    for (cell, what) in [
        ("NaN", "NaN is not a number"),
        ("inf", "finite"),
        ("1e999", "finite"),
        ("", "empty"),
        ("x", "'x'"),
    ] {
        world.refuses_text(
            good_but("0.2", cell),
            &["bad.csv", "column f", "row 2", "line 3", what, "mend the cell"],
        );
    }
}

#[test]
fn time_that_runs_backwards_or_stands_still_is_refused_with_its_row() {
    for (time, what, remedy) in [
        ("0.005", "0.005 s after 0.01 s", "else mend the recording"),
        ("0.01", "0.01 s after 0.01 s", "set equal = \"drop\" in [time] if rows come twice"),
    ] {
        let words =
            ["bad.csv", "column t", "row 3", "time runs backwards or stands still", what, remedy];
        World::new().refuses_text(good_but("0.02", time), &words);
    }
}

#[test]
fn a_duplicate_trial_is_refused_in_one_import_and_in_the_next() {
    let world = World::new().mapping("mode = \"hybrid\"", "mode = \"hybrid\"\ntrial = 7");
    let (a, b) = (world.file("a.csv", GOOD), world.file("b.csv", good_but("0.4", "0.5")));
    world.refuses(
        &[a.clone(), b.clone()],
        &["b.csv", "duplicate trial", "trial 7 of P01 S01", "a.csv", "a number of its own"],
    );
    world.refuses(&[a.clone(), a.clone()], &["a.csv", "given twice"]);
    world.import(&[a]).exits(0);
    world.refuses(
        &[b],
        &["b.csv", "duplicate trial", "trial-007.parquet already", "sessions are imported whole"],
    );
}

#[test]
fn an_empty_file_and_one_of_0_rows_are_refused() {
    let world = World::new();
    world.refuses_text("", &["bad.csv", "the file is empty", "leave it out"]);
    world.refuses_text("\u{feff}\r\n", &["bad.csv", "the file is empty", "leave it out"]);
    world.refuses_text("t,angle,f\n", &["bad.csv", "the file has 0 rows", "leave the file out"]);
}

#[test]
fn text_that_is_cut_or_no_text_is_refused_with_its_line() {
    let world = World::new();
    world.refuses_text(
        "t,angle,f\n0,1,2\n0.01,1",
        &["bad.csv", "line 3 has 2 cells where 3 belong", "cut off"],
    );
    world.refuses_text(
        b"t,angle,f\n0,1,2\n0.01,1,\xff\n",
        &["bad.csv", "line 3 is not UTF-8", "save the file as UTF-8"],
    );
}

#[test]
fn one_bad_file_among_good_ones_keeps_all_of_them_out() {
    let world = World::new();
    let good = world.file("c.csv", good_but("0.4", "0.5"));
    let files = [world.file("a.csv", GOOD), world.file("bad.csv", good_but("0.4", "NaN")), good];
    world.refuses(&files, &["bad.csv", "column f", "row 3"]);
}

#[test]
fn denormals_are_taken_with_their_bits() {
    World::new().takes(
        good_but("0.1", "1e-321").replace("0.2", "-1.98614e-321"),
        &[1e-321, -1.98614e-321, 0.4, 0.0],
    );
}

#[test]
fn carriage_returns_and_a_byte_order_mark_are_taken() {
    World::new().takes(GOOD.replace('\n', "\r\n"), &[0.1, 0.2, 0.4, 0.0]);
    World::new().takes(format!("\u{feff}{GOOD}"), &[0.1, 0.2, 0.4, 0.0]);
}

#[test]
fn semicolons_with_decimal_commas_are_taken_where_the_mapping_says_so() {
    let text = GOOD.replace(',', ";").replace('.', ",");
    let dialect = "kind = \"trials\"\n[file]\ndelimiter = \";\"\ndecimal = \",\"";
    World::new().mapping("kind = \"trials\"", dialect).takes(&text, &[0.1, 0.2, 0.4, 0.0]);
    World::new().refuses_text(
        &text,
        &["bad.csv", "line 2 has 3 cells where 1 belong", "set delimiter in [file]"],
    );
    let delimiter = "kind = \"trials\"\n[file]\ndelimiter = \";\"";
    World::new().mapping("kind = \"trials\"", delimiter).refuses_text(
        "t;angle;f\n0;1;2\n1;1,5;2\n",
        &[
            "bad.csv",
            "column angle",
            "row 2",
            "line 3",
            "'1,5' is not a number with '.' before",
            "set delimiter and decimal",
        ],
    );
}

#[test]
fn an_id_that_is_a_path_is_refused_everywhere() {
    let world = World::new().mapping("participant = \"P01\"", "participant = \"../x\"");
    world.refuses_text(
        GOOD,
        &["'../x' is not a valid participant id", "change participant in the mapping"],
    );
    let world = World::new().mapping("session = \"S01\"", "session = { column = \"who\" }");
    let text = "t,angle,f,who\n0,1,2,../x\n";
    world.refuses_text(
        text,
        &["bad.csv", "column who", "row 1", "'../x' is not a valid session id", "mend the value"],
    );
    let root = world.folder.path();
    let before = listing(root);
    let map = root.join("map.toml");
    for bad in [
        &["new", "../x"][..],
        &["run", "../x"],
        &["verify", "../x"],
        &["list", "/etc"],
        &["table", "..", "metrics"],
        &["import", "../x", "--map", map.to_str().unwrap(), "bad.csv"],
    ] {
        zwidth(root, bad).exits(2).says(&["not a valid study id", "1 to 32 of the letters"]);
    }
    assert_eq!(listing(root), before);
}

#[test]
fn a_damaged_parquet_recording_is_refused() {
    let theirs = Study::new("theirs");
    theirs.session("P01", &repeats("spring", "hybrid", 1..=1));
    let map = "[time]\nfrom = \"t_s\"\nunit = \"s\"\n[[column]]\nto = \"force_ex_n\"\nfrom = \"force_ex_n\"\nunit = \"N\"\n";
    let world = World { map: format!("{LABELS}{map}"), ..World::new() };
    let path = world.folder.path().join("theirs.parquet");
    let length = fs::metadata(theirs.trial("P01", 1)).unwrap().len() as usize;
    for cut in [0, 3, 100, length / 2, length - 1] {
        fs::copy(theirs.trial("P01", 1), &path).unwrap();
        truncate(&path, cut);
        world.refuses(std::slice::from_ref(&path), &["theirs.parquet"]);
    }
    fs::copy(theirs.trial("P01", 1), &path).unwrap();
    flip_bit(&path, length - 20);
    world.refuses(std::slice::from_ref(&path), &["theirs.parquet"]);
    let (batch, footer) = read_parquet(&theirs.trial("P01", 1)).unwrap();
    fs::write(&path, write_parquet(&batch.slice(0, 0), footer, &path).unwrap()).unwrap();
    world.refuses(&[path], &["theirs.parquet", "the file has 0 rows", "leave the file out"]);
}

#[test]
fn a_study_or_a_mapping_that_is_not_there_or_not_understood_is_told() {
    let world = World::new();
    let good = world.file("a.csv", GOOD);
    let map = world.file("map.toml", &world.map);
    let root = world.folder.path();
    let import = |study: &str, map: &str, file: &str| {
        zwidth(root, &["import", study, "--map", map, file]).exits(1)
    };
    let (map, good) = (map.to_str().unwrap(), good.to_str().unwrap());
    import("nothing", map, good).says(&["raw/nothing/study.toml", "zwidth new nothing"]);
    import("rig", "nothing.toml", good).says(&["nothing.toml", "cannot read", "check the path"]);
    import("rig", map, "nothing.csv").says(&["nothing.csv", "cannot read", "check the path"]);
    World::new()
        .mapping("kind = \"trials\"", "kind = \"trails\"")
        .refuses_text(GOOD, &["map.toml", "line 2", "trails"]);
    let toml = root.join("raw/rig/study.toml");
    let text = fs::read_to_string(&toml).unwrap().replace("schema = 2", "schema = 9");
    fs::write(&toml, text).unwrap();
    import("rig", map, good).says(&[
        "study.toml",
        "line 5",
        "schema",
        "version 9 is unknown",
        "this software reads 2 and 3",
    ]);
}

/// An XDF recording of three streams' worth of chunks: `chunks` of 20 samples at 100 Hz, each behind a
/// boundary, of a stream whose footer counts them all.
fn xdf(chunks: usize) -> Vec<u8> {
    let chunk = |tag: u16, stream: Option<u32>, content: &[u8]| {
        let stream = stream.map(|stream| stream.to_le_bytes().to_vec()).unwrap_or_default();
        let inner = [&tag.to_le_bytes()[..], &stream, content].concat();
        let length = u32::try_from(inner.len()).unwrap().to_le_bytes();
        [&[4][..], &length, &inner].concat()
    };
    let boundary = [
        0x43, 0xa5, 0x46, 0xdc, 0xcb, 0xf5, 0x41, 0x0f, 0xb3, 0x0e, 0xd5, 0x46, 0x73, 0x83, 0xcb,
        0xe4,
    ];
    let head = "<info><name>rig</name><channel_count>2</channel_count><nominal_srate>0</nominal_srate>\
        <channel_format>double64</channel_format><desc><channels><channel><label>angle</label></channel>\
        <channel><label>f</label></channel></channels></desc></info>";
    let mut file =
        [b"XDF:".to_vec(), chunk(1, None, b"<info/>"), chunk(2, Some(1), head.as_bytes())];
    for part in 0..chunks {
        let mut content = vec![1, 20];
        for sample in 0..20 {
            let i = f64::from(u32::try_from(20 * part + sample).unwrap());
            let values =
                [0.01 * i, -45.0 + 15.0 * (1.0 - (0.03 * i).cos()), 4.0 * (0.03 * i).sin()];
            content.push(8);
            content.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        file[2].extend(chunk(5, None, &boundary));
        file[2].extend(chunk(3, Some(1), &content));
    }
    let count = format!("<info><sample_count>{}</sample_count></info>", 20 * chunks);
    file[2].extend(chunk(5, None, &boundary));
    file[2].extend(chunk(6, Some(1), count.as_bytes()));
    file.concat()
}

#[test]
fn a_damaged_xdf_is_told_by_import_list_verify_and_run() {
    let world = World::new().mapping("from = \"t\"", "from = \"time_s\"");
    let mut damaged = xdf(6);
    // The length of the third chunk of samples is none: up to the next boundary all is lost.
    let boundary = [0x43, 0xa5, 0x46, 0xdc];
    let places: Vec<usize> =
        (0..damaged.len() - 4).filter(|i| damaged[*i..*i + 4] == boundary).collect();
    damaged[places[2] + 16] = 9;
    let file = world.file("damaged.xdf", &damaged);
    let lost = "100 of 120 samples are read: the XDF file is damaged or was cut off";
    told(&world.import(&[file]).exits(3), &["read with care", lost]);
    let root = world.folder.path();
    told(&zwidth(root, &["list", "rig"]).exits(0), &["lost: trial 1: ", lost]);
    let remedy = "import a whole copy of the recording as another session, or exclude the trial";
    told(&zwidth(root, &["verify", "rig"]).exits(1), &["trial-001.parquet", lost, remedy]);
    told(&zwidth(root, &["run", "rig"]).exits(3), &["P01 S01 trial 1", lost]);
    let summary = fs::read_to_string(root.join("reports/rig/summary.md")).unwrap();
    assert!(summary.contains("100 of 120 samples"), "{summary}");
    // Who excludes the trial has settled it.
    let exclude = ["exclude", "rig", "-p", "P01", "-s", "S01", "--trial", "1", "a part is lost"];
    zwidth(root, &exclude).exits(0);
    zwidth(root, &["verify", "rig"]).exits(0);
    told(&zwidth(root, &["list", "rig"]), &["lost: trial 1: "]);
}

/// Each of these words must be printed.
#[track_caller]
fn told(ran: &Ran, words: &[&str]) {
    for word in words {
        assert!(ran.out.contains(word) || ran.err.contains(word), "'{word}' is not in {ran:#?}");
    }
}
