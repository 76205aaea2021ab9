//! The mean of force against position, by branch at the angle.
//!
//! If repeats turn or let go at different angles, a mean of force at equal phases of the movement,
//! drawn at their mean angle, passes through pairs of force and angle that occur in no repeat. At
//! one angle the mean of the forces lies between those of the repeats.

use crate::average::{Parameters, Placed, place, source_of};
use crate::{AverageError, LeftOut};
use zwidth_numerics::series::{common_grid, interpolate_all};
use zwidth_results::LoopBranch as Branch;
use zwidth_stats::band::{Band, band};
use zwidth_store::{Recorded, Signal};
use zwidth_study::{Alignment, Condition, ParticipantId, SessionId, Source};

/// Angles at which a branch is averaged.
pub(crate) const NODES: usize = 101;

/// The signals that are averaged at each angle.
pub(crate) const LOADS: [Signal; 4] =
    [Signal::ForceEx, Signal::TorqueEx, Signal::ForceCmd, Signal::ThetaDot];

/// One branch of a mean loop.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanBranch {
    /// The branch.
    pub branch: Branch,
    /// The angles, in the order of the movement, rad.
    pub theta_rad: Vec<f64>,
    /// Mean, SD and band at each of them, of each load that all have.
    pub loads: Vec<(Signal, Band)>,
}

/// The mean of force against position of one condition's repeats by one participant in one session.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanLoop {
    /// The participant.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The condition.
    pub condition: Condition,
    /// The source of the numbers: simulated if any repeat is, else that of the first.
    pub source: Source,
    /// Number of repeats averaged, at every angle.
    pub n: usize,
    /// Number of them that return.
    pub returning: usize,
    /// The repeats that are left out.
    pub left_out: Vec<LeftOut>,
    /// The branches that all repeats have.
    pub branches: Vec<MeanBranch>,
}

/// One repeat's, session's or person's course of a branch: angles that rise, and each load there.
#[derive(Debug, Clone, Default)]
pub(crate) struct Course {
    pub(crate) theta_rad: Vec<f64>,
    pub(crate) loads: Vec<(Signal, Vec<f64>)>,
}

impl Course {
    fn load(&self, signal: Signal) -> Option<&[f64]> {
        self.loads.iter().find(|(load, _)| *load == signal).map(|(_, values)| values.as_slice())
    }
}

impl MeanBranch {
    /// The same branch averaged over groups of courses, `counts` of which follow each other: within
    /// a group the plain mean, then mean and band over groups.
    pub(crate) fn of_groups(
        &self,
        courses: &[Course],
        counts: &[usize],
        level: f64,
    ) -> Result<Self, AverageError> {
        let mut angles = self.theta_rad.clone();
        if self.branch == Branch::Out {
            angles.reverse();
        }
        let on_grid = match self.branch {
            Branch::Held => courses.to_vec(), // no angles: the same two points in each
            _ => at(courses, &angles),
        };
        let mut rest = on_grid.as_slice();
        let mut groups = Vec::new();
        for count in counts {
            let (group, others) = rest.split_at(*count);
            let mut loads = Vec::new();
            for signal in LOADS {
                // A load that one of the courses lacks has no mean.
                let all: Option<Vec<&[f64]>> = group.iter().map(|c| c.load(signal)).collect();
                let all = all.unwrap_or_default();
                let Some(first) = all.first() else { continue };
                let means = (0..first.len())
                    .map(|i| all.iter().map(|v| v[i]).sum::<f64>() / all.len() as f64);
                loads.push((signal, means.collect()));
            }
            groups.push(Course { theta_rad: angles.clone(), loads });
            rest = others;
        }
        mean(self.branch, angles, &groups, level).map(Self::in_order)
    }

    /// In the order of the movement.
    fn in_order(mut self) -> Self {
        if self.branch == Branch::Out {
            self.theta_rad.reverse();
            for (_, Band { n, mean, sd, ci_low, ci_high }) in &mut self.loads {
                n.reverse();
                [mean, sd, ci_low, ci_high].into_iter().for_each(|values| values.reverse());
            }
        }
        self
    }
}

