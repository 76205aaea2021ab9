//! A questionnaire on scales of other lengths than five, from a table to figures: −3 to 3, 0 to 6,
//! 0 to 100 in steps of 5, and a line from 0 to 100; wide and long.

use crate::binary::{Ran, zwidth};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use zwidth_store::Layout;
use zwidth_tables::Table;

const PEOPLE: u32 = 12;
const MODES: [&str; 3] = ["A", "B", "C"];

const STUDY: &str = r#"
schema = 2
[study]
id = "survey"
title = "A survey on four scales"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "three knobs"
[[environments]]
id = "knob"
label = "Knob"
kind = "none"
[[modes]]
id = "A"
label = "Knob A"
[[modes]]
id = "B"
label = "Knob B"
[[modes]]
id = "C"
label = "Knob C"
[[questions]]
id = "mood"
text = "How did it feel?"
points = 7
from = -3
labels = ["very unpleasant", "neither", "very pleasant"]
[[questions]]
id = "hard"
text = "It was too complicated."
points = 7
from = 0
reversed = true
labels = ["not at all", "entirely"]
[[questions]]
id = "load"
text = "How much effort did it take?"
points = 21
from = 0
step = 5
labels = ["very low", "very high"]
[[questions]]
id = "line"
text = "How real was it?"
points = 101
from = 0
reversed = true
labels = ["not at all", "entirely"]
"#;

const WHO: &str = r#"
kind = "likert"
[trial]
participant = { column = "who", prefix = "P", digits = 2 }
session = "S01"
environment = "knob"
mode = { column = "knob" }
"#;

const QUESTIONS: [&str; 4] = ["mood", "hard", "load", "line"];

/// A person's answers after a mode, scattered by a rule: C is liked best.
fn answers(person: u32, mode: u32) -> [i32; 4] {
    let scatter = |step: u32, width: u32| ((person * step + mode * 3) % width) as i32;
    [
        (scatter(3, 5) - 3 + mode as i32).clamp(-3, 3),
        (5 - scatter(7, 4) - mode as i32).clamp(0, 6),
        (scatter(7, 10) + 3 * mode as i32).clamp(0, 20) * 5,
        (scatter(37, 60) + 15 * mode as i32).clamp(0, 100),
    ]
}

/// The time that an answer took, ms.
fn time_ms(person: u32, mode: u32, question: usize) -> u32 {
    1_000 + 100 * person + 10 * mode + question as u32
}

fn each(mut row: impl FnMut(u32, u32, [i32; 4])) {
    for person in 1..=PEOPLE {
        for mode in 0..3 {
            row(person, mode, answers(person, mode));
        }
    }
}

/// A row a person and mode.
fn wide() -> String {
    let mut table = "who,knob,mood,hard,load,line\n".to_owned();
    each(|person, mode, [a, b, c, d]| {
        writeln!(table, "{person},{},{a},{b},{c},{d}", MODES[mode as usize]).unwrap();
    });
    table
}

const WIDE: &str =
    "[questions.columns]\nmood = \"mood\"\nhard = \"hard\"\nload = \"load\"\nline = \"line\"\n";

/// A row an answer, question by question.
fn long() -> String {
    let mut table = "who,knob,item,answer,rt\n".to_owned();
    for (place, question) in QUESTIONS.iter().enumerate() {
        each(|person, mode, answers| {
            let (knob, time) = (MODES[mode as usize], time_ms(person, mode, place));
            writeln!(table, "{person},{knob},{question},{},{time}", answers[place]).unwrap();
        });
    }
    table
}

const LONG: &str = "[questions]\nquestion = { column = \"item\" }\nanswer = \"answer\"\ntime = \"rt\"\ntime_unit = \"ms\"\n";

fn layout(root: &Path) -> Layout {
    Layout::new(root, "survey".parse().unwrap())
}

/// An import of a table of answers into this study.
pub(crate) fn import_answers(root: &Path, study: &str, questions: &str, table: &str) -> Ran {
    let layout = layout(root);
    fs::create_dir_all(layout.raw()).unwrap();
    fs::write(layout.study_toml(), study).unwrap();
    fs::write(root.join("map.toml"), format!("{WHO}{questions}")).unwrap();
    fs::write(root.join("answers.csv"), table).unwrap();
    let [map, csv] = ["map.toml", "answers.csv"].map(|name| root.join(name));
    let [map, csv] = [&map, &csv].map(|path| path.to_str().unwrap());
    zwidth(root, &["import", "survey", "--map", map, csv])
}

pub(crate) fn has_no_findings(root: &Path) {
    let found = zwidth(root, &["verify", "survey"]).exits(0).out;
    assert_eq!(found, "survey: no findings (schema 2)\n");
}

fn derived(layout: &Layout, name: &str) -> Table {
    Table::from_parquet(&layout.derived().join(name)).unwrap()
}

/// The row of a question and a mode.
fn row_of(table: &Table, question: &str, mode: &str) -> usize {
    let [questions, modes] = ["question", "mode"].map(|name| table.texts(name).unwrap());
    let is = |row: &usize| {
        questions[*row].as_deref() == Some(question) && modes[*row].as_deref() == Some(mode)
    };
    (0..table.height()).find(is).unwrap()
}

