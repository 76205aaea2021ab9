//! One column in one encoding: its size, and how long it takes (`cargo xtask encodings`).

use crate::form::encode::{Encoding, properties};
use crate::form::write::signal_column;
use crate::{Samples, Signal, StoreError};
use arrow::array::RecordBatch;
use arrow::datatypes::Schema;
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use std::path::Path;
use std::sync::Arc;

/// One column alone in a Parquet file, to measure an encoding (`cargo xtask encodings`).
pub fn encoded_column(
    signal: Signal,
    values: &[f64],
    encoding: Encoding,
    zstd: i32,
) -> Result<Vec<u8>, StoreError> {
    let mut samples = Samples::default();
    samples.set(signal, values.to_vec());
    let (field, array) = signal_column(signal.column(), &samples);
    let name = signal.name();
    (|| {
        let batch = RecordBatch::try_new(Arc::new(Schema::new(vec![field])), vec![array])?;
        let compression = Compression::ZSTD(ZstdLevel::try_new(zstd)?);
        let properties =
            properties([(name, encoding)].into_iter(), Vec::new(), compression).build();
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))?;
        writer.write(&batch)?;
        writer.close()?;
        Ok(bytes)
    })()
    .map_err(|e| unmeasured(name, &e))
}

/// The error of an encoding that cannot be measured.
fn unmeasured(name: &str, error: &ParquetError) -> StoreError {
    StoreError::new(Path::new(name), error.to_string(), "try another encoding")
}

/// Rows decoded from the bytes of a Parquet file, to measure an encoding.
pub fn decoded_rows(bytes: &[u8]) -> Result<usize, StoreError> {
    (|| {
        let reader =
            ParquetRecordBatchReaderBuilder::try_new(Bytes::copy_from_slice(bytes))?.build()?;
        reader.map(|batch| Ok(batch?.num_rows())).sum::<Result<usize, ParquetError>>()
    })()
    .map_err(|e| unmeasured("(memory)", &e))
}
