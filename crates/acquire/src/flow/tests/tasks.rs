//! Sessions of tasks: presentations, sequences of levels, and lives that end at any write.

use crate::flow::{About, Action, End, Flow, GAP_S, Input, Phase, Recorded};
use crate::tasks::Tasks;
use std::collections::BTreeMap;
use zwidth_study::{
    AnswerScale, Asks, Event, Given, Kind, Method, PlannedTrial, Question, StaircasePlan, Study,
    Task, TaskEstimate, TaskFit, TaskLevel, TaskPlace, template,
};

const RATE_HZ: f64 = 1000.0;

fn level(value: f64) -> TaskLevel {
    TaskLevel::nearest(value).unwrap()
}

fn levels(values: &[f64]) -> Vec<TaskLevel> {
    values.iter().map(|value| level(*value)).collect()
}

fn task(id: &str, asks: Asks, method: Method) -> Task {
    Task {
        id: id.parse().unwrap(),
        text: "Which one was stiffer?".to_owned(),
        asks,
        environment: "spring".parse().unwrap(),
        varies: "stiffness_n_per_rad".to_owned(),
        standard: Some(level(4.0)),
        method,
        catch: 0.0,
        feedback: false,
        fit: TaskFit::default(),
        estimate: TaskEstimate::Likelihood,
    }
}

fn staircase() -> Method {
    Method::Staircase(StaircasePlan {
        up_after: 1,
        down_after: 2,
        starts: levels(&[6.0, 5.0]),
        up: 0.4,
        down: 0.22,
        is_factor: false,
        bounds: [level(2.0), level(8.0)],
        reversals: 4,
        of_last: 2,
        most_trials: 30,
    })
}

fn quest() -> Method {
    let levels = levels(&[2.0, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0]);
    let (pse, sigma, lapse) = ([3.0, 5.0, 0.25], [0.2, 1.0, 0.2], [0.02, 0.02, 1.0]);
    Method::QuestPlus { levels, trials: 12, pse, sigma, lapse }
}

fn constant() -> Method {
    Method::Constant { levels: levels(&[3.0, 4.0, 5.0]), trials: 3 }
}

fn adjustment() -> Method {
    let starts = [level(2.5), level(6.0)];
    let bounds = [level(2.0), level(7.0)];
    Method::Adjustment { starts, step: level(0.5), bounds, settings: 2, most_trials: 12 }
}

/// A study whose only content are these tasks.
fn study(tasks: Vec<Task>) -> Study {
    let mut study = Study::from_toml(&template(&"demo".parse().unwrap())).unwrap();
    study.tasks = tasks;
    study
}

/// Each task in each of two modes, the modes in turn.
fn order(study: &Study) -> Vec<(PlannedTrial, Vec<Question>)> {
    let mut order = Vec::new();
    for task in &study.tasks {
        let each = match &task.method {
            Method::Constant { levels, trials } => levels.len() as u32 * trials,
            Method::Staircase(plan) => 2 * plan.most_trials,
            Method::QuestPlus { trials, .. } => *trials,
            Method::Adjustment { settings, most_trials, .. } => settings * most_trials,
        };
        for presentation in 1..=each {
            for mode in &study.modes[..2] {
                for interval in 1..=task.asks.intervals() {
                    let trial = order.len() as u32 + 1;
                    let track = match &task.method {
                        Method::Staircase(_) => (presentation % 2) as u8,
                        Method::Adjustment { most_trials, .. } => {
                            ((presentation - 1) / most_trials) as u8
                        }
                        _ => 0,
                    };
                    let level = match &task.method {
                        Method::Constant { levels, .. } => {
                            Some(levels[presentation as usize % levels.len()])
                        }
                        _ => None,
                    };
                    let has_two = task.asks.intervals() == 2;
                    let is_standard =
                        has_two.then_some((presentation + u32::from(interval)) % 2 == 0);
                    let place = TaskPlace {
                        task: task.id.clone(),
                        presentation,
                        track,
                        interval,
                        level,
                        is_standard,
                    };
                    let is_last = place.is_last(task.asks);
                    let planned = PlannedTrial {
                        trial,
                        repeat: presentation,
                        kind: Kind::Trial,
                        environment: task.environment.clone(),
                        mode: mode.id.clone(),
                        samples: true,
                        task: Some(place),
                    };
                    let question = Question {
                        id: task.id.clone(),
                        text: task.text.clone(),
                        group: None,
                        scale: AnswerScale::Task(task.asks),
                        label: None,
                        is_weight: false,
                        reversed: false,
                    };
                    order.push((planned, is_last.then_some(question).into_iter().collect()));
                }
            }
        }
    }
    order
}

