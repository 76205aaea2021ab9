//! The question which mode it was: what a blinded session shows of it, and the table that says how
//! often the mode was known.

use crate::acquire::Desk;
use crate::binary::{Ran, zwidth, zwidth_line};
use crate::folders::{edit, files};
use crate::small::{Draft, Study, draft};
use crate::survey::{has_no_findings, import_answers};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use zwidth_store::{Layout, StudyData, read_trial};
use zwidth_study::{Event, Kind, Status};
use zwidth_tables::Table;

const GUESS: &str = "[[questions]]\nid = \"guess\"\ntext = \"Which mode was it?\"\nasks = \"mode\"\n\n[[questions]]";

/// How it is asked in plain mode.
const ASKED: &str =
    "question (2 of 2) Which mode was it? (0 do not know, 1 Active, 2 Passive, 3 Hybrid)";

/// Trials of a session of one environment: one to practise, and one in each mode.
const TRIALS: usize = 4;

/// A study of one environment that asks for the mode.
fn desk(blinded: bool) -> Desk {
    let desk = Desk::new(blinded);
    desk.edit_study("question = \"felt_spring\"", "questions = [\"felt_spring\", \"guess\"]");
    desk.edit_study("[[questions]]", GUESS);
    let path = desk.root().join("raw/small/study.toml");
    let text = fs::read_to_string(&path).unwrap();
    let from = text.find("[[environments]]\nid = \"spring_wall\"").unwrap();
    let to = from + text[from..].find("# How it is rendered").unwrap();
    fs::write(&path, format!("{}{}", &text[..from], &text[to..])).unwrap();
    desk
}

/// A session of which every trial is answered alike.
fn session(desk: &Desk, more: &[&str]) -> Ran {
    desk.acquire(&("start\n3\n0\n".repeat(TRIALS) + "quit\n"), more).exits(0)
}

fn modes(desk: &Desk) -> Vec<String> {
    let data = StudyData::load(&Layout::new(desk.root(), "small".parse().unwrap())).unwrap();
    data.trials.iter().map(|trial| trial.meta.mode.to_string()).collect()
}

/// What is shown of the questions.
fn questions(ran: &Ran) -> Vec<&str> {
    ran.out.lines().filter(|line| line.starts_with("question")).collect()
}

#[test]
fn a_blinded_session_shows_the_same_whatever_the_modes_of_its_trials() {
    let made = ["1", "2"].map(|seed| {
        let desk = desk(true);
        let ran = session(&desk, &["--seed", seed]);
        desk.verify();
        (desk, ran)
    });
    let [(first, one), (second, other)] = &made;
    assert_eq!(one.out, other.out);
    assert_eq!(questions(one).iter().filter(|line| **line == ASKED).count(), TRIALS);
    // Besides that list nothing has a mode's name.
    for text in [&one.out.replace(ASKED, ""), &one.err, &first.record().to_string()] {
        for mode in ["active", "passive", "hybrid"] {
            assert!(!text.to_lowercase().contains(mode), "{mode} in {text}");
        }
    }
    first.unseal().exits(0);
    second.unseal().exits(0);
    assert_ne!(modes(first), modes(second), "the test needs seeds with other orders");
}

#[test]
fn the_table_has_no_sealed_session_and_counts_its_trials() {
    let desk = desk(true);
    let key = desk.keys();
    session(&desk, &[]);
    let second = ["acquire", "small", "-p", "P02", "-s", "S01", "--plain", "--fast", "--auto"];
    let keyed = ["--key", key.to_str().unwrap()];
    zwidth(desk.root(), &[&second[..], &keyed[..]].concat()).exits(0);
    zwidth(desk.root(), &["run", "--only", "likert tallies"]);
    let path = desk.root().join("derived/small/blinding.parquet");
    assert!(!path.exists(), "both are sealed");
    desk.unseal().exits(0);
    zwidth(desk.root(), &["run", "--only", "likert tallies"]).exits(0);
    let table = Table::from_parquet(&path).unwrap();
    assert_eq!(table.texts("participant").unwrap(), vec![Some("P01".to_owned()); 3]);
    assert_eq!(table.integers("do_not_know").unwrap(), [Some(1); 3]);
    assert_eq!(table.floats("index").unwrap(), [Some(0.0); 3]);
    let notes = table.notes().join("\n");
    assert!(notes.contains("Without 3 trials of sealed sessions"), "{notes}");
}

#[test]
fn a_mode_that_there_is_not_is_refused_with_the_range() {
    let desk = desk(false);
    let answered = desk.acquire("start\n3\n4\n2\nquit\n", &[]).exits(3);
    answered.prints(&["4 is not an answer: 0 to 3"]);
    let of = ["answer", "small", "-p", "P01", "-s", "S01", "--trial", "1", "--question", "guess"];
    let answer = |value| zwidth(desk.root(), &[&of[..], &[value]].concat());
    answer("4")
        .exits(1)
        .one_error()
        .says(&["4 is no answer to guess: it must be a whole number from 0 to 3"]);
    answer("0").exits(0).prints(&["in place of 2"]);
    desk.verify();
}

