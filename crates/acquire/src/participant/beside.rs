//! A session's front end, and a participant's screen beside it.

use super::door::Door;
use super::reception::Reception;
use super::sight::Sight;
use crate::{AcquireError, Front, Input, Phase, View};
use std::sync::Arc;
use std::time::Duration;
use zwidth_store::PortFile;

/// Another front end, and a participant's screen: it shows what the participant may see, and hands
/// over answers to the open question. Whatever becomes of the screen, the other front end goes on.
pub struct Beside<'a> {
    front: Box<dyn Front + 'a>,
    reception: Arc<Reception>,
    /// The way in, and the file by which screens find it. The file goes first.
    _way: Option<(PortFile, Door)>,
    /// The trial and the phase with the open question.
    open: Option<(Option<u32>, Phase)>,
    /// How many questions were opened.
    number: u64,
    /// Whether a screen was open at the last look.
    was_open: bool,
}

impl<'a> Beside<'a> {
    /// Beside that front end; the way in is kept as long.
    pub fn new(
        front: Box<dyn Front + 'a>,
        reception: Arc<Reception>,
        way: Option<(PortFile, Door)>,
    ) -> Self {
        Self { front, reception, _way: way, open: None, number: 0, was_open: false }
    }
}

impl Front for Beside<'_> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        let is_open = matches!(view.phase, Phase::Question { .. });
        let open =
            is_open.then(|| (view.trial.as_ref().map(|trial| trial.trial), view.phase.clone()));
        // Of another trial, too: the same words may be asked again.
        if open.is_some() && open != self.open {
            self.number += 1;
        }
        self.open = open;
        self.reception.show(&Sight::of(view, self.number));
        self.front.show(view)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        let is_open = self.reception.is_open();
        if is_open && !self.was_open {
            self.was_open = true;
            return Ok(Some(Input::Tell("the participant's screen is open".to_owned())));
        }
        // What a screen said before it went counts.
        if let Some(value) = self.reception.answer() {
            return Ok(Some(Input::AnswerThere(value)));
        }
        if self.was_open && !is_open {
            self.was_open = false;
            let closed = "the participant's screen was closed: answer here, or open it again";
            return Ok(Some(Input::Tell(closed.to_owned())));
        }
        self.front.next(wait)
    }
}

#[cfg(test)]
mod tests {
    use super::super::guest::Guest;
    use super::super::proof::Secret;
    use super::super::sight::Now;
    use super::super::sight::tests::telling;
    use super::super::wire::place_of;
    use super::*;
    use crate::Nobody;
    use zwidth_study::AnswerScale;

    const SOON: Duration = Duration::from_millis(1);

    fn question(text: &str) -> View {
        telling(Phase::Question { text: text.into(), scale: AnswerScale::FivePoint })
    }

    /// A session, and a screen that is in.
    fn both() -> (Beside<'static>, Guest, Door) {
        let door = Door::open(Secret::new([1; 32])).unwrap();
        let mut beside = Beside::new(Box::new(Nobody), door.reception(), None);
        let guest = enter(&door);
        assert_eq!(next(&mut beside), Input::Tell("the participant's screen is open".into()));
        (beside, guest, door)
    }

    fn enter(door: &Door) -> Guest {
        let (port, secret) = place_of(&door.place()).unwrap();
        Guest::enter(port, &secret).unwrap()
    }

    fn next(beside: &mut Beside<'_>) -> Input {
        loop {
            if let Some(input) = beside.next(SOON).unwrap() {
                return input;
            }
        }
    }

    /// The number of the question with this text, once the screen shows it.
    fn number(guest: &mut Guest, text: &str) -> u64 {
        loop {
            let sight = guest.next(SOON).unwrap();
            match sight.as_ref().and_then(Sight::question) {
                Some(asked) if asked.text == text => return asked.number,
                _ => {}
            }
        }
    }

    #[test]
    fn an_answer_at_the_participants_screen_is_handed_over() {
        let (mut beside, mut guest, _door) = both();
        beside.show(&question("one")).unwrap();
        let number = number(&mut guest, "one");
        guest.answer(number, 4).unwrap();
        assert_eq!(next(&mut beside), Input::AnswerThere(4));
    }

    #[test]
    fn an_answer_that_comes_after_its_question_is_none_to_the_next() {
        let (mut beside, mut guest, _door) = both();
        beside.show(&question("one")).unwrap();
        let one = number(&mut guest, "one");
        beside.show(&question("two")).unwrap();
        let two = number(&mut guest, "two");
        guest.answer(one, 1).unwrap();
        guest.answer(two, 5).unwrap();
        assert_eq!(next(&mut beside), Input::AnswerThere(5));
        beside.show(&telling(Phase::Ready)).unwrap();
        guest.answer(two, 2).unwrap();
        drop(guest);
        // Only that it went is heard.
        assert!(matches!(next(&mut beside), Input::Tell(told) if told.contains("was closed")));
    }

    #[test]
    fn a_question_that_is_asked_again_has_another_number() {
        let (mut beside, mut guest, _door) = both();
        beside.show(&question("one")).unwrap();
        let first = number(&mut guest, "one");
        beside.show(&question("one")).unwrap();
        assert_eq!(beside.number, first);
        beside.show(&telling(Phase::Ready)).unwrap();
        beside.show(&question("one")).unwrap();
        assert_ne!(beside.number, first);
    }

    #[test]
    fn the_session_goes_on_when_the_screen_is_gone_and_another_may_come() {
        let (mut beside, guest, door) = both();
        drop(guest);
        assert!(matches!(next(&mut beside), Input::Tell(told) if told.contains("was closed")));
        beside.show(&telling(Phase::Done)).unwrap();
        let mut guest = enter(&door);
        assert_eq!(guest.next(SOON).unwrap().map(|sight| sight.now), Some(Now::Done));
    }
}
