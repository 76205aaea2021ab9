//! The table: columns that know their unit and what they mean.

use crate::TableError;
use crate::unit::split_unit;
use zwidth_results::{
    Column, Field, ModelRun, ModelSample, NoteKind, Row, Type, UNIT_OF_ROW, Values,
};

/// The mark below every table made from simulated data, as on every such figure.
pub const SYNTHETIC: &str = "SYNTHETIC: simulated, not measured.";

/// A table: name, title, notes, and columns of one length.
#[derive(Debug, Clone)]
pub struct Table {
    name: String,
    title: String,
    notes: Vec<String>,
    /// As many as notes.
    kinds: Vec<NoteKind>,
    columns: Vec<Column>,
}

impl Table {
    /// A table from columns.
    ///
    /// # Errors
    /// A float that is not finite (a missing value is null), columns of unequal length, two of one
    /// name.
    pub fn new(name: &str, title: &str, columns: Vec<Column>) -> Result<Self, TableError> {
        let expected = columns.first().map_or(0, |c| c.values.len());
        for (i, c) in columns.iter().enumerate() {
            let own = &c.field.name;
            if let Values::Float(values) = &c.values
                && let Some((row, value)) = (1_usize..)
                    .zip(values)
                    .find_map(|(row, v)| Some((row, v.filter(|v| !v.is_finite())?)))
            {
                return Err(TableError::Form(format!(
                    "column '{own}' of table '{name}', row {row}: {value} is not a number; a missing value is null"
                )));
            }
            if columns[..i].iter().any(|before| before.field.name == *own) {
                return Err(TableError::Form(format!(
                    "table '{name}' has the column '{own}' twice"
                )));
            }
            let found = c.values.len();
            if found != expected {
                return Err(TableError::Form(format!(
                    "column '{own}' of table '{name}' has {found} rows where the first has {expected}"
                )));
            }
        }
        let name = name.to_owned();
        let title = title.to_owned();
        Ok(Self { name, title, notes: Vec::new(), kinds: Vec::new(), columns })
    }

    /// The table of some rows, under their name and title.
    ///
    /// # Errors
    /// A float that is not finite.
    pub fn of_rows<R: Row>(rows: &[R]) -> Result<Self, TableError> {
        Self::new(R::NAME, R::TITLE, R::columns(rows))
    }

    /// The same table under another name and title: that of one subject.
    #[must_use]
    pub fn called(self, name: impl Into<String>, title: impl Into<String>) -> Self {
        Self { name: name.into(), title: title.into(), ..self }
    }

    /// The same table, `unit` in the place of one that a declaration leaves open.
    #[must_use]
    pub fn with_unit(mut self, open: &str, unit: &str) -> Self {
        for column in self.columns.iter_mut().filter(|column| column.field.unit == open) {
            column.field.unit = unit.to_owned().into();
        }
        self
    }

    /// The unit in the place of one that the declaration of rows `R` leaves open.
    pub fn unit_for<R: Row>(&self, open: &str) -> Option<&str> {
        let declared = R::fields().into_iter().find(|field| field.unit == open)?;
        let own = self.fields().find(|field| field.name == declared.name)?;
        Some(&own.unit)
    }

    /// Its rows as those of a declaration.
    ///
    /// # Errors
    /// A column that is not there or of another type; a value that is none.
    pub fn to_rows<R: Row>(&self) -> Result<Vec<R>, TableError> {
        R::read(&self.columns)
            .map_err(|source| TableError::Rows { table: self.name.clone(), source })
    }

    /// The same table without the columns that have no value in any row; a table without rows stays
    /// whole.
    #[must_use]
    pub fn without_empty_columns(mut self) -> Self {
        if self.height() > 0 {
            self.columns.retain(|column| column.values.are_any());
        }
        self
    }

