//! Groups of people, from recordings and a participants' file to the tables and the sentences.

use crate::binary::{zwidth, zwidth_line};
use crate::formulas::{import, near, ran, record, u};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const MODES: [&str; 3] = ["active", "passive", "hybrid"];

const STUDY: &str = r#"
schema = 2
[study]
id = "twelve"
title = "Twelve people"
[design]
repeats = 4
familiarisation = 0
trial_limit_s = 60.0
pause_s = 0.0
[device]
name = "lever"
lever_m = 0.1
[[environments]]
id = "task"
label = "Task"
kind = "none"
[[modes]]
id = "active"
label = "Active"
[[modes]]
id = "passive"
label = "Passive"
[[modes]]
id = "hybrid"
label = "Hybrid"
[[people]]
id = "group"
levels = ["novice", "expert"]
[compare]
primary = "force_mean_n"
metrics = []
groups = "group"
"#;

/// The study of twelve people in three modes, of whom the last five are experts and scatter three times as much;
/// a trial's force is constant, so that its mean is known.
fn twelve(root: &Path) {
    let mut people = "participant,group\n".to_owned();
    for person in 1..=12 {
        let expert = if person > 7 { 1.0 } else { 0.0 };
        writeln!(people, "P{person:02},{}", if person > 7 { "expert" } else { "novice" }).unwrap();
        for (m, mode) in (0_u64..).zip(MODES) {
            for repeat in 1..=4 {
                let hybrid = if m == 2 { 1.0 } else { 0.0 };
                let force = 2.0
                    + 0.25 * m as f64
                    + (0.15 + 0.3 * expert) * hybrid
                    + 0.8 * u(&[person])
                    + 0.6 * (1.0 + 2.0 * expert) * u(&[person, m + 1])
                    + 0.4 * u(&[person, m + 1, repeat]);
                let force = (1000.0 * force).round() / 1000.0;
                let largest = 20.0 + 0.1 * person as f64 + 0.03 * m as f64 + 0.01 * repeat as f64;
                let (who, repeat) = (format!("P{person:02}"), repeat.to_string());
                record(root, [&who, mode, &repeat], largest, |_| force);
            }
        }
    }
    import(root, "twelve", STUDY, FORCE);
    fs::write(root.join("raw/twelve/participants.csv"), people).unwrap();
}

/// The column of the force.
const FORCE: &str = "[[column]]\nto = \"force_ex_n\"";

/// The row of a table of `compare --json` in which these columns have these values.
fn row<'a>(tables: &'a Value, table: &str, values: &[(&str, &str)]) -> &'a Value {
    let all = tables.as_array().unwrap().iter();
    let found = all.clone().find(|t| t["table"] == format!("{table}_force_mean_n").as_str());
    let rows = found.unwrap()["rows"].as_array().unwrap();
    let is_it = |row: &&Value| values.iter().all(|(name, value)| row[*name] == *value);
    rows.iter().find(is_it).unwrap()
}

/// The numbers of R 4.2 (`t.test`) and SciPy 1.17 on people's means; permutations counted in Python.
#[test]
fn groups_of_people_are_compared_from_recordings_to_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    twelve(root);
    ran(root, "run twelve --quiet");
    let groups = ran(root, "compare twelve --by group --json").json();
    let between = row(&groups, "groups", &[("effect", "hybrid − active")]);
    near(between, "difference_n", 0.0245571429);
    near(between, "difference_std_error_n", 0.408888294);
    near(between, "df", 4.33041842);
    near(between, "p_value", 0.954780048);
    near(between, "difference_ci_low_n", -1.07733935);
    near(between, "p_permuted", 742.0 / 792.0);
    near(row(&groups, "groups", &[("effect", "hybrid")]), "p_value", 0.631813917);
    let expert = [("group", "expert"), ("contrast", "hybrid − active")];
    near(row(&groups, "group_contrasts", &expert), "p_value", 0.164866159);
    let modes = ran(root, "compare twelve --json").json();
    let contrast = row(&modes, "contrasts", &[("contrast", "hybrid − active")]);
    near(contrast, "difference_n", 0.667921429);
    near(contrast, "p_value", 0.0274871718);

    let summary = fs::read_to_string(root.join("reports/twelve/summary.md")).unwrap();
    let sentence = "Task, expert − novice in the difference Hybrid − Active: the user's force, mean over the \
                    recording differs by 0.02 N (interval −1.08 to 1.13, 5 and 7 people, Welch's t(4.330) = 0.06006";
    assert!(summary.contains(sentence), "{summary}");
    assert!(root.join("reports/twelve/figures/groups.force_mean_n.svg").exists());
    let page = fs::read_to_string(root.join("reports/twelve/index.html")).unwrap();
    let claim =
        "\"of\":\"Task: expert − novice in the difference Hybrid − Active\",\"is_of_groups\":true";
    assert!(
        page.contains(claim) && page.contains("Groups differ in 0 of 3 comparisons"),
        "{claim}"
    );
    ran(root, "methods twelve").prints(&["Welch's t test (Welch 1947)", "Satterthwaite 1946"]);
    ran(root, "compare twelve").prints(&["Task: expert − novice, mean over modes"]);

    // Whoever moves to another group moves in every result of groups, and nothing of them is stale.
    let file = root.join("raw/twelve/participants.csv");
    let people = fs::read_to_string(&file).unwrap();
    fs::write(&file, people.replace("P08,expert", "P08,novice")).unwrap();
    let moved = ran(root, "compare twelve --by group --json").json();
    let moved = row(&moved, "groups", &[("effect", "hybrid − active")]);
    assert_eq!((moved["n_first"].as_i64(), moved["n_second"].as_i64()), (Some(4), Some(8)));
}

