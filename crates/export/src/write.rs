//! The order in which an export is written: data, what describes them, and last the checksums of all.

use crate::contents::{Contents, Described, described};
use crate::data_package::{Resource, data_package};
use crate::dictionary::{Entry, dictionary};
use crate::folder::{Folder, Written};
use crate::readme::readme;
use crate::ro_crate::{check_licence, ro_crate};
use crate::{
    Asked, Codes, ExportError, Format, Origin, bids, citation, mapping, mat, mcap, samples,
};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{Files, NewFolder, keep_private, write_new};
use zwidth_tables::csv;

/// A file that is written elsewhere and goes with the others.
pub struct Beside {
    /// Its path in the export.
    pub path: String,
    /// What it is, a phrase.
    pub about: String,
    /// What it holds.
    pub bytes: Vec<u8>,
}

/// The file that keeps which code is whose.
pub struct Key<'a> {
    /// Where it is written; nothing is there yet.
    pub path: &'a Path,
    /// What it keeps.
    pub codes: &'a Codes,
}

/// Writes an export into the folder `to`, which is not there yet, and its key: both are complete, or
/// absent.
///
/// # Errors
/// A recording that cannot be read; what a form cannot hold; the disk's.
pub fn write(
    files: &dyn Files,
    to: &Path,
    key: Option<&Key>,
    contents: &Contents,
    asked: &Asked,
    beside: &[Beside],
) -> Result<Vec<Written>, ExportError> {
    let Some(Key { path, codes }) = key else {
        return write_folder(files, to, contents, asked, beside);
    };
    // First: codes without their key would be nobody's for ever.
    write_new(files, path, codes.key().as_bytes())?;
    let private = keep_private(files, path).map_err(ExportError::from);
    let written = private.and_then(|()| write_folder(files, to, contents, asked, beside));
    if written.is_err() {
        // The first error is the one to report; a key that stays is told when it is named again.
        let _ = files.remove(path);
    }
    written
}

fn write_folder(
    files: &dyn Files,
    to: &Path,
    contents: &Contents,
    asked: &Asked,
    beside: &[Beside],
) -> Result<Vec<Written>, ExportError> {
    let mut folder = Folder::new(Some(NewFolder::begin(files, to)?));
    match fill(&mut folder, contents, asked, beside) {
        Ok(()) => folder.publish(),
        Err(error) => {
            folder.discard();
            Err(error)
        }
    }
}

/// The files that [`write()`] would write.
///
/// # Errors
/// What a form cannot hold.
pub fn planned(
    contents: &Contents,
    asked: &Asked,
    beside: &[Beside],
) -> Result<Vec<Written>, ExportError> {
    let mut folder = Folder::new(None);
    fill(&mut folder, contents, asked, beside)?;
    folder.publish()
}

fn fill(
    folder: &mut Folder,
    contents: &Contents,
    asked: &Asked,
    beside: &[Beside],
) -> Result<(), ExportError> {
    asked.licence.as_deref().map(check_licence).transpose()?;
    let mut resources = Vec::new();
    for own in &contents.tables {
        resources.push(write_table(folder, own, contents, &asked.software)?);
    }
    let with = |format: Format| asked.formats.contains(&format);
    if !contents.trials.is_empty() {
        let columns = contents.sample_columns()?;
        samples::write_parquet(folder, contents, &asked.software)?;
        resources.push(samples_resource("samples", samples::PARQUET, &columns));
        if with(Format::SamplesCsv) {
            samples::write_csv(folder, contents)?;
            resources.push(samples_resource("samples_csv", samples::CSV, &columns));
        }
    }
    if with(Format::Mat) {
        mat::write(folder, contents)?;
    }
    if with(Format::Mcap) {
        mcap::write(folder, contents, &asked.software)?;
    }
    if with(Format::Bids) {
        bids::write(folder, contents, asked)?;
    }
    for Beside { path, about, bytes } in beside {
        folder.write(path, about, |out| Ok(out.write_all(bytes)?))?;
    }
    for (path, text) in mapping::mappings(contents, &asked.formats)? {
        folder.text(path, "how zwidth import reads the samples back", &text)?;
    }
    if let Some(people) = &contents.people {
        folder.text(
            "import/participants.csv",
            "what is known of people, as zwidth reads it",
            people,
        )?;
    }
    folder.text("study.toml", "what was planned", &contents.study_toml)?;
    let entries: Vec<Entry> = resources
        .iter()
        .filter(|resource| resource.path != samples::CSV)
        .map(|resource| Entry { table: &resource.name, columns: &resource.columns })
        .collect();
    let text = dictionary(&entries)?;
    folder.text("dictionary.csv", "type, unit and definition of each column", &text)?;
    folder.text("CITATION.cff", "how to cite", &citation::citation(contents, asked))?;
    folder.text("LICENCE", "the licence", &citation::licence(asked))?;
    folder.text("README.md", "what to read first", &readme(contents, asked, &resources))?;
    let package = data_package(contents, asked, &resources, folder);
    folder.json("datapackage.json", "the tables as a Data Package", &package)?;
    let all = ro_crate(contents, asked, &folder.files);
    folder.json("ro-crate-metadata.json", "all files as an RO-Crate", &all)?;
    let sums = folder.files.iter().map(|file| format!("{}  {}\n", file.sha256, file.path));
    let sums: String = sums.collect();
    folder.text("SHA256SUMS", "checksums of all other files, for sha256sum -c", &sums)
}

/// A table as CSV and Parquet.
fn write_table(
    folder: &mut Folder,
    own: &Origin,
    contents: &Contents,
    software: &str,
) -> Result<Resource, ExportError> {
    let table = &own.table;
    let [path, parquet] =
        ["csv", "parquet"].map(|extension| format!("tables/{}.{extension}", table.name()));
    // The column `source` says it: in CSV the note would be a column more.
    folder.text(&path, table.title(), &csv(table))?;
    let marked = table.clone().with_mark(contents.is_simulated);
    let mut footer = BTreeMap::from([("software".to_owned(), software.to_owned())]);
    footer.extend(own.origin.clone().map(|origin| ("origin".to_owned(), origin)));
    let bytes = marked.to_parquet(&footer, Path::new(&parquet))?;
    folder.write(&parquet, table.title(), |out| Ok(out.write_all(&bytes)?))?;
    let (name, title) = (table.name().to_owned(), table.title().to_owned());
    Ok(Resource { name, title, path, columns: described(table) })
}

fn samples_resource(name: &str, path: &str, columns: &[Described]) -> Resource {
    let (name, path) = (name.to_owned(), path.to_owned());
    Resource { name, title: "Samples of all trials".to_owned(), path, columns: columns.to_vec() }
}
