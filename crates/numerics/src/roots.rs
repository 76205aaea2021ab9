//! Roots: the first place where a polynomial falls below zero, and a bracketed root of a function.

/// `Σ c[k] tᵏ`: even and odd powers by Horner's rule in t², each without waiting for the other.
#[inline]
pub fn polynomial<const K: usize>(c: &[f64; K], t: f64) -> f64 {
    let square = t * t;
    let mut sums = [0.0; 2];
    for (k, &x) in c.iter().enumerate().rev() {
        sums[k % 2] = sums[k % 2] * square + x;
    }
    sums[0] + t * sums[1]
}

/// First `t` in `[0, span]` at which `p(t) = Σ c[k] tᵏ` goes below zero, to within `resolution`.
///
/// No dip is missed that lasts longer than `resolution`: an interval is passed over only where
/// its end values exceed `max|p''| width² / 8`, the most a curve can sag below its chord.
/// `Some(0)` if `p(0) < 0` already, or if `p` is not finite; `None` if `p` stays at or above zero.
/// A polynomial that cannot be distinguished from zero over a whole stretch counts as falling where
/// the search gives up.
pub fn first_descent<const K: usize>(c: &[f64; K], span: f64, resolution: f64) -> Option<f64> {
    /// Intervals looked at: forty halvings for a crossing, and many near misses.
    const MOST_INTERVALS: u32 = 4_000;
    let start = c.first().copied().unwrap_or(0.0);
    // Bound of |p''| / 8 over the whole span, by Horner's rule with every coefficient positive.
    let mut bend = 0.0;
    for (k, x) in c.iter().enumerate().skip(2).rev() {
        bend = bend * span + x.abs() * (k * (k - 1)) as f64;
    }
    let sag = bend / 8.0;
    let end = polynomial(c, span);
    if start < 0.0 || !(sag + end).is_finite() {
        return Some(0.0);
    }
    descend(&Search { c, sag, resolution }, &mut { MOST_INTERVALS }, [0.0, start], [span, end])
}

/// A polynomial with its bound of sag, and how finely it is searched.
struct Search<'a, const K: usize> {
    c: &'a [f64; K],
    sag: f64,
    resolution: f64,
}

/// `first_descent` between two points `[t, p(t)]`, the left one not below zero.
fn descend<const K: usize>(
    search: &Search<'_, K>,
    left_over: &mut u32,
    left: [f64; 2],
    right: [f64; 2],
) -> Option<f64> {
    let width = right[0] - left[0];
    if left[1].min(right[1]) >= search.sag * width * width {
        return None;
    }
    // The slope stays within max|p''| width of the chord's: where that is below zero there is one
    // crossing.
    let steepest = 8.0 * search.sag * width;
    if right[1] < 0.0
        && (right[1] - left[1]) / width + steepest < 0.0
        && let Some(t) = just_below(search, left, right)
    {
        return Some(t);
    }
    if *left_over == 0 {
        return Some(left[0]);
    }
    *left_over -= 1;
    let middle = 0.5 * (left[0] + right[0]);
    if width <= search.resolution || middle <= left[0] || middle >= right[0] {
        return (right[1] < 0.0).then_some(right[0]);
    }
    let centre = [middle, polynomial(search.c, middle)];
    if centre[1] < 0.0 {
        return descend(search, left_over, left, centre);
    }
    // The left half first, and the right one only if nothing falls there: the first crossing
    // counts.
    let first = descend(search, left_over, left, centre);
    first.or_else(|| descend(search, left_over, centre, right))
}

/// The single crossing between two points: the root, moved on by some units in the last place until
/// the polynomial is below zero there. `None` if it hardly falls; then halving has to find it.
fn just_below<const K: usize>(
    search: &Search<'_, K>,
    left: [f64; 2],
    right: [f64; 2],
) -> Option<f64> {
    let root = bracketed(|t| polynomial(search.c, t), left[0], right[0], search.resolution);
    let ulp = root.abs().max(search.resolution) * f64::EPSILON;
    [0.0, 1.0, 4.0, 16.0, 64.0]
        .iter()
        .map(|k| root + k * ulp)
        .find(|&t| t <= right[0] && polynomial(search.c, t) < 0.0)
}

/// Root of `f` in `[left, right]` by the Illinois variant of regula falsi (Dowell & Jarratt 1971),
/// to within about `resolution`. The signs of `f` at the ends must differ; else the nearer end is
/// returned.
pub fn bracketed(mut f: impl FnMut(f64) -> f64, left: f64, right: f64, resolution: f64) -> f64 {
    /// Illinois converges superlinearly; bisection from 1 to 1e-16 would take 54.
    const MOST_STEPS: usize = 200;
    let mut a = [left, f(left)];
    let mut b = [right, f(right)];
    if (a[1] > 0.0) == (b[1] > 0.0) {
        return if a[1].abs() <= b[1].abs() { left } else { right };
    }
    for _ in 0..MOST_STEPS {
        let secant = b[0] - b[1] * (b[0] - a[0]) / (b[1] - a[1]);
        let new = [secant, f(secant)];
        let settled = (new[0] - b[0]).abs() <= resolution || new[1].abs() <= f64::MIN_POSITIVE;
        if (new[1] > 0.0) == (b[1] > 0.0) {
            // The far end stays: unless it counts for less and less, the secants only creep.
            a[1] *= 0.5;
        } else {
            a = b;
        }
        b = new;
        if settled || (b[0] - a[0]).abs() <= resolution {
            break;
        }
    }
    b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const K: usize>(c: &[f64; K], expect: Option<f64>) {
        match (first_descent(c, 1.0, 1e-13), expect) {
            (None, None) => {}
            (Some(t), Some(e)) => assert!((t - e).abs() < 1e-12, "{c:?}: {t} instead of {e}"),
            (found, _) => panic!("{c:?}: {found:?} instead of {expect:?}"),
        }
    }

    #[test]
    fn the_first_of_two_crossings_is_found_though_both_ends_are_positive() {
        // (t - 0.5)(t - 0.501): a dip that lasts a thousandth of the span.
        check(&[0.5 * 0.501, -1.001, 1.0], Some(0.5));
        // (t - 0.3)(t - 0.7)
        check(&[0.21, -1.0, 1.0], Some(0.3));
    }

    #[test]
    fn touching_zero_is_not_falling_below_it() {
        check(&[0.25, -1.0, 1.0 + 1e-15], None);
        check(&[0.0, 1.0], None);
        check(&[0.0], None);
    }

    #[test]
    fn a_start_below_zero_counts_at_once_and_a_start_at_zero_once_it_falls() {
        check(&[-1e-9, 1.0], Some(0.0));
        check(&[0.0, -1.0], Some(0.0));
        // t (0.5 - t)
        check(&[0.0, 0.5, -1.0], Some(0.5));
    }

    #[test]
    fn a_polynomial_without_finite_values_ends_the_search() {
        check(&[1.0, f64::NAN], Some(0.0));
        check(&[1.0, f64::MAX, f64::MAX], Some(0.0));
    }

    #[test]
    fn a_bracketed_root_is_found_to_the_resolution() {
        let t = bracketed(|t| libm::cos(t) - t, 0.0, 1.0, 1e-14);
        assert!((t - 0.739_085_133_215_160_6).abs() < 1e-13);
    }
}
