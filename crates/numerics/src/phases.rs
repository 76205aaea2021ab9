//! The phases of one movement there and back, and where it passes a level on its way.

/// The phases of a movement: indices of samples, each inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Phases {
    /// First sample of the movement.
    pub onset: usize,
    /// First sample of the largest coordinate between onset and end: there the way back begins.
    pub reversal: usize,
    /// Last sample of the movement.
    pub end: usize,
}

/// The phases of a movement that lasts from sample `onset` to sample `end` of the coordinate `x`;
/// both must lie in `x`.
pub fn phases(x: &[f64], onset: usize, end: usize) -> Phases {
    let mut reversal = onset;
    for i in onset..=end {
        if x[i] > x[reversal] {
            reversal = i;
        }
    }
    Phases { onset, reversal, end }
}

/// The sample at which a movement begins to return: the first one from the reversal on from which the
/// velocity stays below −`offset` until it falls below −`onset`. `None` if it never does.
pub fn return_begins(velocity: &[f64], phases: Phases, onset: f64, offset: f64) -> Option<usize> {
    let mut begins = None;
    for (i, v) in velocity.iter().enumerate().take(phases.end + 1).skip(phases.reversal) {
        begins = (*v < -offset).then(|| begins.unwrap_or(i));
        if *v < -onset {
            return begins;
        }
    }
    None
}

/// When the polyline through (tᵢ, xᵢ) first passes `level` upwards, in the unit of `t`. `None` if
/// it never exceeds `level`, or does so from its first sample on.
pub fn first_passing(t: &[f64], x: &[f64], level: f64) -> Option<f64> {
    let after = x.iter().position(|x| *x > level)?;
    let before = after.checked_sub(1)?;
    let share = (level - x[before]) / (x[after] - x[before]);
    Some(t[before] + share * (t[after] - t[before]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reversal_is_the_first_sample_of_the_largest_value() {
        let x = [9.0, 0.0, 2.0, 3.0, 3.0, 1.0, 9.0];
        assert_eq!(phases(&x, 1, 5), Phases { onset: 1, reversal: 3, end: 5 });
        assert_eq!(phases(&x, 5, 5), Phases { onset: 5, reversal: 5, end: 5 });
    }

    #[test]
    fn a_return_begins_where_the_way_back_that_gets_fast_does() {
        let v = [0.0, 1.0, 0.0, -0.3, 0.1, -0.3, -0.4, -2.0, 0.0];
        let phases = Phases { onset: 1, reversal: 2, end: 8 };
        assert_eq!(return_begins(&v, phases, 1.0, 0.2), Some(5));
        assert_eq!(return_begins(&v, phases, 3.0, 0.2), None);
    }

    #[test]
    fn a_level_is_passed_between_the_samples_on_its_two_sides() {
        let (t, x) = ([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, 2.0, 0.0]);
        assert_eq!(first_passing(&t, &x, 1.25), Some(1.5));
        assert_eq!(first_passing(&t, &x, 1.0), Some(1.0));
        assert_eq!(first_passing(&t, &x, 2.0), None);
        assert_eq!(first_passing(&t, &x, -1.0), None);
    }
}
