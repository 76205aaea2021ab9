//! A board as a device: one question per reading, one write per command.

use super::frame::MOST_WIRE;
use super::message::{Description, FromBoard, PROTOCOL, Seen, ToBoard, UNASKED, status};
use super::patience::{Patience, wire_rate_hz};
use super::wording::Wording;
use crate::shaft::Shaft;
use crate::{Drive, Settings, Wire, mark};
use std::io;
use std::time::Duration;
use zwidth_device::{Angle, Capabilities, Cue, Device, DeviceError, Reading};
use zwidth_study::{EnvironmentId, Extra, Moment, Source, Voltages};

/// So often it is asked who it is meanwhile.
const HELLO_EVERY: Duration = Duration::from_millis(200);
/// At homing the board is asked for so long.
const HOMING: Duration = Duration::from_millis(250);
/// The questions whose time is kept. One unanswered so long ago is answered no more.
const KEPT: usize = 16;

/// A board behind a wire.
pub struct Rig<W> {
    wire: W,
    settings: Settings,
    capabilities: Capabilities,
    /// Full scale, V.
    full: Voltages,
    shaft: Shaft,
    /// The study's environments: a marker tells a place among them.
    environments: Vec<EnvironmentId>,
    /// What has come and is not looked at yet: of so many bytes those from the one place to the
    /// other.
    bytes: [u8; MOST_WIRE],
    taken: usize,
    came: usize,
    wording: Box<dyn Wording>,
    /// What is said at once.
    out: Vec<u8>,
    sequence: u16,
    /// The last questions, by their number, and when they were asked, host time, s.
    questions: [(u16, f64); KEPT],
    /// When the last one was, s.
    question_s: f64,
    patience: Patience,
    last: Option<Answer>,
    /// Answers since the newest that nobody waited for.
    unasked: usize,
    /// What was commanded last.
    drive: Drive,
    /// The board has begun anew since the last homing.
    reset: bool,
    /// The wire is gone since then.
    gone: bool,
    /// Looks that found no newer answer.
    late: u64,
}

/// The newest answer.
#[derive(Debug, Clone, Copy)]
struct Answer {
    seen: Seen,
    /// When it was asked for, host time, s.
    question_s: f64,
    /// The board's clock without its turning over, µs.
    t_us: u64,
}

impl<W: Wire> Rig<W> {
    /// Asks the board at the other end who it is. `environments`: the study's, in its order.
    ///
    /// # Errors
    /// Settings that make no sense; no answer; a board of another protocol, or one that says
    /// something impossible of itself.
    pub fn connect(
        wire: W,
        settings: Settings,
        environments: Vec<EnvironmentId>,
    ) -> Result<Self, DeviceError> {
        settings.check()?;
        let mut rig = Self {
            wire,
            capabilities: settings.unknown(),
            full: Voltages::OFF,
            shaft: Shaft::new(1, settings.turning),
            environments,
            bytes: [0; MOST_WIRE],
            taken: 0,
            came: 0,
            wording: settings.asks(),
            out: Vec::with_capacity(256),
            sequence: 0,
            questions: [(0, 0.0); KEPT],
            question_s: 0.0,
            patience: Patience::at(settings.baud()),
            last: None,
            unasked: 0,
            drive: Drive::default(),
            reset: false,
            gone: false,
            late: 0,
            settings,
        };
        let board = rig.introduce()?;
        rig.full = Voltages { motor_v: volts(board.motor_mv), brake_v: volts(board.brake_mv) };
        rig.shaft.counts_per_turn = board.counts_per_turn;
        rig.capabilities = rig.capabilities_of(&board)?;
        // A board that begins when its port is opened says so; that is no restart in a session.
        rig.reset = false;
        Ok(rig)
    }

    /// Looks that found no newer answer than before, and pieces on the wire that were not a
    /// message.
    pub fn faults(&self) -> [u64; 2] {
        [self.late, self.wording.damaged()]
    }

    /// As if the stop had been at another count at the first homing.
    #[cfg(test)]
    pub(crate) fn forget_stop(&mut self, counts: u16) {
        self.shaft.stop_counts = Some(counts);
    }

    /// Asks until the board says who it is.
    fn introduce(&mut self) -> Result<Description, DeviceError> {
        let began = self.wire.now();
        while self.wire.now() - began < self.wording.begins_within() {
            self.send(&ToBoard::Hello)?;
            let until = self.wire.now() + HELLO_EVERY;
            while let Some(wait) = until.checked_sub(self.wire.now()).filter(|wait| !wait.is_zero())
            {
                if let Some(FromBoard::Description(board)) = self.receive(wait)? {
                    return Ok(board);
                }
            }
        }
        let (what, remedy) = self.wording.silent(self.settings.baud());
        Err(self.unable(what, remedy))
    }

    /// The number of the next question.
    fn next(&self) -> u16 {
        // Round, and past the number of what a board says unasked.
        self.sequence.wrapping_add(1).max(UNASKED + 1)
    }

    fn send(&mut self, message: &ToBoard) -> Result<(), DeviceError> {
        self.sequence = self.next();
        self.out.clear();
        self.wording.say(message, self.sequence, &mut self.out);
        self.wire.send(&self.out).map_err(|e| self.break_off(&e))
    }

