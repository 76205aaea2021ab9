//! The runner: binds a session's flow to device, clock, journal, event log and front end.
//!
//! There is one path for real and simulated time: the device does one thing after another. In real
//! time a thread of its own holds the device ([`Attendant`]) while this one writes and shows. That
//! thread runs the trials, and between them keeps reading at 0 V, so the turn of the shaft stays
//! known however long a disk takes. On a simulated clock this thread drives the device, and a pause
//! is over at once.

mod check;
mod idle;
mod lasting;
mod look;
mod mark;
#[cfg(test)]
mod tests;
mod trial;

use crate::course::{Conditions, course};
use crate::flow::{Action, Flow, Input, Phase};
use crate::folder::Within;
use crate::markers::Markers;
use crate::outlets::Outlets;
use crate::plan::Plan;
use crate::session::Session;
use crate::tape::Tape;
use crate::{AcquireError, Course, Front, StreamName, Target, Verdict, View};
use lasting::Lasting;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use zwidth_device::check::Step;
use zwidth_device::{
    Attendant, Capabilities, Clock, Device, Guard, Limits, Station, Timing, TrialPlan,
};
use zwidth_store::{Entered, Files, OpenSession, Trial, sync_names};
use zwidth_study::{Event, ExperimenterId};

/// How long one look at the keys may wait, and how often an idle screen is drawn.
const WAIT: Duration = Duration::from_millis(50);

/// A voltage's command has arrived by then, s: some twenty of the slowest.
const HEARD_S: f64 = 0.05;

/// What is told when a blinded session begins or goes on.
const BLINDED: &str = "blinded: no name, record or screen tells a mode, but whoever opens a trial's file can read it from \
                       voltages, flags, forces, the angle or the file's size: leave raw/ alone until it is unsealed";

/// What a session runs on.
pub struct Parts<'a> {
    /// The device.
    pub device: &'a mut dyn Device,
    /// The clock of the device.
    pub clock: &'a mut dyn Clock,
    /// The disk: everything that a session reads and writes goes through it.
    pub files: &'a dyn Files,
    /// The front end of the operator.
    pub front: &'a mut dyn Front,
    /// The time of day, in UTC and RFC 3339, at a time of the clock, s.
    pub utc: &'a (dyn Fn(f64) -> String + Sync),
    /// Whether a trial that ran to its end met the protocol, if that can be told.
    pub judge: &'a dyn Fn(&Trial) -> Option<Verdict>,
}

/// How a session runs.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The clock is the machine's: the device gets a thread of its own, and pauses are waited for.
    pub live: bool,
    /// The device's own participant answers the questions.
    pub answers: bool,
    /// The lever needs a hand to get to its stop.
    pub by_hand: bool,
    /// The steps of the device check, in order.
    pub steps: Vec<Step>,
    /// Each of them waits for somebody to say that it may begin; else all are gone through at once.
    pub ask: bool,
    /// The motor of a device without a watchdog may be used; each trial is marked.
    pub no_watchdog: bool,
    /// The receivers of each trial's start, contact, end and answer.
    pub markers: Vec<Target>,
    /// Streams of other programs without which no trial begins.
    pub streams: Vec<StreamName>,
    /// The operator's code, which is added to each event.
    pub by: Option<ExperimenterId>,
    /// Raised by a stop key: the running trial ends at its next tick.
    pub stop: Arc<AtomicBool>,
    /// Raised by a signal that ends the program: the session is left in order.
    pub quit: Arc<AtomicBool>,
}

/// How a session was left.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Trials of the order that are done.
    pub done: usize,
    /// Trials of the order.
    pub total: usize,
    /// What stopped it last, if it was left in that state.
    pub stopped: Option<String>,
    /// A signal ended it, or the terminal that is gone.
    pub interrupted: bool,
    /// Why the terminal, or the pipe, is gone, if it is.
    pub gone: Option<String>,
    /// The device did not take its last 0 V, and has no watchdog: a voltage may stay on.
    pub stays_on: bool,
    /// How the loop kept its time, over all trials.
    pub timing: Timing,
}

