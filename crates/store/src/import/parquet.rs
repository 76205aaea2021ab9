//! Anybody's Parquet file.

use super::table::{Cells, Table};
use crate::StoreError;
use crate::codec::check_codecs;
use crate::read::guarded;
use ::parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use arrow::compute::{cast, concat_batches};
use arrow::datatypes::{DataType, Float64Type};
use bytes::Bytes;
use std::path::Path;

const REMEDY: &str = "the file may be cut off or damaged; copy or export it again";

/// Reads a Parquet file, whole.
pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<Table, StoreError> {
    if bytes.is_empty() {
        return Err(StoreError::new(path, "the file is empty", REMEDY));
    }
    let builder = guarded(path, REMEDY, || ParquetRecordBatchReaderBuilder::try_new(Bytes::from(bytes)))?;
    check_codecs(path, builder.metadata())?;
    let batch: RecordBatch = guarded(path, REMEDY, || {
        let reader = builder.build()?;
        let schema = arrow::array::RecordBatchReader::schema(&reader);
        Ok(concat_batches(&schema, &reader.collect::<Result<Vec<_>, _>>()?)?)
    })?;
    let names = batch.schema().fields().iter().map(|f| f.name().clone()).collect();
    let columns = batch.columns().iter().map(cells).collect();
    Ok(Table { names: Some(names), columns, lines: Vec::new() })
}

fn cells(array: &ArrayRef) -> Cells {
    let unusable = || Cells::Other(format!("its type {} is neither number nor text", array.data_type()));
    let target = match kind(array.data_type()) {
        Some(target) => target,
        None => return unusable(),
    };
    match (cast(array, &target), &target) {
        (Ok(cast), DataType::Float64) => Cells::Numbers(cast.as_primitive::<Float64Type>().clone()),
        (Ok(cast), _) => Cells::Text(cast.as_string::<i64>().clone()),
        (Err(_), _) => unusable(),
    }
}

/// Whether a type counts as numbers (`Float64`) or text (`LargeUtf8`).
fn kind(data_type: &DataType) -> Option<DataType> {
    match data_type {
        DataType::Dictionary(_, values) => kind(values),
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => Some(DataType::LargeUtf8),
        numeric if numeric.is_numeric() => Some(DataType::Float64),
        _ => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::table::Cell;
    use super::*;
    use crate::codec::tests::said_to_be;
    use ::parquet::arrow::ArrowWriter;
    use arrow::array::{BooleanArray, DictionaryArray, Float32Array, Int64Array, StringArray};
    use arrow::datatypes::Int32Type;
    use std::sync::Arc;

    fn sample() -> Vec<u8> {
        let mode: DictionaryArray<Int32Type> = ["a", "b"].into_iter().collect();
        let batch = RecordBatch::try_from_iter([
            ("f", Arc::new(Float32Array::from(vec![Some(0.1), None])) as ArrayRef),
            ("n", Arc::new(Int64Array::from(vec![1, 2]))),
            ("mode", Arc::new(mode)),
            ("who", Arc::new(StringArray::from(vec!["x", "y"]))),
            ("on", Arc::new(BooleanArray::from(vec![true, false]))),
        ])
        .unwrap();
        encode(&batch)
    }

    /// A Parquet file with the writer's own defaults.
    pub(in super::super) fn encode(batch: &RecordBatch) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), None).unwrap();
        writer.write(batch).unwrap();
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn numbers_are_f64_words_are_text_and_the_rest_says_why_not() {
        let table = read(Path::new("a.parquet"), sample()).unwrap();
        let cell = |c: usize, r: usize| table.columns[c].cell(r);
        assert_eq!(cell(0, 0), Cell::Number(f64::from(0.1_f32)));
        assert_eq!((cell(0, 1), cell(1, 1)), (Cell::Empty, Cell::Number(2.0)));
        assert_eq!((cell(2, 1), cell(3, 0)), (Cell::Text("b"), Cell::Text("x")));
        assert!(matches!(&table.columns[4], Cells::Other(why) if why.contains("Boolean")));
    }

    #[test]
    fn a_file_compressed_with_gzip_is_named_so() {
        let gzip = said_to_be(&sample(), ::parquet::basic::CompressionCodec::GZIP);
        let error = read(Path::new("a.parquet"), gzip).unwrap_err();
        assert!(error.what.contains("compressed with gzip"), "{error}");
    }

    #[test]
    fn a_file_cut_anywhere_is_one_clear_error() {
        let bytes = sample();
        for cut in (0..bytes.len()).step_by(41) {
            let error = read(Path::new("a.parquet"), bytes[..cut].to_vec()).unwrap_err();
            assert!(error.what.contains("Parquet") || error.what.contains("empty"), "{error}");
        }
    }

    #[test]
    fn a_flipped_bit_never_ends_the_program() {
        let bytes = sample();
        for i in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[i] ^= 1 << (i % 8);
            let _ = read(Path::new("a.parquet"), bad);
        }
    }
}
