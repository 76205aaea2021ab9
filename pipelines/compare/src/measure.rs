//! A metric as it is compared: its column of the metrics, and the columns made of it.

use zwidth_tables::{Column, Field, Table, TableError, Type, Values, split_unit};

/// A metric.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measure {
    /// Its column in the table of metrics, the unit last: `discrepancy_user_mean_n`.
    pub name: String,
    /// The end of that name that is its unit, `_n`; empty for the unit `1`.
    suffix: String,
    /// Its unit.
    pub unit: String,
    /// What it is, in words.
    pub description: String,
}

impl Measure {
    /// The metric of that column.
    ///
    /// # Errors
    /// A column that is not there.
    pub fn of(metrics: &Table, name: &str) -> Result<Self, TableError> {
        let field = &metrics.column(name)?.field;
        Ok(Self {
            name: name.to_owned(),
            suffix: split_unit(&field.name, &field.unit).1.to_owned(),
            unit: field.unit.to_string(),
            description: field.description.to_string(),
        })
    }

    /// A column in the metric's unit: `difference` of `discrepancy_user_mean_n` is `difference_n`.
    pub(crate) fn column(
        &self,
        stem: &str,
        description: &str,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Column {
        let field = Field {
            name: self.named(stem).into(),
            unit: self.unit.clone().into(),
            description: description.to_owned().into(),
            kind: Type::Float,
        };
        Column { field, values: Values::Float(values.into_iter().collect()) }
    }

    /// The name of such a column.
    pub fn named(&self, stem: &str) -> String {
        format!("{stem}{}", self.suffix)
    }
}