struct Runner<'a> {
    plan: &'a Plan,
    options: &'a Options,
    attendant: Attendant<'a>,
    capabilities: Capabilities,
    /// Ticks a second, Hz: the study's, or the device's if those are fewer.
    rate_hz: f64,
    files: Within<'a>,
    front: Lasting<'a>,
    utc: &'a (dyn Fn(f64) -> String + Sync),
    judge: &'a dyn Fn(&Trial) -> Option<Verdict>,
    session: Session,
    /// The session's files.
    stored: OpenSession,
    conditions: Conditions,
    flow: Flow,
    /// The journal of the trial that runs, or that waits for its answer.
    tape: Option<Tape>,
    /// What the device's participant answers to the open question.
    answer: Option<i16>,
    view: View,
    timing: Timing,
    markers: Markers,
    outlets: Outlets,
    /// Why no trial begins, as it was said last.
    withheld: Option<String>,
    /// The last trial that ran.
    ran: Option<Ran>,
    /// What stopped the session, while it is stopped.
    stopped: Option<String>,
    /// The clock at the last look, s.
    seen_s: f64,
    /// The clock before the first trial of this life, s, and what was done by then.
    began: Option<(f64, usize)>,
    /// The trials done, and the clock when the last of them was, s.
    lasted: (usize, f64),
}

/// A trial that ran.
#[derive(Debug, Clone, Copy)]
struct Ran {
    trial: u32,
    /// The clock when it had ended, s.
    ended_s: f64,
    /// Its last sample's time, s.
    last_s: f64,
    /// When it began by the machine's monotonic clock, s.
    monotonic_s: Option<f64>,
}

/// Runs a session from its present state to where it is left. The caller holds the study's lock.
///
/// # Errors
/// A device, a disk or a study's folder that is gone; a study that this device must not run. The
/// device is at 0 V then, and what was finished is safe; the session can be resumed.
pub fn run<'a>(
    plan: &'a Plan,
    session: Session,
    options: &'a Options,
    parts: Parts<'a>,
) -> Result<Outcome, AcquireError> {
    let Parts { device, clock, files, front, utc, judge } = parts;
    let capabilities = device.capabilities().clone();
    let guard = Guard::new(&capabilities, Limits::of(&plan.study)?, options.no_watchdog);
    // Every mode before the first trial: no session stops in the middle for one.
    for mode in &plan.study.modes {
        guard.admit(mode, &plan.calibration)?;
    }
    if options.markers.contains(&Target::Board) && !capabilities.shows_moments {
        return Err(AcquireError::refused(
            format!("--markers board: {} has no pin for markers", capabilities.name),
            "leave board out, or use the framed link, or a sketch that takes markers (docs/rig.md)",
        ));
    }
    // The study's rate, or the device's if that is lower.
    let rate_hz = match plan.study.environments.first() {
        Some(environment) => TrialPlan::new(&plan.study, environment, 0, &capabilities)?.rate_hz,
        None => capabilities.rate_hz,
    };
    let outlets = Outlets::ask_for(&options.streams).map_err(|error| {
        AcquireError::refused(
            format!("--wait-for: the network cannot be asked ({error})"),
            "connect this machine to a network, or leave it out",
        )
    })?;
    let files = Within::open(files, &plan.layout.raw())?;
    let folder = files.clone();
    let (flow, first) = Flow::begin(
        session.order(&plan.study),
        session.tasks(&plan.study, rate_hz)?,
        plan.study.design.pause_s,
        &session.recorded,
        &session.events,
    );
    let flow = flow.homed_by_hand(options.by_hand).redoing(plan.study.design.redo_unmet);
    let view = look::view(plan, &session, &capabilities);
    let stored = OpenSession::new(&plan.layout, &plan.participant, &plan.session);
    let modes = (!session.blinded).then_some(session.modes.as_slice());
    let conditions = Conditions::new(&flow, modes, &plan.study);
    let station = Station::new(device, clock, guard, rate_hz);
    let left = thread::scope(|scope| {
        let mut attendant = match options.live {
            true => Attendant::in_real_time(scope, station),
            false => Attendant::here(station),
        };
        let seen_s = attendant.now_s();
        let mut runner = Runner {
            plan,
            options,
            attendant,
            capabilities,
            rate_hz,
            files,
            front: Lasting::new(front, &options.stop, &options.quit),
            utc,
            judge,
            session,
            stored,
            conditions,
            flow,
            tape: None,
            answer: None,
            view,
            timing: Timing::default(),
            markers: Markers::to(&options.markers),
            outlets,
            withheld: None,
            ran: None,
            stopped: None,
            seen_s,
            began: None,
            lasted: (0, 0.0),
        };
        runner.begin(first).and_then(|()| runner.go_on())?;
        let stays_on = runner.stays_on();
        // However the runner is left, the attendant in it leaves the device at 0 V.
        Ok(Outcome {
            stays_on,
            done: runner.flow.done(),
            total: runner.flow.total(),
            stopped: runner.stopped,
            interrupted: options.quit.load(Ordering::SeqCst),
            gone: runner.front.gone().map(str::to_owned),
            timing: runner.timing,
        })
    });
    // A folder that is gone is behind whatever could not be written.
    left.map_err(|error| folder.check().err().unwrap_or(error))
}

