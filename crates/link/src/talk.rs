//! What a host needs from a link whose board sends readings unasked: bytes in, readings out, and
//! back.

use crate::Drive;
use zwidth_device::DeviceError;
use zwidth_study::Voltages;

/// What is settled before a board has said a word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plan {
    /// Readings a second.
    pub(crate) rate_hz: f64,
    /// Full scale, V.
    pub(crate) full: Voltages,
    /// Seconds of one step of the board's clock.
    pub(crate) tick_s: f64,
    /// Whether the board takes a trial's moments ([`Talk::mark`]).
    pub(crate) shows_moments: bool,
}

/// What a board is, once it is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Facts {
    /// What it is called.
    pub(crate) name: String,
    /// Counts of the angle sensor in a turn.
    pub(crate) counts_per_turn: u16,
    /// It says that what it sends is simulated.
    pub(crate) simulated: bool,
}

/// What was heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Heard {
    /// A reading: the angle sensor's count, and what came with it.
    Reading {
        /// The board's clock, in its steps, round after 2³².
        ticks: Option<u32>,
        counts: u16,
        /// The load cell's count.
        force: Option<i32>,
    },
    /// The board has begun anew.
    Reset,
}

/// The host's end of such a link. Sans-IO: bytes come and go through its caller.
pub(crate) trait Talk: Send {
    fn plan(&self) -> Plan;

    /// Forgets what was heard: another board may be there now.
    fn begin_anew(&mut self);

    /// Asks the board who it is.
    fn hello(&mut self, out: &mut Vec<u8>);

    /// Who it is, once enough of it is known; what it cannot do is an error.
    fn facts(&self) -> Option<Result<Facts, DeviceError>>;

    /// Makes it send readings.
    fn begin(&mut self, out: &mut Vec<u8>);

    /// Takes one byte; what was heard with it.
    fn push(&mut self, byte: u8) -> Option<Heard>;

    /// Commands both voltages.
    fn write(&mut self, drive: Drive, out: &mut Vec<u8>);

    /// Tells a marker ([`crate::mark`]).
    fn mark(&mut self, code: u8, number: u16, out: &mut Vec<u8>);

    /// Pieces that were no message, so far.
    fn damaged(&self) -> u64;
}
