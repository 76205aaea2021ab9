//! The sweeps laid end to end, checked once.

use crate::error::CharacteriseError;
use crate::steps::{Cell, Gathered, Steps};
use core::ops::Range;
use zwidth_numerics::branch::{Branch, branches};

/// Three blocks of two points: a line through two of them keeps degrees of freedom.
const MIN_POINTS: usize = 6;
/// Two commands make a line; a third shows whether it is one.
const MIN_COMMANDS: usize = 3;

/// One ramp of an actuator (or of a load on a sensor), in the order of recording. Units are the
/// caller's.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// The values that were set: volts, counts, newtons, …
    pub command: &'a [f64],
    /// The measured values, one per command. A held value belongs here once, at its own update:
    /// repeated, it would hide the noise. The recorder leaves out samples that cannot show the
    /// response: a brake gives no force of its own unless the lever slips.
    pub response: &'a [f64],
}

/// All sweeps, end to end in the order of recording.
pub(crate) struct Samples {
    pub(crate) command: Vec<f64>,
    pub(crate) response: Vec<f64>,
    /// The way the command was going.
    pub(crate) branch: Vec<Branch>,
    /// The range of each sweep.
    pub(crate) sweeps: Vec<Range<usize>>,
    /// The steps of the command that fits are made on.
    pub(crate) steps: Steps,
}

impl Samples {
    pub(crate) fn new(sweeps: &[Sweep]) -> Result<Self, CharacteriseError> {
        sweeps.iter().enumerate().try_for_each(|(number, sweep)| check(number, sweep))?;
        let mut end = 0;
        let mut ranges = Vec::new();
        for sweep in sweeps {
            let start = end;
            end += sweep.command.len();
            // A sweep without samples would be an empty fold.
            if start < end {
                ranges.push(start..end);
            }
        }
        let command: Vec<f64> = sweeps.iter().flat_map(|s| s.command).copied().collect();
        let response: Vec<f64> = sweeps.iter().flat_map(|s| s.response).copied().collect();
        let branch = sweeps.iter().flat_map(|s| branches(s.command)).collect();
        let steps = Steps::new(&command);
        let points = command.len();
        let commands = steps.levels.len();
        if points < MIN_POINTS || commands < MIN_COMMANDS {
            return Err(CharacteriseError::Refused(format!(
                "{points} points at {commands} different commands cannot show a characteristic: \
                 need at least {MIN_POINTS} points and {MIN_COMMANDS} commands"
            )));
        }
        Ok(Self { sweeps: ranges, command, response, branch, steps })
    }

    pub(crate) fn len(&self) -> usize {
        self.command.len()
    }

    /// Lowest and highest command.
    pub(crate) fn command_range(&self) -> (f64, f64) {
        let commands = self.command.iter().copied();
        (commands.clone().fold(f64::INFINITY, f64::min), commands.fold(f64::NEG_INFINITY, f64::max))
    }

    /// Whether the command went both up and down.
    pub(crate) fn has_both_branches(&self) -> bool {
        self.branch.iter().any(|b| *b != self.branch[0])
    }

    /// The samples of `range` gathered by branch and step.
    pub(crate) fn cells(&self, range: Range<usize>) -> Vec<Cell> {
        self.steps.cells(range, &self.command, &self.response, &self.branch)
    }

    /// Everything with other responses (a resample).
    pub(crate) fn with_response(&self, response: &[f64]) -> Gathered<'_> {
        let cells = self.steps.cells(0..self.len(), &self.command, response, &self.branch);
        self.steps.gather([(cells.as_slice(), 1)].into_iter())
    }

    /// Everything, as it was measured.
    pub(crate) fn gathered(&self) -> Gathered<'_> {
        self.with_response(&self.response)
    }
}

/// Checks that both columns of a sweep are equally long and finite.
fn check(number: usize, sweep: &Sweep) -> Result<(), CharacteriseError> {
    let commands = sweep.command.len();
    let responses = sweep.response.len();
    if commands != responses {
        return Err(CharacteriseError::Refused(format!(
            "sweep {number} has {commands} commands and {responses} responses: each sample needs both"
        )));
    }
    for (column, values) in [("command", sweep.command), ("response", sweep.response)] {
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            let value = values[row];
            return Err(CharacteriseError::Refused(format!(
                "sweep {number}, row {row}: the {column} is {value}; drop the row or mend its source"
            )));
        }
    }
    Ok(())
}

/// `range` in `parts` contiguous pieces whose lengths differ by one at most; `parts` ≥ 1.
pub(crate) fn split(range: &Range<usize>, parts: usize) -> Vec<Range<usize>> {
    let mut start = range.start;
    let mut pieces = Vec::with_capacity(parts);
    for part in 1..=parts {
        let end = range.start + part * range.len() / parts;
        pieces.push(start..end);
        start = end;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_error(sweeps: &[(&[f64], &[f64])], expected: &str) {
        let sweeps: Vec<_> =
            sweeps.iter().map(|&(command, response)| Sweep { command, response }).collect();
        assert_eq!(Samples::new(&sweeps).err().map(|e| e.to_string()).as_deref(), Some(expected));
    }

    #[test]
    fn sweeps_lie_end_to_end_and_know_their_branches() {
        let up = Sweep { command: &[0.0, 1.0, 2.0], response: &[0.0, 1.0, 2.0] };
        let down = Sweep { command: &[2.0, 1.0, 0.5], response: &[2.5, 1.5, 1.0] };
        let samples = Samples::new(&[up, down]).unwrap();
        assert_eq!(samples.steps.levels, [0.0, 0.5, 1.0, 2.0]);
        assert_eq!(samples.sweeps, [0..3, 3..6]);
        assert_eq!(
            samples.branch,
            [Branch::Up, Branch::Up, Branch::Up, Branch::Down, Branch::Down, Branch::Down]
        );
    }

    #[test]
    fn pieces_cover_the_range_in_order() {
        assert_eq!(split(&(5..12), 3), [5..7, 7..9, 9..12]);
    }

    #[test]
    fn bad_sweeps_are_named_with_sweep_and_row() {
        let good: (&[f64], &[f64]) = (&[0.0, 1.0], &[0.0, 1.0]);
        check_error(
            &[good, (&[0.0, 1.0], &[0.0])],
            "sweep 1 has 2 commands and 1 responses: each sample needs both",
        );
        check_error(
            &[good, (&[0.0, f64::NAN], &[0.0, 1.0])],
            "sweep 1, row 1: the command is NaN; drop the row or mend its source",
        );
        check_error(
            &[good, good, good],
            "6 points at 2 different commands cannot show a characteristic: need at least 6 points and 3 commands",
        );
        check_error(
            &[],
            "0 points at 0 different commands cannot show a characteristic: need at least 6 points and 3 commands",
        );
    }
}
