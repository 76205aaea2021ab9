//! A label's word in a row of a recording, and what it becomes.

use super::label::{From, Label};
use super::recording::Recording;
use zwidth_store::StoreError;

impl Label {
    /// The label of the rows that begin with `row`, as the value that `parse` makes of it.
    ///
    /// # Errors
    /// No value there, no translation for it, or what `parse` says of it, with file, column and
    /// row.
    pub(super) fn value<T>(
        &self,
        what: &str,
        recording: &Recording,
        row: usize,
        parse: impl FnOnce(&str) -> Result<T, String>,
    ) -> Result<T, StoreError> {
        let theirs = self.word(recording, row)?;
        let ours = match theirs.as_str() {
            "" => Err(format!("there is no {what}")),
            theirs => self.ours(theirs),
        };
        ours.and_then(|ours| parse(&ours)).map_err(|problem| {
            let remedy = format!("mend the value, or change {what} in the mapping");
            match self.column().map(|c| recording.find(c)) {
                Some(Ok(column)) => recording.cell_error(column, row, &problem, &remedy),
                _ => recording.error(problem, remedy),
            }
        })
    }

    /// Their word, as the recording has it.
    ///
    /// # Errors
    /// No such column, or no such group in the path.
    pub(super) fn word(&self, recording: &Recording, row: usize) -> Result<String, StoreError> {
        match &self.from {
            From::Fixed(text) => Ok(text.clone()),
            From::Name(group) => recording.group(group),
            From::Column(column) => Ok(recording.cell(column, row)?.to_string()),
        }
    }

    /// Whether the comma stands before decimals in their word: not in a number of a workbook, nor in
    /// a word of the mapping.
    ///
    /// # Errors
    /// No such column.
    pub(super) fn has_decimal_comma(
        &self,
        recording: &Recording,
        row: usize,
    ) -> Result<bool, StoreError> {
        let Some(column) = self.column().filter(|_| self.translate.is_empty()) else {
            return Ok(false);
        };
        Ok(recording.has_decimal_comma(recording.find(column)?, row))
    }
}
