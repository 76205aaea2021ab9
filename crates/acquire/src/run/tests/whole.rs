//! A session that is no longer whole: nothing more is recorded in it.

use super::*;
use std::collections::BTreeMap;
use std::fs;
use zwidth_store::read_events;

/// Everything below a folder, by content.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path))
        } else {
            drop(found.insert(path.clone(), fs::read(&path).unwrap()))
        }
    }
    found
}

/// A desk at which two trials of a session were recorded.
fn begun() -> Desk {
    let desk = Desk::new(false);
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(2)).unwrap();
    desk
}

/// The files of the session at a desk.
struct Of {
    record: PathBuf,
    log: PathBuf,
    head: PathBuf,
    copy: PathBuf,
    trials: [PathBuf; 2],
}

fn of(desk: &Desk) -> Of {
    let Plan { layout, participant, session, .. } = &desk.plan;
    let log = layout.events(participant, session);
    Of {
        record: layout.session(participant, session),
        head: log.with_extension("head"),
        log,
        copy: layout.study_copy(participant, session),
        trials: [1, 2].map(|n| layout.trial(participant, session, n)),
    }
}

fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

fn remove(path: &Path) {
    fs::remove_file(path).unwrap();
}

type Damage = (&'static str, fn(&Of), &'static str);

const DAMAGES: [Damage; 13] = [
    ("record deleted", |of| remove(&of.record), "record is missing, and its log is there"),
    (
        "record and log deleted",
        |of| [&of.record, &of.log, &of.head].into_iter().for_each(|path| remove(path)),
        "record is missing, and trials of it are there",
    ),
    (
        "record edited",
        |of| edit(&of.record, "test 1", "test 2"),
        "not the one that the session began with",
    ),
    ("record cut", |of| fs::write(&of.record, "{").unwrap(), "not a session record"),
    ("log deleted", |of| remove(&of.log), "the log has 0 lines where its head counts"),
    (
        "log and head deleted",
        |of| [&of.log, &of.head].into_iter().for_each(|path| remove(path)),
        "the log does not mention trials 1, 2",
    ),
    ("log edited", |of| edit(&of.log, "\"trial\":1", "\"trial\":3"), "the checksum does not match"),
    ("copy of study.toml deleted", |of| remove(&of.copy), "so copy it to this name"),
    (
        "copy of study.toml edited",
        |of| edit(&of.copy, "pause_s = 5", "pause_s = 6"),
        "not the study.toml that",
    ),
    ("trial deleted", |of| remove(&of.trials[0]), "its file is missing"),
    (
        "folder in a trial's place",
        |of| {
            remove(&of.trials[1]);
            fs::create_dir(&of.trials[1]).unwrap();
        },
        "its file is missing",
    ),
    ("trial cut", |of| fs::write(&of.trials[1], "PAR1").unwrap(), "trial-002.parquet"),
    (
        "trial put in another's place",
        |of| {
            fs::copy(&of.trials[0], &of.trials[1]).unwrap();
        },
        "trial-002.parquet: the file is trial 1",
    ),
];

#[test]
fn a_session_of_which_anything_is_gone_or_changed_is_refused_at_the_start_and_nothing_is_written() {
    for (name, damage, words) in DAMAGES {
        let desk = begun();
        damage(&of(&desk));
        recover(&RealFiles, &desk.plan.layout, UTC); // as the command does first
        let before = contents(desk.root());
        let mut mock = Mock::default();
        let error = desk.run(&mut mock, &RealFiles, &mut diligent()).unwrap_err();
        assert!(matches!(&error, AcquireError::NotWhole { .. }), "{name}: {error}");
        let told = error.to_string();
        assert!(
            told.contains("session P01 S01 is incomplete or damaged") && told.contains(words),
            "{name}: {told}"
        );
        assert_eq!(contents(desk.root()), before, "{name}");
        assert_eq!(mock.writes, [], "{name}: the device was driven");
    }
}

#[test]
fn a_session_that_is_damaged_in_a_pause_ends_before_its_next_trial() {
    for (name, damage, words) in DAMAGES {
        // What only a look into a trial's file finds waits for the next start.
        if name.starts_with("trial cut") || name.starts_with("trial put") {
            continue;
        }
        let desk = Desk::new(false);
        let files = of(&desk);
        let mut done = false;
        let mut front = somebody(|view: &View| {
            if view.done == 2 && view.phase == Shown::Ready && !std::mem::replace(&mut done, true) {
                damage(&files);
            }
            None
        });
        let mut mock = Mock::default();
        let told = desk.run(&mut mock, &RealFiles, &mut front).unwrap_err().to_string();
        let words = match name {
            "record deleted" => "P01_S01.json: cannot read",
            "record and log deleted" | "log and head deleted" => "the session's log is missing",
            "record cut" => "not the one that the session began with",
            _ => words,
        };
        assert!(
            told.contains("session P01 S01 is incomplete or damaged") && told.contains(words),
            "{name}: {told}"
        );
        assert_eq!(mock.writes.last().map(|(_, v)| *v), Some(Voltages::OFF), "{name}");
        let trials = files.trials[1].with_file_name("trial-003.parquet");
        assert!(
            !trials.exists() && fs::read_dir(desk.plan.layout.journals()).unwrap().count() == 0,
            "{name}"
        );
    }
}

