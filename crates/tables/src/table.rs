//! The table: a polars frame whose columns know their unit and what they mean.

use crate::TableError;
use polars::prelude::{self as pl, IntoColumn, NamedFrom};
use std::borrow::Cow;

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// `f64`, finite or null.
    Float,
    /// `i64`.
    Integer,
    /// Text.
    Text,
    /// Yes or no.
    Flag,
}

/// What a column is: name (with its unit as suffix), unit, meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name, in snake case, with the unit as its suffix: `theta_max_rad`.
    pub name: Cow<'static, str>,
    /// Unit: `rad`, `N`, `1` for a pure number or a word.
    pub unit: Cow<'static, str>,
    /// Meaning, one sentence.
    pub description: Cow<'static, str>,
    /// Type.
    pub kind: Type,
}

/// The values of a column; `None` is null: not applicable, or not known.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers.
    Float(Vec<Option<f64>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// Yes or no.
    Flag(Vec<Option<bool>>),
}

impl Values {
    fn kind(&self) -> Type {
        match self {
            Self::Float(_) => Type::Float,
            Self::Integer(_) => Type::Integer,
            Self::Text(_) => Type::Text,
            Self::Flag(_) => Type::Flag,
        }
    }
}

/// A column to be: its field and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// What it is.
    pub field: Field,
    /// Its values.
    pub values: Values,
}

impl Column {
    fn new(name: &'static str, unit: &'static str, description: &'static str, values: Values) -> Self {
        let field = Field {
            name: name.into(),
            unit: unit.into(),
            description: description.into(),
            kind: values.kind(),
        };
        Self { field, values }
    }

    /// A column of numbers.
    pub fn float(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Self {
        Self::new(name, unit, description, Values::Float(values.into_iter().collect()))
    }

    /// A column of whole numbers.
    pub fn integer(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<i64>>,
    ) -> Self {
        Self::new(name, unit, description, Values::Integer(values.into_iter().collect()))
    }

    /// A column of texts.
    pub fn text(
        name: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<String>>,
    ) -> Self {
        Self::new(name, "1", description, Values::Text(values.into_iter().collect()))
    }

    /// A column of yes and no.
    pub fn flag(
        name: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<bool>>,
    ) -> Self {
        Self::new(name, "1", description, Values::Flag(values.into_iter().collect()))
    }
}

/// A table: name, title, notes, and a polars frame whose columns are described by `fields`.
#[derive(Debug, Clone)]
pub struct Table {
    name: String,
    title: String,
    notes: Vec<String>,
    fields: Vec<Field>,
    frame: pl::DataFrame,
}

impl Table {
    /// A table from columns.
    ///
    /// # Errors
    /// A float that is not finite (a missing value is null), columns of unequal length.
    pub fn new(name: &str, title: &str, columns: Vec<Column>) -> Result<Self, TableError> {
        for c in &columns {
            check_finite(name, c)?;
        }
        let height = columns.first().map_or(0, |c| length(&c.values));
        let (fields, series): (Vec<_>, Vec<_>) =
            columns.into_iter().map(|c| (c.field.clone(), series(c))).unzip();
        let frame = pl::DataFrame::new(height, series)
            .map_err(|source| TableError::Polars { table: name.to_owned(), source })?;
        Ok(Self { name: name.to_owned(), title: title.to_owned(), notes: Vec::new(), fields, frame })
    }

    /// A table from a polars frame, as a query gave it; `fields` describe its columns, in order.
    ///
    /// # Errors
    /// Columns that differ from `fields` in name or type; a float that is not finite.
    pub fn from_frame(
        name: &str,
        title: &str,
        fields: Vec<Field>,
        frame: pl::DataFrame,
    ) -> Result<Self, TableError> {
        let table = Self { name: name.to_owned(), title: title.to_owned(), notes: Vec::new(), fields, frame };
        table.columns()?.iter().try_for_each(|c| check_finite(name, c))?;
        Ok(table)
    }

    /// The same table with a note below it.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Short name: a file's stem.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Title, a phrase.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Notes to be printed below the table.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What the columns are, in order.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.frame.height()
    }

    /// The rows as a polars frame, for grouping and joining.
    pub fn frame(&self) -> &pl::DataFrame {
        &self.frame
    }

    /// The numbers of a column.
    pub fn floats(&self, column: &str) -> Result<Vec<Option<f64>>, TableError> {
        let series = self.series(column)?;
        let values = series.f64().map_err(|_| self.wrong_type(column, Type::Float))?;
        Ok(values.iter().collect())
    }

    /// The whole numbers of a column.
    pub fn integers(&self, column: &str) -> Result<Vec<Option<i64>>, TableError> {
        let series = self.series(column)?;
        let values = series.i64().map_err(|_| self.wrong_type(column, Type::Integer))?;
        Ok(values.iter().collect())
    }

