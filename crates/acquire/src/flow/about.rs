//! What is done with a trial that ended: it is excluded, repeated, asked about again, or annotated.

use super::{About, Action, Flow, Phase, UNDER_WAY, refuse};
use zwidth_study::Event;

impl Flow {
    /// Does what is requested about the trial of that number.
    pub(super) fn about(&mut self, trial: u32, about: About) -> Vec<Action> {
        match about {
            About::Note(_) if !self.has_trial(trial) => {
                refuse(format!("there is no trial {trial}"))
            }
            About::Note(text) => note(Some(trial), text),
            _ if matches!(self.phase, Phase::Trial { .. }) => {
                refuse("a trial is running: that can be asked for when it has ended")
            }
            _ if self.is_between() => refuse(UNDER_WAY),
            _ if !self.ended.contains(&trial) => {
                refuse(format!("there is no trial {trial} that has ended"))
            }
            About::Exclude(reason) => self.exclude_trial(trial, reason),
            About::Repeat => {
                self.place_of(trial).map_or_else(refuse, |place| self.repeat_at(place))
            }
            About::Ask => self.place_of(trial).map_or_else(refuse, |place| self.ask_again(place)),
        }
    }

    /// Whether the session has a trial of that number.
    fn has_trial(&self, trial: u32) -> bool {
        self.ended.contains(&trial) || self.places.iter().any(|p| p.trial.trial == trial)
    }

    /// The place that a trial holds; the error says to which trial it gave the place.
    fn place_of(&self, trial: u32) -> Result<usize, String> {
        let holder = self.places.iter().position(|p| p.trial.trial == trial);
        holder.ok_or_else(|| match self.places.iter().find(|p| p.repeats == Some(trial)) {
            Some(p) if !p.done => format!("trial {trial} is to be done again already"),
            Some(p) => format!("trial {trial} was done again as trial {}", p.trial.trial),
            None => format!("trial {trial} was done again"),
        })
    }

    /// Has the last trial done again.
    pub(super) fn repeat(&mut self) -> Vec<Action> {
        if matches!(self.phase, Phase::Trial { .. }) {
            return refuse("a trial is running: stop it first; it is then done again");
        }
        if self.is_between() {
            // Nothing was asked yet: the presentation begins again, after a pause as after others.
            let again = self.abandon();
            self.rest_s = self.rest_s.max(self.pause_s);
            return [again, self.go_on()].concat();
        }
        match self.last {
            Some(place) => self.repeat_at(place),
            None => refuse("there is no trial to do again yet"),
        }
    }

    fn repeat_at(&mut self, place: usize) -> Vec<Action> {
        // With the other interval of its presentation.
        let own = self.tasks.places(place);
        // The trial whose first question is open has no file yet.
        let waits = matches!(self.phase, Phase::Question { place: open, late: false, .. } if own.contains(&open));
        let mut actions: Vec<Action> =
            waits.then(|| self.finish(own.end - 1, None)).into_iter().collect();
        if !self.places[place].done {
            let Some(trial) = self.places[place].repeats else {
                return refuse("it is open anyway");
            };
            return refuse(format!("trial {trial} is to be done again already"));
        }
        actions.extend(self.supersede_presentation(place));
        // What was left to ask about the trial before is asked about the new one.
        self.open = self.open.filter(|(open, _)| !own.contains(open));
        let asks_other =
            matches!(self.phase, Phase::Question { place: open, .. } if !own.contains(&open));
        if !asks_other && matches!(self.phase, Phase::Question { .. } | Phase::Ready | Phase::Done)
        {
            actions.extend(self.go_on());
        }
        actions
    }

    /// Excludes the last trial.
    pub(super) fn exclude(&mut self, reason: String) -> Vec<Action> {
        if matches!(self.phase, Phase::Trial { .. }) {
            return refuse("a trial is running: exclude it when it has ended");
        }
        if self.is_between() {
            return refuse(UNDER_WAY);
        }
        match self.subject() {
            Some(trial) => self.exclude_trial(trial, reason),
            None => refuse("there is no trial to exclude yet"),
        }
    }

    fn exclude_trial(&mut self, trial: u32, reason: String) -> Vec<Action> {
        let reason = reason.trim().to_owned();
        if reason.is_empty() {
            return refuse("an exclusion needs its reason");
        }
        let mut actions = vec![Action::Log(Event::Excluded { trial, reason: reason.clone() })];
        // One that was done again already has no place to lose.
        let place = self.place_of(trial).ok().filter(|place| self.places[*place].counts());
        if let Some(place) = place {
            // A presentation counts whole or not at all.
            for own in self.tasks.places(place) {
                let other = self.places[own].trial.trial;
                if other != trial && !self.places[own].excluded {
                    let reason = format!("{reason} (trial {trial} of the same presentation)");
                    actions.push(Action::Log(Event::Excluded { trial: other, reason }));
                }
                self.places[own].excluded = true;
                self.tasks.forget(own);
            }
            actions.push(Action::Tell(format!(
                "trial {trial} is missing now: it is done again at the end, or right away if it is repeated"
            )));
        }
        if self.phase == Phase::Done {
            actions.extend(self.go_on());
        }
        actions
    }

    /// Asks the questions of a trial once more. The event of an answer takes the place of the one
    /// before, which stays where it was kept.
    fn ask_again(&mut self, place: usize) -> Vec<Action> {
        match self.phase {
            Phase::Question { .. } => refuse("a question is open: answer it first, or skip it"),
            Phase::Ready | Phase::Pause | Phase::Done
                if self.places[place].questions.is_empty() =>
            {
                refuse("nothing is asked about that trial")
            }
            Phase::Ready | Phase::Pause | Phase::Done if self.places[place].done => {
                self.ask(place, 0, true)
            }
            Phase::Ready | Phase::Pause | Phase::Done => refuse("that trial is to be done again"),
            _ => refuse("the session is not ready for a question"),
        }
    }
}

/// A remark on a trial, or on the session.
pub(super) fn note(trial: Option<u32>, text: String) -> Vec<Action> {
    match text.trim() {
        "" => refuse("the note is empty"),
        text => vec![Action::Log(Event::Note { trial, text: text.to_owned() })],
    }
}
