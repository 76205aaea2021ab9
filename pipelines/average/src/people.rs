//! The mean of force against position over participants.

use crate::AverageError;
use crate::loops::{Course, LOADS, branches};
use crate::table::{angles, column_name, loads, of_loop};
use std::collections::BTreeMap;
use zwidth_results::{LoopBranch as Branch, LoopPoint, ParticipantsLoopPoint, Row as _};
use zwidth_study::ParticipantId;
use zwidth_tables::{Table, TableError};

/// The columns that [`SessionLoop::of`] reads.
pub fn looked_at() -> Vec<String> {
    let means = LOADS.into_iter().map(|signal| column_name(signal, "mean"));
    LoopPoint::fields().into_iter().map(|field| field.name.into_owned()).chain(means).collect()
}

/// A participant's mean loop in a session.
#[derive(Debug, Clone)]
pub struct SessionLoop {
    participant: ParticipantId,
    courses: BTreeMap<Branch, Course>,
}

impl SessionLoop {
    /// Reads the loop of a table of this stage; `None` without a loop.
    ///
    /// # Errors
    /// A table that is not of this stage.
    pub fn of(table: &Table) -> Result<Option<Self>, TableError> {
        let points: Vec<LoopPoint> = table.to_rows()?;
        let Some(LoopPoint { participant, .. }) = points.first().cloned() else {
            return Ok(None);
        };
        let mut courses = BTreeMap::new();
        for branch in Branch::ALL.iter().copied() {
            let mut rows: Vec<usize> =
                (0..points.len()).filter(|row| points[*row].branch == branch).collect();
            // Rows come in the order of the movement, courses in that of the angle.
            if branch == Branch::Out {
                rows.reverse();
            }
            if rows.is_empty() {
                continue;
            }
            let mut loads = Vec::new();
            for signal in LOADS {
                let values = table.floats(&column_name(signal, "mean"))?;
                let values: Option<Vec<f64>> = rows.iter().map(|row| values[*row]).collect();
                loads.extend(values.map(|values| (signal, values)));
            }
            let theta_rad = rows.iter().map(|row| points[*row].theta_rad).collect();
            courses.insert(branch, Course { theta_rad, loads });
        }
        Ok(Some(Self { participant, courses }))
    }
}

/// The mean over participants of one condition's loops, of one per participant and session, in any
/// number and order. Each branch is averaged at the angles that everybody covers in every session: a
/// participant's sessions with equal weight, then participants, with Student's t band at `level`. A
/// branch that somebody lacks is left out. `None` for fewer than two participants with a loop.
///
/// # Errors
/// A level outside (0, 1).
pub fn over_participants(
    loops: impl IntoIterator<Item = SessionLoop>,
    level: f64,
) -> Result<Option<Table>, AverageError> {
    let mut people: BTreeMap<ParticipantId, Vec<BTreeMap<Branch, Course>>> = BTreeMap::new();
    for SessionLoop { participant, courses } in loops {
        people.entry(participant).or_default().push(courses);
    }
    if people.len() < 2 {
        return Ok(None);
    }
    let sessions: usize = people.values().map(Vec::len).sum();
    let all = [Branch::In, Branch::Held, Branch::Out].map(|branch| {
        let courses = people.values().flatten().map(|courses| courses.get(&branch).cloned());
        courses.collect::<Option<Vec<Course>>>().unwrap_or_default()
    });
    // At the angles of all sessions; then each participant's sessions are one.
    let counts: Vec<usize> = people.values().map(Vec::len).collect();
    let mut means = Vec::new();
    for branch in branches([&all[0], &all[1], &all[2]], level)? {
        means.push(branch.of_groups(&all[branch.branch as usize], &counts, level)?);
    }
    let n = people.len();
    let points: Vec<ParticipantsLoopPoint> = angles(&means)
        .map(|(branch, theta_rad)| ParticipantsLoopPoint { n, sessions, branch, theta_rad })
        .collect();
    let table = of_loop(&points, loads(&means, "participants"))?;
    Ok(Some(table.with_note(
        "n counts participants: each one's repeats are averaged, then their sessions with equal weight, at each angle that \
         all of them reach on the same way.",
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{parameters, repeat};
    use crate::{loop_table, mean_loop};
    use zwidth_store::{Signal, Trial};

    /// The loop of one trial of a participant, in a table of its own.
    fn of(who: &str, mut trial: Trial) -> Table {
        trial.meta.participant = who.parse().unwrap();
        loop_table(&mean_loop(&[trial], &parameters()).unwrap()).unwrap()
    }

    /// That of a stroke so far into a spring of 4 N/rad, with so much more force.
    fn stroke(who: &str, stroke_rad: f64, more_n: f64) -> Table {
        let mut trial = repeat(1, 0.3, stroke_rad, 3.0);
        let force =
            trial.samples.get(Signal::ForceEx).unwrap().iter().map(|f| f + more_n).collect();
        trial.samples.set(Signal::ForceEx, force);
        of(who, trial)
    }

    fn loops(tables: &[Table]) -> Vec<SessionLoop> {
        tables.iter().filter_map(|table| SessionLoop::of(table).unwrap()).collect()
    }

    #[test]
    fn people_meet_at_their_angles_and_the_mean_ends_where_one_of_them_does() {
        let people = [stroke("P01", 0.4, 0.0), stroke("P02", 0.8, 1.0)];
        let all = over_participants(loops(&people), 0.95).unwrap().unwrap();
        let points: Vec<ParticipantsLoopPoint> = all.to_rows().unwrap();
        let farthest = points.iter().map(|point| point.theta_rad).fold(0.0, f64::max);
        assert!((farthest - 0.4).abs() < 1e-6, "{farthest}");
        let force = all.floats(&column_name(Signal::ForceEx, "mean")).unwrap();
        for (point, force) in points.iter().zip(&force) {
            // On the spring, and half a newton more; held at the turn of each.
            let expect = match point.branch {
                Branch::Held => 4.0 * 0.6 + 0.5,
                _ => 4.0 * point.theta_rad + 0.5,
            };
            assert!((force.unwrap() - expect).abs() < 1e-2, "{point:?} {force:?}");
        }
        assert!(points.iter().all(|point| point.n == 2));
    }

    #[test]
    fn sessions_of_one_participant_count_once_and_one_participant_is_nobody_else() {
        let (a, b, c) = (stroke("P01", 0.8, 0.0), stroke("P01", 0.8, 1.0), stroke("P02", 0.8, 3.0));
        assert!(over_participants(loops(&[a.clone(), b.clone()]), 0.95).unwrap().is_none());
        let all = over_participants(loops(&[a, b, c]), 0.95).unwrap().unwrap();
        let points: Vec<ParticipantsLoopPoint> = all.to_rows().unwrap();
        assert_eq!(points[0].sessions, 3);
        let force = all.floats(&column_name(Signal::ForceEx, "mean")).unwrap()[50];
        let expect = 4.0 * points[50].theta_rad + (0.5 + 3.0) / 2.0;
        assert!((force.unwrap() - expect).abs() < 1e-3, "{force:?} against {expect}");
    }

    #[test]
    fn without_a_loop_nobody_is_in_it() {
        let none = crate::no_loop(&crate::WhyNot::NoVelocity).unwrap();
        assert!(
            over_participants(loops(&[none, stroke("P01", 1.0, 0.0)]), 0.95).unwrap().is_none()
        );
        assert!(over_participants([], 0.95).unwrap().is_none());
    }
}
