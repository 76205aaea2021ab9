//! What is said of trials after they were recorded: `zwidth exclude`, `note`, `answer`, and the
//! same within a session. Events alone; no file changes.

use crate::acquire::{Desk, Live, TRIALS};
use crate::binary::{Ran, zwidth};
use crate::folders::listing;
use serde_json::Value;
use std::fs;
use zwidth_tables::Table;

/// A session of which all trials are done, each answered with 3.
fn done() -> Desk {
    let desk = Desk::new(false);
    desk.acquire(&("start\n3\n".repeat(TRIALS) + "quit\n"), &[]).exits(0);
    desk
}

/// A command on that session.
fn say(desk: &Desk, command: &str, more: &[&str]) -> Ran {
    let session = [command, "small", "-p", "P01", "-s", "S01"];
    zwidth(desk.root(), &[&session, more].concat())
}

pub(crate) fn log(desk: &Desk) -> Vec<Value> {
    let path = desk.root().join("raw/small/sessions/P01_S01.events.jsonl");
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The answers that count: trial and value.
pub(crate) fn answers(desk: &Desk) -> Vec<(i64, i64)> {
    zwidth(desk.root(), &["run", "--only", "likert"]).exits(0);
    let path = desk.root().join("derived/small/answers.parquet");
    let table = Table::from_parquet(&path).unwrap();
    let column = |name| table.integers(name).unwrap().into_iter().flatten();
    let all = column("trial").zip(column("answer")).zip(table.flags("counts").unwrap());
    all.filter(|(_, counts)| *counts == Some(true)).map(|(answer, _)| answer).collect()
}

#[test]
fn an_excluded_trial_never_counts_and_is_missing_until_it_is_done_again() {
    let desk = done();
    let files = listing(&desk.root().join("raw/small/trials"));
    let by = ["--trial", "3", "the phone rang", "--by", "E1"];
    let words =
        "trial 3 is excluded; it is missing until it is done again: `zwidth acquire small -p P01";
    say(&desk, "exclude", &by).exits(0).prints(&[words]);
    let line = log(&desk).pop().unwrap();
    assert_eq!((&line["by"], &line["what"]["reason"]), (&"E1".into(), &"the phone rang".into()));
    assert!(line["utc"].as_str().is_some_and(|utc| utc.ends_with('Z')), "{line}");
    let session = desk.session();
    assert_eq!((&session["trials_that_count"], &session["to_go"]), (&5.into(), &1.into()));
    assert_eq!(session["left_out"][0], "trial 3: excluded: the phone rang");
    assert_eq!(listing(&desk.root().join("raw/small/trials")), files, "nothing is overwritten");
    assert_eq!(answers(&desk).len(), 5);
    let all = Table::from_parquet(&desk.root().join("derived/small/answers.parquet")).unwrap();
    let trials = all.integers("trial").unwrap().into_iter().flatten();
    let why_not = all.texts("why_not").unwrap().into_iter();
    let left_out: Vec<_> = trials.zip(why_not).filter_map(|(t, why)| Some((t, why?))).collect();
    let reasons = [(1, "familiarisation"), (3, "excluded: the phone rang")];
    assert_eq!(left_out, reasons.map(|(trial, why)| (trial, why.to_owned())));
    assert_eq!(all.height(), 7, "what was given stays to be read");
    desk.verify();
    let words = ["ready 8 (place 3 of 7)", "again for trial 3", "done 7 of 7"];
    desk.acquire("start\n4\nquit\n", &[]).exits(0).prints(&words);
    let session = desk.session();
    assert_eq!((&session["trials_that_count"], &session["to_go"]), (&6.into(), &0.into()));
    assert_eq!(answers(&desk).last(), Some(&(8, 4)));
    desk.verify();
}

#[test]
fn an_answer_that_is_given_later_counts_and_the_first_one_is_kept() {
    let desk = done();
    let answer = |more: &[&str]| say(&desk, "answer", &[&["--trial", "4"], more].concat()).exits(0);
    answer(&["5"]).prints(&["answered with 5, in place of 3, which is kept"]);
    answer(&["2", "--by", "E2"]).prints(&["in place of 5"]);
    let of_four = |answers: Vec<(i64, i64)>| answers.into_iter().find(|(trial, _)| *trial == 4);
    assert_eq!(of_four(answers(&desk)), Some((4, 2)));
    let values: Vec<Value> = log(&desk)
        .into_iter()
        .filter(|line| line["what"]["event"] == "answer" && line["what"]["trial"] == 4)
        .map(|line| line["what"]["value"].clone())
        .collect();
    assert!(values.ends_with(&[5.into(), 2.into()]), "{values:?}");
    desk.verify();
}

#[test]
fn a_note_belongs_to_a_trial_or_to_the_session() {
    let desk = done();
    let note = |more: &[&str]| say(&desk, "note", more).exits(0);
    note(&["--trial", "2", "looked away"]).prints(&["kept with trial 2"]);
    note(&["left-handed"]).prints(&["kept with the session"]);
    let what: Vec<Value> =
        log(&desk).into_iter().rev().take(2).map(|l| l["what"].clone()).collect();
    assert_eq!((&what[0]["trial"], &what[0]["text"]), (&Value::Null, &"left-handed".into()));
    assert_eq!((&what[1]["trial"], &what[1]["text"]), (&2.into(), &"looked away".into()));
    desk.verify();
}

#[test]
fn what_cannot_be_said_is_refused_with_the_reason_and_nothing_is_written() {
    let desk = Desk::new(false);
    desk.acquire("start\n3\nstart\n3\nquit\n", &[]).exits(3);
    let before = listing(&desk.root().join("raw"));
    for (command, more, words) in [
        ("exclude", &["--trial", "2", " "][..], "an exclusion needs its reason"),
        ("exclude", &["--trial", "5", "x"], "trial 5 is still to be done"),
        ("exclude", &["--trial", "99", "x"], "no trial 99: they are 1 to 7"),
        ("note", &["--trial", "99", "x"], "no trial 99"),
        ("note", &[""], "the note is empty"),
        ("answer", &["--trial", "5", "3"], "trial 5 is still to be done"),
        ("answer", &["--trial", "2", "6"], "6 is no answer to felt_"),
        ("answer", &["--trial", "2", "-1"], "-1 is no answer to felt_"),
        ("answer", &["--trial", "2", "3", "--question", "mood"], "mood is not asked after trial 2"),
    ] {
        say(&desk, command, more).exits(1).one_error().says(&[words]);
    }
    let other = ["note", "small", "-p", "P09", "-s", "S01", "x"];
    zwidth(desk.root(), &other).exits(1).says(&["no session S01 of P09", "zwidth list small"]);
    assert_eq!(listing(&desk.root().join("raw")), before);
}

#[test]
fn while_a_session_runs_it_is_said_there() {
    let desk = Desk::slow();
    let mut live = Live::new(&desk, &[]);
    live.until("check");
    say(&desk, "note", &["x"]).exits(1).one_error().says(&["in use: zwidth acquire, process "]);
    live.say("quit");
    live.child.wait().unwrap();
}

#[test]
fn in_a_session_any_trial_is_excluded_asked_again_remarked_on_and_done_again() {
    let desk = Desk::new(false);
    let lines = "start\n3\n".repeat(4)
        + "trial 2 exclude the phone rang\ntrial 3 ask\n5\ntrial 2 note twice\ntrial 4 repeat\n"
        + &"start\n4\n".repeat(5)
        + "quit\n";
    desk.acquire(&lines, &["--by", "E1"]).exits(0).prints(&[
        "trial 2 excluded: the phone rang",
        "trial 2 is missing now",
        "trial 3: answered 5",
        "trial 2: note: twice",
        "ready 8 (place 4 of 7)",
        "ready 9 (place 2 of 7)",
        "again for trial 2",
        "done 7 of 7",
    ]);
    desk.verify();
    assert_eq!((desk.trials(), desk.session()["trials_that_count"].clone()), (9, 6.into()));
    let said = log(&desk).into_iter().filter(|line| line["what"]["event"] == "excluded");
    assert!(said.into_iter().all(|line| line["by"] == "E1"));
    assert_eq!(answers(&desk).iter().find(|(trial, _)| *trial == 3), Some(&(3, 5)));
}

/// The session, with a table of answers beside it.
fn with_table(rows: &[&str]) -> (Desk, String) {
    let desk = done();
    let path = desk.root().join("ratings.csv");
    fs::write(&path, rows.join("\n") + "\n").unwrap();
    (desk, path.to_str().unwrap().to_owned())
}

#[test]
fn a_table_of_answers_is_given_whole_and_only_once() {
    let rows = ["participant,session,trial,answer", "P01,S01,2,5", "P01,S01,3,3", "P01,S01,4,1"];
    let (desk, table) = with_table(&rows);
    let before = answers(&desk);
    let give = |more: &[&str]| {
        zwidth(desk.root(), &[&["answer", "small", "--from", &table], more].concat()).exits(0).out
    };
    let told = "2 answers in 1 session would be given; 2 in place of others, which are kept; 1 there already";
    assert!(give(&["--dry-run"]).contains(told));
    assert_eq!(answers(&desk), before, "a dry run gives nothing");
    assert!(give(&["--by", "E2"]).contains("2 answers in 1 session are given; 2 in place"));
    assert_eq!(log(&desk).pop().unwrap()["by"], "E2");
    let value = |trial| answers(&desk).iter().find(|(t, _)| *t == trial).unwrap().1;
    assert_eq!((value(2), value(3), value(4)), (5, 3, 1));
    let lines = log(&desk).len();
    assert!(give(&[]).contains("0 answers in 0 sessions are given; 3 there already"));
    assert_eq!(log(&desk).len(), lines);
    desk.verify();
}

#[test]
fn a_table_with_a_wrong_line_gives_nothing_and_tells_each_such_line() {
    let rows = [
        "participant,session,trial,answer",
        "P01,S01,2,5",
        "P01,S01,2,4",
        "P09,S01,2,4",
        "P01,S01,99,4",
        "P01,S01,3,9",
    ];
    let (desk, table) = with_table(&rows);
    let lines = log(&desk).len();
    zwidth(desk.root(), &["answer", "small", "--from", &table]).exits(1).says(&[
        "trial 2 has an answer to felt_",
        "in line 2 too (line 3)",
        "there is no session S01 of P09",
        "the session has no trial 99: they are 1 to 7 (line 5)",
        "9 is no answer to felt_",
        "nothing was written",
    ]);
    assert_eq!(log(&desk).len(), lines);
}

#[test]
fn a_table_names_trials_by_condition_and_repeat_as_well() {
    let desk = done();
    let trial = planned(&desk, 5);
    let table = desk.root().join("ratings.csv");
    let row = format!("P01,{},{},{},5", trial.environment, trial.mode, trial.repeat);
    fs::write(&table, format!("participant,environment,mode,repeat,answer\n{row}\n")).unwrap();
    let give = ["answer", "small", "--from", table.to_str().unwrap()];
    let words = "no column 'session': add it, or name one with -s";
    zwidth(desk.root(), &give).exits(1).says(&[words]);
    zwidth(desk.root(), &[&give[..], &["-s", "S01"]].concat()).exits(0);
    assert!(answers(&desk).contains(&(5, 5)));
}

/// A trial of the session as it was planned.
fn planned(desk: &Desk, trial: u32) -> zwidth_study::PlannedTrial {
    let layout = zwidth_store::Layout::new(desk.root(), "small".parse().unwrap());
    let data = zwidth_store::StudyData::load(&layout).unwrap();
    data.sessions[0].trials.iter().find(|t| t.trial == trial).unwrap().clone()
}

/// Answers by a table of one row, which says of which session it is.
fn give(desk: &Desk, row: &str, more: &[&str]) -> Ran {
    let head = "participant,session,trial,environment,mode,repeat,answer";
    let table = desk.root().join("ratings.csv");
    fs::write(&table, format!("{head}\nP01,S01,{row}\n")).unwrap();
    let give = ["answer", "small", "--from", table.to_str().unwrap()];
    zwidth(desk.root(), &[&give, more].concat())
}

#[test]
fn a_row_that_names_a_trial_and_another_condition_or_repeat_is_refused_with_what_the_trial_is() {
    let desk = done();
    let trial = planned(&desk, 5);
    let (environment, mode, repeat) = (&trial.environment, &trial.mode, trial.repeat);
    let other_mode = if mode.as_str() == "active" { "passive" } else { "active" };
    let other_environment = if environment.as_str() == "spring" { "spring_wall" } else { "spring" };
    let give = |row: &str| give(&desk, row, &[]);
    let is = format!("but trial 5 is of {environment}, {mode}, repeat {repeat} (line 2)");
    for (row, says) in [
        (format!("5,{environment},{other_mode},{repeat},4"), format!("mode {other_mode}")),
        (format!("5,{other_environment},,,4"), format!("environment {other_environment}")),
        (
            format!("5,,{other_mode},{},4", repeat + 1),
            format!("mode {other_mode}, repeat {}", repeat + 1),
        ),
    ] {
        give(&row).exits(1).says(&[&format!("row 1: the table says {says}, {is}")]);
        assert!(!answers(&desk).contains(&(5, 4)));
    }
    // The label is as good as the id, and an empty cell says nothing.
    give(&format!("5,{},,{repeat},4", environment.as_str().to_uppercase())).exits(0);
    assert!(answers(&desk).contains(&(5, 4)));
    desk.verify();
}

#[test]
fn of_a_sealed_session_a_table_is_told_the_same_whatever_it_says_of_modes_and_repeats() {
    let desk = Desk::new(true);
    desk.acquire(&("start\n3\n".repeat(TRIALS) + "quit\n"), &[]).exits(0);
    let environment = planned(&desk, 5).environment;
    let give = |row: &str| give(&desk, &format!("5,{row},4"), &["--dry-run"]);
    let said = ["active,1", "passive,1", "hybrid,1", "hybrid,7"]
        .map(|rest| give(&format!("{environment},{rest}")).exits(0).out);
    assert!(said.iter().all(|text| *text == said[0]), "{said:?}");
    let words = "1 row of sealed sessions, whose modes and repeats cannot be checked before `zwidth unseal`";
    assert!(said[0].contains(words), "{said:?}");
    let other = if environment.as_str() == "spring" { "spring_wall" } else { "spring" };
    let expect =
        format!("the table says environment {other}, but trial 5 is of {environment} (line 2)");
    give(&format!("{other},active,1")).exits(1).says(&[&expect]);
}

#[test]
fn a_table_that_is_wrong_in_every_row_is_told_by_its_first_twenty_and_a_number() {
    let rows: Vec<String> = std::iter::once("participant,session,trial,answer".to_owned())
        .chain((0..30_000).map(|i| format!("P01,S01,{},4", 1000 + i)))
        .collect();
    let (desk, table) = with_table(&rows.iter().map(String::as_str).collect::<Vec<_>>());
    let ran = zwidth(desk.root(), &["answer", "small", "--from", &table]).exits(1);
    assert_eq!(ran.err.lines().count(), 21, "{}", &ran.err[..2000]);
    assert!(ran.err.contains("the session has no trial 1000: they are 1 to 7 (line 2)"));
    assert_eq!(ran.err.lines().last().map(str::trim), Some("and 29,980 more"));
}
