//! Which columns the statements use.

use crate::thesis::forces::WALL_FORCE;
use crate::thesis::rule::From;
use crate::thesis::statements::ALL;
use std::borrow::Cow;
use zwidth_results::{Causality, ModelPlant, ReplayedModel, Row as _, TrialKey};
use zwidth_tables::{Table, TableError};

/// The rows of the table of replays that are used: those of the model by eye, driven by force.
///
/// # Errors
/// A table that is not one of replays.
pub fn replayed(replays: &Table) -> Result<Table, TableError> {
    let models: Vec<ReplayedModel> = replays.to_rows()?;
    let used = models.iter().enumerate().filter(|(_, model)| {
        (model.causality, model.model) == (Causality::ForceDriven, ModelPlant::ByEye)
    });
    let rows = used.map(|(row, _)| row);
    Ok(replays.rows(&rows.collect::<Vec<_>>()))
}

/// The columns of the table of replays that are used.
pub fn replayed_columns() -> Vec<Cow<'static, str>> {
    let keys = [TrialKey::fields(), ReplayedModel::fields()].concat().into_iter();
    keys.map(|field| field.name).chain(columns(From::Replays).map(Cow::from)).collect()
}

/// The metrics of trials that the statements need.
pub(crate) fn statement_metrics() -> impl Iterator<Item = &'static str> {
    columns(From::Metrics).chain(WALL_FORCE.columns())
}

fn columns(from: From) -> impl Iterator<Item = &'static str> {
    let quantities = ALL.iter().filter_map(|statement| statement.rule.quantity());
    quantities.filter(move |quantity| quantity.from == from).flat_map(|quantity| quantity.columns())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_the_replays_those_by_eye_and_by_force_are_asked() {
        let of = |causality, model| ReplayedModel { causality, model };
        let rows = [
            of(Causality::PositionDriven, ModelPlant::ByEye),
            of(Causality::ForceDriven, ModelPlant::ByEye),
            of(Causality::ForceDriven, ModelPlant::Fitted),
        ];
        let asked = replayed(&Table::of_rows(&rows).unwrap()).unwrap();
        assert_eq!(asked.to_rows::<ReplayedModel>().unwrap(), rows[1..2]);
    }
}
