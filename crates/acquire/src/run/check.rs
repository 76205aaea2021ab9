//! The device check: its steps one by one, each after a confirmation if somebody is asked for it.

use super::{Runner, WAIT, look};
use crate::flow::{EMERGENCY_STOP, Input};
use crate::{AcquireError, Front as _, Phase, step_words};
use std::sync::atomic::Ordering;
use zwidth_device::check::{Finding, Step, check_step, tare_n};
use zwidth_device::{Station, Trip};
use zwidth_study::{Check, Event};

/// What happens in a step while it runs, in words.
fn activity(step: Step) -> &'static str {
    match step {
        Step::Rest => "the sensors at rest, for 2 s",
        Step::Load(_) => "the known mass on the load cell, for 2 s",
        Step::Hand => "the lever all the way and back, for 4 s",
        Step::Actuators => "motor and brake, switched on for a moment",
    }
}

/// The decision of the operator on a step before it.
enum Word {
    Begin,
    LeaveOut,
    /// The check ends, with this input.
    End(Input),
}

impl Runner<'_> {
    /// The device check. The first one of a session goes into its record, which is laid down then;
    /// a later one into the log. What is not good enough is told, not forbidden: that is a
    /// person's to judge.
    pub(super) fn check(&mut self) -> Result<Input, AcquireError> {
        self.view.checks.clear();
        let outcome = self.go_through()?;
        self.view.step = None;
        let findings = match outcome {
            Ok(findings) => findings,
            Err(input) => return Ok(input),
        };
        if self.options.stop.load(Ordering::SeqCst) {
            // Cut short, it proves nothing.
            return Ok(Input::Failed(EMERGENCY_STOP.to_owned()));
        }
        for bad in findings.iter().filter(|f| !f.check.ok) {
            self.view.say(format!(
                "device check: {}: {}",
                look::check_words(&bad.check),
                bad.about
            ));
        }
        let checks: Vec<Check> = findings.into_iter().map(|f| f.check).collect();
        if !self.session.laid_down {
            self.session.record.checks = checks;
            let utc = (self.utc)(self.attendant.now_s());
            self.session.lay_down(self.plan, &self.files, &utc)?;
            self.remark()?;
        } else if !checks.is_empty() {
            let words: Vec<String> = checks.iter().map(look::check_words).collect();
            self.log(Event::Note {
                trial: None,
                text: format!("device check: {}", words.join("; ")),
            })?;
        }
        Ok(Input::Checked)
    }

    /// Goes through the steps one by one, each shown while it lasts; the findings, or the input that
    /// ended it.
    fn go_through(&mut self) -> Result<Result<Vec<Finding>, Input>, AcquireError> {
        let options = self.options;
        let mut findings = Vec::new();
        for (i, step) in options.steps.iter().enumerate() {
            let word = if options.ask { self.ask(*step)? } else { Word::Begin };
            match word {
                Word::Begin => {}
                Word::LeaveOut => continue,
                Word::End(input) => return Ok(Err(input)),
            }
            let place = format!("Step {} of {}", i + 1, options.steps.len());
            self.view.step = Some(format!("{place}: {}", activity(*step)));
            self.show()?;
            let more = match self.check_step(*step, tare_n(&findings)) {
                Ok(more) => more,
                Err(trip) => return Ok(Err(Input::Failed(format!("device check: {trip}")))),
            };
            self.view.checks.extend(more.iter().map(|f| look::check_line(&f.check)));
            findings.extend(more);
        }
        if options.steps.is_empty() {
            self.show()?;
        }
        Ok(Ok(findings))
    }

    fn check_step(&mut self, step: Step, tare_n: f64) -> Result<Vec<Finding>, Trip> {
        let calibration = &self.plan.calibration;
        let rate_hz = self.rate_hz;
        let stop = &*self.options.stop;
        self.attendant.ask(move |station| {
            let Station { device, clock, guard, .. } = station;
            check_step(*device, *clock, guard, calibration, rate_hz, (step, tare_n), stop)
        })?
    }

    /// Waits for the operator's decision; a step that moves the lever has a key of its own for it.
    fn ask(&mut self, step: Step) -> Result<Word, AcquireError> {
        let (what, moves) = step_words(step);
        loop {
            if self.options.quit.load(Ordering::SeqCst) {
                return Ok(Word::End(Input::Quit));
            }
            look::refresh(&mut self.view, &self.flow, self.plan, &self.session, &self.conditions);
            self.view.phase = Phase::Step { what: what.clone(), moves };
            self.front.show(&self.view)?;
            match self.front.next(WAIT)? {
                None => {}
                Some(Input::Start) if !moves => return Ok(Word::Begin),
                Some(Input::Yes) if moves => return Ok(Word::Begin),
                Some(Input::Skip) => return Ok(Word::LeaveOut),
                Some(Input::Stop) => {
                    return Ok(Word::End(Input::Failed(EMERGENCY_STOP.to_owned())));
                }
                Some(Input::Quit) => return Ok(Word::End(Input::Quit)),
                Some(Input::Tell(words)) => self.view.say(words),
                Some(Input::Start) => {
                    self.view.say("the lever will move: yes lets it, skip does not")
                }
                Some(_) => self.view.say("the device check comes first"),
            }
        }
    }
}
