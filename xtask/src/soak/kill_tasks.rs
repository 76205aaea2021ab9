//! `kill -9` at random instants of a session whose levels follow from its answers: staircases, QUEST+ and constant stimuli.
//! However often it is killed, it presents the levels of a session that nobody killed, and no answer is lost or counted
//! twice.

use super::kill::killed;
use super::{SESSION, STUDY, fraction, fresh, run};
use crate::shell::{program, scratch, words};
use crate::tried::held;
use anyhow::{Context as _, ensure};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Event, TaskLevel};

/// A study of tasks alone: the spring is theirs, and the spring with a wall is recorded once in each mode.
const SHORT: [(&str, &str); 5] = [
    ("\nschema = 2\n", "\nschema = 3\n"),
    ("\nrepeats = 6\n", "\nrepeats = 1\n"),
    ("\nfamiliarisation = 3\n", "\nfamiliarisation = 0\n"),
    ("\nrate_hz = 1000.0\n", "\nrate_hz = 120.0\n"),
    ("\nquestion = \"felt_spring\"\n", "\n"),
];

/// Its tasks.
const TASKS: &str = r#"
[[tasks]]
id = "stiffer"
text = "Which one was stiffer?"
asks = "2ifc"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "constant"
levels = [3.2, 4.0, 4.8]
trials = 1

[[tasks]]
id = "steps"
text = "Which one was stiffer?"
asks = "2ifc"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "staircase"
rule = "1up1down"
start = 4.8
up = 0.2
down = 0.2
lowest = 2.0
highest = 8.0
reversals = 4
of_last = 2
most_trials = 12
interleaved = 2

[[tasks]]
id = "grid"
text = "Was it stiffer or softer than usual?"
asks = "more_less"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "quest_plus"
levels = [2.8, 3.2, 3.6, 4.0, 4.4, 4.8, 5.2]
trials = 6
pse = [3.0, 5.0, 0.25]
sigma = [0.2, 1.4, 0.2]
lapse = [0.02, 0.04, 0.02]
"#;

/// A session is killed so often before it goes on to its end.
const LIVES: u32 = 3;
/// How often it tells how far it is.
const TOLD_EVERY: u32 = 10;

/// By task, mode, track and presentation: the level, and whether the answer was positive.
type Course = BTreeMap<(String, String, u8, u32), (TaskLevel, bool)>;

pub(crate) fn kill_tasks(kills: u32, seed: u64) -> anyhow::Result<()> {
    let program = &program()?;
    let folder = scratch("kill-tasks");
    let reference = folder.join("reference");
    let whole = study(&reference)?;
    let started = Instant::now();
    run(program, &reference, &words(&line(seed)), &[0])?;
    let length = started.elapsed();
    let expect = course(&whole)?;
    ensure!(expect.len() > 40, "the session that nobody killed has {} answers", expect.len());
    let began = Instant::now();
    let mut number = 0;
    let mut within = 0;
    while number < kills {
        let root = folder.join("killed");
        let layout = study(&root)?;
        for _ in 0..LIVES.min(kills - number) {
            number += 1;
            let after = length.mul_f64(fraction(&format!("kill {seed} {number}"))?);
            let (lines, _) = killed(program, &root, &line(seed), after)?;
            within += u32::from(!lines.iter().any(|line| line.starts_with("left ")));
            run(program, &root, &["recover", STUDY], &[0])?;
            run(program, &root, &["verify", STUDY], &[0])?;
            // A session that was killed early is not there yet.
            if layout.session(&"P01".parse()?, &"S01".parse()?).exists() {
                expect_beginning(&layout, &expect)
                    .with_context(|| format!("kill {number} of seed {seed}"))?;
            }
            if number % TOLD_EVERY == 0 {
                println!("{number} of {kills} kills");
            }
        }
        run(program, &root, &words(&line(seed)), &[0])?;
        run(program, &root, &["verify", STUDY], &[0])?;
        let found =
            course(&layout).with_context(|| format!("after kill {number} of seed {seed}"))?;
        ensure!(
            found == expect,
            "after kill {number} of seed {seed} the session presented {found:?} instead of {expect:?}; see {}",
            root.display()
        );
    }
    println!(
        "{kills} kills, {within} of them before the session was over; every level and answer was that of a session without"
    );
    let what = "`kill -9` of the program at random instants of a session with tasks: levels and answers are those of a session without";
    held(what, format!("cargo xtask soak kill-tasks {kills}"), kills.into(), began)
}

fn study(root: &Path) -> anyhow::Result<Layout> {
    let layout = fresh(root, &SHORT)?;
    let path = layout.study_toml();
    let text = std::fs::read_to_string(&path)? + TASKS;
    std::fs::write(&path, text)?;
    Ok(layout)
}

/// The command of a session that runs by itself.
fn line(seed: u64) -> String {
    format!("acquire {STUDY} {SESSION} --plain --auto --seed {seed} --fast")
}

/// What was answered, and counts.
fn course(layout: &Layout) -> anyhow::Result<Course> {
    let data = StudyData::load(layout).map_err(|errors| anyhow::anyhow!("{errors:?}"))?;
    ensure!(data.problems.is_empty(), "the study has problems: {:?}", data.problems);
    let mut found = Course::new();
    for answer in data.task_answers() {
        let mode = answer.condition.mode.to_string();
        let key = (answer.task.to_string(), mode, answer.track, answer.presentation);
        let is_new = found.insert(key.clone(), (answer.level, answer.is_positive)).is_none();
        ensure!(is_new, "{key:?} was answered twice");
    }
    // Each answer is one event, whatever came of its trial.
    for log in &data.sessions {
        let mut answered = std::collections::BTreeSet::new();
        for event in &log.events {
            if let Event::Answer { trial, question, .. } = event {
                let is_new = answered.insert((*trial, question.clone()));
                ensure!(is_new, "trial {trial} has two answers to {question}");
            }
        }
    }
    Ok(found)
}

/// What is there so far is as in the session that nobody killed.
fn expect_beginning(layout: &Layout, expect: &Course) -> anyhow::Result<()> {
    for (key, found) in course(layout)? {
        ensure!(
            expect.get(&key) == Some(&found),
            "{key:?} is {found:?}, not {:?}",
            expect.get(&key)
        );
    }
    Ok(())
}
