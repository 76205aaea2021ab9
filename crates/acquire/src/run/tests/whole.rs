//! A session that is no longer whole: nothing more is recorded in it.

use super::*;
use std::collections::BTreeMap;
use std::fs;
use zwidth_store::read_events;
use zwidth_study::{PeopleForm, PersonColumnId, PersonValue};

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

/// What notes of changes, and of what chance gave, have in them.
const OF_CHANGES: [&str; 3] = ["study.toml", "participants' file", "was drawn"];

fn notes(desk: &Desk) -> Vec<String> {
    let events = read_events(&of(desk).log).unwrap();
    let note = |event| if let Event::Note { text, .. } = event { Some(text) } else { None };
    events
        .into_iter()
        .filter_map(note)
        .filter(|text| OF_CHANGES.iter().any(|words| text.contains(words)))
        .collect()
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

/// A desk of a study that has two columns of people, of which chance chooses the one; the participants' file tells the
/// other of P01.
fn with_people() -> Desk {
    let mut desk = Desk::new(false);
    let columns = "\n[[people]]\nid = \"crew\"\nlevels = [\"novice\", \"expert\"]\nassigned = true\n\
                   [[people]]\nid = \"age_years\"\nunit = \"years\"\n\
                   [compare]\ngroups = \"crew\"\n";
    let text = String::from_utf8(desk.plan.study_toml.clone()).unwrap() + columns;
    fs::write(desk.plan.layout.study_toml(), &text).unwrap();
    fs::write(desk.plan.layout.people(PeopleForm::Toml), "[P01]\nage_years = 27\n").unwrap();
    desk.plan.study = Study::from_toml(&text).unwrap();
    desk.plan.study_toml = text.into_bytes();
    desk
}

#[test]
fn what_is_known_of_the_person_is_kept_with_the_session_and_chance_gives_a_level_once() {
    let mut desk = with_people();
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(2)).unwrap();
    let record = desk.data().sessions[0].record.clone();
    let [crew, age] = ["crew", "age_years"].map(|id| id.parse::<PersonColumnId>().unwrap());
    assert_eq!(record.person[&age], PersonValue::Number(27.0));
    assert_eq!(record.drawn, [(crew.clone(), 0)].into());
    let given = desk.data().people.level(&record.participant, &crew).cloned().unwrap();
    assert_eq!(record.person[&crew], PersonValue::Level(given.clone()));
    assert_eq!(notes(&desk)[0], format!("crew was drawn: {given}"));
    // Of another seed, yet of the same person.
    desk.plan.session = "S02".parse().unwrap();
    for seed in 0..8 {
        desk.plan.seed = Some(seed);
        let capabilities = Mock::default();
        let next = Session::open(&desk.plan, capabilities.capabilities(), &RealFiles).unwrap();
        assert_eq!((&next.record.person, &next.record.drawn), (&record.person, &record.drawn));
    }
    assert_eq!(verify(&desk.plan.layout), []);
    // Four people in a block: two of each.
    let levels = (1..=4).map(|number| {
        desk.plan.participant = format!("P{number:02}").parse().unwrap();
        desk.plan.seed = None;
        let device = Mock::default();
        let next = Session::open(&desk.plan, device.capabilities(), &RealFiles).unwrap();
        next.record.person[&crew].to_string()
    });
    let levels: Vec<String> = levels.collect();
    assert_eq!(levels.iter().filter(|level| *level == "expert").count(), 2, "{levels:?}");
}

#[test]
fn another_group_than_at_the_start_is_refused_until_it_is_accepted_and_another_age_is_noted() {
    let mut desk = with_people();
    let file = desk.plan.layout.people(PeopleForm::Toml);
    fs::write(&file, "[P01]\ncrew = \"novice\"\nage_years = 27\n").unwrap();
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(2)).unwrap();
    assert!(desk.data().sessions[0].record.drawn.is_empty());
    fs::write(&file, "[P01]\ncrew = \"novice\"\nage_years = 28\n").unwrap();
    desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(1)).unwrap();
    assert_eq!(notes(&desk), ["the participants' file has changed: age_years was 27 and is 28"]);
    assert_eq!(verify(&desk.plan.layout), []);
    let said = zwidth_store::study_notes(&RealFiles, &desk.plan.layout);
    assert!(said[0].ends_with("P01 S01 began: age_years was 27 and is 28"), "{said:?}");
    fs::write(&file, "[P01]\ncrew = \"expert\"\nage_years = 28\n").unwrap();
    let before = contents(desk.root());
    let error =
        desk.run(&mut Mock::default(), &RealFiles, &mut diligent()).unwrap_err().to_string();
    for words in ["crew was novice and is expert", "--accept-study-change"] {
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(contents(desk.root()), before);
    let [finding] = verify(&desk.plan.layout).try_into().unwrap();
    assert!(finding.what.contains("crew was novice and is expert"), "{finding}");
    desk.plan.accept_study_change = true;
    assert_eq!(desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap().done, TRIALS);
    let accepted = |event: &Event| matches!(event, Event::PersonAccepted { .. });
    assert_eq!(read_events(&of(&desk).log).unwrap().iter().filter(|e| accepted(e)).count(), 1);
    // Once it is accepted nobody is asked again; a third group would be another.
    desk.plan.accept_study_change = false;
    desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    assert_eq!(verify(&desk.plan.layout), []);
    let said = zwidth_store::study_notes(&RealFiles, &desk.plan.layout);
    assert!(said[0].contains("crew was novice and is expert"), "{said:?}");
    fs::write(&file, "[P01]\nage_years = 28\n").unwrap();
    assert!(desk.run(&mut Mock::default(), &RealFiles, &mut diligent()).is_err());
    let said = zwidth_store::accept_study(&RealFiles, &desk.plan.layout, UTC, None).unwrap();
    assert_eq!(said, ["P01 S01: another group is accepted: crew was novice and is not known"]);
    assert_eq!(verify(&desk.plan.layout).len(), 1, "who has no group is told");
}

