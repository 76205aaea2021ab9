//! Copies of a study's trials with one file for each participant, a row group for each trial: what a
//! study of small files would become if it were compacted. Column chunks are copied as they are,
//! which is the cheapest way. `cargo run --release -p zwidth-benches --example compacted --
//! raw/STUDY/trials COPIES`
#![allow(clippy::print_stdout)] // it is run by hand, or by benches/scale

use anyhow::Context as _;
use parquet::column::writer::ColumnCloseResult;
use parquet::file::metadata::{KeyValue, RowGroupMetaData};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use rayon::prelude::*;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

fn main() -> anyhow::Result<()> {
    let mut words = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = words.next().context("which folder of trials?")?;
    let copies = words.next().context("a folder for the copies?")?;
    let begun = Instant::now();
    fs::create_dir_all(&copies)?;
    let people: Vec<PathBuf> =
        fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    let copied = people.par_iter().map(|person| {
        let name = person.file_name().context("a participant without a name")?;
        copy(person, &copies.join(name).with_extension("parquet"))
    });
    let trials = copied.try_reduce(|| 0, |a, b| Ok(a + b))?;
    println!("{trials} trials in {} files, {:.3} s", people.len(), begun.elapsed().as_secs_f64());
    Ok(())
}

/// Copies the trials of a participant into one file; how many there are.
fn copy(person: &Path, to: &Path) -> anyhow::Result<usize> {
    let mut files = Vec::new();
    zwidth_benches::gather(person, &mut files)?;
    files.sort();
    let first = SerializedFileReader::new(File::open(files.first().context("no trial")?)?)?;
    let schema = first.metadata().file_metadata().schema_descr().root_schema_ptr();
    let out = BufWriter::new(File::create(to)?);
    let mut out = SerializedFileWriter::new(out, schema, Arc::new(WriterProperties::default()))?;
    for (trial, path) in files.iter().enumerate() {
        let file = File::open(path)?;
        let reader = SerializedFileReader::new(file.try_clone()?)?;
        let metadata = reader.metadata();
        for group in metadata.row_groups() {
            append(&mut out, &file, group).with_context(|| path.display().to_string())?;
        }
        // What each says of itself would have to go along.
        for said in metadata.file_metadata().key_value_metadata().into_iter().flatten() {
            let key = format!("{trial} {}", said.key);
            out.append_key_value_metadata(KeyValue { key, value: said.value.clone() });
        }
    }
    out.close()?;
    Ok(files.len())
}

fn append(
    out: &mut SerializedFileWriter<BufWriter<File>>,
    file: &File,
    group: &RowGroupMetaData,
) -> anyhow::Result<()> {
    let mut to = out.next_row_group()?;
    for column in group.columns() {
        let close = ColumnCloseResult {
            bytes_written: u64::try_from(column.compressed_size())?,
            rows_written: u64::try_from(group.num_rows())?,
            metadata: column.clone(),
            bloom_filter: None,
            column_index: None,
            offset_index: None,
        };
        to.append_column(file, close)?;
    }
    to.close()?;
    Ok(())
}
