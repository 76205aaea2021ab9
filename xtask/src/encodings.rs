//! Measures column encodings on the trials of a study: bytes per sample, and time to write and
//! read.

use std::path::Path;
use std::time::Instant;
use zwidth_store::{
    Encoding, Layout, Signal, Storage, StudyData, decoded_rows, encoded_column, read_trial,
};
use zwidth_study::StudyId;

const CANDIDATES: [(&str, Encoding); 4] = [
    ("plain", Encoding::Plain),
    ("dictionary", Encoding::Dictionary),
    ("byte-stream split", Encoding::ByteStreamSplit),
    ("delta", Encoding::Delta),
];

/// Prints, for each signal the study has, each encoding's size and speed at three zstd levels.
pub(crate) fn measure(root: &Path, study: &str) -> anyhow::Result<()> {
    let layout = Layout::new(root, StudyId::new(study)?);
    let data = StudyData::load(&layout).map_err(|e| anyhow::anyhow!("{e:?}"))?;
    let trials = data
        .trials
        .iter()
        .map(|t| read_trial(&t.path, Signal::all()))
        .collect::<Result<Vec<_>, _>>()?;
    println!(
        "| column | encoding | zstd | bytes a sample | write ns | read ns |\n|---|---|---|---|---|---|"
    );
    for signal in Signal::all() {
        let columns: Vec<&[f64]> = trials.iter().filter_map(|t| t.samples.get(signal)).collect();
        if columns.is_empty() {
            continue;
        }
        for (name, encoding) in CANDIDATES {
            if encoding == Encoding::Delta && signal.column().storage != Storage::U16 {
                continue;
            }
            for level in [1, 3, 9] {
                row(signal, name, encoding, level, &columns)?;
            }
        }
    }
    Ok(())
}

fn row(
    signal: Signal,
    name: &str,
    encoding: Encoding,
    level: i32,
    columns: &[&[f64]],
) -> anyhow::Result<()> {
    let samples: usize = columns.iter().map(|c| c.len()).sum();
    let per_sample = |start: Instant| start.elapsed().as_nanos() as f64 / samples as f64;
    let start = Instant::now();
    let files = columns
        .iter()
        .map(|c| encoded_column(signal, c, encoding, level))
        .collect::<Result<Vec<_>, _>>()?;
    let write = per_sample(start);
    let start = Instant::now();
    let rows = files.iter().map(|f| decoded_rows(f)).sum::<Result<usize, _>>()?;
    let read = per_sample(start);
    anyhow::ensure!(rows == samples, "{rows} of {samples} samples came back");
    let bytes: usize = files.iter().map(Vec::len).sum::<usize>() - files.len() * overhead(signal)?;
    let size = bytes as f64 / samples as f64;
    println!("| {} | {name} | {level} | {size:.2} | {write:.0} | {read:.0} |", signal.name());
    Ok(())
}

/// Bytes of a file with one sample: what a file costs besides its samples.
fn overhead(signal: Signal) -> anyhow::Result<usize> {
    Ok(encoded_column(signal, &[0.0], Encoding::Plain, 1)?.len())
}
