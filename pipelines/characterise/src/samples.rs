//! The sweeps laid end to end, checked once.

use crate::error::{CharacteriseError, MIN_COMMANDS, MIN_POINTS};
use crate::models::Points;
use core::ops::Range;

/// One ramp of an actuator (or of a load on a sensor), in the order of recording. Units are the caller's.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// What was set: volts, counts, newtons, …
    pub command: &'a [f64],
    /// What was measured, one a command. A held value belongs in here once, at its own update: repeated, it
    /// would hide the noise.
    pub response: &'a [f64],
}

/// All sweeps, end to end in the order of recording.
pub(crate) struct Samples {
    pub(crate) command: Vec<f64>,
    pub(crate) response: Vec<f64>,
    /// Where each sweep lies.
    pub(crate) sweeps: Vec<Range<usize>>,
    /// Indices of the samples by rising command; equal commands in the order of recording.
    pub(crate) order: Vec<usize>,
    /// The different commands, rising.
    pub(crate) levels: Vec<f64>,
}

impl Samples {
    pub(crate) fn new(sweeps: &[Sweep]) -> Result<Self, CharacteriseError> {
        sweeps.iter().enumerate().try_for_each(|(number, sweep)| check(number, sweep))?;
        let command: Vec<f64> = sweeps.iter().flat_map(|s| s.command).copied().collect();
        let response: Vec<f64> = sweeps.iter().flat_map(|s| s.response).copied().collect();
        let mut order: Vec<usize> = (0..command.len()).collect();
        order.sort_by(|&i, &j| command[i].total_cmp(&command[j]));
        let levels = distinct(order.iter().map(|&i| command[i]));
        if command.len() < MIN_POINTS || levels.len() < MIN_COMMANDS {
            return Err(CharacteriseError::TooFew { points: command.len(), commands: levels.len() });
        }
        Ok(Self { sweeps: ranges(sweeps), command, response, order, levels })
    }

    pub(crate) fn len(&self) -> usize {
        self.command.len()
    }

    /// The samples as a model sees them, with other responses (a resample) or weights (a fold).
    pub(crate) fn points<'a>(&'a self, response: &'a [f64], weight: &'a [f64]) -> Points<'a> {
        Points { command: &self.command, response, weight, order: &self.order, levels: &self.levels }
    }
}

fn check(number: usize, sweep: &Sweep) -> Result<(), CharacteriseError> {
    let (commands, responses) = (sweep.command.len(), sweep.response.len());
    if commands != responses {
        return Err(CharacteriseError::LengthMismatch { sweep: number, commands, responses });
    }
    for (column, values) in [("command", sweep.command), ("response", sweep.response)] {
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            return Err(CharacteriseError::NonFinite { sweep: number, row, column, value: values[row] });
        }
    }
    Ok(())
}

/// Where each sweep that is not empty lies in the whole.
fn ranges(sweeps: &[Sweep]) -> Vec<Range<usize>> {
    let mut end = 0;
    let all = sweeps.iter().map(|s| {
        let start = end;
        end += s.command.len();
        start..end
    });
    all.filter(|r| !r.is_empty()).collect()
}

fn distinct(rising: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut levels: Vec<f64> = Vec::new();
    for command in rising {
        if levels.last().is_none_or(|&last| command > last) {
            levels.push(command);
        }
    }
    levels
}

/// `range` in `parts` contiguous pieces whose lengths differ by one at most; `parts` ≥ 1.
pub(crate) fn split(range: &Range<usize>, parts: usize) -> Vec<Range<usize>> {
    let edge = |part: usize| range.start + part * range.len() / parts;
    (0..parts).map(|part| edge(part)..edge(part + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_error(sweeps: &[(&[f64], &[f64])], expected: &str) {
        let sweeps: Vec<_> = sweeps.iter().map(|&(command, response)| Sweep { command, response }).collect();
        assert_eq!(Samples::new(&sweeps).err().map(|e| e.to_string()).as_deref(), Some(expected));
    }

    #[test]
    fn samples_are_ordered_by_command_and_levels_are_distinct() {
        let up = Sweep { command: &[0.0, 1.0, 2.0], response: &[0.0, 1.0, 2.0] };
        let down = Sweep { command: &[2.0, 1.0, 0.5], response: &[2.5, 1.5, 1.0] };
        let samples = Samples::new(&[up, down]).unwrap();
        assert_eq!(samples.order, [0, 5, 1, 4, 2, 3]);
        assert_eq!(samples.levels, [0.0, 0.5, 1.0, 2.0]);
        assert_eq!(samples.sweeps, [0..3, 3..6]);
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
