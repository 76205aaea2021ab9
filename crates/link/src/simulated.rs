//! A rig in simulated time: a board, its serial lines, and their faults.
//!
//! Both ends use one clock, which moves on only while somebody waits: the loop for its next tick,
//! the host for an answer. Each byte takes the time of ten bits at its line's baud rate, and a line
//! delivers its messages in order. A message is what one end sends at once. One of them, counted
//! from the first, may meet with a [`Trouble`], so a session can be run with a fault in each of its
//! messages, and the same run always goes the same way.

use crate::rate::line_s;
use crate::{Board, Drive, Wire};
use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use zwidth_device::Clock;

/// How often a board looks around unasked, s.
const LOOK_S: f64 = 1e-3;
/// After so long without a write a board with a watchdog is at 0 V, and one look more, s.
const WATCHED_S: f64 = 0.052;
/// Bits in which a damaged byte may differ: those of Firmata's data.
const BITS: u64 = 7;
/// Bytes between one damaged place and the next one's, so that every place is met.
const PLACES: u64 = 5;

/// Whose messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Way {
    /// What the host says.
    ToBoard,
    /// What the board says.
    ToHost,
    /// What a load cell says at a port of its own.
    Cell,
}

impl Way {
    /// All there are.
    pub const ALL: [Self; 3] = [Self::ToBoard, Self::ToHost, Self::Cell];
}

/// What goes wrong with a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trouble {
    /// It does not arrive.
    Drop,
    /// It arrives twice.
    Duplicate,
    /// A bit of it arrives turned over.
    Corrupt,
    /// Its second half does not arrive.
    Half,
    /// It arrives so much later, s; what comes behind it on its line waits, what another line
    /// carries does not.
    Late(f64),
    /// The board begins anew instead.
    Reset,
    /// Its cable is pulled, and plugged in again after so long, s.
    Unplug(f64),
}

/// A board with its lines.
pub struct Bench(Arc<Mutex<Inside>>);

impl Clone for Bench {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

struct Inside {
    board: Board,
    now_s: f64,
    looked_s: f64,
    /// What the board needs for an answer, s.
    thinks_s: f64,
    lanes: [Lane; 3],
    trouble: Option<(Way, u64, Trouble)>,
    happened: bool,
    pulled: Option<Pulled>,
    /// A voltage was on for longer without a host than a watchdog allows.
    left_on: bool,
}

/// A cable that is out, from when until when, s.
struct Pulled {
    is_cell: bool,
    from_s: f64,
    until_s: f64,
}

struct Lane {
    baud: u32,
    /// When what was said last is through, s.
    free_s: f64,
    on: VecDeque<(f64, Vec<u8>)>,
    /// Messages so far.
    messages: u64,
}

impl Lane {
    fn new(baud: u32) -> Self {
        Self { baud, free_s: 0.0, on: VecDeque::new(), messages: 0 }
    }

    fn carry(&mut self, now_s: f64, bytes: Vec<u8>) {
        self.free_s = self.free_s.max(now_s) + line_s(self.baud, bytes.len());
        self.on.push_back((self.free_s, bytes));
    }

    /// When the next message arrives, s.
    fn next_s(&self) -> f64 {
        self.on.front().map_or(f64::INFINITY, |(at_s, _)| *at_s)
    }

    fn arrived(&mut self, now_s: f64) -> Option<Vec<u8>> {
        self.on.pop_front_if(|(at_s, _)| *at_s <= now_s).map(|(_, bytes)| bytes)
    }
}

impl Inside {
    /// When the board hears or looks next, s.
    fn next_s(&self) -> f64 {
        self.lanes[0].next_s().min(self.looked_s + LOOK_S)
    }

    /// Everything that happens until then.
    fn go_on(&mut self, until_s: f64) {
        loop {
            let look_s = self.looked_s + LOOK_S;
            let next_s = self.next_s();
            if next_s > until_s {
                break;
            }
            self.now_s = self.now_s.max(next_s);
            let bytes = self.lanes[0].arrived(next_s).unwrap_or_default();
            if next_s >= look_s {
                self.looked_s = look_s;
            }
            let mut out = Vec::new();
            let now_s = self.now_s;
            // A board whose device is lost says nothing.
            let _ = self.board.take(now_s, &bytes, &mut out);
            let weighed = self.board.load_cell();
            self.say(Way::ToHost, now_s + self.thinks_s, out);
            self.say(Way::Cell, now_s, weighed);
            if let Some(Pulled { from_s, until_s, .. }) = self.pulled {
                let on = self.board.drive() != Drive::default();
                self.left_on |= on && now_s > from_s + WATCHED_S && now_s < until_s;
            }
        }
        self.now_s = self.now_s.max(until_s);
    }