/// What lies on the disk of a session.
#[derive(Debug, Clone, Default, PartialEq)]
struct Disk {
    files: Vec<Recorded>,
    events: Vec<Event>,
    /// Writes until the end of this life; none: it lives on.
    left: Option<usize>,
}

impl Disk {
    /// Whether there is a write left.
    fn write(&mut self) -> bool {
        let Some(left) = &mut self.left else { return true };
        let is_left = *left > 0;
        *left = left.saturating_sub(1);
        is_left
    }
}

fn opened(study: &Study, disk: &Disk) -> (Flow, Vec<Action>) {
    let order = order(study);
    let trials: Vec<PlannedTrial> = order.iter().map(|(trial, _)| trial.clone()).collect();
    let numbers: Vec<u32> = trials.iter().map(|trial| trial.trial).collect();
    let mut tasks = Tasks::new(study, &trials, RATE_HZ).unwrap();
    tasks.replay(&numbers, &disk.events).unwrap();
    Flow::begin(order, tasks, 0.0, &disk.files, &disk.events)
}

/// A person of one's own: what is answered depends on the level and the presentation alone.
fn answer(flow: &Flow, place: usize) -> i16 {
    let shown = flow.tasks().at_hand(place).unwrap();
    let compared = shown.compared.value();
    let noise = f64::from(shown.presentation.wrapping_mul(2_654_435_761) >> 20) / 4096.0 - 0.5;
    let is_more = compared + 1.5 * noise > 4.1;
    match shown.task.asks {
        Asks::MoreOfTwo | Asks::OneOfTwo => 1 + i16::from(is_more != shown.last_is_standard),
        Asks::YesNo | Asks::MoreLess => 1 + i16::from(!is_more),
        Asks::Set if (compared - 4.0).abs() < 0.3 => 3,
        Asks::Set => 1 + i16::from(compared > 4.0),
    }
}

/// A life of the session, from what the disk has to its end, or to the end of the disk's writes. `say` may give an input
/// before all else, once for each phase.
fn live(study: &Study, disk: &mut Disk, mut say: impl FnMut(&Flow) -> Option<Input>) -> Flow {
    let (mut flow, mut actions) = opened(study, disk);
    let mut inputs = Vec::new();
    for _ in 0..100_000 {
        for action in std::mem::take(&mut actions) {
            match action {
                Action::Check => inputs.push(Input::Checked),
                Action::Home => inputs.push(Input::Homed),
                Action::Run(_) => inputs.push(Input::Ended(End::Complete)),
                Action::Finish { trial, complete, likert } => {
                    if !disk.write() {
                        return flow;
                    }
                    disk.files.push(Recorded { trial, complete, settled: false });
                    let place = flow.places().iter().position(|p| p.trial.trial == trial);
                    if let Some(Given { value, time_ms }) = likert {
                        let question = flow.places()[place.unwrap()].questions[0].id.clone();
                        let value = value.into();
                        disk.events.push(Event::Answer { trial, question, value, time_ms });
                    }
                }
                Action::Log(event) => {
                    if !disk.write() {
                        return flow;
                    }
                    disk.events.push(event);
                }
                Action::Refuse(why) => panic!("{why}"),
                Action::Halt | Action::Tell(_) | Action::Off | Action::Leave => {}
            }
        }
        let own = say(&flow);
        let next = if let Some(own) = own {
            own
        } else if !inputs.is_empty() {
            inputs.remove(0)
        } else {
            match flow.phase() {
                Phase::Ready | Phase::Stopped { .. } => Input::Start,
                Phase::Question { place, .. } => Input::Answer(answer(&flow, *place)),
                Phase::Pause => Input::Elapsed(GAP_S),
                Phase::Done | Phase::Left => return flow,
                phase => panic!("{phase:?}"),
            }
        };
        actions = flow.step(next);
    }
    panic!("the session has no end");
}

/// The level and the answer of each presentation that counts, by its first place.
fn counting(study: &Study, disk: &Disk) -> BTreeMap<usize, (Option<TaskLevel>, i16)> {
    let (flow, _) = opened(study, disk);
    let order = order(study);
    let mut found = BTreeMap::new();
    for place in 0..order.len() {
        let holder = flow.places()[place].trial.trial;
        let answers: Vec<i16> = disk
            .events
            .iter()
            .filter_map(|event| match event {
                Event::Answer { trial, value, .. } if *trial == holder => value.whole(),
                _ => None,
            })
            .collect();
        assert!(answers.len() < 2, "trial {holder} was answered twice");
        if let [value] = answers[..] {
            let level = flow.tasks().at_hand(place).map(|shown| shown.compared);
            assert!(found.insert(flow.tasks().places(place).start, (level, value)).is_none());
        }
    }
    found
}

