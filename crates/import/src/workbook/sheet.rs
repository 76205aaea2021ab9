//! The cells of a sheet, row by row, as a table.

use super::super::csv::Dialect;
use super::super::limits::{
    MOST_TEXT, MOST_WHOLE_ROWS, Take, check_columns, check_name, more_rows, too_much_text,
};
use super::super::table::{Cells, EmptyRows, Table};
use arrow::array::Float64Array;
use std::borrow::Cow;
use std::path::Path;
use zwidth_store::StoreError;

/// The value of a cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    Number(f64),
    Text(Cow<'a, str>),
}

impl Value<'_> {
    fn text(&self) -> String {
        match self {
            Self::Number(value) => value.to_string(),
            Self::Text(text) => text.trim().to_owned(),
        }
    }
}

/// A sheet, as far as its rows were given.
pub(super) struct Sheet<'a> {
    path: &'a Path,
    dialect: Dialect,
    take: &'a Take<'a>,
    names: Option<Vec<String>>,
    columns: Vec<Column>,
    /// The places of those that are read.
    read: Vec<usize>,
    /// The row in the sheet of each of ours, from 1.
    lines: Vec<u64>,
    /// Bytes of all texts.
    text: usize,
}

/// A column that grows; numbers until a text comes.
enum Column {
    Unread,
    Numbers(Vec<Option<f64>>),
    Texts(Vec<Option<String>>),
}

impl Column {
    fn push(&mut self, value: Option<&Value>) {
        if let (Self::Numbers(numbers), Some(Value::Text(_))) = (&*self, value) {
            let texts = numbers.iter().map(|number| number.map(|number| number.to_string()));
            *self = Self::Texts(texts.collect());
        }
        match (self, value) {
            (Self::Unread, _) => {}
            (Self::Numbers(numbers), Some(Value::Number(number))) => numbers.push(Some(*number)),
            (Self::Numbers(numbers), _) => numbers.push(None),
            (Self::Texts(texts), value) => texts.push(value.map(Value::text)),
        }
    }

    fn cells(self) -> Cells {
        match self {
            Self::Unread => Cells::Unread,
            Self::Numbers(numbers) => Cells::Numbers(Float64Array::from(numbers)),
            Self::Texts(texts) => Cells::Text(texts.into_iter().collect()),
        }
    }
}

impl<'a> Sheet<'a> {
    pub(super) fn new(path: &'a Path, dialect: Dialect, take: &'a Take<'a>) -> Self {
        Self {
            path,
            dialect,
            take,
            names: None,
            columns: Vec::new(),
            read: Vec::new(),
            lines: Vec::new(),
            text: 0,
        }
    }

    /// Adds the row `line` (from 1) of the sheet, and as many more like it as it is repeated. Cells
    /// stand in the order of their places, from 0; a row without any is an empty row.
    ///
    /// # Errors
    /// More than is read.
    pub(super) fn row(
        &mut self,
        line: u64,
        repeated: usize,
        cells: &[(usize, Value)],
    ) -> Result<(), StoreError> {
        let cells: Vec<&(usize, Value)> = cells
            .iter()
            .filter(|(_, v)| !matches!(v, Value::Text(text) if text.trim().is_empty()))
            .collect();
        let Some((last, _)) = cells.last() else { return Ok(()) };
        if line <= self.dialect.skip as u64 {
            return Ok(());
        }
        let width = last + 1;
        check_columns(self.path, width)?;
        if self.dialect.header && self.names.is_none() {
            let mut names = vec![String::new(); width];
            for (place, value) in &cells {
                let name = value.text();
                check_name(self.path, &name)?;
                names[*place] = name;
            }
            self.names = Some(names);
            self.widen(width);
            return Ok(());
        }
        self.widen(width);
        // Before memory is taken: a row may be repeated a million times in a few bytes of the file.
        if self.lines.len().saturating_add(repeated) > MOST_WHOLE_ROWS {
            return Err(more_rows(self.path));
        }
        self.take.room(self.path, self.read.len().saturating_mul(repeated))?;
        let texts = cells.iter().map(|(place, value)| match (&self.columns[*place], value) {
            (Column::Unread, _) | (_, Value::Number(_)) => 0,
            (_, Value::Text(text)) => text.len(),
        });
        self.text = self.text.saturating_add(texts.sum::<usize>().saturating_mul(repeated));
        if self.text > MOST_TEXT {
            return Err(too_much_text(self.path));
        }
        for place in &self.read {
            let here = cells.binary_search_by_key(place, |(at, _)| *at).ok().map(|i| &cells[i].1);
            (0..repeated).for_each(|_| self.columns[*place].push(here));
        }
        self.lines.extend((line..).take(repeated));
        Ok(())
    }

    /// Adds columns up to `width`, as if they had been there, without names.
    fn widen(&mut self, width: usize) {
        for place in self.columns.len()..width {
            // A row may be wider than the header.
            if let Some(names) = self.names.as_mut().filter(|names| names.len() == place) {
                names.push(String::new());
            }
            let name = self.names.as_ref().map(|names| names[place].as_str());
            if self.take.wants(place, name) {
                self.read.push(place);
                self.columns.push(Column::Numbers(vec![None; self.lines.len()]));
            } else {
                self.columns.push(Column::Unread);
            }
        }
    }

    /// The table.
    ///
    /// # Errors
    /// No row has a value.
    pub(super) fn table(self) -> Result<Table, StoreError> {
        if self.columns.is_empty() {
            let what = "the sheet has no values";
            return Err(StoreError::new(self.path, what, "leave the file out of the import"));
        }
        let columns = self.columns.into_iter().map(Column::cells).collect();
        let empty = EmptyRows::between(&self.lines);
        Ok(Table { names: self.names, columns, lines: self.lines, empty, ..Table::default() })
    }
}