/// Of whom the file alone says the group.
fn with_people_not_drawn() -> Desk {
    let mut desk = with_people();
    edit(&desk.plan.layout.study_toml(), "assigned = true", "assigned = false");
    desk.plan.study_toml = fs::read(desk.plan.layout.study_toml()).unwrap();
    let text = String::from_utf8(desk.plan.study_toml.clone()).unwrap();
    desk.plan.study = Study::from_toml(&text).unwrap();
    desk
}

#[test]
fn a_group_that_was_not_known_when_the_session_began_is_noted_and_kept_and_another_is_refused() {
    let accepted = |desk: &Desk| -> Vec<Event> {
        let is_accepted = |event: &Event| matches!(event, Event::PersonAccepted { .. });
        read_events(&of(desk).log).unwrap().into_iter().filter(is_accepted).collect()
    };
    let [novice, expert] = ["novice", "expert"].map(|level| Event::PersonAccepted {
        column: "crew".parse().unwrap(),
        level: Some(level.parse().unwrap()),
    });
    // Nothing at all was known of the person, or their age alone.
    for at_the_start in ["", "[P01]\nage_years = 27\n"] {
        let mut desk = with_people_not_drawn();
        let file = desk.plan.layout.people(PeopleForm::Toml);
        fs::write(&file, at_the_start).unwrap();
        desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(2)).unwrap();
        fs::write(&file, "[P01]\ncrew = \"novice\"\nage_years = 27\n").unwrap();
        desk.run(&mut Mock::default(), &Unsynced, &mut quits_after(1)).unwrap();
        let was = "crew was not known and is novice";
        let [note] = notes(&desk).try_into().unwrap();
        assert!(note.contains(was), "{note}");
        assert_eq!(note.contains("age_years"), at_the_start.is_empty(), "{note}");
        assert_eq!(verify(&desk.plan.layout), []);
        let said = zwidth_store::study_notes(&RealFiles, &desk.plan.layout);
        assert!(said[0].contains(was), "{said:?}");
        assert_eq!(accepted(&desk), std::slice::from_ref(&novice));
        fs::write(&file, "[P01]\ncrew = \"expert\"\nage_years = 27\n").unwrap();
        let error =
            desk.run(&mut Mock::default(), &RealFiles, &mut diligent()).unwrap_err().to_string();
        for words in ["crew was novice and is expert", "--accept-study-change"] {
            assert!(error.contains(words), "{error}");
        }
        let [finding] = verify(&desk.plan.layout).try_into().unwrap();
        assert!(finding.what.contains("crew was novice and is expert"), "{finding}");
        desk.plan.accept_study_change = true;
        desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
        assert_eq!(accepted(&desk), [novice.clone(), expert.clone()]);
        assert_eq!(verify(&desk.plan.layout), []);
    }
}

#[test]
fn a_group_filled_in_after_the_last_trial_is_kept_once_it_is_accepted() {
    let desk = with_people_not_drawn();
    let file = desk.plan.layout.people(PeopleForm::Toml);
    assert_eq!(desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap().done, TRIALS);
    // Nothing saw the first.
    for level in ["expert", "novice"] {
        fs::write(&file, format!("[P01]\ncrew = \"{level}\"\nage_years = 27\n")).unwrap();
        assert_eq!(verify(&desk.plan.layout), []);
    }
    let accept = || zwidth_store::accept_study(&RealFiles, &desk.plan.layout, UTC, None).unwrap();
    assert_eq!(accept(), ["P01 S01: the group is accepted: crew was not known and is novice"]);
    assert_eq!(accept(), Vec::<String>::new());
    assert_eq!(verify(&desk.plan.layout), []);
    // Another, and none.
    fs::write(&file, "[P01]\ncrew = \"expert\"\nage_years = 27\n").unwrap();
    let [finding] = verify(&desk.plan.layout).try_into().unwrap();
    assert!(finding.what.contains("crew was novice and is expert"), "{finding}");
    fs::write(&file, "[P01]\nage_years = 27\n").unwrap();
    let findings = verify(&desk.plan.layout);
    let words = "crew was novice and is not known";
    assert!(findings.iter().any(|finding| finding.what.contains(words)), "{findings:?}");
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
