//! Metrics that other programs computed, as further columns of the table of metrics. This is the one place where tables of
//! such values come in, wherever they lie: those that were given beside the recordings, and those that jobs make.

use crate::shared::handle::Derived;
use crate::shared::own_stages::{given, values};
use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_metrics::OutsideColumn;
use zwidth_results::OutsideValue;
use zwidth_store::StudyData;
use zwidth_study::{OutsideMetric, ParticipantId, SessionId};
use zwidth_tables::TableError;

/// A metric from outside that becomes a column, and which of its values do not count.
#[derive(Serialize)]
pub(crate) struct Joined {
    pub(crate) metric: OutsideMetric,
    /// Trials whose recordings are others now than those that the values are of.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    outdated: BTreeSet<(ParticipantId, SessionId, u32)>,
    /// Whether a stage of the study's own gives it, whose table is missing as long as it fails.
    #[serde(skip)]
    is_of_stage: bool,
}

impl Joined {
    /// The column, from the rows of its table.
    pub(crate) fn column(
        &self,
        table: &Derived<OutsideValue>,
    ) -> Result<OutsideColumn, TableError> {
        let rows = match self.is_of_stage {
            true => table.read_if_made()?.unwrap_or_default(),
            false => table.read()?,
        };
        let named = rows
            .into_iter()
            .filter_map(|row| Some(((row.participant, row.session, row.trial), row.value?)));
        let values = named.filter(|(trial, _)| !self.outdated.contains(trial));
        Ok(OutsideColumn { metric: self.metric.clone(), values: values.collect() })
    }
}

/// Every metric from outside that the study has, each with its table of values.
pub(crate) fn joined(data: &StudyData) -> Vec<(Joined, Derived<OutsideValue>)> {
    let mut joined = Vec::new();
    for metric in zwidth_metrics::outside_metrics(&data.study) {
        if let Some((stage, own)) = given(data, metric) {
            let table = values(&data.layout, stage, own);
            let (metric, outdated) = (metric.clone(), BTreeSet::new());
            joined.push((Joined { metric, outdated, is_of_stage: true }, table));
            continue;
        }
        let mut given = data.outside.iter().filter(|own| own.counts());
        if let Some(own) = given.find(|own| own.metric == *metric) {
            let outdated = own.outdated.iter().cloned().collect();
            let table = Derived::at(own.path.clone());
            let metric = metric.clone();
            joined.push((Joined { metric, outdated, is_of_stage: false }, table));
        }
    }
    joined
}
