//! MAT files: some that SciPy wrote, truncated ones, and some that claim too much.

use super::super::limits::Budget;
use super::super::limits::tests::{everything, everything_turned, only};
use super::super::table::{Cell, ColumnRef};
use super::*;
use flate2::{Compression, write::ZlibEncoder};
use std::io::Write as _;

fn read(path: &Path, bytes: &[u8], matrix: Option<&str>) -> Result<Table, StoreError> {
    everything(|take| super::read(path, bytes, matrix, take))
}

/// `scipy.io.savemat(f, {"t": [0, .5, 1], "n": int32 [[1], [-2], [300]], "m": arange(6).reshape(3,
/// 2), "s": {"a": 1}, "c": [1 + 2j], "w": "hi"}, do_compression=True)`, SciPy 1.17.1, without its
/// header.
const COMPRESSED: &str = "\
    0f0000002d000000789ce3636060f000623620e680d220c00ae5330231339866642801d29c402cc1800e1ed843e80ff6\
    00444003610f0000002f000000789ce36360607000623620e600621e06086085f2998198118c1919f2a0e23c50b17fff\
    ffffd76184a80700571305240f00000036000000789ce36360604800623620e680d220c00ae533033113103302612e90\
    e6046203060ce000a104a0f4077b08cd01e58b380000860103980f0000003a000000789ce3636060a800623620e60062\
    2606086085f219e19891a1182cce0256c308241381341f105b20e967c3a91f0238a1e210f0c11e00ad3103340f000000\
    2b000000789ce3636060f000623620e600d120020858a17c463866644806d29c507108f8608fca677000004ae502780f\
    0000002a000000789ce36360603000623620e600621606086085f2198198094c333294036901202f23938101001b0101\
    bd";
/// `scipy.io.savemat(f, {"x": [1e-321, -0.0, nan], "b": [True, False]})`, without its header.
const PLAIN: &str = "\
    0e0000004800000006000000080000000600000000000000050000000800000001000000030000000100010078000000\
    0900000018000000ca000000000000000000000000000080000000000000f87f0e000000300000000600000008000000\
    09020000000000000500000008000000010000000200000001000100620000000200020001000000";

fn file(hex: &str) -> Vec<u8> {
    let digit = |i: usize| u8::from_str_radix(&hex[i..i + 2], 16).unwrap();
    let mut bytes = header(*b"\x00\x01IM");
    bytes.extend((0..hex.len()).step_by(2).map(digit));
    bytes
}

fn header(end: [u8; 4]) -> Vec<u8> {
    let mut bytes = vec![b' '; HEADER - 4];
    bytes.extend(end);
    bytes
}

fn column(table: &Table, name: &str) -> Vec<Cell<'static>> {
    let index = table.find(&ColumnRef::Name(name.to_owned())).unwrap();
    let Cells::Numbers(values) = &table.columns[index] else { panic!("{name}") };
    values.values().iter().map(|v| Cell::Number(*v)).collect()
}

