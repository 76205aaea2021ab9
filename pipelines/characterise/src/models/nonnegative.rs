//! Least squares with parameters that may not be negative.

use zwidth_numerics::dense::solve_symmetric;

/// A parameter is set free only for a gradient above this share of the largest one at the start:
/// rounding.
const GRADIENT_TOLERANCE: f64 = 1e-12;
/// Parameters are set free this often for each that there is; Lawson and Hanson's method needs
/// about one.
const ROUNDS: usize = 5;
/// A pivot below this share of its diagonal element is rounding.
const PIVOT_TOLERANCE: f64 = 1e-12;

/// Minimises ½ xᵀ G x − mᵀ x over x ≥ 0, G = XᵀX positive semidefinite and m = Xᵀy: the active-set
/// method of Lawson & Hanson (1974), *Solving Least Squares Problems*, ch. 23, on the normal
/// equations, which the few well-scaled columns here allow.
pub(super) fn nonnegative<const P: usize>(gram: &[[f64; P]; P], moment: &[f64; P]) -> [f64; P] {
    let mut x = [0.0; P];
    let mut free = [false; P];
    let largest = moment.iter().fold(0.0_f64, |max, m| max.max(m.abs()));
    for _ in 0..ROUNDS * P {
        // m − G x.
        let gradient: [f64; P] = core::array::from_fn(|j| {
            moment[j] - gram[j].iter().zip(&x).map(|(g, x)| g * x).sum::<f64>()
        });
        let held = (0..P).filter(|&j| !free[j]);
        let Some(next) = held.max_by(|&i, &j| gradient[i].total_cmp(&gradient[j])) else { break };
        if gradient[next] <= GRADIENT_TOLERANCE * largest {
            break;
        }
        free[next] = true;
        settle(gram, moment, &mut x, &mut free);
    }
    x
}

/// Goes to the minimum over the free parameters; each that meets 0 on the way is held there.
fn settle<const P: usize>(
    gram: &[[f64; P]; P],
    moment: &[f64; P],
    x: &mut [f64; P],
    free: &mut [bool; P],
) {
    loop {
        // The minimum over the free parameters, the others being 0; one that the others explain
        // wholly stays 0.
        let goal = solve_symmetric(*gram, *moment, |j, pivot| {
            !(free[j] && pivot > PIVOT_TOLERANCE * gram[j][j])
        });
        let blocked = (0..P).filter(|&j| free[j] && goal[j] <= 0.0);
        let stop =
            blocked.map(|j| (x[j] / (x[j] - goal[j]), j)).min_by(|(a, _), (b, _)| a.total_cmp(b));
        let Some((share, first)) = stop else {
            *x = goal;
            return;
        };
        // 0/0: the parameter is at 0 already.
        let share = if share.is_finite() { share } else { 0.0 };
        (0..P).filter(|&j| free[j]).for_each(|j| x[j] = (x[j] + share * (goal[j] - x[j])).max(0.0));
        (x[first], free[first]) = (0.0, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy: `scipy.optimize.nnls(X, y)` for X of 6 × 4 whole numbers.
    #[test]
    fn the_minimum_is_that_of_scipy() {
        let rows = [
            [1.0, 2.0, 0.0, 3.0],
            [4.0, 1.0, 1.0, 0.0],
            [0.0, 3.0, 5.0, 1.0],
            [2.0, 2.0, 1.0, 1.0],
            [1.0, 0.0, 4.0, 2.0],
            [3.0, 1.0, 0.0, 2.0],
        ];
        let y = [5.0, 3.0, 2.0, 6.0, 1.0, 9.0];
        let gram: [[f64; 4]; 4] = core::array::from_fn(|j| {
            core::array::from_fn(|k| rows.iter().map(|r| r[j] * r[k]).sum())
        });
        let moment: [f64; 4] =
            core::array::from_fn(|j| rows.iter().zip(y).map(|(r, y)| r[j] * y).sum());
        let found = nonnegative(&gram, &moment);
        for (found, scipy) in found.iter().zip(SCIPY) {
            assert!((found - scipy).abs() < 1e-12, "{found} {scipy}");
        }
    }
    const SCIPY: [f64; 4] = [1.1391437308868506, 0.5840978593272173, 0.0, 1.0840978593272166];

    #[test]
    fn without_a_bound_in_the_way_it_is_plain_least_squares_and_all_may_be_held() {
        let gram = [[2.0, 1.0], [1.0, 2.0]];
        let found = nonnegative(&gram, &[4.0, 5.0]);
        assert!((found[0] - 1.0).abs() < 1e-14 && (found[1] - 2.0).abs() < 1e-14);
        assert_eq!(nonnegative(&gram, &[-1.0, -2.0])[..], [0.0, 0.0]);
    }

    #[test]
    fn a_column_without_data_and_a_column_given_twice_are_no_error() {
        assert_eq!(nonnegative(&[[2.0, 0.0], [0.0, 0.0]], &[4.0, 0.0])[..], [2.0, 0.0]);
        let twice = nonnegative(&[[1.0, 1.0], [1.0, 1.0]], &[3.0, 3.0]);
        assert!((twice[0] + twice[1] - 3.0).abs() < 1e-14);
    }
}
