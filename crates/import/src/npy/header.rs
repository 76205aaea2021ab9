//! The description of an array: a Python dictionary of type, order and shape.

use crate::limits::{MOST_COLUMNS, MOST_NAME};
use crate::table::{Number, NumberKind};

/// The first bytes of every array.
const MAGIC: &[u8] = b"\x93NUMPY";
/// Bytes of a header that is read: no array of a few thousand fields needs more.
const MOST_HEADER: usize = 1 << 20;
/// Dimensions of an array, the most that NumPy has.
const MOST_DIMENSIONS: usize = 64;
/// Values within values of a header.
const DEEPEST: usize = 8;

/// The description of an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) shape: Vec<usize>,
    /// Whether a matrix lies column by column.
    pub(super) by_columns: bool,
    /// Bytes of an item.
    pub(super) item: usize,
    /// The one value of an item, without a name, or its fields.
    pub(super) members: Vec<Member>,
}

/// A value of an item.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) name: Option<String>,
    pub(super) offset: usize,
    pub(super) size: usize,
    pub(super) kind: Kind,
}

/// What a value is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    Number(Number),
    /// Four bytes a letter; `big`: the first is the highest.
    Unicode {
        big: bool,
    },
    /// One byte a letter.
    Bytes,
    /// Neither number nor text: why, in words, and what to save instead.
    Other(String),
}

impl Header {
    /// The number of items; `None` if it cannot be counted.
    pub(super) fn values(&self) -> Option<usize> {
        self.shape.iter().try_fold(1_usize, |n, size| n.checked_mul(*size))
    }
}

/// Reads what stands before the values, and gives the values' bytes.
pub(super) fn read(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("it does not begin as an array does")?;
    let ([major, _minor], rest) = rest.split_first_chunk::<2>().ok_or(CUT)?;
    let (length, rest) = match major {
        1 => {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or(CUT)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or(CUT)?;
            (u32::from_le_bytes(*length) as usize, rest)
        }
        other => return Err(format!("its format has version {other}; 1 to 3 are read")),
    };
    if length > MOST_HEADER {
        return Err(format!(
            "its header claims {length} bytes, and at most {MOST_HEADER} are read"
        ));
    }
    let (text, data) = rest.split_at_checked(length).ok_or(CUT)?;
    let text = std::str::from_utf8(text).map_err(|_| "its header is not text".to_owned())?;
    Ok((header(text)?, data))
}

const CUT: &str = "it is cut off in its header";

fn header(text: &str) -> Result<Header, String> {
    let mut reader = Reader { rest: text.trim_end() };
    let value = reader.value(0).filter(|_| reader.rest.is_empty());
    let Some(Literal::Dict(entries)) = value else {
        return Err("its header does not list type, order and shape".to_owned());
    };
    let by_columns = matches!(entry(&entries, "fortran_order"), Some(Literal::Bool(true)));
    let Some(Literal::List(lengths)) = entry(&entries, "shape") else {
        return Err("it gives no shape".to_owned());
    };
    if lengths.len() > MOST_DIMENSIONS {
        return Err(format!("it has more than {MOST_DIMENSIONS} dimensions"));
    }
    let shape = sizes(lengths).ok_or("its shape cannot be read")?;
    let (item, members) = members(entry(&entries, "descr").ok_or("it gives no type")?)?;
    Ok(Header { shape, by_columns, item, members })
}

fn entry<'e>(entries: &'e [(String, Literal)], key: &str) -> Option<&'e Literal> {
    entries.iter().find(|(own, _)| own == key).map(|(_, value)| value)
}

/// The numbers in a list; nothing if something else is among them.
fn sizes(list: &[Literal]) -> Option<Vec<usize>> {
    let sizes = list.iter().map(|size| match size {
        Literal::Int(n) => usize::try_from(*n).ok(),
        _ => None,
    });
    sizes.collect()
}

/// The bytes of an item, and its values.
fn members(descr: &Literal) -> Result<(usize, Vec<Member>), String> {
    let fields = match descr {
        Literal::Text(code) => {
            let (kind, size) = kind(code)?;
            return Ok((size, vec![Member { name: None, offset: 0, size, kind }]));
        }
        Literal::List(fields) => fields,
        _ => return Err(no_type()),
    };
    if fields.is_empty() || fields.len() > MOST_COLUMNS {
        return Err(format!("it has {} fields, and 1 to {MOST_COLUMNS} are read", fields.len()));
    }
    let mut offset = 0_usize;
    let mut members = Vec::new();
    for field in fields {
        let (name, code, repeats) = field_of(field).ok_or_else(no_type)?;
        if name.len() > MOST_NAME {
            return Err(format!("a field's name has more than {MOST_NAME} bytes"));
        }
        let (kind, size) = kind(code)?;
        let (kind, size) = match repeats {
            None => (kind, Some(size)),
            Some(n) => {
                (Kind::Other("it holds an array in each row".to_owned()), size.checked_mul(n))
            }
        };
        let size = size.ok_or_else(no_type)?;
        // A gap between fields has no name.
        if !name.is_empty() {
            members.push(Member { name: Some(name.to_owned()), offset, size, kind });
        }
        offset = offset.checked_add(size).ok_or_else(no_type)?;
    }
    Ok((offset, members))
}

