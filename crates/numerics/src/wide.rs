//! Loops over as many numbers at a time as the processor can take.

use fearless_simd::{Level, dispatch};

/// What `work` gives, compiled for the widest vectors that this processor has; what it calls is so only
/// if it is `#[inline(always)]`, as `work` itself must be. The bits are those of any other processor: a
/// product and a sum are never rounded as one, and sums run in the order of the code.
#[inline(always)]
pub fn widest<T>(work: impl FnOnce() -> T) -> T {
    dispatch!(Level::new(), _vectors => work())
}

/// Numbers that are summed side by side.
const LANES: usize = 8;

/// a · b, in eight sums side by side, over as much as there is of both.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || {
            let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
            let mut sums = [0.0; LANES];
            for (a, b) in a.iter().zip(b) {
                for lane in 0..LANES {
                    sums[lane] += a[lane] * b[lane];
                }
            }
            let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
            sums.iter().sum::<f64>() + rest
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products whose last digits are lost where a sum is rounded with them.
    #[inline(always)]
    fn sums(x: &[f64], y: &[f64]) -> Vec<f64> {
        x.iter().zip(y).map(|(x, y)| x * y - (x * x + y * y) / 2.0).collect()
    }

    #[test]
    fn a_sum_in_lanes_is_the_sum() {
        for n in [0, 1, 7, 8, 9, 100] {
            let a: Vec<f64> = (0..n).map(f64::from).collect();
            let b: Vec<f64> = a.iter().map(|x| 3.0 * x - 1.0).collect();
            let n = f64::from(n);
            let squares = (n - 1.0) * n * (2.0 * n - 1.0) / 6.0;
            let expect = 3.0 * squares - n * (n - 1.0) / 2.0;
            assert!((dot(&a, &b) - expect).abs() < 1e-9, "{n}");
        }
    }

    #[test]
    fn the_widest_vectors_have_the_bits_of_the_narrowest() {
        let x: Vec<f64> = (1..1000).map(|i| f64::from(i).sqrt()).collect();
        let y: Vec<f64> = x.iter().map(|x| x + 1e-9).collect();
        let plain: Vec<f64> = (0..x.len()).map(|i| sums(&x[i..=i], &y[i..=i])[0]).collect();
        let wide = widest(
            #[inline(always)]
            || sums(&x, &y),
        );
        let narrow = dispatch!(Level::baseline(), _vectors => sums(&x, &y));
        assert_eq!((&wide, &narrow), (&plain, &plain));
    }
}
