//! One input at a time: what it changes, and which actions follow.

use super::about::note;
use super::{Action, EMERGENCY_STOP, End, Flow, GAP_S, Halt, Input, Phase, UNDER_WAY, refuse};
use zwidth_study::{Event, Given, Question};

impl Flow {
    /// Takes an input; what is to be done about it, in order.
    pub(crate) fn step(&mut self, input: Input) -> Vec<Action> {
        if self.phase == Phase::Left {
            return Vec::new();
        }
        match input {
            Input::Checked => self.device_checked(),
            Input::Homed => self.homed(),
            Input::Failed(why) => self.failed(why),
            Input::Unmet(what) => self.unmet(what),
            Input::Ended(end) => self.ended(end),
            Input::Elapsed(dt_s) => self.elapsed(dt_s),
            Input::Start => self.start(),
            Input::Yes => refuse("nothing waits for a yes"),
            Input::Answer(value) => self.answer(value),
            Input::AnswerThere(value) => self.answer_there(value),
            Input::Skip => self.skip(),
            Input::Hold => self.hold(),
            Input::Repeat => self.repeat(),
            Input::Exclude(reason) => self.exclude(reason),
            Input::Note(text) => note(self.subject(), text),
            Input::Of(trial, about) => self.about(trial, about),
            Input::Tell(what) => vec![Action::Tell(what)],
            Input::Stop => self.halt(Halt::Stop),
            Input::Quit => self.halt(Halt::Quit),
        }
    }

    fn device_checked(&mut self) -> Vec<Action> {
        if self.phase != Phase::Check {
            return Vec::new();
        }
        self.checked = true;
        if self.by_hand {
            self.phase = Phase::AtStop;
            return Vec::new();
        }
        self.home()
    }

    fn home(&mut self) -> Vec<Action> {
        self.phase = Phase::Homing;
        vec![Action::Home]
    }

    fn homed(&mut self) -> Vec<Action> {
        if self.phase != Phase::Homing {
            return Vec::new();
        }
        // A question that a stop left open comes before the next trial.
        self.ask_or_go_on()
    }

    /// Asks the question that is open, or goes on to what follows.
    fn ask_or_go_on(&mut self) -> Vec<Action> {
        match self.open {
            Some((place, question)) => self.ask(place, question, true),
            None => self.go_on(),
        }
    }

    /// Opens a question of the trial at `place`.
    pub(super) fn ask(&mut self, place: usize, question: usize, late: bool) -> Vec<Action> {
        self.shown_s = None;
        self.phase = Phase::Question { place, question, late };
        Vec::new()
    }

    /// Goes on after a question: to the trial's next one, or to what follows.
    fn after(&mut self, place: usize, question: usize) -> Vec<Action> {
        let next = question + 1;
        self.open = (next < self.places[place].questions.len()).then_some((place, next));
        self.ask_or_go_on()
    }

    /// Goes on to the pause, if some of it is left; to the next trial, with the device check before
    /// the first one; or to the end.
    pub(super) fn go_on(&mut self) -> Vec<Action> {
        self.phase = match self.here() {
            None => Phase::Done,
            Some(_) if !self.checked => Phase::Check,
            Some(_) if self.rest_s > 0.0 || self.held => Phase::Pause,
            // The second interval waits for nobody.
            Some(place) if self.has_begun() => return self.run(place),
            Some(_) => Phase::Ready,
        };
        if self.phase == Phase::Check { vec![Action::Check] } else { Vec::new() }
    }

    /// Holds the pause before the next trial, or releases it.
    fn hold(&mut self) -> Vec<Action> {
        if !matches!(self.phase, Phase::Pause | Phase::Ready) {
            return refuse("there is no pause to hold");
        }
        if self.is_between() {
            return refuse(UNDER_WAY);
        }
        self.held = !self.held;
        self.go_on()
    }

    fn failed(&mut self, why: String) -> Vec<Action> {
        match self.phase {
            // A trial ends with a reason of its own; after the last one no device is needed.
            Phase::Trial { .. } | Phase::Done => self.halt(Halt::Stop),
            Phase::Question { place, late: false, .. } => {
                [vec![self.finish(place, None)], self.stop(why)].concat()
            }
            _ => self.stop(why),
        }
    }

    /// A question is no rest: the pause is what comes after it.
    fn elapsed(&mut self, dt_s: f64) -> Vec<Action> {
        if matches!(self.phase, Phase::Question { .. }) {
            // The first time that goes by is the trial's: the question is shown from then on.
            self.shown_s = Some(self.shown_s.map_or(0.0, |shown_s| shown_s + dt_s.max(0.0)));
        }
        if !matches!(self.phase, Phase::Trial { .. } | Phase::Question { .. }) {
            // `max` takes the 0 where dt is not a number.
            self.rest_s = (self.rest_s - dt_s.max(0.0)).max(0.0);
        }
        if self.phase == Phase::Pause && self.rest_s == 0.0 { self.go_on() } else { Vec::new() }
    }

