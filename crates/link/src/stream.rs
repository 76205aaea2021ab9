//! A board that sends readings unasked as a device, and a load cell that may have a port of its
//! own.
//!
//! Readings are handed out in the order in which they came, one for each look, so none is lost if
//! the loop was late. The loop looks more often than readings come ([`LOOKS_PER_READING`]), which
//! works off a backlog. Between two readings the last one is used, with its age, counted from when
//! the host received it, so up to one look too young.

use crate::rate::LOOKS_PER_READING;
use crate::shaft::Shaft;
use crate::talk::{Facts, Heard, Plan, Talk};
use crate::text::{Field, Lines, Template};
use crate::{Drive, Hx711, Settings, Wire, mark};
use std::collections::VecDeque;
use std::io;
use std::time::Duration;
use zwidth_device::{Angle, Capabilities, Cue, Device, DeviceError, Reading};
use zwidth_study::{EnvironmentId, Extra, Moment, Source, Voltages};

/// A board may take so long to begin after its port was opened, and so long to its first reading.
const BEGIN: Duration = Duration::from_secs(4);
/// So often it is asked who it is meanwhile.
const HELLO_EVERY: Duration = Duration::from_millis(200);
/// At homing the lever must rest for so long, s.
const HOMING_S: f64 = 0.25;
/// It is waited for so long, s.
const HOMING_MOST_S: f64 = 2.0;
/// Readings that may pile up: more than come within [`AWAY_S`]. Of a board that sends more often
/// than it was said to, the oldest are dropped; before that safety finds them too old.
const MOST_WAITING: usize = 512;
/// What came while nobody looked for so long is dropped, s: buffers keep the oldest of it, and how
/// old that is nobody knows.
const AWAY_S: f64 = 0.25;
/// Values that an HX711 gives at most, Hz (data sheet, "Output Data Rate").
const HX711_HZ: f64 = 80.0;
/// Bytes that are taken in at one look at most: no wire brings more in a tick.
const MOST_BYTES: usize = 16_384;

/// A board that sends readings unasked.
pub(crate) struct Stream<W> {
    wire: W,
    talk: Box<dyn Talk>,
    cell: Option<Cell<W>>,
    settings: Settings,
    plan: Plan,
    capabilities: Capabilities,
    environments: Vec<EnvironmentId>,
    shaft: Shaft,
    waiting: VecDeque<Received>,
    last: Option<Received>,
    /// The load cell's newest value at its own port, counts, and when it came, s.
    force: Option<(i32, f64)>,
    /// The board's clock: the last step, and all of them.
    ticks: Option<(u32, u64)>,
    /// When it was looked last, s.
    looked_s: f64,
    reset: bool,
    /// The wire, or the load cell's, is gone since then.
    gone: bool,
    /// Readings that came twice.
    twice: u64,
    out: Vec<u8>,
}

/// A reading that came.
#[derive(Debug, Clone, Copy)]
struct Received {
    counts: u16,
    ticks: Option<u64>,
    /// The force that came with it.
    force: Option<i32>,
    came_s: f64,
}

/// A load cell at a wire of its own.
pub(crate) struct Cell<W> {
    wire: W,
    lines: Lines,
    template: Template,
    port: String,
    rate_hz: f64,
    damaged: u64,
}

impl<W: Wire> Cell<W> {
    /// # Errors
    /// A template that is none.
    pub(crate) fn new(wire: W, settings: &Hx711) -> Result<Self, DeviceError> {
        let template = settings.template()?;
        let rate_hz = settings.rate_hz;
        let port = settings.port.display().to_string();
        Ok(Self { wire, lines: Lines::from_anywhere(), template, port, rate_hz, damaged: 0 })
    }

    /// Opens its port anew: a line that began before is none.
    fn begin_anew(&mut self) -> io::Result<()> {
        self.lines = Lines::from_anywhere();
        self.wire.reopen()
    }

    /// The newest value that has come.
    fn newest(&mut self) -> io::Result<Option<i32>> {
        let mut newest = None;
        let mut bytes = [0; 256];
        for _ in 0..MOST_BYTES / bytes.len() {
            let came = self.wire.receive(&mut bytes, Duration::ZERO)?;
            for byte in &bytes[..came] {
                let Some(line) = self.lines.push(*byte) else { continue };
                let value = self.template.read(line).and_then(|values| values.get(Field::Hx711));
                let value = value.and_then(|value| i32::try_from(value).ok());
                self.damaged += u64::from(value.is_none());
                // A line that is not understood does not hide the value before it.
                newest = value.or(newest);
            }
            if came < bytes.len() {
                break;
            }
        }
        Ok(newest)
    }
}

