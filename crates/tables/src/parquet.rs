//! Derived tables as Parquet files, through the store.

use crate::{Column, Field, NoteKind, Table, TableError, Type, Values};
use arrow::array::{
    Array, ArrayRef, AsArray, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray,
};
use arrow::datatypes::{DataType, Float64Type, Int64Type, Schema, SchemaRef};
use std::collections::{BTreeMap, VecDeque};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{
    PART_ROWS, StoreError, TableParts, TableWriter, described, read_entries, read_parquet,
    write_table,
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
        Ok(write_table(&self.batch(path)?, self.footer(provenance), path)?)
    }

    /// The rows as a record batch: what the file at `path`, which is for errors, has.
    ///
    /// # Errors
    /// None that a table can cause.
    pub fn batch(&self, path: &Path) -> Result<RecordBatch, TableError> {
        let arrays = self.columns().iter().map(|c| array(&c.values)).collect();
        Ok(RecordBatch::try_new(self.schema(), arrays).map_err(|e| defect(path, &e))?)
    }

    fn schema(&self) -> SchemaRef {
        let fields = self.fields().map(|f| {
            let data_type = match f.kind {
                Type::Float => DataType::Float64,
                Type::Integer => DataType::Int64,
                Type::Text => DataType::Utf8,
                Type::Flag => DataType::Boolean,
            };
            // Nullable throughout: any value may be missing.
            described(&f.name, data_type, true, &f.unit, &f.description)
        });
        Arc::new(Schema::new(fields.collect::<Vec<_>>()))
    }

    /// What the file's footer says.
    fn footer(&self, provenance: &BTreeMap<String, String>) -> BTreeMap<String, String> {
        let mut footer = provenance.clone();
        footer.insert(NAME.to_owned(), self.name().to_owned());
        footer.insert(TITLE.to_owned(), self.title().to_owned());
        footer.insert(NOTES.to_owned(), self.notes().join("\n"));
        if self.notes_by_kind().any(|(kind, _)| kind != NoteKind::General) {
            let kinds: Vec<_> = self.notes_by_kind().map(|(kind, _)| kind.as_str()).collect();
            footer.insert(KINDS.to_owned(), kinds.join("\n"));
        }
        footer
    }

    /// What a Parquet file says about its table, without its rows.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn about(path: &Path) -> Result<About, TableError> {
        let (footer, rows) = read_entries(path)?;
        let [name, title] = [NAME, TITLE].map(|key| footer.get(key).cloned().unwrap_or_default());
        Ok(About { name, title, notes: notes(&footer).collect(), rows })
    }

    /// Reads a table from its Parquet file some rows at a time: each part has these, and name, title
    /// and notes. There is at least one.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn parts(
        path: &Path,
    ) -> Result<impl Iterator<Item = Result<Self, TableError>> + use<>, TableError> {
        let mut parts = TableParts::open(path, None)?;
        let path = path.to_owned();
        let footer = of_table(parts.take_footer(), &[NAME, TITLE, NOTES, KINDS]);
        Ok(parts.map(move |batch| Self::back(&path, batch?, &footer)))
    }

    /// Writes the parts of a table, at least one, as one Parquet file: its name and title are the
    /// first's, its notes those of all, each once. In memory are some thousand rows, and a row group
    /// of the file.
    ///
    /// # Errors
    /// Those of the parts; parts whose columns differ; those of `out`.
    pub fn write_parts<E: From<TableError>>(
        mut parts: impl Iterator<Item = Result<Self, E>>,
        provenance: &BTreeMap<String, String>,
        path: &Path,
        out: &mut (dyn Write + Send),
    ) -> Result<(), E> {
        let first = parts.next().ok_or(TableError::NoPart)??;
        let mut about = first.rows(&[]);
        let begun = TableWriter::begin(out, about.schema(), path);
        let mut file = begun.map_err(TableError::from)?;
        let mut pending: Vec<Self> = Vec::new();
        for part in std::iter::once(Ok(first)).chain(parts) {
            let part = part?;
            about.check_like(&part)?;
            about = about.with_notes_of(&part);
            pending.push(part);
            // Encoded by so many rows, however small the parts are that come.
            if pending.iter().map(Self::height).sum::<usize>() >= PART_ROWS {
                Self::add_rows(&mut file, std::mem::take(&mut pending), path)?;
            }
        }
        Self::add_rows(&mut file, pending, path)?;
        Ok(file.end(about.footer(provenance)).map_err(TableError::from)?)
    }

    /// Writes the rows of parts to a file.
    fn add_rows<W: Write + Send>(
        file: &mut TableWriter<W>,
        parts: Vec<Self>,
        path: &Path,
    ) -> Result<(), TableError> {
        // The name and the title are in the footer, which is written last.
        if let Some(rows) = Self::concat("", "", parts)? {
            file.add(&rows.batch(path)?)?;
        }
        Ok(())
    }

    /// Reads a table back from its Parquet file.
    pub fn from_parquet(path: &Path) -> Result<Self, TableError> {
        let (batch, footer) = read_parquet(path)?;
        Self::back(path, batch, &footer)
    }

    /// Reads these columns alone, in the order of the file; a name that the file lacks is ignored.
    pub fn columns_from_parquet(path: &Path, names: &[&str]) -> Result<Self, TableError> {
        Self::joined(path, names, MOST_RESERVED, Ok)
    }

    /// The same, with only the rows of each part that `select` leaves: memory holds no more than
    /// these and one part.
    ///
    /// # Errors
    /// A file that cannot be read; those of `select`.
    pub fn gathered(
        path: &Path,
        names: &[&str],
        select: impl Fn(Self) -> Result<Self, TableError>,
    ) -> Result<Self, TableError> {
        Self::joined(path, names, 0, select)
    }

    /// The same, with room for all rows of the file, up to so many.
    fn joined(
        path: &Path,
        names: &[&str],
        most: usize,
        select: impl Fn(Self) -> Result<Self, TableError>,
    ) -> Result<Self, TableError> {
        let mut parts = TableParts::open(path, Some(names))?;
        // The notes of a long table are long, too: the first part has them.
        let footer = of_table(parts.take_footer(), &[NAME, TITLE, NOTES, KINDS]);
        let room = parts.rows().min(most);
        let first = parts.next().ok_or(TableError::NoPart)??;
        let mut all = select(Self::back(path, first, &footer)?)?;
        // At once: a column that grows by doubling is copied again and again, and held twice
        // meanwhile.
        all.reserve(room.saturating_sub(all.height()));
        let footer = of_table(footer, &[NAME, TITLE]);
        for part in parts {
            all.append(select(Self::back(path, part?, &footer)?)?)?;
        }
        Ok(all)
    }

    fn back(
        path: &Path,
        batch: RecordBatch,
        footer: &BTreeMap<String, String>,
    ) -> Result<Self, TableError> {
        // Each array is gone before the next column is made: a long table is not held twice.
        let (schema, arrays, _) = batch.into_parts();
        let mut columns = Vec::new();
        for (f, a) in schema.fields().iter().zip(arrays) {
            let values = values(&a).ok_or_else(|| {
                let what = format!("its type {} is not one of a table", f.data_type());
                StoreError::new(path, what, "delete derived/ and run again").column(f.name())
            })?;
            let [unit, description] = ["unit", "description"]
                .map(|key| f.metadata().get(key).cloned().unwrap_or_default().into());
            let name = f.name().clone().into();
            let field = Field { name, unit, description, kind: values.kind() };
            columns.push(Column { field, values });
        }
        let [name, title] = [NAME, TITLE].map(|key| footer.get(key).cloned().unwrap_or_default());
        Ok(Self::new(&name, &title, columns)?.with_notes(notes(footer)))
    }
}

