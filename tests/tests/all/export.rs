//! What leaves by `zwidth export`: it comes back to the last bit, hides what it says it hides, is
//! complete or absent, and is refused where it would not be what was recorded.

use crate::acquire::Desk;
use crate::binary::{Ran, zwidth};
use crate::folders::{copy, edit, files, listing};
use crate::shipped;
use crate::small::{Draft, Study, draft, repeats};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use zwidth_store::{Layout, Signal, StudyData, read_named, read_parquet, read_trial};
use zwidth_study::{AnswerValue, Event};
use zwidth_tables::Table;

/// What nobody may learn of a study whose people were renamed.
const REASON: &str = "Jane sneezed";
const NOTE: &str = "left-handed";

/// Two people, one trial that does not count, and what was said of them; after a run.
fn study() -> Study {
    let study = Study::new("demo");
    let mut drafts = repeats("spring", "hybrid", 1..=3);
    drafts.extend(repeats("spring", "active", 4..=6));
    drafts[1].events = vec![Event::Excluded { trial: 2, reason: REASON.to_owned() }];
    drafts[2].events = vec![Event::Note { trial: None, text: NOTE.to_owned() }];
    drafts[0].likert = Some(4);
    study.session("Alice-1", &drafts);
    study.session("Bob-2", &repeats("spring", "hybrid", 1..=3));
    zwidth(study.root(), &["run", "--quiet"]).exits(0);
    study
}

fn export(root: &Path, to: &Path, more: &[&str]) -> Ran {
    let to = to.to_str().unwrap();
    zwidth(root, &[&["export", "demo", "--to", to], more].concat())
}

/// A place for exports beside the study's data.
fn outside() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("out");
    (folder, to)
}

/// Every trial of a study: its key and condition, and the bits of its samples.
type Bits = Vec<(String, Vec<(Signal, Vec<u64>)>)>;

fn bits(root: &Path) -> Bits {
    let data = StudyData::load(&Layout::new(root, "demo".parse().unwrap())).unwrap();
    let of = |entry: &zwidth_store::TrialEntry| {
        let m = &entry.meta;
        let key = format!(
            "{} {} {} {} {} {}",
            m.participant, m.session, m.trial, m.repeat, m.environment, m.mode
        );
        let samples = read_trial(&entry.path, Signal::all()).unwrap().samples;
        let columns = Signal::all().filter_map(|signal| {
            let values = samples.get(signal)?;
            Some((signal, values.iter().map(|v| v.to_bits()).collect()))
        });
        (key, columns.collect())
    };
    data.counting().map(of).collect()
}

#[test]
fn samples_come_back_to_the_last_bit_from_parquet_csv_mat_and_mcap() {
    let study = study();
    let (_folder, out) = outside();
    export(study.root(), &out, &["--with", "samples-csv,mat,mcap"]).exits(0);
    let recorded = bits(study.root());
    assert_eq!(recorded.len(), 8, "of nine one is excluded");
    let mats = files(&out.join("mat"), "mat");
    let mats: Vec<PathBuf> =
        mats.into_iter().filter(|path| !path.ends_with("tables.mat")).collect();
    for (map, recordings) in [
        ("samples.toml", vec![out.join("samples.parquet")]),
        ("samples.toml", vec![out.join("samples.csv")]),
        ("mat.toml", mats),
        ("mcap.toml", files(&out.join("mcap"), "mcap")),
    ] {
        let back = tempfile::tempdir().unwrap();
        fs::create_dir_all(back.path().join("raw/demo")).unwrap();
        fs::copy(out.join("study.toml"), back.path().join("raw/demo/study.toml")).unwrap();
        let map = out.join("import").join(map);
        let mut arguments = vec!["import", "demo", "--map", map.to_str().unwrap()];
        arguments.extend(recordings.iter().map(|path| path.to_str().unwrap()));
        // With fewer repeats than were planned, it is to be read with care there, too.
        zwidth(back.path(), &arguments).exits(3);
        assert!(bits(back.path()) == recorded, "{}", recordings[0].display());
        let answers = out.join("tables/answers.csv");
        zwidth(back.path(), &["answer", "demo", "--from", answers.to_str().unwrap()]).exits(0);
        let answered = |root: &Path| {
            let data = StudyData::load(&Layout::new(root, "demo".parse().unwrap())).unwrap();
            data.answers.iter().map(|a| (a.trial, a.value)).collect::<Vec<_>>()
        };
        assert_eq!(answered(back.path()), answered(study.root()));
    }
}

