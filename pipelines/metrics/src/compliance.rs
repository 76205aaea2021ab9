//! Whether a trial was what the protocol asks for.

use crate::Parameters;
use crate::signals::Signals;
use zwidth_numerics::series::ends;
use zwidth_numerics::zigzag::zigzag;
use zwidth_study::counted;

/// A movement is a way of more than this share of the angles travelled; less is a correction or a
/// wobble.
pub(crate) const MOVEMENT_SHARE: f64 = 0.1;
/// The lever is outside the work space when it is beyond an end by more than this share of it: the
/// ends are stops, which give a little, and the angle sensor is not exact.
const OUTSIDE_SHARE: f64 = 0.01;

/// Whether a trial was what the protocol asks for (thesis §5.2.2): one forward and one backward
/// movement, in no more than the time allowed, inside the work space.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Compliance {
    /// Ways forward between onset and end: ways up of the zigzag of θ that are longer than 10 % of
    /// the angles travelled there. Null without a movement.
    pub movements_forward: Option<i64>,
    /// Ways back, likewise.
    pub movements_backward: Option<i64>,
    /// One way forward and one way back, in this order. In a mode that has a brake and no motor
    /// the way back may be missing: nothing there returns the lever.
    pub one_movement: Option<bool>,
    /// Whether the movement takes no longer than `design.trial_limit_s`. Null without an onset,
    /// and where the recording stops within both movement and limit.
    pub in_time: Option<bool>,
    /// Whether θ stays within the work space over the whole recording; an excess of 1 % of the
    /// work space is allowed. Null unless both ends are known.
    pub inside_work_space: Option<bool>,
    /// Whether all three hold: false if one does not; null if one is null and the others hold.
    pub met: Option<bool>,
}

impl Compliance {
    /// What the trial lacks of the protocol, in words; empty where it met all that can be told.
    pub fn unmet(&self, limit_s: f64) -> Vec<String> {
        let mut unmet = Vec::new();
        match (self.movements_forward, self.movements_backward) {
            (Some(forward), Some(back)) if self.one_movement == Some(false) => {
                let forward = counted(usize::try_from(forward).unwrap_or(0), "movements forward");
                unmet.push(format!("{forward}, {back} back"));
            }
            (None, _) => unmet.push("no movement".to_owned()),
            _ => {}
        }
        match self.in_time {
            Some(false) => unmet.push(format!("the movement took longer than {limit_s} s")),
            None if self.movements_forward.is_some() => {
                unmet.push("the recording ended before the movement".to_owned());
            }
            _ => {}
        }
        if self.inside_work_space == Some(false) {
            unmet.push("the lever left the work space".to_owned());
        }
        unmet
    }
}

pub(crate) fn compliance(signals: &Signals, parameters: &Parameters) -> Compliance {
    let ways = ways(signals);
    let one_movement = ways.as_deref().map(|ways| match ways {
        [true, false] => true,
        [true] => parameters.brakes_only(),
        _ => false,
    });
    let [movements_forward, movements_backward] = [true, false]
        .map(|up| Some(ways.as_ref()?.iter().filter(|way| **way == up).count() as i64));
    let in_time = in_time(signals, parameters.trial_limit_s);
    let inside_work_space = inside(signals.theta().as_deref(), parameters);
    Compliance {
        movements_forward,
        movements_backward,
        one_movement,
        in_time,
        inside_work_space,
        met: all([one_movement, in_time, inside_work_space]),
    }
}

/// The movements in order, true for a way forward.
fn ways(signals: &Signals) -> Option<Vec<bool>> {
    let theta = signals.theta()?;
    let phases = signals.phases?;
    let moving = &theta[phases.onset..=phases.end];
    let least = MOVEMENT_SHARE * range(moving);
    Some(zigzag(moving, least).iter().map(|leg| leg.up).collect())
}

/// Largest minus smallest value; `values` has at least one.
pub(crate) fn range(values: &[f64]) -> f64 {
    let (low, high) = ends(values);
    high - low
}

fn in_time(signals: &Signals, limit_s: f64) -> Option<bool> {
    let activity = signals.activity?;
    let t = signals.t().ok()?;
    let last = activity.end.unwrap_or(t.len() - 1);
    let took_s = t[last] - t[activity.onset];
    // A recording that stops in mid movement is late once it has passed the limit.
    (activity.end.is_some() || took_s > limit_s).then_some(took_s <= limit_s)
}

