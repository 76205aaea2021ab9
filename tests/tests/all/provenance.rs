//! `why`, `trace`, and what files say of their making, through the program.

use crate::binary::{binary, ran, zwidth};
use crate::folders::edit;
use crate::shipped;
use crate::small::{Study, repeats};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use zwidth_store::{RealFiles, append_events, file_blake3};
use zwidth_study::Event;

pub(crate) const FIGURE: &str = "reports/thesis-twin/figures/modes.P01.S01.spring.svg";
const TRIAL: &str = "raw/thesis-twin/trials/participant=P01/session=S01/trial-004.parquet";

fn words(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

/// The jobs of a listing.
fn jobs(listed: &Value) -> Vec<&str> {
    listed.as_array().unwrap().iter().map(|entry| entry["job"].as_str().unwrap()).collect()
}

/// The one entry of a listing.
pub(crate) fn only(root: &Path, arguments: &[&str]) -> Value {
    let listed = zwidth(root, &[arguments, &["--json"]].concat()).exits(0).json();
    let entries = listed.as_array().unwrap();
    assert_eq!(entries.len(), 1, "{listed:#}");
    entries[0].clone()
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|w| w == text.as_bytes())
}

#[test]
fn every_result_carries_its_origin_where_its_format_can_and_no_path_of_the_machine() {
    let root = shipped::folder();
    let records: Value =
        serde_json::from_slice(&fs::read(root.join("derived/thesis-twin/records.json")).unwrap())
            .unwrap();
    let mut seen = BTreeSet::new();
    for record in records.as_object().unwrap().values() {
        let origin = record["origin"].as_str().unwrap();
        assert!(seen.insert(origin.to_owned()), "{origin} stands for two jobs");
        for (path, hash) in record["outputs"].as_object().unwrap() {
            let bytes = fs::read(root.join(path)).unwrap();
            // CSV has no comments, and the same calibration must have the same hash, whoever made
            // it.
            let cannot = path.ends_with(".csv") || path.ends_with("calibration.toml");
            assert_eq!(contains(&bytes, origin), !cannot, "{path}");
            assert!(
                !contains(&bytes, root.to_str().unwrap()),
                "{path} names a folder of this machine"
            );
            assert_eq!(hash.as_str().unwrap(), file_blake3(&root.join(path)).unwrap());
        }
    }
}

#[test]
fn a_trace_goes_back_to_the_trials_of_the_figure_and_to_nothing_else() {
    let root = shipped::folder();
    let traced = only(root, &["trace", FIGURE]);
    assert_eq!(traced["job"], "figure modes.P01.S01.spring");
    assert_eq!(traced["recorded"], traced["now"]);
    let expect = [
        "figure modes.P01.S01.spring",
        "average P01 S01 spring active",
        "average P01 S01 spring hybrid",
        "average P01 S01 spring passive",
    ];
    assert_eq!(jobs(&traced["jobs"]), expect);
    let raw = traced["raw"].as_array().unwrap();
    assert_eq!(raw.len(), 36, "of both environments, which share their axes; no practice trial");
    for file in raw {
        let path = file["path"].as_str().unwrap();
        assert!(
            path.starts_with("raw/thesis-twin/trials/participant=P01/session=S01/trial-"),
            "{path}"
        );
        assert_eq!(file["blake3"].as_str().unwrap(), file_blake3(&root.join(path)).unwrap());
        assert_eq!(file["blake3"], file["now"]);
    }
    let own = traced["jobs"][0]["inputs"].as_object().unwrap();
    assert_eq!(
        own.keys().filter(|path| path.starts_with("raw/")).count(),
        36,
        "six repeats of three modes in each environment"
    );
    let from = ["study.toml", "sessions/P01_S01.json", "sessions/P01_S01.events.jsonl"];
    assert_eq!(words(&traced["parameters_from"]), from.map(|f| format!("raw/thesis-twin/{f}")));
}