fn all_methods() -> Study {
    study(vec![
        task("stiffer", Asks::MoreOfTwo, constant()),
        task("steps", Asks::MoreOfTwo, staircase()),
        task("grid", Asks::MoreLess, quest()),
        task("equal", Asks::Set, adjustment()),
    ])
}

#[test]
fn two_intervals_follow_each_other_with_one_question_after_the_last() {
    let study = study(vec![task("stiffer", Asks::MoreOfTwo, constant())]);
    let (mut flow, _) = opened(&study, &Disk::default());
    flow.step(Input::Checked);
    flow.step(Input::Homed);
    let first = flow.step(Input::Start);
    assert!(matches!(&first[..], [Action::Run(trial)] if trial.trial == 1), "{first:?}");
    let ended = flow.step(Input::Ended(End::Complete));
    assert!(matches!(ended[..], [Action::Finish { trial: 1, complete: true, likert: None }]));
    assert_eq!((flow.phase(), flow.rest_s()), (&Phase::Pause, GAP_S));
    // Nothing comes between.
    for refused in [Input::Hold, Input::Exclude("x".into()), Input::Start] {
        assert!(matches!(flow.step(refused.clone())[..], [Action::Refuse(_)]), "{refused:?}");
    }
    let about = Input::Of(1, About::Repeat);
    assert!(matches!(flow.step(about)[..], [Action::Refuse(_)]));
    let second = flow.step(Input::Elapsed(GAP_S));
    assert!(matches!(&second[..], [Action::Run(trial)] if trial.trial == 2), "{second:?}");
    flow.step(Input::Ended(End::Complete));
    assert!(matches!(flow.phase(), Phase::Question { place: 1, question: 0, late: false }));
    let answered = flow.step(Input::Answer(2));
    assert!(matches!(answered[..], [Action::Finish { trial: 2, likert: Some(_), .. }]));
    assert_eq!(flow.phase(), &Phase::Ready);
}

/// What was done again of a presentation: its trials, and those in their place.
fn superseded(actions: &[Action]) -> Vec<(u32, u32)> {
    let all = actions.iter().filter_map(|action| match action {
        Action::Log(Event::Superseded { trial, by }) => Some((*trial, *by)),
        _ => None,
    });
    all.collect()
}

#[test]
fn whatever_befalls_one_interval_befalls_the_presentation() {
    let study = study(vec![task("stiffer", Asks::MoreOfTwo, constant())]);
    let n = order(&study).len() as u32;
    let at = |inputs: &[Input]| {
        let (mut flow, _) = opened(&study, &Disk::default());
        flow.step(Input::Checked);
        flow.step(Input::Homed);
        let actions = inputs.iter().map(|input| flow.step(input.clone())).last().unwrap();
        (flow, actions)
    };
    let complete = Input::Ended(End::Complete);
    let first = [Input::Start, complete.clone()];
    let second = [&first[..], &[Input::Elapsed(GAP_S)]].concat();
    let asked = [&second[..], std::slice::from_ref(&complete)].concat();
    let both = vec![(1, n + 1), (2, n + 2)];
    // Cut in the second interval; stopped or left between both.
    let cut = Input::Ended(End::Cut("a safety trigger".into()));
    let (flow, actions) = at(&[&second[..], &[cut]].concat());
    assert_eq!((superseded(&actions), flow.here()), (both.clone(), Some(0)));
    for end in [Input::Stop, Input::Quit, Input::Failed("the cable".into()), Input::Repeat] {
        let (flow, actions) = at(&[&first[..], &[end]].concat());
        assert_eq!((superseded(&actions), flow.here()), (vec![(1, n + 1)], Some(0)));
    }
    // Done again while its question is open, and later, by either of its trials.
    let (flow, actions) = at(&[&asked[..], &[Input::Repeat]].concat());
    assert_eq!((superseded(&actions), flow.here()), (both.clone(), Some(0)));
    for trial in [1, 2] {
        let about = |about| [&asked[..], &[Input::Answer(1), Input::Of(trial, about)]].concat();
        let (flow, actions) = at(&about(About::Repeat));
        assert_eq!((superseded(&actions), flow.here()), (both.clone(), Some(0)), "{trial}");
        // Excluded it is missing, and offered when all others are done.
        let (flow, actions) = at(&about(About::Exclude("the phone rang".into())));
        let excluded = actions.iter().filter(|a| matches!(a, Action::Log(Event::Excluded { .. })));
        assert_eq!((excluded.count(), flow.done(), flow.here()), (2, 0, Some(2)), "{trial}");
    }
}

