mod tasks;

use super::{About, Action, End, Flow, Halt, Input, Phase, Recorded};
use crate::tasks::Tasks;
use proptest::prelude::*;
use std::collections::BTreeMap;
use zwidth_study::{AnswerScale, Event, Given, Kind, ModeId, PlannedTrial, Question};

const PAUSE_S: f64 = 5.0;

/// A session without tasks.
fn begin(
    order: Vec<(PlannedTrial, Vec<Question>)>,
    pause_s: f64,
    recorded: &[Recorded],
    events: &[Event],
) -> (Flow, Vec<Action>) {
    Flow::begin(order, Tasks::default(), pause_s, recorded, events)
}

fn felt() -> Question {
    Question {
        id: "felt".parse().unwrap(),
        text: "Felt?".to_owned(),
        group: None,
        scale: AnswerScale::FivePoint,
        label: None,
        is_weight: false,
        reversed: false,
    }
}

fn order(n: u32) -> Vec<(PlannedTrial, Vec<Question>)> {
    let trial = |trial: u32| PlannedTrial {
        trial,
        repeat: trial.div_ceil(3),
        kind: if trial == 1 { Kind::Familiarisation } else { Kind::Trial },
        environment: "spring".parse().unwrap(),
        mode: ModeId::new(format!("m{}", trial % 3)).unwrap(),
        samples: true,
        task: None,
    };
    // Every fourth trial has no question.
    (1..=n).map(|i| (trial(i), (i % 4 != 0).then(felt).into_iter().collect())).collect()
}

fn fresh(n: u32) -> Flow {
    let (flow, first) = begin(order(n), PAUSE_S, &[], &[]);
    assert_eq!(first, [Action::Check]);
    flow
}

/// Feeds inputs; the actions of the last one.
fn feed(flow: &mut Flow, inputs: impl IntoIterator<Item = Input>) -> Vec<Action> {
    inputs.into_iter().map(|i| flow.step(i)).last().unwrap_or_default()
}

/// A flow of three trials, ready for the first.
fn ready() -> Flow {
    let mut flow = fresh(3);
    feed(&mut flow, [Input::Checked, Input::Homed]);
    flow
}

/// The file of a trial that was answered at once.
fn finish(trial: u32, value: i16) -> Action {
    Action::Finish { trial, complete: true, likert: Some(Given { value, time_ms: None }) }
}

fn run_one(flow: &mut Flow) -> Vec<Action> {
    feed(flow, [Input::Start, Input::Ended(End::Complete), Input::Answer(4)])
}

#[test]
fn an_answer_has_the_time_for_which_its_question_was_shown() {
    let mut flow = ready();
    feed(&mut flow, [Input::Start, Input::Ended(End::Complete), Input::Elapsed(6.0)]);
    let given = |time_ms| {
        let likert = Some(Given { value: 2, time_ms });
        [Action::Finish { trial: 1, complete: true, likert }]
    };
    // What went by first was the trial's.
    assert_eq!(flow.clone().step(Input::Answer(2)), given(None));
    feed(&mut flow, [Input::Elapsed(0.5), Input::Elapsed(0.25)]);
    assert_eq!(flow.step(Input::Answer(2)), given(Some(750)));
}

/// One trial with three questions, the second of which goes from −3 to 3.
fn three() -> Vec<(PlannedTrial, Vec<Question>)> {
    let labels = Vec::new();
    let scale = zwidth_study::NumberScale { points: 7, from: -3, step: 1, labels };
    let mood =
        Question { id: "mood".parse().unwrap(), scale: AnswerScale::Numbers(scale), ..felt() };
    let last = Question { id: "last".parse().unwrap(), ..felt() };
    order(2)
        .into_iter()
        .map(|(trial, _)| (trial, vec![felt(), mood.clone(), last.clone()]))
        .collect()
}

/// A flow at the first of these questions.
fn questioned() -> Flow {
    let (mut flow, _) = begin(three(), PAUSE_S, &[], &[]);
    feed(&mut flow, [Input::Checked, Input::Homed, Input::Start, Input::Ended(End::Complete)]);
    flow
}

fn answered(question: &str, value: i16) -> Event {
    let question = question.parse().unwrap();
    Event::Answer { trial: 1, question, value: value.into(), time_ms: None }
}