#[test]
fn a_trace_of_forces_ends_in_sweeps_and_one_of_the_model_in_its_scene() {
    let root = shipped::folder();
    let range = only(root, &["trace", "reports/thesis-twin/figures/rendering_range.pdf"]);
    let raw = range["raw"].as_array().unwrap();
    assert_eq!(raw.len(), 45, "15 sweeps of the motor and 30 of the brake");
    assert!(
        raw.iter().all(|f| f["path"].as_str().unwrap().contains("/sweeps/actuator=")),
        "{raw:#?}"
    );
    let jobs = jobs(&range["jobs"]);
    assert!(jobs.contains(&"calibration"), "{jobs:#?}");
    let model = only(root, &["trace", "reports/thesis-twin/tables/model.csv"]);
    assert_eq!(model["raw"], serde_json::json!([]));
    assert!(
        words(&model["parameters_from"]).iter().any(|f| f.starts_with("scenes/sine_finger.toml"))
    );
}

#[test]
fn a_copy_anywhere_is_traced_by_what_it_says_or_else_by_its_content() {
    let root = shipped::folder();
    let thesis = tempfile::tempdir().unwrap();
    let reports = root.join("reports/thesis-twin");
    for (name, extensions, job) in [
        ("figures/modes.P01.S01.spring", "svg pdf png parquet", "figure modes.P01.S01.spring"),
        ("figures/captions", "tex", "captions"),
        ("tables/conditions", "tex typ md html csv", "table conditions"),
        ("summary", "md", "summary"),
        ("index", "html", "page"),
        ("report-data/P01.S01.spring", "js", "samples P01 S01 spring"),
    ] {
        for extension in extensions.split(' ') {
            let file = format!("{name}.{extension}");
            // CSV has no comments.
            let by = if extension == "csv" { "content" } else { "origin" };
            let copy = thesis.path().join(format!("fig1.{extension}"));
            fs::copy(reports.join(&file), &copy).unwrap();
            let traced = only(root, &["trace", copy.to_str().unwrap()]);
            let found = (traced["found_by"].as_str(), traced["job"].as_str());
            assert_eq!(found, (Some(by), Some(job)), "{file}");
            assert_eq!(traced["path"], format!("reports/thesis-twin/{file}"));
            let why = only(root, &["why", copy.to_str().unwrap()]);
            let made = (why["job"].as_str(), why["again"].as_str());
            assert_eq!(made, (Some(job), Some("no")), "{file}");
        }
    }
    // A chapter with two tables in it is from two jobs; an edited figure still says where it is
    // from.
    let text =
        |table: &str| fs::read_to_string(reports.join(format!("tables/{table}.tex"))).unwrap();
    let chapter = thesis.path().join("chapter.tex");
    fs::write(&chapter, format!("Results\n{}\n{}", text("weight"), text("likert"))).unwrap();
    let traced = zwidth(root, &["trace", chapter.to_str().unwrap(), "--json"]).exits(0).json();
    assert_eq!(jobs(&traced), ["table likert", "table weight"]);
}

#[test]
fn a_copy_of_what_is_no_longer_made_says_so_once() {
    let root = shipped::finished();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("fig.svg");
    fs::copy(root.path().join(FIGURE), &copy).unwrap();
    fs::remove_file(root.path().join("derived/thesis-twin/records.json")).unwrap();
    let origin_of_it = "zwidth:figures:";
    let trace = || zwidth(root.path(), &["trace", copy.to_str().unwrap()]).exits(1).one_error();
    trace().says(&[origin_of_it, "inputs have changed since", "--root"]);
    fs::write(&copy, "<svg/>").unwrap();
    trace().says(&["fig.svg", "--root"]);
}

#[test]
fn why_of_what_is_up_to_date_tells_what_it_was_made_from() {
    let root = shipped::folder();
    let why = only(root, &["why", FIGURE]);
    assert_eq!(
        (why["again"].as_str(), why["job"].as_str()),
        (Some("no"), Some("figure modes.P01.S01.spring"))
    );
    assert_eq!((&why["reasons"], &why["first"]), (&serde_json::json!([]), &serde_json::json!([])));
    let last = &why["last_made"];
    assert_eq!(last["inputs"][TRIAL], file_blake3(&root.join(TRIAL)).unwrap());
    assert!(last["parameters"].as_str().unwrap().contains("rotational"));
    assert!(
        last["dated"].as_str().unwrap().ends_with('Z') && last["version"].as_u64().unwrap() > 0
    );
    let words = [FIGURE, "made by", "last made", "zwidth:figures:", TRIAL, "Up to date"];
    zwidth(root, &["why", FIGURE]).exits(0).prints(&words);
}