impl<W: Wire> Stream<W> {
    /// Hears the board at the other end. `environments`: the study's, in its order.
    ///
    /// # Errors
    /// No answer, no reading, no force; a board that cannot do what the settings say.
    pub(crate) fn connect(
        wire: W,
        cell: Option<Cell<W>>,
        talk: Box<dyn Talk>,
        settings: Settings,
        environments: Vec<EnvironmentId>,
    ) -> Result<Self, DeviceError> {
        let mut stream = Self {
            plan: talk.plan(),
            capabilities: settings.unknown(),
            shaft: Shaft::new(1, settings.turning),
            waiting: VecDeque::with_capacity(MOST_WAITING),
            last: None,
            force: None,
            ticks: None,
            looked_s: 0.0,
            reset: false,
            gone: false,
            twice: 0,
            out: Vec::with_capacity(256),
            wire,
            talk,
            cell,
            environments,
            settings,
        };
        let facts = stream.introduce()?;
        stream.shaft.counts_per_turn = facts.counts_per_turn;
        stream.capabilities = stream.capabilities(&facts);
        stream.say(|talk, out| talk.begin(out))?;
        stream.first()?;
        Ok(stream)
    }

    /// Pieces on the wires that were no message.
    pub(crate) fn damaged(&self) -> u64 {
        let cell = self.cell.as_ref().map_or(0, |cell| cell.lines.damaged() + cell.damaged);
        self.talk.damaged() + self.twice + cell
    }

    /// A wire failed.
    fn break_off(&mut self, whose: &str, why: &io::Error) -> DeviceError {
        // A wire that only took too long is still there.
        self.gone |= why.kind() != io::ErrorKind::TimedOut;
        self.lost(&format!("{whose}{why}"))
    }

    /// Connects anew, and asks whether it is the same board.
    fn come_back(&mut self) -> Result<(), DeviceError> {
        let opened = self.wire.reopen();
        let opened = opened.and_then(|()| self.cell.as_mut().map_or(Ok(()), Cell::begin_anew));
        opened.map_err(|e| {
            let remedy = "plug the board in where it was, then home again";
            self.unable(format!("the port cannot be opened again: {e}"), remedy)
        })?;
        self.gone = false;
        self.talk.begin_anew();
        let facts = self.introduce()?;
        if self.capabilities(&facts) != self.capabilities {
            self.gone = true;
            let what = format!("another board is at the port now, {}", facts.name);
            return Err(self.unable(what, "plug in the one that the session began with"));
        }
        self.force = None;
        self.say(|talk, out| talk.begin(out))?;
        self.first()
    }

    fn capabilities(&self, facts: &Facts) -> Capabilities {
        let in_lines_hz = self.plan.rate_hz.min(HX711_HZ);
        let force_rate_hz = self.cell.as_ref().map_or(in_lines_hz, |cell| cell.rate_hz);
        let unknown = self.settings.unknown();
        Capabilities {
            name: facts.name.clone(),
            rate_hz: LOOKS_PER_READING * self.plan.rate_hz,
            force_rate_hz,
            counts_per_turn: Some(facts.counts_per_turn.into()),
            motor_max_v: self.plan.full.motor_v,
            brake_max_v: self.plan.full.brake_v,
            shows_moments: self.plan.shows_moments,
            source: if facts.simulated { Source::Twin } else { unknown.source },
            ..unknown
        }
    }

    /// Asks until the board has said enough.
    fn introduce(&mut self) -> Result<Facts, DeviceError> {
        let began = self.wire.now();
        while self.wire.now() - began < BEGIN {
            self.say(|talk, out| talk.hello(out))?;
            let until = self.wire.now() + HELLO_EVERY;
            while let Some(wait) = until.checked_sub(self.wire.now()).filter(|wait| !wait.is_zero())
            {
                self.take_in(0.0, wait)?;
                if let Some(facts) = self.talk.facts() {
                    return facts;
                }
            }
        }
        let baud = self.settings.baud();
        let damaged = self.damaged();
        let what =
            format!("nothing understood came at {baud} baud, {damaged} pieces not understood");
        Err(self.unable(what, "check port, link and baud in rig.toml, and what runs on the board; `zwidth ports PORT` asks who is there"))
    }

