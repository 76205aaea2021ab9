//! One trial: run, written to the journal, shown, and made a file.

use super::mark::Marking;
use super::{Options, Ran, Runner, look};
use crate::course::Conditions;
use crate::flow::{Action, EMERGENCY_STOP, End, Flow, Input};
use crate::plan::Plan;
use crate::session::Session;
use crate::tape::Tape;
use crate::view::Point;
use crate::{AcquireError, Front, View};
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use zwidth_device::{
    Controller, Histogram, Judged, Station, Timing, TrialEnd, TrialPlan, TrialRun, TrialTask, Trip,
    watch,
};
use zwidth_store::{Entered, Files, Journal, OpenSession, Protocol, TrialFile};
use zwidth_study::{
    Environment, Event, Flags, Given, Mode, PlannedTrial, Presented, Sample, Study,
};

/// Why a trial was cut that a signal ended.
const SIGNAL: &str = "a signal ended the program";
/// Why one was cut whose terminal is gone.
const GONE: &str = "the terminal is gone";

/// How often the screen is drawn while a trial runs: more than a person follows.
const FRAME: Duration = Duration::from_millis(50);

/// Longest wait for the lever to come back to its start, s.
const LEVER_BACK_S: f64 = 5.0;
/// This close to its stop the lever is at its start, rad: 5°, what friction may leave of a spring's
/// way back.
const AT_START_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Between two looks at the lever, s.
const LOOK_S: f64 = 0.05;

impl<'a> Runner<'a> {
    /// Runs a trial to its end, each sample on its way to the journal.
    pub(super) fn record(&mut self, trial: &PlannedTrial) -> Result<End, AcquireError> {
        self.files.check()?;
        // Nothing is recorded onto a session that is not whole any more.
        let checked = self.stored.check(&self.files, &self.session.record);
        checked.map_err(|finding| AcquireError::NotWhole {
            session: self.plan.name(),
            findings: vec![finding],
        })?;
        // The environment and the mode of the place at hand.
        let study: &'a Study = &self.plan.study;
        let mode = self.flow.here().and_then(|place| self.session.modes.get(place));
        let mode = mode.and_then(|id| study.mode(id));
        let condition = study.environment(&trial.environment).zip(mode);
        let (environment, mode) = condition.ok_or_else(|| {
            let number = trial.trial;
            AcquireError::refused(
                format!("trial {number} has an environment or a mode that is not in study.toml"),
                "put study.toml back as it was when the session began",
            )
        })?;
        let at_hand = self.flow.here().and_then(|place| self.flow.tasks().at_hand(place));
        let presented = at_hand.as_ref().map(|shown| shown.presented.clone());
        // The environment at the level of the interval.
        let varied = match &at_hand {
            Some(shown) => {
                Some(study.environment_at(shown.task, shown.level).ok_or_else(|| {
                    AcquireError::refused(
                        format!("{} is no level of {}", shown.level.value(), shown.task.varies),
                        "put study.toml back as it was when the session began",
                    )
                })?)
            }
            None => None,
        };
        let plan = TrialPlan::new(&self.plan.study, environment, trial.trial, &self.capabilities)?;
        let plan = TrialPlan { shows_moments: self.shows_moments(), varied, ..plan };
        if let Some(cut) = self.await_lever()? {
            return Ok(cut);
        }
        let calibration = &self.plan.calibration;
        let rendered = plan.varied.as_ref().unwrap_or(environment);
        let controller = Controller::new(&self.plan.study.control, rendered, mode, calibration);
        // Made before the loop begins, which waits for no file.
        let journal = self.journal(trial, presented)?;
        // The level of a task is not shown.
        let range_rad = self.view.theta_range_rad;
        let law = if plan.varied.is_none() {
            commanded(environment, range_rad.0, range_rad.1)
        } else {
            Vec::new()
        };
        self.view.begin_trace(law);
        self.show()?;
        let mut live = Live {
            tape: Tape::new(journal, plan.rate_hz),
            view: &mut self.view,
            blinded: self.session.blinded,
            pace: Pace { rate_hz: plan.rate_hz, ..Pace::default() },
            marking: Marking::new(&self.markers, trial.trial),
            saturated: 0,
        };
        let stop = &*self.options.stop;
        let mut desk = Desk {
            front: &mut self.front,
            flow: &mut self.flow,
            files: &self.files,
            utc: self.utc,
            plan: self.plan,
            session: &self.session,
            stored: &mut self.stored,
            conditions: &self.conditions,
            options: self.options,
            drawn: Instant::now(),
            error: None,
        };
        let in_real_time = self.options.live;
        let task = TrialTask { plan, mode, calibration, controller, stop };
        let run = self.attendant.run_trial(task, &mut |samples| {
            if in_real_time { desk.take(&mut live, samples) } else { live.add_all(samples) }
        })?;
        if let Some(error) = desk.error {
            return Err(error);
        }
        // What it finds is in `error`.
        let _ = live.tape.write();
        live.view.timing = live.pace.timing();
        let saturated = live.saturated;
        let (last_s, sent) = live.marking.end();
        let mut tape = live.tape;
        if let Some(error) = tape.error.take() {
            return Err(error.into());
        }
        let now_s = self.attendant.now_s();
        // A device that is lost tells no time: its trial has the others.
        let monotonic_s = run.begun_s.and_then(|begun_s| {
            self.attendant.ask(move |station| station.clock.monotonic_s(begun_s)).ok().flatten()
        });
        self.ran =
            last_s.map(|last_s| Ran { trial: trial.trial, ended_s: now_s, last_s, monotonic_s });
        let end = self.conclude(trial.trial, tape, &run)?;
        self.keep_markers(&sent, monotonic_s)?;
        self.tell_saturated(trial.trial, saturated, run.timing.ticks)?;
        Ok(end)
    }

