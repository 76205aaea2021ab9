//! How often a serial line can carry which messages.

/// Bits of a byte on a serial line: a start, eight, a stop.
const BITS: f64 = 10.0;

/// A stream is looked at so much more often than it sends: then none of its readings falls between
/// two looks, though board and host go by two clocks, and what has piled up is soon worked off.
pub(crate) const LOOKS_PER_READING: f64 = 1.25;

/// So many bytes are on the line for so long, s.
pub(crate) fn line_s(baud: u32, bytes: usize) -> f64 {
    BITS * bytes as f64 / f64::from(baud)
}

/// So many bytes go through so many times a second, Hz.
pub(crate) fn line_rate_hz(baud: u32, bytes: usize) -> f64 {
    1.0 / line_s(baud, bytes)
}

/// Readings a second of a stream: its readings go one way, a command for each look the other, Hz.
pub(crate) fn stream_rate_hz(baud: u32, reading_bytes: usize, command_bytes: usize) -> f64 {
    let commands_hz = line_rate_hz(baud, command_bytes) / LOOKS_PER_READING;
    line_rate_hz(baud, reading_bytes).min(commands_hz)
}
