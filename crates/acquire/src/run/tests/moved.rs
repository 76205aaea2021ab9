//! A study's folder that is moved or removed while a session is recorded into it.

use super::*;
use std::fs;

/// The study's folder goes elsewhere.
fn move_away(raw: &Path) {
    fs::rename(raw, raw.with_file_name("moved")).unwrap();
}

/// The session's end, its folder gone; what was recorded lies there alone.
fn gone(desk: &Desk, mock: &Mock, error: &AcquireError) -> Layout {
    let words = error.to_string();
    assert!(words.contains("moved or removed") && words.contains("same command"), "{words}");
    assert!(!desk.plan.layout.raw().exists(), "it was made anew");
    assert_eq!(mock.writes.last().unwrap().1, Voltages::OFF);
    Layout::new(desk.root(), "moved".parse().unwrap())
}

/// The folder back in its place, nothing is lost and the session goes on to its end.
fn goes_on(desk: &Desk) {
    fs::rename(desk.root().join("raw/moved"), desk.plan.layout.raw()).unwrap();
    recover(&RealFiles, &desk.plan.layout, UTC).into_iter().for_each(|found| drop(found.unwrap()));
    assert_eq!(verify(&desk.plan.layout), []);
    let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    assert_eq!((outcome.done, verify(&desk.plan.layout)), (TRIALS, vec![]));
}

/// Somebody whose study's folder goes elsewhere when two trials are done, in a phase of this kind.
fn leaves_at(
    desk: &Desk,
    is_phase: fn(&Shown) -> bool,
) -> Somebody<impl FnMut(&View) -> Option<Input>> {
    let raw = desk.plan.layout.raw();
    somebody(move |view: &View| {
        if view.done == 2 && is_phase(&view.phase) {
            move_away(&raw);
        }
        None
    })
}

#[test]
fn a_folder_moved_in_a_pause_is_noticed_before_the_next_trial() {
    let desk = Desk::new(false);
    let mut front = leaves_at(&desk, |phase| *phase == Shown::Ready);
    let mut mock = Mock::default();
    let error = desk.run(&mut mock, &RealFiles, &mut front).unwrap_err();
    let begun = mock.writes.last().unwrap().0;
    let moved = gone(&desk, &mock, &error);
    assert_eq!(fs::read_dir(moved.journals()).unwrap().count(), 0);
    assert!(mock.writes.iter().rfind(|(_, v)| *v != Voltages::OFF).unwrap().0 < begun - 1.0);
    goes_on(&desk);
}

#[test]
fn a_folder_moved_while_a_question_is_open_keeps_the_journal_of_its_trial() {
    let desk = Desk::new(false);
    let mut front = leaves_at(&desk, |phase| matches!(phase, Shown::Question { .. }));
    let mut mock = Mock::default();
    let error = desk.run(&mut mock, &RealFiles, &mut front).unwrap_err();
    let moved = gone(&desk, &mock, &error);
    assert_eq!(fs::read_dir(moved.journals()).unwrap().count(), 1);
    goes_on(&desk);
    assert_eq!(desk.data().trials[2].meta.status, Status::Complete);
}

#[test]
fn a_folder_moved_in_a_trial_ends_it_at_the_next_batch_and_its_samples_are_kept() {
    let desk = Desk::new(false);
    let raw = desk.plan.layout.raw();
    let left = Mutex::new(20);
    // The folder goes away at an append of a trial's journal.
    let files = Heard::new(move |request| {
        if matches!(request, Request::Append(..)) && take(&left).is_err() && raw.exists() {
            move_away(&raw);
        }
        Ok(())
    });
    let mut mock = Mock::default();
    let mut asked = 0;
    let mut front = somebody(|view: &View| {
        asked += u32::from(matches!(view.phase, Shown::Question { .. }));
        None
    });
    let error = desk.run(&mut mock, &files, &mut front).unwrap_err();
    drop(front);
    assert_eq!(asked, 0, "noticed only after the question");
    let moved = gone(&desk, &mock, &error);
    assert_eq!(fs::read_dir(moved.journals()).unwrap().count(), 1);
    goes_on(&desk);
    let (incomplete, rows) =
        desk.data().trials.iter().map(|t| (t.meta.status, t.rows)).next().unwrap();
    assert!(incomplete == Status::Incomplete && rows > 100, "{rows}");
}

#[test]
fn a_folder_that_is_removed_is_not_made_anew() {
    let desk = Desk::new(false);
    let raw = desk.plan.layout.raw();
    let mut front = somebody(|view: &View| {
        if view.done == 1 && view.phase == Shown::Ready {
            fs::remove_dir_all(&raw).unwrap();
        }
        None
    });
    let mut mock = Mock::default();
    let error = desk.run(&mut mock, &RealFiles, &mut front).unwrap_err();
    gone(&desk, &mock, &error);
}
