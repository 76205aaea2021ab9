//! `zwidth compare` and `zwidth power` as a user types them.

use crate::binary::{Ran, zwidth, zwidth_line};
use crate::folders::{append, edit};
use crate::shipped;
use std::fs;
use std::path::{Path, PathBuf};

/// The file of the finished study.
const STUDY: &str = "raw/thesis-twin/study.toml";

fn compare(root: &Path) -> Ran {
    zwidth(root, &["compare", "thesis-twin"])
}

fn methods(root: &Path) -> Ran {
    zwidth(root, &["methods", "thesis-twin"]).exits(0)
}

#[test]
fn compare_makes_what_is_missing_and_says_whom_it_speaks_of() {
    let root = shipped::raw();
    compare(root.path()).exits(0).prints(&[
        "Means by condition",
        "Modes compared",
        "trials of P01",
        "nothing is said of anybody else",
    ]);
    assert!(root.path().join("derived/thesis-twin/compare/contrasts.parquet").exists());
}

#[test]
fn compare_gives_machines_every_row_in_si_units() {
    let ran = zwidth(shipped::finished().path(), &["compare", "thesis-twin", "--json"]).exits(0);
    let json = ran.json();
    let names: Vec<&str> =
        json.as_array().unwrap().iter().map(|t| t["table"].as_str().unwrap()).collect();
    let tables = ["means", "contrasts", "omnibus", "orders"];
    assert_eq!(names, tables.map(|table| format!("{table}_discrepancy_user_mean_n")));
    assert!(json[1]["rows"][0]["difference_n"].as_f64().unwrap().is_finite());
}

#[test]
fn what_other_programs_print_stands_beside_each_difference() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    zwidth_line(root, "twin several --participants 4 --sessions 1 --rate 100 --quiet").exits(0);
    let ran = zwidth_line(root, "compare several --peers --metric duration_s --json").exits(0);
    let json = ran.json();
    assert_eq!(json[0]["table"], "peers_duration_s");
    let rows = json[0]["rows"].as_array().unwrap();
    // Two environments, two contrasts, ten programs.
    assert_eq!(rows.len(), 40);
    for row in rows {
        assert!(row["why"].as_str().is_some_and(|why| !why.is_empty()), "{row}");
        assert!(row["difference_s"].as_f64().is_some(), "{row}");
        let is_normal = row["distribution"] == "normal";
        assert_eq!(row["df"].is_null(), is_normal, "{row}");
    }
    let df = |program: &str| {
        let row = rows.iter().find(|row| row["program"] == program).unwrap();
        row["df"].as_f64().unwrap().round() as u32
    };
    assert_eq!([df("zwidth"), df("pingouin"), df("pyfixest, clustered")], [3; 3]);
    let as_text = zwidth_line(root, "compare several --peers --metric duration_s").exits(0);
    as_text.prints(&["The same differences by other programs", "statsmodels", "docs/analysis.md"]);
    zwidth_line(root, "compare several --peers --by mode").exits(2);
}

#[test]
fn other_programs_have_nothing_to_say_of_one_participant() {
    let root = shipped::finished();
    let ran = zwidth_line(root.path(), "compare thesis-twin --peers").exits(1);
    ran.says(&["P01 alone took part: the other programs compare several people"]);
}

#[test]
fn a_table_is_printed_with_the_columns_and_digits_that_are_asked_for() {
    let root = shipped::finished();
    let table = "table thesis-twin contrasts_discrepancy_user_mean_n";
    let ran = |more: &str| zwidth_line(root.path(), &format!("{table} {more}"));
    let chosen = ran("--columns difference,contrast --digits 2").exits(0);
    let lines: Vec<&str> = chosen.out.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(lines[0], "| difference (N) | contrast |");
    assert_eq!(lines[2..], ["| 0.95 | Hybrid − Active |", "| 0.78 | Hybrid − Active |"]);
    let csv = ran("--columns contrast,difference_n --format csv").exits(0);
    let lines: Vec<&str> = csv.out.lines().collect();
    assert_eq!(lines[0], "contrast,difference_n,synthetic");
    assert!(lines[1].starts_with("hybrid − active,0.9508"), "{}", csv.out);
    // The unit of these depends on the row: without it the number would be of no unit.
    let table = "table thesis-twin comparison --columns contrast,difference";
    let of_rows = zwidth_line(root.path(), table).exits(0);
    of_rows.prints(&[
        "| metric | contrast | difference |",
        "| wall past max (°) | Hybrid − Active | −5.1",
    ]);
    let csv = zwidth_line(root.path(), &format!("{table},metric --format csv")).exits(0);
    assert_eq!(csv.out.lines().next(), Some("contrast,difference,metric,unit,synthetic"));
    ran("--columns differing").exits(1).says(&["has no column 'differing'; it has"]);
    ran("--columns contrast,contrast").exits(1).says(&["contrast"]);
    ran("--digits 3 --format csv").exits(1).says(&["leave --digits out"]);
}