    fn start(&mut self) -> Vec<Action> {
        match (&self.phase, self.here()) {
            (Phase::Ready, Some(place)) => {
                // One that was excluded, and is offered, gives its place away only now.
                let again = match self.places[place].done {
                    true => self.supersede_presentation(place),
                    false => Vec::new(),
                };
                [again, self.run(place)].concat()
            }
            (Phase::AtStop, _) => self.home(),
            (Phase::Stopped { .. }, _) if self.checked => self.home(),
            (Phase::Stopped { .. }, _) => {
                self.phase = Phase::Check;
                vec![Action::Check]
            }
            (Phase::Pause, _) if self.held => self.hold(),
            (Phase::Pause, _) => refuse(format!("the pause has {:.1} s to go", self.rest_s)),
            (Phase::Question { place, question, .. }, _) => {
                let question = self.question(*place, *question);
                let range = question.map(|q| q.scale.range()).unwrap_or_default();
                refuse(format!("the question is open: answer it with {range}, or skip it"))
            }
            (Phase::Done, _) => refuse("every trial is done: quit"),
            (Phase::Trial { .. }, _) => refuse("a trial is running"),
            _ => refuse("the device is not ready yet"),
        }
    }

    /// Begins the trial of a place; the level of a presentation is in the log before.
    fn run(&mut self, place: usize) -> Vec<Action> {
        self.phase = Phase::Trial { halted: None };
        self.feedback = None;
        let trial = self.places[place].trial.clone();
        let level = self.tasks.begin(place, trial.trial).map(Action::Log);
        level.into_iter().chain([Action::Run(trial)]).collect()
    }

    /// Has a trial that did not meet the protocol done again after all others, if it is so planned and
    /// was not done too often.
    fn unmet(&mut self, what: String) -> Vec<Action> {
        let (Phase::Trial { .. }, Some(place)) = (&self.phase, self.here()) else {
            return Vec::new();
        };
        let is_of_task = self.tasks.is_presentation(place);
        let (most, slot) = (self.redo_unmet, &mut self.places[place]);
        if is_of_task || !slot.counts() || slot.unmet >= most {
            return Vec::new();
        }
        slot.unmet += 1;
        slot.excluded = true;
        let trial = slot.trial.trial;
        let told = format!(
            "trial {trial} does not count: it is done again after all others ({} of at most {most} times)",
            slot.unmet
        );
        vec![Action::Log(Event::Unmet { trial, what }), Action::Tell(told)]
    }

    fn ended(&mut self, end: End) -> Vec<Action> {
        let (Phase::Trial { halted }, Some(place)) = (self.phase.clone(), self.here()) else {
            return Vec::new();
        };
        self.last = Some(place);
        self.ended.insert(self.places[place].trial.trial);
        self.rest_s = if self.tasks.is_followed(place) { GAP_S } else { self.pause_s };
        match end {
            End::Cut(why) => {
                let trial = self.places[place].trial.trial;
                let finish = Action::Finish { trial, complete: false, likert: None };
                // With the interval before it, if there is one: it is presented again, too.
                let mut actions = vec![finish];
                actions.extend(self.supersede_presentation(place));
                actions.push(self.supersede(place));
                self.rest_s = self.pause_s;
                let then = match halted {
                    Some(Halt::Quit) => self.leave(),
                    _ => self.stop(why),
                };
                [actions, then].concat()
            }
            End::Complete if halted.is_none() && !self.places[place].questions.is_empty() => {
                self.ask(place, 0, false)
            }
            End::Complete => {
                let actions = vec![self.finish(place, None)];
                let then = match halted {
                    Some(halt) => self.halt_idle(halt),
                    None => self.go_on(),
                };
                [actions, then].concat()
            }
        }
    }

    /// The trial at `place` is done: its file can be made.
    pub(super) fn finish(&mut self, place: usize, likert: Option<Given>) -> Action {
        let slot = &mut self.places[place];
        slot.done = true;
        // The answer to the first question goes into the file; the others are asked after that.
        let open = usize::from(likert.is_some());
        self.open = (open < slot.questions.len()).then_some((place, open));
        Action::Finish { trial: slot.trial.trial, complete: true, likert }
    }

    /// Gives a place to a new trial, which is open.
    pub(super) fn supersede(&mut self, place: usize) -> Action {
        let by = self.next_number;
        self.next_number += 1;
        let slot = &mut self.places[place];
        let trial = std::mem::replace(&mut slot.trial.trial, by);
        slot.repeats = Some(trial);
        (slot.done, slot.excluded) = (false, false);
        self.tasks.forget(place);
        Action::Log(Event::Superseded { trial, by })
    }

