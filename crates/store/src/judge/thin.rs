//! A long trial as it is drawn: with fewer samples, among them the extremes of every stretch, so
//! that it looks as it would with all. Only one of its columns is in memory at a time.

use crate::form::columns::{Columns, LONG};
use crate::form::read::{OpenColumns, read_trial};
use crate::judge::samples::{check_samples, import_findings};
use crate::{Asked, RealFiles, Samples, Signal, StoreError, Trial};
use std::path::Path;

/// Reads a trial with these signals and its time; one of more than `most` samples with at most so
/// many of them: the first and last of all, and of each of equally long stretches the first and, of
/// each signal, the smallest and the largest. With it how many samples were recorded.
///
/// # Errors
/// Those of [`read_trial`].
pub fn read_thinned(
    path: &Path,
    signals: impl IntoIterator<Item = Signal>,
    most: usize,
) -> Result<(Trial, usize), StoreError> {
    let open = OpenColumns::open(&RealFiles, path)?;
    let mut signals: Vec<Signal> = signals.into_iter().filter(|s| *s != Signal::Time).collect();
    signals.sort();
    signals.dedup();
    if open.rows() <= most {
        return Ok((read_trial(path, signals)?, open.rows()));
    }
    let (meta, file) = open.meta_and_file()?;
    let (rows, last) = thinned(&open, &signals, most)?;
    let few = |values: &[f64]| rows.iter().map(|row| values[*row]).collect();
    let mut samples = Samples::default();
    let mut room = Vec::new();
    // That which was read last is still there.
    if let Some((signal, values)) = last {
        samples.set(signal, few(&values));
        signals.retain(|other| *other != signal);
        room = values;
    }
    for signal in signals.into_iter().chain([Signal::Time]) {
        if let Some(values) = open.signal_in(signal, std::mem::take(&mut room))? {
            samples.set(signal, few(&values));
            room = values;
        }
    }
    samples.check(path)?;
    Ok((Trial { meta, file, samples }, open.rows()))
}

/// What the trial at `path` is to be read with care for: what its samples say against it, as
/// [`check_samples`] finds it, and what its import found. Of a long one no more than two
/// columns are in memory at a time.
///
/// # Errors
/// A file that cannot be read.
pub fn check_trial(path: &Path, expected: &Asked) -> Result<Vec<StoreError>, StoreError> {
    let open = OpenColumns::open(&RealFiles, path)?;
    // Of a short one each column is decoded once.
    let doubts = match open.rows() <= LONG {
        true => check_samples(expected, Path::new(""), &read_trial(path, Signal::all())?.samples),
        false => check_samples(expected, Path::new(""), &open),
    };
    let imported = import_findings(Path::new(""), &open.meta_and_file()?.1);
    open.failure().map_or(Ok(doubts.into_iter().chain(imported).collect()), Err)
}

/// A signal and all its values.
type OneColumn = (Signal, Vec<f64>);

/// The samples that stand for all, in order; and the last of the signals that the recording has.
fn thinned(
    open: &OpenColumns,
    signals: &[Signal],
    most: usize,
) -> Result<(Vec<usize>, Option<OneColumn>), StoreError> {
    let rows = open.rows();
    let of_each = 1 + 2 * signals.len();
    let stretches = (most.saturating_sub(1) / of_each).max(1);
    let length = rows.div_ceil(stretches);
    let mut kept: Vec<usize> = (0..rows).step_by(length).chain(rows.checked_sub(1)).collect();
    let mut last: Option<OneColumn> = None;
    for signal in signals.iter().filter(|signal| open.has(**signal)) {
        let room = last.take().map(|(_, values)| values).unwrap_or_default();
        let Some(values) = open.signal_in(*signal, room)? else { continue };
        for (i, stretch) in values.chunks(length).enumerate() {
            let [mut smallest, mut largest] = [0; 2];
            for (j, value) in stretch.iter().enumerate() {
                if *value < stretch[smallest] {
                    smallest = j;
                }
                if *value > stretch[largest] {
                    largest = j;
                }
            }
            kept.extend([i * length + smallest, i * length + largest]);
        }
        last = Some((*signal, values));
    }
    kept.sort_unstable();
    kept.dedup();
    Ok((kept, last))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::read::tests::written;

    #[test]
    fn a_trial_that_is_not_long_is_read_as_it_is_and_a_long_one_keeps_its_extremes() {
        let (_folder, trial, path) = written();
        let signals = [Signal::Theta, Signal::StateBits];
        let whole = (read_trial(&path, signals).unwrap(), 200);
        assert_eq!(read_thinned(&path, signals, 200).unwrap(), whole);
        let (few, recorded) = read_thinned(&path, signals, 60).unwrap();
        assert_eq!(recorded, 200);
        let of = |trial: &Trial, signal| trial.samples.get(signal).unwrap().to_vec();
        let (all, kept) = (of(&trial, Signal::Theta), of(&few, Signal::Theta));
        // Of 11 stretches the first sample and the angle's other extreme, in one the first with the
        // bit; in the last these are its ends, of which one is the trial's.
        assert_eq!(few.samples.len(), 23);
        let most = |v: &[f64]| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(most(&all).to_bits(), most(&kept).to_bits());
        let t = of(&few, Signal::Time);
        assert_eq!((t.first(), t.last()), (Some(&0.0), Some(&(199.0 * 0.0083))));
        let row =
            of(&trial, Signal::Time).iter().position(|at| at.to_bits() == t[7].to_bits()).unwrap();
        assert_eq!(kept[7].to_bits(), all[row].to_bits(), "each sample is one that was recorded");
    }
}
