//! Derived tables as Parquet files, through the store.

use crate::{Column, Field, NoteKind, Table, TableError, Type, Values};
use arrow::array::{
    Array, ArrayRef, AsArray, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray,
};
use arrow::datatypes::{DataType, Float64Type, Int64Type, Schema};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{
    StoreError, described, read_entries, read_parquet, read_parquet_columns, write_table,
};

const NAME: &str = "table_name";
const TITLE: &str = "table_title";
const NOTES: &str = "table_notes";
/// The kinds of the notes, if any of them is not a general note.
const KINDS: &str = "table_note_kinds";

impl Table {
    /// The bytes of the table's Parquet file: SI units, units and meanings in the field metadata,
    /// `provenance` in the footer.
    pub fn to_parquet(
        &self,
        provenance: &BTreeMap<String, String>,
        path: &Path,
    ) -> Result<Vec<u8>, TableError> {
        let columns = self.columns();
        let fields: Vec<_> = columns.iter().map(|c| arrow_field(&c.field)).collect();
        let arrays = columns.iter().map(|c| array(&c.values)).collect();
        let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
            .map_err(|e| defect(path, &e))?;
        let mut footer = provenance.clone();
        footer.insert(NAME.to_owned(), self.name().to_owned());
        footer.insert(TITLE.to_owned(), self.title().to_owned());
        footer.insert(NOTES.to_owned(), self.notes().join("\n"));
        if self.notes_by_kind().any(|(kind, _)| kind != NoteKind::General) {
            let kinds: Vec<_> = self.notes_by_kind().map(|(kind, _)| kind.word()).collect();
            footer.insert(KINDS.to_owned(), kinds.join("\n"));
        }
        Ok(write_table(&batch, footer, path)?)
    }

    /// What a Parquet file says of its table, without its rows.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn title_and_notes(path: &Path) -> Result<(String, Vec<(NoteKind, String)>), TableError> {
        let footer = read_entries(path)?;
        let title = footer.get(TITLE).cloned().unwrap_or_default();
        Ok((title, notes(&footer).collect()))
    }

    /// Reads a table back from its Parquet file.
    pub fn from_parquet(path: &Path) -> Result<Self, TableError> {
        Self::back(path, read_parquet(path)?)
    }

    /// Reads these columns alone, in the order of the file; a name that the file lacks is ignored.
    pub fn columns_from_parquet(path: &Path, names: &[&str]) -> Result<Self, TableError> {
        Self::back(path, read_parquet_columns(path, names)?)
    }

    fn back(
        path: &Path,
        (batch, footer): (RecordBatch, BTreeMap<String, String>),
    ) -> Result<Self, TableError> {
        let text = |key: &str| footer.get(key).cloned().unwrap_or_default();
        // Each array is gone before the next column is made: a long table is not held twice.
        let (schema, arrays, _) = batch.into_parts();
        let columns = schema
            .fields()
            .iter()
            .zip(arrays)
            .map(|(f, a)| {
                let values = values(&a).ok_or_else(|| {
                    let what = format!("its type {} is not one of a table", f.data_type());
                    StoreError::new(path, what, "delete derived/ and run again").column(f.name())
                })?;
                let meta = |key: &str| f.metadata().get(key).cloned().unwrap_or_default();
                let (unit, description) = (meta("unit").into(), meta("description").into());
                let kind = kind_of(&values);
                Ok(Column {
                    field: Field { name: f.name().clone().into(), unit, description, kind },
                    values,
                })
            })
            .collect::<Result<Vec<_>, StoreError>>()?;
        let table = Self::new(&text(NAME), &text(TITLE), columns)?;
        Ok(notes(&footer).fold(table, |table, (kind, note)| table.with_note_of(kind, note)))
    }
}

