//! How the messages of a link whose host asks are written: as frames, or as another link has them.

use super::frame::Frames;
use super::message::{FromBoard, ToBoard};
use std::time::Duration;

/// The host's end: bytes in, messages out, and back.
pub(crate) trait Wording: Send {
    /// Takes one byte; the message that it closes, with its number. An error where the other end must
    /// not say what is not understood, because nothing on the way can have damaged it.
    fn push(&mut self, byte: u8) -> Option<Result<(u16, FromBoard), String>>;

    /// Writes a message with its number behind `out`.
    fn say(&mut self, message: &ToBoard, number: u16, out: &mut Vec<u8>);

    /// Forgets what came since the last message: another line begins.
    fn begin_anew(&mut self);

    /// Pieces that were no message, so far.
    fn damaged(&self) -> u64;

    /// Turns of the counted shaft in one turn of the lever, where the other end says so.
    fn shaft_per_lever(&self) -> Option<f64>;

    /// How long the other end may take to say who it is.
    fn begins_within(&self) -> Duration;

    /// What is told if it does not, and what to do.
    fn silent(&self, baud: u32) -> (String, &'static str);
}

impl Wording for Frames {
    fn push(&mut self, byte: u8) -> Option<Result<(u16, FromBoard), String>> {
        let frame = Frames::push(self, byte)?;
        FromBoard::read(&frame).map(|message| Ok((frame.sequence, message)))
    }

    fn say(&mut self, message: &ToBoard, number: u16, out: &mut Vec<u8>) {
        let (bytes, length) = message.frame(number).encode();
        out.extend(&bytes[..length]);
    }

    fn begin_anew(&mut self) {
        Frames::begin_anew(self);
    }

    fn damaged(&self) -> u64 {
        Frames::damaged(self)
    }

    fn shaft_per_lever(&self) -> Option<f64> {
        None
    }

    /// Many boards reset themselves when their port is opened.
    fn begins_within(&self) -> Duration {
        Duration::from_secs(4)
    }

    fn silent(&self, baud: u32) -> (String, &'static str) {
        let remedy = "check port and baud in rig.toml, and that the board runs the framed firmware (docs/rig.md); `zwidth ports PORT` asks who is there";
        (format!("nothing answers at {baud} baud"), remedy)
    }
}

/// The board's end.
pub(crate) trait BoardWording: Send {
    /// Takes one byte; the message that it closes, with its number.
    fn hear(&mut self, byte: u8) -> Option<(u16, ToBoard)>;

    /// Writes a message with its number behind `out`.
    fn answer(&mut self, message: &FromBoard, number: u16, out: &mut Vec<u8>);

    /// Forgets all that was heard.
    fn reset(&mut self);
}

impl BoardWording for Frames {
    fn hear(&mut self, byte: u8) -> Option<(u16, ToBoard)> {
        let frame = Frames::push(self, byte)?;
        Some((frame.sequence, ToBoard::read(&frame)?))
    }

    fn answer(&mut self, message: &FromBoard, number: u16, out: &mut Vec<u8>) {
        let (bytes, length) = message.frame(number).encode();
        out.extend(&bytes[..length]);
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}
