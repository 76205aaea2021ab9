//! The delay of one signal relative to another, by cross-correlation.

use zwidth_numerics::NumericsError;
use zwidth_numerics::series::interpolate_all;
use zwidth_numerics::wide::dot;

/// Lags are searched up to this, s: longer than any delay of the device, shorter than a movement.
const MOST_LAG_S: f64 = 0.5;

/// Steps of the grid are at least this long, s: a movement of the hand is smooth over it.
const LEAST_STEP_S: f64 = 0.005;

/// Where a shift leaves a smaller part of a signal's squares than this, differences of running sums
/// have lost the digits that its correlation needs.
const LEAST_SHARE: f64 = 1e-6;

/// The lag of `model` behind `recorded`, s: where Pearson's correlation of the two, shifted against
/// each other over an even grid of the mean step (5 ms at least), is highest within ±0.5 s; between
/// steps by the parabola through the highest three. `None` where either is constant, or the
/// correlation is still rising at the end of the search.
///
/// # Errors
/// None for times and values of one length.
pub(crate) fn lag_s(
    t: &[f64],
    recorded: &[f64],
    model: &[f64],
) -> Result<Option<f64>, NumericsError> {
    let steps = t.len().saturating_sub(1);
    let Some(span) = t.last().map(|end| end - t[0]).filter(|_| steps >= 2) else { return Ok(None) };
    let even_steps = steps.min((span / LEAST_STEP_S) as usize).max(1);
    let step = span / even_steps as f64;
    let grid: Vec<f64> = (0..=even_steps).map(|i| (t[0] + i as f64 * step).min(t[steps])).collect();
    let [recorded, model] = [recorded, model].map(|y| -> Vec<f64> {
        interpolate_all(t, y, &grid).into_iter().map(Option::unwrap_or_default).collect()
    });
    // At least half of both signals overlap at the largest shift.
    let most = ((MOST_LAG_S / step) as usize).min(even_steps / 2);
    Ok(best_shift(&recorded, &model, most).map(|shift| shift * step))
}

/// The shift of the highest correlation, in samples; the smallest of equals.
fn best_shift(recorded: &[f64], model: &[f64], most: usize) -> Option<f64> {
    let (a, b) = (Centred::of(recorded), Centred::of(model));
    let mut shift = 0;
    let mut highest = a.correlation(&b, shift)?;
    for size in 1..=most as isize {
        for other in [-size, size] {
            if let Some(r) = a.correlation(&b, other).filter(|r| *r > highest) {
                (highest, shift) = (r, other);
            }
        }
    }
    // Highest at the end of the search: it may be higher still beyond.
    if shift.unsigned_abs() >= most {
        return None;
    }
    let peak = correlation(recorded, model, shift)?;
    let before = correlation(recorded, model, shift - 1)?;
    let after = correlation(recorded, model, shift + 1)?;
    let curvature = before - 2.0 * peak + after;
    let between = if curvature < 0.0 { (before - after) / (2.0 * curvature) } else { 0.0 };
    Some(shift as f64 + between)
}

/// A signal, the same less its mean, and running sums of that: the same for every shift of a search.
struct Centred<'a> {
    signal: &'a [f64],
    y: Vec<f64>,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl<'a> Centred<'a> {
    fn of(signal: &'a [f64]) -> Self {
        let mean = signal.iter().sum::<f64>() / signal.len() as f64;
        let y: Vec<f64> = signal.iter().map(|x| x - mean).collect();
        let running = |term: fn(f64) -> f64| {
            let mut sum = 0.0;
            let sums = y.iter().map(|y| {
                sum += term(*y);
                sum
            });
            std::iter::once(0.0).chain(sums).collect()
        };
        Self { signal, sums: running(|y| y), squares: running(|y| y * y), y }
    }

    /// [`correlation`] but for rounding, in a fraction of its time.
    fn correlation(&self, model: &Self, shift: isize) -> Option<f64> {
        let ahead = shift.max(0) as usize;
        let behind = (-shift).max(0) as usize;
        let n = self.y.len() - ahead.max(behind);
        let overlap = |signal: &Self, from: usize| {
            let sum = signal.sums[from + n] - signal.sums[from];
            let squares = signal.squares[from + n] - signal.squares[from] - sum * sum / n as f64;
            let all = signal.squares[signal.y.len()];
            (squares > LEAST_SHARE * all).then_some((sum, squares))
        };
        let Some(((a, aa), (b, bb))) = overlap(self, behind).zip(overlap(model, ahead)) else {
            return correlation(self.signal, model.signal, shift);
        };
        let ab = dot(&self.y[behind..behind + n], &model.y[ahead..ahead + n]) - a * b / n as f64;
        Some(ab / (aa * bb).sqrt())
    }
}