    /// The wire failed.
    fn break_off(&mut self, why: &io::Error) -> DeviceError {
        // A wire that only took too long is still there.
        self.gone |= why.kind() != io::ErrorKind::TimedOut;
        self.lost(&why.to_string())
    }

    /// Connects anew, and asks whether it is the same board.
    fn come_back(&mut self) -> Result<(), DeviceError> {
        self.wire.reopen().map_err(|e| {
            let remedy = "plug the board in where it was, then home again";
            self.unable(format!("the port cannot be opened again: {e}"), remedy)
        })?;
        (self.gone, self.taken, self.came) = (false, 0, 0);
        self.wording.begin_anew();
        let board = self.introduce()?;
        if self.capabilities_of(&board)? != self.capabilities {
            self.gone = true;
            let what = format!("another board is at the port now, {}", board.name);
            return Err(self.unable(what, "plug in the one that the session began with"));
        }
        // A board without a watchdog may have kept its voltages while the cable was out.
        self.write(0.0, Voltages::OFF)
    }

    /// The next message that is in what has come, or that comes within `wait`.
    fn receive(&mut self, wait: Duration) -> Result<Option<FromBoard>, DeviceError> {
        let until = self.wire.now() + wait;
        for _ in 0..MOST_BYTES {
            let Some(byte) = self.byte(until)? else { return Ok(None) };
            let Some(heard) = self.wording.push(byte) else { continue };
            let (number, message) = heard.map_err(|why| self.lost(&why))?;
            match &message {
                FromBoard::Seen(seen) => self.take_answer(number, *seen),
                // What it was asked for may come late, when it has said who it is by itself.
                FromBoard::Description(_) => self.reset |= number == UNASKED,
            }
            return Ok(Some(message));
        }
        Err(self.lost("it keeps sending, and nothing that it sends is a message of this link"))
    }

    /// The next byte; none that comes before `until`.
    fn byte(&mut self, until: Duration) -> Result<Option<u8>, DeviceError> {
        if self.taken == self.came {
            let left = until.saturating_sub(self.wire.now());
            let came = self.wire.receive(&mut self.bytes, left);
            (self.taken, self.came) = (0, came.map_err(|e| self.break_off(&e))?);
        }
        let byte = self.bytes[..self.came].get(self.taken).copied();
        self.taken += usize::from(byte.is_some());
        Ok(byte)
    }

    /// Takes an answer, if its question is known and nothing newer came.
    fn take_answer(&mut self, sequence: u16, seen: Seen) {
        let (question, question_s) = self.questions[usize::from(sequence) % KEPT];
        if question != sequence || self.last.is_some_and(|last| last.question_s > question_s) {
            self.unasked += 1;
            return;
        }
        self.unasked = 0;
        let passed_us = self.last.map_or(0, |last| seen.t_us.wrapping_sub(last.seen.t_us));
        // A clock that goes back has begun anew, though nobody said so.
        self.reset |= passed_us > u32::MAX / 2;
        let t_us = self.last.map_or(u64::from(seen.t_us), |last| last.t_us + u64::from(passed_us));
        self.last = Some(Answer { seen, question_s, t_us });
    }