#[test]
fn a_wide_and_a_long_table_of_the_same_answers_give_the_same_study() {
    let [wide, long] = [(wide(), WIDE), (long(), LONG)].map(|(table, questions)| {
        let root = tempfile::tempdir().unwrap();
        let layout = layout(root.path());
        import_answers(root.path(), STUDY, questions, &table)
            .exits(0)
            .prints(&["36 trials without samples, 144 answers"]);
        has_no_findings(root.path());
        zwidth(root.path(), &["run", "survey", "--only", "likert tallies"]).exits(0);
        (derived(&layout, "likert.parquet"), derived(&layout, "answers.parquet"))
    });
    assert_eq!(wide.0.columns(), long.0.columns());
    assert_eq!(wide.0.height(), 12);
    // The long one has the times besides.
    let times = long.1.floats("answer_time_s").unwrap();
    assert!(wide.1.column("answer_time_s").is_err());
    assert!(times.iter().all(|t| t.is_some_and(|t| (1.0..3.0).contains(&t))), "{times:?}");
    assert_eq!(long.1.floats("answer").unwrap().len(), 144, "one of the scales is a line");
}

#[test]
fn each_scale_is_tallied_compared_and_drawn_as_what_it_is() {
    let root = tempfile::tempdir().unwrap();
    let layout = layout(root.path());
    import_answers(root.path(), STUDY, LONG, &long()).exits(0);
    zwidth(root.path(), &["run", "survey"]).exits(0);
    let tally = derived(&layout, "likert.parquet");
    for (place, question) in QUESTIONS.iter().enumerate() {
        for (number, mode) in (0..).zip(MODES) {
            let mut given: Vec<i32> = (1..=PEOPLE).map(|p| answers(p, number)[place]).collect();
            if *question == "hard" {
                given.iter_mut().for_each(|a| *a = 6 - *a);
            } else if *question == "line" {
                given.iter_mut().for_each(|a| *a = 100 - *a);
            }
            given.sort_unstable();
            let row = row_of(&tally, question, mode);
            let cell = |column: &str| tally.integers(column).unwrap()[row];
            let median = |column: &str| tally.floats(column).unwrap()[row];
            assert_eq!(median("median_low"), Some(given[5].into()), "{question} {mode}");
            assert_eq!(median("median_high"), Some(given[6].into()), "{question} {mode}");
            let lowest = if *question == "mood" { -3 } else { 0 };
            for point in 1..=7 {
                let n = given.iter().filter(|a| **a == lowest + point - 1).count() as i64;
                let counted = cell(&format!("count_{point}"));
                assert_eq!(counted, Some(n).filter(|_| place < 2), "{question} {mode} {point}");
            }
            let mean = tally.floats("mean").unwrap()[row];
            let expect = f64::from(given.iter().sum::<i32>()) / f64::from(PEOPLE);
            assert_eq!(mean.map(|m| (m - expect).abs() < 1e-12), (place > 1).then_some(true));
        }
    }
    let compared = derived(&layout, "compare/answers_compared.parquet");
    let [questions, models] = ["question", "model"].map(|name| compared.texts(name).unwrap());
    let [odds, difference, p] =
        ["odds_ratio", "difference", "p_value"].map(|name| compared.floats(name).unwrap());
    let remarks = compared.texts("remark").unwrap();
    for row in 0..compared.height() {
        let is_long = ["load", "line"].contains(&questions[row].as_deref().unwrap());
        assert_eq!(
            (odds[row].is_none(), difference[row].is_some()),
            (is_long, is_long),
            "{remarks:?}"
        );
        assert!(p[row].is_some());
        let model = models[row].as_deref().unwrap();
        assert!(model.starts_with(if is_long { "means, as for a metric" } else { "cumulative" }));
    }
    let figures = layout.reports().join("figures");
    for stem in ["likert", "likert_items", "ratings", "answers"] {
        let pages = fs::read_dir(&figures)
            .unwrap()
            .filter_map(|f| f.unwrap().file_name().into_string().ok());
        let drawn = pages.filter(|f| f.starts_with(stem) && f.ends_with(".svg")).count();
        assert!(drawn > 0, "{stem}");
    }
    assert!(layout.reports().join("index.html").exists());
    if let Some(kept) = std::env::var_os("ZWIDTH_KEEP_SURVEY") {
        fs::rename(layout.reports(), Path::new(&kept)).unwrap();
    }
}

