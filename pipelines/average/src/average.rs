//! The average of one condition's repeats.

use crate::align::{Aligned, average_length_s, check_lengths, grid, mean_landmarks, warped};
use crate::landmarks::{Landmark, warp};
use crate::{AverageError, WhyNot};
use serde::Serialize;
use zwidth_stats::band::{Band, band};
use zwidth_store::{Recorded, Signal, Trial};
use zwidth_study::{
    Alignment, Analysis, Condition, ParticipantId, Scene, SceneKind, SessionId, Source,
};

/// Everything that is averaged, in the order of the columns.
pub const SIGNALS: [Signal; 5] =
    [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx, Signal::ForceCmd];

/// One repeat that entered the average.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Its trial's number.
    pub trial: u32,
    /// Its number among the repeats of the condition.
    pub repeat: u32,
    /// Its onset on its own clock, s: the average's t = 0.
    pub onset_s: f64,
    /// Onset to last sample on the average's time scale, s.
    pub length_s: f64,
}

/// One repeat that did not enter the average.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its trial's number.
    pub trial: u32,
    /// The reason.
    pub why: WhyNot,
}

/// A signal over the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The signal.
    pub signal: Signal,
    /// Mean, SD and band of the repeats at each time of the grid.
    pub band: Band,
}

/// Everything that the average of a condition's trials depends on besides the trials.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameters {
    /// Thresholds, grid and confidence level.
    pub analysis: Analysis,
    /// The rendered scene.
    pub scene: Scene,
}

/// The mean course of one condition's repeats by one participant in one session.
#[derive(Debug, Clone, PartialEq)]
pub struct Average {
    /// The participant.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The condition.
    pub condition: Condition,
    /// The source of the numbers: simulated if any repeat is, else that of the first.
    pub source: Source,
    /// How the repeats were aligned.
    pub alignment: Alignment,
    /// Landmarks and their mean times since onset, s, in order; empty where repeats are aligned at
    /// onset alone.
    pub landmarks: Vec<(Landmark, f64)>,
    /// The grid: time since onset, s; aligned by landmarks, on the scale of their mean times.
    pub t_s: Vec<f64>,
    /// Repeats that reach each time.
    pub n: Vec<usize>,
    /// The repeats averaged.
    pub repeats: Vec<Repeat>,
    /// The repeats that could not be.
    pub left_out: Vec<LeftOut>,
    /// Each signal that all repeats have.
    pub courses: Vec<Course>,
}

impl Average {
    /// How far through the movement the repeats are at a time of the grid: as many landmarks as
    /// [`Landmark::ALL`] has before the last one passed, straight between those that they share: 0
    /// at the start, 2 at the reversal, 3 at the return, 4 at the end. `None` outside, and where repeats are aligned
    /// at onset alone.
    pub fn phase(&self, t_s: f64) -> Option<f64> {
        let (times, phases): (Vec<f64>, Vec<f64>) =
            self.landmarks.iter().map(|(landmark, t)| (*t, *landmark as usize as f64)).unzip();
        let is_within = t_s >= *times.first()? && t_s <= *times.last()?;
        is_within.then(|| warp(t_s, &times, &phases))
    }
}

/// The mean course of `trials`: the repeats of one condition by one participant in one session, in
/// any number.
///
/// A repeat that cannot be placed (no velocity, no movement; for landmarks, no end) is left out and
/// listed; the result says so.
///
/// # Errors
/// [`AverageError::WhyNot`] if there is no average and no fault: free motion, or no repeat that can
/// be placed (the first one's reason). Otherwise: no trial, trials of different conditions, columns
/// of unequal length.
pub fn average<'a, T>(
    trials: &'a [T],
    parameters: &Parameters,
    alignment: Alignment,
) -> Result<Average, AverageError>
where
    &'a T: Into<Recorded<'a>>,
{
    let trials: Vec<Recorded> = trials.iter().map(Into::into).collect();
    let first = trials.first().ok_or(AverageError::Empty)?;
    let Placed { aligned, left_out, landmarks } = place(&trials, parameters, alignment)?;
    let points = parameters.analysis.grid_points;
    if points < 2 {
        return Err(AverageError::Grid { points });
    }
    let t_s = grid(average_length_s(aligned.iter().map(Aligned::length_s).collect()), points);
    Ok(Average {
        participant: first.meta.participant.clone(),
        session: first.meta.session.clone(),
        condition: first.meta.condition(),
        source: source_of(&trials),
        // Not from the bands: a signal that some repeat lacks has none.
        n: t_s.iter().map(|t| aligned.iter().filter(|a| a.length_s() >= *t).count()).collect(),
        courses: courses(&aligned, &t_s, parameters.analysis.confidence)?,
        repeats: aligned
            .iter()
            .map(|repeat| Repeat {
                trial: repeat.meta().trial,
                repeat: repeat.meta().repeat,
                onset_s: repeat.onset_s,
                length_s: repeat.length_s(),
            })
            .collect(),
        left_out,
        alignment,
        landmarks,
        t_s,
    })
}