    /// Waits for the first reading and the first force.
    fn first(&mut self) -> Result<(), DeviceError> {
        let began = self.wire.now();
        while self.wire.now() - began < BEGIN {
            self.take_in(0.0, Duration::from_millis(10))?;
            if self.waiting.back().is_some_and(|newest| self.force_with(newest).is_some()) {
                self.reset = false;
                return Ok(());
            }
        }
        let Some(cell) = self.cell.as_ref().filter(|_| self.force.is_none()) else {
            let remedy = "check the angle sensor and its place in rig.toml";
            return Err(self.unable("it sends no readings".to_owned(), remedy));
        };
        let what = format!("no line of the load cell came at {}", cell.port);
        Err(self.unable(what, "check the table [hx711] in rig.toml, and what runs there"))
    }

    fn say(&mut self, write: impl FnOnce(&mut dyn Talk, &mut Vec<u8>)) -> Result<(), DeviceError> {
        self.out.clear();
        write(&mut *self.talk, &mut self.out);
        self.wire.send(&self.out).map_err(|e| self.break_off("", &e))
    }

    /// Takes in what has come; waits for the first of it for so long.
    fn take_in(&mut self, now_s: f64, wait: Duration) -> Result<(), DeviceError> {
        let mut bytes = [0; 256];
        let mut wait = wait;
        let before = self.waiting.len();
        for _ in 0..MOST_BYTES / bytes.len() {
            // Waited for once: what comes after the first bytes is there already.
            let came = self.wire.receive(&mut bytes, std::mem::take(&mut wait));
            let came = came.map_err(|e| self.break_off("", &e))?;
            bytes[..came].iter().for_each(|byte| self.hear(*byte, now_s));
            if came < bytes.len() {
                break;
            }
        }
        // Readings that came together came one after another, but not before the last look.
        let period_s = 1.0 / self.plan.rate_hz;
        let looked_s = self.looked_s.min(now_s);
        for (behind, received) in (0_u32..).zip(self.waiting.iter_mut().skip(before).rev()) {
            received.came_s = (now_s - f64::from(behind) * period_s).max(looked_s);
        }
        self.looked_s = now_s;
        let Some(cell) = &mut self.cell else { return Ok(()) };
        let newest = cell.newest();
        let newest = newest.map_err(|e| self.break_off("the load cell's port: ", &e))?;
        self.force = newest.map(|force| (force, now_s)).or(self.force);
        Ok(())
    }

    fn hear(&mut self, byte: u8, now_s: f64) {
        match self.talk.push(byte) {
            Some(Heard::Reading { ticks, counts, force }) => {
                let ticks = match ticks.map(|ticks| self.passed(ticks)) {
                    Some(None) => return self.twice += 1,
                    ticks => ticks.flatten(),
                };
                if self.waiting.len() == MOST_WAITING {
                    self.waiting.pop_front();
                }
                self.waiting.push_back(Received { counts, ticks, force, came_s: now_s });
            }
            Some(Heard::Reset) => self.reset = true,
            None => {}
        }
    }

    /// All steps of the board's clock; one that goes back has begun anew. None of a reading that
    /// came before: its clock goes further between two.
    fn passed(&mut self, ticks: u32) -> Option<u64> {
        let Some((last, all)) = self.ticks else {
            self.ticks = Some((ticks, ticks.into()));
            return Some(ticks.into());
        };
        let passed = ticks.wrapping_sub(last);
        // A clock whose steps are longer than a period may well stand between two readings.
        if passed == 0 && self.plan.tick_s * self.plan.rate_hz < 1.0 {
            return None;
        }
        // A clock that goes back has begun anew, though nobody said so.
        self.reset |= passed > u32::MAX / 2;
        let all = if passed > u32::MAX / 2 { ticks.into() } else { all + u64::from(passed) };
        self.ticks = Some((ticks, all));
        Some(all)
    }

