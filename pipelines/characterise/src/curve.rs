//! A fitted curve on a grid, with its bands: what a figure draws.

use crate::characteristic::Candidate;
use crate::error::CharacteriseError;
use crate::models::Model;
use crate::samples::Sweep;
use zwidth_numerics::branch::{Branch, branches};
use zwidth_stats::student_t::critical_value;

/// A curve at a command, with the band of its mean and the band for one new response, each from low
/// to high. Units are those of command and response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveAt {
    /// The command.
    pub command: f64,
    /// The fitted response.
    pub fit: f64,
    /// The pointwise band of the mean.
    pub mean: [f64; 2],
    /// The band for a new response.
    pub new: [f64; 2],
}

/// `candidate` on `grid`, the command on its way `branch`, at confidence `level`.
///
/// The band of the mean holds the middle share `level` of the resampled curves at each command,
/// widened to include the fit itself. The band for a new response adds the residuals' spread, as
/// independent of it: distance² = (distance of the mean's band)² + (t s)², s² = n rms² / df. `None`
/// for a candidate that was not fitted or has no resamples.
///
/// # Errors
/// `level` outside (0, 1).
pub fn curve(
    candidate: &Candidate,
    grid: &[f64],
    branch: Branch,
    level: f64,
) -> Result<Option<Vec<CurveAt>>, CharacteriseError> {
    let Some(quality) = candidate.quality else { return Ok(None) };
    let model = Model::of(candidate.name);
    // `rms` divides by n, s² by the degrees of freedom.
    let (df, n) = (quality.df as f64, (quality.df + candidate.complexity) as f64);
    let spread = critical_value(level, df)? * quality.rms * (n / df).sqrt();
    let fitted: Vec<f64> = candidate.parameters.iter().map(|p| p.estimate).collect();
    let mut curve = Vec::with_capacity(grid.len());
    for &x in grid {
        let fit = model.predict(&fitted, x, branch);
        let resampled: Vec<f64> =
            candidate.resampled.iter().map(|p| model.predict(p, x, branch)).collect();
        let Some((low, high)) = candidate.interval(&resampled, level)? else { return Ok(None) };
        let low = low.min(fit);
        let high = high.max(fit);
        let new = [fit - libm::hypot(fit - low, spread), fit + libm::hypot(high - fit, spread)];
        curve.push(CurveAt { command: x, fit, mean: [low, high], new });
    }
    Ok(Some(curve))
}

/// The mean response on `branch` (`None`: on both) of all samples within half a step of each
/// command of an even, rising `grid` of two commands at least; `None` where there is none.
pub(crate) fn mean_response(
    sweeps: &[Sweep],
    grid: &[f64],
    branch: Option<Branch>,
) -> Vec<Option<f64>> {
    let step = (grid[grid.len() - 1] - grid[0]) / (grid.len() - 1) as f64;
    let mut sums = vec![(0.0, 0.0); grid.len()];
    for sweep in sweeps {
        let samples = sweep.command.iter().zip(sweep.response).zip(branches(sweep.command));
        for ((x, y), _) in samples.filter(|(_, on)| branch.is_none_or(|branch| branch == *on)) {
            let place = (((x - grid[0]) / step + 0.5).max(0.0) as usize).min(grid.len() - 1);
            let (n, sum) = &mut sums[place];
            (*n, *sum) = (*n + 1.0, *sum + y);
        }
    }
    sums.into_iter().map(|(n, sum)| (n > 0.0).then(|| sum / n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characteristic::tests::settings;
    use crate::{characterise, first_order};

    #[test]
    fn the_mean_takes_what_lies_within_half_a_step() {
        let sweep = Sweep {
            command: &[0.0, 0.9, 1.1, 2.0, 1.0, 0.0],
            response: &[0.0, 1.0, 3.0, 4.0, 8.0, 1.0],
        };
        let mean = |branch| mean_response(&[sweep], &[0.0, 1.0, 2.0, 3.0], branch);
        assert_eq!(mean(None), [Some(0.5), Some(4.0), Some(4.0), None]);
        assert_eq!(mean(Some(Branch::Up)), [Some(0.0), Some(2.0), Some(4.0), None]);
        assert_eq!(mean(Some(Branch::Down)), [Some(1.0), Some(8.0), None, None]);
    }

    /// With independent errors about a true line the bootstrap's bands are near the textbook's. 400
    /// commands are gathered in 256 steps: the fit moves by far less than its bands are wide.
    #[test]
    fn the_bands_of_a_line_are_near_those_of_the_first_order_fit() {
        let x: Vec<f64> = (0..400).map(|i| f64::from(i) / 40.0).collect();
        let y: Vec<f64> =
            (0..400).map(|i| f64::from(i) / 40.0 + f64::from(i * i * 7 % 401) / 401.0).collect();
        let sweeps = [Sweep { command: &x, response: &y }];
        let grid = [0.0, 5.0, 12.0];
        let found = characterise(&sweeps, &settings(1000, 2)).unwrap();
        let ours = curve(&found.candidates[0], &grid, Branch::Up, 0.95).unwrap().unwrap();
        let textbook = first_order(&sweeps, 0.95).unwrap().curve(&grid);
        for (ours, textbook) in ours.iter().zip(&textbook) {
            let moved = (ours.fit - textbook.fit).abs();
            assert!(moved < 1e-2 * (textbook.mean[1] - textbook.fit), "{moved}");
            let width = |[low, high]: [f64; 2]| high - low;
            let mean = width(ours.mean) / width(textbook.mean);
            let new = width(ours.new) / width(textbook.new);
            assert!(mean > 0.5 && mean < 1.5 && (new - 1.0).abs() < 0.01, "{mean} {new}");
        }
    }

    #[test]
    fn without_resamples_there_is_no_band() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let sweep = Sweep { command: &x, response: &x };
        let found = characterise(&[sweep], &settings(0, 2)).unwrap();
        assert_eq!(curve(&found.candidates[0], &x, Branch::Up, 0.95), Ok(None));
    }
}
