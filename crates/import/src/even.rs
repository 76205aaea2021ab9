//! The quick way through a text in which all is plain, as in most long ones: every line is a record of
//! as many cells, and mapped cells are numbers in digits. One walk finds the cells and reads their
//! numbers. Whatever is written otherwise is left to `csv`, which reads anything, and says what is
//! wrong with it: both give the same table.

use super::blocks::Block;
use super::csv::{self, Dialect, WHITE_SPACE};
use super::limits::{MOST_LINE, Take};
use super::recording::number;
use super::table::{Cells, Table};
use arrow::array::{Float64Array, LargeStringBuilder};
use std::path::Path;

/// What is taken of a column.
enum Taken {
    Nothing,
    Numbers(Vec<f64>),
    Texts(LargeStringBuilder),
}

/// The table of a block. Of the columns taken those for which `is_number` holds, by place and name, must
/// have numbers alone, and have them already. Nothing if anything in the block is not plain.
pub(super) fn read(
    path: &Path,
    block: &Block,
    take: &Take,
    is_number: &dyn Fn(usize, Option<&str>) -> bool,
) -> Option<Table> {
    let Block { text, dialect, header } = block;
    let records = &text[*header..];
    let is_plain = dialect.delimiter != WHITE_SPACE && records.is_ascii();
    if !is_plain || records.contains(&b'"') {
        return None;
    }
    let first = 1 + records.iter().position(|byte| *byte == b'\n')?;
    // What comes before the records, and what they are taken for, is as everywhere.
    let head = csv::read(path, &text[..header + first], *dialect, take).ok()?;
    let [line] = head.lines[..] else { return None };
    // Of lines as long as the first there are so many.
    let lines = records.len() / first + 1;
    let mut columns: Vec<Taken> = (0..head.columns.len())
        .map(|place| {
            let name = head.names.as_ref().and_then(|names| names.get(place)).map(String::as_str);
            match &head.columns[place] {
                Cells::Unread => Taken::Nothing,
                _ if is_number(place, name) => Taken::Numbers(Vec::with_capacity(lines)),
                _ => Taken::Texts(LargeStringBuilder::new()),
            }
        })
        .collect();
    // A record with a number is not an empty one.
    columns.iter().find(|column| matches!(column, Taken::Numbers(_)))?;
    let mut rest = records;
    let mut rows = 0;
    while !rest.is_empty() {
        rest = record(rest, *dialect, &mut columns)?;
        rows += 1;
    }
    let columns = columns.into_iter().map(|column| match column {
        Taken::Nothing => Cells::Unread,
        Taken::Numbers(values) => Cells::Numbers(Float64Array::from(values)),
        Taken::Texts(mut texts) => Cells::Text(texts.finish()),
    });
    Some(Table { columns: columns.collect(), lines: (line..line + rows).collect(), ..head })
}

/// Takes the cells of the record that `text` begins with; what follows it. Nothing if it is not plain.
fn record<'a>(text: &'a [u8], dialect: Dialect, columns: &mut [Taken]) -> Option<&'a [u8]> {
    if text.first().copied() == dialect.comment {
        return None;
    }
    let mut rest = text;
    let last = columns.len() - 1;
    for (place, column) in columns.iter_mut().enumerate() {
        rest = match column {
            Taken::Numbers(values) => {
                let (value, after) = number_cell(rest, dialect.delimiter)?;
                values.push(value);
                after
            }
            Taken::Nothing => cell(rest, dialect.delimiter).1,
            Taken::Texts(texts) => {
                let (cell, after) = cell(rest, dialect.delimiter);
                let cell = std::str::from_utf8(cell).ok()?.trim();
                texts.append_option(Some(cell).filter(|cell| !cell.is_empty()));
                after
            }
        };
        if place < last {
            rest = rest.strip_prefix(&[dialect.delimiter])?;
        }
    }
    let rest = match rest {
        [] => rest,
        [b'\n', rest @ ..] | [b'\r', b'\n', rest @ ..] => rest,
        _ => return None,
    };
    (text.len() - rest.len() < MOST_LINE).then_some(rest)
}

/// The cell that `text` begins with, and what follows it.
fn cell(text: &[u8], delimiter: u8) -> (&[u8], &[u8]) {
    let end = text.iter().position(|byte| *byte == delimiter || matches!(byte, b'\n' | b'\r'));
    text.split_at(end.unwrap_or(text.len()))
}

/// The number in the cell that `text` begins with, and what follows the cell.
fn number_cell(text: &[u8], delimiter: u8) -> Option<(f64, &[u8])> {
    if let Some((value, after)) = decimal(text)
        && after.first().is_none_or(|next| *next == delimiter || matches!(next, b'\n' | b'\r'))
    {
        return Some((value, after));
    }
    let (cell, after) = cell(text, delimiter);
    let cell = std::str::from_utf8(cell).ok()?.trim();
    Some((number(cell, false).ok()??, after))
}

/// The largest whole number up to which a double holds each, 2⁵³.
const MOST_EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// Digits that a whole number of 64 bits holds, whatever they are.
const MOST_DIGITS: usize = 19;

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The number in digits that `text` begins with, and what follows them; nothing if there are too many
/// digits, or none.
///
/// Where a double holds both the digits as a whole number and the power of ten, their quotient is rounded
/// once, and so is the number nearest to what is written (Clinger, 1990, "How to read floating point
/// numbers accurately").
#[allow(clippy::cast_precision_loss)] // Checked.
fn decimal(text: &[u8]) -> Option<(f64, &[u8])> {
    let unsigned = text.strip_prefix(b"-").unwrap_or(text);
    let (whole, mut rest) = digits(0, unsigned);
    let (mut number, mut places) = (whole, 0);
    if let Some(decimals) = rest.strip_prefix(b".") {
        (number, rest) = digits(whole, decimals);
        places = decimals.len() - rest.len();
    }
    let written = &unsigned[..unsigned.len() - rest.len()];
    let fits = written.len() <= MOST_DIGITS && number <= MOST_EXACT;
    if !fits || !written.last()?.is_ascii_digit() {
        return None;
    }
    let value = number as f64 / POWERS.get(places)?;
    Some((if unsigned.len() < text.len() { -value } else { value }, rest))
}