/// The time of each sample of each trial on the scale of their average, s; `None` for a
/// repeat that is not in it.
///
/// # Errors
/// Those of [`average`].
pub fn times_s(
    trials: &[Trial],
    parameters: &Parameters,
    alignment: Alignment,
) -> Result<Vec<Option<Vec<f64>>>, AverageError> {
    let recorded: Vec<Recorded> = trials.iter().map(Into::into).collect();
    let placed = place(&recorded, parameters, alignment)?;
    let mut times_s = Vec::new();
    for trial in trials {
        // The repeats borrow their trials: the address tells which is whose.
        let aligned = placed.aligned.iter().find(|a| std::ptr::eq(a.meta(), &trial.meta));
        times_s.push(aligned.map(Aligned::times_s));
    }
    Ok(times_s)
}

/// Simulated if any of the trials is, else as the first; `Recorded` without trials.
pub(crate) fn source_of(trials: &[Recorded]) -> Source {
    let mut sources = trials.iter().map(|trial| trial.meta.source);
    let first = trials.first().map(|trial| trial.meta.source);
    sources.find(|source| source.is_simulated()).or(first).unwrap_or(Source::Recorded)
}

/// Repeats on the scale of their average.
pub(crate) struct Placed<'a> {
    pub(crate) aligned: Vec<Aligned<'a>>,
    pub(crate) left_out: Vec<LeftOut>,
    landmarks: Vec<(Landmark, f64)>,
}

/// Places every repeat that can be placed, and lists the others. If none can: the first one's
/// reason.
pub(crate) fn place<'a>(
    trials: &[Recorded<'a>],
    parameters: &Parameters,
    alignment: Alignment,
) -> Result<Placed<'a>, AverageError> {
    check_together(trials)?;
    let wall_rad = match parameters.scene.kind() {
        SceneKind::Free => return Err(WhyNot::FreeMotion.into()),
        SceneKind::None => return Err(WhyNot::NothingRendered.into()),
        _ => parameters.scene.wall_rad(),
    };
    let mut aligned = Vec::new();
    let mut left_out = Vec::new();
    for trial in trials {
        let repeat = Aligned::new(*trial, &parameters.analysis, wall_rad);
        match repeat.and_then(|repeat| repeat.fit_for(alignment)) {
            Ok(repeat) => aligned.push(repeat),
            Err(why) => left_out.push(LeftOut { trial: trial.meta.trial, why }),
        }
    }
    if let (true, Some(first)) = (aligned.is_empty(), left_out.first()) {
        return Err(first.why.clone().into());
    }
    let landmarks = match alignment {
        Alignment::Onset => Vec::new(),
        Alignment::Landmarks => mean_landmarks(&aligned),
    };
    let aligned = aligned.into_iter().map(|a| warped(a, &landmarks)).collect();
    Ok(Placed { aligned, left_out, landmarks })
}

fn check_together(trials: &[Recorded]) -> Result<(), AverageError> {
    let first = trials.first().ok_or(AverageError::Empty)?.meta;
    for Recorded { meta, .. } in trials {
        if (&meta.participant, &meta.session) != (&first.participant, &first.session)
            || meta.condition() != first.condition()
        {
            return Err(AverageError::Mixed { trial: meta.trial });
        }
    }
    trials.iter().try_for_each(check_lengths)
}

