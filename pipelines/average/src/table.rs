//! Averages as tables: SI units, one row per point of the grid.

use crate::WhyNot;
use crate::average::{Average, SIGNALS};
use crate::loops::{LOADS, MeanBranch, MeanLoop};
use crate::notes::not_averaged;
use zwidth_results::{AveragePoint, LoopBranch, LoopPoint, Row};
use zwidth_stats::band::Band;
use zwidth_store::Signal;
use zwidth_study::Condition;
use zwidth_tables::{Column, NoteKind, Table, TableError};

/// One row per point of time of each average: participant, session, environment, mode, source,
/// `alignment` (`onset` or `landmarks`), `t_s` since onset, `phase` by landmarks, `n` repeats, and mean, SD and band of
/// each signal (null where not every repeat has it). Notes say where an average ends and where
/// repeats drop out of it, its landmarks, and which trials are not in it.
///
/// # Errors
/// A number that is not finite.
pub fn table(averages: &[Average]) -> Result<Table, TableError> {
    let mut points = Vec::new();
    for a in averages {
        points.extend((0..a.t_s.len()).map(|i| AveragePoint {
            participant: a.participant.clone(),
            session: a.session.clone(),
            environment: a.condition.environment.clone(),
            mode: a.condition.mode.clone(),
            source: a.source,
            alignment: a.alignment,
            t_s: a.t_s[i],
            phase: a.phase(a.t_s[i]),
            n: a.n[i],
        }));
    }
    let mut columns = AveragePoint::columns(&points);
    columns.extend(bands(&SIGNALS, "repeats", averages, |average, signal| {
        let course = average.courses.iter().find(|course| course.signal == signal);
        (average.t_s.len(), course.map(|course| &course.band))
    }));
    let table = Table::new(AveragePoint::NAME, AveragePoint::TITLE, columns)?;
    let notes = averages.iter().flat_map(Average::notes);
    Ok(notes.fold(table, |table, (kind, note)| table.with_note_of(kind, note)))
}

/// One row per angle of each branch of a mean loop, in the order of the movement: participant, session,
/// environment, mode, source, `branch` (`in`, `held`, `out`), `theta_rad`, `n` repeats, and mean, SD and
/// band of each load there (null where not every repeat has it). Notes say which trials are not in
/// it, and which repeats do not return.
///
/// # Errors
/// A number that is not finite.
pub fn loop_table(mean: &MeanLoop) -> Result<Table, TableError> {
    let MeanLoop { participant, session, source, n, returning, .. } = mean;
    let Condition { environment, mode } = &mean.condition;
    let points: Vec<LoopPoint> = angles(&mean.branches)
        .map(|(branch, theta_rad)| LoopPoint {
            participant: participant.clone(),
            session: session.clone(),
            environment: environment.clone(),
            mode: mode.clone(),
            source: *source,
            n: *n,
            branch,
            theta_rad,
        })
        .collect();
    let table = of_loop(&points, loads(&mean.branches, "repeats"))?;
    let name = format!("{participant} {session} {environment} {mode}");
    let left_out = not_averaged(&name, &mean.left_out);
    let some_stay = (0 < *returning && returning < n)
        .then(|| format!("{name}: {returning} of {n} repeats return; their way back has no mean."));
    let notes = left_out.chain(some_stay);
    Ok(notes.fold(table, |table, note| table.with_note_of(NoteKind::General, note)))
}

/// Each branch with each of its angles, rad.
pub(crate) fn angles(branches: &[MeanBranch]) -> impl Iterator<Item = (LoopBranch, f64)> {
    branches.iter().flat_map(|b| b.theta_rad.iter().map(|theta_rad| (b.branch, *theta_rad)))
}

/// The columns of the loads, one row per angle of [`angles`].
pub(crate) fn loads(branches: &[MeanBranch], whose: &str) -> Vec<Column> {
    bands(&LOADS, whose, branches, |branch, signal| {
        let band = branch.loads.iter().find(|(load, _)| *load == signal);
        (branch.theta_rad.len(), band.map(|(_, band)| band))
    })
}

