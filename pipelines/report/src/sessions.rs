//! What the comparison of sessions says, in a sentence.

use crate::compared::{ComparedMetric, Role, floats, words};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_study::Setup;
use zwidth_tables::{Table, TableError, for_people, number, with_unit};

/// How participants changed from their first session to a later one, in the first of `metrics`: one
/// sentence, with interval and n of each condition. `sessions` is that metric's table of the stage
/// `compare`. Nothing is said where fewer than two participants came again: one changes for
/// themselves alone.
///
/// # Errors
/// A table that is not of the stage `compare`.
pub fn changes(
    study: &Setup,
    metrics: &[ComparedMetric],
    sessions: &Table,
) -> Result<Option<Finding>, TableError> {
    let Some(metric) = metrics.first() else { return Ok(None) };
    let table = for_people(sessions, study.coordinate)?;
    let unit = table.column_of("change")?.field.unit.to_string();
    let (environments, modes) = (table.texts("environment")?, table.texts("mode")?);
    let (pairs, n) = (table.texts("sessions")?, table.integers("n")?);
    let of = |stem| floats(&table, stem);
    let (change, error) = (of("change")?, of("change_std_error")?);
    let (low, high) = (of("change_ci_low")?, of("change_ci_high")?);
    let one = |row: usize| {
        let (environment, mode) = (environments[row].as_deref()?, modes[row].as_deref()?);
        let environment = study.environments.iter().find(|e| e.id.as_str() == environment)?;
        let mode = study.modes.iter().find(|m| m.id.as_str() == mode)?;
        let said = |value: f64| number(value, error[row]);
        Some(format!(
            "{}, {}, {}: {} ({} to {}, n = {} participants)",
            environment.label,
            mode.label,
            pairs[row].as_deref()?,
            with_unit(&said(change[row]?), &unit),
            said(low[row]?),
            said(high[row]?),
            n[row].filter(|n| *n > 1)?,
        ))
    };
    let told: Vec<String> = (0..table.height()).filter_map(one).collect();
    if told.is_empty() {
        return Ok(None);
    }
    let role = match metric.role {
        Role::Primary | Role::PrimaryByDefault => "the primary metric, ",
        Role::Exploratory => "",
    };
    let text = format!(
        "Exploratory, mean change between sessions in {role}{}: {}. Not adjusted for the number of changes.",
        words(&table),
        told.join("; ")
    );
    Ok(Some(Finding { text, shown: Shown::Sessions(metric.name.to_owned()) }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn told(n: [i64; 2]) -> Option<String> {
        let text = |name: &'static str, values: [&str; 2]| {
            Column::text(name, "", values.map(|value| Some(value.to_owned())))
        };
        let float =
            |name: &'static str, values: [Option<f64>; 2]| Column::float(name, "N", "", values);
        // Without a second participant there is no interval.
        let known = |value: f64| n.map(|n| (n > 1).then_some(value));
        let columns = vec![
            text("environment", ["spring", "spring"]),
            text("mode", ["active", "hybrid"]),
            text("sessions", ["S02 − S01", "S02 − S01"]),
            Column::integer("n", "1", "", n.map(Some)),
            float("change_n", known(-0.12)),
            float("change_std_error_n", known(0.01)),
            float("change_ci_low_n", known(-0.15)),
            float("change_ci_high_n", known(-0.09)),
        ];
        let table = Table::new("sessions", "Sessions compared: peak force", columns).unwrap();
        let metric =
            ComparedMetric { name: "peak", role: Role::Primary, means: &table, contrasts: &table };
        let study = Setup::of(&zwidth_testing::study());
        changes(&study, &[metric], &table).unwrap().map(|found| found.text)
    }

    #[test]
    fn changes_are_told_with_interval_and_number_of_participants() {
        assert_eq!(
            told([5, 1]).unwrap(),
            "Exploratory, mean change between sessions in the primary metric, peak force: Spring, Active, \
             S02 − S01: −0.120\u{a0}N (−0.150 to −0.090, n = 5 participants). Not adjusted for the number of changes."
        );
    }

    #[test]
    fn one_participant_tells_nothing_of_people() {
        assert_eq!(told([1, 1]), None);
    }
}
