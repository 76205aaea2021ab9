//! A spring whose force stops growing: where a line ends in a plateau.

use std::ops::Range;

/// Fewest samples of the line and of the plateau: with fewer a mean or a slope rests on chance.
const LEAST_SAMPLES: usize = 10;
/// The plateau spans at least this share of the angles fitted: a shorter one is how a press ends,
/// not saturation.
const LEAST_SPAN: f64 = 0.05;
/// The force grows no further: the plateau's own slope is less than this share of the line's. It
/// may fall, as the force of a user does whose lever, once it is past the line, slows down.
const FLAT: f64 = 0.25;
/// The plateau matters: with it the residual sum of squares is at most this share of the straight
/// line's.
const BETTER: f64 = 0.5;

/// Angles that differ by a smaller share of themselves are one angle.
const ROUNDING: f64 = 1e-12;

/// Where the force saturates, the angle u_s: the continuous model F = F₀ + k min(u, u_s) with the
/// least sum of squares, by all ways of dividing the samples in order of u into a line below and a
/// mean above whose intersection lies between the two groups (Hudson 1966, J. Am. Stat. Assoc.
/// 61:1097).
///
/// `None` where the force did not saturate as far as the samples show: no division with at least 10
/// samples a side, or the best has a line that does not rise, a plateau that is short (under 5 % of
/// the angles) or on which the force grows on (its own slope at least a quarter of the line's), or
/// is no better than the straight line (more than half of its residual sum of squares).
pub(crate) fn plateau(u: &[f64], f: &[f64]) -> Option<f64> {
    // Places, which are half of an angle: a long press is not copied.
    let mut order: Vec<u32> = (0..u.len().min(f.len()) as u32).collect();
    // Of equal angles in the order of recording, so that sums run in one order.
    order.sort_unstable_by(|a, b| u[*a as usize].total_cmp(&u[*b as usize]).then(a.cmp(b)));
    let points = Points { order: &order, u, f };
    let Division { below: at, u_s, rss } = best_division(points)?;
    let line = points.part(0..at);
    let flat = points.part(at..order.len());
    let whole = points.fit()?;
    let rise = line.fit()?.slope;
    let on = flat.fit()?.slope;
    let first = points.at(0).0;
    let last = points.at(order.len() - 1).0;
    let is_long = last - u_s >= LEAST_SPAN * (last - first);
    let is_flat = rise > 0.0 && on < FLAT * rise;
    let is_better = rss <= BETTER * whole.rss;
    (is_long && is_flat && is_better).then_some(u_s)
}

/// Points in the order of u.
#[derive(Clone, Copy)]
struct Points<'a> {
    order: &'a [u32],
    u: &'a [f64],
    f: &'a [f64],
}

/// A straight line through points.
struct Line {
    slope: f64,
    rss: f64,
}

impl<'a> Points<'a> {
    fn at(self, i: usize) -> (f64, f64) {
        let place = self.order[i] as usize;
        (self.u[place], self.f[place])
    }

    fn part(self, range: Range<usize>) -> Self {
        Self { order: &self.order[range], ..self }
    }

    fn iter(self) -> impl Iterator<Item = (f64, f64)> {
        (0..self.order.len()).map(move |i| self.at(i))
    }

    /// Their mean.
    fn middle(self) -> (f64, f64) {
        let all = self.iter().fold(Sums::default(), Sums::with);
        (all.u / all.n, all.f / all.n)
    }

    /// Their sums about a point.
    fn sums_about(self, (u0, f0): (f64, f64)) -> Sums {
        self.iter().map(|(u, f)| (u - u0, f - f0)).fold(Sums::default(), Sums::with)
    }

    /// The line; `None` where the points are few or of one angle.
    fn fit(self) -> Option<Line> {
        let middle = self.middle();
        let about = self.sums_about(middle);
        let from_zero = about.uu + about.n * middle.0 * middle.0;
        let (_, slope, rss) = about.line();
        let is_line = about.n > 2.0 && about.uu.sqrt() > ROUNDING * from_zero.sqrt();
        is_line.then_some(Line { slope, rss })
    }
}

/// Sums of a group of points, about the means of all.
#[derive(Clone, Copy, Default)]
struct Sums {
    n: f64,
    u: f64,
    f: f64,
    uu: f64,
    uf: f64,
    ff: f64,
}

impl Sums {
    fn with(self, (u, f): (f64, f64)) -> Self {
        Self {
            n: self.n + 1.0,
            u: self.u + u,
            f: self.f + f,
            uu: self.uu + u * u,
            uf: self.uf + u * f,
            ff: self.ff + f * f,
        }
    }

    fn without(self, part: Self) -> Self {
        Self {
            n: self.n - part.n,
            u: self.u - part.u,
            f: self.f - part.f,
            uu: self.uu - part.uu,
            uf: self.uf - part.uf,
            ff: self.ff - part.ff,
        }
    }