    /// The texts of a column.
    pub fn texts(&self, column: &str) -> Result<Vec<Option<String>>, TableError> {
        let series = self.series(column)?;
        let values = series.str().map_err(|_| self.wrong_type(column, Type::Text))?;
        Ok(values.iter().map(|v| v.map(str::to_owned)).collect())
    }

    /// The yes and no of a column.
    pub fn flags(&self, column: &str) -> Result<Vec<Option<bool>>, TableError> {
        let series = self.series(column)?;
        let values = series.bool().map_err(|_| self.wrong_type(column, Type::Flag))?;
        Ok(values.iter().collect())
    }

    /// The columns, taken apart again.
    pub fn columns(&self) -> Result<Vec<Column>, TableError> {
        let values = |f: &Field| -> Result<Values, TableError> {
            Ok(match f.kind {
                Type::Float => Values::Float(self.floats(&f.name)?),
                Type::Integer => Values::Integer(self.integers(&f.name)?),
                Type::Text => Values::Text(self.texts(&f.name)?),
                Type::Flag => Values::Flag(self.flags(&f.name)?),
            })
        };
        self.fields.iter().map(|f| Ok(Column { field: f.clone(), values: values(f)? })).collect()
    }

    /// The rows of several tables of one form, one after the other.
    ///
    /// # Errors
    /// Tables whose columns differ.
    pub fn concat(name: &str, title: &str, tables: &[Self]) -> Result<Option<Self>, TableError> {
        let polars = |source| TableError::Polars { table: name.to_owned(), source };
        let Some((first, others)) = tables.split_first() else {
            return Ok(None);
        };
        let mut frame = first.frame.clone();
        for table in others {
            frame.vstack_mut(&table.frame).map_err(polars)?;
        }
        let (name, title) = (name.to_owned(), title.to_owned());
        Ok(Some(Self { name, title, notes: Vec::new(), fields: first.fields.clone(), frame }))
    }

    fn series(&self, column: &str) -> Result<&pl::Column, TableError> {
        self.frame.column(column).map_err(|_| TableError::NoColumn {
            table: self.name.clone(),
            column: column.to_owned(),
            has: self.fields.iter().map(|f| f.name.as_ref()).collect::<Vec<_>>().join(", "),
        })
    }

    fn wrong_type(&self, column: &str, wanted: Type) -> TableError {
        TableError::WrongType { table: self.name.clone(), column: column.to_owned(), wanted }
    }
}

fn length(values: &Values) -> usize {
    match values {
        Values::Float(v) => v.len(),
        Values::Integer(v) => v.len(),
        Values::Text(v) => v.len(),
        Values::Flag(v) => v.len(),
    }
}

fn series(column: Column) -> pl::Column {
    let name = pl::PlSmallStr::from_str(&column.field.name);
    match column.values {
        Values::Float(v) => pl::Series::new(name, v),
        Values::Integer(v) => pl::Series::new(name, v),
        Values::Text(v) => pl::Series::new(name, v),
        Values::Flag(v) => pl::Series::new(name, v),
    }
    .into_column()
}

fn check_finite(table: &str, column: &Column) -> Result<(), TableError> {
    let Values::Float(values) = &column.values else {
        return Ok(());
    };
    match values.iter().enumerate().find_map(|(i, v)| v.filter(|v| !v.is_finite()).map(|v| (i, v))) {
        None => Ok(()),
        Some((row, value)) => Err(TableError::NotFinite {
            table: table.to_owned(),
            column: column.field.name.to_string(),
            row: row + 1,
            value,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let columns = vec![
            Column::text("mode", "the mode", [Some("active".to_owned()), Some("hybrid".to_owned())]),
            Column::float("force_n", "N", "a force", [Some(1.5), None]),
        ];
        Table::new("sample", "A sample", columns).unwrap()
    }

    #[test]
    fn columns_come_back_with_nulls() {
        let table = sample();
        assert_eq!(table.floats("force_n").unwrap(), [Some(1.5), None]);
        assert_eq!(table.height(), 2);
        assert_eq!(table.columns().unwrap().len(), 2);
    }

    #[test]
    fn a_number_that_is_none_is_refused_with_column_and_row() {
        let bad = Column::float("force_n", "N", "a force", [Some(1.0), Some(f64::NAN)]);
        let error = Table::new("t", "", vec![bad]).unwrap_err();
        assert!(error.to_string().contains("column 'force_n' of table 't', row 2"), "{error}");
    }

    #[test]
    fn a_missing_column_is_named_with_those_there_are() {
        let error = sample().floats("mass_kg").unwrap_err().to_string();
        assert!(error.contains("no column 'mass_kg'; it has mode, force_n"), "{error}");
        assert!(matches!(sample().floats("mode"), Err(TableError::WrongType { .. })));
    }

    #[test]
    fn tables_of_one_form_are_put_together() {
        let both = Table::concat("both", "Both", &[sample(), sample()]).unwrap().unwrap();
        assert_eq!(both.height(), 4);
        assert!(Table::concat("none", "", &[]).unwrap().is_none());
    }
}