/// The mean loop of `trials`, the repeats of one condition by one participant in one session.
///
/// # Errors
/// Those of [`average`](crate::average()).
pub fn mean_loop<'a, T>(trials: &'a [T], parameters: &Parameters) -> Result<MeanLoop, AverageError>
where
    &'a T: Into<Recorded<'a>>,
{
    let trials: Vec<Recorded> = trials.iter().map(Into::into).collect();
    let first = trials.first().ok_or(AverageError::Empty)?;
    let Placed { aligned, left_out, .. } = place(&trials, parameters, Alignment::Onset)?;
    let mut ways_in = Vec::new();
    let mut held = Vec::new();
    let mut ways_out = Vec::new();
    for repeat in &aligned {
        let Some(theta) = repeat.column(Signal::Theta) else { continue };
        let (phases, returns) = repeat.phases;
        let forth = farther(&theta, phases.onset..=phases.reversal, 1.0);
        let back = returns.map(|returns| {
            let mut rows = farther(&theta, returns..=phases.end, -1.0);
            // Angles of a course rise, and on the way back they fall.
            rows.reverse();
            rows
        });
        let last = returns.unwrap_or(theta.len() - 1);
        let mut way_in = Course { theta_rad: at_rows(&theta, &forth), loads: Vec::new() };
        let mut turn = Course::default();
        let mut way_out = back
            .as_deref()
            .map(|back| Course { theta_rad: at_rows(&theta, back), loads: Vec::new() });
        for signal in LOADS {
            let Some(load) = repeat.column(signal) else { continue };
            way_in.loads.push((signal, at_rows(&load, &forth)));
            // While the lever is held its angle stays and its force falls: the branch is the two
            // ends of a vertical line. Its velocity is none.
            if signal != Signal::ThetaDot {
                let (low, high) = zwidth_numerics::series::ends(&load[phases.reversal..=last]);
                turn.loads.push((signal, vec![high, low]));
            }
            if let (Some(way_out), Some(back)) = (&mut way_out, &back) {
                way_out.loads.push((signal, at_rows(&load, back)));
            }
        }
        ways_in.push(way_in);
        held.push(turn);
        ways_out.extend(way_out);
    }
    let level = parameters.analysis.confidence;
    // A mean of those that return alone would be of other repeats than the way in.
    let returning = ways_out.len();
    let n = ways_in.len();
    let out = if returning == n { ways_out.as_slice() } else { &[] };
    Ok(MeanLoop {
        participant: first.meta.participant.clone(),
        session: first.meta.session.clone(),
        condition: first.meta.condition(),
        source: source_of(&trials),
        n,
        returning,
        left_out,
        branches: branches([&ways_in, &held, out], level)?,
    })
}

/// The mean of courses by branch: each over the angles that all of them cover.
pub(crate) fn branches(
    [ways_in, held, ways_out]: [&[Course]; 3],
    level: f64,
) -> Result<Vec<MeanBranch>, AverageError> {
    let mut branches = Vec::new();
    if let Some(angles) = shared(ways_in) {
        let turn = angles[NODES - 1];
        branches.push(mean(Branch::In, angles.clone(), &at(ways_in, &angles), level)?);
        branches.push(mean(Branch::Held, vec![turn; 2], held, level)?);
    }
    if let Some(angles) = shared(ways_out) {
        let out = mean(Branch::Out, angles.clone(), &at(ways_out, &angles), level)?;
        branches.push(out.in_order());
    }
    Ok(branches)
}

/// Even angles over all that every course covers, rising; `None` if that is nothing.
fn shared(courses: &[Course]) -> Option<Vec<f64>> {
    common_grid(courses.iter().map(|course| course.theta_rad.as_slice()), NODES)
}

/// The courses at these angles.
fn at(courses: &[Course], angles: &[f64]) -> Vec<Course> {
    let mut on_grid = Vec::new();
    for course in courses {
        let mut loads = Vec::new();
        for (signal, values) in &course.loads {
            let values = interpolate_all(&course.theta_rad, values, angles);
            loads.push((*signal, values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()));
        }
        on_grid.push(Course { theta_rad: angles.to_vec(), loads });
    }
    on_grid
}

fn mean(
    branch: Branch,
    theta_rad: Vec<f64>,
    courses: &[Course],
    level: f64,
) -> Result<MeanBranch, AverageError> {
    let mut loads = Vec::new();
    for signal in LOADS {
        let rows: Option<Vec<Vec<Option<f64>>>> = courses
            .iter()
            .map(|course| Some(course.load(signal)?.iter().copied().map(Some).collect()))
            .collect();
        if let Some(rows) = rows.filter(|rows| !rows.is_empty()) {
            loads.push((signal, band(&rows, level)?));
        }
    }
    Ok(MeanBranch { branch, theta_rad, loads })
}

fn at_rows(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|row| values[*row]).collect()
}

