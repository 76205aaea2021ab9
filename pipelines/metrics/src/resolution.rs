//! How fine the angles of a recording are.

use zwidth_numerics::series::ends;

/// Smaller steps between angles are their arithmetic, not a sensor, rad.
const LEAST_RAD: f64 = 1e-9;

/// About how many angles are sorted at a time: a long recording is not copied whole.
const AT_ONCE: usize = 1 << 20;

/// Parts whose angles are gathered in one walk.
const TOGETHER: usize = 4;

/// The smallest step between two angles of the recording, rad: a count of the angle sensor, where
/// it has counts. 0 for a lever that never moves.
pub(crate) fn resolution_rad(theta: &[f64]) -> f64 {
    let nothing = Sorted { last: None, least: f64::INFINITY };
    let sorted = match theta.len() {
        0 => nothing,
        1..=AT_ONCE => nothing.with_all(theta.to_vec()),
        _ => within(theta, ends(theta), nothing, AT_ONCE),
    };
    if sorted.least.is_finite() { sorted.least } else { 0.0 }
}

/// Angles up to some angle, in order: the last of them, and the smallest step.
#[derive(Clone, Copy)]
struct Sorted {
    last: Option<f64>,
    least: f64,
}

impl Sorted {
    /// With the next angle, which is no smaller than the last.
    fn with(self, next: f64) -> Self {
        let step = self.last.map(|last| next - last).filter(|step| *step > LEAST_RAD);
        Self { last: Some(next), least: step.map_or(self.least, |step| self.least.min(step)) }
    }

    /// With some that follow, in any order.
    fn with_all(self, mut some: Vec<f64>) -> Self {
        // A lever at rest has one angle for long, and on its way they are in order: this sort takes them
        // as they come.
        some.dedup_by_key(|theta| theta.to_bits());
        some.sort_by(f64::total_cmp);
        let Some((first, last)) = some.first().zip(some.last()) else { return self };
        let steps = some.windows(2).map(|two| two[1] - two[0]);
        let least = steps.fold(self.with(*first).least, |least, step| {
            if step > LEAST_RAD && step < least { step } else { least }
        });
        Self { last: Some(*last), least }
    }
}

/// The angles from `low` to `high`, which are two of them, after those before: sorted, or where they
/// are many, part by part.
fn within(theta: &[f64], (low, high): (f64, f64), before: Sorted, at_once: usize) -> Sorted {
    if low >= high {
        return before.with(low);
    }
    let parts = (2 * theta.len()).div_ceil(at_once);
    let bound = |end: usize| low + (high - low) * (end as f64 / parts as f64);
    let mut sorted = before;
    for first in (0..parts).step_by(TOGETHER) {
        let next = parts.min(first + TOGETHER);
        // The last bound may be rounded to below `high`, whose angle must not be lost.
        let is_last = next == parts;
        let (from, to) = (bound(first), bound(next));
        let inner: Vec<f64> = (first + 1..next).map(bound).collect();
        let angles = theta.iter().copied();
        let angles =
            angles.filter(|theta| *theta >= from && (*theta < to || is_last) && *theta <= high);
        let part = |theta: f64| inner.iter().filter(|bound| theta >= **bound).count();
        let mut some = vec![Vec::new(); next - first];
        for theta in angles.clone() {
            let some = &mut some[part(theta)];
            if some.len() <= at_once {
                some.push(theta);
            }
        }
        for (i, some) in some.into_iter().enumerate() {
            if some.len() > at_once {
                let own = angles.clone().filter(|theta| part(*theta) == i);
                let ends = own.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), theta| {
                    (low.min(theta), high.max(theta))
                });
                sorted = within(theta, ends, sorted, at_once);
            } else {
                sorted = sorted.with_all(some);
            }
        }
    }
    sorted
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

    /// Many angles, few of them apart, among them neighbouring numbers.
    #[test]
    fn angles_that_are_looked_at_part_by_part_have_the_step_of_all() {
        let spread: Vec<f64> = (0..2000_u32).map(|i| f64::from(i * 7919 % 2000) * 1e-3).collect();
        let next = 1.0_f64.next_up();
        let few: Vec<f64> = (0..2000).map(|i| [0.5, 1.0, next, 1.25][i % 4]).collect();
        let one = vec![0.5; 2000];
        for (angles, step) in [(&spread, 1e-3), (&few, 0.25), (&one, 0.0)] {
            let nothing = Sorted { last: None, least: f64::INFINITY };
            for at_once in [1, 2, 16, 100, 5000] {
                let Sorted { least, .. } = within(angles, ends(angles), nothing, at_once);
                let least = if least.is_finite() { least } else { 0.0 };
                assert!((least - step).abs() < 1e-12, "{at_once}: {least}");
            }
            assert!((resolution_rad(angles) - step).abs() < 1e-12);
        }
    }
}