impl<'a> Runner<'a> {
    fn begin(&mut self, first: Vec<Action>) -> Result<(), AcquireError> {
        // A life of this session that was killed may have left a folder's name unsynced; what is
        // recorded into it would go with it in a power cut.
        let Plan { layout, participant, session, .. } = self.plan;
        let trials = layout.trial(participant, session, 1);
        let folders =
            [trials.parent().map(Path::to_owned), Some(layout.journals()), Some(layout.sessions())];
        for folder in folders.into_iter().flatten() {
            sync_names(&self.files, &folder, layout.root())?;
        }
        if self.session.laid_down {
            let place = self.flow.done();
            self.view.say(format!("resumed: {place} of {} trials are done", self.flow.total()));
            self.remark()?;
        }
        if self.session.blinded {
            self.view.say(BLINDED);
        }
        self.act(first)
    }

    /// Whether the device is to show a trial's moments itself.
    fn shows_moments(&self) -> bool {
        self.options.markers.contains(&Target::Board)
    }

    /// Until the session is left.
    fn go_on(&mut self) -> Result<(), AcquireError> {
        while *self.flow.phase() != Phase::Left {
            self.stopped = match self.flow.phase() {
                Phase::Stopped { why } => Some(why.clone()),
                _ => None,
            };
            self.files.check()?;
            self.tell_unsent()?;
            // Before the session is laid down there is no log.
            let changes = if self.session.laid_down {
                self.outlets.changes(Instant::now())
            } else {
                Vec::new()
            };
            for text in changes {
                self.log(Event::Note { trial: None, text })?;
            }
            self.show()?;
            let idle = self.idle()?;
            let now_s = self.attendant.now_s();
            let elapsed_s = now_s - std::mem::replace(&mut self.seen_s, now_s);
            // Before the inputs: the time that an answer took lasts until now.
            self.feed(Input::Elapsed(elapsed_s))?;
            for input in idle {
                let starts = input == Input::Start && *self.flow.phase() == Phase::Ready;
                if let Some(missing) = self.outlets.missing(Instant::now()).filter(|_| starts) {
                    self.withhold(missing);
                    continue;
                }
                self.withheld = None;
                self.feed(input)?;
            }
        }
        self.view.is_cut_off = self.options.quit.load(Ordering::SeqCst);
        self.show()
    }

    /// Begins no trial, and says once why. A front end that starts trials by itself asks again at once.
    fn withhold(&mut self, missing: String) {
        if self.withheld.as_ref() != Some(&missing) {
            self.view.say(missing.clone());
            self.withheld = Some(missing);
        }
        thread::sleep(WAIT);
    }

    fn feed(&mut self, input: Input) -> Result<(), AcquireError> {
        let actions = self.flow.step(input);
        self.act(actions)
    }

