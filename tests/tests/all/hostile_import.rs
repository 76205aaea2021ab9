//! Recordings that claim too much, are given twice, lie where a pipe or a device is, or have names
//! that steer a terminal; and imports that end before their end. Each is one clear error, and the
//! study stays as it was.

use crate::bad_import::{GOOD, World, good_but};
use crate::binary::{Ran, binary, ran, zwidth};
use crate::folders::listing;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zwidth_store::{Layout, StudyLock, file_blake3};

impl World {
    fn root(&self) -> &Path {
        self.folder.path()
    }

    /// Imports a file through another mapping.
    fn import_by(&self, map: &Path, file: &Path) -> Ran {
        let [map, file] = [map, file].map(|path| path.to_str().unwrap());
        zwidth(self.root(), &["import", "rig", "--map", map, file])
    }

    /// The import must be refused with these words, and nothing in what it says may steer a
    /// terminal.
    #[track_caller]
    fn refuses_plainly(&self, file: PathBuf, words: &[&str]) {
        let before = listing(&self.root().join("raw"));
        let ran = self.import(&[file]).exits(1).one_error().says(words);
        assert!(is_plain(&ran.err) && ran.err.len() < 4000, "{:?}", ran.err);
        assert_eq!(listing(&self.root().join("raw")), before);
    }
}

/// Whether a text steers no terminal and turns no line.
fn is_plain(text: &str) -> bool {
    let turns = |c| matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !text.chars().any(|c| turns(c) || (c.is_control() && c != '\n'))
}

#[test]
fn a_recording_of_more_bytes_than_are_read_is_refused_before_any_is() {
    let world = World::new();
    // Holes of a file take no room on the disk.
    let limits = [
        ("tdms", 1 << 30),
        ("c3d", 1 << 30),
        ("mcap", 1 << 30),
        ("mat", 1 << 28),
        ("xdf", 1 << 28),
    ];
    for (format, most) in limits {
        let large = world.file(&format!("large.{format}"), "");
        fs::File::options().write(true).open(&large).unwrap().set_len(most + 1).unwrap();
        let bytes = format!("at most {most} are read");
        world.refuses_plainly(large, &[&format!("large.{format}"), &bytes, "split it"]);
    }
}

#[test]
fn a_recording_that_claims_more_than_is_read_is_refused_with_the_limit() {
    let world = World::new();
    let csv = |text: String| world.file("big.csv", text);
    let header: String = (0..1_000_000).map(|i| format!("c{i},")).collect();
    world.refuses_plainly(
        csv(header),
        &["big.csv", "line 1 has more than 16384 columns", "no more are read"],
    );
    let long = format!("t,angle,f\n0,1,{}\n", "9".repeat(5_000_000));
    world.refuses_plainly(csv(long), &["line 2 has more than 1048576 bytes"]);
    let open = format!("t,angle,f\n0,1,\"{}\n", "2\n".repeat(1_000_000));
    world.refuses_plainly(csv(open), &["line 2 has more than 1048576 bytes", "quotes"]);
    let keys: String = (0..30_000).map(|i| format!("\"k{i}\":1,")).collect();
    let keys = world.file("keys.jsonl", format!("{{{}}}\n", keys.trim_end_matches(',')));
    world.refuses_plainly(keys, &["keys.jsonl", "has 30000 columns, and at most 16384 are read"]);
    let skip = World::new()
        .mapping("kind = \"trials\"", "kind = \"trials\"\n[file]\nskip = 1000000000000");
    skip.refuses_plainly(
        skip.file("a.csv", GOOD),
        &["skip = 1000000000000 passes the whole file by: it has 6 lines"],
    );
    let rows: String = (0..4_194_305).map(|i| format!("{i}\n")).collect();
    world.refuses_plainly(csv(format!("t\n{rows}")), &["more than 4194304 rows"]);
}

#[test]
fn deep_nesting_in_a_column_that_is_not_mapped_is_no_matter() {
    let world = World::new();
    let deep = format!("{}{}", "[".repeat(400_000), "]".repeat(400_000));
    let line = |t: u8| format!("{{\"t\":{t},\"angle\":1,\"f\":2,\"x\":{deep}}}\n");
    let file = world.file("deep.jsonl", line(0) + &line(1));
    world.import(&[file]).exits(0);
    let deeper = World::new().mapping("from = \"f\"", "from = \"x\"");
    deeper.refuses_plainly(
        deeper.file("deep.jsonl", line(0)),
        &["column x", "row 1", "is not a number"],
    );
}