    /// The force that belongs to a reading, counts, and when it came, s.
    fn force_with(&self, reading: &Received) -> Option<(i32, f64)> {
        reading.force.map(|force| (force, reading.came_s)).or(self.force)
    }

    /// The next reading, or the last one again.
    fn reading(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        if self.reset {
            return Err(self.lost("the board has begun anew"));
        }
        self.last = self.waiting.pop_front().or(self.last);
        let last = self.last.ok_or_else(|| self.lost("it sends no readings"))?;
        let force = self.force_with(&last);
        let (force, force_s) = force.ok_or_else(|| self.lost("no force has come"))?;
        Ok(Reading {
            t_device_s: last.ticks.map(|ticks| ticks as f64 * self.plan.tick_s),
            angle: Angle::Counts(self.shaft.upwards(last.counts)),
            angle_age_s: (now_s - last.came_s).max(0.0),
            force_n: (f64::from(force) - self.settings.zero_counts)
                * self.settings.newtons_per_count,
            force_age_s: Some((now_s - force_s).max(0.0)),
            extra: Extra::default(),
        })
    }

    fn lost(&self, what: &str) -> DeviceError {
        DeviceError::Lost { device: self.capabilities.name.clone(), what: what.to_owned() }
    }

    fn unable(&self, what: String, remedy: &str) -> DeviceError {
        let device = self.capabilities.name.clone();
        DeviceError::Unable { device, what, remedy: remedy.to_owned() }
    }
}

impl<W: Wire> Device for Stream<W> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        if self.gone {
            self.come_back()?;
        }
        self.take_in(now_s, Duration::ZERO)?;
        self.waiting.clear();
        (self.last, self.ticks, self.reset) = (None, None, false);
        self.say(|talk, out| {
            // Again: a board that began anew has forgotten its pins and its interval.
            talk.begin(out);
            talk.mark(mark::HOMING, 0, out);
        })?;
        let began = self.wire.now();
        let mut rest = None;
        let mut moved = String::new();
        loop {
            let passed_s = (self.wire.now() - began).as_secs_f64();
            self.take_in(now_s + passed_s, HELLO_EVERY)?;
            while let Some(received) = self.waiting.pop_front() {
                self.last = Some(received);
                let (since_s, counts) = *rest.get_or_insert((passed_s, received.counts));
                if let Err(what) = self.shaft.rested(counts, received.counts) {
                    // It moved, so the rest begins anew.
                    (rest, moved) = (None, what);
                } else if passed_s - since_s >= HOMING_S {
                    if !self.shaft.is_stop(counts) {
                        let what = "the lever is not where its stop was before".to_owned();
                        let remedy = "hold it against its lower stop, then home again";
                        return Err(self.unable(what, remedy));
                    }
                    return self.reading(now_s + passed_s);
                }
            }
            if passed_s > HOMING_MOST_S {
                // The next homing connects anew to a board that is silent.
                self.gone = self.last.is_none();
                let remedy = "hold it still against its lower stop, then home again";
                return match self.last {
                    Some(_) => Err(self.unable(moved, remedy)),
                    None => Err(self.lost("it sends no readings")),
                };
            }
        }
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        if now_s - self.looked_s > AWAY_S {
            self.take_in(now_s, Duration::ZERO)?;
            self.waiting.clear();
            self.take_in(now_s, HELLO_EVERY)?;
        }
        self.take_in(now_s, Duration::ZERO)?;
        self.reading(now_s)
    }

    fn write(&mut self, _now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        let drive = Drive::of(voltages, self.plan.full);
        self.say(|talk, out| talk.write(drive, out))
    }

    fn begin(&mut self, _now_s: f64, cue: &Cue<'_>) {
        let place = self.environments.iter().position(|id| *id == cue.environment.id);
        let environment = place.and_then(|place| u16::try_from(place).ok()).unwrap_or(u16::MAX);
        let number = u16::try_from(cue.trial).unwrap_or(u16::MAX);
        // A marker that does not arrive harms nothing; the next reading tells of a lost wire.
        let _ = self.say(|talk, out| {
            talk.mark(mark::ENVIRONMENT, environment, out);
            talk.mark(mark::TRIAL, number, out);
        });
    }

    fn mark(&mut self, moment: Moment) {
        // As above.
        let _ = self.say(|talk, out| talk.mark(mark::MOMENT, mark::number(moment), out));
    }
}