fn courses(aligned: &[Aligned], t_s: &[f64], level: f64) -> Result<Vec<Course>, AverageError> {
    let mut courses = Vec::new();
    for signal in SIGNALS {
        let rows: Option<Vec<_>> = aligned.iter().map(|a| a.on_grid(signal, t_s)).collect();
        // The mean of those that have a signal would be of other repeats than the other means.
        let Some(repeats) = rows else { continue };
        courses.push(Course { signal, band: band(&repeats, level)? });
    }
    Ok(courses)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{RATE_HZ, parameters, repeat, there_and_back};

    fn at_onset(trials: &[Trial], parameters: &Parameters) -> Average {
        average(trials, parameters, Alignment::Onset).unwrap()
    }

    fn begins_with_note(average: &Average, words: &str) {
        let notes = average.notes();
        assert!(notes[0].1.contains(words), "{notes:?}");
    }

    fn course(average: &Average, signal: Signal) -> &Course {
        average.courses.iter().find(|c| c.signal == signal).unwrap()
    }

    #[test]
    fn by_landmarks_every_repeat_turns_when_the_mean_does_and_one_without_an_end_has_no_place() {
        let mut trials = [(1.0, 0.5), (0.6, 0.9), (0.8, 0.7)]
            .map(|(there, back)| there_and_back(1, there, back));
        let turns = |trial: &Trial, times: &[f64]| {
            let theta = trial.samples.get(Signal::Theta).unwrap();
            let top = (0..theta.len()).max_by(|i, j| theta[*i].total_cmp(&theta[*j])).unwrap();
            times[top]
        };
        let by = |trials: &[Trial], alignment| times_s(trials, &parameters(), alignment).unwrap();
        let found = by(&trials, Alignment::Landmarks);
        let turned: Vec<f64> =
            trials.iter().zip(&found).map(|(t, times)| turns(t, times.as_ref().unwrap())).collect();
        for at in &turned {
            assert!((at - turned[0]).abs() < 2.0 / RATE_HZ, "{turned:?}");
        }
        let at_onset = by(&trials, Alignment::Onset);
        let apart = |i: usize| turns(&trials[i], at_onset[i].as_ref().unwrap());
        assert!(apart(0) - apart(1) > 0.3);
        let velocity = vec![1.0; trials[2].samples.len()];
        trials[2].samples.set(Signal::ThetaDot, velocity);
        assert!(by(&trials, Alignment::Landmarks)[2].is_none());
    }

    #[test]
    fn repeats_that_start_at_different_times_meet_at_their_onset() {
        let trials = [repeat(1, 0.3, 1.0, 3.0), repeat(2, 0.8, 1.0, 3.5), repeat(3, 0.5, 1.0, 3.2)];
        let found = at_onset(&trials, &parameters());
        let theta = course(&found, Signal::Theta);
        // the same movement, shifted by whole samples: no spread beyond the rounding of t − onset
        assert!(theta.band.sd.iter().all(|sd| sd.unwrap() < 1e-12));
        assert_eq!(found.n, vec![3; parameters().analysis.grid_points]);
        let onsets: Vec<f64> = found.repeats.iter().map(|r| r.onset_s).collect();
        assert!((onsets[1] - onsets[0] - 0.5).abs() < 1e-12);
    }

    /// Three repeats scaled 0.9, 1.0, 1.1: mean 1, SD 0.1, half width t(0.975, 2) 0.1 / √3, of θ −
    /// rest.
    #[test]
    fn mean_sd_and_band_are_those_of_the_repeats_at_each_time() {
        let trials = [repeat(1, 0.3, 0.9, 3.0), repeat(2, 0.3, 1.0, 3.0), repeat(3, 0.3, 1.1, 3.0)];
        let mut parameters = parameters();
        parameters.analysis.onset_rad_s = 1e-9; // all three begin at the same sample
        let found = at_onset(&trials, &parameters);
        let force = course(&found, Signal::ForceEx);
        let middle = at_onset(&trials[1..2], &parameters);
        let unit = &course(&middle, Signal::ForceEx).band.mean;
        let half = 4.30265273 * 0.1 / 3_f64.sqrt(); // scipy.stats.t.ppf(0.975, 2) to nine digits
        for (i, unit) in unit.iter().enumerate() {
            let u = unit.unwrap();
            assert!((force.band.mean[i].unwrap() - u).abs() < 1e-12);
            assert!((force.band.sd[i].unwrap() - 0.1 * u.abs()).abs() < 1e-12);
            assert!((force.band.ci_high[i].unwrap() - u - half * u.abs()).abs() < 1e-11);
        }
    }

    #[test]
    fn the_average_ends_where_fewer_than_half_remain_and_says_so() {
        let lengths = [3.0, 3.5, 4.0, 2.9, 2.8];
        let trials: Vec<_> = (1..).zip(lengths).map(|(i, s)| repeat(i, 0.3, 1.0, s)).collect();
        let found = at_onset(&trials, &parameters());
        let third_longest = found.repeats[0].length_s;
        assert_eq!(found.t_s.last(), Some(&third_longest));
        assert_eq!((found.n[0], found.n.last()), (5, Some(&3)));
        begins_with_note(&found, "fewer than half of the 5 repeats");
        // of five repeats the mean loses the two shortest on its way
        assert_eq!(found.drops().iter().map(|d| d.1).collect::<Vec<_>>(), [4, 3]);
        begins_with_note(&found, "number of repeats falls: to 4 at 2.4");
        let even = at_onset(&[repeat(1, 0.3, 1.0, 3.0)], &parameters());
        assert!(even.notes().is_empty());
    }

    #[test]
    fn repeats_that_drop_out_are_told_also_where_the_longest_one_stays() {
        let found = at_onset(&[repeat(1, 0.3, 1.0, 3.0), repeat(2, 0.3, 1.0, 3.5)], &parameters());
        let (t, n) = found.drops()[0];
        assert_eq!((found.drops().len(), n), (1, 1));
        assert!((t - found.repeats[0].length_s).abs() < 3.5 / 400.0);
        begins_with_note(&found, "no repeat lasts longer");
    }

    /// There in 1.0, 1.4 and 1.2 s, back in 0.8, 1.2 and 1.6 s: three warps of one raised cosine,
    /// so that aligned by landmarks it comes out as itself, there in 1.2 s and back in 1.2 s.
    #[test]
    fn landmarks_keep_what_an_average_at_onset_smears() {
        let trials =
            [there_and_back(1, 1.0, 0.8), there_and_back(2, 1.4, 1.2), there_and_back(3, 1.2, 1.6)];
        let mut parameters = parameters();
        (parameters.analysis.onset_rad_s, parameters.analysis.offset_rad_s) = (1e-9, 1e-10);
        let spring = parameters.scene.spring().unwrap();
        parameters.scene = Scene::SpringWall { spring, wall_rad: 0.5 };
        let found = average(&trials, &parameters, Alignment::Landmarks).unwrap();
        let names: Vec<_> = found.landmarks.iter().map(|l| l.0).collect();
        assert_eq!(names, Landmark::ALL);
        for ((_, t), expect) in found.landmarks.iter().zip([0.0, 0.6, 1.2, 1.201, 2.4]) {
            assert!((t - expect).abs() < 2e-3, "{t} {expect}");
        }
        let theta = course(&found, Signal::Theta);
        for (t, mean) in found.t_s.iter().zip(&theta.band.mean) {
            let expect = (1.0 - libm::cos(core::f64::consts::PI * t.min(2.4) / 1.2)) / 2.0;
            assert!((mean.unwrap() - expect).abs() < 2e-3, "{mean:?} against {expect} at {t}");
        }
        assert!(theta.band.sd.iter().all(|sd| sd.unwrap() < 2e-3));
        let peak = |a: &Average| {
            course(a, Signal::Theta).band.mean.iter().flatten().copied().fold(0.0, f64::max)
        };
        assert!(peak(&found) > 0.999 && peak(&at_onset(&trials, &parameters)) < 0.97);
        let notes = found.notes();
        assert!(notes.iter().any(|(_, note)| note.contains("wall contact 0.599 s")), "{notes:?}");
    }

    #[test]
    fn a_landmark_that_one_repeat_misses_is_none_and_a_missing_end_leaves_the_repeat_out() {
        let mut trials = vec![repeat(1, 0.3, 1.0, 3.0), repeat(2, 0.3, 0.4, 3.0)];
        let mut parameters = parameters();
        let spring = parameters.scene.spring().unwrap();
        parameters.scene = Scene::SpringWall { spring, wall_rad: 0.5 };
        let landmarks =
            |trials: &[Trial]| average(trials, &parameters, Alignment::Landmarks).unwrap();
        let names: Vec<_> = landmarks(&trials).landmarks.iter().map(|l| l.0).collect();
        assert_eq!(names, [Landmark::Start, Landmark::Reversal, Landmark::Return, Landmark::End]);
        trials.push(repeat(3, 0.3, 1.0, 1.8));
        let found = landmarks(&trials);
        assert_eq!(found.left_out, [LeftOut { trial: 3, why: WhyNot::NoEnd }]);
        assert_eq!(at_onset(&trials, &parameters).n[0], 3);
    }

    #[test]
    fn one_repeat_has_a_mean_and_no_band() {
        let found = at_onset(&[repeat(1, 0.3, 1.0, 3.0)], &parameters());
        let theta = course(&found, Signal::Theta);
        assert!(theta.band.mean.iter().all(Option::is_some));
        assert!(theta.band.sd.iter().chain(&theta.band.ci_low).all(Option::is_none));
    }

    #[test]
    fn a_quantity_that_one_repeat_lacks_is_left_out() {
        let mut trials = [repeat(1, 0.3, 1.0, 3.0), repeat(2, 0.3, 1.0, 3.0)];
        let samples = trials[0].samples.len();
        trials[0].samples.set(Signal::ForceCmd, vec![0.0; samples]);
        let found = at_onset(&trials, &parameters());
        let signals: Vec<_> = found.courses.iter().map(|c| c.signal).collect();
        assert_eq!(signals, [Signal::Theta, Signal::ThetaDot, Signal::ForceEx]);
    }

    #[test]
    fn a_repeat_without_movement_is_left_out_and_named() {
        let trials = [repeat(1, 0.3, 1.0, 3.0), repeat(2, 0.3, 0.0, 3.0)];
        let found = at_onset(&trials, &parameters());
        assert_eq!(found.left_out, [LeftOut { trial: 2, why: WhyNot::NoMovement }]);
        assert_eq!(found.n[0], 1);
        begins_with_note(&found, "trial 2 is not averaged");
    }

    fn check_reason(change: impl FnOnce(&mut Trial, &mut Parameters), expect: AverageError) {
        let (mut trial, mut parameters) = (repeat(1, 0.3, 1.0, 3.0), parameters());
        change(&mut trial, &mut parameters);
        assert_eq!(average(&[trial], &parameters, Alignment::Onset), Err(expect));
    }

    fn keep(trial: &mut Trial, signals: &[Signal]) {
        let mut samples = zwidth_store::Samples::default();
        for &signal in signals {
            samples.set(signal, trial.samples.get(signal).unwrap().to_vec());
        }
        trial.samples = samples;
    }

    #[test]
    fn where_there_is_no_average_there_is_a_reason() {
        check_reason(|_, s| s.scene = Scene::Free, WhyNot::FreeMotion.into());
        check_reason(|_, s| s.scene = Scene::None, WhyNot::NothingRendered.into());
        check_reason(|t, _| keep(t, &[Signal::Time, Signal::ThetaDot]), WhyNot::NoAngle.into());
        check_reason(|t, _| keep(t, &[Signal::Time, Signal::Theta]), WhyNot::NoVelocity.into());
        check_reason(|_, s| s.analysis.onset_rad_s = 1e9, WhyNot::NoMovement.into());
        assert!(WhyNot::NoAngle.to_string().starts_with("no angle was recorded"));
    }

    #[test]
    fn requests_that_make_no_sense_are_refused() {
        assert_eq!(
            average::<Trial>(&[], &parameters(), Alignment::Onset),
            Err(AverageError::Empty)
        );
        let mut other = repeat(2, 0.3, 1.0, 3.0);
        other.meta.session = SessionId::new("S02").unwrap();
        let mixed = average(&[repeat(1, 0.3, 1.0, 3.0), other], &parameters(), Alignment::Onset);
        assert_eq!(mixed, Err(AverageError::Mixed { trial: 2 }));
        check_reason(|_, s| s.analysis.grid_points = 1, AverageError::Grid { points: 1 });
        let found = (3.0 * RATE_HZ) as usize + 1;
        let ragged = AverageError::Ragged {
            trial: 1,
            column: "force_ex_n".to_owned(),
            expected: found,
            found: 1,
        };
        check_reason(|t, _| t.samples.set(Signal::ForceEx, vec![0.0]), ragged);
    }
}
