//! MAT files: those that SciPy wrote, cut ones, and ones that claim too much.

use super::super::limits::{Budget, tests::everything};
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
    let error = read(Path::new("a.mat"), &file(COMPRESSED), Some("q")).unwrap_err();
    assert!(error.what.contains("the file has t, n, m, s, c, w"), "{error}");
    assert!(read(Path::new("a.mat"), &file(COMPRESSED), Some("s")).is_err());
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
    // Less is there than claimed, and much more.
    assert!(refused(&bomb(1 << 16, 1 << 20)).contains("cut off or damaged"));
    let x = &read(Path::new("a.mat"), &bomb(1 << 28, 1 << 16), None).unwrap().columns[0];
    assert_eq!(x.len(), 1 << 13);
    let mut plain = encode(&[(b'x', &[1.0, 2.0])], false);
    for size in [3_u32, u32::MAX, i32::MAX as u32] {
        plain[HEADER + 36..HEADER + 40].copy_from_slice(&size.to_le_bytes());
        assert!(refused(&plain).contains("cut off or damaged"), "{size}");
    }
}

#[test]
fn a_variable_that_is_not_mapped_is_not_unpacked() {
    let y = ColumnRef::Name("y".to_owned());
    let budget = Budget::default();
    let take = Take { columns: vec![&y], pattern: None, budget: &budget };
    let table = super::read(Path::new("a.mat"), &bomb(1 << 20, 1 << 31), None, &take).unwrap();
    assert!(matches!(table.columns[..], [Cells::Unread]));
}

#[test]
fn more_variables_than_are_read_are_refused() {
    let many: Vec<(u8, &[f64])> = (0..=MOST_COLUMNS).map(|_| (b'x', &[] as &[f64])).collect();
    let error = refused(&encode(&many, false));
    assert!(error.contains("more than 16384 variables"), "{error}");
}