/// A guess after a trial.
fn guess(trial: u32, value: i16) -> Event {
    Event::Answer { trial, question: "guess".parse().unwrap(), value: value.into(), time_ms: None }
}

/// A trial with its guesses, of which the last one counts.
fn guessed(trial: u32, mode: &'static str, values: &[i16]) -> Draft {
    let events = values.iter().map(|value| guess(trial, *value)).collect();
    Draft { likert: Some(4), events, ..draft(trial, "spring", mode) }
}

/// Two participants; some trials of the first must not count, and say what would change the index.
fn study() -> Study {
    let study = Study::new("guessed");
    let path = study.layout().study_toml();
    edit(&path, "question = \"felt_spring\"", "questions = [\"felt_spring\", \"guess\"]");
    edit(&path, "[[questions]]", GUESS);
    let excluded = Event::Excluded { trial: 8, reason: "the phone rang".to_owned() };
    study.session(
        "P01",
        &[
            guessed(1, "active", &[1]),
            guessed(2, "active", &[3, 1]),
            guessed(3, "active", &[2]),
            guessed(4, "active", &[0]),
            guessed(5, "passive", &[3]),
            guessed(6, "hybrid", &[]),
            guessed(7, "hybrid", &[3]),
            Draft { events: vec![guess(8, 1), excluded], ..guessed(8, "hybrid", &[]) },
            Draft { kind: Kind::Familiarisation, ..guessed(9, "passive", &[2]) },
            Draft { status: Status::Incomplete, ..guessed(10, "passive", &[2]) },
        ],
    );
    study.session(
        "P02",
        &[guessed(1, "active", &[1]), guessed(2, "passive", &[2]), guessed(3, "hybrid", &[1])],
    );
    study
}

/// Right, wrong and "do not know" by participant and mode, counted from the raw files: modes from
/// the trials' Parquet files, guesses from the lines of the logs.
fn counted(study: &Study) -> BTreeMap<(String, String), [i64; 3]> {
    let numbers = BTreeMap::from([("active", 1), ("passive", 2), ("hybrid", 3)]);
    let mut found: BTreeMap<_, [i64; 3]> = BTreeMap::new();
    for path in files(&study.layout().raw(), "parquet") {
        let meta = read_trial(&path, []).unwrap().meta;
        let lines = log(&study.events(meta.participant.as_str()));
        let of_it = |line: &&Value| line["what"]["trial"] == meta.trial;
        let is_excluded = lines.iter().filter(of_it).any(|line| !line["what"]["reason"].is_null());
        if meta.kind != Kind::Trial || meta.status != Status::Complete || is_excluded {
            continue;
        }
        let mode = meta.mode.to_string();
        let is_guess = |line: &&Value| line["what"]["question"] == "guess";
        let mut said = lines.iter().filter(of_it).filter(is_guess);
        let said = said.next_back().and_then(|line| line["what"]["value"].as_i64());
        let place = match said {
            None => continue,
            Some(0) => 2,
            Some(said) => usize::from(said != numbers[mode.as_str()]),
        };
        found.entry((meta.participant.to_string(), mode)).or_default()[place] += 1;
    }
    found
}

