//! A host that receives arbitrary bytes, for tests.

use crate::Drive;
use crate::Settings;
use crate::talk::Heard;
use zwidth_device::DeviceError;

/// What the host's end of a link that streams heard in some bytes, and what it says at its
/// beginning.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Told {
    /// The angle sensor's counts, in their order.
    pub counts: Vec<u16>,
    /// Pieces that were no message.
    pub damaged: u64,
    /// Counts in a turn of a board that said enough of itself.
    pub counts_per_turn: Option<u16>,
    /// The messages sent to it then.
    pub said: Vec<u8>,
}

/// Hears bytes as by these settings.
///
/// # Errors
/// Settings that make no sense; a board that cannot do what they say.
pub fn hear(settings: &Settings, bytes: &[u8]) -> Result<Told, DeviceError> {
    let mut heard = Told::default();
    let Some(mut talk) = settings.host()? else { return Ok(heard) };
    for byte in bytes {
        if let Some(Heard::Reading { counts, .. }) = talk.push(*byte) {
            heard.counts.push(counts);
        }
    }
    heard.damaged = talk.damaged();
    let Some(facts) = talk.facts() else { return Ok(heard) };
    heard.counts_per_turn = Some(facts?.counts_per_turn);
    talk.begin(&mut heard.said);
    talk.write(Drive { motor: i16::MIN, brake: i16::MAX }, &mut heard.said);
    talk.mark(u8::MAX, u16::MAX, &mut heard.said);
    Ok(heard)
}