    /// A trial begins with the lever at its start. After one in which it stayed where it was,
    /// somebody carries it back; a short pause may be over before. Looks on until it is there,
    /// for a while; how that was cut, if it was.
    fn await_lever(&mut self) -> Result<Option<End>, AcquireError> {
        let Some(start_rad) = self.plan.study.device.theta_min_rad else { return Ok(None) };
        let begun_s = self.attendant.now_s();
        loop {
            let theta_rad = match self.look() {
                Err(trip) => return Ok(Some(End::Cut(trip.to_string()))),
                Ok(theta_rad) => theta_rad,
            };
            let is_back = theta_rad <= start_rad + AT_START_RAD;
            let waited_s = self.attendant.now_s() - begun_s;
            if is_back || waited_s > LEVER_BACK_S || self.options.stop.load(Ordering::SeqCst) {
                return Ok(None);
            }
            self.show()?;
        }
    }

    /// Where the lever is after a short while, rad; nowhere, if nothing could be read.
    fn look(&mut self) -> Result<f64, Trip> {
        let rate_hz = self.rate_hz;
        let stop = &*self.options.stop;
        self.attendant.ask(move |station| {
            let Station { device, clock, guard, .. } = &mut *station;
            let until_s = clock.now_s() + LOOK_S;
            let mut theta_rad = f64::INFINITY;
            let watched =
                watch(*device, *clock, guard, rate_hz, until_s, stop, &mut |_, _, seen| {
                    theta_rad = seen.theta_rad;
                });
            watched.map(|()| theta_rad).map_err(|trip| station.cause(trip))
        })?
    }

