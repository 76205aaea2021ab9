//! What the jobs of every stage share: where results are, reading and writing tables, separating
//! successes from failures.

use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use zwidth_runner::{JobError, Made, Making, Output, WriteLong};
use zwidth_store::Layout;
use zwidth_tables::{Table, TableError};

/// A job's result: tables as Parquet files, in the order of its outputs.
pub(crate) fn write_tables(
    tables: &[Table],
    making: &Making,
    problems: Vec<String>,
) -> Result<Made, JobError> {
    let outputs = tables
        .iter()
        .zip(making.outputs)
        .map(|(table, path)| table.to_parquet(making.from, path))
        .collect::<Result<Vec<_>, TableError>>()?;
    Ok(Made { problems, ..Made::of(outputs) })
}

/// Tables that stages made, read side by side.
pub(crate) fn read_tables(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    files.par_iter().map(|file| Table::from_parquet(file)).collect()
}

/// Tables that a thread keeps.
const KEPT: usize = 4;

/// A table that many jobs of a run look at: a thread reads each of its contents once. The plant's own
/// is small, but its footer names every trial that it was identified from.
pub(crate) fn read_shared(file: &Path, making: &Making) -> Result<Rc<Table>, TableError> {
    type Cache = VecDeque<(String, Rc<Table>)>;
    thread_local! {
        static CACHE: RefCell<Cache> = const { RefCell::new(VecDeque::new()) };
    }
    // Read once per session instead, it took 3.6 % of the metrics of 150 participants. By hash, not by
    // path: a thread may live through two runs, and the file change in between.
    let hash = making.hash_of(file);
    let cached = CACHE.with_borrow(|cache| {
        cache.iter().find(|(key, _)| Some(key.as_str()) == hash).map(|(_, table)| table.clone())
    });
    if let Some(table) = cached {
        return Ok(table);
    }
    let table = Rc::new(Table::from_parquet(file)?);
    if let Some(hash) = hash {
        CACHE.with_borrow_mut(|cache| {
            cache.push_front((hash.to_owned(), table.clone()));
            cache.truncate(KEPT);
        });
    }
    Ok(table)
}

/// Sessions whose tables are read at a time to be joined: enough for all cores, few enough for memory.
const SESSIONS_AT_ONCE: usize = 64;

/// A long table of the study, the job's only output: what `join` makes of the tables of each session,
/// one after the other. A note of one is a note of the whole.
pub(crate) fn join_sessions<T: Clone + Send + Sync + 'static>(
    sessions: &[Vec<T>],
    join: impl Fn(&[T]) -> Result<Table, JobError> + Send + Sync + 'static,
    making: &Making,
) -> Made {
    // The file is written after the job's function has returned: its writer owns all that it needs.
    let sessions = sessions.to_vec();
    let from = making.from.clone();
    let path = making.outputs.first().cloned().unwrap_or_default();
    let write: WriteLong = Box::new(move |out| {
        let tables = sessions
            .chunks(SESSIONS_AT_ONCE)
            .flat_map(|some| some.par_iter().map(|tables| join(tables)).collect::<Vec<_>>());
        Table::write_parts(tables, &from, &path, out)
    });
    Made { outputs: vec![Output::Long(write)], ..Made::default() }
}

/// The good results, and the bad ones in words.
pub(crate) fn split<T, E: ToString>(results: Vec<Result<T, E>>) -> (Vec<T>, Vec<String>) {
    let mut problems = Vec::new();
    let mut good = Vec::new();
    for result in results {
        match result {
            Ok(value) => good.push(value),
            Err(error) => problems.push(error.to_string()),
        }
    }
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
    use zwidth_runner::{Provenance, Scripts};
    use zwidth_store::Lately;
    use zwidth_tables::Column;

    #[test]
    fn sessions_are_joined_in_their_order_with_each_note_once() {
        let folder = tempfile::tempdir().unwrap();
        let trials = Lately::default();
        let session = |number: usize| {
            let file = folder.path().join(number.to_string());
            let column = Column::integer("trial", "1", "", [Some(number as i64)]);
            let table = Table::new("s", "Sessions", vec![column]).unwrap().with_note("of all");
            let table = if number == 70 { table.with_note("of one") } else { table };
            fs::write(&file, table.to_parquet(&Provenance::new(), &file).unwrap()).unwrap();
            vec![file]
        };
        let sessions: Vec<_> = (0..3 * SESSIONS_AT_ONCE).map(session).collect();
        let (from, outputs) = (Provenance::new(), [folder.path().join("all")]);
        let making = Making {
            from: &from,
            outputs: &outputs,
            root: folder.path(),
            trials: &trials,
            scripts: &Scripts::None,
        };
        let written = |sessions: &[Vec<PathBuf>]| {
            let made =
                join_sessions(sessions, |tables| Ok(Table::from_parquet(&tables[0])?), &making);
            let Some(Output::Long(write)) = made.outputs.into_iter().next() else {
                panic!("it is long")
            };
            let mut bytes = Vec::new();
            write(&mut bytes).map(|()| bytes)
        };
        fs::write(&outputs[0], written(&sessions).unwrap()).unwrap();
        let all = Table::from_parquet(&outputs[0]).unwrap();
        let expect: Vec<_> = (0..sessions.len() as i64).map(Some).collect();
        assert_eq!((all.integers("trial").unwrap(), all.title()), (expect, "Sessions"));
        assert_eq!(all.notes(), ["of all", "of one"]);
        fs::remove_file(&sessions[100][0]).unwrap();
        assert!(written(&sessions).is_err());
    }

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
            let making = Making {
                from: &from,
                outputs: &[],
                root,
                trials: &trials,
                scripts: &Scripts::None,
            };
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
