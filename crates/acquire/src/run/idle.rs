//! Between trials.

use super::{Runner, WAIT};
use crate::flow::{Input, Phase};
use crate::{AcquireError, Front as _};
use std::sync::atomic::Ordering;
use std::time::Duration;
use zwidth_device::{Station, Trip, watch};

/// A wait on a simulated clock goes this far past the pause's end, s: nothing rounds it to just
/// before.
const PAST_S: f64 = 1e-6;

impl Runner<'_> {
    /// Waits a little, or for the whole pause on a simulated clock; returns the inputs that came.
    pub(super) fn idle(&mut self) -> Result<Vec<Input>, AcquireError> {
        if self.options.quit.load(Ordering::SeqCst) {
            return Ok(vec![Input::Quit]);
        }
        if let Some(answer) = self.answer_of_participant() {
            return Ok(vec![Input::Answer(answer)]);
        }
        let mut inputs = Vec::new();
        let rests =
            *self.flow.phase() == Phase::Pause && !self.flow.is_held() && !self.options.live;
        let fault = match self.flow.phase() {
            Phase::Pause if rests => self.rest(),
            Phase::Ready | Phase::Question { .. } | Phase::Pause => self.attendant.fault(),
            // What is stopped or over has nothing to stop for.
            _ => None,
        };
        inputs.extend(fault.map(|trip| Input::Failed(trip.to_string())));
        inputs.extend(self.front.next(if rests { Duration::ZERO } else { WAIT })?);
        Ok(inputs)
    }

    /// What the device's participant answers to the open question: the first one as soon as the
    /// trial has ended, the others one by one.
    fn answer_of_participant(&mut self) -> Option<i16> {
        let first = self.answer.take();
        match *self.flow.phase() {
            Phase::Question { late: false, .. } => first,
            Phase::Question { place, question, .. } if question > 0 => {
                self.ask_participant(place, question)
            }
            _ => None,
        }
    }

    /// The pause on a simulated clock, over at once: reads on at 0 V, so that the turn of the shaft
    /// stays known. Without a voltage a large force or a late tick does no harm; a lost turn
    /// does, and is told.
    fn rest(&mut self) -> Option<Trip> {
        let until_s = self.attendant.now_s() + self.flow.rest_s() + PAST_S;
        let rate_hz = self.rate_hz;
        let stop = &*self.options.stop;
        let rested = self.attendant.ask(move |station| {
            let Station { device, clock, guard, .. } = station;
            let seen = watch(*device, *clock, guard, rate_hz, until_s, stop, &mut |_, _, _| {});
            clock.wait_until(until_s);
            seen
        });
        rested.unwrap_or_else(Err).err().filter(Trip::needs_homing)
    }
}
