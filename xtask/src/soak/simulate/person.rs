//! A simulated operator, who does what a seed says.

use super::world::Draw;
use std::time::Duration;
use zwidth_acquire::{About, AcquireError, Front, Input, Phase, View};

/// Stops after which even the most patient person leaves.
const MOST_STOPS: u32 = 6;

/// A person, and what they saw last.
pub(super) struct Person<'a> {
    draw: &'a mut Draw,
    /// Whether they do no more than start, answer and leave at the end.
    diligent: bool,
    phase: Phase,
    stops: u32,
    /// Trials that were shown as done, if nothing was asked for since that takes one back.
    pub(super) done: usize,
}

impl<'a> Person<'a> {
    pub(super) fn new(draw: &'a mut Draw, diligent: bool) -> Self {
        Self { draw, diligent, phase: Phase::Check, stops: 0, done: 0 }
    }

    fn ready(&mut self) -> Input {
        if self.diligent {
            return Input::Start;
        }
        match self.draw.below(60) {
            0 => Input::Note("a remark, with a\nline feed and \u{1b}[2J".to_owned()),
            1 => Input::Quit,
            2 => Input::Stop,
            3 => Input::Exclude("the phone rang".to_owned()),
            4 => Input::Repeat,
            5 => self.of_any_trial(),
            _ => Input::Start,
        }
    }

    /// Something about one of the first trials.
    fn of_any_trial(&mut self) -> Input {
        let trial = 1 + self.draw.below(8) as u32;
        let about = match self.draw.below(4) {
            0 => About::Exclude("the phone rang".to_owned()),
            1 => About::Note("slowly".to_owned()),
            2 => About::Repeat,
            _ => About::Ask,
        };
        Input::Of(trial, about)
    }

    fn question(&mut self) -> Input {
        match self.draw.below(20) {
            0 if !self.diligent => Input::Stop,
            1 if !self.diligent => Input::Quit,
            2 => Input::Skip,
            n => Input::Answer(1 + (n % 5) as i16),
        }
    }

    fn stopped(&mut self) -> Input {
        self.stops += 1;
        let leaves = self.stops > MOST_STOPS || (!self.diligent && self.draw.one_in(3));
        if leaves { Input::Quit } else { Input::Start }
    }
}

impl Front for Person<'_> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        self.phase.clone_from(&view.phase);
        self.done = view.done;
        Ok(())
    }

    fn next(&mut self, _wait: Duration) -> Result<Option<Input>, AcquireError> {
        let input = match self.phase {
            Phase::Ready => Some(self.ready()),
            Phase::Question { .. } => Some(self.question()),
            Phase::Stopped { .. } => Some(self.stopped()),
            Phase::Done => Some(if !self.diligent && self.draw.one_in(8) {
                Input::Repeat
            } else {
                Input::Quit
            }),
            Phase::Trial { .. } if !self.diligent && self.draw.one_in(400) => Some(Input::Stop),
            _ => None,
        };
        if matches!(input, Some(Input::Repeat | Input::Of(_, About::Repeat))) {
            self.done = 0; // a trial done again is done no longer
        }
        Ok(input)
    }
}
