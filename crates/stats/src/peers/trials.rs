//! The trials that are compared.

use std::collections::BTreeSet;

/// Trials with a value, as columns of a tidy table. Participants and modes are any numbers.
#[derive(Debug, Clone, Copy)]
pub struct Trials<'a> {
    /// The participant of each trial.
    pub participant: &'a [usize],
    /// The mode of each trial.
    pub mode: &'a [usize],
    /// The metric of each trial.
    pub value: &'a [f64],
}

/// The ids that there are, in their order.
pub(super) fn distinct(ids: &[usize]) -> Vec<usize> {
    ids.iter().copied().collect::<BTreeSet<_>>().into_iter().collect()
}

/// A trial with the place of its mode.
pub(super) struct Row {
    pub(super) participant: usize,
    pub(super) place: usize,
    pub(super) value: f64,
}

impl Trials<'_> {
    /// The trials, with the places of their modes among `modes`, which are in their order.
    pub(super) fn rows(&self, modes: &[usize]) -> impl Iterator<Item = Row> {
        let columns = self.participant.iter().zip(self.mode).zip(self.value);
        columns.map(|((participant, mode), value)| Row {
            participant: *participant,
            place: modes.partition_point(|own| own < mode),
            value: *value,
        })
    }
}