#[test]
fn an_answer_at_the_participants_screen_is_the_same_and_a_remark_on_its_trial_says_so() {
    let mut here = questioned();
    let mut there = questioned();
    for (question, value) in [("felt", 4), ("mood", -2), ("last", 5)] {
        let text = format!("{question} was answered at the participant's screen");
        let remark = Action::Log(Event::Note { trial: Some(1), text });
        let expect = [here.step(Input::Answer(value)), vec![remark]].concat();
        assert_eq!(there.step(Input::AnswerThere(value)), expect);
        assert_eq!(there, here);
    }
}

#[test]
fn an_answer_at_the_participants_screen_that_is_none_leaves_no_remark() {
    let (mut flow, _) = begin(three(), PAUSE_S, &[], &[]);
    feed(&mut flow, [Input::Checked, Input::Homed]);
    assert!(matches!(&flow.step(Input::AnswerThere(4))[..], [Action::Refuse(_)]));
    feed(&mut flow, [Input::Start, Input::Ended(End::Complete)]);
    assert!(matches!(&flow.step(Input::AnswerThere(9))[..], [Action::Refuse(_)]));
}

#[test]
fn what_is_told_changes_nothing() {
    let (mut flow, _) = begin(three(), PAUSE_S, &[], &[]);
    let before = flow.clone();
    assert_eq!(flow.step(Input::Tell("a word".into())), [Action::Tell("a word".into())]);
    assert_eq!(flow, before);
}

#[test]
fn several_questions_follow_each_other_and_the_trial_is_safe_from_the_first_answer_on() {
    let mut flow = questioned();
    assert_eq!(flow.step(Input::Answer(4)), [finish(1, 4)]);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 1, late: true });
    assert!(is_refused(&flow.step(Input::Answer(4)), "-3 to 3"));
    assert_eq!(flow.step(Input::Answer(-2)), [Action::Log(answered("mood", -2))]);
    assert_eq!(flow.step(Input::Skip), []);
    assert_eq!(flow.phase(), &Phase::Pause);
}

#[test]
fn a_stop_among_several_questions_comes_back_to_the_one_that_is_open() {
    let mut flow = questioned();
    feed(&mut flow, [Input::Answer(4), Input::Stop, Input::Start, Input::Homed]);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 1, late: true });
    // So does a session that is resumed, by its log.
    let recorded = [Recorded { trial: 1, complete: true, settled: false }];
    let log = [answered("felt", 4), answered("mood", -2)];
    let (mut flow, _) = begin(three(), PAUSE_S, &recorded, &log);
    feed(&mut flow, [Input::Checked, Input::Homed]);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 2, late: true });
    assert_eq!(flow.step(Input::Answer(1)), [Action::Log(answered("last", 1))]);
    assert_eq!(flow.phase(), &Phase::Pause);
}

#[test]
fn a_session_goes_from_check_to_done() {
    let mut flow = ready();
    for trial in 1..=3 {
        assert_eq!(flow.phase(), &Phase::Ready);
        assert!(matches!(&flow.step(Input::Start)[..], [Action::Run(t)] if t.trial == trial));
        assert_eq!(flow.step(Input::Ended(End::Complete)), []);
        assert_eq!(flow.step(Input::Answer(2)), [finish(trial, 2)]);
        flow.step(Input::Elapsed(PAUSE_S));
    }
    assert_eq!((flow.phase(), flow.done()), (&Phase::Done, 3));
    assert_eq!(flow.step(Input::Quit), [Action::Off, Action::Leave]);
}

#[test]
fn the_pause_is_at_least_as_long_as_asked_for_and_the_question_is_no_part_of_it() {
    let mut flow = ready();
    feed(
        &mut flow,
        [Input::Start, Input::Ended(End::Complete), Input::Elapsed(60.0), Input::Answer(1)],
    );
    assert_eq!(flow.phase(), &Phase::Pause);
    feed(&mut flow, [Input::Elapsed(4.9), Input::Elapsed(f64::NAN), Input::Elapsed(-3.0)]);
    assert!(is_refused(&flow.step(Input::Start), "0.1 s to go"));
    feed(&mut flow, [Input::Elapsed(0.2)]);
    assert_eq!(flow.phase(), &Phase::Ready);
}

