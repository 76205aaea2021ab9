//! MAT files of version 5 (MATLAB `-v6` and `-v7`; SciPy, Octave): real numeric variables.
//!
//! Source of the format: MathWorks, "MAT-File Format" (R2024b), "Level 5 MAT-File Format".

use super::table::{Cells, Table};
use crate::StoreError;
use arrow::array::Float64Array;
use flate2::read::ZlibDecoder;
use std::io::Read as _;
use std::path::Path;

/// Length of the header; its last two bytes give the byte order, the two before the version.
const HEADER: usize = 128;
/// Elements begin at multiples of this many bytes.
const ALIGN: usize = 8;
/// Most bytes that a small element carries in its tag.
const SMALL: usize = 4;

/// Data types of elements (table "MAT-File Data Types").
mod mi {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT8: u32 = 2;
    pub(super) const INT16: u32 = 3;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const INT64: u32 = 12;
    pub(super) const UINT64: u32 = 13;
    pub(super) const MATRIX: u32 = 14;
    pub(super) const COMPRESSED: u32 = 15;
}

/// Flag of a complex array, in the array flags.
const COMPLEX: u32 = 0x0800;

/// Reads a MAT file: its vectors by name, or with `matrix` the columns of that variable by position.
pub(super) fn read(path: &Path, bytes: &[u8], matrix: Option<&str>) -> Result<Table, StoreError> {
    let remedy = "the file may be cut off or damaged; save it again with -v7";
    let variables = variables(bytes)
        .map_err(|what| StoreError::new(path, format!("not a readable MAT file: {what}"), remedy))?;
    match matrix {
        None => Ok(vectors(variables)),
        Some(name) => columns(variables, name).map_err(|what| {
            StoreError::new(path, what, "set matrix in [file] to a numeric matrix of the file").column(name)
        }),
    }
}

/// A variable of the file: its name, its size, and its values, first dimension fastest.
struct Variable {
    name: String,
    size: Vec<usize>,
    values: Result<Vec<f64>, &'static str>,
}

fn vectors(variables: Vec<Variable>) -> Table {
    let mut table = Table { names: Some(Vec::new()), ..Table::default() };
    for Variable { name, size, values } in variables {
        let long = size.iter().filter(|n| **n != 1).count();
        table.columns.push(match values {
            Ok(values) if long <= 1 => Cells::Numbers(Float64Array::from(values)),
            Ok(_) => {
                let size = size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
                Cells::Other(format!("it is a {size} matrix; name it as matrix in [file] to use its columns"))
            }
            Err(class) => {
                Cells::Other(format!("it is {class}; save what is wanted of it as a numeric variable"))
            }
        });
        table.names.get_or_insert_default().push(name);
    }
    table
}

fn columns(variables: Vec<Variable>, name: &str) -> Result<Table, String> {
    let names = variables.iter().map(|v| v.name.as_str()).collect::<Vec<_>>().join(", ");
    let missing = format!("the variable is missing; the file has {names}");
    let variable = variables.into_iter().find(|v| v.name == name).ok_or(missing)?;
    let values = variable.values.map_err(|class| format!("the variable is {class}"))?;
    let &[rows, _] = variable.size.as_slice() else {
        return Err(format!("the variable has {} dimensions where 2 belong", variable.size.len()));
    };
    let column = |cells: &[f64]| Cells::Numbers(Float64Array::from(cells.to_vec()));
    let columns = values.chunks_exact(rows.max(1)).map(column).collect();
    Ok(Table { names: None, columns, lines: Vec::new() })
}

fn variables(bytes: &[u8]) -> Result<Vec<Variable>, String> {
    let header = bytes.get(..HEADER).ok_or("it is shorter than a MAT header")?;
    let big = match &header[HEADER - 2..] {
        b"IM" => false,
        b"MI" => true,
        _ => return Err("its header gives no byte order; only version 5 is read (save with -v7)".to_owned()),
    };
    let version = header[if big { HEADER - 4 } else { HEADER - 3 }];
    if version != 1 {
        return Err("it is a version 7.3 (HDF5) file; save it with -v7".to_owned());
    }
    let mut elements = Elements { bytes: &bytes[HEADER..], big };
    let mut found = Vec::new();
    while !elements.bytes.is_empty() {
        let (kind, data) = elements.next().ok_or_else(|| cut_after(&found))?;
        let variable = match kind {
            mi::MATRIX => variable(data, big),
            mi::COMPRESSED => inflate(data).and_then(|plain| {
                let (kind, data) = Elements { bytes: &plain, big }.next()?;
                (kind == mi::MATRIX).then(|| variable(data, big))?
            }),
            _ => None,
        };
        found.push(variable.ok_or_else(|| cut_after(&found))?);
    }
    Ok(found)
}

