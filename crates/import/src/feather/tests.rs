use super::super::limits::tests::everything;
use super::super::table::Cell;
use super::batch::Batch;
use super::*;
use arrow::array::{
    ArrayRef, BooleanArray, DictionaryArray, Float32Array, Float64Array, Int16Array,
    LargeStringArray, RecordBatch, StringArray, StringViewArray, StructArray, UInt64Array,
};
use arrow::datatypes::Int8Type;
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use std::sync::Arc;

fn try_read(bytes: &[u8]) -> Result<Table, StoreError> {
    everything(|take| super::read(Path::new("a.arrow"), bytes, take))
}

/// A batch with a column of each kind, those that are not read before those that are.
fn batch() -> RecordBatch {
    let inner: ArrayRef =
        Arc::new(StringViewArray::from(vec!["a view longer than twelve bytes", "x"]));
    let nested = StructArray::from(vec![(
        Arc::new(arrow::datatypes::Field::new("s", inner.data_type().clone(), true)),
        inner.clone(),
    )]);
    let mode: DictionaryArray<Int8Type> = [Some("b"), None].into_iter().collect();
    RecordBatch::try_from_iter_with_nullable([
        ("nested", Arc::new(nested) as ArrayRef, true),
        ("on", Arc::new(BooleanArray::from(vec![true, false])), true),
        ("t", Arc::new(Float64Array::from(vec![0.0, 0.5])), true),
        ("f", Arc::new(Float32Array::from(vec![Some(0.1), None])), true),
        ("n", Arc::new(Int16Array::from(vec![-3, 7])), true),
        ("u", Arc::new(UInt64Array::from(vec![1 << 40, 0])), true),
        ("who", Arc::new(StringArray::from(vec![Some("P01"), None])), true),
        ("large", Arc::new(LargeStringArray::from(vec!["", "ä"])), true),
        ("view", inner, true),
        ("mode", Arc::new(mode), true),
    ])
    .unwrap()
}

pub(in super::super) fn encode(batches: &[RecordBatch]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = IpcWriteOptions::default();
    let mut writer =
        FileWriter::try_new_with_options(&mut bytes, &batches[0].schema(), options).unwrap();
    batches.iter().for_each(|batch| writer.write(batch).unwrap());
    writer.finish().unwrap();
    drop(writer);
    bytes
}

#[test]
fn numbers_and_texts_of_every_form_are_read_and_the_rest_says_why_not() {
    let table = try_read(&encode(&[batch(), batch()])).unwrap();
    let column = |name: &str| table.find(&super::super::table::ColumnRef::Name(name.to_owned()));
    let cells = |name: &str| {
        let column = &table.columns[column(name).unwrap()];
        assert_eq!((column.len(), column.cell(0)), (4, column.cell(2)));
        (column.cell(0), column.cell(1))
    };
    let (number, text) = (Cell::Number, Cell::Text);
    assert_eq!(cells("t"), (number(0.0), number(0.5)));
    assert_eq!(cells("f"), (number(f64::from(0.1_f32)), Cell::Empty));
    assert_eq!(cells("n"), (number(-3.0), number(7.0)));
    assert_eq!(cells("u"), (number(1_099_511_627_776.0), number(0.0)));
    assert_eq!(cells("who"), (text("P01"), Cell::Empty));
    assert_eq!(cells("large"), (text(""), text("ä")));
    assert_eq!(cells("view"), (text("a view longer than twelve bytes"), text("x")));
    assert_eq!(cells("mode"), (text("b"), Cell::Empty));
    assert!(column("nested").unwrap_err().contains("its type Struct is neither"));
    assert!(column("on").unwrap_err().contains("its type Bool is neither"));
}

#[test]
fn packed_columns_unpack_to_no_more_than_they_need() {
    let lz4 = |bytes: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        std::io::Write::write_all(&mut encoder, bytes).unwrap();
        encoder.finish().unwrap()
    };
    let values = [0.5_f64, 1.5].map(f64::to_le_bytes).concat();
    let check = |codec, claimed: i64, packed: &[u8], most: usize| {
        let body = [&claimed.to_le_bytes()[..], packed].concat();
        let room = Room::new();
        let batch = Batch::of_one(2, &body, codec, &room);
        batch.buffer(0, most).map(Cow::into_owned)
    };
    use std::borrow::Cow;
    let zstd = zstd::stream::encode_all(&values[..], 0).unwrap();
    assert_eq!(check(CompressionType::LZ4_FRAME, 16, &lz4(&values), 16).unwrap(), values);
    assert_eq!(check(CompressionType::ZSTD, 16, &zstd, 16).unwrap(), values);
    assert_eq!(check(CompressionType::ZSTD, -1, &values, 16).unwrap(), values);
    // A file's claim costs nothing, and what comes behind is not read.
    let bomb = zstd::stream::encode_all(&vec![0_u8; 1 << 24][..], 0).unwrap();
    assert_eq!(check(CompressionType::ZSTD, i64::MAX, &bomb, 16).unwrap(), [0; 16]);
    for (codec, claimed) in
        [(CompressionType::LZ4_FRAME, 17), (CompressionType::ZSTD, 17), (CompressionType(9), 16)]
    {
        let packed = if codec == CompressionType::ZSTD { &zstd } else { &lz4(&values) };
        assert!(check(codec, claimed, packed, 64).is_err(), "{codec:?}");
    }
    assert!(
        check(CompressionType::ZSTD, 1 << 40, &bomb, usize::MAX).unwrap_err().contains("more than")
    );
}

#[test]
fn other_files_are_called_by_their_name() {
    let check = |bytes: &[u8], words: &str| {
        let error = try_read(bytes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    check(b"", "the file is empty");
    check(b"FEA1....", "a Feather file of version 1; write it again");
    check(&[0xff; 8], "an Arrow stream, which is not the file format; convert it: python");
    check(b"t,f\n", "does not begin with 'ARROW1'");
}

#[test]
fn a_file_cut_or_damaged_anywhere_is_an_error_and_never_ends_the_program() {
    let bytes = encode(&[batch()]);
    for at in 0..bytes.len() {
        if at % 11 == 0 {
            assert!(try_read(&bytes[..at]).is_err());
        }
        let mut bad = bytes.clone();
        bad[at] ^= 1 << (at % 8);
        let _ = try_read(&bad);
    }
}