/// The notes that a footer holds.
fn notes(footer: &BTreeMap<String, String>) -> impl Iterator<Item = (NoteKind, String)> {
    let lines = |key: &str| footer.get(key).map(String::as_str).unwrap_or_default().lines();
    let kinds = lines(KINDS).map(|word| NoteKind::from_word(word).unwrap_or_default());
    // No kinds are written where all notes are general.
    let kinds = kinds.chain(std::iter::repeat(NoteKind::General));
    lines(NOTES).map(str::to_owned).zip(kinds).map(|(note, kind)| (kind, note))
}

fn defect(path: &Path, e: &arrow::error::ArrowError) -> StoreError {
    StoreError::new(path, e.to_string(), "this is a defect of zwidth; please report it")
}

fn arrow_field(f: &Field) -> arrow::datatypes::Field {
    let data_type = match f.kind {
        Type::Float => DataType::Float64,
        Type::Integer => DataType::Int64,
        Type::Text => DataType::Utf8,
        Type::Flag => DataType::Boolean,
    };
    described(&f.name, data_type, true, &f.unit, &f.description)
}

fn array(values: &Values) -> ArrayRef {
    match values {
        Values::Float(v) => Arc::new(v.iter().collect::<Float64Array>()),
        Values::Integer(v) => Arc::new(v.iter().collect::<Int64Array>()),
        Values::Text(v) => Arc::new(v.iter().map(Option::as_deref).collect::<StringArray>()),
        Values::Flag(v) => Arc::new(v.iter().collect::<BooleanArray>()),
    }
}

fn kind_of(values: &Values) -> Type {
    match values {
        Values::Float(_) => Type::Float,
        Values::Integer(_) => Type::Integer,
        Values::Text(_) => Type::Text,
        Values::Flag(_) => Type::Flag,
    }
}

/// Texts, of which those that are the same one after the other are kept once.
fn texts<'a>(values: impl Iterator<Item = Option<&'a str>>) -> Vec<Option<Arc<str>>> {
    let mut last: Arc<str> = Arc::from("");
    let kept = values.map(|value| {
        let value = value?;
        if *last != *value {
            last = Arc::from(value);
        }
        Some(last.clone())
    });
    kept.collect()
}

fn values(a: &ArrayRef) -> Option<Values> {
    Some(match a.data_type() {
        DataType::Float64 => Values::Float(a.as_primitive::<Float64Type>().iter().collect()),
        DataType::Int64 => Values::Integer(a.as_primitive::<Int64Type>().iter().collect()),
        DataType::Utf8 => Values::Text(texts(a.as_string::<i32>().iter())),
        DataType::Boolean => Values::Flag(a.as_boolean().iter().collect()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_survives_parquet_with_units_titles_and_nulls() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        let columns = vec![
            Column::text("mode", "the mode", [Some("a".to_owned()), None]),
            Column::float("force_n", "N", "a force", [None, Some(2.0)]),
            Column::integer("trial", "1", "number", [Some(1), Some(2)]),
            Column::flag("wall_reached", "whether", [Some(true), None]),
        ];
        let table = Table::new("t", "Title", columns).unwrap().with_note("a note");
        let table = table.with_note_of(NoteKind::Extent, "it ends");
        let bytes = table.to_parquet(&BTreeMap::new(), &path).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let again = Table::from_parquet(&path).unwrap();
        assert_eq!(again.columns(), table.columns());
        assert_eq!((again.title(), again.notes()), ("Title", table.notes()));
        let kinds = [(NoteKind::General, "a note"), (NoteKind::Extent, "it ends")];
        assert_eq!(again.notes_by_kind().collect::<Vec<_>>(), kinds);
        let some = Table::columns_from_parquet(&path, &["trial", "mode"]).unwrap();
        assert_eq!(some.columns(), [table.columns()[0].clone(), table.columns()[2].clone()]);
        let about = Table::title_and_notes(&path).unwrap();
        let kinds = kinds.map(|(kind, note)| (kind, note.to_owned())).to_vec();
        assert_eq!(about, ("Title".to_owned(), kinds));
    }
}
