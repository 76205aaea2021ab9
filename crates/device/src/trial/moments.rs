//! The moments of a trial that are announced to others, found among its samples.

use zwidth_study::{Flags, Moment};

/// Looks for the moments of a trial.
#[derive(Debug, Default)]
pub struct Moments {
    begun: bool,
    touched: bool,
}

impl Moments {
    /// The moments that the next sample is, by its flags: the trial's start, and its contact.
    pub fn of(&mut self, flags: Flags) -> impl Iterator<Item = Moment> + use<> {
        let starts = !self.begun;
        let touches = flags.has(Flags::PAST_WALL) && !self.touched;
        (self.begun, self.touched) = (true, self.touched || touches);
        let start = starts.then_some(Moment::Start);
        start.into_iter().chain(touches.then_some(Moment::Contact))
    }

    /// Its end after the last sample; none of a trial without one.
    pub fn end(&self) -> Option<Moment> {
        self.begun.then_some(Moment::End)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_and_contact_come_once_and_an_end_needs_a_start() {
        let flags = |past_wall| Flags::default().with(Flags::PAST_WALL, past_wall);
        let mut moments = Moments::default();
        assert_eq!(moments.end(), None);
        let found: Vec<Vec<Moment>> = [false, false, true, true, false, true]
            .map(|past_wall| moments.of(flags(past_wall)).collect())
            .into();
        let mut wanted = vec![Vec::new(); 6];
        (wanted[0], wanted[2]) = (vec![Moment::Start], vec![Moment::Contact]);
        assert_eq!(found, wanted);
        assert_eq!(moments.end(), Some(Moment::End));
        let both: Vec<Moment> = Moments::default().of(flags(true)).collect();
        assert_eq!(both, [Moment::Start, Moment::Contact]);
    }
}
