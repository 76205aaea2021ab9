//! Factors of a design, from recordings by formula to the effects, their figure and the methods text.

use crate::binary::zwidth_line;
use crate::formulas::{import, near, ran, record, u};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const LEVELS: [&str; 3] = ["light", "medium", "heavy"];

/// A study of 3 × 3 weights, the modes.
fn study() -> String {
    let mut study = r#"
schema = 2
[study]
id = "weights"
title = "Visual and haptic weight"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "lever"
lever_m = 0.1
[[environments]]
id = "task"
label = "Task"
kind = "none"
[[factors]]
id = "visual"
levels = ["light", "medium", "heavy"]
[[factors]]
id = "haptic"
levels = ["light", "medium", "heavy"]
[compare]
primary = "force_mean_n"
metrics = []
"#
    .to_owned();
    for (v, visual) in LEVELS.iter().enumerate() {
        for (h, haptic) in LEVELS.iter().enumerate() {
            writeln!(
                study,
                "[[modes]]\nid = \"v{v}h{h}\"\nlabel = \"V{v} H{h}\"\n\
                 factors = {{ visual = \"{visual}\", haptic = \"{haptic}\" }}"
            )
            .unwrap();
        }
    }
    study
}

/// So many people in 3 × 3 conditions, each with a force that both weights make larger, and more so together.
fn weighed(root: &Path, people: u64) {
    for person in 1..=people {
        for v in 0..3_u64 {
            for h in 0..3_u64 {
                let [fv, fh] = [v, h].map(|level| level as f64);
                let force = 3.0
                    + 0.5 * fv
                    + 0.8 * fh
                    + 0.35 * fv * fh
                    + 1.2 * u(&[person])
                    + 0.7 * fv * u(&[person, 1])
                    + 0.5 * fh * u(&[person, 2])
                    + 0.3 * fv * fh * u(&[person, 3])
                    + 0.6 * u(&[person, 4 + 3 * v + h]);
                let force = (1000.0 * force).round() / 1000.0;
                let largest = 20.0 + 0.1 * person as f64 + 0.03 * fv + 0.01 * fh;
                let (who, mode) = (format!("P{person:02}"), format!("v{v}h{h}"));
                record(root, [&who, &mode, "1"], largest, |_| force);
            }
        }
    }
    import(root, "weights", &study(), "[[column]]\nto = \"force_ex_n\"");
}

fn rows<'a>(tables: &'a Value, table: &str) -> &'a [Value] {
    let name = format!("{table}_force_mean_n");
    let found = tables.as_array().unwrap().iter().find(|table| table["table"] == name.as_str());
    found.unwrap()["rows"].as_array().unwrap()
}

/// Thirty people: R's `aov` and `anova.mlm`, and pingouin's `rm_anova`, have these lines.
#[test]
fn an_interaction_of_two_factors_is_found_drawn_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    weighed(root, 30);
    ran(root, "run weights --quiet");
    let tables = ran(root, "compare weights --json").json();
    let lines = rows(&tables, "anova");
    for (line, (effect, df, f, epsilon)) in lines.iter().zip([
        ("visual", [2.0, 58.0], 395.4723939, 0.5969260076),
        ("haptic", [2.0, 58.0], 1206.650916, 0.704480785),
        ("visual:haptic", [4.0, 116.0], 84.6593081, 0.7966493684),
    ]) {
        assert_eq!(line["effect"], effect);
        near(line, "df_effect", df[0]);
        near(line, "df_error", df[1]);
        near(line, "f", f);
        near(line, "epsilon_gg", epsilon);
    }
    let effects = rows(&tables, "effects");
    assert_eq!((lines.len(), effects.len()), (3, 8));
    let last = &effects[7];
    assert_eq!(last["levels"], "(heavy − light) × (heavy − light)");
    assert_eq!((last["verdict"].as_str(), last["df"].as_f64()), (Some("different"), Some(29.0)));
    let summary = fs::read_to_string(root.join("reports/weights/summary.md")).unwrap();
    for sentence in [
        "Task, effects of factors on the user's force, mean over the recording (30 participants). Shown: visual \
         (medium − light: 0.825 N; heavy − light: 1.692 N), haptic",
        "Task, effect of haptic (heavy − light) on the user's force, mean over the recording: 2.277 N",
        "all levels of visual × haptic in the user's force, mean over the recording: F(4, 116) = 84.66",
    ] {
        assert!(summary.contains(sentence), "{sentence}: {summary}");
    }
    assert!(!summary.contains("Nobody has trials in both modes"), "{summary}");
    let order =
        "task: by the trials' numbers all had the modes in this order (v0h0, v0h1, v0h2, v1h0,";
    assert!(summary.contains(order), "{summary}");
    let page = fs::read_to_string(root.join("reports/weights/index.html")).unwrap();
    for part in [
        "Effects of factors are shown in 8 of 8 comparisons in all metrics",
        "<div id=\"claims\"></div>",
        "\"of\":\"Task: visual × haptic: (heavy − light) × (heavy − light)\",\"is_of_groups\":false",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(root.join("reports/weights/figures/effects.force_mean_n.svg").exists());
    ran(root, "methods weights").prints(&[
        "visual (of modes; light, medium, heavy)",
        "The effects of visual, haptic, visual × haptic were compared in each environment",
        "Psychometrika 24:95",
    ]);
    ran(root, "compare weights").prints(&["Task: visual: medium − light"]);

    // Eight effects share alpha; everybody's effects scatter by their standard error times √n.
    let power = "power weights --effect visual:haptic --difference 0.5 --studies 200";
    let planned = ran(root, &format!("{power} --json")).json();
    near(&planned, "alpha", 0.05 / 8.0);
    let widest = effects[4..].iter().map(|row| row["difference_std_error_n"].as_f64().unwrap());
    let deviation = widest.fold(0.0, f64::max) * 30_f64.sqrt();
    near(&planned, "participant_mode_sd", deviation / 2_f64.sqrt());
    let assumed =
        ran(root, &format!("{power} --participant-mode-sd 0.3 --residual-sd 0.2 --json")).json();
    // Four weights of 1: √(4 / 2).
    near(&assumed, "participant_mode_sd", 0.3 * 2_f64.sqrt());
    ran(root, power).prints(&["if the effect of visual × haptic is 0.5, a study of"]);
    zwidth_line(root, "power weights --effect taste --difference 1")
        .exits(1)
        .says(&["--effect taste: weights compares haptic, visual, visual:haptic"]);
}