    /// Keeps the timing, the tape and the remarks of a trial that ended; returns how it ended.
    fn conclude(
        &mut self,
        trial: u32,
        mut tape: Tape,
        run: &TrialRun,
    ) -> Result<End, AcquireError> {
        let crate::Timing { rate_hz, measured_hz, dropouts, .. } = self.view.timing;
        let Timing { ticks, missed, lateness, .. } = &run.timing;
        self.view.timing = look::timing(rate_hz, measured_hz, *missed, dropouts, lateness);
        self.timing.merge(&run.timing);
        let end = match &run.end {
            TrialEnd::Limit | TrialEnd::LetGo => End::Complete,
            TrialEnd::Stopped if self.options.quit.load(Ordering::SeqCst) => {
                End::Cut(self.front.gone().map_or(SIGNAL, |_| GONE).to_owned())
            }
            TrialEnd::Stopped => End::Cut(EMERGENCY_STOP.to_owned()),
            TrialEnd::Tripped(trip) => End::Cut(trip.to_string()),
        };
        if end == End::Complete {
            self.tell_protocol(&tape.journal)?;
            tape.journal.end()?;
            self.answer = self.flow.here().and_then(|place| self.ask_participant(place, 0));
        }
        self.tape = Some(tape);
        if *missed > 0 {
            let text = format!(
                "{missed} of {} ticks missed their deadline; the latest came {:.1} ms late",
                ticks + missed,
                lateness.max_s() * 1e3
            );
            self.log(Event::Note { trial: Some(trial), text })?;
        }
        // After every trial, also after one without a motor: it must not tell a blinded mode.
        if self.is_unwatched() {
            let text = "the device has no watchdog (--no-watchdog)".to_owned();
            self.log(Event::Note { trial: Some(trial), text })?;
        }
        Ok(end)
    }

    /// Looks at whether a trial met the protocol, before its journal says that it is whole: whatever a kill
    /// leaves, a trial that is to be done again is known for one.
    fn tell_protocol(&mut self, journal: &Journal) -> Result<(), AcquireError> {
        let tasks = self.flow.tasks();
        // A presentation of a task may be any movement.
        if self.flow.here().is_some_and(|place| tasks.is_presentation(place)) {
            return Ok(());
        }
        let trial = journal.trial(&self.files)?;
        self.view.verdict = trial.and_then(|trial| (self.judge)(&trial));
        match self.view.verdict.as_ref().and_then(|verdict| verdict.unmet.clone()) {
            Some(what) => self.feed(Input::Unmet(what)),
            None => Ok(()),
        }
    }

    /// Tells that the actuators did not give what a presentation of a task asked for: its level was not rendered. Not in a
    /// blinded session, where it would tell modes apart; the file has it.
    fn tell_saturated(
        &mut self,
        trial: u32,
        saturated: u64,
        ticks: u64,
    ) -> Result<(), AcquireError> {
        let tasks = self.flow.tasks();
        let is_of_task = self.flow.here().is_some_and(|place| tasks.is_presentation(place));
        if saturated == 0 || !is_of_task || self.session.blinded {
            return Ok(());
        }
        let text = format!(
            "the actuators were saturated in {saturated} of {ticks} ticks: the level may not have been rendered"
        );
        self.log(Event::Note { trial: Some(trial), text })
    }

    /// What the device's own participant answers to a question of a place, where it is asked.
    pub(super) fn ask_participant(&mut self, place: usize, question: usize) -> Option<i16> {
        if !self.options.answers {
            return None;
        }
        let trial = self.flow.places()[place].trial.trial;
        if let Some(shown) = self.flow.tasks().at_hand(place) {
            if self.flow.tasks().is_followed(place) {
                return None;
            }
            let mode = self.plan.study.mode(shown.mode);
            let judged = Judged {
                task: shown.task.clone(),
                mode: shown.mode.clone(),
                law: mode.and_then(Mode::law),
                level: shown.compared,
                last_is_standard: shown.last_is_standard,
                track: shown.track,
                presentation: shown.presentation,
                trial,
            };
            let judge = move |station: &mut Station<'_>| station.device.judge(&judged);
            return self.attendant.ask(judge).ok().flatten();
        }
        let question = self.flow.places()[place].questions.get(question);
        let scale = question.map(|q| q.scale.clone()).unwrap_or_default();
        self.attendant.ask(move |station| station.device.answer(&scale)).ok().flatten()
    }

    /// Whether the motor may run without a watchdog, as requested.
    fn is_unwatched(&self) -> bool {
        self.options.no_watchdog && self.capabilities.watchdog_s.is_none()
    }