#[test]
fn tables_are_those_of_the_study_with_a_source_in_each_row_and_keys_that_lead_to_a_trial() {
    let study = study();
    let (_folder, out) = outside();
    export(study.root(), &out, &["--with", "xlsx"]).exits(0);
    let table =
        |name: &str| Table::from_parquet(&out.join(format!("tables/{name}.parquet"))).unwrap();
    let own = study.derived("metrics");
    let metrics = table("metrics");
    for column in own.columns() {
        assert_eq!(metrics.column(&column.field.name).unwrap(), column);
    }
    let keys = |table: &Table| -> BTreeSet<(String, i64)> {
        let people = table.texts("participant").unwrap().into_iter().flatten();
        people.zip(table.integers("trial").unwrap().into_iter().flatten()).collect()
    };
    let trials = table("trials");
    assert_eq!(keys(&trials).len(), 8);
    let mut names = BTreeSet::new();
    for file in files(&out.join("tables"), "parquet") {
        let table = Table::from_parquet(&file).unwrap();
        let sources: BTreeSet<_> = table.words("source").unwrap().flatten().collect();
        assert!(
            sources.is_empty() || sources == BTreeSet::from(["recorded"]),
            "{file:?}: {sources:?}"
        );
        if table.column("trial").is_ok() {
            assert!(keys(&table).is_subset(&keys(&trials)), "{file:?}");
        }
        names.insert(table.name().to_owned());
    }
    let dictionary = fs::read_to_string(out.join("dictionary.csv")).unwrap();
    for name in ["trials", "participants", "metrics", "answers", "events", "means", "contrasts"] {
        assert!(names.contains(name), "{name} is not in {names:?}");
        assert!(dictionary.contains(&format!("\n{name},")), "{name}");
    }
    assert!(dictionary.contains("\nmetrics,theta_max_rad,number,rad,"), "{dictionary}");
    assert!(dictionary.contains("\nsamples,force_ex_n,number,N,"), "{dictionary}");
    let sums = fs::read_to_string(out.join("SHA256SUMS")).unwrap();
    let listed: BTreeSet<&str> = sums.lines().filter_map(|l| Some(l.split_once("  ")?.1)).collect();
    let all = listing(&out);
    let there = all.iter().filter(|(_, hash)| !hash.is_empty()).map(|(path, _)| path.as_str());
    assert_eq!(listed, there.filter(|path| *path != "SHA256SUMS").collect());
}

#[test]
fn simulated_data_are_marked_wherever_they_are() {
    let root = shipped::finished();
    let (_folder, out) = outside();
    let to = out.to_str().unwrap();
    zwidth(root.path(), &["export", "thesis-twin", "--to", to, "--with", "bids,mcap,mat"]).exits(0);
    let marked = |path: &Path| {
        let bytes = fs::read(path).unwrap();
        bytes.windows(9).any(|window| window == b"SYNTHETIC")
    };
    for path in [
        "README.md",
        "CITATION.cff",
        "datapackage.json",
        "ro-crate-metadata.json",
        "samples.parquet",
        "tables/metrics.parquet",
        "bids/dataset_description.json",
        "bids/README",
    ] {
        assert!(marked(&out.join(path)), "{path}");
    }
    let trials = |folder: &str, extension: &str| files(&out.join(folder), extension);
    for path in [trials("mcap", "mcap"), trials("bids/sub-P01", "json")].concat() {
        assert!(marked(&path), "{path:?}");
    }
    for path in trials("tables", "csv") {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.lines().next().unwrap().contains("source"), "{path:?}");
        assert!(text.lines().skip(1).all(|line| line.contains("twin")), "{path:?}");
    }
}

#[test]
fn renamed_people_are_in_no_byte_and_the_key_leads_back() {
    let study = study();
    let (folder, out) = outside();
    let key = folder.path().join("key.csv");
    let named = ["--rename", "--key", key.to_str().unwrap(), "--with", "bids,mcap,mat,samples-csv"];
    export(study.root(), &out, &named).exits(0);
    let key = fs::read_to_string(&key).unwrap();
    let codes: Vec<&str> = key.lines().skip(1).filter_map(|l| Some(l.split_once(',')?.1)).collect();
    let trials = Table::from_parquet(&out.join("tables/trials.parquet")).unwrap();
    let found: BTreeSet<&str> = trials.words("participant").unwrap().flatten().collect();
    assert_eq!(found, codes.into_iter().collect());
    let data = StudyData::load(study.layout()).unwrap();
    let mut hidden = ["Alice-1", "Alice1", "Bob-2", REASON, NOTE, "2026-01-01", "zwidth:metrics"]
        .map(str::to_owned)
        .to_vec();
    hidden.extend(data.trials.iter().map(|trial| trial.blake3.clone()));
    hidden.push(study.root().to_str().unwrap().to_owned());
    for (path, _) in listing(&out) {
        for word in &hidden {
            assert!(!path.contains(word.as_str()), "{path}");
        }
        let file = out.join(&path);
        if file.is_dir() {
            continue;
        }
        let mut bytes = fs::read(&file).unwrap();
        if path.ends_with(".parquet") {
            // Its columns are packed.
            let (batch, footer) = read_parquet(&file).unwrap_or_else(|_| panic!("{path}"));
            bytes.extend(format!("{batch:?} {footer:?}").into_bytes());
        }
        for word in &hidden {
            let is_in = bytes.windows(word.len()).any(|window| window == word.as_bytes());
            assert!(!is_in, "{word} is in {path}");
        }
    }
}