fn cut_after(found: &[Variable]) -> String {
    match found.last() {
        None => "its first variable is cut off or damaged".to_owned(),
        Some(last) => format!("it is cut off or damaged after variable '{}'", last.name),
    }
}

fn inflate(data: &[u8]) -> Option<Vec<u8>> {
    let mut plain = Vec::new();
    ZlibDecoder::new(data).read_to_end(&mut plain).ok()?;
    Some(plain)
}

/// The elements of a stretch of bytes, one after the other.
struct Elements<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl<'a> Elements<'a> {
    /// The next element's type and data; `None` where it is cut off.
    fn next(&mut self) -> Option<(u32, &'a [u8])> {
        let first = word(self.bytes.get(..4)?.try_into().ok()?, self.big);
        let (small, kind) = ((first >> 16) as usize, first & 0xffff);
        if small > 0 {
            let data = self.bytes.get(4..2 * SMALL)?.get(..small)?;
            self.bytes = &self.bytes[2 * SMALL..];
            return Some((kind, data));
        }
        let size = word(self.bytes.get(4..8)?.try_into().ok()?, self.big) as usize;
        let end = ALIGN.checked_add(size)?;
        let data = self.bytes.get(ALIGN..end)?;
        // Compressed elements follow each other without padding; the last one of all may lack it.
        let next = if first == mi::COMPRESSED { end } else { end.next_multiple_of(ALIGN) };
        self.bytes = self.bytes.get(next..).unwrap_or_default();
        Some((first, data))
    }
}

fn word(bytes: [u8; 4], big: bool) -> u32 {
    if big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
}

fn variable(data: &[u8], big: bool) -> Option<Variable> {
    let mut parts = Elements { bytes: data, big };
    let (_, flags) = parts.next()?;
    let flags = word(flags.get(..4)?.try_into().ok()?, big);
    let (size_kind, size) = parts.next()?;
    let size = numbers(size_kind, size, big)?.into_iter().map(whole).collect::<Option<Vec<_>>>()?;
    let (_, name) = parts.next()?;
    let name = String::from_utf8_lossy(name).into_owned();
    if let Some(class) = not_numeric(flags) {
        return Some(Variable { name, size, values: Err(class) });
    }
    let (kind, real) = parts.next()?;
    let values = numbers(kind, real, big)?;
    let expected = size.iter().try_fold(1_usize, |n, d| n.checked_mul(*d))?;
    (values.len() == expected).then_some(Variable { name, size, values: Ok(values) })
}

/// What the array is where it is not a real numeric one (table "MATLAB Array Types").
fn not_numeric(flags: u32) -> Option<&'static str> {
    match flags & 0xff {
        1 => Some("a cell array"),
        2 => Some("a struct"),
        4 => Some("text"),
        5 => Some("a sparse matrix"),
        6..=15 if flags & COMPLEX != 0 => Some("complex"),
        6..=15 => None,
        _ => Some("an object"),
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn whole(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0).then_some(value as usize)
}

/// The values of a numeric element; MATLAB stores whole numbers in the smallest type that holds them.
#[allow(clippy::cast_precision_loss)]
fn numbers(kind: u32, data: &[u8], big: bool) -> Option<Vec<f64>> {
    macro_rules! all {
        ($type:ty) => {
            data.chunks_exact(size_of::<$type>())
                .map(|chunk| {
                    let bytes = chunk.try_into().ok()?;
                    Some(
                        (if big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
                            as f64,
                    )
                })
                .collect()
        };
    }
    match kind {
        mi::INT8 => all!(i8),
        mi::UINT8 => all!(u8),
        mi::INT16 => all!(i16),
        mi::UINT16 => all!(u16),
        mi::INT32 => all!(i32),
        mi::UINT32 => all!(u32),
        mi::SINGLE => all!(f32),
        mi::DOUBLE => all!(f64),
        mi::INT64 => all!(i64),
        mi::UINT64 => all!(u64),
        _ => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::table::{Cell, ColumnRef};
    use super::*;

    /// `scipy.io.savemat(f, {"t": [0, .5, 1], "n": int32 [[1], [-2], [300]], "m": arange(6).reshape(3, 2),
    /// "s": {"a": 1}, "c": [1 + 2j], "w": "hi"}, do_compression=True)`, SciPy 1.17.1, without its header.
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
        for (name, words) in [("m", "a 3 × 2 matrix"), ("s", "a struct"), ("c", "complex"), ("w", "text")] {
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
            let head = [mi::MATRIX, 48 + 8 * n, mi::UINT32, 8, 6, 0, mi::INT32, 8, 1, n, 1 << 16 | mi::INT8];
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
}