/// A mode fewer: the other effects are of the cells that there are, and what cannot be told says why.
#[test]
fn without_one_of_its_conditions_an_effect_says_within_which_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    weighed(root, 4);
    let study = study();
    let (before, after) = study.split_once("[[modes]]\nid = \"v0h0\"").unwrap();
    let (_, after) = after.split_once("[[modes]]").unwrap();
    let file = root.join("raw/weights/study.toml");
    fs::write(&file, format!("{before}[[modes]]{after}")).unwrap();
    let tables = ran(root, "compare weights --json").json();
    let effects = rows(&tables, "effects");
    let remark = |row: usize| effects[row]["remark"].as_str().unwrap();
    assert_eq!(remark(0), "within haptic = medium; haptic = heavy");
    assert_eq!(remark(4), "cannot be estimated: no condition has visual = light, haptic = light");
    assert_eq!(effects[4]["verdict"], "not tested");
    // A contrast by hand weighs two of the conditions that there are.
    let weighted = "[[compare.weighted]]\nid = \"more\"\n\
                    weights = { \"task/v2h2\" = 1, \"task/v1h1\" = -1 }\n";
    fs::write(&file, format!("{before}[[modes]]{after}\n{weighted}")).unwrap();
    let tables = ran(root, "compare weights --json").json();
    let last = rows(&tables, "effects").last().unwrap().clone();
    assert_eq!((last["effect"].as_str(), last["n"].as_i64()), (Some("more"), Some(4)));
}

/// Before and after in a single mode: nothing but sessions is compared.
#[test]
fn sessions_are_levels_in_a_study_of_one_mode_and_one_that_nobody_has_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    ran(root, "new training");
    let file = root.join("raw/training/study.toml");
    let text = fs::read_to_string(&file).unwrap();
    let (before, modes) = text.split_once("[[modes]]").unwrap();
    let (first, others) = modes.split_once("[[modes]]").unwrap();
    let (_, rest) = others.split_once("[[questions]]").unwrap();
    let factor = "[[factors]]\nid = \"time\"\nlevels = [\"S01\", \"S02\"]\nof = \"sessions\"\n";
    let compare = "[compare]\nprimary = \"duration_s\"\nmetrics = []\n";
    let study = format!("{before}[[modes]]{first}{factor}{compare}[[questions]]{rest}");
    fs::write(&file, &study).unwrap();
    ran(root, "twin training --participants 4 --sessions 2 --quiet");
    let effects = |tables: &Value| -> Vec<Value> {
        let all = tables.as_array().unwrap().iter();
        let found = all.clone().find(|table| table["table"] == "effects_duration_s").unwrap();
        found["rows"].as_array().unwrap().clone()
    };
    let found = effects(&ran(root, "compare training --json").json());
    assert_eq!(found.len(), 2, "one in each environment: {found:?}");
    assert_eq!((found[0]["levels"].as_str(), found[0]["n"].as_i64()), (Some("S02 − S01"), Some(4)));
    assert!(found[0]["p_adjusted"].as_f64().is_some(), "{found:?}");
    fs::write(&file, study.replace("\"S02\"]", "\"S03\"]")).unwrap();
    let found = effects(&ran(root, "compare training --json").json());
    assert_eq!(found[0]["remark"], "nobody has the session S03");
}
