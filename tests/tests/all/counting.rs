//! Neither familiarisation nor superseded, excluded or incomplete trials enter a mean, a table or a
//! tally.
//!
//! Every trial that must not count pushes with an absurd force and answers 1 where the others
//! answer 5.

use crate::binary::zwidth;
use crate::folders::files;
use crate::small::{Draft, Study, draft};
use std::sync::LazyLock;
use zwidth_study::{Event, Kind, Status};
use zwidth_tables::{Table, Type};

/// The force of trials that must not count, N.
const ABSURD_N: f64 = 1000.0;
/// No value of a trial that counts, in any unit a figure or a table uses, comes near this.
const SANE: f64 = 0.9 * ABSURD_N;
/// The environments with trials, and the mode of each.
const CONDITIONS: [(&str, &str); 2] = [("spring", "hybrid"), ("free", "active")];

/// Every combination of what can keep a trial from counting; the first has nothing of it.
fn combinations() -> Vec<(Kind, Status, bool, bool)> {
    let mut all = Vec::new();
    for kind in [Kind::Trial, Kind::Familiarisation] {
        for status in [Status::Complete, Status::Incomplete] {
            for superseded in [false, true] {
                all.extend([false, true].map(|excluded| (kind, status, superseded, excluded)));
            }
        }
    }
    all
}

/// A trial of one combination. What it answers comes as an event, which overrides the answer in its
/// file.
fn combined(
    trial: u32,
    (environment, mode): (&'static str, &'static str),
    combination: (Kind, Status, bool, bool),
) -> Draft {
    let (kind, status, superseded, excluded) = combination;
    let counts = combination == (Kind::Trial, Status::Complete, false, false);
    let question = "felt_spring".parse().unwrap();
    let value = if counts { 5 } else { 1 }.into();
    let mut events = vec![Event::Answer { trial, question, value, time_ms: None }];
    if superseded {
        events.push(Event::Superseded { trial, by: 1 });
    }
    if excluded {
        events.push(Event::Excluded { trial, reason: "the phone rang".to_owned() });
    }
    let force_n = (!counts).then_some(ABSURD_N);
    Draft { kind, status, likert: Some(1), force_n, events, ..draft(trial, environment, mode) }
}

/// In each condition three trials that count, and one of every combination that does not. A second
/// participant only answered.
fn study() -> (Study, Vec<i64>) {
    let study = Study::new("counting");
    let nothing = combinations()[0];
    let (mut drafts, mut count) = (Vec::new(), Vec::new());
    for condition in CONDITIONS {
        for combination in combinations().into_iter().chain([nothing, nothing]) {
            let trial = drafts.len() as u32 + 1;
            drafts.push(combined(trial, condition, combination));
            if combination == nothing {
                count.push(i64::from(trial));
            }
        }
    }
    study.session("P01", &drafts);
    let asked = combinations().into_iter().filter(|c| c.1 == Status::Complete);
    let asked = asked.enumerate().map(|(i, c)| combined(i as u32 + 1, ("spring", "active"), c));
    study.session("P02", &asked.map(|d| Draft { samples: false, ..d }).collect::<Vec<_>>());
    (study, count)
}

/// The study after a run, and the numbers of the trials that count; the free ones come last.
static RUN: LazyLock<(Study, Vec<i64>)> = LazyLock::new(|| {
    let (study, count) = study();
    zwidth(study.root(), &["run"]).exits(0);
    (study, count)
});

fn derived(name: &str) -> Table {
    RUN.0.derived(name)
}

fn numbers(table: &Table, column: &str) -> Vec<i64> {
    table.integers(column).unwrap().into_iter().flatten().collect()
}

#[test]
fn the_metric_table_holds_the_trials_that_count_and_no_other() {
    let mut found = numbers(&derived("metrics"), "trial");
    found.sort_unstable();
    assert_eq!(found, RUN.1);
    assert_eq!(numbers(&derived("conditions"), "n"), [3, 3]);
}

#[test]
fn the_mean_takes_in_the_trials_that_count_and_no_other() {
    let average = derived("average/P01.S01.spring.hybrid");
    assert_eq!(numbers(&average, "n").into_iter().max(), Some(3));
}

#[test]
fn the_plane_fits_are_those_of_the_trials_that_count() {
    assert_eq!(numbers(&derived("free_motion"), "trial"), RUN.1[3..]);
}

#[test]
fn the_tally_counts_the_answers_that_count_with_samples_or_without() {
    let tally = derived("likert");
    let (environments, modes) = (tally.texts("environment").unwrap(), tally.texts("mode").unwrap());
    let rows: Vec<_> =
        environments.into_iter().flatten().zip(modes.into_iter().flatten()).collect();
    let condition = |e: &str, m: &str| (e.to_owned(), m.to_owned());
    assert_eq!(
        rows,
        [condition("spring", "active"), condition("spring", "hybrid"), condition("free", "active")]
    );
    assert_eq!(numbers(&tally, "n"), [1, 3, 3]);
    assert_eq!(numbers(&tally, "count_5"), [1, 3, 3]);
    assert_eq!(numbers(&tally, "count_1"), [0, 0, 0]);
}

#[test]
fn no_absurd_force_is_in_any_derived_file_table_or_figure() {
    let layout = RUN.0.layout();
    let mut files: Vec<_> = files(&layout.derived(), "parquet");
    files.extend(crate::folders::files(&layout.reports(), "parquet"));
    // The trade of solvers has no recording in it, and swings a thousand times what can be felt;
    // the device's parts have rates and masses of the plan.
    let is_of_trials = |path: &std::path::PathBuf| {
        path.file_stem().is_none_or(|stem| stem != "trade" && stem != "components")
    };
    files.retain(is_of_trials);
    assert!(files.len() > 10, "{files:?}");
    for path in files {
        let table = Table::from_parquet(&path).unwrap();
        for field in table.fields().filter(|f| f.kind == Type::Float) {
            let values = table.floats(&field.name).unwrap();
            let absurd = values.into_iter().flatten().find(|v| v.abs() > SANE);
            assert_eq!(absurd, None, "{} of {}", field.name, path.display());
        }
    }
}

#[test]
fn the_summary_and_the_listing_count_alike_and_say_why_each_other_trial_is_left_out() {
    let summary = RUN.0.summary();
    for words in [
        "2 participants, 2 sessions, 7 trials that count",
        "P01 S01 trial 2: excluded: the phone rang",
        "P01 S01 trial 3: superseded by trial 1",
        "P01 S01 trial 5: incomplete",
    ] {
        assert!(summary.contains(words), "'{words}' is not in {summary}");
    }
    let list = zwidth(RUN.0.root(), &["list", "--json"]).exits(0).json();
    let session = &list[0]["sessions"][0];
    assert_eq!(
        (session["trials_that_count"].as_u64(), session["familiarisation"].as_u64()),
        (Some(6), Some(16))
    );
    assert_eq!(session["left_out"].as_array().unwrap().len(), 14);
}