/// Pearson's correlation of `recorded[i]` with `model[i + shift]` where both are there; `None`
/// where one is constant.
fn correlation(recorded: &[f64], model: &[f64], shift: isize) -> Option<f64> {
    let ahead = shift.max(0) as usize;
    let behind = (-shift).max(0) as usize;
    let n = recorded.len() - ahead.max(behind);
    let a = &recorded[behind..behind + n];
    let b = &model[ahead..ahead + n];
    let [mean_a, mean_b] = [a, b].map(|y| y.iter().sum::<f64>() / n as f64);
    let mut ab = 0.0;
    let mut aa = 0.0;
    let mut bb = 0.0;
    for (a, b) in a.iter().zip(b) {
        ab += (a - mean_a) * (b - mean_b);
        aa += (a - mean_a) * (a - mean_a);
        bb += (b - mean_b) * (b - mean_b);
    }
    (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth bump around `centre` s, every 10 ms over 4 s.
    fn bump(centre: f64) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..=400).map(|i| f64::from(i) / 100.0).collect();
        let y = t.iter().map(|t| libm::exp(-(t - centre) * (t - centre) / 0.2)).collect();
        (t, y)
    }

    fn check(delay_s: f64, tolerance_s: f64) {
        let (t, recorded) = bump(2.0);
        let found = lag_s(&t, &recorded, &bump(2.0 + delay_s).1).unwrap().unwrap();
        assert!((found - delay_s).abs() <= tolerance_s, "{found} instead of {delay_s}");
    }

    #[test]
    fn a_delay_is_found_to_a_fraction_of_a_step() {
        check(0.0, 1e-15);
        for delay_s in [0.01, 0.12, -0.25, 0.034, -0.0071] {
            check(delay_s, 2e-4);
        }
    }

    #[test]
    fn the_correlation_by_running_sums_is_the_plain_one() {
        // A rest at one end and a jump at the other: what a shift leaves can be constant.
        let recorded: Vec<f64> = (0..90).map(|i| f64::from(i.max(60)).powi(2)).collect();
        let model: Vec<f64> = (0..90).map(|i| if i < 40 { 3.0 } else { 3.0 - 1e-3 }).collect();
        let (a, b) = (Centred::of(&recorded), Centred::of(&model));
        for shift in -45..=45 {
            let (fast, plain) = (a.correlation(&b, shift), correlation(&recorded, &model, shift));
            let apart = fast.zip(plain).map_or(0.0, |(fast, plain)| (fast - plain).abs());
            assert!(
                fast.is_some() == plain.is_some() && apart < 1e-9,
                "{shift}: {fast:?} {plain:?}"
            );
        }
        assert_eq!(a.correlation(&b, 45), None);
    }

    #[test]
    fn a_delay_beyond_the_search_and_a_constant_have_no_lag() {
        let (t, recorded) = bump(1.5);
        assert_eq!(lag_s(&t, &recorded, &bump(2.5).1).unwrap(), None);
        assert_eq!(lag_s(&t, &recorded, &vec![1.0; t.len()]).unwrap(), None);
        assert_eq!(lag_s(&t[..2], &recorded[..2], &recorded[..2]).unwrap(), None);
    }
}
