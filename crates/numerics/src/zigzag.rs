//! A signal as a zigzag: the legs between its turns, without small wiggles.

/// One way of a zigzag: sample indices, both inclusive; the next leg begins where this one ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// Where the leg begins: an extreme of the signal, or its first sample.
    pub from: usize,
    /// The extreme where the leg ends.
    pub to: usize,
    /// Whether it leads upwards.
    pub up: bool,
}

/// The legs of `y`: a leg ends at an extreme from which `y` retreats by more than `least` (in the
/// unit of `y`); the first one begins with the first sample and counts once it is longer than
/// `least`. Empty if `y` never leaves a range of `least`.
///
/// With `least` above the noise, turns of noise are none; every leg but the first is longer than
/// `least`. This is the hysteresis filter of rainflow counting (ASTM E1049).
pub fn zigzag(y: &[f64], least: f64) -> Vec<Leg> {
    let Some(mut now) = first_leg(y, least) else { return Vec::new() };
    let mut legs = Vec::new();
    let mut sign = if now.up { 1.0 } else { -1.0 };
    let mut extreme = y[now.to];
    for (i, &y) in y.iter().enumerate().skip(now.to + 1) {
        let beyond = sign * (y - extreme);
        if beyond > 0.0 {
            (now.to, extreme) = (i, y);
        } else if -beyond > least {
            legs.push(now);
            now = Leg { from: now.to, to: i, up: !now.up };
            (sign, extreme) = (-sign, y);
        }
    }
    legs.push(now);
    legs
}

/// The first leg, as far as the sample that tells its direction.
fn first_leg(y: &[f64], least: f64) -> Option<Leg> {
    let mut lowest = *y.first()?;
    let mut highest = *y.first()?;
    y.iter().enumerate().find_map(|(to, &y)| {
        (lowest, highest) =
            (if y < lowest { y } else { lowest }, if y > highest { y } else { highest });
        let up = y - lowest > least;
        let down = highest - y > least;
        (up || down).then_some(Leg { from: 0, to, up })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(y: &[f64], least: f64, expect: &[(usize, usize)]) {
        let found = zigzag(y, least);
        assert_eq!(found.iter().map(|l| (l.from, l.to)).collect::<Vec<_>>(), expect, "{y:?}");
        assert!(found.iter().all(|l| l.up == (y[l.to] > y[l.from])));
        assert!(found.windows(2).all(|w| w[0].up != w[1].up && w[0].to == w[1].from));
    }

    #[test]
    fn legs_end_at_extremes_and_wiggles_are_none() {
        check(&[0.0, 1.0, 2.0, 1.9, 3.0, 1.0, 1.1, 0.0], 0.5, &[(0, 4), (4, 7)]);
        check(&[3.0, 0.0, 3.0, 3.0, 0.0], 1.0, &[(0, 1), (1, 2), (2, 4)]);
    }

    #[test]
    fn a_signal_within_its_noise_has_no_leg() {
        check(&[0.0, 0.4, -0.1, 0.3], 0.5, &[]);
        check(&[], 0.5, &[]);
    }

    #[test]
    fn a_sine_of_five_periods_has_a_leg_between_any_two_extremes() {
        let y: Vec<f64> =
            (0..1000).map(|i| libm::sin(f64::from(i) * core::f64::consts::PI / 100.0)).collect();
        let legs = zigzag(&y, 0.1);
        assert_eq!(legs.len(), 11);
        assert!(legs[1..10].iter().all(|l| l.to - l.from == 100));
        assert_eq!(zigzag(&y, 2.1).len(), 0);
    }
}
