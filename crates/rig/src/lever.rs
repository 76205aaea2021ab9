//! Where a lever stands.

use zwidth_device::Weighed;

/// A lever at rest moves by no more, rad: 0.1°.
const AT_REST_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Where a lever at rest stands, rad: the middle of its angles. None of one that moves, or whose turn is not known.
pub(crate) fn stands(values: &[Weighed]) -> Option<f64> {
    let angles = values.iter().filter_map(|value| value.theta_rad);
    let [low, high] = angles.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], theta| {
        [low.min(theta), high.max(theta)]
    });
    (high - low <= AT_REST_RAD && low <= high).then_some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stands_at(angles: &[Option<f64>]) -> Option<f64> {
        let weighed = |theta_rad: &Option<f64>| Weighed {
            t_s: 0.0,
            voltage_v: 0.0,
            force_n: 0.0,
            theta_rad: *theta_rad,
        };
        stands(&angles.iter().map(weighed).collect::<Vec<_>>())
    }

    #[test]
    fn a_lever_stands_where_its_angles_are_close_to_each_other_and_nowhere_without_any() {
        assert_eq!(stands_at(&[Some(0.5), None, Some(0.501)]), Some(0.5005));
        assert_eq!(stands_at(&[Some(0.5), Some(0.502)]), None);
        assert_eq!(stands_at(&[None, None]), None);
        assert_eq!(stands_at(&[]), None);
    }
}