/// The four columns of each signal, averaged over `whose`: repeats, or participants. Each part has
/// as many rows as `band` says, and in them that band, or null.
fn bands<T>(
    signals: &[Signal],
    whose: &str,
    parts: &[T],
    band: impl Fn(&T, Signal) -> (usize, Option<&Band>),
) -> Vec<Column> {
    type Values = fn(&Band) -> &[Option<f64>];
    // What stands between stem and unit in a column's name, its meaning, its values.
    let statistics: [(&str, String, Values); 4] = [
        ("mean", format!("mean of the {whose}"), |b| &b.mean),
        ("sd", format!("standard deviation of the {whose}"), |b| &b.sd),
        ("ci_low", "lower end of the mean's pointwise t interval".to_owned(), |b| &b.ci_low),
        ("ci_high", "upper end of the mean's pointwise t interval".to_owned(), |b| &b.ci_high),
    ];
    let mut columns = Vec::new();
    for signal in signals {
        for (name, meaning, values) in &statistics {
            let mut column = Vec::new();
            for part in parts {
                let (rows, band) = band(part, *signal);
                let band = band.map(*values);
                column.extend((0..rows).map(|i| band?[i]));
            }
            // `Column::float` takes words that live as long as the program.
            let mut column = Column::float("", signal.column().unit, "", column);
            column.field.name = column_name(*signal, name).into();
            column.field.description = format!("{}: {meaning}", signal.column().description).into();
            columns.push(column);
        }
    }
    columns
}

/// Points of a loop with the loads there.
pub(crate) fn of_loop<R: Row>(points: &[R], loads: Vec<Column>) -> Result<Table, TableError> {
    Table::new(R::NAME, R::TITLE, R::columns(points).into_iter().chain(loads).collect())
}

/// The table of no loop, and why there is none.
///
/// # Errors
/// None: it has no number.
pub fn no_loop(why: &WhyNot) -> Result<Table, TableError> {
    let table = of_loop::<LoopPoint>(&[], loads(&[], "repeats"))?;
    Ok(table.with_note(sentence(&why.to_string())))
}

/// The table of no average, and why there is none.
///
/// # Errors
/// None: it has no number.
pub fn no_average(why: &WhyNot) -> Result<Table, TableError> {
    Ok(table(&[])?.with_note(sentence(&why.to_string())))
}

/// A reason as a sentence.
fn sentence(reason: &str) -> String {
    let mut letters = reason.chars();
    let first = letters.next().map(|c| c.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}.", letters.as_str().trim_end_matches('.'))
}

/// The name of a column of a signal: `theta_mean_rad`.
pub(crate) fn column_name(signal: Signal, part: &str) -> String {
    format!("{}_{part}_{}", signal.stem(), signal.suffix())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{parameters, repeat};
    use crate::{Alignment, average};

    fn averages() -> Vec<Average> {
        let trials = [repeat(1, 0.3, 0.9, 3.0), repeat(2, 0.3, 1.1, 3.1), repeat(3, 0.3, 1.0, 3.4)];
        let of = |trials, alignment| average(trials, &parameters(), alignment).unwrap();
        vec![of(&trials, Alignment::Onset), of(&trials[..1], Alignment::Landmarks)]
    }

    #[test]
    fn means_of_conditions_stand_below_each_other_with_their_notes() {
        let averages = averages();
        let table = table(&averages).unwrap();
        let points = parameters().analysis.grid_points;
        assert_eq!(table.height(), 2 * points);
        let mean = table.floats("theta_mean_rad").unwrap();
        assert_eq!(mean[..points], averages[0].courses[0].band.mean);
        assert!(table.floats("theta_ci_low_rad").unwrap()[points..].iter().all(Option::is_none));
        assert!(table.floats("force_cmd_mean_n").unwrap().iter().all(Option::is_none));
        assert_eq!(table.notes().len(), 2);
        let rows: Vec<AveragePoint> = table.to_rows().unwrap();
        assert_eq!(
            (rows[0].alignment, rows[points].alignment),
            (Alignment::Onset, Alignment::Landmarks)
        );
        let field = table.fields().find(|f| f.name == "theta_dot_sd_rad_s").unwrap();
        assert_eq!(field.unit, "rad/s");
    }
}
