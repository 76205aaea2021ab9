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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn homing_takes_a_lever_that_rests_at_its_stop_and_no_other(
            counts_per_turn in 100..=u16::MAX,
            stop in any::<prop::sample::Index>(),
            off_turns in -0.5..0.5_f64,
            noise_turns in -0.5..0.5_f64,
        ) {
            let per_turn = f64::from(counts_per_turn);
            let stop = stop.index(counts_per_turn.into()) as u16;
            let at = |turns: f64| {
                let counts = (f64::from(stop) + turns * per_turn).round();
                counts.rem_euclid(per_turn) as u16
            };
            let mut shaft = Shaft::new(counts_per_turn, Turning::Up);
            prop_assert!(shaft.is_stop(stop), "the first one is the stop");
            // What lies within one count of a limit may fall to either side of it.
            let near = |turns: f64, limit: f64| (turns.abs() - limit).abs() < 1.0 / per_turn;
            if !near(off_turns, SAME_STOP_TURNS) {
                prop_assert_eq!(shaft.is_stop(at(off_turns)), off_turns.abs() < SAME_STOP_TURNS);
            }
            if !near(noise_turns, STILL_TURNS) {
                let rested = shaft.rested(stop, at(noise_turns)).is_ok();
                prop_assert_eq!(rested, noise_turns.abs() < STILL_TURNS);
            }
        }
    }
}