    /// Makes the file of the trial that ended.
    pub(super) fn finish(
        &mut self,
        trial: u32,
        complete: bool,
        likert: Option<Given>,
    ) -> Result<(), AcquireError> {
        let Some(tape) = self.tape.take() else { return Ok(()) };
        let utc = (self.utc)(self.attendant.now_s());
        let entered = Entered { utc: &utc, by: self.options.by.as_ref() };
        let path = tape.journal.finish_in(&self.files, &mut self.stored, likert, entered)?;
        self.view.say(match (path, complete) {
            (None, _) => format!("trial {trial} had not begun: nothing is kept of it"),
            (Some(_), true) => format!("trial {trial} stored"),
            (Some(_), false) => format!("trial {trial} stored, incomplete"),
        });
        Ok(())
    }

    fn journal(
        &mut self,
        trial: &PlannedTrial,
        presented: Option<Presented>,
    ) -> Result<Journal, AcquireError> {
        let start_utc = (self.utc)(self.attendant.now_s());
        let record = &self.session.record;
        let values = [
            ("study_blake3", Some(record.study_blake3.clone())),
            ("calibration_blake3", record.calibration_blake3.clone()),
            ("device", Some(self.capabilities.name.clone())),
            ("software", Some(record.software.clone())),
            ("seed", record.seed.map(|seed| seed.to_string())),
            ("start_utc", Some(start_utc)),
            ("no_watchdog", self.is_unwatched().then(|| "true".to_owned())),
        ];
        let values = values.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
        let file: TrialFile = values.collect();
        let meta = self.session.meta(trial, presented);
        let study = &self.plan.study;
        let environment = study.environment(&trial.environment);
        let question = match &trial.task {
            Some(place) => Some(place.task.clone()),
            None => environment.and_then(|e| e.question.clone()),
        };
        let protocol = Protocol {
            form: study.trial_form(),
            question,
            given: self.capabilities.channels.clone(),
        };
        Ok(Journal::create(&self.files, &self.plan.layout, &meta, &file, &protocol)?)
    }
}

/// Where samples go: to the journal and to the trace.
struct Live<'a> {
    tape: Tape,
    view: &'a mut View,
    blinded: bool,
    pace: Pace,
    marking: Marking<'a>,
    /// Samples in which the actuators did not give what was asked for; past a wall they never do.
    saturated: u64,
}

/// A sample that is early by this share of a period is on time: its time is a difference of two
/// clock readings.
const ROUNDED: f64 = 1e-6;

/// How the loop keeps its time, as far as the samples tell: deadlines are a grid from the trial's
/// start.
#[derive(Default)]
struct Pace {
    rate_hz: f64,
    /// When the last sample was taken, s.
    t_s: f64,
    samples: u64,
    /// Deadlines that have passed.
    deadlines: u64,
    /// Samples that come after a gap.
    dropouts: u64,
    lateness: Histogram,
}

impl Pace {
    fn add(&mut self, sample: &Sample) {
        let periods = sample.t_s * self.rate_hz;
        let due = (periods + ROUNDED).floor();
        (self.t_s, self.samples) = (sample.t_s, self.samples + 1);
        self.dropouts += u64::from(sample.flags.has(Flags::DROPOUT));
        // The first deadline is at 0.
        self.deadlines = due as u64 + 1;
        self.lateness.add((periods - due).max(0.0) / self.rate_hz);
    }

    fn timing(&self) -> crate::Timing {
        let measured_hz =
            if self.t_s > 0.0 { self.samples.saturating_sub(1) as f64 / self.t_s } else { 0.0 };
        let missed = self.deadlines.saturating_sub(self.samples);
        look::timing(self.rate_hz, measured_hz, missed, self.dropouts, &self.lateness)
    }
}

impl Live<'_> {
    fn add(&mut self, sample: &Sample) -> ControlFlow<()> {
        self.pace.add(sample);
        self.marking.add(sample);
        let is_short = sample.flags.has(Flags::SATURATED) && !sample.flags.has(Flags::PAST_WALL);
        self.saturated += u64::from(is_short);
        if let crate::Phase::Trial { t_s, .. } = &mut self.view.phase {
            *t_s = sample.t_s;
        }
        self.view.trace(Point {
            t_s: sample.t_s,
            theta_rad: sample.theta_rad,
            theta_dot_rad_s: sample.theta_dot_rad_s,
            force_ex_n: sample.force_ex_n,
            voltages: (!self.blinded).then_some(sample.voltages),
        });
        self.tape.add(sample)
    }

    fn add_all(&mut self, samples: &[Sample]) -> ControlFlow<()> {
        samples.iter().try_for_each(|sample| self.add(sample))
    }
}

