//! Writes data that are too long for memory, above all a long trial, row group by row group: beside
//! their final place, and published whole, or not at all.

use crate::disk::atomic::{create_folders, folder_of, place, temporary};
use crate::form::digest::ColumnDigest;
use crate::form::encode::{GROUP_ROWS, recorded};
use crate::form::groups::Groups;
use crate::form::read::OpenColumns;
use crate::form::seen::Signals;
use crate::form::trial::backwards;
use crate::form::write::{DIGEST, cannot_encode, entries, footer, stored, trial_batch};
use crate::{Append, Asked, Files, Samples, Signal, StoreError, TrialFile, check_samples};
use arrow::array::ArrayRef;
use arrow::datatypes::SchemaRef;
use rayon::prelude::*;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use zwidth_study::{TrialForm, TrialMeta};

/// Bytes that are synced at a time.
const SYNCED_AT_ONCE: usize = 1 << 23;

/// Writes a trial's file of a form, a row group at a time.
pub struct TrialWriter {
    /// Where it will lie, for errors.
    path: PathBuf,
    beside: PathBuf,
    groups: Groups<Out>,
    schema: SchemaRef,
    meta: TrialMeta,
    file: TrialFile,
    form: TrialForm,
    /// The trial's columns that have values: all row groups have the same ones.
    columns: Vec<Written>,
    rows: usize,
    last_s: Option<f64>,
}

/// A column with values.
struct Written {
    name: String,
    /// Its place in the file.
    place: usize,
    digest: ColumnDigest,
}

/// A trial that is written and synced, under a name that readers pass by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Staged {
    beside: PathBuf,
    /// BLAKE3 of the file, hexadecimal.
    pub blake3: String,
}

impl TrialWriter {
    /// Rows that are best given at a time: row groups are longer, and grow encoded.
    pub const AT_ONCE: usize = 1 << 16;

    /// Begins the file of a trial whose final place is `path`; it is written beside `near`, a file
    /// in an existing folder of the same disk.
    ///
    /// # Errors
    /// The disk's.
    pub fn begin(
        files: &dyn Files,
        near: &Path,
        path: &Path,
        meta: TrialMeta,
        file: TrialFile,
        form: &TrialForm,
    ) -> Result<Self, StoreError> {
        let beside = temporary(near);
        // Without values but times, in place of which others are added.
        let mut rows = Samples::default();
        rows.set(Signal::Time, vec![0.0; Self::AT_ONCE]);
        let rows = trial_batch(&meta, &rows, form, path)?;
        let schema = rows.schema();
        // The entries of the footer are known at the end: the digests are among them.
        let properties =
            recorded(&schema, Vec::new(), Some(GROUP_ROWS)).map_err(|e| cannot_encode(path, &e))?;
        let out = Out::begin(files, &beside).map_err(|e| StoreError::io(path, "write", &e))?;
        let groups = Groups::begin(out, rows, properties, GROUP_ROWS)
            .map_err(|e| cannot_encode(path, &e))?;
        Ok(Self {
            path: path.to_owned(),
            beside,
            groups,
            schema,
            meta,
            file,
            form: form.clone(),
            columns: Vec::new(),
            rows: 0,
            last_s: None,
        })
    }

    /// Adds the next rows: [`TrialWriter::AT_ONCE`] of them, or the remaining ones.
    ///
    /// # Errors
    /// Samples that break a promise of the schema, with column and row of the whole trial; columns
    /// that the rows before did not have; the disk's.
    pub fn add(&mut self, samples: &Samples) -> Result<(), StoreError> {
        let before = self.rows;
        // Rows are counted from the trial's beginning.
        samples
            .check(&self.path)
            .map_err(|error| StoreError { row: error.row.map(|row| row + before), ..error })?;
        samples.check_form(&self.form, &self.path)?;
        let t = samples.get(Signal::Time).unwrap_or_default();
        if let (Some(last_s), Some(first_s)) = (self.last_s, t.first().filter(|_| before > 0))
            && *first_s <= last_s
        {
            return Err(backwards(&self.path, last_s, *first_s).row0(before));
        }
        self.last_s = t.last().copied();
        let named: Vec<_> = samples.named().collect();
        if before == 0 {
            let columns = named.iter().map(|(name, storage, _)| {
                let place = self.schema.index_of(name);
                let place = place.map_err(|e| cannot_encode(&self.path, &e.into()))?;
                let digest = ColumnDigest::new(*storage);
                Ok(Written { name: (*name).to_owned(), place, digest })
            });
            self.columns = columns.collect::<Result<_, StoreError>>()?;
        }
        let known = self.columns.iter().map(|column| column.name.as_str());
        if !known.eq(named.iter().map(|(name, ..)| *name)) {
            let what = "some of its rows have other columns than the rest";
            return Err(StoreError::new(&self.path, what, "leave that column out"));
        }
        let columns = self.columns.par_iter_mut().zip(&named);
        let columns: Vec<(usize, ArrayRef)> = columns
            .map(|(column, (_, storage, values))| {
                column.digest.add(values);
                (column.place, stored(values, *storage))
            })
            .collect();
        self.rows += samples.len();
        let written = self.groups.add(&columns, samples.len());
        written.map_err(|e| self.groups.out().error(&self.path, &e))
    }

