//! MAT files of version 5 (MATLAB `-v6` and `-v7`; SciPy, Octave): real numeric variables.
//!
//! Source of the format: MathWorks, "MAT-File Format" (R2024b), "Level 5 MAT-File Format".

use super::limits::{MOST_COLUMNS, MOST_NAME, MOST_UNPACKED, Take, shown};
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

/// Most bytes of the beginning of a variable: its flags, its size in [`MOST_DIMENSIONS`], its name.
const HEAD: u64 = 2 * MOST_NAME as u64;
/// Most dimensions of a variable.
const MOST_DIMENSIONS: usize = 32;

/// Reads a MAT file: its vectors by name, or with `matrix` the columns of that variable by position.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    matrix: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let remedy = "the file may be cut off or damaged; save it again with -v7, without what is not needed";
    let cannot = |what| StoreError::new(path, format!("not a readable MAT file: {what}"), remedy);
    let Some(matrix) = matrix else {
        let mut table = Table { names: Some(Vec::new()), ..Table::default() };
        variables(bytes, &mut |head, data| {
            let place = table.columns.len();
            let cells = if take.wants(place, Some(&head.name)) {
                vector(head, data, take)
            } else {
                Ok(Cells::Unread)
            };
            table.columns.push(cells?);
            table.names.get_or_insert_default().push(head.name.clone());
            Ok(())
        })
        .map_err(cannot)?;
        return Ok(table);
    };
    let (mut names, mut found) = (Vec::new(), None);
    variables(bytes, &mut |head, data| {
        if head.name == matrix && found.is_none() {
            found = Some(columns(head, data, take)?);
        }
        names.push(shown(&head.name).into_owned());
        Ok(())
    })
    .map_err(cannot)?;
    let missing = || format!("the variable is missing; the file has {}", names.join(", "));
    let table = found.unwrap_or_else(|| Err(missing()));
    table.map_err(|what| {
        StoreError::new(path, what, "set matrix in [file] to a numeric matrix of the file").column(matrix)
    })
}

/// What a variable says of itself before its values.
struct Head {
    name: String,
    size: Vec<usize>,
    /// What it is where it is not a real numeric array.
    class: Option<&'static str>,
}

/// The values of a variable, not decoded yet.
struct Numbers<'a> {
    kind: u32,
    data: &'a [u8],
    big: bool,
}

/// Gives the values of the variable at hand; only who asks has them unpacked.
type Values<'a> = &'a dyn Fn(&mut dyn FnMut(Numbers) -> Option<()>) -> Result<(), String>;

/// A variable as a column: its values if it is a vector of numbers, else why not.
fn vector(head: &Head, values: Values, take: &Take) -> Result<Cells, String> {
    if let Some(class) = head.class {
        return Ok(Cells::Other(format!("it is {class}; save what is wanted of it as a numeric variable")));
    }
    if head.size.iter().filter(|n| **n != 1).count() > 1 {
        let size = head.size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
        return Ok(Cells::Other(format!(
            "it is a {size} matrix; name it as matrix in [file] to use its columns"
        )));
    }
    let mut cells = Cells::Unread;
    let mut fits = true;
    values(&mut |numbers| {
        let n = numbers.count()?;
        fits = take.budget.cells(n);
        if fits && Some(n) == head.count() {
            cells = Cells::Numbers(Float64Array::from(numbers.values(0, n)?));
        }
        (!fits || matches!(cells, Cells::Numbers(_))).then_some(())
    })?;
    if fits { Ok(cells) } else { Err(TOO_MUCH.to_owned()) }
}

/// A matrix' columns by position, or why it has none.
fn columns(head: &Head, values: Values, take: &Take) -> Result<Result<Table, String>, String> {
    if let Some(class) = head.class {
        return Ok(Err(format!("the variable is {class}")));
    }
    let &[rows, columns] = head.size.as_slice() else {
        return Ok(Err(format!("the variable has {} dimensions where 2 belong", head.size.len())));
    };
    if columns > MOST_COLUMNS {
        return Err(format!("the matrix has {columns} columns, and at most {MOST_COLUMNS} are read"));
    }
    let mut table = Table::default();
    let mut fits = true;
    values(&mut |numbers| {
        let whole = numbers.count() == head.count();
        for place in (0..columns).filter(|_| whole && rows > 0) {
            let wanted = take.wants(place, None);
            fits = fits && (!wanted || take.budget.cells(rows));
            table.columns.push(match wanted && fits {
                true => Cells::Numbers(Float64Array::from(numbers.values(place * rows, rows)?)),
                false => Cells::Unread,
            });
        }
        whole.then_some(())
    })?;
    if fits { Ok(Ok(table)) } else { Err(TOO_MUCH.to_owned()) }
}

/// Stands for the error of the budget, which takes its place.
const TOO_MUCH: &str = "it has more values than are read";

