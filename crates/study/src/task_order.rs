//! The order of a task's presentations in a session.
//!
//! Levels and modes come in rounds: of constant stimuli each round has each level once in each mode, of staircases one
//! presentation of each track in each mode, all in an order drawn for the round. So what changes in the course of a
//! session (tiredness, learning) meets all of them alike. Settings of an adjustment come one after the other, in rounds of
//! the modes. Of two intervals each holds the standard equally often.

use crate::random::{below, shuffle};
use crate::{Method, Task, TaskLevel, TaskPlace};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Of so many presentations in a row of one track, half have the standard in the first interval: a track may end at any
/// time, and nobody knows when.
const BALANCED: usize = 4;

/// A presentation, before it has a number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Planned {
    /// By its number, from 0.
    mode: usize,
    track: u8,
    /// None where answers decide.
    level: Option<TaskLevel>,
    is_catch: bool,
}

/// The trials of a task in a session, in order: the mode's number and the place of each.
pub(crate) fn draw(task: &Task, modes: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, TaskPlace)> {
    let others = match &task.method {
        Method::Constant { levels, trials } => {
            let all = levels.iter().map(|level| (0, Some(*level))).collect();
            in_rounds(rng, modes, *trials, all)
        }
        Method::Staircase(plan) => {
            let tracks = (0..).zip(&plan.starts).map(|(track, _)| (track, None)).collect();
            in_rounds(rng, modes, plan.most_trials, tracks)
        }
        Method::QuestPlus { trials, .. } => in_rounds(rng, modes, *trials, vec![(0, None)]),
        Method::Adjustment { starts, settings, most_trials, .. } => {
            in_turn(rng, modes, starts, *settings, *most_trials)
        }
    };
    let presentations = with_catches(rng, task, modes, others);
    numbered(rng, task, &presentations)
}

/// Rounds in each of which each of these tracks and levels comes once in each mode.
fn in_rounds(
    rng: &mut ChaCha8Rng,
    modes: usize,
    rounds: u32,
    each: Vec<(u8, Option<TaskLevel>)>,
) -> Vec<Planned> {
    let mut all = Vec::new();
    for _ in 0..rounds {
        let of_mode = |mode| {
            each.iter().map(move |(track, level)| Planned {
                mode,
                track: *track,
                level: *level,
                is_catch: false,
            })
        };
        let mut round: Vec<Planned> = (0..modes).flat_map(of_mode).collect();
        shuffle(rng, &mut round);
        all.append(&mut round);
    }
    all
}

/// Settings one after the other, in rounds of the modes. In each mode they start below and above in turn; with which it
/// begins is drawn.
fn in_turn(
    rng: &mut ChaCha8Rng,
    modes: usize,
    starts: &[TaskLevel; 2],
    settings: u32,
    most_trials: u32,
) -> Vec<Planned> {
    let begins: Vec<usize> = (0..modes).map(|_| below(rng, 2)).collect();
    let mut all = Vec::new();
    for track in 0..u8::try_from(settings).unwrap_or(u8::MAX) {
        let mut round: Vec<usize> = (0..modes).collect();
        shuffle(rng, &mut round);
        for mode in round {
            let start = starts[(begins[mode] + usize::from(track)) % 2];
            let levels = (0..most_trials).map(|i| (i == 0).then_some(start));
            all.extend(levels.map(|level| Planned { mode, track, level, is_catch: false }));
        }
    }
    all
}

