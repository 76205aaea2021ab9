//! Typed handles: a derived table knows its file and its rows.

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use zwidth_results::Row;
use zwidth_runner::{Inputs, JobError, Made, Making};
use zwidth_study::MetricId;
use zwidth_tables::{Table, TableError};

/// The file in a folder of a table of that name.
pub(crate) fn file_within(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.parquet"))
}

/// A derived table of rows `R`.
pub(crate) struct Derived<R> {
    path: PathBuf,
    // `fn() -> R` instead of `R`: a handle goes to other threads whatever its rows hold.
    rows: PhantomData<fn() -> R>,
}

// Derived, it would ask the rows to be `Clone`.
impl<R> Clone for Derived<R> {
    fn clone(&self) -> Self {
        Self { path: self.path.clone(), rows: PhantomData }
    }
}

impl<R: Row> Derived<R> {
    /// The table in a folder that is named as its rows are.
    pub(crate) fn within(folder: &Path) -> Self {
        Self::at(file_within(folder, R::NAME))
    }

    /// The table at a path of its own, for a subject.
    pub(crate) fn at(path: PathBuf) -> Self {
        Self { path, rows: PhantomData }
    }

    /// Its file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Its rows.
    ///
    /// # Errors
    /// A file that cannot be read, or has other rows.
    pub(crate) fn read(&self) -> Result<Vec<R>, TableError> {
        Table::from_parquet(&self.path)?.to_rows()
    }

    /// Its rows, of a table that has many other columns, which are not read.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(crate) fn read_own_columns(&self) -> Result<Vec<R>, TableError> {
        let fields = R::fields();
        let names: Vec<&str> = fields.iter().map(|field| &*field.name).collect();
        Table::columns_from_parquet(&self.path, &names)?.to_rows()
    }

    /// Its rows, and the notes below them.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(crate) fn read_with_notes(&self) -> Result<(Vec<R>, Vec<String>), TableError> {
        let table = Table::from_parquet(&self.path)?;
        Ok((table.to_rows()?, table.notes().to_vec()))
    }

    /// Its rows, if it was made.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(crate) fn read_if_made(&self) -> Result<Option<Vec<R>>, TableError> {
        self.path.exists().then(|| self.read()).transpose()
    }

    /// Its rows of a metric.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(crate) fn read_of(&self, metric: &MetricId) -> Result<Vec<R>, TableError> {
        let fields = R::fields();
        let names: Vec<&str> = fields.iter().map(|field| &*field.name).collect();
        let is_own = |part: Table| part.with_text("metric", metric.as_str());
        Table::gathered(&self.path, &names, is_own)?.to_rows()
    }

    /// Its rows in parts, for a table of any length.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(crate) fn parts(
        &self,
    ) -> Result<impl Iterator<Item = Result<Vec<R>, TableError>> + use<R>, TableError> {
        Ok(Table::parts(&self.path)?.map(|part| part?.to_rows()))
    }

    /// The notes below its rows.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn notes(&self) -> Result<Vec<String>, TableError> {
        let notes = Table::about(&self.path)?.notes;
        Ok(notes.into_iter().map(|(_, note)| note).collect())
    }
}

impl<R: 'static> Inputs for Derived<R> {
    fn files(&self) -> Vec<PathBuf> {
        vec![self.path.clone()]
    }
}

/// The result of a job that makes these tables: each goes to the output that bears its name. Tables of
/// simulated data are marked.
pub(crate) fn write_named(
    tables: Vec<Table>,
    making: &Making,
    simulated: bool,
) -> Result<Made, JobError> {
    let mut files: Vec<Option<Vec<u8>>> = vec![None; making.outputs.len()];
    for table in tables {
        let place = making
            .outputs
            .iter()
            .position(|path| path.file_stem().is_some_and(|stem| stem == table.name()))
            .ok_or_else(|| format!("the job has no output '{}'", table.name()))?;
        let table = table.with_mark(simulated);
        files[place] = Some(table.to_parquet(making.from, &making.outputs[place])?);
    }
    let all: Option<Vec<Vec<u8>>> = files.into_iter().collect();
    Ok(Made::of(all.ok_or("a table of the job was not made")?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_results::{MetricNote, NoteKind, OrderTest};
    use zwidth_runner::{Output, Provenance, Scripts};
    use zwidth_store::Lately;

    fn note(metric: &str) -> MetricNote {
        MetricNote {
            metric: metric.parse().unwrap(),
            table: "means".to_owned(),
            kind: NoteKind::Care,
            note: "few".into(),
        }
    }

    #[test]
    fn rows_are_written_where_their_handle_reads_them_and_marked_where_simulated() {
        let folder = tempfile::tempdir().unwrap();
        let notes = Derived::<MetricNote>::within(folder.path());
        let orders = Derived::<OrderTest>::within(folder.path());
        let (from, trials) = (Provenance::new(), Lately::default());
        let outputs = [orders.path().to_owned(), notes.path().to_owned()];
        let making = Making {
            from: &from,
            outputs: &outputs,
            root: folder.path(),
            trials: &trials,
            scripts: &Scripts::None,
        };
        let noted = |metrics: &[&str]| -> Table {
            let notes: Vec<_> = metrics.iter().map(|metric| note(metric)).collect();
            Table::of_rows(&notes).unwrap()
        };
        let tables = vec![noted(&["a_n", "b_n"]), Table::of_rows::<OrderTest>(&[]).unwrap()];
        let made = write_named(tables, &making, true).unwrap();
        for (output, path) in made.outputs.into_iter().zip(&outputs) {
            let Output::Whole(bytes) = output else { panic!("it is whole") };
            fs::write(path, bytes).unwrap();
        }
        assert_eq!(notes.read().unwrap(), [note("a_n"), note("b_n")]);
        assert_eq!(notes.read_of(&"b_n".parse().unwrap()).unwrap(), [note("b_n")]);
        assert!(orders.read().unwrap().is_empty());
        let table = Table::from_parquet(notes.path()).unwrap();
        assert_eq!(table.notes(), [zwidth_tables::SYNTHETIC]);
        assert!(write_named(vec![noted(&["a_n"])], &making, false).is_err(), "incomplete");
    }
}