/// What else goes on in real time while a trial runs: the screen, the keys, remarks.
struct Desk<'a> {
    front: &'a mut dyn Front,
    flow: &'a mut Flow,
    files: &'a dyn Files,
    utc: &'a (dyn Fn(f64) -> String + Sync),
    plan: &'a Plan,
    session: &'a Session,
    stored: &'a mut OpenSession,
    conditions: &'a Conditions,
    options: &'a Options,
    drawn: Instant,
    error: Option<AcquireError>,
}

impl Desk<'_> {
    fn take(&mut self, live: &mut Live<'_>, samples: &[Sample]) -> ControlFlow<()> {
        live.add_all(samples)?;
        match self.serve(live) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.error = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    fn serve(&mut self, live: &mut Live<'_>) -> Result<(), AcquireError> {
        let signalled = self.options.quit.load(Ordering::SeqCst).then_some(Input::Quit);
        for input in self.front.next(Duration::ZERO)?.into_iter().chain(signalled) {
            for action in self.flow.step(input) {
                self.act(live, action)?;
            }
        }
        if self.drawn.elapsed() >= FRAME {
            self.drawn = Instant::now();
            live.view.timing = live.pace.timing();
            look::refresh_trial(live.view, self.flow, self.plan, self.session, self.conditions);
            self.front.show(live.view)?;
        }
        Ok(())
    }

    /// While a trial runs only these can be asked for.
    fn act(&mut self, live: &mut Live<'_>, action: Action) -> Result<(), AcquireError> {
        match action {
            Action::Halt => self.options.stop.store(true, Ordering::SeqCst),
            Action::Refuse(why) | Action::Tell(why) => live.view.say(why),
            Action::Log(event) => {
                live.view.say(look::event(&event));
                // In real time the time of day is the machine's, whatever the loop's clock shows.
                let entered = Entered { utc: &(self.utc)(0.0), by: self.options.by.as_ref() };
                self.stored.append(self.files, entered, &[event])?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The force that an environment commands at rest, at angles all over the work space and up to its
/// wall, rad and N.
fn commanded(environment: &Environment, from_rad: f64, to_rad: f64) -> Vec<(f64, f64)> {
    const STEPS: u32 = 60;
    let Some(law) = environment.scene.law() else { return Vec::new() };
    let step_rad = (to_rad - from_rad) / f64::from(STEPS);
    let angles = (0..=STEPS).map(|step| from_rad + f64::from(step) * step_rad);
    let before_wall = angles.filter(|rad| !law.is_past_wall(*rad));
    before_wall.map(|rad| (rad, law.force_n(rad, 0.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Voltages;

    fn sample(t_s: f64, flags: Flags) -> Sample {
        Sample {
            t_s,
            t_device_s: None,
            theta_rad: 0.0,
            theta_dot_rad_s: 0.0,
            force_ex_n: 0.0,
            voltages: Voltages::OFF,
            force_age_s: None,
            theta_raw: None,
            force_cmd_n: 0.0,
            flags,
            extra: zwidth_study::Extra::default(),
        }
    }

    #[test]
    fn the_screen_counts_missed_deadlines_and_the_gaps_they_leave() {
        let mut pace = Pace { rate_hz: 1000.0, ..Pace::default() };
        // Deadlines 3 to 5 are missed; sample 2 is a bit early by rounding, sample 6 comes 0.25 ms
        // late.
        for (t_s, gap) in [(0.0, false), (0.001, false), (0.002 - 1e-12, false), (0.00625, true)] {
            pace.add(&sample(t_s, Flags::default().with(Flags::DROPOUT, gap)));
        }
        let timing = pace.timing();
        assert_eq!((timing.missed, timing.dropouts), (3, 1));
        assert!((timing.measured_hz - 3.0 / 0.00625).abs() < 1e-9, "{}", timing.measured_hz);
        assert!((timing.jitter_max_s - 0.00025).abs() < 1e-9, "{}", timing.jitter_max_s);
    }
}