/// The presentations with those at the standard among them: one at a random place of each of as many stretches.
fn with_catches(
    rng: &mut ChaCha8Rng,
    task: &Task,
    modes: usize,
    others: Vec<Planned>,
) -> Vec<Planned> {
    let in_each_mode = usize::try_from(task.catches()).unwrap_or_default();
    let Some(standard) = task.standard.filter(|_| in_each_mode * modes > 0) else {
        return others;
    };
    let mut catches = Vec::new();
    for _ in 0..in_each_mode {
        let mut round: Vec<usize> = (0..modes).collect();
        shuffle(rng, &mut round);
        catches.append(&mut round);
    }
    let stretches = catches.len();
    let mut all = Vec::with_capacity(others.len() + stretches);
    for (i, mode) in catches.into_iter().enumerate() {
        let stretch = others.len() * i / stretches..others.len() * (i + 1) / stretches;
        let place = stretch.start + below(rng, stretch.len() + 1);
        all.extend_from_slice(&others[stretch.start..place]);
        all.push(Planned { mode, track: 0, level: Some(standard), is_catch: true });
        all.extend_from_slice(&others[place..stretch.end]);
    }
    all
}

/// The trials of presentations, with their numbers in each mode.
fn numbered(
    rng: &mut ChaCha8Rng,
    task: &Task,
    presentations: &[Planned],
) -> Vec<(usize, TaskPlace)> {
    let intervals = task.asks.intervals();
    let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
    let mut standards = Standards::of(task);
    let mut trials = Vec::with_capacity(presentations.len() * usize::from(intervals));
    for planned in presentations {
        let number = numbers.entry(planned.mode).or_default();
        *number += 1;
        let standard = (intervals > 1).then(|| standards.next(rng, planned));
        trials.extend((1..=intervals).map(|interval| {
            let place = TaskPlace {
                task: task.id.clone(),
                presentation: *number,
                track: planned.track,
                interval,
                level: planned.level,
                is_standard: standard.map(|standard| standard == interval),
            };
            (planned.mode, place)
        }));
    }
    trials
}

/// Which interval of two holds the standard: each equally often in each mode at each level, or on each track.
struct Standards {
    /// Of how many in a row half have it in each interval: all of a level, or [`BALANCED`] of a track.
    in_a_row: usize,
    /// What was drawn and not taken yet, by mode, track, level and whether it is at the standard.
    left: BTreeMap<(usize, u8, Option<TaskLevel>, bool), Vec<u8>>,
}

impl Standards {
    fn of(task: &Task) -> Self {
        let in_a_row = match &task.method {
            Method::Constant { trials, .. } => *trials as usize,
            _ => BALANCED,
        };
        Self { in_a_row, left: BTreeMap::new() }
    }

