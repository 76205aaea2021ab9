//! The columns that metrics are made from, decoded from every file below a folder and added up: the
//! least that any reader of a study has to do. `cargo run --release -p zwidth-benches --example
//! decode -- raw/STUDY/trials`
#![allow(clippy::print_stdout)] // it is run by hand, or by benches/scale

use anyhow::Context as _;
use arrow::array::{Array, AsArray};
use arrow::datatypes::{DataType, Float32Type, Float64Type, UInt16Type};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;
use std::fs::File;
use std::path::Path;
use std::time::Instant;

/// What the metrics of a trial without currents and references of its own read.
const COLUMNS: [&str; 9] = [
    "t_s",
    "theta_rad",
    "theta_dot_rad_s",
    "force_ex_n",
    "force_age_s",
    "force_cmd_n",
    "voltage_motor_v",
    "voltage_brake_v",
    "state_bits",
];

/// Rows that are decoded at a time: more than a trial of a few seconds has.
const BATCH_ROWS: usize = 1 << 16;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args().nth(1).context("which folder of trials?")?;
    let begun = Instant::now();
    let mut files = Vec::new();
    zwidth_benches::gather(Path::new(&folder), &mut files)?;
    let sums =
        files.par_iter().map(|file| decoded(file).with_context(|| file.display().to_string()));
    let (values, sum) = sums.try_reduce(|| (0, 0.0), |a, b| Ok((a.0 + b.0, a.1 + b.1)))?;
    println!(
        "{} files, {values} values, sum {sum:.6e}, {:.3} s",
        files.len(),
        begun.elapsed().as_secs_f64()
    );
    Ok(())
}

/// How many values a file's columns have, and their sum.
fn decoded(file: &Path) -> anyhow::Result<(usize, f64)> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(file)?)?;
    let mask = ProjectionMask::columns(builder.parquet_schema(), COLUMNS);
    let reader = builder.with_projection(mask).with_batch_size(BATCH_ROWS).build()?;
    let (mut values, mut sum) = (0, 0.0);
    for batch in reader {
        for column in batch?.columns() {
            values += column.len();
            sum += total(column)?;
        }
    }
    Ok((values, sum))
}

fn total(column: &dyn Array) -> anyhow::Result<f64> {
    Ok(match column.data_type() {
        DataType::Float64 => column.as_primitive::<Float64Type>().values().iter().sum(),
        DataType::Float32 => {
            column.as_primitive::<Float32Type>().values().iter().map(|v| f64::from(*v)).sum()
        }
        DataType::UInt16 => {
            column.as_primitive::<UInt16Type>().values().iter().map(|v| f64::from(*v)).sum()
        }
        other => anyhow::bail!("a column of {other}"),
    })
}