    /// Asks what the board sees, and waits for the answer for so long; whether it came.
    fn poll(&mut self, now_s: f64, wait: Duration) -> Result<bool, DeviceError> {
        let before_s = self.last.map(|last| last.question_s);
        let next = self.next();
        self.questions[usize::from(next) % KEPT] = (next, now_s);
        self.question_s = now_s;
        self.send(&ToBoard::Poll)?;
        let until = self.wire.now() + wait;
        while self.last.is_none_or(|last| last.question_s < now_s) {
            let left = until.saturating_sub(self.wire.now());
            let came = self.receive(left)?;
            if self.unasked > MOST_UNASKED {
                return Err(self.lost("it keeps sending messages that nobody asked for"));
            }
            if self.reset {
                return Err(self.lost("the board has begun anew, or its clock went back"));
            }
            if came.is_none() {
                let newest_s = self.last.map(|last| last.question_s);
                self.late += u64::from(newest_s == before_s);
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// What a board can do behind this wire.
    fn capabilities_of(&self, board: &Description) -> Result<Capabilities, DeviceError> {
        let can = capabilities(board, &self.settings)?;
        let shaft_per_lever = self.wording.shaft_per_lever().unwrap_or(can.shaft_per_lever);
        Ok(Capabilities { shaft_per_lever, ..can })
    }

    /// The newest answer as a reading.
    fn reading(&self, now_s: f64) -> Result<Reading, DeviceError> {
        let Some(Answer { seen, question_s, t_us }) = self.last else {
            return Err(self.lost("it does not answer"));
        };
        if seen.status & status::NO_MAGNET != 0 {
            return Err(self.lost("its angle sensor does not see the magnet"));
        }
        // At 0 V a watchdog takes nothing away.
        if seen.status & status::WATCHDOG != 0 && self.drive != Drive::default() {
            return Err(self.lost("its watchdog took the voltages away"));
        }
        let since_s = (now_s - question_s).max(0.0);
        let (newtons_per_count, zero_counts) = self.settings.scale();
        let force = f64::from(seen.force) - zero_counts;
        Ok(Reading {
            t_device_s: Some(t_us as f64 * 1e-6),
            angle: Angle::Counts(self.shaft.upwards(seen.counts)),
            angle_age_s: since_s + f64::from(seen.angle_age_us) * 1e-6,
            force_n: force * newtons_per_count,
            force_age_s: Some(since_s + f64::from(seen.force_age_us) * 1e-6),
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

/// Messages from before homing that are dropped there at most.
const MOST_OLD: usize = 64;
/// So many answers to questions of long ago may come one after the other, after a long pause of the
/// host.
const MOST_UNASKED: usize = 1024;

/// A reading is not looked for in more bytes than this: no wire brings them in a tick.
const MOST_BYTES: usize = 64 * MOST_WIRE;

impl<W: Wire> Device for Rig<W> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        if self.gone {
            self.come_back()?;
        }
        // What a board said when its port was opened, and to each question who it is, is known by
        // now.
        for _ in 0..MOST_OLD {
            if self.receive(Duration::ZERO)?.is_none() {
                break;
            }
        }
        (self.last, self.reset, self.unasked) = (None, false, 0);
        self.send(&ToBoard::Mark { code: mark::HOMING, number: 0 })?;
        let began = self.wire.now();
        let mut first = None;
        while self.wire.now() - began < HOMING {
            // The loop stands still meanwhile: its time goes on by that of the wire.
            let passed = self.wire.now() - began;
            self.poll(now_s + passed.as_secs_f64(), HELLO_EVERY)?;
            // The next homing connects anew to a board that is silent.
            self.gone = self.last.is_none();
            let counts = self.last.ok_or_else(|| self.lost("it does not answer"))?.seen.counts;
            self.shaft.rested(*first.get_or_insert(counts), counts).map_err(|what| {
                self.unable(what, "hold it still against its lower stop, then home again")
            })?;
        }
        if !self.shaft.is_stop(first.unwrap_or_default()) {
            let what = "the lever is not where its stop was before".to_owned();
            return Err(self.unable(what, "hold it against its lower stop, then home again"));
        }
        let now_s = self.last.map_or(now_s, |last| last.question_s);
        self.reading(now_s)
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let wait = self.patience.of(now_s - self.question_s);
        let came = self.poll(now_s, wait)?;
        self.patience.learn(came, !wait.is_zero());
        self.reading(now_s)
    }

    fn write(&mut self, _now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.drive = Drive::of(voltages, self.full);
        self.send(&ToBoard::Write(self.drive))
    }

    fn begin(&mut self, _now_s: f64, cue: &Cue<'_>) {
        let place = self.environments.iter().position(|id| *id == cue.environment.id);
        let environment = place.and_then(|place| u16::try_from(place).ok()).unwrap_or(u16::MAX);
        let number = u16::try_from(cue.trial).unwrap_or(u16::MAX);
        // A marker that does not arrive harms nothing; the next reading tells of a lost wire.
        let _ = self.send(&ToBoard::Mark { code: mark::ENVIRONMENT, number: environment });
        let _ = self.send(&ToBoard::Mark { code: mark::TRIAL, number });
    }

    fn mark(&mut self, moment: Moment) {
        // As above.
        let number = mark::number(moment);
        let _ = self.send(&ToBoard::Mark { code: mark::MOMENT, number });
    }
}

fn volts(millivolts: u32) -> f64 {
    f64::from(millivolts) * 1e-3
}

/// A board whose firmware is not for this program.
fn outdated(board: &Description, what: String) -> DeviceError {
    let remedy = "put the firmware of this zwidth on it".to_owned();
    DeviceError::Unable { device: board.name.clone(), what, remedy }
}

/// What a board can do behind its wire.
fn capabilities(board: &Description, settings: &Settings) -> Result<Capabilities, DeviceError> {
    if board.protocol != PROTOCOL {
        let what = format!("it speaks version {} of the protocol, not {PROTOCOL}", board.protocol);
        return Err(outdated(board, what));
    }
    if board.period_us == 0 || board.force_period_us == 0 || board.counts_per_turn < 2 {
        return Err(outdated(board, "it gives no rate, or no counts in a turn".to_owned()));
    }
    Ok(Capabilities {
        name: board.name.clone(),
        rate_hz: (1e6 / f64::from(board.period_us)).min(wire_rate_hz(settings.baud())),
        force_rate_hz: 1e6 / f64::from(board.force_period_us),
        counts_per_turn: Some(u32::from(board.counts_per_turn)),
        shaft_per_lever: settings.shaft_per_lever,
        motor_max_v: volts(board.motor_mv),
        brake_max_v: volts(board.brake_mv),
        watchdog_s: (board.watchdog_ms > 0).then(|| f64::from(board.watchdog_ms) * 1e-3),
        shows_moments: true,
        source: if board.simulated { Source::Twin } else { settings.unknown().source },
        channels: Vec::new(),
    })
}