    /// The interval that holds the standard of the next presentation.
    fn next(&mut self, rng: &mut ChaCha8Rng, planned: &Planned) -> u8 {
        let n = if planned.is_catch { BALANCED } else { self.in_a_row };
        let key = (planned.mode, planned.track, planned.level, planned.is_catch);
        let left = self.left.entry(key).or_default();
        if left.is_empty() {
            // Of an odd number, chance says which interval has one more.
            let first = below(rng, 2);
            left.extend((0..n).map(|i| if (i + first).is_multiple_of(2) { 1 } else { 2 }));
            shuffle(rng, left);
        }
        // Never empty: a round has at least one.
        left.pop().unwrap_or(1)
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{CONSTANT, with_task};
    use crate::{Kind, PlannedTrial, Study, order};
    use std::collections::BTreeMap;

    fn study(method: &str) -> Study {
        let from = CONSTANT.find("method").unwrap();
        with_task(&format!("{}{method}", &CONSTANT[..from])).unwrap()
    }

    const STAIRCASE: &str = "method = \"staircase\"\nrule = \"1up2down\"\nstart = [7.0, 4.2]\nup = 0.4\nlowest = 4.1\n\
                             highest = 8.0\nmost_trials = 30";
    const ADJUSTMENT: &str = "method = \"adjustment\"\nstarts = [2.0, 6.0]\nstep = 0.2\nlowest = 1.0\nhighest = 7.0\n\
                              settings = 6\nmost_trials = 10";

    fn drawn(study: &Study) -> Vec<PlannedTrial> {
        let trials = order::draw(study, 1, 1, 7);
        trials
            .into_iter()
            .filter(|t| t.kind == Kind::Trial && t.environment.as_str() == "spring")
            .collect()
    }

    /// How often each of something came.
    fn counts<T: Ord>(all: impl Iterator<Item = T>) -> BTreeMap<T, u32> {
        let mut counts = BTreeMap::new();
        all.for_each(|what| *counts.entry(what).or_default() += 1);
        counts
    }

    #[test]
    fn each_round_has_each_level_once_in_each_mode_and_either_interval_holds_the_standard() {
        let trials = drawn(&with_task(CONSTANT).unwrap());
        assert_eq!(trials.len(), 7 * 20 * 3 * 2);
        for (at, pair) in trials.chunks(2).enumerate() {
            let [first, last] = pair else { panic!() };
            let [a, b] = [first, last].map(|t| t.task.clone().unwrap());
            assert_eq!((a.interval, b.interval, &first.mode), (1, 2, &last.mode), "{at}");
            assert!(a.is_of_presentation_of(&b) && a.level == b.level);
            assert_ne!(a.is_standard.unwrap(), b.is_standard.unwrap());
        }
        for round in trials.chunks(7 * 3 * 2) {
            let each = counts(round.iter().map(|t| (&t.mode, t.task.as_ref().unwrap().level)));
            assert_eq!((each.len(), each.into_values().all(|n| n == 2)), (21, true));
        }
        let standards = counts(trials.iter().map(|t| {
            let place = t.task.as_ref().unwrap();
            (&t.mode, place.level, place.interval, place.is_standard)
        }));
        assert!(standards.len() == 84 && standards.into_values().all(|n| n == 10));
        let mut orders = trials.chunks(42).map(|round| {
            round
                .iter()
                .map(|t| (t.mode.clone(), t.task.as_ref().unwrap().level))
                .collect::<Vec<_>>()
        });
        let first = orders.next().unwrap();
        assert!(orders.all(|other| other != first), "rounds are drawn one by one");
    }

    #[test]
    fn of_an_odd_number_the_intervals_differ_by_one() {
        let study = with_task(&CONSTANT.replace("trials = 20", "trials = 5")).unwrap();
        let trials = drawn(&study);
        let first = trials
            .iter()
            .filter_map(|t| t.task.as_ref())
            .zip(&trials)
            .filter(|(p, _)| p.interval == 1);
        let holds = counts(first.map(|(p, t)| (&t.mode, p.level, p.is_standard)));
        assert!(holds.len() == 42 && holds.into_values().all(|n| n == 2 || n == 3));
    }

    #[test]
    fn presentations_are_counted_in_each_mode_and_trials_from_1_on() {
        let study = with_task(CONSTANT).unwrap();
        let all = order::draw(&study, 1, 1, 7);
        assert!(all.iter().zip(1..).all(|(t, number)| t.trial == number));
        let practice = all.iter().filter(|t| t.kind == Kind::Familiarisation);
        assert!(practice.clone().count() == 3 && practice.clone().all(|t| t.task.is_none()));
        let wall =
            all.iter().filter(|t| t.environment.as_str() == "spring_wall" && t.kind == Kind::Trial);
        assert!(wall.clone().count() == 18 && wall.clone().all(|t| t.task.is_none()));
        for mode in &study.modes {
            let of_mode = all.iter().filter(|t| t.mode == mode.id).filter_map(|t| t.task.as_ref());
            let numbers: Vec<u32> = of_mode.map(|place| place.presentation).collect();
            assert_eq!(numbers, (1..=140).flat_map(|n| [n, n]).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_seed_draws_one_order_and_every_session_has_its_own() {
        let study = with_task(CONSTANT).unwrap();
        let draw = |person, session, seed| order::draw(&study, person, session, seed);
        assert_eq!(draw(1, 1, 7), draw(1, 1, 7));
        for other in [draw(2, 1, 7), draw(1, 2, 7), draw(1, 1, 8)] {
            assert_ne!(draw(1, 1, 7), other);
        }
        // A study without tasks has the order that it always had.
        let without = Study { tasks: Vec::new(), ..study.clone() };
        let of_wall = |study: &Study| {
            let all = order::draw(study, 1, 1, 7).into_iter();
            all.filter(|t| t.environment.as_str() == "spring_wall")
                .map(|t| t.mode)
                .collect::<Vec<_>>()
        };
        assert_eq!(of_wall(&without), of_wall(&study));
    }

    #[test]
    fn staircases_take_turns_without_levels_and_the_standard_is_balanced_all_along() {
        let trials = drawn(&study(STAIRCASE));
        assert_eq!(trials.len(), 2 * 30 * 3 * 2);
        for round in trials.chunks(2 * 3 * 2) {
            let each = counts(round.iter().map(|t| (&t.mode, t.task.as_ref().unwrap().track)));
            assert!(each.len() == 6 && each.into_values().all(|n| n == 2));
        }
        assert!(trials.iter().all(|t| t.task.as_ref().unwrap().level.is_none()));
        let mode = trials[0].mode.clone();
        let first = trials.iter().filter(|t| t.mode == mode).filter_map(|t| t.task.as_ref());
        let first: Vec<bool> = first
            .filter(|place| place.track == 1 && place.interval == 1)
            .map(|place| place.is_standard.unwrap())
            .collect();
        for four in first.chunks_exact(4) {
            assert_eq!(four.iter().filter(|holds| **holds).count(), 2);
        }
    }

    #[test]
    fn presentations_at_the_standard_are_spread_over_the_session_and_the_modes() {
        let study = with_task(&format!("{CONSTANT}\ncatch = 0.1")).unwrap();
        let trials = drawn(&study);
        assert_eq!(trials.len(), (140 + 16) * 3 * 2);
        let standard = study.tasks[0].standard;
        let at_standard =
            counts(trials.iter().map(|t| (&t.mode, t.task.as_ref().unwrap().level == standard)));
        assert!(
            at_standard
                .into_iter()
                .all(|((_, is_at), n)| n == if is_at { 2 * 36 } else { 2 * 120 })
        );
        let adaptive = drawn(
            &with_task(&format!(
                "{}{STAIRCASE}\ncatch = 0.2",
                &CONSTANT[..CONSTANT.find("method").unwrap()]
            ))
            .unwrap(),
        );
        let places: Vec<usize> = adaptive
            .iter()
            .enumerate()
            .filter(|(_, t)| {
                t.task.as_ref().is_some_and(|place| place.level.is_some() && place.interval == 1)
            })
            .map(|(i, _)| i)
            .collect();
        assert_eq!(places.len(), 15 * 3);
        let stretch = adaptive.len() / places.len();
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] <= 2 * stretch + 2), "{places:?}");
    }

    #[test]
    fn settings_start_below_and_above_in_turn() {
        let text = format!("{}{ADJUSTMENT}", &CONSTANT[..CONSTANT.find("method").unwrap()])
            .replace("2ifc", "set");
        let study = with_task(&text).unwrap();
        let trials = drawn(&study);
        assert_eq!(trials.len(), 6 * 10 * 3);
        for setting in trials.chunks(10) {
            let places: Vec<_> = setting.iter().map(|t| t.task.as_ref().unwrap()).collect();
            assert!(
                places[0].level.is_some() && places[1..].iter().all(|place| place.level.is_none())
            );
            assert!(
                places
                    .iter()
                    .all(|place| place.track == places[0].track && place.is_standard.is_none())
            );
        }
        for mode in &study.modes {
            let of_mode =
                trials.iter().filter(|t| t.mode == mode.id).filter_map(|t| t.task.as_ref());
            let starts: Vec<_> = of_mode.filter_map(|place| place.level).collect();
            assert_eq!(starts.len(), 6);
            assert!(starts.windows(2).all(|pair| pair[0] != pair[1]), "{starts:?}");
        }
    }
}