#[test]
fn a_wrong_participants_file_is_refused_and_who_has_no_group_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    twelve(root);
    let file = root.join("raw/twelve/participants.csv");
    let people = fs::read_to_string(&file).unwrap();
    fs::write(&file, people.replace("P08,expert", "P08,Expert")).unwrap();
    zwidth_line(root, "run twelve").exits(1).says(&[
        "participants.csv: line 9: group: 'Expert' is no level of it; there are novice, expert",
    ]);
    fs::write(&file, people.replace("P08,expert", "P08,")).unwrap();
    zwidth_line(root, "verify twelve").exits(1).prints(&["P08 has no group"]);
    ran(root, "compare twelve --by group").prints(&["Without P08 (no group)."]);
    fs::remove_file(&file).unwrap();
    zwidth_line(root, "verify twelve").exits(1).prints(&["12 participants have no group"]);
    ran(root, "compare twelve").says(&["task, hybrid − active: nobody who has both has a group."]);
    let study = root.join("raw/twelve/study.toml");
    fs::write(&study, STUDY.replace("groups = \"group\"\n", "")).unwrap();
    let groups = zwidth_line(root, "compare twelve --by group").exits(1);
    groups.says(&["names no groups: name a column of people in raw/twelve/study.toml"]);
}

/// Modes of different people: no difference within anybody, and a word on why.
#[test]
fn modes_that_nobody_has_both_of_are_told_to_be_groups() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    twelve(root);
    let recordings = fs::read_dir(root.join("recordings")).unwrap();
    for path in recordings.map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let person: u32 = name[1..3].parse().unwrap();
        let own = MODES[person as usize % 2];
        if !name.contains(own) {
            fs::remove_file(&path).unwrap();
        }
    }
    fs::remove_dir_all(root.join("raw/twelve")).unwrap();
    let without =
        STUDY.replace("groups = \"group\"\n", "contrasts = [[\"passive\", \"active\"]]\n");
    import(root, "twelve", &without, FORCE);
    ran(root, "compare twelve").says(&[
        "task, passive − active: nobody has both (6 participants have the one, 6 the other)",
        "name them as a column of people",
    ]);
}

#[test]
fn groups_that_chance_gave_in_the_session_are_compared_within_the_blocks_of_the_drawing() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    ran(root, "new drawn --quiet");
    let file = root.join("raw/drawn/study.toml");
    let plan = fs::read_to_string(&file).unwrap();
    let plan = plan
        .replace("repeats = 6", "repeats = 1")
        .replace("familiarisation = 3", "familiarisation = 0")
        .replace("rate_hz = 1000.0", "rate_hz = 120.0");
    let groups = "\n[[people]]\nid = \"group\"\nlevels = [\"control\", \"assisted\"]\nassigned = true\n\
                  [compare]\ngroups = \"group\"\n";
    fs::write(&file, plan + groups).unwrap();
    ran(root, "twin drawn --participants 8 --sessions 1 --quiet");
    zwidth_line(root, "verify drawn").exits(0);
    ran(root, "run drawn --quiet --only compare");
    let four = ["| group | control | 4 |", "| group | assisted | 4 |"];
    ran(root, "table drawn people").prints(&four);
    ran(root, "compare drawn --by group").prints(&["within the blocks of the drawing"]);
    let tables = ran(root, "compare drawn --by group --json").json();
    let groups = tables.as_array().unwrap()[0]["rows"].as_array().unwrap();
    // Two blocks of two and two: 6 × 6 arrangements, of which each has a mirror.
    near(&groups[0], "smallest_p_permuted", 2.0 / 36.0);

    // A workbook holds them; one that is there stays.
    let book = root.join("all.xlsx");
    zwidth(root, &["table", "drawn", "--xlsx", book.to_str().unwrap()]).exits(0);
    let bytes = fs::read(&book).unwrap();
    assert!(bytes.starts_with(b"PK"));
    let again = zwidth(root, &["table", "drawn", "people", "--xlsx", book.to_str().unwrap()]);
    again.exits(1).says(&["all.xlsx exists already; name another file"]);
    assert_eq!(fs::read(&book).unwrap(), bytes);
    zwidth_line(root, "power drawn --difference 1 --groups 3,9")
        .exits(1)
        .says(&["a claim takes 4"]);
}