#[test]
fn a_metric_that_is_not_compared_is_named_with_those_that_are() {
    let root = shipped::finished();
    zwidth(root.path(), &["compare", "thesis-twin", "--metric", "loop_area"])
        .exits(1)
        .says(&["--metric loop_area", "loop_area_j"]);
}

#[test]
fn answers_are_compared_without_a_mean() {
    let root = shipped::finished();
    zwidth(root.path(), &["compare", "thesis-twin", "--by", "answer"]).exits(0).prints(&[
        "Answers compared",
        "superiority",
        "never answers",
    ]);
}

#[test]
fn one_session_has_no_sessions_to_compare_and_says_so() {
    let root = shipped::finished();
    zwidth(root.path(), &["compare", "thesis-twin", "--by", "session"])
        .exits(3)
        .says(&["there is nothing to compare"]);
}

#[test]
fn one_participant_tells_no_spread_and_assumed_spreads_give_a_plan_that_is_not_written_over() {
    let root = shipped::finished();
    let difference = ["power", "thesis-twin", "--difference", "0.1"];
    zwidth(root.path(), &difference).exits(1).says(&["give --participant-mode-sd"]);
    let (ran, plan) = power(root.path());
    ran.exits(0).prints(&["power of 80 %", "200 simulated studies"]);
    let written = fs::read(&plan).unwrap();
    power(root.path()).0.exits(1).says(&["exists already; move it elsewhere"]);
    assert_eq!(fs::read(plan).unwrap(), written);
}

#[test]
fn a_plan_beside_the_data_says_whether_the_analysis_is_the_planned_one() {
    let root = shipped::finished();
    let plan = planned(root.path());
    compare(root.path()).exits(0).prints(&[
        "As planned (plan.json",
        "Participants: 12 planned, 1 with trials",
        "The plan was written when 36 trials were there already.",
    ]);
    append(&root.path().join(STUDY), "\n[compare]\nalpha = 0.01\n");
    let words = ["Not as planned (plan.json", "alpha was 0.05, is 0.01"];
    compare(root.path()).exits(0).prints(&words);
    fs::write(&plan, "{").unwrap();
    compare(root.path()).exits(0).prints(&["the file holds no plan"]);
    fs::remove_file(&plan).unwrap();
    std::process::Command::new("mkfifo").arg(&plan).status().unwrap();
    // A pipe in the place of a file is a finding.
    compare(root.path()).exits(3).prints(&["Not as planned", "the file cannot be read"]);
}

#[test]
fn a_metric_of_study_toml_that_there_is_not_is_told() {
    let root = shipped::finished();
    append(&root.path().join(STUDY), "\n[compare]\nmetrics = [\"softness_n\"]\n");
    zwidth(root.path(), &["run", "thesis-twin", "--only", "compare"])
        .exits(3)
        .says(&["there is no metric 'softness_n'"]);
}

/// `zwidth power` of assumed spreads for the finished study, and the plan that it writes.
fn power(root: &Path) -> (Ran, PathBuf) {
    let assumed = "--participant-mode-sd 0.1 --residual-sd 0.2 --studies 200 --plan";
    let ran = zwidth_line(root, &format!("power thesis-twin --difference 0.1 {assumed}"));
    (ran, root.join("raw/thesis-twin/plan.json"))
}

/// A plan for the finished study.
fn planned(root: &Path) -> PathBuf {
    let (ran, plan) = power(root);
    ran.exits(0);
    plan
}