#[test]
fn a_repeat_comes_right_away_under_a_new_number_and_keeps_its_place() {
    let mut flow = ready();
    run_one(&mut flow);
    assert_eq!(flow.step(Input::Repeat), [Action::Log(Event::Superseded { trial: 1, by: 4 })]);
    assert!(is_refused(&flow.step(Input::Repeat), "trial 1"));
    feed(&mut flow, [Input::Elapsed(PAUSE_S)]);
    assert!(
        matches!(&flow.step(Input::Start)[..], [Action::Run(t)] if t.trial == 4 && t.mode == order(3)[0].0.mode)
    );
    feed(&mut flow, [Input::Ended(End::Complete), Input::Answer(3), Input::Elapsed(PAUSE_S)]);
    assert!(matches!(&flow.step(Input::Start)[..], [Action::Run(t)] if t.trial == 2));
}

#[test]
fn a_trial_cut_short_is_kept_and_done_again_after_homing() {
    let mut flow = ready();
    let actions =
        feed(&mut flow, [Input::Start, Input::Ended(End::Cut("force over the limit".into()))]);
    let finish = Action::Finish { trial: 1, complete: false, likert: None };
    assert_eq!(actions, [finish, Action::Log(Event::Superseded { trial: 1, by: 4 }), Action::Off]);
    assert_eq!(flow.phase(), &Phase::Stopped { why: "force over the limit".into() });
    assert_eq!(flow.step(Input::Start), [Action::Home]);
    feed(&mut flow, [Input::Homed, Input::Elapsed(PAUSE_S)]);
    assert!(matches!(&flow.step(Input::Start)[..], [Action::Run(t)] if t.trial == 4));
}

#[test]
fn an_emergency_stop_ends_a_trial_and_a_quit_wins_over_it() {
    let mut flow = ready();
    assert_eq!(feed(&mut flow, [Input::Start, Input::Stop]), [Action::Halt]);
    assert_eq!(flow.phase(), &Phase::Trial { halted: Some(Halt::Stop) });
    assert_eq!(feed(&mut flow, [Input::Quit, Input::Stop]), [Action::Halt]);
    let actions = flow.step(Input::Ended(End::Cut("stopped".into())));
    assert_eq!(actions.last(), Some(&Action::Leave));
}

#[test]
fn a_question_that_a_stop_left_open_is_asked_again_and_its_answer_is_an_event() {
    let mut flow = ready();
    let actions = feed(&mut flow, [Input::Start, Input::Ended(End::Complete), Input::Stop]);
    assert_eq!(actions, [Action::Finish { trial: 1, complete: true, likert: None }, Action::Off]);
    feed(&mut flow, [Input::Start, Input::Homed]);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 0, late: true });
    assert_eq!(flow.step(Input::Answer(5)), [Action::Log(answered("felt", 5))]);
}

#[test]
fn a_device_that_fails_while_a_question_is_open_is_told_as_what_stopped_the_session() {
    let mut flow = ready();
    let failed = Input::Failed("the turn is lost".into());
    let actions = feed(&mut flow, [Input::Start, Input::Ended(End::Complete), failed]);
    assert_eq!(actions, [Action::Finish { trial: 1, complete: true, likert: None }, Action::Off]);
    assert_eq!(flow.phase(), &Phase::Stopped { why: "the turn is lost".into() });
    feed(&mut flow, [Input::Start, Input::Homed]);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 0, late: true });
}

#[test]
fn exclusions_and_notes_speak_of_the_trial_that_ended_not_of_its_repeat() {
    let mut flow = ready();
    run_one(&mut flow);
    flow.step(Input::Repeat);
    let excluded = Event::Excluded { trial: 1, reason: "the phone rang".into() };
    // It gave its place away before, so that nothing is missing without it.
    assert_eq!(flow.step(Input::Exclude(" the phone rang ".into())), [Action::Log(excluded)]);
    let note = Event::Note { trial: Some(1), text: "twice".into() };
    assert_eq!(flow.step(Input::Note("twice".into())), [Action::Log(note)]);
    assert!(matches!(&flow.step(Input::Exclude("  ".into()))[..], [Action::Refuse(_)]));
}

#[test]
fn a_session_resumes_at_the_first_open_place_and_gives_a_cut_trial_s_place_to_a_new_one() {
    let file = |trial, complete| Recorded { trial, complete, settled: true };
    let files = [file(1, true), file(2, true), file(3, false), file(6, true)];
    let events = [Event::Superseded { trial: 2, by: 6 }];
    let (flow, first) = begin(order(5), PAUSE_S, &files, &events);
    assert_eq!(first, [Action::Log(Event::Superseded { trial: 3, by: 7 }), Action::Check]);
    let held: Vec<(u32, bool)> = flow.places().iter().map(|p| (p.trial.trial, p.done)).collect();
    assert_eq!(held, [(1, true), (6, true), (7, false), (4, false), (5, false)]);
    assert_eq!((flow.here(), flow.subject()), (Some(2), Some(6)));
}