#[test]
fn a_dry_run_lists_what_leaves_and_what_stays_and_writes_nothing() {
    let study = study();
    let (folder, out) = outside();
    let with = ["--with", "bids,mcap,mat,samples-csv,xlsx"];
    let dry = export(study.root(), &out, &[&with[..], &["--dry-run", "--json"]].concat()).exits(0);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let paths = |ran: &Ran| -> BTreeSet<String> {
        let files = ran.json()["files"].as_array().unwrap().clone();
        files.iter().map(|file| file["path"].as_str().unwrap().to_owned()).collect()
    };
    let left_out = dry.json()["left_out"].to_string();
    assert!(left_out.contains("1 trial of those that do not count: excluded"), "{left_out}");
    assert!(!left_out.contains(REASON), "{left_out}");
    let real = export(study.root(), &out, &[&with[..], &["--json"]].concat()).exits(0);
    assert_eq!(paths(&dry), paths(&real));
    let all = listing(&out).into_iter().filter(|(_, hash)| !hash.is_empty());
    assert_eq!(paths(&real), all.map(|(path, _)| path).collect());
    export(study.root(), &folder.path().join("b"), &["--dry-run", "--rename"])
        .exits(0)
        .prints(&["stay behind"]);
}

#[test]
fn a_place_that_is_taken_or_among_the_data_is_refused_and_so_is_a_key_that_goes_along() {
    let study = study();
    let (folder, out) = outside();
    let root = study.root();
    let before = listing(root);
    fs::create_dir(&out).unwrap();
    let inside = out.join("key.csv");
    let key = folder.path().join("key.csv");
    let new = folder.path().join("new");
    let in_new = new.join("key.csv");
    fs::write(&key, "theirs").unwrap();
    for (to, more, words) in [
        (&out, vec![], "exists already"),
        (&root.join("raw/demo/out"), vec![], "lies in raw/"),
        (&root.join("derived/out"), vec![], "lies in derived/"),
        (&root.join("reports/demo/../out"), vec![], "lies in reports/"),
        (&folder.path().join("no/such/out"), vec![], "make it first"),
        (&new, vec!["--rename"], "--key FILE"),
        (&new, vec!["--rename", "--key", key.to_str().unwrap()], "exists already"),
        (&new, vec!["--rename", "--key", in_new.to_str().unwrap()], "who is who"),
        (&new, vec!["--licence", "my own\nlicence"], "SPDX"),
    ] {
        export(root, to, &more).exits(1).one_error().says(&[words]);
        assert!(!new.exists() && !inside.exists(), "{words}");
    }
    assert_eq!(fs::read_to_string(&key).unwrap(), "theirs");
    assert_eq!(listing(root), before);
    #[cfg(unix)]
    {
        // A link leads into raw/ and is not followed there unseen.
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(root.join("raw"), &link).unwrap();
        export(root, &link.join("out"), &[]).exits(1).one_error().says(&["lies in raw/"]);
        // Under another name a key would lie in what leaves all the same.
        let dots = folder.path().join("new/../new/key.csv");
        let named = ["--rename", "--key", dots.to_str().unwrap()];
        export(root, &new, &named).exits(1).one_error().says(&["who is who"]);
    }
}

#[test]
fn what_is_not_up_to_date_or_sealed_does_not_leave() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    let (_folder, out) = outside();
    let first = export(study.root(), &out, &[]).exits(1).one_error();
    first.says(&["not up to date", "zwidth run demo"]);
    zwidth(study.root(), &["run", "--quiet"]).exits(0);
    let exclude = ["exclude", "demo", "-p", "P01", "-s", "S01", "--trial", "2", "phone"];
    zwidth(study.root(), &exclude).exits(0);
    export(study.root(), &out, &[]).exits(1).one_error().says(&["not up to date"]);
    assert!(!out.exists());
    let desk = Desk::new(true);
    desk.acquire(&("start\n3\n".repeat(3) + "quit\n"), &[]).exits(3);
    let to = out.to_str().unwrap();
    let sealed = zwidth(desk.root(), &["export", "small", "--to", to]).exits(1).one_error();
    sealed.says(&["is sealed", "zwidth unseal small"]);
    assert!(!out.exists());
}

