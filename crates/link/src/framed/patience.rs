//! How long the host waits for a framed answer.
//!
//! The question (9 bytes), the answer (31) and the command that follows from it (13) are on the
//! line one after another. If all three fit into a tick, the host waits for the answer, and its
//! command goes out in the same tick. If they do not, waiting would only delay the command: the
//! host takes the answer to the previous question, which came meanwhile, with its age.

use super::message::{FromBoard, Seen, ToBoard};
use crate::Drive;
use crate::rate::{line_rate_hz, line_s};
use std::time::Duration;

/// What a tick keeps for the host: being late, and the work between answer and command.
const HOST_SHARE: f64 = 0.2;
/// An answer is waited for no longer than this many times what the line needs…
const TIMES: f64 = 3.0;
/// …or this long, s: two frames of USB, which a converter waits for each way…
const USB_S: f64 = 2e-3;
/// …or this share of a tick: a loop that is slow has the time, and a reading that is a tick old is
/// too old to it.
const TICK_SHARE: f64 = 0.4;
/// In ticks longer than this an answer is always waited for, s.
const SHORT_S: f64 = 5e-3;
/// After so many answers in a row that did not come in their tick they are waited for no longer:
/// something between host and board holds them back.
const FUTILE: u32 = 8;
/// After so many ticks without waiting it is tried again.
const AGAIN: u32 = 1000;

/// Patience with the answers of one line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patience {
    /// Question and answer are on the line for so long, s.
    answer_s: f64,
    /// The command, s.
    command_s: f64,
    /// Answers in a row that did not come in their tick, and then ticks without waiting.
    futile: u32,
}

impl Patience {
    /// With a line of so many bits a second.
    pub(crate) fn at(baud: u32) -> Self {
        let [question, command, answer] = bytes();
        let answer_s = line_s(baud, question + answer);
        let command_s = line_s(baud, command);
        Self { answer_s, command_s, futile: 0 }
    }

    /// How long the answer is waited for in a tick that is so long, s.
    pub(crate) fn of(&self, period_s: f64) -> Duration {
        let room_s = (1.0 - HOST_SHARE) * period_s - self.command_s;
        if room_s < self.answer_s || (self.futile >= FUTILE && period_s < SHORT_S) {
            return Duration::ZERO;
        }
        let most_s = (TIMES * self.answer_s).max(USB_S).max(TICK_SHARE * period_s);
        Duration::from_secs_f64(room_s.min(most_s))
    }

    /// Takes in whether the answer of a tick came within it.
    pub(crate) fn learn(&mut self, came: bool, waited: bool) {
        self.futile = match (came, waited) {
            (true, _) => 0,
            (false, true) => self.futile + 1,
            (false, false) if self.futile < FUTILE => self.futile,
            (false, false) if self.futile < FUTILE + AGAIN => self.futile + 1,
            // One wait more; if it is futile too, the next ticks do not wait either.
            (false, false) => FUTILE - 1,
        };
    }

    /// Up to this rate an answer comes, and its command goes out, in its own tick, Hz.
    #[cfg(test)]
    pub(crate) fn same_tick_hz(&self) -> f64 {
        (1.0 - HOST_SHARE) / (self.answer_s + self.command_s)
    }
}

/// Bytes of a question, of a command and of an answer.
fn bytes() -> [usize; 3] {
    let seen = Seen {
        t_us: 0,
        counts: 0,
        angle_age_us: 0,
        force: 0,
        force_age_us: 0,
        status: 0,
        drive: Drive::default(),
    };
    let frames = [
        ToBoard::Poll.frame(0),
        ToBoard::Write(Drive::default()).frame(0),
        FromBoard::Seen(seen).frame(0),
    ];
    frames.map(|frame| frame.encode().1)
}

/// Ticks a second that a serial line carries: question and command go one way, the answer the
/// other, Hz.
pub(crate) fn wire_rate_hz(baud: u32) -> f64 {
    let [question, command, answer] = bytes();
    line_rate_hz(baud, answer.max(question + command))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_waited_for_where_it_and_its_command_have_room_in_the_tick() {
        assert_eq!(bytes(), [9, 13, 31]);
        // 53 bytes of ten bits in 80 % of a tick.
        for (baud, most_hz) in [(115_200, 173.9), (500_000, 754.7), (1_000_000, 1509.4)] {
            let patience = Patience::at(baud);
            assert!((patience.same_tick_hz() - most_hz).abs() < 0.1, "{}", patience.same_tick_hz());
            assert!(patience.of(1.001 / most_hz).as_secs_f64() >= patience.answer_s);
            assert_eq!(patience.of(0.998 / most_hz), Duration::ZERO);
        }
        assert!((wire_rate_hz(500_000) - 500_000.0 / 310.0).abs() < 1e-9);
    }

    #[test]
    fn a_loop_waits_for_an_answer_that_is_lost_no_longer_than_it_has_time() {
        let at = |baud, period_s| Patience::at(baud).of(period_s).as_secs_f64();
        let near = |found: f64, expect: f64| assert!((found - expect).abs() < 1e-9, "{found}");
        near(at(500_000, 5e-3), 2.4e-3);
        near(at(1_000_000, 4e-3), 2e-3);
        near(at(500_000, 0.1), 0.04);
    }

    #[test]
    fn answers_that_never_come_in_their_tick_are_waited_for_no_longer_and_tried_again() {
        let (mut patience, mut waited) = (Patience::at(1_000_000), Vec::new());
        for tick in 0..3000 {
            let waits = !patience.of(1e-3).is_zero();
            if waits {
                waited.push(tick);
            }
            patience.learn(false, waits);
        }
        assert_eq!(waited[..8], [0, 1, 2, 3, 4, 5, 6, 7]);
        assert!((2..=4).contains(&waited[8..].len()), "{waited:?}");
        patience.learn(true, true);
        assert!(!patience.of(1e-3).is_zero());
    }
}
