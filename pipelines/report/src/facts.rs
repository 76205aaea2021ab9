//! A table of single facts: one quantity a row, each with its own unit.

use zwidth_tables::{Column, Table, TableError};

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fact {
    quantity: String,
    value: Option<f64>,
    unit: &'static str,
    remark: String,
    printed: Option<f64>,
}

impl Fact {
    pub(crate) fn new(quantity: impl Into<String>, value: Option<f64>, unit: &'static str) -> Self {
        Self { quantity: quantity.into(), value, unit, remark: String::new(), printed: None }
    }

    /// The same with a remark.
    pub(crate) fn remarked(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }

    /// The same beside the number the thesis prints.
    pub(crate) fn printed(self, value: f64) -> Self {
        Self { printed: Some(value), ..self }
    }
}

/// The facts as a table, in order; the thesis' numbers and the remarks only where there are any.
pub(crate) fn table(name: &str, title: &str, facts: &[Fact]) -> Result<Table, TableError> {
    let word = |word: &str| (!word.is_empty()).then(|| word.to_owned());
    let text = |name, about, get: fn(&Fact) -> &str| {
        Column::text(name, about, facts.iter().map(|f| word(get(f))))
    };
    let mut columns = vec![
        text("quantity", "what it is", |f| &f.quantity),
        Column::float(
            "value",
            "1",
            "its value, in the unit beside it",
            facts.iter().map(|f| f.value),
        ),
        text("unit", "its unit", |f| f.unit),
    ];
    if facts.iter().any(|f| f.printed.is_some()) {
        let about = "the number that the thesis prints, in the same unit";
        columns.push(Column::float("thesis", "1", about, facts.iter().map(|f| f.printed)));
    }
    if facts.iter().any(|f| !f.remark.is_empty()) {
        columns.push(text("remark", "what is to be said of it", |f| &f.remark));
    }
    Table::new(name, title, columns)
}
