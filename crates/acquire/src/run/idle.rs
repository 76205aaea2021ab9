//! Between trials.

use super::{Runner, WAIT};
use crate::AcquireError;
use crate::flow::{Input, Phase};
use std::sync::atomic::Ordering;
use std::time::Duration;
use zwidth_device::{TrialPlan, Trip, watch};

/// A wait on a simulated clock goes this far past the pause's end, s: nothing rounds it to just before.
const PAST_S: f64 = 1e-6;

impl Runner<'_> {
    /// Waits a little, reading on, or for as long as the pause is on a simulated clock; what came of it.
    pub(super) fn idle(&mut self) -> Result<Vec<Input>, AcquireError> {
        if self.options.quit.load(Ordering::SeqCst) {
            return Ok(vec![Input::Quit]);
        }
        if let (Phase::Question { late: false, .. }, Some(answer)) = (self.flow.phase(), self.answer.take()) {
            return Ok(vec![Input::Answer(answer)]);
        }
        let mut inputs = Vec::new();
        let watched = self.watch()?;
        inputs.extend(watched.failed);
        let wait = if watched.waited { Duration::ZERO } else { WAIT };
        inputs.extend(self.parts.front.next(wait)?);
        Ok(inputs)
    }

    /// Reads on at 0 V while the turn of the shaft is to stay known.
    fn watch(&mut self) -> Result<Watched, AcquireError> {
        let wait_s = match (self.flow.phase(), self.options.live) {
            (Phase::Pause, false) => self.flow.rest_s() + PAST_S,
            (Phase::Ready | Phase::Question { .. } | Phase::Pause, true) => WAIT.as_secs_f64(),
            _ => return Ok(Watched::default()),
        };
        let until_s = self.parts.clock.now_s() + wait_s;
        let rate_hz = self.rate_hz()?;
        let (device, clock, stop) = (&mut *self.parts.device, &mut *self.parts.clock, &*self.options.stop);
        let seen = watch(device, clock, &mut self.guard, rate_hz, until_s, stop, &mut |_, _, _| {});
        self.parts.clock.wait_until(until_s);
        // Without a voltage a large force or a late tick does no harm; a lost turn does.
        let failed = seen.err().filter(Trip::needs_homing).map(|trip| Input::Failed(trip.to_string()));
        Ok(Watched { waited: true, failed })
    }

    /// The rate of the loop: the study's, or the device's if that is lower.
    pub(super) fn rate_hz(&self) -> Result<f64, AcquireError> {
        let study = &self.plan.study;
        let capabilities = self.parts.device.capabilities();
        let Some(environment) = study.environments.first() else { return Ok(capabilities.rate_hz) };
        Ok(TrialPlan::new(study, environment, 0, capabilities)?.rate_hz)
    }
}

/// What came of reading on.
#[derive(Default)]
struct Watched {
    waited: bool,
    failed: Option<Input>,
}