/// The name of a field of a structured array, its type, and the number of values in each row if it holds arrays.
fn field_of(field: &Literal) -> Option<(&str, &str, Option<usize>)> {
    let Literal::List(parts) = field else { return None };
    let name = match parts.first()? {
        // A title beside the name.
        Literal::List(both) => both.last()?,
        name => name,
    };
    let (Literal::Text(name), Literal::Text(code)) = (name, parts.get(1)?) else { return None };
    let repeats = match parts.get(2) {
        None => None,
        Some(Literal::List(lengths)) => {
            Some(sizes(lengths)?.into_iter().try_fold(1_usize, usize::checked_mul)?)
        }
        Some(_) => return None,
    };
    Some((name.as_str(), code.as_str(), repeats))
}

/// The kind that a type code means, and its size in bytes: `<f8`, `|S7`, `<U3`.
fn kind(code: &str) -> Result<(Kind, usize), String> {
    let (order, rest) = code.split_at_checked(1).ok_or_else(no_type)?;
    let (letter, size) = rest.split_at_checked(1).ok_or_else(no_type)?;
    let big = order == ">";
    // A date has its unit behind it.
    let digits = size.split('[').next().unwrap_or_default();
    let size: usize = if digits.is_empty() { 0 } else { digits.parse().map_err(|_| no_type())? };
    let number = |kind| Kind::Number(Number { kind, size, big });
    let other = |what: &str| Kind::Other(what.to_owned());
    let kind = match (letter, size) {
        ("f", 4 | 8) => number(NumberKind::Float),
        ("i", 1 | 2 | 4 | 8) => number(NumberKind::Signed),
        ("u", 1 | 2 | 4 | 8) => number(NumberKind::Unsigned),
        ("U", letters) => {
            let size = letters.checked_mul(4).ok_or_else(no_type)?;
            return Ok((Kind::Unicode { big }, size));
        }
        ("S" | "a", _) => Kind::Bytes,
        ("O", _) => {
            let what = "it holds Python objects, which are not read; save numbers or text";
            return Err(what.to_owned());
        }
        ("b", _) => other("it holds yes or no; save it as numbers"),
        ("f" | "g", _) => other("it holds numbers of 2 or 16 bytes; save it as float64"),
        ("c", _) => other("it holds complex numbers; save real and imaginary part apart"),
        ("M" | "m", _) => other("it holds dates; save seconds as float64"),
        ("V", _) => other("it holds bytes without a type; save it as float64"),
        _ => return Err(no_type()),
    };
    Ok((kind, size))
}

fn no_type() -> String {
    "its type is not one that NumPy writes".to_owned()
}

impl Kind {
    /// A value as text, without the zeros behind it.
    pub(super) fn text(&self, bytes: &[u8]) -> Result<String, String> {
        const NO_TEXT: &str = "a text in it cannot be read";
        let Self::Unicode { big } = self else {
            let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
            return String::from_utf8(bytes[..end].to_vec()).map_err(|_| NO_TEXT.to_owned());
        };
        let letters = bytes.chunks(4).map(|four| {
            let four: [u8; 4] = four.try_into().ok()?;
            char::from_u32(if *big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
        });
        let text: Option<String> = letters.collect();
        Ok(text.ok_or(NO_TEXT)?.trim_end_matches('\0').to_owned())
    }
}

/// A value of a header.
#[derive(Debug, Clone, PartialEq)]
enum Literal {
    Text(String),
    Int(u64),
    Bool(bool),
    /// A list or a tuple.
    List(Vec<Literal>),
    Dict(Vec<(String, Literal)>),
}

/// Reads Python's way to write values.
struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    /// Passes `what` by if it comes next, and says whether it did.
    fn passes(&mut self, what: &str) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(what) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn value(&mut self, depth: usize) -> Option<Literal> {
        if depth > DEEPEST {
            return None;
        }
        if self.passes("{") {
            let entries = self.items("}", |reader| {
                let quote = reader.rest.chars().next().filter(|c| ['\'', '"'].contains(c))?;
                let key = reader.text(quote)?;
                reader.passes(":").then_some(())?;
                Some((key, reader.value(depth + 1)?))
            });
            return entries.map(Literal::Dict);
        }
        for (open, close) in [("(", ")"), ("[", "]")] {
            if self.passes(open) {
                return self.items(close, |reader| reader.value(depth + 1)).map(Literal::List);
            }
        }
        if self.passes("True") {
            return Some(Literal::Bool(true));
        }
        if self.passes("False") {
            return Some(Literal::Bool(false));
        }
        match self.rest.chars().next()? {
            quote @ ('\'' | '"') => self.text(quote).map(Literal::Text),
            _ => {
                let end = self.rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.rest.len());
                let (digits, rest) = self.rest.split_at(end);
                // Python 2 wrote long ones with an L.
                self.rest = rest.strip_prefix('L').unwrap_or(rest).trim_start();
                digits.parse().ok().map(Literal::Int)
            }
        }
    }

    /// What stands between commas up to `close`.
    fn items<T>(&mut self, close: &str, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let mut all = Vec::new();
        while !self.passes(close) {
            all.push(item(self)?);
            if !self.passes(",") && !self.rest.starts_with(close) {
                return None;
            }
        }
        Some(all)
    }

    /// A text in quotes; one with a backslash is read by nobody here.
    fn text(&mut self, quote: char) -> Option<String> {
        let inside = self.rest.strip_prefix(quote)?;
        let (text, rest) = inside.split_once(quote)?;
        self.rest = rest.trim_start();
        (!text.contains('\\')).then(|| text.to_owned())
    }
}