/// The study's text with something changed, now the one at the desk; the plan as a command makes
/// it.
fn changed(desk: &mut Desk, from: &str, to: &str) {
    let path = desk.plan.layout.study_toml();
    edit(&path, from, to);
    desk.plan.study_toml = fs::read(&path).unwrap();
    let Plan { layout, participant, session, .. } = &desk.plan;
    desk.plan.study = crate::own_study(&RealFiles, layout, participant, session).unwrap().unwrap();
}

fn notes(desk: &Desk) -> Vec<String> {
    let events = read_events(&of(desk).log).unwrap();
    let note = |event| if let Event::Note { text, .. } = event { Some(text) } else { None };
    events.into_iter().filter_map(note).filter(|text| text.contains("study.toml")).collect()
}

#[test]
fn a_comment_a_label_or_a_figure_in_study_toml_ends_no_session_and_is_noted_once() {
    for (from, to, words) in [
        ("# Practice trials", "# Trials to practise", "comments or form alone"),
        (
            "label = \"Active\"",
            "label = \"Motor\"",
            "nothing that is recorded: modes.active.label was \"Active\"",
        ),
        ("# [figures]\n# alignment", "[figures]\nalignment", "figures.alignment was"),
    ] {
        let mut desk = begun();
        let drawn = desk.data().sessions[0].record.trials.clone();
        changed(&mut desk, from, to);
        desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(3)).unwrap();
        let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
        assert_eq!((outcome.done, verify(&desk.plan.layout)), (TRIALS, vec![]), "{from}");
        let [note] = notes(&desk).try_into().unwrap();
        assert!(note.contains(words), "{note}");
        assert_eq!(desk.data().sessions[0].record.trials, drawn);
    }
}

#[test]
fn a_change_of_what_is_recorded_is_refused_until_it_is_accepted_and_the_session_goes_on_by_its_own_copy()
 {
    let mut desk = begun();
    let drawn = desk.data().sessions[0].record.trials.clone();
    changed(&mut desk, "trial_limit_s = 4.0", "trial_limit_s = 1.5");
    let before = contents(desk.root());
    let mut mock = Mock::default();
    let error = desk.run(&mut mock, &RealFiles, &mut diligent()).unwrap_err().to_string();
    for words in ["design.trial_limit_s was 4.0 and is 1.5", "put it back", "--accept-study-change"]
    {
        assert!(error.contains(words), "{error}");
    }
    assert_eq!((contents(desk.root()), mock.writes), (before, vec![]));
    desk.plan.accept_study_change = true;
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(3)).unwrap();
    let hash = zwidth_store::hex_blake3(&desk.plan.study_toml);
    let events = read_events(&of(&desk).log).unwrap();
    assert!(events.contains(&Event::StudyAccepted { study_blake3: hash }), "{events:?}");
    assert!(
        notes(&desk)[0].contains("goes on by its own copy: design.trial_limit_s was 4.0"),
        "{:?}",
        notes(&desk)
    );
    // Once it is accepted nobody is asked again.
    desk.plan.accept_study_change = false;
    assert_eq!(desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap().done, TRIALS);
    let data = desk.data();
    assert_eq!((&data.sessions[0].record.trials, notes(&desk).len()), (&drawn, 1));
    let lasts = data.trials.iter().map(|t| {
        let read = t.read([zwidth_store::Signal::Time]).unwrap();
        *read.samples.get(zwidth_store::Signal::Time).unwrap().last().unwrap()
    });
    assert!(
        lasts.clone().all(|last_s| last_s > 2.4),
        "as long as the copy says: {:?}",
        lasts.collect::<Vec<_>>()
    );
}

#[test]
fn a_session_from_before_there_were_copies_goes_on_under_its_very_study_toml_alone() {
    let mut desk = begun();
    // As it was laid down then: no copy, and no first line of the log.
    let Of { copy, log, head, .. } = of(&desk);
    let events = read_events(&log).unwrap();
    [&copy, &log, &head].into_iter().for_each(|path| remove(path));
    append_events(&RealFiles, &log, UTC, &events[1..]).unwrap();
    let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(3)).unwrap();
    assert_eq!(outcome.done, 3);
    edit(&desk.plan.layout.study_toml(), "# Practice trials", "# Trials");
    desk.plan.study_toml = fs::read(desk.plan.layout.study_toml()).unwrap();
    desk.plan.accept_study_change = true;
    let error = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap_err().to_string();
    assert!(
        error.contains("what changed is not known") && error.contains("put study.toml back"),
        "{error}"
    );
}

#[test]
fn ids_whose_files_would_have_the_same_names_are_told_apart() {
    let mut desk = Desk::new(false);
    (desk.plan.participant, desk.plan.session) = ("a_b".parse().unwrap(), "c1".parse().unwrap());
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(1)).unwrap();
    (desk.plan.participant, desk.plan.session) = ("a".parse().unwrap(), "b_c1".parse().unwrap());
    let error = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap_err().to_string();
    assert!(
        error.contains("record of session c1 of a_b") && error.contains("choose other ids"),
        "{error}"
    );
}