/// `number`, with the digits that `text` begins with behind its own; and what follows them. What does not
/// fit is found by the number of digits.
fn digits(mut number: u64, text: &[u8]) -> (u64, &[u8]) {
    let mut rest = text;
    while let [digit @ b'0'..=b'9', after @ ..] = rest {
        number = number.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        rest = after;
    }
    (number, rest)
}

#[cfg(test)]
mod tests {
    use super::super::limits::tests::everything;
    use super::super::table::Cell;
    use super::super::text::Encoding;
    use super::*;

    const COMMA: Dialect = Dialect {
        delimiter: b',',
        header: true,
        comment: Some(b'#'),
        skip: 0,
        encoding: Encoding::Utf8,
        bad_lines: 0,
        before: 7,
    };

    /// These records, behind a header of three columns, the second of which is a label: read here, if they
    /// are plain, as everywhere.
    fn is_read(records: &str) -> bool {
        let header = "t,m,f\n";
        let text = format!("{header}{records}").into_bytes();
        let block = Block { text, dialect: COMMA, header: header.len() };
        let path = Path::new("a.csv");
        let is_number = |place: usize, _: Option<&str>| place != 1;
        let found = everything(|take| super::read(path, &block, take, &is_number));
        let Some(found) = found else { return false };
        let table = everything(|take| csv::read(path, &block.text, COMMA, take)).unwrap();
        assert_eq!((&found.names, &found.lines), (&table.names, &table.lines), "{records}");
        assert_eq!((&found.told, &found.empty), (&table.told, &table.empty), "{records}");
        for (found, expect) in found.columns.iter().zip(&table.columns) {
            assert_eq!(found.len(), expect.len(), "{records}");
            for row in 0..expect.len() {
                match (found.cell(row), expect.cell(row)) {
                    (Cell::Number(found), Cell::Text(expect)) => {
                        assert_eq!(Ok(Some(found)), number(expect, false), "{records}");
                    }
                    (found, expect) => assert_eq!(found, expect, "{records}"),
                }
            }
        }
        true
    }

    #[test]
    fn plain_records_are_read_as_everywhere() {
        for records in [
            "0,a,1\n1,b,2\n",
            "0,a,1\r\n1,b,2\r\n",
            "0,a,1\n1,b,2",
            "0.5, a ,-1.25\n1,,1e-3\n 2 ,b, +3\n",
            "0.1000000000000000055511151231257827,a,12345678901234567890\n",
        ] {
            assert!(is_read(records), "{records}");
        }
    }

    #[test]
    fn what_is_not_plain_is_left_to_the_reader_of_everything() {
        for records in [
            "0,a,1",
            "0,a,1\n\n1,b,2\n",
            "0,a,1\n# pause\n1,b,2\n",
            "0,a,1\n1,\"b\",2\n",
            "0,\u{e9},1\n1,b,2\n",
            "0,a,1\n1,b\n",
            "0,a,1\n1,b,2,3\n",
            "0,a,1\n1,b,\n",
            "0,a,1\n1,b,NA\n",
            "0,a,1\n1,b,nan\n",
            "0,a,1\n1,b,inf\n",
            "0,a,1\n1,b,1e999\n",
            "0,a,1\n1,b,x\n",
            "0,a,1\n1,b,true\n",
            "0,a,1\n1,b\r,2\n",
            "0,a,1\r1,b,2\r",
        ] {
            assert!(!is_read(records), "{records}");
        }
        assert!(!is_read(&format!("0,a,1\n1,{},2\n", "b".repeat(MOST_LINE))));
    }

    /// As the standard library reads it, or not at all.
    fn check(text: &str) {
        let expect: f64 = text.parse().unwrap();
        for (after, what) in [("", ""), (",1", ","), ("\n2", "\n"), (".5", ".")] {
            let whole = format!("{text}{after}");
            // A second point ends a number, and not its cell.
            if what == "." && !text.contains('.') {
                continue;
            }
            if let Some((value, rest)) = decimal(whole.as_bytes()) {
                assert_eq!(
                    (value.to_bits(), rest),
                    (expect.to_bits(), after.as_bytes()),
                    "{whole}"
                );
            }
        }
    }

    #[test]
    fn numbers_are_read_to_the_last_bit_as_the_standard_library_reads_them() {
        for text in ["0", "-0", "-0.0", "0.1", ".5", "-.5", "9007199254740992", "9007199254740993"]
        {
            check(text);
        }
        let mut state = 1_u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        let mut read = 0;
        for _ in 0..200_000 {
            let number = next() >> (next() % 64);
            let digits = number.to_string();
            let point = (next() % (1 + digits.len() as u64)) as usize;
            let sign = if next() % 2 == 0 { "-" } else { "" };
            let text = format!("{sign}{}.{}", &digits[..point], &digits[point..]);
            if !text.ends_with('.') {
                read += usize::from(decimal(text.as_bytes()).is_some());
                check(&text);
            }
        }
        assert!(read > 100_000, "{read}");
        for text in ["", "-", ".", "-.", "5.", "+1", "x", "12345678901234567890", "e5", "inf"] {
            assert_eq!(decimal(text.as_bytes()), None, "{text}");
        }
    }
}