/// The samples that are farther along than all before, in their order.
fn farther(theta: &[f64], rows: std::ops::RangeInclusive<usize>, sign: f64) -> Vec<usize> {
    let mut farthest = f64::NEG_INFINITY;
    rows.filter(|row| {
        let is_farther = sign * theta[*row] > farthest;
        farthest = farthest.max(sign * theta[*row]);
        is_farther
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{parameters, repeat};
    use proptest::prelude::*;
    use zwidth_store::Trial;

    /// A stroke into a spring, at whose end a brake holds: the force falls while the lever stands, and
    /// the way back begins at another force.
    fn held(number: u32, stroke_rad: f64, stiffness: f64, share: f64) -> Trial {
        let mut trial = repeat(number, 0.3, stroke_rad, 3.0);
        let theta = trial.samples.get(Signal::Theta).unwrap().to_vec();
        let turn = theta.iter().position(|x| *x >= stroke_rad * (1.0 - 1e-9)).unwrap();
        let force =
            (0..theta.len()).map(|i| stiffness * theta[i] * if i > turn { share } else { 1.0 });
        trial.samples.set(Signal::ForceEx, force.collect());
        trial
    }

    fn branch(of: &MeanLoop, which: Branch) -> &MeanBranch {
        of.branches.iter().find(|b| b.branch == which).unwrap()
    }

    #[test]
    fn each_branch_ends_where_the_first_repeat_does_and_its_mean_is_theirs_at_the_angle() {
        let trials = [held(1, 0.5, 4.0, 0.5), held(2, 0.8, 6.0, 0.25)];
        let found = mean_loop(&trials, &parameters()).unwrap();
        let [way_in, out] = [Branch::In, Branch::Out].map(|which| branch(&found, which));
        assert!((way_in.theta_rad[NODES - 1] - 0.5).abs() < 1e-6);
        assert!((out.theta_rad[0] - 0.5).abs() < 5e-3, "{}", out.theta_rad[0]);
        let at = |of: &MeanBranch, i: usize| (of.theta_rad[i], of.loads[0].1.mean[i].unwrap());
        for i in [10, 50, 90] {
            let ((x, f), (y, g)) = (at(way_in, i), at(out, i));
            assert!((f - 5.0 * x).abs() < 1e-4 && (g - (2.0 + 1.5) / 2.0 * y).abs() < 1e-4);
        }
        let turn = branch(&found, Branch::Held);
        assert_eq!(turn.theta_rad, [way_in.theta_rad[NODES - 1]; 2]);
        let [largest, smallest] = [0, 1].map(|i| turn.loads[0].1.mean[i].unwrap());
        assert!((largest - (2.0 + 4.8) / 2.0).abs() < 1e-3, "{largest}");
        assert!(smallest < (1.0 + 1.2) / 2.0 + 1e-3, "{smallest}");
    }

    #[test]
    fn a_lever_that_is_held_has_no_way_back_and_its_force_goes_to_what_is_left() {
        let mut trial = held(1, 0.5, 4.0, 0.0);
        let theta = trial.samples.get(Signal::Theta).unwrap();
        let turn = theta.iter().position(|x| *x >= 0.5 * (1.0 - 1e-9)).unwrap();
        let stays = |signal: Signal, at: f64| {
            let values = trial.samples.get(signal).unwrap().iter().enumerate();
            values.map(|(i, v)| if i > turn { at } else { *v }).collect::<Vec<f64>>()
        };
        let (theta, velocity) = (stays(Signal::Theta, 0.5), stays(Signal::ThetaDot, 0.0));
        trial.samples.set(Signal::Theta, theta);
        trial.samples.set(Signal::ThetaDot, velocity);
        let found = mean_loop(&[trial, held(2, 0.5, 4.0, 0.5)], &parameters()).unwrap();
        assert_eq!((found.n, found.returning), (2, 1));
        assert!(found.branches.iter().all(|b| b.branch != Branch::Out), "one does not return");
        let smallest = branch(&found, Branch::Held).loads[0].1.mean[1].unwrap();
        assert!(smallest < 0.6, "{smallest}");
    }

    /// Six repeats that turn at 30.3° to 31.8°, stand there for 0.5 to 1.1 s and let go to 1.3 to 1.45 N: the means at 10° and
    /// 30° by definition, in degrees and newtons. A mean at equal phases has 2.5 N at 30.3° on the way back.
    #[test]
    fn repeats_that_turn_elsewhere_have_the_means_of_their_forces_at_the_angle() {
        let s = |x: f64| x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
        let slope = |x: f64| 30.0 * x * x * (1.0 - x) * (1.0 - x);
        let trials: Vec<Trial> = (1..=6)
            .map(|number| {
                let i = f64::from(number);
                let (top, held_s) = ((30.0 + 0.3 * i).to_radians(), 0.4 + 0.12 * i);
                let t: Vec<f64> =
                    (0..=((2.0 + held_s) * 100.0) as u32).map(|k| f64::from(k) / 100.0).collect();
                let back = |t: f64| (t - 1.0 - held_s).clamp(0.0, 1.0);
                let theta = |t: f64| top * (s(t.min(1.0)) - s(back(t)));
                let velocity = |t: f64| top * (slope(t.min(1.0)) - slope(back(t)));
                let force = |t: f64| match back(t) > 0.0 {
                    false => 0.16 * theta(t).to_degrees(),
                    true => (1.3 + 0.025 * i) * theta(t) / top,
                };
                let mut trial = repeat(number, 0.0, 1.0, 1.0);
                trial.samples.set(Signal::Theta, t.iter().copied().map(theta).collect());
                trial.samples.set(Signal::ThetaDot, t.iter().copied().map(velocity).collect());
                trial.samples.set(Signal::ForceEx, t.iter().copied().map(force).collect());
                trial.samples.set(Signal::Time, t);
                trial
            })
            .collect();
        let found = mean_loop(&trials, &parameters()).unwrap();
        let at = |which: Branch, degrees: f64| {
            let branch = branch(&found, which);
            let mut course: Vec<(f64, f64)> = branch
                .theta_rad
                .iter()
                .copied()
                .zip(branch.loads[0].1.mean.iter().flatten().copied())
                .collect();
            course.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y): (Vec<f64>, Vec<f64>) = course.into_iter().unzip();
            zwidth_numerics::series::interpolate(&x, &y, degrees.to_radians()).unwrap()
        };
        let turn = branch(&found, Branch::In).theta_rad[NODES - 1].to_degrees();
        assert!((turn - 30.3).abs() < 1e-3, "{turn}");
        let expected =
            [(Branch::In, 30.0, 4.8), (Branch::Out, 30.0, 1.340264), (Branch::Out, 10.0, 0.446755)];
        for (which, degrees, mean) in expected {
            let found = at(which, degrees);
            assert!((found - mean).abs() < 1e-3, "{which:?} {degrees}: {found}");
        }
    }

    proptest! {
        /// A mean lies within the least and the largest of what it is a mean of, at every angle.
        #[test]
        fn a_mean_lies_between_its_repeats(
            strokes in prop::collection::vec((0.2_f64..1.2, 1.0_f64..9.0, 0.0_f64..1.0), 1..5),
        ) {
            let trials: Vec<Trial> = (1..)
                .zip(&strokes)
                .map(|(n, (stroke, stiffness, share))| held(n, *stroke, *stiffness, *share))
                .collect();
            let all = mean_loop(&trials, &parameters()).unwrap();
            for of_all in &all.branches {
                let mut angles = of_all.theta_rad.clone();
                if of_all.branch == Branch::Out {
                    angles.reverse();
                }
                let alone = |trial: &Trial| {
                    let one = mean_loop(std::slice::from_ref(trial), &parameters()).unwrap();
                    one.branches.into_iter().find(|b| b.branch == of_all.branch).unwrap()
                };
                let ones: Vec<MeanBranch> = trials.iter().map(alone).collect();
                let mean = of_all.loads[0].1.mean.iter().flatten();
                for (i, mean) in mean.enumerate() {
                    // Each repeat alone on its own nodes: a chord of them is off by so much.
                    let at = |one: &MeanBranch| {
                        if of_all.branch == Branch::Held {
                            return one.loads[0].1.mean[i].unwrap();
                        }
                        let mut course: Vec<(f64, f64)> = one.theta_rad.iter().copied()
                            .zip(one.loads[0].1.mean.iter().flatten().copied()).collect();
                        course.sort_by(|a, b| a.0.total_cmp(&b.0));
                        let (x, y): (Vec<f64>, Vec<f64>) = course.into_iter().unzip();
                        zwidth_numerics::series::interpolate(&x, &y, of_all.theta_rad[i]).unwrap()
                    };
                    let values: Vec<f64> = ones.iter().map(at).collect();
                    let (low, high) = zwidth_numerics::series::ends(&values);
                    prop_assert!(low - 1e-4 <= *mean && *mean <= high + 1e-4, "{mean} {values:?}");
                }
            }
        }
    }
}