    /// Adds an entry to the file's footer.
    pub fn note(&mut self, key: &str, value: String) {
        self.file.insert(key.to_owned(), value);
    }

    /// Removes what was written; the next import removes what could not be removed now.
    pub fn discard(self, files: &dyn Files) {
        // The file is closed first: an open one stays on some systems.
        let beside = self.beside.clone();
        drop(self);
        let _ = files.remove(&beside);
    }

    /// Ends the file: it is whole and synced, and not in its place yet.
    ///
    /// # Errors
    /// The disk's.
    pub fn end(mut self) -> Result<Staged, StoreError> {
        let mut footer = footer(&self.meta, &self.file, &self.form);
        let digests = self.columns.iter();
        footer.extend(digests.map(|c| (format!("{DIGEST}{}", c.name), c.digest.end())));
        let written = self.groups.end(entries(&self.schema, footer));
        written.map_err(|e| self.groups.out().error(&self.path, &e))?;
        let out = self.groups.out();
        out.sync().map_err(|e| StoreError::io(&self.path, "write", &e))?;
        Ok(Staged { beside: self.beside, blake3: out.hasher.finalize().to_hex().to_string() })
    }
}

impl Staged {
    /// What its samples say against their trial, as [`crate::check_samples`] finds it; no more than
    /// two columns are in memory at a time.
    ///
    /// # Errors
    /// It cannot be read again.
    pub fn check(
        &self,
        files: &dyn Files,
        expected: &Asked,
    ) -> Result<Vec<StoreError>, StoreError> {
        let mut columns = OpenColumns::open(files, &self.beside)?;
        // They were digested as they were written.
        columns.matched = Signals::of(&Signal::all().collect::<Vec<_>>());
        Ok(check_samples(expected, Path::new(""), &columns))
    }

    /// Gives the trial its place.
    ///
    /// # Errors
    /// The disk's.
    pub fn publish(&self, files: &dyn Files, path: &Path) -> Result<(), StoreError> {
        let folder = folder_of(path);
        create_folders(files, folder)
            .map_err(|e| StoreError::io(folder, "create the folder", &e))?;
        files
            .rename(&self.beside, path)
            .and_then(|()| files.sync_folder(folder))
            .map_err(|e| StoreError::io(path, "write", &e))
    }

    /// Removes what was written, if it is not in its place; the next import removes what could not
    /// be removed now.
    pub fn discard(&self, files: &dyn Files) {
        if files.kind(&self.beside).is_some() {
            let _ = files.remove(&self.beside);
        }
    }
}

/// Writes a file as a whole, as [`crate::replace`] does, but a part at a time: what `write` puts
/// into it is never in memory whole. Gives its BLAKE3, hexadecimal; or the error of `write`, after
/// which what stood there before still does.
///
/// # Errors
/// Those of [`crate::replace`].
pub fn replace_by<E>(
    files: &dyn Files,
    path: &Path,
    write: impl FnOnce(&mut (dyn Write + Send)) -> Result<(), E>,
) -> Result<Result<String, E>, StoreError> {
    let folder = folder_of(path);
    create_folders(files, folder).map_err(|e| StoreError::io(folder, "create the folder", &e))?;
    let mut blake3 = String::new();
    let mut own = None;
    let placed = place(files, path, |beside| {
        let mut out = Out::begin(files, beside)?;
        own = write(&mut out).err();
        // What the disk refused is that, whatever `write` makes of it.
        if let Some(disk) = out.failed.take() {
            own = None;
            return Err(disk);
        }
        if own.is_some() {
            return Err(io::ErrorKind::Other.into());
        }
        out.sync()?;
        blake3 = out.hasher.finalize().to_hex().to_string();
        Ok(())
    });
    match (placed, own) {
        (Err(_), Some(error)) => Ok(Err(error)),
        (placed, _) => placed.map(|()| Ok(blake3)),
    }
}

/// A file that is written and hashed as it grows.
pub(super) struct Out {
    file: Box<dyn Append>,
    pending: Vec<u8>,
    hasher: blake3::Hasher,
    /// Why it could not be written, once it could not.
    pub(super) failed: Option<io::Error>,
}

impl Out {
    /// A new file; what an earlier write of this name left is removed.
    pub(super) fn begin(files: &dyn Files, path: &Path) -> io::Result<Self> {
        if files.kind(path).is_some() {
            files.remove(path)?;
        }
        let file = files.open_append(path)?;
        Ok(Self { file, pending: Vec::new(), hasher: blake3::Hasher::new(), failed: None })
    }

    pub(super) fn sync(&mut self) -> io::Result<()> {
        self.file.append_synced(&self.pending)?;
        self.hasher.update(&self.pending);
        self.pending.clear();
        Ok(())
    }