/// Whether the actions are refused with these words.
fn is_refused(actions: &[Action], words: &str) -> bool {
    matches!(actions, [Action::Refuse(why)] if why.contains(words))
}

#[test]
fn an_excluded_trial_is_missing_and_offered_at_the_end_unless_it_is_repeated_before() {
    let mut flow = fresh(4);
    feed(&mut flow, [Input::Checked, Input::Homed]);
    for _ in 0..3 {
        run_one(&mut flow);
        flow.step(Input::Elapsed(PAUSE_S));
    }
    assert_eq!(flow.done(), 3);
    let why = || About::Exclude("the phone rang".into());
    let logged = |trial| Action::Log(Event::Excluded { trial, reason: "the phone rang".into() });
    assert_eq!(flow.step(Input::Of(2, why()))[0], logged(2));
    assert_eq!(flow.step(Input::Exclude("the phone rang".into()))[0], logged(3));
    assert_eq!((flow.done(), flow.here()), (1, Some(3)), "the rest comes first");
    // One is done again right away, which gives its place away now.
    let again = |trial, by| Action::Log(Event::Superseded { trial, by });
    assert_eq!(flow.step(Input::Of(3, About::Repeat)), [again(3, 5)]);
    assert!(matches!(&flow.step(Input::Start)[..], [Action::Run(t)] if t.trial == 5));
    feed(&mut flow, [Input::Ended(End::Complete), Input::Answer(3), Input::Elapsed(PAUSE_S)]);
    feed(&mut flow, [Input::Start, Input::Ended(End::Complete), Input::Elapsed(PAUSE_S)]);
    // The other one is all that is left.
    assert_eq!((flow.phase(), flow.done(), flow.here()), (&Phase::Ready, 3, Some(1)));
    assert_eq!(flow.number_at(1), (6, Some(2)));
    assert!(
        matches!(&flow.step(Input::Start)[..], [superseded, Action::Run(t)] if *superseded == again(2, 6) && t.trial == 6)
    );
    feed(&mut flow, [Input::Ended(End::Complete), Input::Answer(3), Input::Elapsed(PAUSE_S)]);
    assert_eq!((flow.phase(), flow.done()), (&Phase::Done, 4));
    // Also when all is done.
    flow.step(Input::Of(6, why()));
    assert_eq!((flow.phase(), flow.number_at(1)), (&Phase::Ready, (7, Some(6))));
}

#[test]
fn a_session_that_is_done_needs_no_device_until_a_trial_is_to_be_done_again() {
    let file = |trial, settled| Recorded { trial, complete: true, settled };
    let all = [file(1, true), file(2, true), file(3, true)];
    let (mut flow, first) = begin(order(3), PAUSE_S, &all, &[]);
    assert_eq!((flow.phase(), first), (&Phase::Done, Vec::new()));
    assert_eq!(flow.step(Input::Repeat).last(), Some(&Action::Check));
    assert_eq!(flow.phase(), &Phase::Check);
    let of = Input::Of(2, About::Exclude("x".into()));
    let (mut flow, _) = begin(order(3), PAUSE_S, &all, &[]);
    assert_eq!(flow.step(of).last(), Some(&Action::Check));
    // The last question is asked without it.
    let open = [file(1, true), file(2, true), file(3, false)];
    let (mut flow, first) = begin(order(3), PAUSE_S, &open, &[]);
    assert_eq!(first, []);
    assert_eq!(flow.phase(), &Phase::Question { place: 2, question: 0, late: true });
    flow.step(Input::Answer(3));
    assert_eq!(flow.phase(), &Phase::Done);
}