#[test]
fn levels_are_in_the_log_before_their_trials_and_what_is_over_is_needed_no_more() {
    let study = all_methods();
    let mut disk = Disk::default();
    let flow = live(&study, &mut disk, |_| None);
    assert_eq!((flow.done(), flow.here()), (flow.total(), None));
    assert!(
        flow.total() + 100 < flow.places().len(),
        "{} of {}",
        flow.total(),
        flow.places().len()
    );
    let found = counting(&study, &disk);
    let order = order(&study);
    // Each level that is not planned was told of the first interval, once.
    let told: Vec<u32> = disk
        .events
        .iter()
        .filter_map(|e| if let Event::Level { trial, .. } = e { Some(*trial) } else { None })
        .collect();
    let adaptive = found.keys().filter(|p| order[**p].0.task.as_ref().unwrap().level.is_none());
    assert_eq!(told.len(), adaptive.count());
    for id in ["steps", "grid", "equal"] {
        let own = told.iter().filter(|trial| {
            let place = order[**trial as usize - 1].0.task.as_ref().unwrap();
            assert_eq!(place.interval, 1);
            place.task.as_str() == id
        });
        assert!(own.count() > 10, "{id}");
    }
    // Two modes of a setting from below and one from above.
    let right = found.iter().filter(|(place, (_, value))| {
        order[**place].0.task.as_ref().unwrap().task.as_str() == "equal" && *value == 3
    });
    assert_eq!(right.count(), 4);
    let ends = disk.events.iter().filter(|e| matches!(e, Event::Note { .. })).count();
    assert!(ends < 4, "{:?}", disk.events);
}

#[test]
fn a_session_that_ends_at_any_write_presents_the_same_levels_when_it_goes_on() {
    let study = all_methods();
    let mut whole = Disk::default();
    live(&study, &mut whole, |_| None);
    let expect = counting(&study, &whole);
    let writes = whole.files.len() + whole.events.len();
    for left in 0..writes {
        let mut disk = Disk { left: Some(left), ..Disk::default() };
        live(&study, &mut disk, |_| None);
        disk.left = None;
        let flow = live(&study, &mut disk, |_| None);
        assert_eq!(flow.done(), flow.total(), "{left}");
        assert_eq!(counting(&study, &disk), expect, "{left}");
    }
}

#[test]
fn a_level_that_does_not_follow_is_refused_with_both_sides() {
    let study = study(vec![task("steps", Asks::MoreLess, staircase())]);
    let mut disk = Disk::default();
    live(&study, &mut disk, |_| None);
    let levels = disk.events.iter_mut().filter_map(|event| match event {
        Event::Level { level, .. } => Some(level),
        _ => None,
    });
    *levels.last().unwrap() = level(7.77);
    let trials: Vec<PlannedTrial> = order(&study).into_iter().map(|(trial, _)| trial).collect();
    let numbers: Vec<u32> = trials.iter().map(|trial| trial.trial).collect();
    let mut tasks = Tasks::new(&study, &trials, RATE_HZ).unwrap();
    let why = tasks.replay(&numbers, &disk.events).unwrap_err();
    assert!(why.contains("the level 7.77, and by the plan and the answers before it"), "{why}");
}

#[test]
fn an_excluded_answer_does_not_count_and_levels_of_the_past_stay() {
    let study = study(vec![task("steps", Asks::MoreLess, staircase())]);
    let mut disk = Disk::default();
    // The fifth trial is excluded when ten are done.
    let mut said = false;
    let flow = live(&study, &mut disk, |flow| {
        let is_due = !said && flow.done() == 10 && *flow.phase() == Phase::Ready;
        said |= is_due;
        is_due.then(|| Input::Of(5, About::Exclude("the phone rang".into())))
    });
    assert!(said && flow.here().is_none());
    // What the log says leads to the same state, and every level in it follows.
    let (again, _) = opened(&study, &disk);
    assert_eq!((again.done(), again.total()), (flow.done(), flow.total()));
    let given = counting(&study, &disk);
    let before = disk.events.iter().find_map(|event| match event {
        Event::Level { trial: 5, level } => Some(*level),
        _ => None,
    });
    // If it was done again, at the same level.
    assert!(given.get(&4).is_none_or(|(level, _)| *level == before));
}