/// Rows that there is room for at most before they are read: what a file claims is no reason for more.
const MOST_RESERVED: usize = 1 << 20;

/// Of what a footer says the entries of these names.
fn of_table(footer: BTreeMap<String, String>, names: &[&str]) -> BTreeMap<String, String> {
    footer.into_iter().filter(|(name, _)| names.contains(&name.as_str())).collect()
}

/// What a file says about its table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// Short name: a file's stem.
    pub name: String,
    /// Title, a phrase.
    pub title: String,
    /// Notes, each with its kind.
    pub notes: Vec<(NoteKind, String)>,
    /// Number of rows.
    pub rows: usize,
}

/// The notes that a footer holds.
fn notes(footer: &BTreeMap<String, String>) -> impl Iterator<Item = (NoteKind, String)> {
    let [notes, kinds] =
        [NOTES, KINDS].map(|key| footer.get(key).map(String::as_str).unwrap_or_default().lines());
    let kinds = kinds.map(|word| NoteKind::from_word(word).unwrap_or_default());
    // No kinds are written where all notes are general.
    let kinds = kinds.chain(std::iter::repeat(NoteKind::General));
    notes.map(str::to_owned).zip(kinds).map(|(note, kind)| (kind, note))
}

fn defect(path: &Path, e: &arrow::error::ArrowError) -> StoreError {
    StoreError::new(path, e.to_string(), "this is a defect of zwidth; please report it")
}