#[test]
fn a_pause_that_is_held_goes_on_until_somebody_ends_it() {
    let mut flow = ready();
    run_one(&mut flow);
    feed(&mut flow, [Input::Hold, Input::Elapsed(100.0)]);
    assert_eq!((flow.phase(), flow.is_held()), (&Phase::Pause, true));
    feed(&mut flow, [Input::Start]);
    assert_eq!(
        (flow.phase(), flow.is_held()),
        (&Phase::Ready, false),
        "Enter ends the pause alone"
    );
    feed(&mut flow, [Input::Hold, Input::Elapsed(100.0)]);
    assert_eq!(flow.phase(), &Phase::Pause);
    feed(&mut flow, [Input::Hold]);
    assert_eq!(flow.phase(), &Phase::Ready);
    // One that is held and let go keeps what is left of the pause.
    run_one(&mut flow);
    feed(&mut flow, [Input::Hold, Input::Hold]);
    assert_eq!((flow.phase(), flow.rest_s()), (&Phase::Pause, PAUSE_S));
    let mut fresh = fresh(3);
    assert!(is_refused(&fresh.step(Input::Hold), "no pause to hold"));
}

#[test]
fn an_excluded_trial_is_missing_when_the_session_is_resumed_and_one_to_practise_never() {
    let files: Vec<Recorded> =
        (1..=3).map(|trial| Recorded { trial, complete: true, settled: true }).collect();
    let excluded = |trial| Event::Excluded { trial, reason: "x".into() };
    let resumed = |events: &[Event]| begin(order(3), PAUSE_S, &files, events).0;
    let flow = resumed(&[excluded(1), excluded(2)]);
    assert_eq!((flow.done(), flow.here(), flow.number_at(1)), (2, Some(1), (4, Some(2))));
    let superseded = Event::Superseded { trial: 2, by: 4 };
    let flow = resumed(&[excluded(2), superseded]);
    assert_eq!((flow.here(), flow.number_at(1)), (Some(1), (4, Some(2))), "begun, and cut off");
    assert_eq!(resumed(&[excluded(1)]).here(), None);
}

#[test]
fn any_trial_is_asked_again_and_each_answer_is_an_event() {
    let mut flow = ready();
    run_one(&mut flow);
    assert_eq!(flow.phase(), &Phase::Pause);
    assert_eq!(flow.step(Input::Of(1, About::Ask)), []);
    assert_eq!(flow.phase(), &Phase::Question { place: 0, question: 0, late: true });
    assert!(is_refused(&flow.clone().step(Input::Of(1, About::Ask)), "a question is open"));
    assert_eq!(flow.number_at(0), (1, None));
    assert_eq!(flow.step(Input::Answer(2)), [Action::Log(answered("felt", 2))]);
    assert_eq!(flow.phase(), &Phase::Pause);
    // A stop in it comes back to it: it is no longer the last trial alone that waits.
    feed(&mut flow, [Input::Elapsed(PAUSE_S)]);
    run_one(&mut flow);
    feed(&mut flow, [Input::Of(1, About::Ask)]);
    feed(&mut flow, [Input::Skip]);
    assert_eq!(flow.phase(), &Phase::Pause);
}

#[test]
fn what_cannot_be_said_of_a_trial_is_refused_with_the_reason() {
    let mut flow = ready();
    run_one(&mut flow);
    flow.step(Input::Elapsed(PAUSE_S));
    let why = || About::Exclude("x".into());
    for (trial, about, words) in [
        (2, why(), "no trial 2 that has ended"),
        (9, About::Note("x".into()), "no trial 9"),
        (1, About::Exclude(" ".into()), "needs its reason"),
        (1, About::Note(" ".into()), "is empty"),
        (2, About::Repeat, "no trial 2 that has ended"),
        (2, About::Ask, "no trial 2 that has ended"),
    ] {
        assert!(is_refused(&flow.step(Input::Of(trial, about)), words), "{words}");
    }
    let note = Event::Note { trial: Some(2), text: "left hand".into() };
    assert_eq!(
        flow.step(Input::Of(2, About::Note("left hand".into()))),
        [Action::Log(note)],
        "also before it"
    );
    flow.step(Input::Of(1, About::Repeat));
    for about in [About::Repeat, About::Ask] {
        assert!(is_refused(&flow.step(Input::Of(1, about)), "to be done again already"));
    }
    feed(&mut flow, [Input::Start]);
    assert!(is_refused(&flow.step(Input::Of(1, why())), "a trial is running"));
    feed(&mut flow, [Input::Ended(End::Complete), Input::Answer(1)]);
    assert!(is_refused(&flow.step(Input::Of(1, About::Ask)), "done again as trial 4"));
}

