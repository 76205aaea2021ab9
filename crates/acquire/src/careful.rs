//! A session that runs by itself, with somebody who looks at each trial and repeats failed ones.

use crate::{AcquireError, Auto, Front, Input, Phase, View};
use std::time::Duration;

/// A trial in which the lever did not come this share of its way has failed.
const LEAST_WAY: f64 = 0.5;
/// So often a place is tried again, and a stopped session is gone on with.
const MOST_TRIES: u32 = 3;

/// [`Auto`], and somebody who has a trial done again in which the lever did not come half of its
/// way (to the wall, or the end of the work space), and goes on after a stop; three times each at
/// most.
#[derive(Debug)]
pub struct Careful<F> {
    auto: Auto<F>,
    /// A trial has begun and was not looked at yet.
    begun: bool,
    /// What is to be said next.
    says: Option<Input>,
    /// How often the place at hand was tried again.
    tries: u32,
    stops: u32,
}

impl<F: Front> Careful<F> {
    /// Before that front end.
    pub fn new(front: F) -> Self {
        Self { auto: Auto::new(front), begun: false, says: None, tries: 0, stops: 0 }
    }
}

impl<F: Front> Front for Careful<F> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        match view.phase {
            Phase::Trial { .. } => self.begun = true,
            Phase::Question { .. } | Phase::Pause { .. } | Phase::Ready | Phase::Done
                if self.begun =>
            {
                self.begun = false;
                if is_whole(view) || self.tries >= MOST_TRIES {
                    self.tries = 0;
                } else {
                    self.tries += 1;
                    self.says = Some(Input::Repeat);
                }
            }
            Phase::Stopped { .. } if self.begun => {
                self.begun = false;
                self.stops += 1;
                // After so many stops `Auto` ends the session.
                self.says = (self.stops <= MOST_TRIES).then_some(Input::Start);
            }
            _ => {}
        }
        self.auto.show(view)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        match self.says.take() {
            Some(input) => Ok(Some(input)),
            None => self.auto.next(wait),
        }
    }
}

/// Whether the lever came far enough.
fn is_whole(view: &View) -> bool {
    let (start_rad, end_rad) = view.theta_range_rad;
    let end_rad = view.wall_rad.map_or(end_rad, |wall_rad| wall_rad.min(end_rad));
    let least_rad = start_rad + LEAST_WAY * (end_rad - start_rad);
    view.trace.iter().any(|point| point.theta_rad >= least_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Nobody, Point};

    fn view(phase: Phase, top_rad: f64) -> View {
        let point = |theta_rad| Point { theta_rad, ..Point::default() };
        View {
            phase,
            theta_range_rad: (-0.8, 0.8),
            trace: [-0.8, top_rad, -0.8].map(point).into(),
            ..View::default()
        }
    }

    /// What is said after a trial in which the lever came so far.
    fn said(careful: &mut Careful<Nobody>, top_rad: f64) -> Option<Input> {
        let trial = Phase::Trial { t_s: 0.0, limit_s: 4.0 };
        careful.show(&view(trial, -0.8)).unwrap();
        careful.show(&view(Phase::Ready, top_rad)).unwrap();
        careful.next(Duration::ZERO).unwrap()
    }

    #[test]
    fn a_trial_that_did_not_come_half_way_is_done_again_three_times_at_most() {
        let mut careful = Careful::new(Nobody);
        assert_eq!(said(&mut careful, 0.1), Some(Input::Start));
        let again = [(); 4].map(|()| said(&mut careful, -0.1));
        let repeat = Some(Input::Repeat);
        assert_eq!(again, [repeat.clone(), repeat.clone(), repeat.clone(), Some(Input::Start)]);
        assert_eq!(said(&mut careful, -0.1), repeat);
    }

    #[test]
    fn a_trial_is_looked_at_once() {
        let mut careful = Careful::new(Nobody);
        assert_eq!(said(&mut careful, -0.1), Some(Input::Repeat));
        careful.show(&view(Phase::Ready, -0.1)).unwrap();
        assert_eq!(careful.next(Duration::ZERO).unwrap(), Some(Input::Start));
    }

    #[test]
    fn half_of_the_way_to_a_wall_is_enough() {
        let near = View { wall_rad: Some(-0.4), ..view(Phase::Ready, -0.55) };
        assert!(is_whole(&near) && !is_whole(&view(Phase::Ready, -0.55)));
    }

    #[test]
    fn it_goes_on_after_a_stop_but_not_for_ever() {
        let mut careful = Careful::new(Nobody);
        let mut stopped = || {
            careful.show(&view(Phase::Trial { t_s: 0.0, limit_s: 4.0 }, 0.0)).unwrap();
            careful.show(&view(Phase::Stopped { why: "a trip".to_owned() }, 0.0)).unwrap();
            careful.next(Duration::ZERO).unwrap()
        };
        let said = [(); 4].map(|()| stopped());
        assert_eq!(said[..3], [(); 3].map(|()| Some(Input::Start)));
        assert_eq!(said[3], Some(Input::Quit));
    }
}
