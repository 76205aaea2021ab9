//! Arrays and archives as NumPy writes them, truncated ones, and some that claim too much.

use super::super::limits::tests::{everything, everything_turned};
use super::super::table::{Cell, ColumnRef};
use super::super::workbook::tests::packed as archive;
use super::*;

/// An array of version 1.0: its header is filled with blanks, as NumPy's is.
fn array(descr: &str, by_columns: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': {by_columns}, 'shape': {shape}, }}");
    let blanks = 64 - (10 + text.len() + 1) % 64;
    let text = format!("{text}{}\n", " ".repeat(blanks));
    let length = u16::try_from(text.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), values].concat()
}

fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn vector(values: &[f64]) -> Vec<u8> {
    array("'<f8'", "False", &format!("({},)", values.len()), &floats(values))
}

fn read(bytes: &[u8]) -> Result<Table, StoreError> {
    everything(|take| super::read(Path::new("a.npy"), bytes, take))
}

fn read_archive(bytes: &[u8], matrix: Option<&str>) -> Result<Table, StoreError> {
    everything(|take| super::read_archive(Path::new("a.npz"), bytes, matrix, take))
}

fn column(table: &Table, column: &ColumnRef) -> Vec<Cell<'static>> {
    match &table.columns[table.find(column).unwrap()] {
        Cells::Numbers(values) => values.values().iter().map(|v| Cell::Number(*v)).collect(),
        other => panic!("{other:?}"),
    }
}

fn numbers(values: &[f64]) -> Vec<Cell<'static>> {
    values.iter().copied().map(Cell::Number).collect()
}

fn name(name: &str) -> ColumnRef {
    ColumnRef::Name(name.to_owned())
}

