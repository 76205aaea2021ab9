//! The mean course over participants.

use crate::AverageError;
use crate::average::SIGNALS;
use crate::table::{PARTS, PHASE, column_name, renamed};
use std::collections::BTreeMap;
use zwidth_numerics::series::interpolate_all;
use zwidth_stats::band::{Band, band};
use zwidth_store::Signal;
use zwidth_tables::{Column, Table, TableError};

/// Points of the grid of phases.
const POINTS: usize = 301;
/// The phase at which a movement ends ([`Average::phase`](crate::Average::phase)).
const LAST_PHASE: f64 = 3.0;

/// A course on the grid of phases, signal by signal.
type OnGrid = BTreeMap<Signal, Vec<f64>>;

/// The columns at which [`SessionCourse::of`] looks.
pub fn looked_at() -> Vec<String> {
    let means = SIGNALS.into_iter().map(|signal| column_name(signal, "mean"));
    ["participant", "phase"].into_iter().map(str::to_owned).chain(means).collect()
}

/// A participant's mean course in a session.
#[derive(Debug, Clone)]
pub struct SessionCourse {
    participant: String,
    on_grid: OnGrid,
}

impl SessionCourse {
    /// That of a table of averages aligned by landmarks; `None` without an average.
    ///
    /// # Errors
    /// A table that is not of this stage.
    pub fn of(table: &Table) -> Result<Option<Self>, TableError> {
        let who = table.texts("participant")?.into_iter().flatten().next();
        let course = who.zip(on_grid(table, &phases())?);
        Ok(course.map(|(participant, on_grid)| Self { participant, on_grid }))
    }
}

fn phases() -> Vec<f64> {
    (0..POINTS).map(|i| LAST_PHASE * (i as f64 / (POINTS - 1) as f64)).collect()
}

/// The mean over participants of one condition, of one course per participant and session, in any
/// number and order. Each is taken at the same phases of the movement; a participant's sessions are
/// averaged with equal weight, and the band is over participants, Student's t at `level`. One row
/// per phase; a signal that some participant lacks is null. `None` for fewer than two participants
/// with such an average.
///
/// # Errors
/// A level outside (0, 1).
pub fn over_participants(
    sessions: impl IntoIterator<Item = SessionCourse>,
    level: f64,
) -> Result<Option<Table>, AverageError> {
    let mut people: BTreeMap<String, Vec<OnGrid>> = BTreeMap::new();
    for SessionCourse { participant, on_grid } in sessions {
        people.entry(participant).or_default().push(on_grid);
    }
    let phases = phases();
    if people.len() < 2 {
        return Ok(None);
    }
    let n = people.len() as i64;
    let mut columns = vec![
        Column::float("phase", "1", PHASE, phases.iter().copied().map(Some)),
        Column::integer("n", "1", "participants averaged", vec![Some(n); POINTS]),
    ];
    for signal in SIGNALS {
        let courses: Option<Vec<Vec<Option<f64>>>> =
            people.values().map(|sessions| mean(sessions, signal)).collect();
        let band = match courses {
            Some(courses) => band(&courses, level)?,
            None => nothing(),
        };
        for (part, meaning, values) in PARTS {
            let meaning = meaning.replace("repeats", "participants");
            let description = format!("{}: {meaning}", signal.column().description);
            columns.push(renamed(
                signal,
                column_name(signal, part),
                description,
                values(&band).to_vec(),
            ));
        }
    }
    let table =
        Table::new("participants_average", "Mean over participants against the phase", columns)?;
    Ok(Some(table.with_note(
        "n counts participants: each one's repeats are averaged by landmarks, then their sessions with equal weight.",
    )))
}

/// The mean course of a session on the grid; `None` without an average.
fn on_grid(table: &Table, phases: &[f64]) -> Result<Option<OnGrid>, TableError> {
    let at = table.floats("phase")?;
    let rows: Vec<usize> = (0..at.len()).filter(|row| at[*row].is_some()).collect();
    if rows.len() < 2 {
        return Ok(None);
    }
    let at: Vec<f64> = rows.iter().filter_map(|row| at[*row]).collect();
    let mut found = OnGrid::new();
    for signal in SIGNALS {
        let values = table.floats(&column_name(signal, "mean"))?;
        let Some(values) = rows.iter().map(|row| values[*row]).collect::<Option<Vec<f64>>>() else {
            continue;
        };
        // The grid of time seldom has a point at the very end.
        let last = values[values.len() - 1];
        let on_grid = interpolate_all(&at, &values, phases);
        found.insert(signal, on_grid.into_iter().map(|value| value.unwrap_or(last)).collect());
    }
    Ok(Some(found))
}