/// What lies on the disk of a session played by random inputs, and what is going on.
#[derive(Default)]
struct World {
    running: Option<PlannedTrial>,
    waiting: Option<PlannedTrial>,
    started: Vec<PlannedTrial>,
    files: BTreeMap<u32, (PlannedTrial, bool, Option<Given>)>,
    events: Vec<Event>,
    left: bool,
    /// Somebody spoke of an earlier trial, or excluded one: trials that count may follow each other
    /// otherwise than drawn.
    of_any: bool,
}

impl World {
    fn act(&mut self, action: Action, asked: Option<&Input>) {
        match action {
            Action::Run(trial) => {
                assert!(self.running.is_none() && self.waiting.is_none(), "two trials at once");
                let used = self.started.iter().any(|t| t.trial == trial.trial);
                assert!(
                    !used && !self.files.contains_key(&trial.trial),
                    "number {} twice",
                    trial.trial
                );
                self.started.push(trial.clone());
                self.running = Some(trial);
            }
            Action::Finish { trial, complete, likert } => {
                let ended = self.waiting.take().expect("a file of a trial that did not end");
                assert_eq!(ended.trial, trial, "an answer or a file of another trial");
                assert_eq!(likert.is_some(), matches!(asked, Some(Input::Answer(_))));
                assert!(self.files.insert(trial, (ended, complete, likert)).is_none());
            }
            Action::Log(event) => {
                if let Event::Answer { trial, .. } = event
                    && !self.of_any
                {
                    let (_, complete, likert) = &self.files[&trial];
                    assert!(*complete && likert.is_none(), "a second answer");
                    assert_eq!(
                        self.files_in_time().last(),
                        Some(&trial),
                        "an answer to an earlier trial"
                    );
                    let answered =
                        |e: &Event| matches!(e, Event::Answer { trial: t, .. } if *t == trial);
                    assert!(!self.events.iter().any(answered), "answered twice");
                }
                self.events.push(event);
            }
            Action::Off => assert!(self.running.is_none(), "the loop that runs has the device"),
            Action::Halt => assert!(self.running.is_some()),
            Action::Leave => self.left = true,
            Action::Check | Action::Home | Action::Refuse(_) | Action::Tell(_) => {}
        }
    }

    fn files_in_time(&self) -> Vec<u32> {
        self.started.iter().map(|t| t.trial).filter(|t| self.files.contains_key(t)).collect()
    }

    fn superseded(&self) -> BTreeMap<u32, u32> {
        let pair = |e: &Event| match e {
            Event::Superseded { trial, by } => Some((*trial, *by)),
            _ => None,
        };
        self.events.iter().filter_map(pair).collect()
    }

    fn recorded(&self) -> Vec<Recorded> {
        let answered = |n: u32| {
            self.events.iter().any(|e| matches!(e, Event::Answer { trial, .. } if *trial == n))
        };
        let one = |(n, (_, complete, likert)): (&u32, &(PlannedTrial, bool, Option<Given>))| {
            Recorded { trial: *n, complete: *complete, settled: likert.is_some() || answered(*n) }
        };
        self.files.iter().map(one).collect()
    }

    /// The conditions that count, in the order in which they were recorded, are a beginning of the
    /// order drawn; where somebody spoke of any trial they are some of it, each once.
    fn check_order(&self, n: u32) -> usize {
        let superseded = self.superseded();
        let excluded = |n: u32| {
            let is_it = |e: &Event| matches!(e, Event::Excluded { trial, .. } if *trial == n);
            self.files[&n].0.kind == Kind::Trial && self.events.iter().any(is_it)
        };
        let counts = |t: &&PlannedTrial| {
            self.files.get(&t.trial).is_some_and(|f| f.1)
                && !superseded.contains_key(&t.trial)
                && !excluded(t.trial)
        };
        let found: Vec<(ModeId, u32)> =
            self.started.iter().filter(counts).map(|t| (t.mode.clone(), t.repeat)).collect();
        let drawn: Vec<(ModeId, u32)> =
            order(n).into_iter().map(|(t, _)| (t.mode, t.repeat)).collect();
        if self.of_any {
            let once = |one| drawn.iter().filter(|d| *d == one).count() == 1;
            assert!(
                found
                    .iter()
                    .all(|one| once(one) && found.iter().filter(|f| *f == one).count() == 1)
            );
        } else {
            assert_eq!(found[..], drawn[..found.len()]);
        }
        found.len()
    }
}

