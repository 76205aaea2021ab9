//! A fitted curve on a grid, with its bands: what a figure draws.

use crate::characteristic::Candidate;
use crate::error::CharacteriseError;
use crate::models::Model;
use crate::samples::Sweep;
use zwidth_numerics::branch::{Branch, branches};
use zwidth_stats::student_t::critical_value;

/// A curve with the pointwise band of its mean and the band for one new response. All columns have
/// one length; units are those of command and response.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// The grid.
    pub command: Vec<f64>,
    /// The fitted response.
    pub fit: Vec<f64>,
    /// Lower end of the band of the mean.
    pub ci_low: Vec<f64>,
    /// Upper end of the band of the mean.
    pub ci_high: Vec<f64>,
    /// Lower end of the band for a new response.
    pub prediction_low: Vec<f64>,
    /// Upper end of the band for a new response.
    pub prediction_high: Vec<f64>,
}

impl Curve {
    /// Adds a point with the bands of its mean and of a new response, each from low to high.
    pub(crate) fn push(&mut self, x: f64, fit: f64, mean: [f64; 2], new: [f64; 2]) {
        self.command.push(x);
        self.fit.push(fit);
        self.ci_low.push(mean[0]);
        self.ci_high.push(mean[1]);
        self.prediction_low.push(new[0]);
        self.prediction_high.push(new[1]);
    }
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
) -> Result<Option<Curve>, CharacteriseError> {
    let Some(quality) = candidate.quality else {
        return Ok(None);
    };
    let model = Model::of(candidate.name);
    // `rms` divides by n, s² by the degrees of freedom.
    let (df, n) = (quality.df as f64, (quality.df + candidate.complexity) as f64);
    let spread = critical_value(level, df)? * quality.rms * (n / df).sqrt();
    let fitted: Vec<f64> = candidate.parameters.iter().map(|p| p.estimate).collect();
    let mut curve = Curve::default();
    for &x in grid {
        let fit = model.predict(&fitted, x, branch);
        let resampled: Vec<f64> =
            candidate.resampled.iter().map(|p| model.predict(p, x, branch)).collect();
        let Some((low, high)) = candidate.interval(&resampled, level)? else {
            return Ok(None);
        };
        let low = low.min(fit);
        let high = high.max(fit);
        let new = [fit - libm::hypot(fit - low, spread), fit + libm::hypot(high - fit, spread)];
        curve.push(x, fit, [low, high], new);
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
    use crate::{Settings, characterise, first_order};

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
        let (command_unit, response_unit) = ("V".to_owned(), "N".to_owned());
        let settings =
            Settings { resamples: 1000, seed: 2, level: 0.95, command_unit, response_unit };
        let grid = [0.0, 5.0, 12.0];
        let found = characterise(&sweeps, &settings).unwrap();
        let ours = curve(&found.candidates[0], &grid, Branch::Up, 0.95).unwrap().unwrap();
        let textbook = first_order(&sweeps, 0.95).unwrap().curve(&grid);
        for i in 0..grid.len() {
            let moved = (ours.fit[i] - textbook.fit[i]).abs();
            assert!(moved < 1e-2 * (textbook.ci_high[i] - textbook.fit[i]), "{moved}");
            let width = |low: &[f64], high: &[f64]| high[i] - low[i];
            let mean =
                width(&ours.ci_low, &ours.ci_high) / width(&textbook.ci_low, &textbook.ci_high);
            let new = width(&ours.prediction_low, &ours.prediction_high)
                / width(&textbook.prediction_low, &textbook.prediction_high);
            assert!(mean > 0.5 && mean < 1.5 && (new - 1.0).abs() < 0.01, "{mean} {new}");
        }
    }

    #[test]
    fn without_resamples_there_is_no_band() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let (command_unit, response_unit) = ("V".to_owned(), "N".to_owned());
        let settings = Settings { resamples: 0, seed: 2, level: 0.95, command_unit, response_unit };
        let found = characterise(&[Sweep { command: &x, response: &x }], &settings).unwrap();
        assert_eq!(curve(&found.candidates[0], &x, Branch::Up, 0.95), Ok(None));
    }
}