fn log(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn the_index_is_that_of_an_independent_count_of_the_raw_files() {
    let study = study();
    zwidth(study.root(), &["run"]).exits(0);
    let table = study.derived("blinding");
    let [who, modes] = ["participant", "mode"].map(|name| table.texts(name).unwrap());
    let counts = ["right", "wrong", "do_not_know"].map(|name| table.integers(name).unwrap());
    let index = table.floats("index").unwrap();
    let expect = counted(&study);
    let mut own: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in (0..table.height()).filter(|row| who[*row].is_some()) {
        let key = (who[row].clone().unwrap(), modes[row].clone().unwrap());
        let [right, wrong, unknown] = expect[&key];
        assert_eq!(counts.each_ref().map(|c| c[row]), [right, wrong, unknown].map(Some), "{key:?}");
        let n = (right + wrong + unknown) as f64;
        let of_it = right as f64 / n - wrong as f64 / (2.0 * n);
        assert!((index[row].unwrap() - of_it).abs() < 1e-12, "{key:?}");
        own.entry(key.1).or_default().push(of_it);
    }
    assert_eq!(expect.len(), 6);
    let over: Vec<usize> = (0..table.height()).filter(|row| who[*row].is_none()).collect();
    assert_eq!(
        over.iter().map(|row| modes[*row].clone().unwrap()).collect::<Vec<_>>(),
        ["active", "passive", "hybrid"]
    );
    for row in over {
        let of = &own[modes[row].as_ref().unwrap()];
        assert!((index[row].unwrap() - 0.5 * (of[0] + of[1])).abs() < 1e-12);
    }
    assert_eq!(table.integers("trials").unwrap()[2], Some(2), "one of them was left open");
}

#[test]
fn a_guess_is_in_no_tally_figure_or_comparison_of_answers() {
    let study = study();
    zwidth(study.root(), &["run"]).exits(0);
    let questions = |name: &str| {
        let questions = study.derived(name).texts("question").unwrap();
        BTreeSet::from_iter(questions.into_iter().flatten())
    };
    let rated = BTreeSet::from(["felt_spring".to_owned()]);
    let all = BTreeSet::from(["felt_spring", "guess"].map(str::to_owned));
    assert_eq!(questions("answers"), all);
    for name in ["likert", "compare/answers_compared", "compare/answers_participants"] {
        assert_eq!(questions(name), rated, "{name}");
    }
    for path in files(&study.layout().reports(), "svg") {
        let text = fs::read_to_string(&path).unwrap();
        assert!(!text.contains("Which mode"), "{}", path.display());
    }
    let words = ["Active, Passive, Hybrid or “do not know”", "blinding index"];
    zwidth(study.root(), &["methods", "guessed"]).exits(0).prints(&words);
    zwidth(study.root(), &["table", "guessed", "blinding"]).exits(0).prints(&["Blinding index"]);
}

const SURVEY: &str = r#"
schema = 2
[study]
id = "survey"
title = "Two knobs"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "two knobs"
[[environments]]
id = "knob"
label = "Knob"
kind = "none"
question = "guess"
[[modes]]
id = "A"
label = "Knob A"
[[modes]]
id = "B"
label = "Knob B"
[[questions]]
id = "guess"
text = "Which knob was it?"
asks = "mode"
"#;

/// An import of this table, which has nothing but guesses.
fn import(root: &Path, questions: &str, table: &str) -> Ran {
    import_answers(root, SURVEY, questions, table)
}

const WIDE: &str = "[questions.columns]\nguess = \"guess\"\n\
    [questions.translate]\n\"the first\" = 1\n\"the second\" = 2\n";
const LONG: &str = "[questions]\nquestion = { column = \"item\" }\nanswer = \"answer\"\n";

#[test]
fn guesses_are_imported_wide_and_long_and_alone_make_the_table_and_no_tally() {
    let wide = "who,knob,guess\n1,A,the first\n1,B,the second\n2,A,the second\n2,B,0\n";
    let long = "who,knob,item,answer\n1,A,guess,1\n1,B,guess,2\n2,A,guess,2\n2,B,guess,0\n";
    for (questions, table) in [(WIDE, wide), (LONG, long)] {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        import(root, questions, table).exits(0);
        has_no_findings(root);
        zwidth(root, &["run"]).exits(0);
        let derived = root.join("derived/survey");
        let table = Table::from_parquet(&derived.join("blinding.parquet")).unwrap();
        let of = |values: [f64; 6]| values.map(Some).to_vec();
        assert_eq!(table.floats("index").unwrap(), of([1.0, 1.0, -1.0, 0.0, 0.0, 0.5]));
        assert!(derived.join("answers.parquet").exists());
        assert!(!derived.join("likert.parquet").exists() && !derived.join("compare").exists());
    }
    let folder = tempfile::tempdir().unwrap();
    let bad = long.replace("guess,0", "guess,3");
    import(folder.path(), LONG, &bad).exits(1).says(&["'3'", "from 0 to 2"]);
}

#[test]
fn a_simulated_participant_guesses_at_chance() {
    let desk = desk(false);
    desk.edit_study("\nrepeats = 1\n", "\nrepeats = 12\n");
    zwidth_line(desk.root(), "twin small --participants 3 --sessions 1 --seed 1").exits(0);
    desk.verify();
    zwidth(desk.root(), &["run", "--only", "likert tallies"]).exits(0);
    let path = desk.root().join("derived/small/blinding.parquet");
    let table = Table::from_parquet(&path).unwrap();
    // A score has mean 0 and variance (1 + 2 · ¼) / 4 = 3/8; the mean over 3 participants × 3 modes ×
    // 12 trials an SD of 0.059.
    let index: Vec<f64> = table.floats("index").unwrap().into_iter().flatten().collect();
    let mean = index[9..].iter().sum::<f64>() / 3.0;
    assert!(index.len() == 12 && mean.abs() < 4.0 * 0.059, "{index:?}");
    let all = ["right", "wrong", "do_not_know"].map(|name| table.integers(name).unwrap()[9]);
    assert!(all.iter().all(|count| *count > Some(0)), "{all:?}");
}
