//! The tally against a questionnaire collected by others.

use crate::tests::answer;
use crate::{Scheme, tally, tally_table};
use std::path::PathBuf;
use zwidth_store::Answer;
use zwidth_study::{
    AnswerScale, AnswerValue, Mode, ModeId, Question, QuestionId, Scene, Study, StudyId,
};
use zwidth_tables::Table;

/// Columns before the first question: time, participant, condition, order.
const BEFORE: usize = 4;
/// Column of the participant, and of the condition.
const PARTICIPANT: usize = 1;
const CONDITION: usize = 2;
/// Marks a question that is not on the five-point scale.
const OTHER_SCALE: &str = "-2";

fn rows(path: PathBuf) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| line.split(';').map(|v| v.trim().to_owned()).collect();
    text.lines().skip(1).map(row).collect()
}

/// The questions on the five-point scale with their column; `-1` marks a reversed one.
fn questions(rows: &[Vec<String>]) -> Vec<(usize, Question)> {
    let question = |(i, row): (usize, &Vec<String>)| {
        let id = QuestionId::new(format!("q{i}")).unwrap();
        let group = Some(row[0].clone());
        let text = row[1].clone();
        let reversed = row[2] == "-1";
        let scale = AnswerScale::FivePoint;
        (row[2] != OTHER_SCALE).then_some((
            BEFORE + i,
            Question { id, text, group, scale, reversed, label: None, is_weight: false },
        ))
    };
    rows.iter().enumerate().filter_map(question).collect()
}

fn scheme(questions: &[(usize, Question)]) -> Scheme {
    let mut study =
        Study::from_toml(&zwidth_study::template(&StudyId::new("shoes").unwrap())).unwrap();
    study.modes = ["HED", "HIP", "STF", "AVG"]
        .map(|id| Mode {
            id: ModeId::new(id).unwrap(),
            label: id.to_owned(),
            motor_max_v: None,
            brake_max_v: None,
            law: None,
            factors: zwidth_study::Levels::new(),
        })
        .to_vec();
    study.environments.truncate(1);
    study.environments[0].scene = Scene::None;
    study.questions = questions.iter().map(|(_, q)| q.clone()).collect();
    Scheme::of(&study)
}

/// The counts 1 … 5 of the pooled row of `group`, for each mode.
fn pooled(table: &Table, group: &str) -> Vec<[i64; 5]> {
    let flags = table.flags("pooled").unwrap();
    let groups = table.texts("group").unwrap();
    let counts =
        ["count_1", "count_2", "count_3", "count_4", "count_5"].map(|c| table.integers(c).unwrap());
    let rows = (0..table.height())
        .filter(|&i| flags[i] == Some(true) && groups[i].as_deref() == Some(group));
    rows.map(|i| counts.each_ref().map(|c| c[i].unwrap())).collect()
}

/// Python, from the two files: `Counter(6 - a if inverted == "-1" else a)` over the group's
/// columns, by condition.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn pooled_counts_with_reversed_items_are_those_of_an_independent_count() {
    let root = PathBuf::from(
        std::env::var_os("ZWIDTH_REAL_DATA").expect("ZWIDTH_REAL_DATA names a folder"),
    );
    let folder = root.join("likert_vr_shoes");
    let questions = questions(&rows(folder.join("UXdata_questions2023-04-17.csv")));
    let people = rows(folder.join("UXdata2023-04-28.csv"));
    let of = |row: &Vec<String>| {
        let given = |i: usize| row[i].parse::<AnswerValue>().unwrap();
        let (who, mode) = (&row[PARTICIPANT], &row[CONDITION]);
        let all = questions.iter().map(|(i, q)| answer(who, mode, q.id.as_str(), given(*i)));
        all.collect::<Vec<_>>()
    };
    let answers: Vec<Answer> = people.iter().flat_map(of).collect();
    assert_eq!((questions.len(), answers.len()), (45, 3600));
    let scheme = scheme(&questions);
    let table = tally_table(&tally(&answers, &scheme).unwrap(), &scheme).unwrap();
    let ease =
        [[12, 26, 24, 44, 34], [2, 24, 18, 47, 49], [2, 17, 24, 59, 38], [6, 18, 24, 43, 49]];
    let presence =
        [[2, 12, 13, 32, 21], [4, 9, 11, 25, 31], [2, 10, 10, 30, 28], [2, 8, 9, 28, 33]];
    assert_eq!(pooled(&table, "Ease of Use"), ease);
    assert_eq!(pooled(&table, "Presence"), presence);
    assert!(table.integers("participants").unwrap().iter().all(|n| *n == Some(20)));
}
