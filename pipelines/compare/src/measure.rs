//! A metric as it is compared.

use crate::MetricParameters;
use std::sync::Arc;
use zwidth_tables::{Measured, TableError};

/// A metric, and what its comparison depends on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Measure<'a> {
    /// The parameters of its comparison.
    pub(crate) parameters: &'a MetricParameters,
    /// Its unit.
    pub(crate) unit: Arc<str>,
    /// Its description.
    pub(crate) words: String,
}

impl<'a> Measure<'a> {
    /// The metric, as the table of metrics describes it.
    pub(crate) fn new(
        metrics: &Measured,
        parameters: &'a MetricParameters,
    ) -> Result<Self, TableError> {
        let field = &metrics.table().column(parameters.metric.as_str())?.field;
        let unit = field.unit.as_ref().into();
        let words = field.description.to_string();
        Ok(Self { parameters, unit, words })
    }
}