#[test]
fn angles_and_times_that_no_rig_has_are_refused_with_column_and_row() {
    let world = World::new();
    for angle in ["1e6", "-1e6", "1e300", "-1e308"] {
        let file = world.file("a.csv", good_but("-42", angle));
        world.refuses_plainly(
            file,
            &["column angle", "row 3", "line 4", "more than a thousand turns"],
        );
    }
    for time in ["1e5", "1e12", "1e308"] {
        let file = world.file("a.csv", good_but("0.03", time));
        world.refuses_plainly(file, &["column t", "row 4", "line 5", "check the unit of the time"]);
    }
    for rate in ["1e-300", "1e300"] {
        let rate = format!("rate_hz = {rate}");
        let world = World::new().mapping("from = \"t\"\nunit = \"s\"", &rate);
        world.refuses_plainly(
            world.file("a.csv", GOOD),
            &["map.toml", "time.rate_hz", "from 0.001 to 1000000"],
        );
    }
    for number in ["1000001", "4294967295", "1e300"] {
        let world = World::new()
            .mapping("mode = \"hybrid\"", "mode = \"hybrid\"\ntrial = { column = \"n\" }");
        let file = world.file("a.csv", format!("t,angle,f,n\n0,1,2,{number}\n"));
        world.refuses_plainly(file, &["column n", "must be a whole number from 0 to 1000000"]);
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_a_device_a_folder_or_a_link_to_nothing_is_refused_at_once_as_recording_and_as_mapping() {
    use std::os::unix::fs::symlink;
    let world = World::new();
    let at = |name: &str| world.root().join(name);
    let made = Command::new("mkfifo").arg(at("pipe.csv")).status().unwrap();
    assert!(made.success());
    fs::create_dir(at("folder.csv")).unwrap();
    symlink("loop.csv", at("loop.csv")).unwrap();
    symlink("/dev/zero", at("zero.csv")).unwrap();
    symlink("nothing", at("lost.csv")).unwrap();
    symlink("pipe.csv", at("to_pipe.csv")).unwrap();
    let good = world.file("good.csv", GOOD);
    for (name, words) in [
        ("pipe.csv", "is a pipe, socket or device"),
        ("to_pipe.csv", "is a pipe, socket or device"),
        ("zero.csv", "is a pipe, socket or device"),
        ("folder.csv", "is a folder"),
        ("loop.csv", "cannot read"),
        ("lost.csv", "check the path"),
    ] {
        world.refuses_plainly(at(name), &[name, words]);
        world.import_by(&at(name), &good).exits(1).one_error().says(&[name, words]);
    }
    // A link of a person's to a recording is one way to name it.
    symlink("good.csv", at("link.csv")).unwrap();
    world.refuses(
        &[good, at("link.csv")],
        &["link.csv", "given twice", "good.csv has the same content"],
    );
    world.import(&[at("link.csv")]).exits(0);
}

#[test]
fn the_same_recording_counts_once_whatever_it_is_called() {
    let world = World::new();
    let first = world.file("x.csv", GOOD);
    let copy = world.file("copy.csv", GOOD);
    let linked = world.root().join("linked.csv");
    fs::hard_link(&first, &linked).unwrap();
    let dotted = world.root().join("./x.csv");
    // Of two files the one whose name comes first is the recording, the other the copy.
    for (second, name) in [(&first, "x"), (&dotted, "x"), (&copy, "copy"), (&linked, "linked")] {
        let same = format!("{name}.csv has the same content");
        let words = ["given twice", &same, "give every recording once"];
        world.refuses(&[first.clone(), second.clone()], &words);
    }
    world.import(std::slice::from_ref(&first)).exits(0);
    let there = "it is in the study already, as P01 S01 trial 1: left out";
    world.import(&[first]).exits(0).prints(&[there, "nothing new for study rig"]);
    let other = World { map: world.map.replace("S01", "S02"), ..world };
    for again in [copy, linked] {
        other.refuses(&[again], &["imported before, as P01 S01 trial 1", "must not count twice"]);
    }
    let mine = other.file("mine.csv", good_but("0.4", "0.5"));
    other.import(&[mine]).exits(0);
    zwidth(other.root(), &["verify", "rig"]).exits(0);
}

#[test]
fn ids_that_differ_only_by_case_are_refused() {
    let world = World::new();
    world.import(&[world.file("a.csv", GOOD)]).exits(0);
    let other = world.file("b.csv", good_but("0.4", "0.5"));
    for (from, to) in [("P01", "p01"), ("S01", "s01")] {
        let map = world.file("case.toml", world.map.replace(from, to));
        let words = format!("'{to}' differs only by case from '{from}'");
        let ran = world.import_by(&map, &other);
        ran.exits(1).one_error().says(&[&words, "choose another id"]);
    }
}

#[test]
fn a_header_or_a_key_that_comes_twice_is_refused() {
    let world = World::new();
    let csv = world.file("a.csv", "t,angle,f,note,note\n0,1,2,x,y\n");
    world.refuses_plainly(
        csv,
        &["a.csv", "column note", "columns 4 and 5 have the same header", "rename one"],
    );
    let json = "{\"t\":0,\"angle\":1,\"f\":2}\n{\"t\":1,\"angle\":1,\"f\":2,\"f\":3}\n";
    world.refuses_plainly(
        world.file("a.jsonl", json),
        &["a.jsonl", "line 2", "the key 'f' comes twice"],
    );
}

#[test]
fn names_and_values_of_others_never_steer_a_terminal() {
    let world = World::new();
    let steer = "\u{1b}[2J\u{9b}31m\u{202e}";
    let shown = r"\u{1b}[2J\u{9b}31m\u{202e}";
    let csv = |text: &str| world.file("a.csv", text);
    world.refuses_plainly(csv(&format!("t,{steer},f\n0,1,2\n")), &["column angle", shown]);
    world.refuses_plainly(
        csv(&format!("t,angle,f\n0,1,{steer}\n")),
        &["column f", shown, "is not a number"],
    );
    let json = "{\"t\":0,\"angle\":1,\"\\u001b[2J\":2}\n";
    world.refuses_plainly(world.file("a.jsonl", json), &["the file has", r"\u{1b}[2J"]);
    if cfg!(unix) {
        let name = "a\nverify: fine\u{202e}.csv";
        let file = world.file(name, "t,angle\n0,1\n");
        world.refuses_plainly(file, &[r"a\nverify: fine\u{202e}.csv"]);
        let good = world
            .file(name, GOOD.replace("f\n", &format!("f,{steer}\n")).replace(".1\n", ".1,x\n"));
        let text = fs::read_to_string(&good).unwrap();
        let rows: Vec<String> = text
            .lines()
            .map(|l| if l.matches(',').count() == 2 { format!("{l},x") } else { l.into() })
            .collect();
        fs::write(&good, rows.join("\n")).unwrap();
        let report = world.import(&[good]).exits(0);
        assert!(is_plain(&report.out) && report.out.contains(shown), "{:?}", report.out);
        assert!(report.out.contains(r"a\nverify: fine"), "{:?}", report.out);
    }
}

#[test]
fn an_import_that_was_cut_short_is_taken_back_by_the_next_one_and_by_recover() {
    let world = World::new();
    let file = world.file("a.csv", GOOD);
    let raw = world.root().join("raw/rig");
    let empty = listing(&raw);
    world.import(std::slice::from_ref(&file)).exits(0);
    let whole = listing(&raw);
    let trial = "trials/participant=P01/session=S01/trial-001.parquet";
    // As a kill leaves it after the trial and the copy of study.toml: neither record nor log, half
    // a record beside.
    let cut_short = || {
        let entry = |path: &str| {
            let blake3 = file_blake3(&raw.join(path)).unwrap();
            format!("{{\"path\":\"{path}\",\"blake3\":\"{blake3}\"}}")
        };
        let files =
            [entry(trial), entry("sessions/P01_S01.study.toml"), entry("sessions/P01_S01.json")]
                .join(",");
        let folders = "\"sessions\",\"trials\",\"trials/participant=P01\",\"trials/participant=P01/session=S01\"";
        let list = format!("{{\"files\":[{files}],\"folders\":[{folders}]}}");
        for name in ["P01_S01.json", "P01_S01.events.jsonl", "P01_S01.events.head"] {
            fs::remove_file(raw.join("sessions").join(name)).unwrap();
        }
        fs::write(raw.join("sessions/.P01_S01.json.1.tmp"), "{").unwrap();
        fs::write(raw.join("unfinished.json"), list).unwrap();
    };
    cut_short();
    let words = ["unfinished.json", "give the command again"];
    zwidth(world.root(), &["verify", "rig"]).exits(1).prints(&words);
    world
        .import(std::slice::from_ref(&file))
        .exits(0)
        .says(&["an import was cut short, and the 2 files"]);
    zwidth(world.root(), &["verify", "rig"]).exits(0);
    assert_eq!(listing(&raw).keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>());
    cut_short();
    zwidth(world.root(), &["recover", "rig"])
        .exits(0)
        .prints(&["the 2 files it had written were removed again"]);
    assert_eq!(listing(&raw), empty);
    world.import(&[file]).exits(0);
    zwidth(world.root(), &["verify", "rig"]).exits(0);
}

#[test]
fn while_somebody_writes_to_the_study_an_import_is_refused() {
    let world = World::new();
    let file = world.file("a.csv", GOOD);
    let layout = Layout::new(world.root(), "rig".parse().unwrap());
    let lock = StudyLock::take(&layout, "zwidth acquire, process 1").unwrap();
    world.refuses_plainly(file.clone(), &["in use: zwidth acquire", "nothing was imported"]);
    drop(lock);
    world.import(&[file]).exits(0);
}

#[test]
fn of_two_imports_of_one_recording_at_once_exactly_one_goes_through() {
    let world = World::new();
    let (map, file) = (world.file("map.toml", &world.map), world.file("a.csv", GOOD));
    let start = || {
        let mut command = Command::new(binary());
        command
            .arg("--root")
            .arg(world.root())
            .args(["import", "rig", "--map"])
            .arg(&map)
            .arg(&file);
        command
            .env_remove("ZWIDTH_ROOT")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let both = [start(), start()].map(|child| ran(&child.wait_with_output().unwrap()));
    let through = |ran: &&Ran| ran.code == Some(0) && ran.out.contains("1 file imported");
    assert_eq!(both.iter().filter(through).count(), 1, "{both:#?}");
    let told = |ran: &Ran| {
        // The second finds the study in use, or what the first imported.
        through(&ran) || ran.err.contains("in use") || ran.out.contains("nothing new")
    };
    assert!(both.iter().all(told), "{both:#?}");
    zwidth(world.root(), &["verify", "rig"]).exits(0);
}
