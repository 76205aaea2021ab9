//! Lines of text: those that an existing sketch prints, and the commands that it takes.
//!
//! A [`Template`] says what a line contains; [`Lines`] finds the lines in the incoming bytes. Only
//! the form of a line is checked: a digit that a noisy wire changed is believed. So text is meant
//! for a board behind USB, whose packets have a checksum.

mod board;
mod host;
mod link;
mod settings;
mod template;

pub(crate) use settings::named;
pub use settings::{Templates, Text};
pub use template::{Field, MOST_ANY, Template, TemplateError, Values};

/// Longest line, bytes without its end.
pub const MOST_LINE: usize = 128;

/// Takes bytes as they come, in whatever pieces, and gives lines. Its memory is bounded.
///
/// A line ends with `\n`; a `\r` before it is not part of it. Bytes before the first end are
/// dropped, because they may be half a line.
#[derive(Debug, Clone)]
pub struct Lines<const MOST: usize = MOST_LINE> {
    bytes: [u8; MOST],
    length: usize,
    /// What comes until the next end is too long, or has no beginning.
    dropped: bool,
    /// The line that was handed out last is still in `bytes`.
    handed_out: bool,
    /// Lines that were too long.
    damaged: u64,
}

impl Lines {
    /// Of a board: a host begins anywhere in what it prints.
    pub fn from_anywhere() -> Self {
        Self { dropped: true, ..Self::whole() }
    }

    /// Of a host: a board hears it from its first byte on.
    pub fn from_start() -> Self {
        Self::whole()
    }
}

impl<const MOST: usize> Lines<MOST> {
    /// Heard from the first byte on.
    pub fn whole() -> Self {
        Self { bytes: [0; MOST], length: 0, dropped: false, handed_out: false, damaged: 0 }
    }

    /// Takes one byte; the line that it ends.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if std::mem::take(&mut self.handed_out) {
            self.length = 0;
        }
        if byte != b'\n' {
            match self.bytes.get_mut(self.length) {
                _ if self.dropped => {}
                Some(place) => (*place, self.length) = (byte, self.length + 1),
                None => (self.dropped, self.damaged) = (true, self.damaged + 1),
            }
            return None;
        }
        if std::mem::take(&mut self.dropped) {
            self.length = 0;
            return None;
        }
        self.handed_out = true;
        let line = &self.bytes[..self.length];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Lines that were too long, so far.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(lines: &mut Lines, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut found = Vec::new();
        for byte in bytes {
            found.extend(lines.push(*byte).map(<[u8]>::to_vec));
        }
        found
    }

    #[test]
    fn half_a_line_at_the_beginning_is_dropped_where_a_line_may_have_begun_before() {
        let bytes = b"23\n8123\r\n\n-7\n9";
        let expect = [&b"8123"[..], b"", b"-7"];
        assert_eq!(read(&mut Lines::from_anywhere(), bytes), expect);
        assert_eq!(read(&mut Lines::from_start(), bytes)[0], b"23");
    }

    #[test]
    fn a_line_that_is_too_long_is_counted_once_and_the_next_one_is_whole() {
        let mut lines = Lines::from_start();
        let long = [vec![b'1'; 10 * MOST_LINE], b"\n".to_vec(), b"2\n".to_vec()].concat();
        assert_eq!(read(&mut lines, &long), [b"2"]);
        assert_eq!(lines.damaged(), 1);
        let most = [vec![b'1'; MOST_LINE], b"\n".to_vec()].concat();
        assert_eq!(read(&mut lines, &most)[0].len(), MOST_LINE);
    }

    proptest! {
        #[test]
        fn lines_are_what_stands_between_two_ends(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), Just(b'\r'), any::<u8>()], 0..600),
        ) {
            let found = read(&mut Lines::from_start(), &bytes);
            let mut pieces: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            pieces.pop();
            pieces.retain(|piece| piece.len() <= MOST_LINE);
            let expect = pieces.into_iter().map(|p| p.strip_suffix(b"\r").unwrap_or(p));
            prop_assert_eq!(found, expect.map(<[u8]>::to_vec).collect::<Vec<_>>());
        }
    }
}