#[test]
fn why_and_trace_take_paths_from_the_current_folder_and_from_the_root() {
    let root = shipped::folder();
    let here = |folder: &Path, path: &str| {
        let mut command = Command::new(binary());
        command.args(["--root", root.to_str().unwrap(), "why", path, "--json"]).current_dir(folder);
        ran(&command.env_remove("ZWIDTH_ROOT").output().unwrap()).exits(0).json()[0]["path"].clone()
    };
    assert_eq!(here(&root.join("reports/thesis-twin/figures"), "modes.P01.S01.spring.svg"), FIGURE);
    assert_eq!(
        here(&root.join("derived"), "../reports/thesis-twin/figures/modes.P01.S01.spring.svg"),
        FIGURE
    );
    assert_eq!(here(Path::new("/"), root.join(FIGURE).to_str().unwrap()), FIGURE);
    assert_eq!(here(Path::new("/"), FIGURE), FIGURE);
    let mut command = Command::new(binary());
    command.args(["trace", FIGURE, "--json"]).current_dir(root).env_remove("ZWIDTH_ROOT");
    assert_eq!(
        ran(&command.output().unwrap()).exits(0).json()[0]["path"],
        FIGURE,
        "with the root left out"
    );
}

#[test]
fn why_names_the_input_that_changed_with_both_hashes_and_what_is_made_before() {
    let root = shipped::finished();
    let before = file_blake3(&root.path().join(TRIAL)).unwrap();
    // Trial 4 is one of the spring in hybrid mode.
    shipped::log(root.path(), Event::Excluded { trial: 4, reason: "slipped".into() });
    let why = only(root.path(), &["why", FIGURE]);
    assert_eq!(why["again"], "yes");
    let trial = why["reasons"].as_array().unwrap().iter().find(|r| r["path"] == TRIAL).unwrap();
    let expect = (Some("input"), Some("dropped"), Some(before.as_str()));
    assert_eq!((trial["what"].as_str(), trial["how"].as_str(), trial["recorded"].as_str()), expect);
    assert_eq!(jobs(&why["first"]), ["average P01 S01 spring hybrid"]);
    // A table made from that alone is made again only if the numbers come out otherwise.
    let table = only(root.path(), &["why", "reports/thesis-twin/tables/conditions.md"]);
    assert_eq!(
        (table["again"].as_str(), table["reasons"][0]["how"].as_str()),
        (Some("if_inputs_differ"), Some("to_be_made"))
    );
    let told = format!("input {TRIAL} is no longer part of it (recorded {})", &before[..12]);
    zwidth(root.path(), &["why", FIGURE]).exits(0).prints(&[&told]);
    // What `why` says is what `run` does.
    let made = zwidth(root.path(), &["run", "--json"]).exits(0).made();
    assert!(
        made.contains(&"figure modes.P01.S01.spring".to_owned())
            && made.contains(&"table conditions".to_owned())
    );
    assert_eq!(only(root.path(), &["why", FIGURE])["again"], "no");
}

#[test]
fn why_tells_a_changed_content_with_what_it_was_and_what_it_is() {
    let root = shipped::finished();
    let name = "raw/thesis-twin/sweeps/actuator=motor/sweep-02.parquet";
    let path = root.path().join(name);
    let before = file_blake3(&path).unwrap();
    shipped::change_sweep(root.path(), name);
    let why = only(root.path(), &["why", "reports/thesis-twin/figures/characteristic.motor.png"]);
    let now = file_blake3(&path).unwrap();
    let expect = serde_json::json!({"what": "input", "path": name, "recorded": before, "now": now, "how": "changed"});
    let reasons = why["reasons"].as_array().unwrap();
    assert!(reasons.contains(&expect), "{reasons:#?}");
    assert_eq!(
        (why["again"].as_str(), why["first"][0]["job"].as_str()),
        (Some("yes"), Some("characteristic of motor"))
    );
    let traced =
        only(root.path(), &["trace", "reports/thesis-twin/figures/characteristic.motor.png"]);
    let sweep = traced["raw"].as_array().unwrap().iter().find(|file| file["path"] == name).unwrap();
    assert_eq!(
        (sweep["blake3"].as_str(), sweep["now"].as_str()),
        (Some(before.as_str()), Some(now.as_str()))
    );
}