fn array(values: &Values) -> ArrayRef {
    match values {
        Values::Float(v) => Arc::new(v.iter().collect::<Float64Array>()),
        Values::Integer(v) => Arc::new(v.iter().collect::<Int64Array>()),
        Values::Text(v) => Arc::new(v.iter().map(Option::as_deref).collect::<StringArray>()),
        Values::Flag(v) => Arc::new(v.iter().collect::<BooleanArray>()),
    }
}

/// Texts that are remembered while others are read: of a few that come in turns each is kept once.
const RECENT_TEXTS: usize = 8;

/// Texts, of which those that came a short while ago are kept once.
fn texts<'a>(values: impl Iterator<Item = Option<&'a str>>) -> Vec<Option<Arc<str>>> {
    let mut recent: VecDeque<Arc<str>> = VecDeque::new();
    let texts = values.map(|value| {
        let value = value?;
        let earlier = recent.iter().find(|text| ***text == *value).cloned();
        Some(earlier.unwrap_or_else(|| {
            let new: Arc<str> = value.into();
            recent.truncate(RECENT_TEXTS - 1);
            recent.push_front(new.clone());
            new
        }))
    });
    texts.collect()
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
    use crate::write_csv;

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
        let about = Table::about(&path).unwrap();
        let kinds = kinds.map(|(kind, note)| (kind, note.to_owned())).to_vec();
        assert_eq!(
            about,
            About { name: "t".to_owned(), title: "Title".to_owned(), notes: kinds, rows: 2 }
        );
    }

    #[test]
    fn a_table_of_any_length_is_written_and_read_back_in_parts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        let long = PART_ROWS + PART_ROWS / 2;
        for rows in [0, 1, PART_ROWS, long] {
            let table = |rows: std::ops::Range<usize>| {
                let text = rows.clone().map(|row| Some(format!("{}", row % 7)));
                let number = rows.map(|row| Some(row as f64));
                let columns =
                    vec![Column::text("mode", "", text), Column::float("force_n", "N", "", number)];
                Table::new("t", "Title", columns).unwrap().with_note("a note")
            };
            let mut bytes = Vec::new();
            let starts = (0..rows.max(1)).step_by(PART_ROWS / 4);
            let parts = starts.map(|from| Ok(table(from..rows.min(from + PART_ROWS / 4))));
            let none = BTreeMap::new();
            Table::write_parts::<TableError>(parts, &none, &path, &mut bytes).unwrap();
            let all = table(0..rows);
            assert!(bytes == all.to_parquet(&BTreeMap::new(), &path).unwrap(), "{rows} rows");
            std::fs::write(&path, bytes).unwrap();
            let parts: Vec<Table> = Table::parts(&path).unwrap().map(Result::unwrap).collect();
            assert_eq!(parts.len(), rows.div_ceil(PART_ROWS).max(1));
            assert!(
                parts.iter().all(|part| part.height() <= PART_ROWS && part.notes() == ["a note"])
            );
            let back = Table::concat("t", "Title", parts).unwrap().unwrap();
            assert_eq!(back.columns(), all.columns());
            let force = Table::columns_from_parquet(&path, &["force_n", "no such"]).unwrap();
            assert_eq!((force.columns(), force.notes()), (&all.columns()[1..], all.notes()));
            let threes = |table: &Table| {
                let is_three =
                    |(row, mode): (usize, Option<&str>)| (mode == Some("3")).then_some(row);
                table.words("mode").unwrap().enumerate().filter_map(is_three).collect::<Vec<_>>()
            };
            let some = |part: Table| Ok(part.rows(&threes(&part)));
            let some = Table::gathered(&path, &["mode", "force_n"], some).unwrap();
            assert_eq!(some.columns(), all.rows(&threes(&all)).columns());
        }
        let parts = || Table::parts(&path).unwrap();
        let mut text = Vec::new();
        write_csv(parts(), &mut text).unwrap();
        let all = Table::from_parquet(&path).unwrap();
        assert!(text == crate::csv(&all).into_bytes());
        let other = Table::new("u", "", vec![Column::flag("no", "", [None])]).unwrap();
        let unlike = parts().chain([Ok(other)]);
        let written = |parts: &mut dyn Iterator<Item = Result<Table, TableError>>| {
            Table::write_parts(parts, &BTreeMap::new(), &path, &mut Vec::new())
        };
        let error = written(&mut unlike.into_iter()).unwrap_err();
        assert!(error.to_string().contains("has other columns than"), "{error}");
        assert!(matches!(written(&mut std::iter::empty()), Err(TableError::NoPart)));
    }
}
