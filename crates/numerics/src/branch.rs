//! Whether the command was going up or down: an actuator may respond differently to the two.

/// A command that falls back (or recovers) by more than this share of its sweep's span has turned;
/// less is jitter of a measured command.
const TURN: f64 = 0.02;

/// The way the command was going.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Branch {
    /// The command rises (or rests at its highest).
    Up,
    /// The command falls (or rests at its lowest).
    Down,
}

impl Branch {
    /// Both, up first.
    pub const ALL: [Self; 2] = [Self::Up, Self::Down];

    /// `up` or `down`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// The branch of each sample of one sweep, in the order of recording.
///
/// A branch ends at its furthest command (the last of equals) as soon as the command has come back
/// from there by more than 2 % of the sweep's span. Samples left out of the recording do not
/// matter: only the commands' order does. A command that never moves is on its way up.
pub fn branches(command: &[f64]) -> Vec<Branch> {
    let highest = command.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = command.iter().copied().fold(f64::INFINITY, f64::min);
    let threshold = TURN * (highest - lowest);
    let departure = command.iter().find(|x| (*x - command[0]).abs() > threshold);
    let is_down = departure.is_some_and(|x| *x <= command[0]);
    let mut branch = if is_down { Branch::Down } else { Branch::Up };
    let mut branches = Vec::with_capacity(command.len());
    let mut furthest = 0;
    for (i, &x) in command.iter().enumerate() {
        branches.push(branch);
        // How far the furthest command lies ahead on this branch.
        let (lost, other) = match branch {
            Branch::Up => (command[furthest] - x, Branch::Down),
            Branch::Down => (x - command[furthest], Branch::Up),
        };
        if lost <= 0.0 {
            furthest = i;
        } else if lost > threshold {
            branch = other;
            // The turn shows only now, but the way back began right after the furthest command.
            branches[furthest + 1..].fill(branch);
            furthest = i;
        }
    }
    branches
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(command: &[f64], expect: &str) {
        let letter = |b: &Branch| if *b == Branch::Up { 'u' } else { 'd' };
        assert_eq!(branches(command).iter().map(letter).collect::<String>(), expect);
    }

    #[test]
    fn a_ramp_turns_after_the_last_of_its_highest_commands() {
        check(&[0.0, 1.0, 2.0, 2.0, 1.0, 0.0], "uuuudd");
        check(&[2.0, 1.0, 0.0, 1.0, 2.0], "ddduu");
        check(&[0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0], "uuuddduu");
    }

    #[test]
    fn jitter_is_no_turn() {
        check(&[0.0, 5.0, 4.9, 5.0, 10.0, 9.9, 10.0, 5.0, 5.1, 0.0], "uuuuuuuddd");
        check(&[0.1, 0.0, 5.0, 10.0], "uuuu");
    }

    #[test]
    fn a_command_that_stands_still_and_no_command_at_all_are_no_error() {
        check(&[3.0, 3.0], "uu");
        check(&[], "");
    }

    /// A brake that does not slip below 3: those samples are not recorded.
    #[test]
    fn what_was_not_recorded_does_not_matter() {
        check(&[3.0, 4.0, 8.0, 7.0, 3.0], "uuudd");
    }
}