#[test]
fn a_plan_that_was_edited_or_is_of_another_study_is_a_finding_and_nothing_is_as_planned() {
    let root = shipped::finished();
    let plan = planned(root.path());
    let written = fs::read_to_string(&plan).unwrap();
    zwidth(root.path(), &["verify", "thesis-twin"]).exits(0);
    let with = |field: &str, was: &str, is: &str| {
        written.replace(&format!("\"{field}\": {was}"), &format!("\"{field}\": {is}"))
    };
    for (damaged, says) in [
        (with("alpha", "0.05", "0.01"), "does not fit its own hash"),
        (with("participants", "12", "1"), "does not fit its own hash"),
        (with("study", "\"thesis-twin\"", "\"another\""), "study 'another'"),
        (written[..written.len() / 2].to_owned(), "holds no plan"),
    ] {
        assert_ne!(damaged, written);
        fs::write(&plan, damaged).unwrap();
        let verified = zwidth(root.path(), &["verify", "thesis-twin"]).exits(1);
        verified.prints(&["raw/thesis-twin/plan.json", says, "1 finding"]);
        let compared = compare(root.path()).exits(0).prints(&["Not as planned (plan.json", says]);
        assert!(!compared.out.contains("As planned"), "{compared:#?}");
        methods(root.path()).prints(&[says]);
    }
    // A damaged plan stops no run: the report is made, and says so.
    let ran = zwidth(root.path(), &["run", "thesis-twin", "--only", "summary"]).exits(3);
    ran.says(&["plan.json", "holds no plan"]);
    let summary = fs::read_to_string(root.path().join("reports/thesis-twin/summary.md")).unwrap();
    assert!(summary.contains("## The deposited plan\n\n- Not as planned"), "{summary}");
    assert!(summary.contains("Deviation: the file holds no plan"), "{summary}");
}

#[test]
fn a_plan_for_another_study_toml_says_what_differs_even_if_it_is_a_comment() {
    let root = shipped::finished();
    planned(root.path());
    let path = root.path().join(STUDY);
    let text = fs::read_to_string(&path).unwrap();
    // A session that was recorded under another design is a finding.
    for (edited, says, code) in [
        (format!("# A comment.\n{text}"), "they differ in comments and form alone", 0),
        (text.replacen("pause_s = 5.0", "pause_s = 4.0", 1), "s was 5.0, is 4.0", 3),
    ] {
        assert_ne!(edited, text);
        fs::write(&path, edited).unwrap();
        compare(root.path()).exits(code).prints(&["Not as planned (plan.json", says]);
        methods(root.path()).prints(&["Not as planned", says]);
    }
}

#[test]
fn summary_page_and_methods_tell_each_deviation_from_the_plan_in_a_sentence() {
    let root = shipped::finished();
    planned(root.path());
    let path = root.path().join(STUDY);
    edit(&path, "repeats = 6", "repeats = 5");
    append(
        &path,
        "\n[compare]\nalpha = 0.01\nprimary = \"duration_s\"\n\
         bounds = { duration_s = 0.5 }\ncontrasts = [[\"active\", \"passive\"]]\n",
    );
    for stage in ["summary", "page"] {
        zwidth(root.path(), &["run", "thesis-twin", "--only", stage]);
    }
    let sentences = [
        "Not as planned (plan.json",
        "alpha was 0.05, is 0.01.",
        "repeats was 6, is 5.",
        "primary was ",
        "bounds was {}, is ",
        "contrasts was ",
        "the power was computed for discrepancy_user_mean_n, and the primary metric is duration_s",
        "Participants: 12 planned, 1 with trials.",
    ];
    let read = |name: &str| {
        let text = fs::read_to_string(root.path().join("reports/thesis-twin").join(name)).unwrap();
        text.replace('\\', "").replace("&quot;", "\"")
    };
    let in_words = methods(root.path()).out.replace('\\', "");
    for told in [read("summary.md"), read("index.html"), in_words] {
        for sentence in sentences {
            assert!(told.contains(sentence), "'{sentence}' is not in {told}");
        }
    }
    let exclude =
        ["exclude", "thesis-twin", "-p", "P01", "-s", "S01", "--trial", "9", "the phone rang"];
    zwidth(root.path(), &exclude).exits(0);
    methods(root.path()).prints(&["Deviation: 1 trial was excluded by hand."]);
}

#[test]
fn several_primary_metrics_are_answered_one_after_the_other_and_claimed_together() {
    let root = shipped::finished();
    planned(root.path());
    let primary = "\n[compare]\nprimary = [\"duration_s\", \"loop_area_j\"]\n";
    append(&root.path().join(STUDY), primary);
    zwidth(root.path(), &["run", "thesis-twin", "--only", "page"]);
    let page = root.path().join("reports/thesis-twin/index.html");
    let page = fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("<p class=\"answer\">").count(), 2);
    assert_eq!(
        page.matches("(a primary metric; n = ").count(),
        4,
        "each in the head and in the list"
    );
    compare(root.path()).exits(0).prints(&[
        "A primary metric. The rows of this table and of every other primary metric's are one family",
        r"and the primary metrics are duration\_s, loop\_area\_j",
    ]);
    methods(root.path()).prints(&[
        "The primary measures were duration, from onset to end; the user's net work",
        "adjusted over the contrasts of all primary measures over all environments",
    ]);
}
