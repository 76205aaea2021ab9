//! The ranges of axes in figures that are to be compared with each other, and the part of one that
//! deserves a panel of its own.

use crate::course::data::EnvironmentData;
use crate::course::panels::on_axis;
use zwidth_draw::Range;
use zwidth_store::Signal;

/// A mode that goes past the wall by less than this share of all angles shown stands in one line
/// with it in print.
const NEAR: f64 = 0.02;
/// A panel of the wall reaches past it by so much more than the modes that stay near it.
const PAST: f64 = 1.3;
/// It begins before the wall by this share of what it shows past it.
const BEFORE: f64 = 0.5;
/// A command beyond what was felt by more than this would squeeze what was felt.
const EXCESS: f64 = 1.2;

/// The smallest and the largest of finite numbers.
pub(crate) fn ends(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite.fold(None, |ends: Option<(f64, f64)>, v| {
        Some(ends.map_or((v, v), |(low, high)| (low.min(v), high.max(v))))
    })
}

/// An axis that holds these values.
pub(crate) fn holding(values: impl IntoIterator<Item = f64>) -> Range {
    ends(values).map_or(Range::Auto, |(low, high)| Range::Holding(low, high))
}

/// The axis of a signal that holds every repeat of all these environments.
pub(crate) fn shared(scenes: &[&EnvironmentData], signal: Signal) -> Range {
    let words = scenes[0].words();
    let repeats = scenes.iter().flat_map(|scene| scene.repeats());
    holding(repeats.filter_map(|r| r.signal(signal)).flat_map(|v| on_axis(words, signal, v)))
}

/// The axis of time that holds the same.
pub(crate) fn shared_time(scenes: &[&EnvironmentData]) -> Range {
    // Times since onset and times since the start of a trial have no common axis.
    let aligned = scenes[0].aligned();
    let repeats = scenes
        .iter()
        .filter(|scene| scene.aligned() == aligned)
        .flat_map(|scene| scene.repeats())
        .filter(|repeat| repeat.onset_s.is_some() || !aligned);
    match ends(repeats.flat_map(|repeat| repeat.time())) {
        Some((low, high)) if high > low => Range::Fixed(low, high),
        _ => Range::Tight,
    }
}

/// The part of the position's axis around the wall in which what some mode does past it can be
/// read; none where no mode stays near the wall, because then it can be read as it is.
pub(crate) fn at_wall(scene: &EnvironmentData) -> Option<(f64, f64)> {
    let words = scene.words();
    let wall = words.position(scene.environment.scene.wall_rad()?);
    let positions = |theta: &[f64]| on_axis(words, Signal::Theta, theta);
    let all = scene.repeats().filter_map(|repeat| repeat.signal(Signal::Theta));
    let (low, high) = ends(all.flat_map(positions))?;
    let past = scene.modes.iter().filter_map(|mode| {
        let thetas = mode.repeats.iter().filter_map(|r| r.signal(Signal::Theta));
        Some(ends(thetas.flat_map(positions))?.1 - wall)
    });
    let near = past.filter(|past| *past > 0.0 && *past <= NEAR * (high - low));
    let past = PAST * near.reduce(f64::max)?;
    Some((wall - BEFORE * past, wall + past))
}

/// An axis of forces cut where only the command goes on, and how far it goes; `None` where the
/// command lies among the forces or little above them.
pub(crate) fn without_excess(
    felt: impl IntoIterator<Item = f64>,
    commanded: impl IntoIterator<Item = f64>,
) -> Option<(Range, f64)> {
    let (low, high) = ends(felt)?;
    let (_, most) = ends(commanded)?;
    let room = 0.1 * (high - low);
    let cut = high > low && most > high + (EXCESS - 1.0) * (high - low);
    cut.then_some((Range::Fixed(low - room / 2.0, high + room), most))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_that_nobody_felt_does_not_squeeze_what_was_felt() {
        assert_eq!(without_excess([0.0, 5.0], [0.0, 5.9]), None);
        let (range, most) = without_excess([0.0, 5.0], [f64::NAN, 13.0]).unwrap();
        assert_eq!((range, most), (Range::Fixed(-0.25, 5.5), 13.0));
        assert_eq!(without_excess([], [13.0]), None);
        assert_eq!(without_excess([1.0], [13.0]), None, "one force has no extent");
    }

    #[test]
    fn ends_leave_out_what_is_no_number() {
        assert_eq!(ends([f64::NAN, 2.0, -1.0, f64::INFINITY]), Some((-1.0, 2.0)));
        assert_eq!(ends([f64::NAN]), None);
    }
}
