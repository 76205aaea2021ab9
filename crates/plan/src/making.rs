//! What the jobs of every stage share: where results lie, reading and writing tables, keeping apart
//! what went well and what did not.

use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use zwidth_runner::{JobError, Made, Making, Output};
use zwidth_store::Layout;
use zwidth_tables::{Table, TableError, TableFile};

/// A job's result: tables as Parquet files, in the order of its outputs.
pub(crate) fn write_tables(
    tables: &[Table],
    making: &Making,
    problems: Vec<String>,
) -> Result<Made, JobError> {
    let files = tables.iter().zip(making.outputs);
    let outputs = files
        .map(|(table, path)| table.to_parquet(making.from, path))
        .collect::<Result<Vec<_>, TableError>>()?;
    Ok(Made { problems, ..Made::of(outputs) })
}

/// Tables that stages made, read side by side.
pub(crate) fn read_tables(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    files.par_iter().map(|file| Table::from_parquet(file)).collect()
}

/// Tables of one content that a thread keeps.
const KEPT: usize = 4;

/// A table that many jobs of a run look at: a thread reads each of its contents once. The plant's own
/// is small, but tells of every trial that it was identified from.
pub(crate) fn read_shared(file: &Path, making: &Making) -> Result<Rc<Table>, TableError> {
    type Known = VecDeque<(String, Rc<Table>)>;
    thread_local! {
        static KNOWN: RefCell<Known> = const { RefCell::new(VecDeque::new()) };
    }
    let hash = making.hash_of(file);
    let is_it = |(of, _): &&(String, Rc<Table>)| Some(of.as_str()) == hash;
    let known = KNOWN.with_borrow(|known| known.iter().find(is_it).map(|(_, table)| table.clone()));
    if let Some(table) = known {
        return Ok(table);
    }
    let table = Rc::new(Table::from_parquet(file)?);
    if let Some(hash) = hash {
        KNOWN.with_borrow_mut(|known| {
            known.push_front((hash.to_owned(), table.clone()));
            known.truncate(KEPT);
        });
    }
    Ok(table)
}

/// Tables of one form that are read at a time to be joined.
const JOINED_AT_ONCE: usize = 256;

/// The same as fewer tables, to be joined: a large study has thousands of one form. Titles and notes
/// are left out.
pub(crate) fn read_parts(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    let part = |files: &[PathBuf]| Table::concat("part", "", read_tables(files)?);
    let parts: Result<Vec<_>, TableError> = files.chunks(JOINED_AT_ONCE).map(part).collect();
    Ok(parts?.into_iter().flatten().collect())
}

/// Sessions whose tables are read at a time to be joined.
const SESSIONS_AT_ONCE: usize = 64;

/// A long table of the study: what `join` makes of the tables of each session (nothing where it has
/// none), one after the other. A note of one is a note of the whole.
pub(crate) fn join_sessions(
    sessions: &[Vec<PathBuf>],
    join: impl Fn(&[PathBuf]) -> Result<Option<Table>, JobError> + Send + Sync + 'static,
    making: &Making,
) -> Output {
    let (sessions, from) = (sessions.to_vec(), making.from.clone());
    let path = making.outputs.first().cloned().unwrap_or_default();
    Output::Long(Box::new(move |out| {
        let mut tables = sessions.chunks(SESSIONS_AT_ONCE).flat_map(|some| {
            let read: Vec<_> = some.par_iter().map(|files| join(files)).collect();
            read.into_iter().filter_map(Result::transpose)
        });
        let first = tables.next().ok_or("there is no trial")??;
        let mut about = first.rows(&[]);
        let mut file = TableFile::begin(out, &about, &path)?;
        for table in std::iter::once(Ok(first)).chain(tables) {
            let table = table?;
            about = about.with_notes_of(&table);
            file.add(table)?;
        }
        Ok(file.end(&about, &from)?)
    }))
}

/// The good results, and the bad ones in words.
pub(crate) fn split<T, E: ToString>(results: Vec<Result<T, E>>) -> (Vec<T>, Vec<String>) {
    let mut problems = Vec::new();
    let good = results
        .into_iter()
        .filter_map(|r| r.map_err(|e| problems.push(e.to_string())).ok())
        .collect();
    (good, problems)
}

/// A file under `derived/<study>`.
pub(crate) fn derived(layout: &Layout, name: impl AsRef<Path>) -> PathBuf {
    layout.derived().join(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_runner::Provenance;
    use zwidth_store::Lately;
    use zwidth_tables::Column;

    #[test]
    fn a_shared_table_is_read_once_for_each_of_its_contents() {
        let folder = tempfile::tempdir().unwrap();
        let (root, file, trials) =
            (folder.path(), folder.path().join("plant.parquet"), Lately::default());
        let read = |hash: Option<&str>| {
            let from: Provenance = hash
                .map(|hash| ("input plant.parquet".to_owned(), hash.to_owned()))
                .into_iter()
                .collect();
            let making = Making { from: &from, outputs: &[], root, trials: &trials };
            read_shared(&file, &making)
        };
        let write = |title: &str| {
            let column = Column::text("parameter", "", [Some("mass".to_owned())]);
            let table = Table::new("plant", title, vec![column]).unwrap();
            fs::write(&file, table.to_parquet(&Provenance::new(), &file).unwrap()).unwrap();
        };
        write("first");
        let first = read(Some("1")).unwrap();
        write("second");
        assert!(Rc::ptr_eq(&first, &read(Some("1")).unwrap()));
        assert_eq!(read(Some("2")).unwrap().title(), "second");
        assert_eq!(read(None).unwrap().title(), "second");
        fs::remove_file(&file).unwrap();
        assert!(Rc::ptr_eq(&first, &read(Some("1")).unwrap()));
        assert!(read(Some("3")).is_err());
        assert!(read(None).is_err(), "what tells no hash is not remembered");
    }
}
