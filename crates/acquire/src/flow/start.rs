//! A session set up: from nothing, or from what was recorded of it earlier.

use super::{Action, Flow, Phase, Place};
use crate::tasks::Tasks;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{Event, PlannedTrial, Question};

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
    /// done. A presentation of which one interval is not done is done again, and so is the last one
    /// if nobody answered it: what was felt is forgotten by now. `tasks` have followed the log.
    pub(crate) fn begin(
        order: Vec<(PlannedTrial, Vec<Question>)>,
        tasks: Tasks,
        pause_s: f64,
        recorded: &[Recorded],
        events: &[Event],
    ) -> (Self, Vec<Action>) {
        let files: BTreeMap<u32, Recorded> = recorded.iter().map(|r| (r.trial, *r)).collect();
        let mut successors = BTreeMap::new();
        let mut excluded = BTreeSet::new();
        let mut unmet = BTreeSet::new();
        for event in events {
            match event {
                // Numbers only grow; an event that says otherwise is not followed.
                Event::Superseded { trial, by } if by > trial => {
                    successors.insert(*trial, *by);
                }
                Event::Excluded { trial, .. } => _ = excluded.insert(*trial),
                Event::Unmet { trial, .. } => _ = unmet.insert(*trial),
                _ => {}
            }
        }
        // Of files and of the log, too: no number is used twice, whatever one of them lacks.
        let used = order.iter().map(|(t, _)| t.trial).chain(files.keys().copied());
        let next_number = used.chain(successors.values().copied()).max().unwrap_or(0) + 1;
        let places: Vec<Place> = order
            .into_iter()
            .map(|(trial, questions)| {
                place(trial, questions, &successors, &files, &excluded, &unmet)
            })
            .collect();
        let mut flow = Self {
            phase: Phase::Check,
            last: None,
            places,
            tasks,
            feedback: None,
            open: None,
            ended: files.keys().copied().collect(),
            next_number,
            pause_s,
            redo_unmet: 0,
            // The last trial of an earlier life may have ended just now.
            rest_s: if files.is_empty() { 0.0 } else { pause_s },
            held: false,
            shown_s: None,
            checked: false,
            by_hand: false,
        };
        let first_open =
            (0..flow.places.len()).find(|i| !flow.places[*i].done && flow.tasks.is_needed(*i));
        let before = first_open.unwrap_or(flow.places.len());
        flow.last = (0..before).rfind(|i| flow.places[*i].done);
        let mut actions = Vec::new();
        for i in 0..flow.places.len() {
            let own = flow.tasks.places(i);
            // What is excluded of a presentation is all of it.
            flow.places[i].excluded |= own.clone().any(|other| flow.places[other].excluded);
            let Place { trial, done, .. } = &flow.places[i];
            let is_cut = !done && files.contains_key(&trial.trial);
            if is_cut || (*done && own.clone().any(|other| !flow.places[other].done)) {
                // It was cut short, and gives its place to a new trial.
                actions.push(flow.supersede(i));
            }
        }
        if let Some(last) = flow.last.filter(|last| flow.is_unanswered(*last, &files)) {
            actions.extend(flow.supersede_presentation(last));
        }
        flow.open = flow.last.and_then(|i| Some((i, flow.left_open(i, &files, events)?)));
        // Where nothing is left to do, nothing is checked, and no lever is homed.
        match flow.open {
            Some((place, question)) if flow.here().is_none() => {
                actions.extend(flow.ask(place, question, true));
            }
            _ => actions.extend(flow.go_on()),
        }
        (flow, actions)
    }

    /// Whether the presentation at a place is whole and counts, and nobody answered it.
    fn is_unanswered(&self, place: usize, files: &BTreeMap<u32, Recorded>) -> bool {
        let Place { trial, excluded, .. } = &self.places[place];
        let is_settled = files.get(&trial.trial).is_some_and(|recorded| recorded.settled);
        self.tasks.awaits(place) && !excluded && !is_settled
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
        let answers = events.iter().filter_map(|event| match event {
            Event::Answer { trial: subject, question, .. } => {
                (*subject == trial.trial).then_some(question)
            }
            _ => None,
        });
        let answered: BTreeSet<_> = answers.collect();
        let open = questions.iter().position(|question| !answered.contains(&question.id));
        // A repeat that waits means that something was tried after this trial.
        let next = self.here().map(|next| &self.places[next]);
        open.filter(|_| next.is_none_or(|next| next.repeats.is_none() || next.done))
    }
}

/// A place of the order with the trial that holds it last.
fn place(
    mut trial: PlannedTrial,
    questions: Vec<Question>,
    successors: &BTreeMap<u32, u32>,
    files: &BTreeMap<u32, Recorded>,
    excluded: &BTreeSet<u32>,
    unmet: &BTreeSet<u32>,
) -> Place {
    let mut repeats = None;
    let mut of_unmet = u32::from(unmet.contains(&trial.trial));
    // Numbers grow from one to the next, so that this ends.
    while let Some(by) = successors.get(&trial.trial) {
        repeats = Some(trial.trial);
        trial.trial = *by;
        of_unmet += u32::from(unmet.contains(by));
    }
    let done = files.get(&trial.trial).is_some_and(|r| r.complete);
    let excluded = excluded.contains(&trial.trial) || unmet.contains(&trial.trial);
    let place = Place { trial, repeats, questions, done, excluded: false, unmet: of_unmet };
    Place { excluded: excluded && place.counts(), ..place }
}
