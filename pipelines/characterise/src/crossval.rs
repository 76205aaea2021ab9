//! The error on data that a fit has not seen.

use crate::models::Model;
use crate::samples::{Samples, split};
use core::ops::Range;
use rayon::prelude::*;
use zwidth_numerics::moments::Moments;

/// Blocks a single sweep is cut into.
const BLOCKS: usize = 10;
/// A shorter block would test one sample against its neighbours.
const MIN_BLOCK: usize = 2;

/// Error on left-out data.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LeftOut {
    /// Mean squared error on each fold, unit of the response squared.
    pub(crate) squares: Vec<f64>,
    /// Root of their mean, unit of the response.
    pub(crate) rms: f64,
    /// Its standard error.
    pub(crate) std_error: f64,
}

/// The parts that are left out, one at a time: each sweep, or of a single sweep ten contiguous
/// blocks of two samples or more.
pub(crate) fn folds(samples: &Samples) -> Vec<Range<usize>> {
    match samples.sweeps.as_slice() {
        [only] => split(only, (only.len() / MIN_BLOCK).clamp(1, BLOCKS)),
        sweeps => sweeps.to_vec(),
    }
}

/// Root of the mean over folds of the mean squared error on the fold left out, and its standard
/// error: that of the mean over folds, SD / √K, carried through the root. `None` if a fit without
/// one fold is impossible.
pub(crate) fn cross_validate(
    model: &Model,
    samples: &Samples,
    folds: &[Range<usize>],
) -> Option<LeftOut> {
    // Gathered once: leaving a fold out is then to count it 0 times.
    let cells: Vec<_> = folds.iter().map(|fold| samples.cells(fold.clone())).collect();
    let squares: Option<Vec<f64>> = (0..folds.len())
        .into_par_iter()
        .map(|out| {
            let kept =
                cells.iter().enumerate().map(|(k, cells)| (cells.as_slice(), u32::from(k != out)));
            let parameters = model.fit(&samples.steps.gather(kept), None)?;
            // The error on the samples themselves, not on the steps that fits are made on.
            let squares: f64 = folds[out]
                .clone()
                .map(|i| {
                    let (command, branch) = (samples.command[i], samples.branch[i]);
                    samples.response[i] - model.predict(&parameters, command, branch)
                })
                .map(|error| error * error)
                .sum();
            Some(squares / folds[out].len() as f64)
        })
        .collect();
    let squares = squares?;
    let (mean, std_error) = mean_and_error(&squares);
    let rms = mean.sqrt();
    // √x has the slope 1 / (2 √x).
    let std_error = if rms > 0.0 { std_error / (2.0 * rms) } else { 0.0 };
    Some(LeftOut { squares, rms, std_error })
}

/// Mean over folds and its standard error, SD / √K.
pub(crate) fn mean_and_error(folds: &[f64]) -> (f64, f64) {
    let k = folds.len() as f64;
    let moments = Moments::of(folds);
    (moments.mean, moments.variance().map_or(f64::NAN, |variance| (variance / k).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Sweep;
    use zwidth_results::CurveModel;

    #[test]
    fn sweeps_are_folds_and_a_single_sweep_is_cut_into_blocks() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let lengths = |n: &[usize]| {
            let sweeps: Vec<_> =
                n.iter().map(|&n| Sweep { command: &x[..n], response: &x[..n] }).collect();
            folds(&Samples::new(&sweeps).unwrap()).iter().map(Range::len).collect::<Vec<_>>()
        };
        assert_eq!(lengths(&[30, 20]), [30, 20]);
        assert_eq!(lengths(&[50]), [5; 10]);
        assert_eq!(lengths(&[21]), [2, 2, 2, 2, 2, 2, 2, 2, 2, 3]);
        assert_eq!(lengths(&[7]), [2, 2, 3]);
    }

    /// Two sweeps y = x and y = x + 1: each misses the other by 1 everywhere.
    #[test]
    fn the_error_is_that_on_the_sweep_left_out() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let sweeps = [
            Sweep { command: &x, response: &x },
            Sweep { command: &x, response: &x.map(|x| x + 1.0) },
        ];
        let samples = Samples::new(&sweeps).unwrap();
        let found =
            cross_validate(&Model::of(CurveModel::Line), &samples, &folds(&samples)).unwrap();
        assert!((found.rms - 1.0).abs() < 1e-14 && found.std_error < 1e-14);
    }
}