#[test]
fn vectors_written_by_scipy_come_back_by_name() {
    let table = read(Path::new("a.mat"), &file(COMPRESSED), None).unwrap();
    assert_eq!(column(&table, "t"), [0.0, 0.5, 1.0].map(Cell::Number));
    assert_eq!(column(&table, "n"), [1.0, -2.0, 300.0].map(Cell::Number));
    for (name, words) in
        [("m", "a 3 × 2 matrix"), ("s", "a struct"), ("c", "complex"), ("w", "text")]
    {
        let error = table.find(&ColumnRef::Name(name.to_owned())).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn denormals_and_minus_zero_keep_their_bits() {
    let table = read(Path::new("a.mat"), &file(PLAIN), None).unwrap();
    let Cells::Numbers(x) = &table.columns[0] else { panic!() };
    let bits: Vec<u64> = x.values().iter().map(|v| v.to_bits()).collect();
    assert_eq!(bits, [1e-321, -0.0, f64::NAN].map(f64::to_bits));
    assert_eq!(column(&table, "b"), [1.0, 0.0].map(Cell::Number));
}

#[test]
fn the_columns_of_a_matrix_come_by_position() {
    let table = read(Path::new("a.mat"), &file(COMPRESSED), Some("m")).unwrap();
    assert_eq!(table.columns.len(), 2);
    assert_eq!(table.columns[1].cell(2), Cell::Number(5.0));
    let bytes = file(COMPRESSED);
    let turned = |take: &Take| super::read(Path::new("a.mat"), &bytes, Some("m"), take);
    let turned = everything_turned(turned).unwrap();
    assert_eq!(turned.columns.len(), 3);
    for (row, place) in [(0, 2), (1, 0)] {
        assert_eq!(turned.columns[place].cell(row), table.columns[row].cell(place));
    }
    let error = read(Path::new("a.mat"), &file(COMPRESSED), Some("q")).unwrap_err();
    assert!(error.what.contains("the file has t, n, m, s, s.a, c, w"), "{error}");
    let table = read(Path::new("a.mat"), &file(COMPRESSED), Some("s")).unwrap();
    assert_eq!(column(&table, "a"), [Cell::Number(1.0)]);
    assert!(read(Path::new("a.mat"), &file(COMPRESSED), Some("w")).is_err());
}

/// An element of a MAT file: its tag, its data, and what fills it up.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut all = [kind, data.len() as u32].map(u32::to_le_bytes).concat();
    all.extend(data);
    all.resize(all.len().next_multiple_of(ALIGN), 0);
    all
}

/// An array of this class, size and name; `rest` are the elements behind.
fn array(class: u32, size: &[i32], name: &str, rest: &[Vec<u8>]) -> Vec<u8> {
    let flags = element(mi::UINT32, &[class, 0].map(u32::to_le_bytes).concat());
    let size: Vec<u8> = size.iter().flat_map(|n| n.to_le_bytes()).collect();
    let parts =
        [flags, element(mi::INT32, &size), element(mi::INT8, name.as_bytes()), rest.concat()];
    element(mi::MATRIX, &parts.concat())
}

/// Real numbers, column by column.
fn doubles(rows: i32, columns: i32, name: &str, values: &[f64]) -> Vec<u8> {
    let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(6, &[rows, columns], name, &[element(mi::DOUBLE, &values)])
}

/// Structures of these fields, the values of one structure behind those of the other.
fn structure(count: i32, name: &str, fields: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
    let mut names = Vec::new();
    for field in fields {
        names.extend(field.bytes());
        names.resize(names.len().next_multiple_of(16), 0);
    }
    let rest =
        [element(mi::INT32, &16_i32.to_le_bytes()), element(mi::INT8, &names), values.concat()];
    array(STRUCT, &[1, count], name, &rest)
}

/// What "To Workspace" of Simulink saves as a structure with time, its only signal of two columns; and what a
/// scope saves of two signals.
pub(in super::super) fn simulink() -> Vec<u8> {
    let time = || doubles(3, 1, "", &[0.0, 0.5, 1.0]);
    let values = doubles(3, 2, "", &[7.0, 8.0, 9.0, 1.5, -2.0, 4.0]);
    let label = array(4, &[1, 1], "", &[element(mi::INT8, b"f")]);
    let signals = structure(1, "", &["values", "label"], &[values, label]);
    let simout = structure(
        1,
        "simout",
        &["time", "signals", "none"],
        &[time(), signals, element(mi::MATRIX, &[])],
    );
    let one = |values: &[f64]| doubles(3, 1, "", values);
    let two = structure(2, "", &["values"], &[one(&[7.0, 8.0, 9.0]), one(&[1.5, -2.0, 4.0])]);
    let scope = structure(1, "scope", &["time", "signals"], &[time(), two]);
    [header(*b"\x00\x01IM"), simout, scope].concat()
}

/// A variable of a class of MATLAB's own, as `save -v7` writes it, with the block of values that belongs to it.
pub(in super::super) fn object(class: &str) -> Vec<u8> {
    let flags = element(mi::UINT32, &[OPAQUE, 0].map(u32::to_le_bytes).concat());
    let texts = ["x", "MCOS", class].map(|text| element(mi::INT8, text.as_bytes())).concat();
    let numbers = array(13, &[1, 1], "", &[element(mi::UINT32, &7_u32.to_le_bytes())]);
    let object = element(mi::MATRIX, &[flags, texts, numbers].concat());
    let mut bytes = header(*b"\x00\x01IM");
    let behind = (bytes.len() + object.len()) as u64;
    bytes[SUBSYSTEM..SUBSYSTEM + 8].copy_from_slice(&behind.to_le_bytes());
    [bytes, object, array(9, &[1, 4], "", &[element(mi::UINT8, &[1, 2, 3, 4])])].concat()
}

#[test]
fn the_fields_of_structures_come_by_their_path_and_columns_of_a_matrix_by_their_place() {
    let names = ["simout.time", "simout.signals.values(2)", "scope.signals(2).values"];
    let plain = simulink();
    let take = |take: &Take| super::read(Path::new("a.mat"), &plain, None, take);
    let table = only(&names, take).unwrap();
    for (name, expect) in
        names.into_iter().zip([[0.0, 0.5, 1.0], [1.5, -2.0, 4.0], [1.5, -2.0, 4.0]])
    {
        assert_eq!(column(&table, name), expect.map(Cell::Number), "{name}");
    }
    let within = read(Path::new("a.mat"), &plain, Some("simout.signals.values")).unwrap();
    assert_eq!(within.columns[0].cell(2), Cell::Number(9.0));
    for (name, words) in [
        ("simout", "a struct; name its fields by their path"),
        ("simout.none", "empty"),
        ("simout.signals.label", "text"),
        ("simout.signals.values", "a 3 × 2 matrix; name it as matrix in [file]"),
    ] {
        let table = read(Path::new("a.mat"), &plain, None).unwrap();
        let error = table.find(&ColumnRef::Name(name.to_owned())).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn an_object_is_named_with_the_line_that_makes_numbers_of_it() {
    for (class, words) in [
        ("table", "'x' is a MATLAB table; in MATLAB, type s = table2struct(x, 'ToScalar', true)"),
        ("datetime", "'x' is a MATLAB datetime; in MATLAB, type x = seconds(x - x(1))"),
        ("Simulink.SimulationOutput", "an object of the class Simulink.SimulationOutput"),
    ] {
        let table = read(Path::new("a.mat"), &object(class), None).unwrap();
        let error = table.find(&ColumnRef::Name("t".to_owned())).unwrap_err();
        assert!(error.contains("the file has x; ") && error.contains(words), "{error}");
    }
}

#[test]
fn damaged_structures_and_objects_are_an_error_or_a_table_and_never_a_panic() {
    for whole in [simulink(), object("table")] {
        for place in HEADER..whole.len() {
            for change in [0xff, 0x01, 0x80] {
                let mut bad = whole.clone();
                bad[place] ^= change;
                let _ = read(Path::new("a.mat"), &bad, None);
            }
            let _ = read(Path::new("a.mat"), &whole[..place], None);
        }
    }
}

/// A MAT file of row vectors with names of one letter.
pub(in super::super) fn encode(vectors: &[(u8, &[f64])], big: bool) -> Vec<u8> {
    let mut bytes = header(if big { *b"\x01\x00MI" } else { *b"\x00\x01IM" });
    let word = |w: u32| if big { w.to_be_bytes() } else { w.to_le_bytes() };
    let number = |v: &f64| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    for (name, values) in vectors {
        let n = u32::try_from(values.len()).unwrap();
        let head =
            [mi::MATRIX, 48 + 8 * n, mi::UINT32, 8, 6, 0, mi::INT32, 8, 1, n, 1 << 16 | mi::INT8];
        bytes.extend(head.into_iter().flat_map(word));
        bytes.extend([*name, 0, 0, 0]);
        bytes.extend([mi::DOUBLE, 8 * n].into_iter().flat_map(word));
        bytes.extend(values.iter().flat_map(number));
    }
    bytes
}

#[test]
fn both_byte_orders_read_alike() {
    for big in [false, true] {
        let bytes = encode(&[(b'x', &[2.5, -1.0]), (b'y', &[0.1])], big);
        let table = read(Path::new("a.mat"), &bytes, None).unwrap();
        assert_eq!(column(&table, "x"), [2.5, -1.0].map(Cell::Number));
        assert_eq!(column(&table, "y"), [Cell::Number(0.1)]);
    }
}

#[test]
fn a_file_cut_anywhere_says_where_it_ends() {
    for hex in [COMPRESSED, PLAIN] {
        let whole = file(hex);
        let complete = read(Path::new("a.mat"), &whole, None).unwrap().columns.len();
        for cut in 0..whole.len() {
            match read(Path::new("a.mat"), &whole[..cut], None) {
                Err(error) => assert!(error.what.contains("not a readable MAT file"), "{error}"),
                Ok(table) => {
                    assert!(table.columns.len() < complete || cut >= whole.len() - ALIGN, "{cut}")
                }
            }
        }
    }
}

#[test]
fn other_formats_are_refused_by_name() {
    let check = |bytes: &[u8], words: &str| {
        let error = read(Path::new("a.mat"), bytes, None).unwrap_err();
        assert!(error.what.contains(words), "{error}");
    };
    check(&header(*b"\x00\x02IM"), "7.3");
    check(&header(*b"...."), "byte order");
    check(b"t,f\n", "shorter");
}

#[test]
fn a_flipped_bit_never_ends_the_program() {
    for hex in [COMPRESSED, PLAIN] {
        let whole = file(hex);
        for bit in HEADER * 8..whole.len() * 8 {
            let mut bad = whole.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let _ = read(Path::new("a.mat"), &bad, None);
        }
    }
}

#[test]
fn a_compressed_variable_whose_checksum_is_wrong_is_damage() {
    let mut bytes = bomb(1 << 16, 1 << 16);
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    assert!(refused(&bytes).contains("cut off or damaged"));
}

/// A MAT file of one compressed variable `x`, of which `zeros` bytes of values are there and
/// `claimed` are claimed.
fn bomb(zeros: usize, claimed: u32) -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
    let n = claimed / 8;
    let head =
        [mi::MATRIX, 48 + claimed, mi::UINT32, 8, 6, 0, mi::INT32, 8, 1, n, 1 << 16 | mi::INT8];
    packed.write_all(&head.map(u32::to_le_bytes).concat()).unwrap();
    packed.write_all(&[b'x', 0, 0, 0]).unwrap();
    packed.write_all(&[mi::DOUBLE, claimed].map(u32::to_le_bytes).concat()).unwrap();
    let block = vec![0; 1 << 16];
    (0..zeros >> 16).for_each(|_| packed.write_all(&block).unwrap());
    let packed = packed.finish().unwrap();
    let mut bytes = header(*b"\x00\x01IM");
    bytes.extend([mi::COMPRESSED, packed.len() as u32].map(u32::to_le_bytes).concat());
    bytes.extend(packed);
    bytes
}

fn refused(bytes: &[u8]) -> String {
    read(Path::new("a.mat"), bytes, None).unwrap_err().what
}

#[test]
fn a_variable_that_unpacks_to_more_than_is_read_is_refused_before_it_is_unpacked() {
    let error = refused(&bomb(1 << 20, 1 << 29));
    assert!(
        error.contains("variable 'x' unpacks to 536870960 bytes, and at most 268435456"),
        "{error}"
    );
    let x = &read(Path::new("a.mat"), &bomb(1 << 20, 1 << 20), None).unwrap().columns[0];
    assert_eq!(x.len(), 1 << 17);
}

#[test]
fn a_size_that_is_not_that_of_the_values_is_damage_however_large_it_is() {
    // Less is there than claimed, much less than can be unpacked from it, and much more.
    for (zeros, claimed) in [(1 << 19, 1 << 20), (1 << 16, 1 << 27), (1 << 28, 1 << 16)] {
        let error = refused(&bomb(zeros, claimed));
        assert!(error.contains("cut off or damaged"), "{zeros} of {claimed}: {error}");
    }
    let mut plain = encode(&[(b'x', &[1.0, 2.0])], false);
    for size in [3_u32, u32::MAX, i32::MAX as u32] {
        plain[HEADER + 36..HEADER + 40].copy_from_slice(&size.to_le_bytes());
        assert!(refused(&plain).contains("cut off or damaged"), "{size}");
    }
}

#[test]
fn a_variable_that_is_not_mapped_is_not_unpacked() {
    let bytes = bomb(1 << 20, 1 << 31);
    let take = |take: &Take| super::read(Path::new("a.mat"), &bytes, None, take);
    let table = only(&["y"], take).unwrap();
    assert!(matches!(table.columns[..], [Cells::Unread]));
}

#[test]
fn more_variables_than_are_read_are_refused() {
    let many: Vec<(u8, &[f64])> = (0..=MOST_COLUMNS).map(|_| (b'x', &[] as &[f64])).collect();
    let error = refused(&encode(&many, false));
    assert!(error.contains("more than 16384 variables"), "{error}");
}

/// A table `rig` and a timetable `log` as mat-io 1.0.2 writes them.
pub(in super::super) const OBJECTS: &[u8] = include_bytes!("objects.mat");

#[test]
fn tables_and_timetables_have_their_columns_by_name_whatever_is_in_them() {
    let all = |names: &[&str], matrix| {
        only(names, |take| super::read(Path::new("a.mat"), OBJECTS, matrix, take)).unwrap()
    };
    let names =
        ["rig.t", "rig.f", "rig.who", "rig.level", "rig.wait", "rig.when", "log.Time", "log.f"];
    let table = all(&names, None);
    let numbers = |values: [f64; 3]| values.map(Cell::Number);
    assert_eq!(column(&table, "rig.t"), numbers([0.0, 0.5, 1.0]));
    assert_eq!(column(&table, "rig.f"), numbers([1.5, -2.0, 4.0]));
    let texts = |name: &str| {
        let cells = &table.columns[table.find(&ColumnRef::Name(name.to_owned())).unwrap()];
        [0, 1, 2].map(|row| cells.cell(row))
    };
    assert_eq!(texts("rig.who"), [Cell::Text("P01"), Cell::Empty, Cell::Text("P02")]);
    assert_eq!(texts("rig.level"), ["low", "high", "low"].map(Cell::Text));
    assert_eq!(column(&table, "rig.wait"), numbers([1500.0, 2250.0, 0.0]));
    // As far as the writer kept it (a double of ms), and before 1970 too.
    let when = ["1769853600000000977", "1769853601000000000", "-500000000"];
    assert_eq!(texts("rig.when"), when.map(Cell::Text));
    assert_eq!(column(&table, "log.Time"), numbers([0.0, 500.0, 1000.0]));
    let unit = |name: &str| {
        let place = table.find(&ColumnRef::Name(name.to_owned())).unwrap();
        table.units.get(&place).map(|unit| (unit.unit.as_str(), unit.is_type))
    };
    assert_eq!(
        [unit("rig.t"), unit("rig.wait"), unit("rig.when")],
        [None, Some(("ms", true)), Some(("ns", true))]
    );
    // A table that is named has its columns by their own names.
    let table = all(&["f", "Time"], Some("log"));
    assert_eq!(column(&table, "f"), numbers([1.5, -2.0, 4.0]));
}

#[test]
fn no_damage_of_objects_ends_the_program() {
    let at = super::place_of_objects(OBJECTS, false).unwrap();
    let subsystem = super::objects::subsystem(OBJECTS, at, false, 1 << 20).unwrap();
    for place in 0..subsystem.len() {
        for byte in [0, 1, 0x7F, 0xFF] {
            let mut damaged = subsystem.clone();
            damaged[place] = byte;
            let Some(objects) = super::Objects::read(&damaged, false) else { continue };
            for id in 0..8 {
                let Ok(columns) = objects.columns(id) else { continue };
                let budget = Budget::default();
                let take = Take::of(Vec::new(), &budget);
                for column in &columns {
                    let _: Result<Cells, String> = objects.cells(column, &take);
                }
            }
        }
    }
}