#[test]
fn an_answer_that_its_scale_does_not_have_is_refused_with_its_cell_and_the_scale() {
    let root = tempfile::tempdir().unwrap();
    for (row, words) in [
        ("1,A,4,0,0,0", ["the answer '4' must be a whole number from -3 to 3", "mood"]),
        ("1,A,0,7,0,0", ["the answer '7' must be a whole number from 0 to 6", "hard"]),
        ("1,A,0,0,12,0", ["from 0 to 100 in steps of 5", "load"]),
        ("1,A,1.5,0,0,0", ["the answer '1.5' must be a whole number from -3 to 3", "mood"]),
        ("1,A,0,0,0,100.5", ["the answer '100.5' must be a number from 0 to 100", "line"]),
        ("1,A,0,0,0,half", ["the answer 'half' must be a number from 0 to 100", "line"]),
    ] {
        let table = format!("who,knob,mood,hard,load,line\n{row}\n");
        import_answers(root.path(), STUDY, WIDE, &table).exits(1).says(&words);
    }
}

/// A slider's answers after the modes A and B, in eighths: every sum and difference of them is exact.
const SLIDER: [[f64; 2]; 6] = [
    [47.125, 53.5],
    [54.625, 60.25],
    [61.875, 68.125],
    [44.0, 51.375],
    [51.25, 57.0],
    [58.5, 66.875],
];

/// The study with the answers of a slider alone, to the question that is turned round.
fn with_slider(root: &Path) -> Layout {
    let mut table = "who,knob,line\n".to_owned();
    for (person, [a, b]) in (1..).zip(SLIDER) {
        write!(table, "{person},A,{a}\n{person},B,{b}\n").unwrap();
    }
    let study = STUDY.replace("[[modes]]\nid = \"C\"\nlabel = \"Knob C\"\n", "").replace(
        "kind = \"none\"\n",
        "kind = \"none\"\nquestions = [\"mood\", \"load\", \"line\"]\n",
    );
    import_answers(root, &study, "[questions.columns]\nline = \"line\"\n", &table).exits(0);
    layout(root)
}

#[test]
fn decimals_of_a_slider_are_compared_by_their_own_means() {
    let root = tempfile::tempdir().unwrap();
    let layout = with_slider(root.path());
    let log = |who: &str| {
        fs::read_to_string(layout.events(&who.parse().unwrap(), &"S01".parse().unwrap())).unwrap()
    };
    assert!(log("P01").contains(r#""value":47.125"#), "{}", log("P01"));
    assert!(log("P04").contains(r#""value":44}"#), "{}", log("P04"));
    has_no_findings(root.path());
    zwidth(root.path(), &["run", "survey"]).exits(0);
    zwidth(root.path(), &["compare", "survey", "--by", "answer"]).exits(0);
    let mean = |side: usize| SLIDER.iter().map(|pair| pair[side]).sum::<f64>() / 6.0;
    let compared = derived(&layout, "compare/answers_compared.parquet");
    assert_eq!(compared.texts("contrast").unwrap(), [Some("B − A".to_owned())]);
    assert_eq!(compared.integers("n").unwrap(), [Some(6)]);
    // The question is turned round, so that B lies below A, for everybody.
    assert_eq!(compared.floats("difference").unwrap(), [Some(mean(0) - mean(1))]);
    assert_eq!(compared.floats("superiority").unwrap(), [Some(0.0)]);
    let tally = derived(&layout, "likert.parquet");
    let mut scored = SLIDER.map(|pair| 100.0 - pair[0]);
    scored.sort_by(f64::total_cmp);
    let median = |column: &str| tally.floats(column).unwrap()[row_of(&tally, "line", "A")];
    assert_eq!([median("median_low"), median("median_high")], [scored[2], scored[3]].map(Some));
    let answers = derived(&layout, "answers.parquet").floats("answer").unwrap();
    assert_eq!(answers, SLIDER.concat().into_iter().map(Some).collect::<Vec<_>>());
    let summary = fs::read_to_string(layout.reports().join("summary.md")).unwrap();
    assert!(summary.contains("the median answer was 51.25 to 54.62 with Knob A"), "{summary}");
}

#[test]
fn late_answers_have_decimals_on_a_line_and_on_no_other_scale() {
    let root = tempfile::tempdir().unwrap();
    let layout = with_slider(root.path());
    let answer = |question: &str, value: &str| {
        let of = ["answer", "survey", "-p", "P01", "-s", "S01", "--trial", "1"];
        zwidth(root.path(), &[&of[..], &["--question", question, value]].concat())
    };
    let words = "line is answered with 47.273, in place of 47.125";
    answer("line", "47.273").exits(0).prints(&[words]);
    for (question, value, words) in [
        ("line", "100.5", "100.5 is no answer to line: it must be a number from 0 to 100"),
        ("mood", "-0.5", "it must be a whole number from -3 to 3"),
        ("load", "47", "it must be a whole number from 0 to 100 in steps of 5"),
    ] {
        answer(question, value).exits(1).says(&[words]);
    }
    answer("line", "NaN").exits(2).says(&["'NaN' is not a number"]);
    let table = root.path().join("late.csv");
    fs::write(&table, "participant;session;trial;question;answer\nP01;S01;1;line;47,3\n").unwrap();
    let give = ["answer", "survey", "--from", table.to_str().unwrap()];
    zwidth(root.path(), &give).exits(0);
    let data = zwidth_store::StudyData::load(&layout).unwrap();
    assert_eq!(data.answers[0].value, "47.3".parse().unwrap());
}
