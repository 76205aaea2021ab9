//! Landmarks of a movement, and the time warp that aligns those of several repeats.

use std::fmt;

/// A point of a movement that every repeat passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Landmark {
    /// Movement onset.
    Start,
    /// The lever first passes the wall's angle, on the straight line between the samples around it.
    WallContact,
    /// First sample of the largest angle between onset and end.
    Reversal,
    /// The way back begins: where a brake holds the lever, when it lets go.
    Return,
    /// Movement end.
    End,
}

impl Landmark {
    /// In the order in which a movement passes them.
    pub const ALL: [Self; 5] =
        [Self::Start, Self::WallContact, Self::Reversal, Self::Return, Self::End];
}

impl fmt::Display for Landmark {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::WallContact => "wall contact",
            Self::Reversal => "reversal",
            Self::Return => "return",
            Self::End => "end",
        })
    }
}

/// The time at which a repeat passes each landmark, s since its onset, in the order of
/// [`Landmark::ALL`]; `None` where it does not.
pub(crate) type Times = [Option<f64>; 5];

/// The landmarks that every repeat passes, each after the one before; start and end always (they
/// must be there). A wall that one repeat does not reach, or a reversal that coincides with the end
/// because a brake holds the lever, is not a landmark for any of them.
pub(crate) fn shared(repeats: &[Times]) -> Vec<Landmark> {
    let [start, wall, reversal, returns, end] = Landmark::ALL;
    let mut shared = vec![start];
    for landmark in [wall, reversal, returns] {
        let before = shared[shared.len() - 1];
        if repeats.iter().all(|times| {
            let [t, t_before, t_end] = [landmark, before, end].map(|l| times[l as usize]);
            t.zip(t_before).zip(t_end).is_some_and(|((t, before), end)| before < t && t < end)
        }) {
            shared.push(landmark);
        }
    }
    shared.push(end);
    shared
}

/// The time t of a repeat that passes landmarks at `own` times, on the scale where they are at
/// `common` times: piecewise linear between them, and past the last a shift. Both increase and are
/// of one length; times before the first landmark shift with it.
pub(crate) fn warp(t: f64, own: &[f64], common: &[f64]) -> f64 {
    let after = own.partition_point(|own| *own <= t);
    let Some(before) = after.checked_sub(1) else {
        return t - own[0] + common[0];
    };
    if after == own.len() {
        return common[before] + (t - own[before]);
    }
    let share = (t - own[before]) / (own[after] - own[before]);
    common[before] + share * (common[after] - common[before])
}

#[cfg(test)]
mod tests {
    use super::*;
    use Landmark::{End, Return, Reversal, Start, WallContact};

    #[test]
    fn a_landmark_counts_if_every_repeat_passes_it_in_order() {
        let whole = [Some(0.0), Some(0.5), Some(1.0), Some(1.5), Some(2.0)];
        let no_wall = [Some(0.0), None, Some(1.0), Some(1.5), Some(2.0)];
        let held = [Some(0.0), Some(0.5), Some(1.0), None, Some(1.0)];
        assert_eq!(shared(&[whole, whole]), Landmark::ALL);
        assert_eq!(shared(&[whole, no_wall]), [Start, Reversal, Return, End]);
        assert_eq!(shared(&[whole, held]), [Start, WallContact, End]);
        assert_eq!(shared(&[no_wall, held]), [Start, End]);
    }

    #[test]
    fn a_warp_takes_landmarks_to_landmarks_and_runs_straight_between_them() {
        let (own, common) = ([0.0, 1.0, 3.0], [0.0, 2.0, 3.0]);
        for (t, expect) in
            [(-0.5, -0.5), (0.0, 0.0), (0.25, 0.5), (1.0, 2.0), (2.0, 2.5), (3.0, 3.0), (4.0, 4.0)]
        {
            assert!((warp(t, &own, &common) - expect).abs() < 1e-15, "{t}");
        }
    }
}
