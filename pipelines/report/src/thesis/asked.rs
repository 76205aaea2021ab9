//! Which columns the statements look at.

use crate::thesis::forces::WALL_FORCE;
use crate::thesis::rule::From;
use crate::thesis::statements::ALL;
use zwidth_tables::{Table, TableError};

/// Of the rows of the table of replays those that are asked: of the model by eye, driven by force.
///
/// # Errors
/// A table that lacks a column.
pub fn replayed(replays: &Table) -> Result<Table, TableError> {
    let rows = replays.words("causality")?.zip(replays.words("model")?).enumerate();
    let is_asked = |(row, of)| (of == (Some("force_driven"), Some("by_eye"))).then_some(row);
    Ok(replays.rows(&rows.filter_map(is_asked).collect::<Vec<_>>()))
}

/// The columns of the table of replays that are looked at.
pub fn replayed_columns() -> Vec<&'static str> {
    let told_apart = ["participant", "session", "environment", "mode", "causality", "model"];
    told_apart.into_iter().chain(asked(From::Replays)).collect()
}

/// The metrics that the statements ask of trials.
pub(crate) fn asked_metrics() -> impl Iterator<Item = &'static str> {
    asked(From::Metrics).chain(WALL_FORCE.columns())
}

fn asked(from: From) -> impl Iterator<Item = &'static str> {
    let quantities = ALL.iter().filter_map(|statement| statement.rule.quantity());
    quantities.filter(move |quantity| quantity.from == from).flat_map(|of| of.columns())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    #[test]
    fn of_the_replays_those_by_eye_and_by_force_are_asked() {
        let text = |name, values: [&str; 4]| {
            Column::text(name, "", values.map(|value| Some(value.to_owned())))
        };
        let columns = vec![
            text("causality", ["force_driven", "motion_driven", "force_driven", "force_driven"]),
            text("model", ["by_eye", "by_eye", "fitted", "by_eye"]),
            Column::integer("trial", "1", "", (1..=4).map(Some)),
        ];
        let asked = replayed(&Table::new("replay", "", columns).unwrap()).unwrap();
        assert_eq!(asked.integers("trial").unwrap(), [Some(1), Some(4)]);
    }
}
