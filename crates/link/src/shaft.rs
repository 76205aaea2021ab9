//! The angle sensor's shaft: counts within a turn, and where the lever's stop is among them.

use crate::Turning;

/// A lever is at rest at its stop where its count moves by no more than this, turns of the shaft.
const STILL_TURNS: f64 = 0.01;
/// A stop is where it was at the last homing to within this, turns of the shaft: 2.6° of the
/// prototype's lever.
const SAME_STOP_TURNS: f64 = 0.05;

/// A shaft.
#[derive(Debug, Clone)]
pub(crate) struct Shaft {
    pub(crate) counts_per_turn: u16,
    pub(crate) turning: Turning,
    /// The count at the stop, from the first homing on.
    pub(crate) stop_counts: Option<u16>,
}

impl Shaft {
    /// One that was not homed yet.
    pub(crate) fn new(counts_per_turn: u16, turning: Turning) -> Self {
        Self { counts_per_turn, turning, stop_counts: None }
    }

    /// A count as of a sensor that counts up with +θ.
    pub(crate) fn upwards(&self, counts: u16) -> u16 {
        match self.turning {
            Turning::Up => counts,
            Turning::Down => {
                (self.counts_per_turn - counts % self.counts_per_turn) % self.counts_per_turn
            }
        }
    }

    /// Whether the lever rested from one count to another; if not, what it did.
    ///
    /// # Errors
    /// By how much it moved.
    pub(crate) fn rested(&self, from: u16, to: u16) -> Result<(), String> {
        let turns = self.turns(from, to).abs();
        if turns > STILL_TURNS {
            return Err(format!("the lever moves by {:.1} % of a shaft's turn", 100.0 * turns));
        }
        Ok(())
    }

    /// Whether this is the count of the stop, which the first one is.
    pub(crate) fn is_stop(&mut self, counts: u16) -> bool {
        let stop = *self.stop_counts.get_or_insert(counts);
        self.turns(stop, counts).abs() <= SAME_STOP_TURNS
    }

    /// Turns of the shaft from one count to another, the shorter way.
    fn turns(&self, from: u16, to: u16) -> f64 {
        let share = (f64::from(to) - f64::from(from)) / f64::from(self.counts_per_turn);
        share - share.round()
    }
}