    fn say(&mut self, way: Way, now_s: f64, mut bytes: Vec<u8>) {
        if bytes.is_empty() || self.is_pulled(way) {
            return;
        }
        let lane = &mut self.lanes[way as usize];
        let nth = lane.messages;
        lane.messages += 1;
        let troubled = self.trouble.filter(|(of_way, which, _)| (*of_way, *which) == (way, nth));
        let Some((_, _, trouble)) = troubled else { return lane.carry(now_s, bytes) };
        self.happened = true;
        match trouble {
            Trouble::Drop => {}
            Trouble::Duplicate => {
                lane.carry(now_s, bytes.clone());
                lane.carry(now_s, bytes);
            }
            Trouble::Corrupt => {
                let place = (nth * PLACES % bytes.len() as u64) as usize;
                bytes[place] ^= 1 << (nth % BITS);
                lane.carry(now_s, bytes);
            }
            Trouble::Half => {
                bytes.truncate(bytes.len() / 2);
                lane.carry(now_s, bytes);
            }
            Trouble::Late(by_s) => {
                lane.free_s = lane.free_s.max(now_s) + by_s;
                lane.carry(now_s, bytes);
            }
            // Of a device that is lost there is nothing to say.
            Trouble::Reset => drop(self.board.reset(self.now_s)),
            Trouble::Unplug(for_s) => {
                let (is_cell, until_s) = (way == Way::Cell, now_s + for_s);
                self.pulled = Some(Pulled { is_cell, from_s: now_s, until_s });
                self.lanes.iter_mut().for_each(|lane| lane.on.clear());
            }
        }
    }

    /// Whether this way's cable is out.
    fn is_pulled(&self, way: Way) -> bool {
        let is_cell = way == Way::Cell;
        let pulled = self.pulled.as_ref();
        pulled.is_some_and(|pulled| pulled.is_cell == is_cell && self.now_s < pulled.until_s)
    }
}

impl Bench {
    /// A board at lines with these bits per second, its own and its load cell's, that needs this
    /// time for an answer, s.
    pub fn new(board: Board, baud: u32, cell_baud: u32, thinks_s: f64) -> Self {
        let lanes = [Lane::new(baud), Lane::new(baud), Lane::new(cell_baud)];
        Self(Arc::new(Mutex::new(Inside {
            board,
            now_s: 0.0,
            looked_s: 0.0,
            thinks_s,
            lanes,
            trouble: None,
            happened: false,
            pulled: None,
            left_on: false,
        })))
    }

    fn inside(&self) -> MutexGuard<'_, Inside> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The host's end of the board's line.
    pub fn wire(&self) -> End {
        End { bench: self.clone(), way: Way::ToHost, gone: false, left: Vec::new() }
    }

    /// The host's end of the load cell's line.
    pub fn cell(&self) -> End {
        End { way: Way::Cell, ..self.wire() }
    }

    /// Puts another board there.
    pub fn replace(&self, board: Board) {
        self.inside().board = board;
    }

    /// Has this message of that way go wrong.
    pub fn trouble(&self, way: Way, nth: u64, trouble: Trouble) {
        self.inside().trouble = Some((way, nth, trouble));
    }

    /// Whether it came to that.
    pub fn happened(&self) -> bool {
        self.inside().happened
    }

    /// Messages that were said on a way.
    pub fn said(&self, way: Way) -> u64 {
        self.inside().lanes[way as usize].messages
    }

    /// The voltages that are out.
    pub fn drive(&self) -> Drive {
        self.inside().board.drive()
    }

    /// Whether a voltage stayed on without a cable for longer than a watchdog allows.
    pub fn left_on(&self) -> bool {
        self.inside().left_on
    }

    /// Now, s.
    pub fn now_s(&self) -> f64 {
        self.inside().now_s
    }

    /// Lets time pass.
    pub fn wait(&self, for_s: f64) {
        let mut inside = self.inside();
        let until_s = inside.now_s + for_s;
        inside.go_on(until_s);
    }
}

impl Clock for Bench {
    fn now_s(&mut self) -> f64 {
        Self::now_s(self)
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        let mut inside = self.inside();
        inside.go_on(deadline_s);
        inside.now_s
    }
}

/// The host's end of a line.
pub struct End {
    bench: Bench,
    way: Way,
    /// It saw its cable pulled, and was not opened again since.
    gone: bool,
    /// Of what has arrived what nobody took yet.
    left: Vec<u8>,
}

impl End {
    fn check(&mut self, inside: &Inside) -> io::Result<()> {
        self.gone |= inside.is_pulled(self.way);
        if self.gone { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(()) }
    }
}

impl Wire for End {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let bench = self.bench.clone();
        let mut inside = bench.inside();
        let until_s = inside.now_s + wait.as_secs_f64();
        let way = self.way as usize;
        loop {
            self.check(&inside)?;
            let now_s = inside.now_s;
            while let Some(bytes) = inside.lanes[way].arrived(now_s) {
                self.left.extend(bytes);
            }
            if !self.left.is_empty() || now_s >= until_s {
                break;
            }
            // The board may say something meanwhile: no further than where it can at a time.
            let next_s = inside.lanes[way].next_s().min(inside.next_s().max(now_s)).min(until_s);
            inside.go_on(next_s);
        }
        let n = into.len().min(self.left.len());
        into[..n].copy_from_slice(&self.left[..n]);
        self.left.drain(..n);
        Ok(n)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let bench = self.bench.clone();
        let mut inside = bench.inside();
        self.check(&inside)?;
        let now_s = inside.now_s;
        inside.say(Way::ToBoard, now_s, bytes.to_vec());
        Ok(())
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.bench.now_s())
    }

    fn reopen(&mut self) -> io::Result<()> {
        let bench = self.bench.clone();
        if bench.inside().is_pulled(self.way) {
            return Err(io::ErrorKind::NotFound.into());
        }
        (self.gone, self.left) = (false, Vec::new());
        Ok(())
    }
}
