//! How fine the angles of a recording are.

/// Smaller steps between angles are their arithmetic, not a sensor, rad.
const LEAST_RAD: f64 = 1e-9;

/// The smallest step between two angles of the recording, rad: a count of the angle sensor, where
/// it has counts. 0 for a lever that never moves.
pub(crate) fn resolution_rad(theta: &[f64]) -> f64 {
    let mut sorted = theta.to_vec();
    sorted.sort_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > LEAST_RAD);
    steps.reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resolution_is_a_count_however_the_lever_moves() {
        let count = 2.25e-4;
        let theta = [0.0, 3.0, 1.0, 7.0, 2.0, 3.0].map(|n: f64| 0.1 + n * count);
        assert!((resolution_rad(&theta) - count).abs() < 1e-15);
        assert!(resolution_rad(&[1.0, 1.0 + 1e-12]).abs() < 1e-300);
        assert!(resolution_rad(&[]).abs() < 1e-300);
    }
}
