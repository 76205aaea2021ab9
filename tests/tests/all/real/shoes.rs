//! A questionnaire: 20 participants, 4 conditions, 45 five-point items, some of them reversed.

use super::{Real, labels, recordings};
use crate::binary::zwidth;
use crate::folders::files;
use std::collections::BTreeMap;
use std::fs;
use std::sync::LazyLock;
use zwidth_tables::Table;

const ANSWERS: &str = "UXdata2023-04-28.csv";
/// Where the condition stands in a row.
const CONDITION: usize = 2;

static RUN: LazyLock<Real> = LazyLock::new(|| {
    let folder = recordings("likert_vr_shoes");
    let real = Real::new("likert_vr_shoes");
    let report = real.import("map.toml", &[folder.join(ANSWERS)]);
    assert!(report.contains("80 trials without samples, 3600 answers"), "{report}");
    real.run()
});

/// The counts of answers 1 … 5 to one item under each condition, of the answers file.
fn counted(question: &str, reversed: bool) -> BTreeMap<String, [i64; 5]> {
    let text = fs::read_to_string(recordings("likert_vr_shoes").join(ANSWERS)).unwrap();
    let mut lines = text.lines().map(|l| l.split(';').collect::<Vec<_>>());
    let column = lines.next().unwrap().iter().position(|h| *h == question).unwrap();
    let mut counts = BTreeMap::new();
    for row in lines {
        let answer: usize = row[column].parse().unwrap();
        let place = if reversed { 5 - answer } else { answer - 1 };
        counts.entry(row[CONDITION].to_owned()).or_insert([0; 5])[place] += 1;
    }
    counts
}

/// The same of the tally.
fn tallied(tally: &Table, question: &str) -> BTreeMap<String, [i64; 5]> {
    let (questions, modes) = (tally.texts("question").unwrap(), tally.texts("mode").unwrap());
    let counts = [1, 2, 3, 4, 5].map(|k| tally.integers(&format!("count_{k}")).unwrap());
    let rows = (0..tally.height()).filter(|i| questions[*i].as_deref() == Some(question));
    rows.map(|i| (modes[i].clone().unwrap(), counts.each_ref().map(|c| c[i].unwrap()))).collect()
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn twenty_participants_answer_45_items_under_4_conditions() {
    let tally = RUN.derived("likert.parquet");
    let (questions, n) = (tally.texts("question").unwrap(), tally.integers("n").unwrap());
    let of_items: Vec<i64> =
        (0..tally.height()).filter(|i| questions[*i].is_some()).filter_map(|i| n[i]).collect();
    assert_eq!((of_items.len(), of_items.iter().sum::<i64>()), (4 * 45, 3600));
    assert!(of_items.iter().all(|n| *n == 20));
    assert!(RUN.summary().contains("20 participants, 20 sessions, 80 trials that count"));
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn an_item_as_asked_and_a_reversed_one_are_those_of_an_independent_count() {
    let tally = RUN.derived("likert.parquet");
    let easy = counted("I found the interface easy to use", false);
    let complicated = counted("The interface was too complicated to use effectively", true);
    assert_eq!(tallied(&tally, "q01"), easy);
    assert_eq!(tallied(&tally, "q02"), complicated);
    // The two say the same thing, so that agreement must lie on the same side after the turn.
    let favourable = |c: &BTreeMap<String, [i64; 5]>| c.values().map(|k| k[3] + k[4]).sum::<i64>();
    assert!(favourable(&easy) > 40 && favourable(&complicated) > 40);
}

/// `-1` in the question table marks a reversed item, `-2` one of another scale.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_study_reverses_the_items_that_the_question_table_reverses() {
    let table = recordings("likert_vr_shoes").join("UXdata_questions2023-04-17.csv");
    let text = fs::read_to_string(table).unwrap();
    let rows = text.lines().skip(1).map(|l| l.split(';').map(str::trim).collect::<Vec<_>>());
    let expect: BTreeMap<String, bool> =
        rows.filter(|r| r[2] != "-2").map(|r| (r[1].to_owned(), r[2] == "-1")).collect();
    let study =
        zwidth_study::Study::from_toml(&fs::read_to_string(RUN.layout.study_toml()).unwrap())
            .unwrap();
    let found: BTreeMap<String, bool> =
        study.questions.into_iter().map(|q| (q.text, q.reversed)).collect();
    assert_eq!(found, expect);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn figures_show_bars_with_counts_and_say_what_was_turned() {
    let overview = labels(&RUN.report("figures/likert.1.svg"));
    for word in ["strongly disagree", "strongly agree", "HED", "AVG", "Ease of Use"] {
        assert!(overview.iter().any(|l| l.contains(word)), "{word} is not in {overview:?}");
    }
    assert!(overview.iter().any(|l| l.contains("6 − a")), "{overview:?}");
    // Two of groups, four of items, and four of the items compared.
    assert_eq!(files(&RUN.report("figures"), "svg").len(), 10);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_import_says_which_columns_it_dropped_and_why() {
    let list = zwidth(RUN.folder.path(), &["list", "--json"]).exits(0).json();
    assert_eq!(list[0]["sessions"].as_array().unwrap().len(), 20);
    let folder = recordings("likert_vr_shoes");
    let report = Real::new("likert_vr_shoes").import("map.toml", &[folder.join(ANSWERS)]);
    assert!(report.contains("Nausea") && report.contains("simulator sickness item"), "{report}");
    assert!(report.contains("80 rows read, 80 kept"), "{report}");
}