/// Inputs of people and devices, the likelier ones more often; `None` is a kill, after which the
/// session is resumed.
fn inputs() -> impl Strategy<Value = Vec<Option<Input>>> {
    let one = prop_oneof![
        6 => Just(Some(Input::Checked)), 6 => Just(Some(Input::Homed)), 10 => Just(Some(Input::Start)),
        10 => Just(Some(Input::Ended(End::Complete))), 3 => Just(Some(Input::Ended(End::Cut("cut".into())))),
        10 => (0_i16..7).prop_map(|a| Some(Input::Answer(a))), 2 => Just(Some(Input::Skip)), 1 => Just(Some(Input::Hold)),
        10 => (0.0..9.0_f64).prop_map(|dt| Some(Input::Elapsed(dt))), 2 => Just(Some(Input::Repeat)),
        1 => (1_u32..9, about()).prop_map(|(trial, about)| Some(Input::Of(trial, about))),
        1 => Just(Some(Input::Exclude("why".into()))), 1 => Just(Some(Input::Note("note".into()))),
        1 => Just(Some(Input::Stop)), 1 => Just(Some(Input::Quit)), 1 => Just(Some(Input::Failed("fault".into()))),
        1 => Just(None),
    ];
    prop::collection::vec(one, 0..300)
}

/// What is said of any trial.
fn about() -> impl Strategy<Value = About> {
    prop_oneof![
        Just(About::Exclude("why".into())),
        Just(About::Note("note".into())),
        Just(About::Repeat),
        Just(About::Ask)
    ]
}

const TRIALS: u32 = 5;

fn play(world: &mut World, flow: &mut Flow, input: Input) {
    // Only a running trial ends; the runner sees to that.
    if let Input::Ended(_) = input {
        match world.running.take() {
            Some(trial) => world.waiting = Some(trial),
            None => return,
        }
    }
    world.of_any |= matches!(input, Input::Of(..) | Input::Exclude(_));
    for action in flow.step(input.clone()) {
        world.act(action, Some(&input));
    }
    let running = matches!(flow.phase(), Phase::Trial { .. });
    assert_eq!(running, world.running.is_some(), "the flow and the world disagree");
}

/// The session is killed: what ran is cut, what waited for its answer is complete, as `recover`
/// makes them.
fn resume(world: &mut World) -> Flow {
    if let Some(trial) = world.running.take() {
        world.files.insert(trial.trial, (trial, false, None));
    }
    if let Some(trial) = world.waiting.take() {
        world.files.insert(trial.trial, (trial, true, None));
    }
    world.left = false;
    let (flow, first) = begin(order(TRIALS), PAUSE_S, &world.recorded(), &world.events);
    first.into_iter().for_each(|a| world.act(a, None));
    flow
}

proptest! {
    #[test]
    fn whatever_happens_no_trial_runs_beside_another_none_is_lost_and_the_order_stays(inputs in inputs()) {
        let mut world = World::default();
        let mut flow = resume(&mut world);
        for input in inputs {
            match input {
                Some(input) if !world.left => play(&mut world, &mut flow, input),
                _ => flow = resume(&mut world),
            }
            world.check_order(TRIALS);
        }
        // From wherever that led, the session can be brought to its end.
        flow = resume(&mut world);
        for _ in 0..=3 * TRIALS {
            let whole = [
                Input::Hold, Input::Hold, Input::Checked, Input::Homed, Input::Answer(3), Input::Elapsed(PAUSE_S), Input::Start,
                Input::Ended(End::Complete), Input::Answer(3), Input::Elapsed(PAUSE_S),
            ];
            whole.into_iter().for_each(|i| play(&mut world, &mut flow, i));
        }
        prop_assert_eq!(flow.phase(), &Phase::Done);
        prop_assert_eq!(world.check_order(TRIALS), TRIALS as usize);
        // Every trial that was started has its file, and all but those superseded are complete.
        prop_assert_eq!(world.files.len(), world.started.len());
    }

    #[test]
    fn an_emergency_stop_is_obeyed_from_every_phase(inputs in inputs()) {
        let mut world = World::default();
        let mut flow = resume(&mut world);
        for input in inputs.into_iter().flatten().filter(|i| *i != Input::Quit) {
            play(&mut world, &mut flow, input);
            let stopped = flow.clone().step(Input::Stop);
            let expect = if world.running.is_some() { Action::Halt } else { Action::Off };
            prop_assert!(stopped.contains(&expect), "{:?} in {:?}", stopped, flow.phase());
        }
    }
}