#[test]
fn a_matrix_is_read_by_its_columns_whichever_way_it_lies() {
    let by_rows = array("'<f8'", "False", "(2, 3)", &floats(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    let by_columns = array("'<f8'", "True", "(2, 3)", &floats(&[0.0, 3.0, 1.0, 4.0, 2.0, 5.0]));
    for bytes in [by_rows, by_columns] {
        let table = read(&bytes).unwrap();
        assert_eq!(table.columns.len(), 3);
        assert_eq!(column(&table, &ColumnRef::Position(2)), numbers(&[1.0, 4.0]));
        let read = |take: &Take| super::read(Path::new("a.npy"), &bytes, take);
        let turned = everything_turned(read).unwrap();
        assert_eq!(turned.columns.len(), 2);
        assert_eq!(column(&turned, &ColumnRef::Position(2)), numbers(&[3.0, 4.0, 5.0]));
    }
}

#[test]
fn every_kind_of_number_is_read_in_either_order_of_bytes() {
    for (descr, bytes, expect) in [
        ("'<f4'", vec![0, 0, 0x80, 0x3f], 1.0),
        ("'>f8'", (-2.5_f64).to_be_bytes().to_vec(), -2.5),
        ("'|i1'", vec![0xff], -1.0),
        ("'|u1'", vec![0xff], 255.0),
        ("'<i2'", (-300_i16).to_le_bytes().to_vec(), -300.0),
        ("'>i4'", (-70_000_i32).to_be_bytes().to_vec(), -70_000.0),
        ("'<u4'", u32::MAX.to_le_bytes().to_vec(), 4_294_967_295.0),
        ("'<i8'", (-5_i64).to_le_bytes().to_vec(), -5.0),
        ("'>u2'", 258_u16.to_be_bytes().to_vec(), 258.0),
    ] {
        let table = read(&array(descr, "False", "(1,)", &bytes)).unwrap();
        assert_eq!(column(&table, &ColumnRef::Position(1)), numbers(&[expect]), "{descr}");
    }
}

#[test]
fn fields_of_a_structured_array_are_columns_with_names_and_texts_are_text() {
    let row = |t: f64, mode: &str, who: &str| {
        let letters: Vec<u8> = mode.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        let pad = vec![0; 12 - letters.len()];
        let who = [who.as_bytes(), &vec![0; 4 - who.len()]].concat();
        [t.to_le_bytes().to_vec(), letters, pad, who].concat()
    };
    let values = [row(0.5, "é", "P01"), row(1.5, "abc", "")].concat();
    let descr = "[('t', '<f8'), ('mode', '<U3'), ('who', '|S4')]";
    let table = read(&array(descr, "False", "(2,)", &values)).unwrap();
    assert_eq!(column(&table, &name("t")), numbers(&[0.5, 1.5]));
    let cell = |of: &str, row| table.columns[table.find(&name(of)).unwrap()].cell(row);
    assert_eq!((cell("mode", 0), cell("mode", 1)), (Cell::Text("é"), Cell::Text("abc")));
    assert_eq!((cell("who", 0), cell("who", 1)), (Cell::Text("P01"), Cell::Empty));
}

#[test]
fn a_field_that_is_not_read_keeps_none_of_the_others_from_it() {
    for (descr, before) in [
        ("[('a', '<f12'), ('t', '<f8')]", 12),
        ("[('a', '<m8'), ('t', '<f8')]", 8),
        ("[('a', '<M8[25s]'), ('t', '<f8')]", 8),
        ("[('a', '<f4', (2, 3)), ('t', '<f8')]", 24),
        ("[('a', '<f4'), ('', '|V4'), ('t', '<f8')]", 8),
        ("[('a', '<f4'), (('a title', 't'), '<f8')]", 4),
    ] {
        let bytes = [vec![0; before], floats(&[1.5])].concat();
        // Python 2 wrote long numbers with an L.
        for shape in ["(1,)", "(1L,)"] {
            let table = read(&array(descr, "False", shape, &bytes)).unwrap();
            assert_eq!(column(&table, &name("t")), numbers(&[1.5]), "{descr} {shape}");
        }
    }
}

#[test]
fn vectors_of_an_archive_come_back_by_name_stored_or_deflated() {
    let matrix = array("'<f8'", "False", "(2, 2)", &floats(&[1.0, 2.0, 3.0, 4.0]));
    let entries =
        [("t.npy", vector(&[0.0, 0.5])), ("m.npy", matrix), ("f.npy", vector(&[1.0, -1.0]))];
    for deflated in [false, true] {
        let bytes = archive(&entries, deflated);
        let table = read_archive(&bytes, None).unwrap();
        assert_eq!(column(&table, &name("t")), numbers(&[0.0, 0.5]));
        assert_eq!(column(&table, &name("f")), numbers(&[1.0, -1.0]));
        let error = table.find(&name("m")).unwrap_err();
        assert!(error.contains("a 2 × 2 matrix; name it as matrix"), "{error}");
        let table = read_archive(&bytes, Some("m")).unwrap();
        assert_eq!(column(&table, &ColumnRef::Position(2)), numbers(&[2.0, 4.0]));
        let error = read_archive(&bytes, Some("x")).unwrap_err();
        assert!(error.what.contains("the file has t, m, f"), "{error}");
    }
}

#[test]
fn what_is_neither_number_nor_text_says_what_to_save_instead() {
    for (descr, size, words) in [
        ("'|b1'", 1, "yes or no"),
        ("'<c16'", 16, "real and imaginary part"),
        ("'<f2'", 2, "save it as float64"),
        ("'<M8[ns]'", 8, "dates"),
    ] {
        let table = read(&array(descr, "False", "(1,)", &vec![0; size])).unwrap();
        let error = table.find(&ColumnRef::Position(1)).unwrap_err();
        assert!(error.contains(words), "{descr}: {error}");
    }
    let objects = read(&array("'|O'", "False", "(1,)", b"pickled")).unwrap_err();
    assert!(objects.what.contains("Python objects"), "{objects}");
    let deep = read(&array("'<f8'", "False", "(1, 1, 1)", &floats(&[0.0]))).unwrap_err();
    assert!(deep.what.contains("an array of 3 dimensions (1 × 1 × 1)"), "{deep}");
}

#[test]
fn what_a_header_claims_takes_no_memory_and_is_refused_where_it_is_not_there() {
    for (descr, shape, words) in [
        ("'<f8'", "(1000000000000,)", "claims 8000000000000 bytes of values, and 8 are there"),
        ("'<f8'", "(18446744073709551615, 18446744073709551615)", "more values than any file"),
        ("'<f8'", "(99999999999999999999999,)", "its header does not list"),
        ("'<f8'", "(-1,)", "its header does not list"),
        ("'<U9223372036854775807'", "(1,)", "its type is not one that NumPy writes"),
        ("'<f8'", "('a',)", "its shape cannot be read"),
        ("[]", "(1,)", "0 fields"),
        (
            "[('a', '<f8', (4294967295, 4294967295, 4294967295))]",
            "(1,)",
            "its type is not one that NumPy writes",
        ),
        ("((((((((((1,),),),),),),),),),)", "(1,)", "its header does not list"),
        ("'<f8'", "(0, 0)", "8 are there"),
    ] {
        let error = read(&array(descr, "False", shape, &floats(&[0.0]))).unwrap_err();
        assert!(error.what.contains(words), "{descr} {shape}: {error}");
    }
    // An item of no bytes, as often as can be counted.
    let error = read(&array("'|S0'", "False", "(18446744073709551615,)", b"")).unwrap_err();
    assert!(error.what.contains("rows, and at most"), "{error}");
}

#[test]
fn a_file_that_is_cut_anywhere_is_one_clear_error() {
    let (one, many) = (vector(&[1.0, 2.0]), archive(&[("t.npy", vector(&[1.0, 2.0]))], true));
    for length in 0..one.len() {
        let error = read(&one[..length]).unwrap_err();
        assert!(error.what.contains("not a readable NumPy file"), "{length}: {error}");
    }
    for length in 0..many.len() {
        let error = read_archive(&many[..length], None).unwrap_err();
        assert!(error.what.contains("not a readable NumPy file"), "{length}: {error}");
    }
}

#[test]
fn a_flipped_bit_in_a_value_of_an_archive_is_noticed_and_none_makes_a_panic() {
    let bytes = archive(&[("t.npy", vector(&[1.0, 2.0]))], false);
    let value = bytes.windows(8).position(|w| w == 2.0_f64.to_le_bytes()).unwrap();
    let mut flipped = bytes.clone();
    flipped[value] ^= 1;
    assert!(
        read_archive(&flipped, None).unwrap_err().what.contains("'t.npy' is cut off or damaged")
    );
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let _: Result<Table, StoreError> = read_archive(&flipped, None);
    }
}

#[test]
fn an_archive_that_unpacks_to_more_than_is_read_is_refused() {
    let zeros = archive(&[("t.npy", vec![0; 1 << 20])], true);
    let entry = &zip::entries(&zeros).unwrap()[0];
    let mut unpacked = super::super::limits::MOST_UNPACKED - 10;
    let error = zip::unpack(&zeros, entry, &mut unpacked).unwrap_err();
    assert!(error.contains("unpack to more than"), "{error}");
}