    /// The samples of a run of the model.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn of_run(run: &ModelRun) -> Result<Self, TableError> {
        let table = Self::new(ModelSample::NAME, &run.scene, run.columns())?;
        Ok(run.notes.iter().cloned().fold(table.without_empty_columns(), Self::with_note))
    }

    /// The run whose samples the table has.
    ///
    /// # Errors
    /// A table of anything else.
    pub fn to_run(&self) -> Result<ModelRun, TableError> {
        let run = ModelRun::read(self.title.clone(), self.notes.clone(), &self.columns);
        run.map_err(|source| TableError::Rows { table: self.name.clone(), source })
    }

    /// The same table with a note below it.
    #[must_use]
    pub fn with_note(self, note: impl Into<String>) -> Self {
        self.with_note_of(NoteKind::General, note)
    }

    /// The same table with a note of a kind below it.
    #[must_use]
    pub fn with_note_of(mut self, kind: NoteKind, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self.kinds.push(kind);
        self
    }

    /// The same table with more notes below it.
    #[must_use]
    pub(crate) fn with_notes<N: Into<String>>(
        self,
        notes: impl IntoIterator<Item = (NoteKind, N)>,
    ) -> Self {
        notes.into_iter().fold(self, |table, (kind, note)| table.with_note_of(kind, note))
    }

    /// The same table, where `simulated` with the note that says so; once.
    #[must_use]
    pub fn with_mark(self, simulated: bool) -> Self {
        match simulated && !self.notes.iter().any(|note| note == SYNTHETIC) {
            true => self.with_note_of(NoteKind::Care, SYNTHETIC),
            false => self,
        }
    }

    /// The same table with the notes of another, those that it has not.
    #[must_use]
    pub fn with_notes_of(self, other: &Self) -> Self {
        let notes = other.notes_by_kind();
        notes.fold(self, |table, (kind, note)| match table.notes.iter().any(|own| own == note) {
            true => table,
            false => table.with_note_of(kind, note),
        })
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

    /// The same, each with its kind.
    pub fn notes_by_kind(&self) -> impl Iterator<Item = (NoteKind, &str)> {
        self.kinds.iter().copied().zip(self.notes.iter().map(String::as_str))
    }

    /// What the columns are, in order.
    pub fn fields(&self) -> impl Iterator<Item = &Field> {
        self.columns.iter().map(|c| &c.field)
    }

    /// The columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// One column.
    ///
    /// # Errors
    /// A column that is not there.
    pub fn column(&self, name: &str) -> Result<&Column, TableError> {
        let column = self.columns.iter().find(|c| c.field.name == name);
        column.ok_or_else(|| {
            let table = &self.name;
            let has = self.names();
            TableError::Form(format!("table '{table}' has no column '{name}'; it has {has}"))
        })
    }

    /// The column of that stem, whatever its unit: `mean` is `mean_n`, or `mean_rad`.
    ///
    /// # Errors
    /// A column that is not there.
    pub fn column_of(&self, stem: &str) -> Result<&Column, TableError> {
        let mut columns = self.columns.iter();
        let column = columns.find(|c| split_unit(&c.field.name, &c.field.unit).0 == stem);
        // The error then lists the columns, whose names have their units.
        column.map_or_else(|| self.column(stem), Ok)
    }

    /// The table with these columns alone, in this order, each by its name or its stem (see
    /// [`column_of`](Self::column_of)). Numbers in the unit of their row bring its metric and unit along.
    ///
    /// # Errors
    /// A column that is not there; one that is named twice.
    pub fn with_columns(&self, names: &[String]) -> Result<Self, TableError> {
        let columns = names.iter().map(|name| Ok(self.column_of(name)?.clone()));
        let mut columns: Vec<Column> = columns.collect::<Result<_, TableError>>()?;
        let place = |columns: &[Column], name| columns.iter().position(|c| c.field.name == name);
        if columns.iter().any(|c| c.field.unit == UNIT_OF_ROW) && place(&columns, "unit").is_none()
        {
            let metric = place(&columns, "metric");
            columns.insert(metric.map_or(0, |metric| metric + 1), self.column("unit")?.clone());
            if metric.is_none() {
                columns.splice(0..0, self.column("metric").ok().cloned());
            }
        }
        Ok(Self::new(&self.name, &self.title, columns)?.with_notes_of(self))
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The numbers of a column.
    pub fn floats(&self, column: &str) -> Result<Vec<Option<f64>>, TableError> {
        match self.values(column)? {
            Values::Float(values) => Ok(values.clone()),
            _ => Err(self.wrong_type(column, Type::Float)),
        }
    }

    /// The whole numbers of a column.
    pub fn integers(&self, column: &str) -> Result<Vec<Option<i64>>, TableError> {
        match self.values(column)? {
            Values::Integer(values) => Ok(values.clone()),
            _ => Err(self.wrong_type(column, Type::Integer)),
        }
    }

    /// The numbers of a column, whole or not.
    pub fn numbers(&self, column: &str) -> Result<Vec<Option<f64>>, TableError> {
        match self.values(column)? {
            Values::Integer(values) => Ok(values.iter().map(|n| n.map(|n| n as f64)).collect()),
            _ => self.floats(column),
        }
    }

    /// The texts of a column.
    pub fn texts(&self, column: &str) -> Result<Vec<Option<String>>, TableError> {
        Ok(self.words(column)?.map(|text| text.map(str::to_owned)).collect())
    }

    /// The same, borrowed and not copied.
    pub fn words(
        &self,
        column: &str,
    ) -> Result<impl ExactSizeIterator<Item = Option<&str>>, TableError> {
        match self.values(column)? {
            Values::Text(values) => Ok(values.iter().map(Option::as_deref)),
            _ => Err(self.wrong_type(column, Type::Text)),
        }
    }

    /// The yes and no of a column.
    pub fn flags(&self, column: &str) -> Result<Vec<Option<bool>>, TableError> {
        match self.values(column)? {
            Values::Flag(values) => Ok(values.clone()),
            _ => Err(self.wrong_type(column, Type::Flag)),
        }
    }

    /// The rows of several tables of one form, one after the other. Each column of theirs is dropped
    /// once it is joined, so that two of all the rows are never held.
    ///
    /// # Errors
    /// Tables whose columns differ.
    pub fn concat(name: &str, title: &str, tables: Vec<Self>) -> Result<Option<Self>, TableError> {
        let Some(first) = tables.first() else { return Ok(None) };
        tables.iter().try_for_each(|table| first.check_like(table))?;
        let fields: Vec<Field> = first.fields().cloned().collect();
        let mut parts: Vec<_> = tables.into_iter().map(|table| table.columns.into_iter()).collect();
        let mut columns = Vec::new();
        for field in fields {
            let parts = parts.iter_mut().filter_map(Iterator::next).map(|column| column.values);
            if let Some(values) = Values::joined(parts.collect()) {
                columns.push(Column { field, values });
            }
        }
        Self::new(name, title, columns).map(Some)
    }

    /// Makes room for so many rows more.
    pub(crate) fn reserve(&mut self, more: usize) {
        self.columns.iter_mut().for_each(|column| column.values.reserve(more));
    }

    /// Puts another table's rows behind these.
    ///
    /// # Errors
    /// Other columns.
    pub(crate) fn append(&mut self, more: Self) -> Result<(), TableError> {
        self.check_like(&more)?;
        let columns = self.columns.iter_mut().zip(more.columns);
        columns.for_each(|(column, more)| column.values.append(more.values));
        Ok(())
    }

    /// Whether another table's rows can be put to this one's.
    pub(crate) fn check_like(&self, other: &Self) -> Result<(), TableError> {
        let form =
            |table: &Self| table.fields().map(|f| (f.name.clone(), f.kind)).collect::<Vec<_>>();
        if form(self) == form(other) {
            return Ok(());
        }
        Err(TableError::Form(format!(
            "table '{}' has other columns than those it is to be put to ({} instead of {})",
            other.name,
            other.names(),
            self.names()
        )))
    }

    /// The rows in the order of a key; rows of one key stay as they are.
    #[must_use]
    pub fn sorted<K: Ord>(mut self, key: impl Fn(usize) -> K) -> Self {
        let mut rows: Vec<usize> = (0..self.height()).collect();
        rows.sort_by_cached_key(|row| key(*row));
        // A column at a time, so that two of all the rows are never held.
        for column in &mut self.columns {
            column.values = column.values.of_rows(rows.iter().copied().map(Some));
        }
        self
    }

    /// Some of the rows, in this order. One that is not there is null.
    #[must_use]
    pub fn rows(&self, rows: &[usize]) -> Self {
        let columns = self.columns.iter().map(|column| {
            let values = column.values.of_rows(rows.iter().copied().map(Some));
            Column { field: column.field.clone(), values }
        });
        Self {
            name: self.name.clone(),
            title: self.title.clone(),
            notes: self.notes.clone(),
            kinds: self.kinds.clone(),
            columns: columns.collect(),
        }
    }

    /// The rows that have a text in a column.
    ///
    /// # Errors
    /// A column that is not there or holds no texts.
    pub fn with_text(&self, column: &str, text: &str) -> Result<Self, TableError> {
        let texts = self.words(column)?.enumerate();
        let rows: Vec<usize> =
            texts.filter(|(_, own)| *own == Some(text)).map(|(row, _)| row).collect();
        Ok(self.rows(&rows))
    }

    /// The columns' names, for a message.
    fn names(&self) -> String {
        self.fields().map(|f| f.name.as_ref()).collect::<Vec<_>>().join(", ")
    }

    fn values(&self, column: &str) -> Result<&Values, TableError> {
        self.column(column).map(|column| &column.values)
    }

    fn wrong_type(&self, column: &str, wanted: Type) -> TableError {
        let table = &self.name;
        TableError::Form(format!("column '{column}' of table '{table}' is not of type {wanted:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let columns = vec![
            Column::text("mode", "the mode", ["active", "hybrid"].map(Some)),
            Column::float("force_n", "N", "a force", [Some(1.5), None]),
        ];
        Table::new("sample", "A sample", columns).unwrap()
    }

    #[test]
    fn columns_come_back_with_nulls() {
        let table = sample();
        assert_eq!(table.floats("force_n").unwrap(), [Some(1.5), None]);
        assert_eq!(table.height(), 2);
        assert_eq!(table.columns().len(), 2);
    }

    #[test]
    fn numbers_are_read_whole_or_not_and_texts_are_none() {
        let trial = Column::integer("trial", "1", "", [Some(-3), None]);
        let table = Table::new("t", "", [sample().columns, vec![trial]].concat()).unwrap();
        assert_eq!(table.numbers("trial").unwrap(), [Some(-3.0), None]);
        assert_eq!(table.numbers("force_n").unwrap(), [Some(1.5), None]);
        assert!(table.numbers("mode").is_err());
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
        let error = sample().floats("mode").unwrap_err().to_string();
        assert_eq!(error, "column 'mode' of table 'sample' is not of type Float");
    }

    #[test]
    fn columns_of_unequal_length_or_of_one_name_are_refused() {
        let columns = vec![
            Column::integer("trial", "1", "", [Some(1), Some(2)]),
            Column::integer("repeat", "1", "", [Some(1)]),
        ];
        let twice = Table::new("t", "", vec![columns[0].clone(), columns[0].clone()]).unwrap_err();
        assert_eq!(twice.to_string(), "table 't' has the column 'trial' twice");
        let error = Table::new("t", "", columns).unwrap_err();
        assert_eq!(
            error.to_string(),
            "column 'repeat' of table 't' has 1 rows where the first has 2"
        );
    }

    #[test]
    fn tables_of_one_form_are_put_together() {
        let both = Table::concat("both", "Both", vec![sample(), sample()]).unwrap().unwrap();
        assert_eq!(both.height(), 4);
        assert!(Table::concat("none", "", Vec::new()).unwrap().is_none());
        let other =
            Table::new("other", "", vec![Column::text("force_n", "", [Some("1")])]).unwrap();
        assert!(Table::concat("both", "", vec![sample(), other]).is_err());
        let more = [sample().columns(), &[Column::flag("more", "", [None, None])]].concat();
        let more = Table::new("more", "", more).unwrap();
        let error = Table::concat("both", "", vec![sample(), more]).unwrap_err().to_string();
        assert!(error.contains("mode, force_n, more instead of mode, force_n"), "{error}");
    }
}
