//! Trials that do not meet the protocol: told, and done again if the study says so.

use super::*;

/// The first trial of each place of a condition does not meet it, and no practice trial does.
fn first_ones(trial: &Trial) -> Option<Verdict> {
    let trial = trial.meta.trial;
    Some(Verdict {
        trial,
        unmet: (trial <= 3).then(|| "2 movements forward and 1 back".to_owned()),
    })
}

fn desk(redo_unmet: u32, blinded: bool) -> Desk {
    let text = small("small", blinded)
        .replace("pause_s = 5.0", &format!("pause_s = 5.0\nredo_unmet = {redo_unmet}"));
    Desk { judge: first_ones, ..Desk::with(text) }
}

fn unmet(desk: &Desk) -> Vec<u32> {
    let events = desk.data().sessions[0].events.clone();
    events
        .into_iter()
        .filter_map(|event| match event {
            Event::Unmet { trial, .. } => Some(trial),
            _ => None,
        })
        .collect()
}

#[test]
fn the_verdict_stays_on_the_screen_until_the_next_trial_and_nothing_follows_without_a_rule() {
    let desk = desk(0, false);
    let mut told = Vec::new();
    let mut front = Somebody(
        |view: &View| {
            if let (Shown::Pause { .. } | Shown::Done, Some(verdict)) = (&view.phase, &view.verdict)
                && told.last() != Some(verdict)
            {
                told.push(verdict.clone());
            }
            assert!(!matches!(view.phase, Shown::Trial { .. }) || view.verdict.is_none());
            None
        },
        Shown::Check,
        None,
    );
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    assert_eq!((outcome.done, outcome.total), (TRIALS, TRIALS));
    let seen: Vec<(u32, bool)> = told.iter().map(|v| (v.trial, v.unmet.is_some())).collect();
    assert_eq!(seen, (1..=7).map(|trial| (trial, trial <= 3)).collect::<Vec<_>>());
    assert!(unmet(&desk).is_empty());
    assert_eq!(desk.data().counting().count(), TRIALS - 1);
}

#[test]
fn by_the_rule_a_trial_that_does_not_meet_it_is_done_again_after_all_others_blinded_or_not() {
    for blinded in [false, true] {
        let desk = desk(2, blinded);
        let mut front = Auto::new(Nobody);
        let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
        assert_eq!((outcome.done, outcome.total), (TRIALS, TRIALS));
        // Trial 1 is practice, which counts nowhere.
        assert_eq!(unmet(&desk), [2, 3]);
        let data = desk.data();
        let why = |trial: u32| {
            let entry = data.trials.iter().find(|entry| entry.meta.trial == trial).unwrap();
            (entry.is_unmet, entry.superseded_by, entry.why_left_out().unwrap_or_default())
        };
        let what = "the protocol was not met: 2 movements forward and 1 back; superseded by trial";
        assert_eq!(why(2), (true, Some(8), format!("{what} 8")));
        assert_eq!(why(3), (true, Some(9), format!("{what} 9")));
        assert_eq!(why(8), (false, None, String::new()));
        assert_eq!(data.problems, [], "{blinded}");
    }
}

#[test]
fn after_as_many_times_as_the_rule_says_a_trial_counts_and_a_kill_forgets_none_of_them() {
    let never = |trial: &Trial| {
        Some(Verdict { trial: trial.meta.trial, unmet: Some("no movement".to_owned()) })
    };
    let desk = Desk { judge: never, ..desk(1, false) };
    // It is left in the middle of the repeats.
    let mut leaves = Somebody(
        |view: &View| {
            let is_repeat = view.trial.as_ref().is_some_and(|trial| trial.trial >= 10);
            (is_repeat && view.phase == Shown::Ready).then_some(Input::Quit)
        },
        Shown::Check,
        None,
    );
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut leaves).unwrap();
    assert!(outcome.done < TRIALS, "{outcome:?}");
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut Auto::new(Nobody)).unwrap();
    assert_eq!((outcome.done, outcome.total), (TRIALS, TRIALS));
    assert_eq!(unmet(&desk), [2, 3, 4, 5, 6, 7]);
    let counting: Vec<u32> = desk.data().counting().map(|entry| entry.meta.trial).collect();
    assert_eq!(counting, [8, 9, 10, 11, 12, 13]);
}
