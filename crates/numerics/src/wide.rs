//! Loops over as many numbers at a time as the processor can take.

use fearless_simd::{Level, dispatch};

/// What `work` gives, compiled for the widest vectors that this processor has; what it calls is so only
/// if it is `#[inline(always)]`, as `work` itself must be. The bits are those of any other processor: a
/// product and a sum are never rounded as one, and sums run in the order of the code.
#[inline(always)]
pub fn widest<T>(work: impl FnOnce() -> T) -> T {
    dispatch!(Level::new(), _vectors => work())
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
