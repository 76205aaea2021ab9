//! Everybody's means by condition, and weighted sums of them.

use crate::Parameters;
use crate::cells::Cells;
use std::collections::BTreeMap;
use zwidth_study::{OverDose, Weight};

/// A condition by the places of its environment and its mode, and of its session where that is one of its
/// levels.
pub(crate) type Condition = (Option<usize>, [usize; 2]);

/// A condition with its weight.
pub(crate) type Placed = (Condition, f64);

/// Weights by the places of their conditions; `None` if the study has no such condition.
pub(crate) fn placed(
    weights: &[Weight],
    cells: &Cells,
    parameters: &Parameters,
) -> Option<Vec<Placed>> {
    let places = weights.iter().map(|weight| {
        let condition = parameters.condition(&weight.environment, &weight.mode)?;
        // Nobody has a session that is not among those there are.
        let place = |id| cells.sessions.iter().position(|own| own == id).unwrap_or(usize::MAX);
        Some(((weight.session.as_ref().map(place), condition), weight.weight))
    });
    places.collect()
}

/// What a participant has of conditions at a time.
pub(crate) type Own = BTreeMap<Condition, f64>;

/// Everybody's means by condition: session by session, or, where sessions are levels, all of them together.
pub(crate) fn of_people(cells: &Cells, are_levels: bool) -> BTreeMap<usize, Vec<Own>> {
    let mut people: BTreeMap<usize, BTreeMap<Option<usize>, Own>> = BTreeMap::new();
    for cell in &cells.cells {
        let Some(mean) = cell.mean else { continue };
        let session = Some(cell.session);
        let (apart, level) = if are_levels { (None, session) } else { (session, None) };
        let own = people.entry(cell.participant).or_default().entry(apart).or_default();
        own.insert((level, [cell.environment, cell.mode]), mean);
    }
    people.into_iter().map(|(who, sessions)| (who, sessions.into_values().collect())).collect()
}

/// Everybody's mean of `values` over those of their sessions that have them, by participant.
pub(crate) fn averaged(
    people: &BTreeMap<usize, Vec<Own>>,
    values: impl Fn(&Own) -> Option<Vec<f64>>,
) -> BTreeMap<usize, Vec<f64>> {
    let mut means = BTreeMap::new();
    for (participant, sessions) in people {
        let sessions: Vec<Vec<f64>> = sessions.iter().filter_map(&values).collect();
        let Some(first) = sessions.first() else { continue };
        let sum = |k: usize| sessions.iter().map(|values| values[k]).sum::<f64>();
        let mean = (0..first.len()).map(|k| sum(k) / sessions.len() as f64);
        means.insert(*participant, mean.collect());
    }
    means
}

/// The conditions of each level of a dose, with their weights in its mean.
pub(crate) fn levels_of(
    over: &OverDose,
    cells: &Cells,
    parameters: &Parameters,
) -> Vec<Vec<Placed>> {
    let level = |weights: &Vec<Weight>| placed(weights, cells, parameters).unwrap_or_default();
    over.levels.iter().map(level).collect()
}

/// The weighted sum of somebody's conditions; `None` if they lack one.
pub(crate) fn weighed(weights: &[Placed], own: &Own) -> Option<f64> {
    weights.iter().map(|(condition, weight)| Some(weight * own.get(condition)?)).sum()
}