#[test]
fn why_tells_an_edited_a_missing_and_a_never_made_result() {
    let root = shipped::finished();
    let path = root.path().join(FIGURE);
    fs::write(&path, "edited").unwrap();
    let why = only(root.path(), &["why", FIGURE]);
    let edited = &why["reasons"][0];
    assert_eq!(
        (edited["what"].as_str(), edited["how"].as_str()),
        (Some("output"), Some("changed"))
    );
    assert_eq!(edited["now"], file_blake3(&path).unwrap());
    assert!(zwidth(root.path(), &["trace", FIGURE]).exits(0).out.contains("edited since"));
    fs::remove_file(&path).unwrap();
    assert_eq!(only(root.path(), &["why", FIGURE])["reasons"][0]["how"], "missing");
    let fresh = shipped::raw();
    let why = only(fresh.path(), &["why", FIGURE]);
    assert_eq!(
        (why["reasons"][0]["what"].as_str(), &why["last_made"]),
        (Some("never_made"), &Value::Null)
    );
    zwidth(fresh.path(), &["trace", FIGURE]).exits(1).one_error().says(&["zwidth run thesis-twin"]);
}

#[test]
fn why_tells_a_changed_parameter_with_both_values() {
    let root = shipped::finished();
    let toml = root.path().join("raw/thesis-twin/study.toml");
    edit(&toml, "confidence = 0.95", "confidence = 0.9");
    let why =
        only(root.path(), &["why", "derived/thesis-twin/average/P01.S01.spring.active.parquet"]);
    let reason = &why["reasons"][0];
    assert_eq!(reason["what"], "parameters");
    let field = serde_json::json!({ "name": "analysis.confidence", "recorded": 0.95, "now": 0.9 });
    assert_eq!(reason["fields"], serde_json::json!([field]));
}

#[test]
fn a_path_that_no_job_makes_is_one_clear_error() {
    let root = shipped::folder();
    for command in ["why", "trace"] {
        let error = |path: &str| zwidth(root, &[command, path]).exits(1).one_error();
        error("reports/thesis-twin/figures/mods.P01.S01.spring.svg")
            .says(&["did you mean modes.P01.S01.spring.svg"]);
        error(TRIAL).says(&["is raw", "zwidth verify"]);
        error("derived/thesis-twin/records.json").says(&["no job makes it"]);
        error("reports/simulate/sine.svg").says(&["zwidth simulate"]);
        error("reports/nothing/figures/a.svg").says(&["there is no study 'nothing'"]);
        error("nowhere.svg").says(&["cannot read nowhere.svg"]);
    }
}

#[test]
fn a_trace_says_what_was_replaced_since_instead_of_guessing() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    let root = study.root();
    zwidth(root, &["run"]).exits(0);
    let append = |event| {
        append_events(&RealFiles, &study.events("P01"), "2026-01-02T00:00:00Z", &[event]).unwrap()
    };
    append(Event::Excluded { trial: 2, reason: "slipped".into() });
    zwidth(root, &["run", "--only", "metrics by condition"]).exits(0);
    let traced = only(root, &["trace", "reports/demo/tables/conditions.csv"]);
    assert_eq!(traced["lost"][0]["path"], "derived/demo/conditions.parquet");
    assert_eq!(
        traced["raw"],
        serde_json::json!([]),
        "which trials were behind it is not known any more"
    );
    zwidth(root, &["run"]).exits(0);
    let traced = only(root, &["trace", "reports/demo/tables/conditions.csv"]);
    assert_eq!(
        (traced["lost"].as_array().unwrap().len(), traced["raw"].as_array().unwrap().len()),
        (0, 2)
    );
}
