//! The scatter of the response that the curve cannot explain.

use crate::samples::{Samples, split};
use crate::shape::weighted_line;

/// Neighbouring samples that share one local line: short enough that any smooth curve is straight
/// over it, long enough that the line leaves three of five degrees of freedom.
const WINDOW: usize = 5;

/// Pooled standard deviation of the response about local straight lines (response over command;
/// their mean where the command stands still), one for each run of five neighbouring samples of a
/// sweep, a remainder shared out among them: √(Σ rss / Σ df), in the unit of the response. `None`
/// without a degree of freedom.
pub(crate) fn noise(samples: &Samples) -> Option<f64> {
    let mut rss = 0.0;
    let mut df = 0;
    let sweeps = samples.sweeps.iter();
    for window in sweeps.flat_map(|sweep| split(sweep, (sweep.len() / WINDOW).max(1))) {
        let x = &samples.command[window.clone()];
        let y = &samples.response[window];
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let line = weighted_line(x.iter().zip(y).map(|(&x, &y)| (x, y, 1.0)));
        let (a, b) = line.unwrap_or((mean, 0.0));
        // Summed window by window: in one go the rounding would be another.
        rss += x.iter().zip(y).map(|(x, y)| y - a - b * x).map(|r| r * r).sum::<f64>();
        df += y.len().saturating_sub(if line.is_some() { 2 } else { 1 });
    }
    (df > 0).then(|| (rss / df as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Sweep;

    fn noise_of(command: &[f64], response: &[f64]) -> Option<f64> {
        noise(&Samples::new(&[Sweep { command, response }]).unwrap())
    }

    #[test]
    fn a_line_has_none() {
        let x: Vec<f64> = (0..23).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 3.0 - 2.0 * x).collect();
        assert!(noise_of(&x, &y).unwrap() < 1e-13);
    }

    /// A local line through (0, 1, 0, 1, 0) is level and leaves Σ r² = 1.2.
    #[test]
    fn it_is_the_spread_about_each_local_line() {
        let up =
            Sweep { command: &[0.0, 1.0, 2.0, 3.0, 4.0], response: &[0.0, 1.0, 0.0, 1.0, 0.0] };
        let found = noise(&Samples::new(&[up, up]).unwrap()).unwrap();
        assert!((found - (1.2_f64 / 3.0).sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_command_that_stands_still_has_its_mean() {
        let x = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0];
        let y = [1.0, -1.0, 0.0, 1.0, -1.0].repeat(3);
        assert!((noise_of(&x, &y).unwrap() - 1.0).abs() < 1e-14);
    }
}
