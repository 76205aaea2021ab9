//! The values of messages as columns, which come as they are first met.

use super::super::limits::{MOST_TEXT, Take, check_columns, check_name, check_rows, too_much_text};
use super::super::table::{Cells, Declared, Table};
use arrow::array::{Array as _, ArrayBuilder as _, Float64Array, LargeStringBuilder};
use std::collections::HashMap;
use std::path::Path;
use zwidth_store::StoreError;

/// A value of a message.
pub(super) enum Leaf<'a> {
    Number(f64),
    Whole(i128),
    Nanoseconds(i128),
    Text(&'a str),
    /// A list of so many values, which are no columns.
    Long(usize),
}

/// The values of a column, from the first message on.
enum Values {
    Unread,
    Numbers(Vec<Option<f64>>),
    Whole(Vec<Option<i128>>),
    Text(LargeStringBuilder),
    Other(String),
}

/// Columns that grow message by message.
pub(super) struct Columns<'a> {
    path: &'a Path,
    take: &'a Take<'a>,
    names: Vec<String>,
    values: Vec<Values>,
    places: HashMap<String, usize>,
    nanoseconds: Vec<usize>,
    rows: usize,
    letters: usize,
}

impl<'a> Columns<'a> {
    pub(super) fn new(path: &'a Path, take: &'a Take<'a>) -> Self {
        Self {
            path,
            take,
            names: Vec::new(),
            values: Vec::new(),
            places: HashMap::new(),
            nanoseconds: Vec::new(),
            rows: 0,
            letters: 0,
        }
    }

    /// Adds a value of the message at hand.
    ///
    /// # Errors
    /// More than is read.
    pub(super) fn add(&mut self, name: &str, leaf: &Leaf) -> Result<(), StoreError> {
        let place = match self.places.get(name) {
            Some(place) => *place,
            None => {
                let place = self.names.len();
                check_columns(self.path, place + 1)?;
                check_name(self.path, name)?;
                self.names.push(name.to_owned());
                self.places.insert(name.to_owned(), place);
                if matches!(leaf, Leaf::Nanoseconds(_)) {
                    self.nanoseconds.push(place);
                }
                let is_taken = self.take.wants(place, Some(name));
                self.values.push(match leaf {
                    Leaf::Long(count) => Values::Other(format!(
                        "it is a list of {count} values, and at most 256 are columns"
                    )),
                    _ if !is_taken => Values::Unread,
                    Leaf::Number(_) => Values::Numbers(Vec::new()),
                    Leaf::Whole(_) | Leaf::Nanoseconds(_) => Values::Whole(Vec::new()),
                    Leaf::Text(_) => Values::Text(LargeStringBuilder::new()),
                });
                place
            }
        };
        // Whole numbers among others are numbers: JSON writes 1 for 1.0.
        if let (Values::Whole(whole), Leaf::Number(_)) = (&self.values[place], leaf) {
            #[allow(clippy::cast_precision_loss)] // As JSON meant them.
            let numbers = whole.iter().map(|value| value.map(|value| value as f64)).collect();
            self.values[place] = Values::Numbers(numbers);
        }
        let row = self.rows;
        let length = match &self.values[place] {
            Values::Numbers(values) => values.len(),
            Values::Whole(values) => values.len(),
            Values::Text(values) => values.len(),
            Values::Unread | Values::Other(_) => return Ok(()),
        };
        if length > row {
            // A second value of one name: the first counts.
            return Ok(());
        }
        self.take.room(self.path, row + 1 - length)?;
        match (&mut self.values[place], leaf) {
            (Values::Numbers(values), Leaf::Number(value)) => {
                values.resize(row, None);
                values.push(Some(*value));
            }
            #[allow(clippy::cast_precision_loss)] // As JSON meant them.
            (Values::Numbers(values), Leaf::Whole(value)) => {
                values.resize(row, None);
                values.push(Some(*value as f64));
            }
            (Values::Whole(values), Leaf::Whole(value) | Leaf::Nanoseconds(value)) => {
                values.resize(row, None);
                values.push(Some(*value));
            }
            (Values::Text(values), Leaf::Text(text)) => {
                self.letters += text.len();
                if self.letters > MOST_TEXT {
                    return Err(too_much_text(self.path));
                }
                values.append_nulls(row - length);
                values.append_option(Some(*text).filter(|text| !text.is_empty()));
            }
            (values, _) => {
                *values =
                    Values::Other("it is a number in some messages, and none in others".to_owned())
            }
        }
        Ok(())
    }

    /// Ends a message.
    ///
    /// # Errors
    /// More rows than are read.
    pub(super) fn end(&mut self) -> Result<(), StoreError> {
        self.rows += 1;
        check_rows(self.path, self.rows)
    }

    /// The table of all messages; what a message lacks is missing.
    pub(super) fn table(self) -> Table {
        let rows = self.rows;
        let columns = self.values.into_iter().map(|values| match values {
            Values::Unread => Cells::Unread,
            Values::Other(why) => Cells::Other(why),
            Values::Numbers(mut values) => {
                values.resize(rows, None);
                Cells::Numbers(Float64Array::from(values))
            }
            Values::Whole(mut values) => {
                values.resize(rows, None);
                Cells::whole(values.into_iter())
            }
            Values::Text(mut values) => {
                values.append_nulls(rows - values.len());
                let texts = values.finish();
                debug_assert_eq!(texts.len(), rows);
                Cells::Text(texts)
            }
        });
        let columns = columns.collect();
        let declared = || Declared { unit: "ns".to_owned(), is_type: true };
        let units = self.nanoseconds.iter().map(|place| (*place, declared())).collect();
        Table { names: Some(self.names), columns, units, ..Table::default() }
    }
}