#[test]
fn a_study_of_answers_alone_leaves_and_one_without_anything_is_refused() {
    let study = Study::new("demo");
    let question = "felt_spring".parse().unwrap();
    let answered = |trial| Draft {
        samples: false,
        events: vec![Event::Answer {
            trial,
            question: zwidth_study::QuestionId::clone(&question),
            value: AnswerValue::from(3),
            time_ms: None,
        }],
        ..draft(trial, "spring", "hybrid")
    };
    let (_folder, out) = outside();
    zwidth(study.root(), &["run", "--quiet"]);
    export(study.root(), &out, &[]).exits(1).one_error().says(&["nothing to export"]);
    study.session("P01", &[answered(1), answered(2)]);
    zwidth(study.root(), &["run", "--quiet"]).exits(0);
    export(study.root(), &out, &["--with", "bids,mcap,mat,samples-csv,xlsx"]).exits(0);
    let trials = Table::from_parquet(&out.join("tables/trials.parquet")).unwrap();
    assert_eq!(trials.integers("samples").unwrap(), [Some(0), Some(0)]);
    let answers = Table::from_parquet(&out.join("tables/answers.parquet")).unwrap();
    assert_eq!(answers.height(), 2);
    assert!(!out.join("samples.parquet").exists() && !out.join("import").exists());
}

#[test]
fn what_is_known_of_people_leaves_only_if_it_is_asked_for() {
    let study = study();
    let toml = study.layout().study_toml();
    edit(&toml, "[study]", "[[people]]\nid = \"age_years\"\nunit = \"years\"\n\n[study]");
    fs::write(
        study.layout().raw().join("participants.csv"),
        "participant,age_years\nAlice-1,97\nBob-2,41\n",
    )
    .unwrap();
    zwidth(study.root(), &["run", "--quiet"]);
    let (folder, out) = outside();
    export(study.root(), &out, &[]);
    let people = |out: &Path| fs::read_to_string(out.join("tables/participants.csv")).unwrap();
    assert_eq!(people(&out), "participant,source\r\nAlice-1,recorded\r\nBob-2,recorded\r\n");
    let asked = folder.path().join("asked");
    export(study.root(), &asked, &["--people"]);
    assert_eq!(
        people(&asked),
        "participant,age_years,source\r\nAlice-1,97.0,recorded\r\nBob-2,41.0,recorded\r\n"
    );
    // Beside study.toml it is read again.
    let back = tempfile::tempdir().unwrap();
    let raw = back.path().join("raw/demo");
    fs::create_dir_all(&raw).unwrap();
    fs::copy(asked.join("study.toml"), raw.join("study.toml")).unwrap();
    fs::copy(asked.join("import/participants.csv"), raw.join("participants.csv")).unwrap();
    let known = StudyData::load(&Layout::new(back.path(), "demo".parse().unwrap())).unwrap().people;
    assert_eq!(known, StudyData::load(study.layout()).unwrap().people);
    assert!(!out.join("import/participants.csv").exists());
    let told = fs::read_to_string(out.join("README.md")).unwrap();
    assert!(
        told.contains("what is known of people (age_years): --people takes it along"),
        "{told}"
    );
}

#[test]
fn the_same_study_gives_the_same_bytes_and_what_a_cut_export_left_is_told() {
    let study = study();
    let (folder, out) = outside();
    let left = folder.path().join(".out.4711.tmp");
    fs::create_dir(&left).unwrap();
    let with = ["--with", "bids,mcap,mat,samples-csv,xlsx"];
    export(study.root(), &out, &with).exits(0).says(&[".out.4711.tmp", "can be removed"]);
    assert!(left.exists(), "it may be another's that still writes");
    let again = folder.path().join("again");
    let elsewhere = tempfile::tempdir().unwrap();
    for name in ["raw", "derived", "reports"] {
        copy(&study.root().join(name), &elsewhere.path().join(name));
    }
    export(elsewhere.path(), &again, &with).exits(0);
    assert_eq!(listing(&again), listing(&out));
    assert!(read_named(&out.join("samples.parquet"), 1 << 30).unwrap().starts_with(b"PAR1"));
}