/// The mean of a participant's sessions; `None` if one of them lacks the signal.
fn mean(sessions: &[OnGrid], signal: Signal) -> Option<Vec<Option<f64>>> {
    let courses =
        sessions.iter().map(|session| session.get(&signal)).collect::<Option<Vec<_>>>()?;
    let at = |i: usize| courses.iter().map(|course| course[i]).sum::<f64>() / courses.len() as f64;
    Some((0..POINTS).map(|i| Some(at(i))).collect())
}

fn nothing() -> Band {
    let null = || vec![None; POINTS];
    Band { n: vec![0; POINTS], mean: null(), sd: null(), ci_low: null(), ci_high: null() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn courses(tables: &[Table]) -> Vec<SessionCourse> {
        tables.iter().filter_map(|table| SessionCourse::of(table).unwrap()).collect()
    }
    use crate::testing::{parameters, repeat, there_and_back};
    use crate::{Alignment, average, table};
    use zwidth_store::Trial;

    /// The average of one trial of a participant, in a table of its own.
    fn of(who: &str, mut trial: Trial) -> Table {
        trial.meta.participant = who.parse().unwrap();
        table(&[average(&[trial], &parameters(), Alignment::Landmarks).unwrap()]).unwrap()
    }

    /// That of a stroke so far into a spring of 4 N/rad.
    fn stroke(who: &str, stroke_rad: f64) -> Table {
        of(who, repeat(1, 0.3, stroke_rad, 3.0))
    }

    fn column(table: &Table, signal: Signal, part: &str) -> Vec<f64> {
        table.floats(&column_name(signal, part)).unwrap().into_iter().flatten().collect()
    }

    #[test]
    fn participants_meet_at_their_phases_whatever_their_speed() {
        let people =
            [of("P01", there_and_back(1, 0.8, 1.6)), of("P02", there_and_back(1, 1.5, 0.7))];
        let all = over_participants(courses(&people), 0.95).unwrap().unwrap();
        let theta = column(&all, Signal::Theta, "mean");
        assert_eq!(theta.len(), POINTS);
        // both turn at phase 2 and at 1 rad, and so does their mean
        let turn = (0..POINTS).fold(0, |best, i| if theta[i] > theta[best] { i } else { best });
        assert!(turn.abs_diff(2 * (POINTS - 1) / 3) <= 1, "{turn}");
        assert!((theta[turn] - 1.0).abs() < 1e-4, "{}", theta[turn]);
        assert!(column(&all, Signal::ForceEx, "mean").is_empty(), "nobody has a force");
    }

    #[test]
    fn sessions_of_one_participant_count_once_and_one_participant_is_nobody_else() {
        let (a, b, c) = (stroke("P01", 0.4), stroke("P01", 0.8), stroke("P02", 1.2));
        assert!(over_participants(courses(&[a.clone(), b.clone()]), 0.95).unwrap().is_none());
        let all =
            over_participants(courses(&[a.clone(), b.clone(), c.clone()]), 0.95).unwrap().unwrap();
        assert_eq!(all.integers("n").unwrap()[0], Some(2));
        let at = |table: &Table| on_grid(table, &[1.0]).unwrap().unwrap()[&Signal::ForceEx][0];
        let expect = ((at(&a) + at(&b)) / 2.0 + at(&c)) / 2.0;
        let found = column(&all, Signal::ForceEx, "mean")[(POINTS - 1) / 3];
        assert!((found - expect).abs() < 1e-9 * expect.abs().max(1.0), "{found} against {expect}");
    }

    #[test]
    fn without_an_average_nobody_is_in_it() {
        let none = crate::no_average(&crate::WhyNot::NoVelocity).unwrap();
        assert!(over_participants(courses(&[none, stroke("P01", 1.0)]), 0.95).unwrap().is_none());
        assert!(over_participants([], 0.95).unwrap().is_none());
    }
}