    /// Does what the flow asks for, and what comes of it.
    fn act(&mut self, actions: Vec<Action>) -> Result<(), AcquireError> {
        for action in actions {
            match action {
                Action::Check => {
                    let input = self.check()?;
                    self.feed(input)?;
                }
                Action::Home => {
                    let input = self.home()?;
                    self.feed(input)?;
                }
                Action::Run(trial) => {
                    self.began = self.began.or(Some((self.attendant.now_s(), self.flow.done())));
                    let end = self.record(&trial)?;
                    // The trial is no part of the pause after it.
                    self.seen_s = self.attendant.now_s();
                    self.feed(Input::Ended(end))?;
                }
                Action::Finish { trial, complete, likert } => {
                    if likert.is_some() {
                        self.mark_answer(trial)?;
                    }
                    self.finish(trial, complete, likert)?;
                }
                Action::Log(event) => {
                    if let Event::Answer { trial, .. } = event {
                        self.mark_answer(trial)?;
                    }
                    self.log(event)?;
                }
                Action::Refuse(why) | Action::Tell(why) => self.view.say(why),
                Action::Halt => self.options.stop.store(true, Ordering::SeqCst),
                Action::Off => {
                    if *self.flow.phase() == Phase::Done {
                        // Nothing homes from here before a trial that is done again, so the stop
                        // is over now.
                        self.options.stop.store(false, Ordering::SeqCst);
                    }
                    // 0 V now. A device that does not take it is lost, which its next reading
                    // tells; its watchdog does the rest.
                    let _ = self.attendant.ask(Station::off);
                }
                Action::Leave => {}
            }
        }
        Ok(())
    }

    fn log(&mut self, event: Event) -> Result<(), AcquireError> {
        if !self.session.laid_down {
            self.view.say("not kept: the session begins after the device check");
            return Ok(());
        }
        self.view.say(look::event(&event));
        self.keep(&[event])
    }

    /// Appends events to the session's log.
    fn keep(&mut self, events: &[Event]) -> Result<(), AcquireError> {
        let utc = (self.utc)(self.attendant.now_s());
        let entered = Entered { utc: &utc, by: self.options.by.as_ref() };
        Ok(self.stored.append(&self.files, entered, events)?)
    }

    /// Tells what is to be known of the session, and keeps it in its log.
    fn remark(&mut self) -> Result<(), AcquireError> {
        std::mem::take(&mut self.session.opening).into_iter().try_for_each(|event| self.log(event))
    }

    fn home(&mut self) -> Result<Input, AcquireError> {
        self.show()?;
        // What was stopped is over; the next stop is a new one.
        self.options.stop.store(false, Ordering::SeqCst);
        Ok(match self.attendant.ask(Station::home) {
            Ok(Ok(())) => Input::Homed,
            Ok(Err(error)) => Input::Failed(error.to_string()),
            Err(trip) => Input::Failed(trip.to_string()),
        })
    }

    fn show(&mut self) -> Result<(), AcquireError> {
        look::refresh(&mut self.view, &self.flow, self.plan, &self.session, &self.conditions);
        self.view.course = self.course();
        self.front.show(&self.view)
    }

    /// How long the session takes, so far and still.
    fn course(&mut self) -> Course {
        let now_s = self.attendant.now_s();
        let (began_s, before) = self.began.unwrap_or((now_s, self.flow.done()));
        let design = &self.plan.study.design;
        let done = self.flow.done();
        let all = self.flow.total();
        let planned_s = design.trial_limit_s + design.pause_s;
        if self.lasted.0 != done {
            self.lasted = (done, now_s);
        }
        let lasted_s = (self.lasted.1 - began_s).max(0.0);
        course(
            now_s - began_s,
            lasted_s,
            done.saturating_sub(before),
            all.saturating_sub(done),
            planned_s,
        )
    }

    /// Takes the voltages away; whether a device without a watchdog may not have heard it. It is
    /// told twice: a line that breaks while the first word is on its way refuses the second.
    fn stays_on(&mut self) -> bool {
        if self.capabilities.watchdog_s.is_some() {
            return false;
        }
        let off = self.attendant.ask(|station| {
            let first = station.off();
            let heard_s = station.clock.now_s() + HEARD_S;
            station.clock.wait_until(heard_s);
            first.and(station.off())
        });
        !matches!(off, Ok(Ok(())))
    }
}
