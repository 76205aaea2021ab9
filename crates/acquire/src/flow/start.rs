//! A session set up: from nothing, or from what was recorded of it earlier.

use super::{Action, Flow, Phase, Place};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{Event, PlannedTrial, Question, QuestionId};

/// A trial of the session that has a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// Its number.
    pub trial: u32,
    /// Whether it ran to its end.
    pub complete: bool,
    /// Whether no question about it is left, whatever the log says about answers.
    pub settled: bool,
}

impl Flow {
    /// The session of that order, each trial with what is asked after it, as far as it was
    /// `recorded`; `events` are its log. Its first actions.
    ///
    /// A place is done if the trial that holds it last is complete. A trial that was cut short
    /// gives its place to a new one, right away; one that was excluded when nothing else is to be
    /// done.
    pub(crate) fn begin(
        order: Vec<(PlannedTrial, Vec<Question>)>,
        pause_s: f64,
        recorded: &[Recorded],
        events: &[Event],
    ) -> (Self, Vec<Action>) {
        let files: BTreeMap<u32, Recorded> = recorded.iter().map(|r| (r.trial, *r)).collect();
        let successors = successors(events);
        let excluded = excluded(events);
        let used = order.iter().map(|(t, _)| t.trial).chain(files.keys().copied());
        let next_number = used.chain(successors.values().copied()).max().unwrap_or(0) + 1;
        let places: Vec<Place> = order
            .into_iter()
            .map(|(trial, questions)| place(trial, questions, &successors, &files, &excluded))
            .collect();
        let mut flow = Self {
            phase: Phase::Check,
            last: places.iter().take_while(|p| p.done).count().checked_sub(1),
            places,
            open: None,
            ended: files.keys().copied().collect(),
            next_number,
            pause_s,
            rest_s: if files.is_empty() { 0.0 } else { pause_s },
            held: false,
            asked_s: None,
            checked: false,
            by_hand: false,
        };
        let mut actions = flow.replace_cut_trials(&files);
        flow.open = flow.last.and_then(|i| Some((i, flow.left_open(i, &files, events)?)));
        // Where nothing is left to do, nothing is checked, and no lever is homed.
        match flow.open {
            Some((place, asked)) if flow.here().is_none() => flow.ask(place, asked, true),
            _ => actions.extend(flow.go_on()),
        }
        (flow, actions)
    }

    /// The first question of the done trial at `place` that waits for its answer, if nothing was
    /// tried after the trial.
    fn left_open(
        &self,
        place: usize,
        files: &BTreeMap<u32, Recorded>,
        events: &[Event],
    ) -> Option<usize> {
        let Place { trial, questions, .. } = &self.places[place];
        files.get(&trial.trial).filter(|recorded| !recorded.settled)?;
        let is_answer = |event: &Event, id: &QuestionId| matches!(event, Event::Answer { trial: of, question, .. } if *of == trial.trial && question == id);
        let open =
            questions.iter().position(|q| !events.iter().any(|event| is_answer(event, &q.id)));
        let is_new = |next: usize| self.places[next].repeats.is_none() || self.places[next].done;
        open.filter(|_| self.here().is_none_or(is_new))
    }

    fn replace_cut_trials(&mut self, files: &BTreeMap<u32, Recorded>) -> Vec<Action> {
        let cut = |p: &Place| !p.done && files.contains_key(&p.trial.trial);
        let cut: Vec<usize> = (0..self.places.len()).filter(|i| cut(&self.places[*i])).collect();
        cut.into_iter().map(|i| self.supersede(i)).collect()
    }
}

/// Which trial took whose place. Numbers only grow; an event that says otherwise is not followed.
fn successors(events: &[Event]) -> BTreeMap<u32, u32> {
    let pair = |e: &Event| match e {
        Event::Superseded { trial, by } if by > trial => Some((*trial, *by)),
        _ => None,
    };
    events.iter().filter_map(pair).collect()
}

/// The trials that were excluded.
fn excluded(events: &[Event]) -> BTreeSet<u32> {
    let one = |event: &Event| match event {
        Event::Excluded { trial, .. } => Some(*trial),
        _ => None,
    };
    events.iter().filter_map(one).collect()
}

fn place(
    mut trial: PlannedTrial,
    questions: Vec<Question>,
    successors: &BTreeMap<u32, u32>,
    files: &BTreeMap<u32, Recorded>,
    excluded: &BTreeSet<u32>,
) -> Place {
    let mut repeats = None;
    while let Some(by) = successors.get(&trial.trial) {
        repeats = Some(trial.trial);
        trial.trial = *by;
    }
    let done = files.get(&trial.trial).is_some_and(|r| r.complete);
    let excluded = excluded.contains(&trial.trial);
    let place = Place { trial, repeats, questions, done, excluded: false };
    Place { excluded: excluded && place.counts(), ..place }
}
