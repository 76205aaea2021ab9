//! Sobol' points: a sequence that fills a cube more evenly than random points do.

/// Bits of a coordinate.
const BITS: usize = 32;

/// Coordinates that there are direction numbers for.
pub const MOST_SOBOL_DIMENSIONS: usize = 21;

/// Degree s, the inner coefficients a of the primitive polynomial, and m₁ … m_s of each coordinate
/// after the first.
const DIRECTIONS: [(usize, u32, &[u32]); MOST_SOBOL_DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

/// The first points of Sobol's sequence, the zero point left out, in the order of Antonov & Saleev
/// (Gray code), each within (0, 1). Not scrambled: the same points every time. `None` for more than
/// [`MOST_SOBOL_DIMENSIONS`] coordinates.
///
/// Direction numbers: S. Joe & F. Y. Kuo, SIAM J. Sci. Comput. 30 (2008) 2635–2654
/// (`new-joe-kuo-6`); order: I. A. Antonov & V. M. Saleev, USSR Comput. Math. Math. Phys. 19 (1980)
/// 252–256.
pub fn sobol_points(dimensions: usize, points: usize) -> Option<Vec<Vec<f64>>> {
    (dimensions <= MOST_SOBOL_DIMENSIONS).then_some(())?;
    let directions: Vec<[u32; BITS]> = (0..dimensions).map(directions).collect();
    let mut at = vec![0_u32; dimensions];
    let sequence = (0..points).map(|k| {
        // The one bit in which the Gray codes of k and k + 1 differ.
        let bit = (k.trailing_ones() as usize).min(BITS - 1);
        for (x, v) in at.iter_mut().zip(&directions) {
            *x ^= v[bit];
        }
        at.iter().map(|x| f64::from(*x) / (1_u64 << BITS) as f64).collect()
    });
    Some(sequence.collect())
}

/// The direction numbers of a coordinate: v_k = m_k 2^(32−k), by the polynomial's recurrence after
/// the initial ones.
fn directions(coordinate: usize) -> [u32; BITS] {
    let Some((degree, inner, initial)) = coordinate.checked_sub(1).map(|i| DIRECTIONS[i]) else {
        return std::array::from_fn(|k| 1 << (BITS - 1 - k));
    };
    let mut v = [0; BITS];
    for k in 0..BITS {
        v[k] = match initial.get(k) {
            Some(m) => m << (BITS - 1 - k),
            None => (1..degree).fold(v[k - degree] ^ (v[k - degree] >> degree), |sum, i| {
                if inner >> (degree - 1 - i) & 1 == 1 { sum ^ v[k - i] } else { sum }
            }),
        };
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published first points of three coordinates.
    #[test]
    fn the_first_points_are_the_published_ones() {
        let published = [
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
            [0.875, 0.875, 0.125],
            [0.625, 0.125, 0.875],
            [0.125, 0.625, 0.375],
            [0.1875, 0.3125, 0.9375],
            [0.6875, 0.8125, 0.4375],
        ];
        assert_eq!(sobol_points(3, 9).unwrap(), published.map(Vec::from));
    }

    /// With the zero point, 2^k points have one in each interval of length 2^−k of every
    /// coordinate.
    #[test]
    fn every_coordinate_is_stratified() {
        let points = sobol_points(MOST_SOBOL_DIMENSIONS, 4095).unwrap();
        for coordinate in 0..MOST_SOBOL_DIMENSIONS {
            let mut cells: Vec<u32> =
                points.iter().map(|point| (4096.0 * point[coordinate]) as u32).collect();
            cells.sort_unstable();
            assert_eq!(cells, (1..4096).collect::<Vec<_>>(), "coordinate {coordinate}");
        }
    }

    /// ∫ Π (1 + (x_i − 1/2)) = 1: the sequence's error is far below that of as many random points
    /// (0.3/√1023 = 0.01).
    #[test]
    fn it_integrates_a_product_better_than_random_points() {
        let points = sobol_points(6, 1023).unwrap();
        let sum: f64 = points.iter().map(|x| x.iter().map(|x| 0.5 + x).product::<f64>()).sum();
        assert!((sum / 1023.0 - 1.0).abs() < 0.002, "{}", sum / 1023.0);
    }

    #[test]
    fn more_coordinates_than_there_are_numbers_for_are_refused() {
        assert!(sobol_points(MOST_SOBOL_DIMENSIONS + 1, 1).is_none());
    }
}