    /// The disk's error where that was it, else the encoder's.
    fn error(&mut self, path: &Path, encoder: &parquet::errors::ParquetError) -> StoreError {
        match self.failed.take() {
            Some(disk) => StoreError::io(path, "write", &disk),
            None => cannot_encode(path, encoder),
        }
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // A record of a large study has megabytes: no more than there is room for.
        let bytes = &bytes[..bytes.len().min(SYNCED_AT_ONCE - self.pending.len())];
        self.pending.extend_from_slice(bytes);
        if self.pending.len() >= SYNCED_AT_ONCE
            && let Err(error) = self.sync()
        {
            let kind = error.kind();
            self.failed = Some(error);
            return Err(kind.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::read::tests::{sample_trial, written};
    use crate::tests::faulty::Faulty;
    use crate::{Layout, RealFiles, Trial, read_footer, read_trial};

    fn part(trial: &Trial, rows: std::ops::Range<usize>) -> Samples {
        let mut part = Samples::default();
        for signal in Signal::all() {
            if let Some(values) = trial.samples.get(signal) {
                part.set(signal, values[rows.clone()].to_vec());
            }
        }
        part
    }

    fn begun(folder: &Path, trial: &Trial) -> (TrialWriter, PathBuf) {
        let layout = Layout::new(folder, "demo".parse().unwrap());
        std::fs::create_dir_all(layout.raw()).unwrap();
        let path = layout.trial(&trial.meta.participant, &trial.meta.session, trial.meta.trial);
        let form = TrialForm { likert: true, ..TrialForm::default() };
        let near = layout.raw().join("trial.parquet");
        let (meta, file) = (trial.meta.clone(), trial.file.clone());
        (TrialWriter::begin(&RealFiles, &near, &path, meta, file, &form).unwrap(), path)
    }

    #[test]
    fn a_trial_written_in_parts_is_the_trial_written_whole() {
        let folder = tempfile::tempdir().unwrap();
        let trial = sample_trial();
        let (mut writer, path) = begun(folder.path(), &trial);
        writer.add(&part(&trial, 0..150)).unwrap();
        writer.add(&part(&trial, 150..200)).unwrap();
        let staged = writer.end().unwrap();
        assert!(!path.exists() && crate::is_unfinished(&staged.beside));
        assert_eq!(crate::file_blake3(&staged.beside).unwrap(), staged.blake3);
        staged.publish(&RealFiles, &path).unwrap();
        // As it comes back from a file: some columns are stored in 32 bits.
        let (_folder, _, whole) = written();
        let [found, expect] =
            [path.as_path(), &whole].map(|p| read_trial(p, Signal::all()).unwrap());
        assert_eq!(found, expect);
        let footer = read_footer(&path).unwrap();
        assert_eq!((footer.rows, footer.blake3), (200, staged.blake3));
    }

    #[test]
    fn a_file_written_in_parts_stands_whole_or_the_one_before_it_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new").join("records");
        let part = vec![b'x'; SYNCED_AT_ONCE / 2 + 1];
        let five = |out: &mut (dyn Write + Send)| (0..5).try_for_each(|_| out.write_all(&part));
        let blake3 = replace_by(&RealFiles, &path, five).unwrap().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), part.repeat(5));
        assert_eq!(blake3, crate::file_blake3(&path).unwrap());
        let cut = replace_by(&RealFiles, &path, |out| {
            out.write_all(&part.repeat(3)).map_err(|e| e.to_string())?;
            Err("no more".to_owned())
        });
        assert_eq!(cut.unwrap(), Err("no more".to_owned()));
        // A disk that is full is that, whatever is said of it.
        let full = replace_by(&Faulty::at(1), &path, |out| {
            out.write_all(&part.repeat(3)).map_err(|_| "something else")
        });
        assert!(full.unwrap_err().remedy.contains("free some space"));
        assert_eq!(std::fs::read(&path).unwrap().len(), part.len() * 5);
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn what_breaks_a_promise_is_told_with_the_row_of_the_whole_trial_and_can_be_taken_back() {
        let folder = tempfile::tempdir().unwrap();
        let trial = sample_trial();
        let (mut writer, _) = begun(folder.path(), &trial);
        writer.add(&part(&trial, 0..150)).unwrap();
        let error = writer.add(&part(&trial, 100..200)).unwrap_err();
        assert!(error.row == Some(151) && error.what.contains("runs backwards"), "{error}");
        let mut bad = part(&trial, 150..200);
        bad.set(Signal::Theta, vec![f64::NAN; 50]);
        let error = writer.add(&bad).unwrap_err();
        assert!(error.row == Some(151) && error.column.as_deref() == Some("theta_rad"), "{error}");
        let mut fewer = Samples::default();
        fewer.set(Signal::Time, vec![1e3]);
        assert!(writer.add(&fewer).unwrap_err().what.contains("other columns"));
    }
}