#[test]
fn ends_that_say_nothing_are_told_and_noted() {
    let always = |value: i16| {
        let study = study(vec![task("steps", Asks::MoreLess, staircase())]);
        let mut disk = Disk::default();
        let flow = live(&study, &mut disk, |flow| {
            matches!(flow.phase(), Phase::Question { .. }).then_some(Input::Answer(value))
        });
        let notes = disk.events.iter().filter_map(|event| match event {
            Event::Note { trial: Some(_), text } => Some(text.clone()),
            _ => None,
        });
        (flow.total(), notes.collect::<Vec<String>>())
    };
    let (total, notes) = always(1);
    assert_eq!((total, notes.len()), (120, 4));
    assert_eq!(
        notes[0],
        "task steps: it ends after 30 presentations with 0 of 4 reversals, without a threshold; it came to a bound: the \
         threshold may lie beyond"
    );
    assert_eq!(always(2).1.len(), 4);
}

#[test]
fn a_delay_is_given_in_whole_ticks_and_each_step_goes_on_from_there() {
    let mut late = task("late", Asks::MoreLess, staircase());
    late.varies = "delay_ms".to_owned();
    if let Method::Staircase(plan) = &mut late.method {
        (plan.up, plan.down) = (10.0, 12.0);
        plan.starts = levels(&[55.0, 30.0]);
        plan.bounds = [level(0.0), level(200.0)];
    }
    let study = study(vec![late]);
    let order: Vec<PlannedTrial> = order(&study).into_iter().map(|(trial, _)| trial).collect();
    let mut tasks = Tasks::new(&study, &order, 120.0).unwrap();
    // 55 ms are 6.6 ticks of 8.33 ms: seven are given.
    let mut given = Vec::new();
    for place in (0..order.len()).filter(|p| {
        let own = order[*p].task.as_ref().unwrap();
        own.track == 0 && order[*p].mode == order[0].mode
    }) {
        let Some(Event::Level { level, .. }) = tasks.begin(place, order[place].trial) else {
            break;
        };
        given.push(level.value());
        if given.len() == 4 {
            break;
        }
        tasks.answered(place, 2);
    }
    assert_eq!(given, [58.333333, 66.666667, 75.0, 83.333333]);
    assert_eq!(crate::tasks::refuse(&study, 1000.0), None);
    let why = crate::tasks::refuse(&study, 40.0).unwrap();
    assert!(
        why.contains("task late: at 40 Hz a step of delay_ms is less than a tick of 25 ms"),
        "{why}"
    );
}

#[test]
fn levels_that_cannot_be_given_are_refused_before_the_session() {
    let mut late = task("late", Asks::MoreLess, constant());
    late.varies = "delay_ms".to_owned();
    let why = crate::tasks::refuse(&study(vec![late.clone()]), 400.0).unwrap();
    assert!(
        why.contains("at 400 Hz delay_ms = 3 would be 2.5: give a whole number of ticks of 2.5 ms"),
        "{why}"
    );
    assert_eq!(crate::tasks::refuse(&study(vec![late.clone()]), 1000.0), None);
    late.varies = "force_n".to_owned();
    let why = crate::tasks::refuse(&study(vec![late]), 1000.0).unwrap();
    assert!(why.contains("force_n = 3 is no level of environment spring"), "{why}");
}

#[test]
fn feedback_is_told_only_where_something_is_right() {
    let told = |asks: Asks, at: f64, value: i16| {
        let mut one = task("stiffer", asks, Method::Constant { levels: levels(&[at]), trials: 1 });
        (one.feedback, one.catch) = (true, 0.25);
        let study = study(vec![one]);
        let mut disk = Disk::default();
        let mut found = None;
        live(&study, &mut disk, |flow| {
            found = found.or(flow.feedback());
            matches!(flow.phase(), Phase::Question { .. }).then_some(Input::Answer(value))
        });
        found
    };
    // The first presentation has the standard in its first interval: 1 + 1 is even.
    assert_eq!(told(Asks::OneOfTwo, 5.0, 2), Some(true));
    assert_eq!(told(Asks::OneOfTwo, 5.0, 1), Some(false));
    assert_eq!(told(Asks::MoreOfTwo, 5.0, 2), Some(true));
    assert_eq!(told(Asks::MoreOfTwo, 3.0, 2), Some(false));
    assert_eq!(told(Asks::MoreOfTwo, 4.0, 2), None);
    assert_eq!(told(Asks::YesNo, 5.0, 1), Some(true));
    assert_eq!(told(Asks::YesNo, 4.0, 1), Some(false));
    assert_eq!(told(Asks::MoreLess, 5.0, 1), None);
}