/// Goes through the variables of a file.
fn variables(bytes: &[u8], each: &mut dyn FnMut(&Head, Values) -> Result<(), String>) -> Result<(), String> {
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
    let mut last: Option<String> = None;
    for count in 1.. {
        if elements.bytes.is_empty() {
            break;
        }
        if count > MOST_COLUMNS {
            return Err(format!("it has more than {MOST_COLUMNS} variables, and no more are read"));
        }
        let damaged = || match &last {
            None => "its first variable is cut off or damaged".to_owned(),
            Some(name) => format!("it is cut off or damaged after variable '{}'", shown(name)),
        };
        let (kind, data) = elements.next().ok_or_else(damaged)?;
        // Of a compressed variable only the beginning is unpacked, until its values are asked for.
        let beginning = match kind {
            mi::MATRIX => Vec::new(),
            mi::COMPRESSED => inflate(data, HEAD).ok_or_else(damaged)?,
            _ => return Err(damaged()),
        };
        let (size, plain) = match kind {
            mi::MATRIX => (data.len() as u64, data),
            _ => matrix_tag(&beginning, big).ok_or_else(damaged)?,
        };
        let (head, _) = head(plain, big).ok_or_else(damaged)?;
        each(&head, &|take| match kind {
            mi::MATRIX => real_part(data, big).and_then(&mut *take).ok_or_else(damaged),
            _ => {
                if size > MOST_UNPACKED {
                    let name = shown(&head.name);
                    return Err(format!(
                        "variable '{name}' unpacks to {size} bytes, and at most {MOST_UNPACKED} are read"
                    ));
                }
                let plain = inflate(data, ALIGN as u64 + size).ok_or_else(damaged)?;
                let matrix = Elements { bytes: &plain, big }.next().map(|(_, data)| data);
                matrix.and_then(|data| real_part(data, big)).and_then(&mut *take).ok_or_else(damaged)
            }
        })?;
        last = Some(head.name);
    }
    Ok(())
}

/// The first bytes of a compressed element, at most `most`: what it claims of its size decides nothing.
fn inflate(data: &[u8], most: u64) -> Option<Vec<u8>> {
    let mut plain = Vec::new();
    ZlibDecoder::new(data).take(most).read_to_end(&mut plain).ok()?;
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

/// The size that the tag of a matrix gives, bytes, and what follows the tag.
fn matrix_tag(bytes: &[u8], big: bool) -> Option<(u64, &[u8])> {
    let (tag, data) = bytes.split_at_checked(ALIGN)?;
    let word = |at: usize| Some(word(tag.get(at..at + 4)?.try_into().ok()?, big));
    (word(0)? == mi::MATRIX).then_some((u64::from(word(4)?), data))
}

/// What a matrix says of itself, and the elements behind.
fn head(data: &[u8], big: bool) -> Option<(Head, Elements<'_>)> {
    let mut parts = Elements { bytes: data, big };
    let (_, flags) = parts.next()?;
    let flags = word(flags.get(..4)?.try_into().ok()?, big);
    let (kind, size) = parts.next()?;
    let size = Numbers { kind, data: size, big };
    let dimensions = size.count().filter(|n| *n <= MOST_DIMENSIONS)?;
    let size = size.values(0, dimensions)?.into_iter().map(whole).collect::<Option<Vec<_>>>()?;
    let (_, name) = parts.next()?;
    let name = String::from_utf8_lossy(name.get(..MOST_NAME).unwrap_or(name)).into_owned();
    Some((Head { name, size, class: not_numeric(flags) }, parts))
}

/// The values of a matrix, as they lie in the file.
fn real_part(data: &[u8], big: bool) -> Option<Numbers<'_>> {
    let (kind, data) = head(data, big)?.1.next()?;
    Some(Numbers { kind, data, big })
}

impl Head {
    /// How many values the variable has, by its size.
    fn count(&self) -> Option<usize> {
        self.size.iter().try_fold(1_usize, |n, d| n.checked_mul(*d))
    }
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

/// MATLAB stores whole numbers in the smallest type that holds them.
impl Numbers<'_> {
    /// Bytes of a value.
    fn width(&self) -> Option<usize> {
        match self.kind {
            mi::INT8 | mi::UINT8 => Some(1),
            mi::INT16 | mi::UINT16 => Some(2),
            mi::INT32 | mi::UINT32 | mi::SINGLE => Some(4),
            mi::DOUBLE | mi::INT64 | mi::UINT64 => Some(8),
            _ => None,
        }
    }

    /// How many values there are.
    fn count(&self) -> Option<usize> {
        Some(self.data.len() / self.width()?)
    }

    /// `n` values from the one at `from` on.
    #[allow(clippy::cast_precision_loss)]
    fn values(&self, from: usize, n: usize) -> Option<Vec<f64>> {
        let width = self.width()?;
        let data = self.data.get(from.checked_mul(width)?..from.checked_add(n)?.checked_mul(width)?)?;
        let big = self.big;
        macro_rules! all {
            ($type:ty) => {
                data.chunks_exact(size_of::<$type>())
                    .map(|chunk| {
                        let bytes = chunk.try_into().ok()?;
                        let value =
                            if big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) };
                        Some(value as f64)
                    })
                    .collect()
            };
        }
        match self.kind {
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
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::limits::{Budget, tests::everything};
    use super::super::table::{Cell, ColumnRef};
    use super::*;
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write as _;

    fn read(path: &Path, bytes: &[u8], matrix: Option<&str>) -> Result<Table, StoreError> {
        everything(|take| super::read(path, bytes, matrix, take))
    }

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

    /// A MAT file of one compressed variable `x`, of which `zeros` bytes of values are there and `claimed` are claimed.
    fn bomb(zeros: usize, claimed: u32) -> Vec<u8> {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
        let n = claimed / 8;
        let head = [mi::MATRIX, 48 + claimed, mi::UINT32, 8, 6, 0, mi::INT32, 8, 1, n, 1 << 16 | mi::INT8];
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
        assert!(error.contains("variable 'x' unpacks to 536870960 bytes, and at most 268435456"), "{error}");
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
}
