//! Parameters of resampled data.

use crate::characteristic::Settings;
use crate::models::Model;
use crate::samples::Samples;
use core::ops::Range;
use zwidth_stats::bootstrap::resample;

/// Blocks of residuals are this share of a single sweep long, and two samples at least.
const BLOCK_SHARE: usize = 10;
const MIN_BLOCK: usize = 2;

/// The parameters of `model` on each resample of the data it could be fitted to, `fitted` being
/// those of the data themselves: whole sweeps drawn with replacement, or blocks of residuals if
/// there is but one sweep. Each search starts from `fitted`.
pub(crate) fn resampled(
    model: &Model,
    samples: &Samples,
    fitted: &[f64],
    settings: &Settings,
) -> Vec<Vec<f64>> {
    let Settings { resamples, seed, .. } = *settings;
    let fits = if samples.sweeps.len() > 1 {
        let cells: Vec<_> =
            samples.sweeps.iter().map(|sweep| samples.cells(sweep.clone())).collect();
        let numbers: Vec<usize> = (0..cells.len()).collect();
        resample(&numbers, numbers.len(), resamples, seed, |drawn| {
            // A sweep drawn twice weighs twice.
            let mut times = vec![0; cells.len()];
            drawn.iter().for_each(|&&number| times[number] += 1);
            let groups = cells.iter().map(Vec::as_slice).zip(times);
            model.fit(&samples.steps.gather(groups), Some(fitted))
        })
    } else {
        // The fitted curve plus blocks of residuals drawn from anywhere in the sweep (Künsch 1989;
        // Davison & Hinkley 1997, *Bootstrap Methods and their Application*, §8.2.3), enlarged by
        // √(n / (n − p)) because a fit makes its residuals too small.
        let n = samples.len();
        let commands = samples.command.iter().zip(&samples.branch);
        let curve: Vec<f64> = commands.map(|(&x, &b)| model.predict(fitted, x, b)).collect();
        let enlarge = (n as f64 / (n - model.complexity()) as f64).sqrt();
        let residuals: Vec<f64> =
            samples.response.iter().zip(&curve).map(|(y, f)| enlarge * (y - f)).collect();
        let length = n.div_ceil(BLOCK_SHARE).max(MIN_BLOCK);
        let blocks: Vec<Range<usize>> =
            (0..=n - length).map(|start| start..start + length).collect();
        // Blocks enough for n samples; the last one is cut where the sweep ends.
        resample(&blocks, n.div_ceil(length), resamples, seed, |drawn| {
            let errors = drawn.iter().flat_map(|block| &residuals[(*block).clone()]);
            let response: Vec<f64> = curve.iter().zip(errors).map(|(f, e)| f + e).collect();
            model.fit(&samples.with_response(&response), Some(fitted))
        })
    };
    fits.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characteristic::tests::settings;
    use crate::samples::Sweep;
    use zwidth_results::CurveModel;

    const X: [f64; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];

    fn slopes(responses: &[[f64; 6]]) -> Vec<f64> {
        let sweeps: Vec<_> =
            responses.iter().map(|response| Sweep { command: &X, response }).collect();
        let samples = Samples::new(&sweeps).unwrap();
        let line = Model::of(CurveModel::Line);
        let fitted = line.fit(&samples.gathered(), None).unwrap();
        resampled(&line, &samples, &fitted, &settings(300, 1)).iter().map(|p| p[1]).collect()
    }

    #[test]
    fn an_exact_line_has_no_spread() {
        let slopes = slopes(&[X.map(|x| 2.0 * x)]);
        assert_eq!(slopes.len(), 300);
        assert!(slopes.iter().all(|b| (b - 2.0).abs() < 1e-14));
    }

    /// Slopes 1 and 3, both drawn or one of them twice: 1, 2 or 3, in the shares 1 : 2 : 1.
    #[test]
    fn sweeps_are_drawn_whole() {
        let slopes = slopes(&[X, X.map(|x| 3.0 * x)]);
        let near = |b: f64| slopes.iter().filter(|s| (*s - b).abs() < 1e-12).count();
        assert_eq!(near(1.0) + near(2.0) + near(3.0), 300);
        assert!(near(2.0) > 120 && near(2.0) < 180, "{}", near(2.0));
    }
}
