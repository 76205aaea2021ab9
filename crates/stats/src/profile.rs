//! The end of a profile interval: how far from the estimate the profiled likelihood falls to its
//! critical value.

use crate::tested::Unestimable;
use zwidth_numerics::roots;

/// Ends are found to this many standard errors.
const RESOLUTION: f64 = 1e-7;
/// What a fall without end counts for, in critical values: no secant leads through infinity.
const ENDLESS: f64 = 2.0;

/// The distance, in standard errors, at which `fall` reaches `critical`. `fall` is √(2 (maximum −
/// profile)) at a distance: 0 at 0, the distance itself for a parabola. `None` if it stays below
/// up to the `farthest` distance. `fall` may be infinite, where the answers are impossible.
///
/// # Errors
/// The error of a `fall`.
pub(crate) fn end(
    mut fall: impl FnMut(f64) -> Result<f64, Unestimable>,
    critical: f64,
    farthest: f64,
) -> Result<Option<f64>, Unestimable> {
    let left =
        |fallen: f64| critical - if fallen.is_finite() { fallen } else { ENDLESS * critical };
    let first = critical.min(farthest);
    let mut inner = [0.0, critical];
    let mut outer = [first, left(fall(first)?)];
    while outer[1] > 0.0 {
        if outer[0] >= farthest {
            return Ok(None);
        }
        inner = outer;
        // Twice what a parabola needs from here on, but a doubling at most.
        let next = outer[0] + (2.0 * outer[1]).clamp(0.1 * critical, outer[0]);
        let next = next.min(farthest);
        outer = [next, left(fall(next)?)];
    }
    let mut failure = None;
    let left_at = |distance: f64| match distance {
        // A fall costs a search, and the ends of the bracket are known.
        d if d <= inner[0] => inner[1],
        d if d >= outer[0] => outer[1],
        d => fall(d).map_or_else(
            |error| {
                // A root function has no errors: 0 ends the search, and the error comes after it.
                failure = Some(error);
                0.0
            },
            left,
        ),
    };
    let distance = roots::bracketed(left_at, inner[0], outer[0], RESOLUTION);
    failure.map_or(Ok(Some(distance)), Err)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_parabola_is_its_critical_value() {
        let found = end(Ok, 1.96, 9.0).unwrap().unwrap();
        assert!((found - 1.96).abs() < 1e-7);
    }

    #[test]
    fn a_flat_and_a_steep_profile_are_followed_to_their_ends() {
        for steepness in [0.01, 0.3, 5.0] {
            let found = end(|d| Ok(steepness * d + 0.001 * d * d), 2.2, 200.0).unwrap().unwrap();
            assert!((steepness * found + 0.001 * found * found - 2.2).abs() < 1e-6);
        }
    }

    #[test]
    fn a_profile_that_falls_without_end_has_its_end_before_that_or_there() {
        for impossible in [1.0, 3.0, 3.9] {
            let fall = |d: f64| Ok(if d < impossible { 0.7 * d } else { f64::INFINITY });
            let found = end(fall, 1.96, 1000.0).unwrap().unwrap();
            assert!((found - f64::min(2.8, impossible)).abs() < 1e-6, "{impossible}: {found}");
        }
    }

    #[test]
    fn a_profile_that_levels_off_has_no_end_and_an_error_is_handed_on() {
        assert_eq!(end(|d| Ok(d / (1.0 + d)), 1.96, 1000.0), Ok(None));
        let error = Unestimable::Constant { units: "answers" };
        let failing = |d: f64| if d > 1.0 { Err(error.clone()) } else { Ok(d) };
        assert_eq!(end(failing, 1.96, 9.0), Err(error.clone()));
    }
}