    /// Mean of f, and the sum of squares about it.
    fn mean(self) -> (f64, f64) {
        let share = self.n.recip();
        (self.f * share, self.ff - self.f * self.f * share)
    }

    /// Intercept, slope and residual sum of squares of the line of f on u.
    fn line(self) -> (f64, f64, f64) {
        let share = self.n.recip();
        let uu = self.uu - self.u * self.u * share;
        let uf = self.uf - self.u * self.f * share;
        let slope = uf / uu;
        ((self.f - slope * self.u) * share, slope, self.mean().1 - slope * uf)
    }
}

/// A division of sorted points.
struct Division {
    /// How many points belong to the line.
    below: usize,
    /// Where the line meets the plateau.
    u_s: f64,
    /// The residual sum of squares of both.
    rss: f64,
}

/// The division with the least residual sum of squares.
fn best_division(points: Points) -> Option<Division> {
    let n = points.order.len();
    let (u0, f0) = points.middle();
    // About the means: sums of squares about 0 would cancel to few digits.
    let all = points.sums_about((u0, f0));
    let centred = |i: usize| {
        let (u, f) = points.at(i);
        (u - u0, f - f0)
    };
    let mut below = Sums::default();
    let mut best: Option<Division> = None;
    for at in 1..n {
        below = below.with(centred(at - 1));
        if at < LEAST_SAMPLES || n - at < LEAST_SAMPLES {
            continue;
        }
        let (intercept, slope, rss_line) = below.line();
        let (level, rss_flat) = all.without(below).mean();
        let meets = (level - intercept) / slope;
        let rss = rss_line + rss_flat;
        let between = centred(at - 1).0 <= meets && meets <= centred(at).0;
        if between && best.as_ref().is_none_or(|best| rss < best.rss) {
            best = Some(Division { below: at, u_s: meets + u0, rss });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(n: u32, length: f64) -> Vec<f64> {
        (0..n).map(|i| length * f64::from(i) / f64::from(n - 1)).collect()
    }

    fn of(u: &[f64], force: impl Fn(f64) -> f64) -> Option<f64> {
        let f: Vec<f64> = u.iter().map(|u| force(*u)).collect();
        plateau(u, &f)
    }

    #[test]
    fn a_saturated_spring_saturates_where_its_line_meets_the_plateau() {
        let found = of(&even(200, 1.3), |u| 0.2 + (4.0 * u).min(4.16)).unwrap();
        assert!((found - 1.04).abs() < 1e-12, "{found}");
    }

    #[test]
    fn the_order_of_the_samples_does_not_matter() {
        let mut u = even(200, 1.3);
        u.reverse();
        u.swap(3, 150);
        let found = of(&u, |u| (4.0 * u).min(2.08)).unwrap();
        assert!((found - 0.52).abs() < 1e-12, "{found}");
    }

    /// NumPy: `min` over all divisions of `polyfit` below and `mean` above, `meets` between the
    /// groups.
    #[test]
    fn a_noisy_plateau_is_that_of_an_exhaustive_search() {
        let u = even(120, 1.2);
        let f: Vec<f64> = u
            .iter()
            .zip(0u32..)
            .map(|(u, i)| (4.0 * u).min(3.0) + f64::from(i * i * 7 % 31) / 62.0)
            .collect();
        let found = plateau(&u, &f).unwrap();
        assert!((found - NUMPY_U).abs() < 1e-9, "{found}");
    }

    const NUMPY_U: f64 = 0.7497014493464199;

    /// A user whose lever of mass m slows down by a on the plateau presses by m a less. That the
    /// mean of a falling force lies below its first value moves the meeting by a few hundredths.
    #[test]
    fn a_plateau_on_which_the_force_falls_is_one() {
        for falls in [0.0, 0.9, 1.1] {
            let slows = |u: f64| (4.0 * u).min(4.16) - falls * (u - 1.04).max(0.0);
            let found = of(&even(200, 1.3), slows).unwrap();
            assert!((found - 1.04).abs() < 0.04, "{falls}: {found}");
        }
    }

    #[test]
    fn a_force_that_only_falls_has_no_plateau() {
        assert_eq!(of(&even(200, 1.3), |u| (-4.0 * u).max(-3.0)), None);
        assert_eq!(of(&even(200, 1.3), |u| -(2.0 * u).min(1.0) - 6.0 * (u - 0.5).max(0.0)), None);
    }

    #[test]
    fn springs_that_soften_end_slowly_or_go_on_have_no_plateau() {
        let u = even(200, 1.0);
        assert_eq!(of(&u, |u| 4.0 * u), None);
        assert_eq!(of(&u, |u| 4.0 * u - 1.6 * u * u), None);
        assert_eq!(of(&u, |u| (4.0 * u).min(2.0) + 1.5 * (u - 0.5).max(0.0)), None);
        assert_eq!(of(&u, |u| (4.0 * u).min(3.88)), None);
        assert_eq!(of(&u[..15], |u| (4.0 * u).min(0.1)), None);
        assert_eq!(of(&[0.5; 40], |_| 1.0), None);
    }
}