    /// Gives the places of a presentation that are done to new trials; the place alone where it is of
    /// none.
    pub(super) fn supersede_presentation(&mut self, place: usize) -> Vec<Action> {
        let own = self.tasks.places(place).filter(|own| self.places[*own].done);
        own.collect::<Vec<_>>().into_iter().map(|own| self.supersede(own)).collect()
    }

    /// A presentation that is left between its intervals is done again.
    pub(super) fn abandon(&mut self) -> Vec<Action> {
        match self.here() {
            Some(place) if self.has_begun() => self.supersede_presentation(place),
            _ => Vec::new(),
        }
    }

    fn answer(&mut self, value: i16) -> Vec<Action> {
        let Phase::Question { place, question: index, late } = self.phase else {
            return refuse("no question is open");
        };
        let Some(question) = self.question(place, index) else {
            return refuse("no question is open");
        };
        if !question.scale.has(value) {
            return refuse(format!("{value} is not an answer: {}", question.scale.range()));
        }
        // Of a pair that is shown the other way round, the answer is still the number of the one that was chosen.
        let value = match question.is_pair() && question.reversed {
            true => question.scale.ends_together() - value,
            false => value,
        };
        let time_ms = self.took_ms();
        let action = if late {
            let trial = self.places[place].trial.trial;
            let question = question.id.clone();
            Action::Log(Event::Answer { trial, question, value: value.into(), time_ms })
        } else {
            self.finish(place, Some(Given { value, time_ms }))
        };
        let remark = self.answered_task(place, value);
        [vec![action], remark, self.after(place, index)].concat()
    }

    /// The answer at a place decides about the levels of its task; what is to be noted at their end.
    fn answered_task(&mut self, place: usize, value: i16) -> Vec<Action> {
        // One that is excluded does not count.
        if self.tasks.places(place).any(|own| self.places[own].excluded) {
            return Vec::new();
        }
        let remark = self.tasks.answered(place, value);
        self.feedback = match self.tasks.has_feedback(place) {
            true => self.tasks.is_right(place),
            false => None,
        };
        let trial = self.places[place].trial.trial;
        remark.map(|text| note(Some(trial), text)).unwrap_or_default()
    }

    /// Takes an answer from the participant's own screen; a remark on the trial says so.
    fn answer_there(&mut self, value: i16) -> Vec<Action> {
        // Before the answer, after which another question, or none, is open.
        let remark = match self.phase {
            Phase::Question { place, question, .. } => {
                self.question(place, question).map(|question| {
                    let text = format!("{} was answered at the participant's screen", question.id);
                    note(Some(self.places[place].trial.trial), text)
                })
            }
            _ => None,
        };
        let mut actions = self.answer(value);
        let is_refused = matches!(actions.first(), Some(Action::Refuse(_)));
        actions.extend(remark.filter(|_| !is_refused).into_iter().flatten());
        actions
    }

    /// From the question to now, ms. None where no time goes by, as in a simulated session.
    fn took_ms(&self) -> Option<u32> {
        // What is too long for it is held to the highest.
        self.shown_s.filter(|s| *s > 0.0).map(|s| (s * 1e3).round() as u32)
    }

    /// A question of the trial at `place`.
    fn question(&self, place: usize, index: usize) -> Option<&Question> {
        self.places[place].questions.get(index)
    }

    fn skip(&mut self) -> Vec<Action> {
        let Phase::Question { place, question, late } = self.phase else {
            return refuse("no question is open");
        };
        // A trial has no file before its first question is settled.
        let actions = if late { Vec::new() } else { vec![self.finish(place, None)] };
        [actions, self.after(place, question)].concat()
    }

    fn halt(&mut self, halt: Halt) -> Vec<Action> {
        match self.phase {
            Phase::Trial { ref mut halted } => {
                // A quit stays a quit, whatever is pressed after it.
                *halted = (*halted).max(Some(halt));
                vec![Action::Halt]
            }
            Phase::Question { place, late: false, .. } => {
                [vec![self.finish(place, None)], self.halt_idle(halt)].concat()
            }
            _ => self.halt_idle(halt),
        }
    }

    /// Stop or quit while no trial waits for its file.
    fn halt_idle(&mut self, halt: Halt) -> Vec<Action> {
        match halt {
            Halt::Quit => self.leave(),
            // What is done stays done: there is nothing to go on with after a stop.
            Halt::Stop if self.phase == Phase::Done => vec![Action::Off],
            Halt::Stop => self.stop(EMERGENCY_STOP.to_owned()),
        }
    }

    fn stop(&mut self, why: String) -> Vec<Action> {
        let again = self.abandon();
        self.phase = Phase::Stopped { why };
        [vec![Action::Off], again].concat()
    }

    fn leave(&mut self) -> Vec<Action> {
        let again = self.abandon();
        self.phase = Phase::Left;
        [vec![Action::Off], again, vec![Action::Leave]].concat()
    }
}