fn inside(theta: Option<&[f64]>, parameters: &Parameters) -> Option<bool> {
    let min = parameters.theta_min_rad?;
    let max = parameters.theta_max_rad?;
    let (low, high) = ends(theta?);
    let excess = OUTSIDE_SHARE * (max - min);
    Some(low >= min - excess && high <= max + excess)
}

/// Three-valued "and".
fn all<const N: usize>(parts: [Option<bool>; N]) -> Option<bool> {
    if parts.contains(&Some(false)) {
        Some(false)
    } else {
        (!parts.contains(&None)).then_some(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, in_spring, stroke, trial};
    use crate::trial_metrics;

    type Points = Vec<(f64, f64, f64)>;

    fn compliance(points: &Points, change: impl FnOnce(&mut Parameters)) -> Compliance {
        let mut parameters = in_spring(4.0, REST_RAD);
        change(&mut parameters);
        trial_metrics(&trial(points, |_, _| 0.0), &parameters).unwrap().compliance
    }

    #[test]
    fn what_was_not_met_is_told_in_words_and_what_cannot_be_told_of_a_device_is_not() {
        let met = Compliance {
            movements_forward: Some(1),
            movements_backward: Some(1),
            one_movement: Some(true),
            in_time: Some(true),
            inside_work_space: None,
            met: None,
        };
        let told = |compliance: Compliance| compliance.unmet(4.0).join("; ");
        assert_eq!(told(met), "");
        let twice = Compliance {
            movements_forward: Some(2),
            one_movement: Some(false),
            in_time: Some(false),
            inside_work_space: Some(false),
            ..met
        };
        let all = "2 movements forward, 1 back; the movement took longer than 4 s; the lever left the work space";
        assert_eq!(told(twice), all);
        let cut = Compliance { in_time: None, ..met };
        assert_eq!(told(cut), "the recording ended before the movement");
        assert_eq!(told(Compliance::default()), "no movement");
    }

    #[test]
    fn a_movement_there_and_back_in_time_and_inside_meets_the_protocol() {
        let found = compliance(&stroke(1.2, 2.0), |_| ());
        let all = Compliance {
            movements_forward: Some(1),
            movements_backward: Some(1),
            one_movement: Some(true),
            in_time: Some(true),
            inside_work_space: Some(true),
            met: Some(true),
        };
        assert_eq!(found, all);
    }

    #[test]
    fn two_strokes_are_not_one_movement() {
        let once = stroke(1.2, 2.0);
        let again: Points = once.iter().map(|p| (p.0 + 3.001, p.1, p.2)).collect();
        let found = compliance(&[once, again].concat(), |_| ());
        assert_eq!((found.movements_forward, found.movements_backward), (Some(2), Some(2)));
        assert_eq!(
            (found.one_movement, found.in_time, found.met),
            (Some(false), Some(false), Some(false))
        );
    }

    #[test]
    fn a_lever_that_a_brake_holds_need_not_come_back() {
        let forward: Points = stroke(1.2, 2.0).into_iter().take_while(|p| p.0 <= 1.5).collect();
        let held: Points =
            (1..500).map(|i| (1.5 + f64::from(i) / 1000.0, forward[1500].1, 0.0)).collect();
        let points = [forward, held].concat();
        let one = |change: fn(&mut Parameters)| compliance(&points, change).one_movement;
        assert_eq!(one(|_| ()), Some(false));
        assert_eq!(one(|p| p.uses_motor = false), Some(true));
    }

    #[test]
    fn a_recording_that_stops_too_soon_leaves_the_time_open() {
        let cut: Points = stroke(1.2, 2.0).into_iter().take_while(|p| p.0 <= 2.0).collect();
        assert_eq!(compliance(&cut, |_| ()).in_time, None);
        assert_eq!(compliance(&cut, |s| s.trial_limit_s = 1.0).in_time, Some(false));
        assert_eq!(compliance(&cut, |_| ()).met, None);
    }

    #[test]
    fn a_lever_beyond_its_work_space_is_outside_and_an_unknown_work_space_is_null() {
        let points = stroke(1.2, 2.0);
        let inside =
            |max: Option<f64>| compliance(&points, |s| s.theta_max_rad = max).inside_work_space;
        assert_eq!(inside(Some(REST_RAD + 1.19)), Some(true));
        assert_eq!(inside(Some(REST_RAD + 1.18)), Some(false));
        assert_eq!(inside(None), None);
    }
}
