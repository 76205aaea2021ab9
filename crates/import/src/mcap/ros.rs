//! Messages of ROS 2: their definitions, and their values in CDR.
//!
//! Source: ROS 2 documentation, "Interfaces" and "Interface definition" (`.msg`); MCAP specification, "Well-known schema
//! encodings", `ros2msg`; OMG, "DDS-XTypes" 1.3, 7.4.1 (encapsulation and alignment of XCDR version 1).

use super::values::Leaf;
use std::collections::HashMap;

/// Definitions within definitions that are followed.
const MOST_DEPTH: usize = 16;
/// Elements of a list that are columns; of a longer one, such as a picture, none is.
const MOST_ELEMENTS: usize = 256;

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Bytes of a whole number, and whether it has a sign.
    Whole(usize, bool),
    Float(usize),
    Bool,
    Text,
    /// Seconds and nanoseconds.
    Time {
        signed: bool,
    },
    Message(String),
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    /// As many as the message says.
    Any,
}

#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    kind: Kind,
    count: Count,
}

/// The definition of a message, with those that it names.
pub(super) struct Definition {
    root: Vec<Field>,
    of: HashMap<String, Vec<Field>>,
}

impl Definition {
    /// Reads the text of a definition, behind which those that it names stand between lines of `=`.
    ///
    /// # Errors
    /// What of it is not read here.
    pub(super) fn read(name: &str, text: &str) -> Result<Self, String> {
        let mut of = HashMap::new();
        let mut root = None;
        let mut lines = text.lines().peekable();
        let mut package = name.split('/').next().unwrap_or_default().to_owned();
        let mut current = None;
        while lines.peek().is_some() {
            let mut fields = Vec::new();
            for line in lines.by_ref() {
                let line = line.split('#').next().unwrap_or_default().trim();
                if line.len() > 2 && line.bytes().all(|byte| byte == b'=') {
                    break;
                }
                if let Some(named) = line.strip_prefix("MSG:") {
                    let named = named.trim();
                    package = named.split('/').next().unwrap_or_default().to_owned();
                    current = Some(short(named));
                } else if let Some(field) = field(line, &package)? {
                    fields.push(field);
                }
            }
            match current.take() {
                None if root.is_none() => root = Some(fields),
                None => {}
                Some(name) => {
                    of.entry(name).or_insert(fields);
                }
            }
        }
        Ok(Self { root: root.unwrap_or_default(), of })
    }

    /// Gives every value of a message by its path.
    ///
    /// # Errors
    /// Its bytes are not those of such a message.
    pub(super) fn walk(
        &self,
        data: &[u8],
        each: &mut dyn FnMut(&str, Leaf) -> Result<(), String>,
    ) -> Result<(), String> {
        let big = match data {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            _ => return Err("a message is not in plain CDR".to_owned()),
        };
        let mut reader = Reader { data: &data[4..], at: 0, big };
        self.fields(&self.root, &mut reader, &mut String::new(), 0, each)
    }

    fn fields(
        &self,
        fields: &[Field],
        reader: &mut Reader,
        path: &mut String,
        depth: usize,
        each: &mut dyn FnMut(&str, Leaf) -> Result<(), String>,
    ) -> Result<(), String> {
        if depth > MOST_DEPTH {
            return Err("its definition is deeper than any message".to_owned());
        }
        if fields.is_empty() {
            // A message without fields has one byte.
            reader.take(1)?;
        }
        let length = path.len();
        for field in fields {
            if length > 0 {
                path.push('.');
            }
            path.push_str(&field.name);
            match field.count {
                Count::One => self.value(&field.kind, reader, path, depth, each)?,
                Count::Fixed(count) => self.list(count, field, reader, path, depth, each)?,
                Count::Any => {
                    let count = reader.whole(4, false)? as usize;
                    self.list(count, field, reader, path, depth, each)?;
                }
            }
            path.truncate(length);
        }
        Ok(())
    }

    fn list(
        &self,
        count: usize,
        field: &Field,
        reader: &mut Reader,
        path: &mut String,
        depth: usize,
        each: &mut dyn FnMut(&str, Leaf) -> Result<(), String>,
    ) -> Result<(), String> {
        if count > MOST_ELEMENTS {
            each(path, Leaf::Long(count))?;
        }
        let length = path.len();
        for i in 0..count {
            if i < MOST_ELEMENTS && count <= MOST_ELEMENTS {
                path.push_str(&format!("[{i}]"));
                self.value(&field.kind, reader, path, depth, each)?;
                path.truncate(length);
            } else {
                self.value(&field.kind, reader, path, depth, &mut |_, _| Ok(()))?;
            }
        }
        Ok(())
    }

    fn value(
        &self,
        kind: &Kind,
        reader: &mut Reader,
        path: &mut String,
        depth: usize,
        each: &mut dyn FnMut(&str, Leaf) -> Result<(), String>,
    ) -> Result<(), String> {
        let leaf = match kind {
            Kind::Whole(size, signed) => Leaf::Whole(reader.whole(*size, *signed)?),
            Kind::Float(4) => {
                Leaf::Number(f64::from(f32::from_bits(reader.whole(4, false)? as u32)))
            }
            Kind::Float(_) => Leaf::Number(f64::from_bits(reader.whole(8, false)? as u64)),
            Kind::Bool => Leaf::Whole(i128::from(reader.whole(1, false)? != 0)),
            Kind::Time { signed } => {
                let (s, ns) = (reader.whole(4, *signed)?, reader.whole(4, false)?);
                Leaf::Nanoseconds(s * 1_000_000_000 + ns)
            }
            Kind::Text => {
                let length = reader.whole(4, false)? as usize;
                let text = reader.take(length)?;
                // With the zero that ends it.
                let text = text.strip_suffix(b"\0").unwrap_or(text);
                return each(path, Leaf::Text(&String::from_utf8_lossy(text)));
            }
            Kind::Message(name) => {
                let fields = self.of.get(name);
                let fields =
                    fields.ok_or_else(|| format!("the definition of '{name}' is absent"))?;
                return self.fields(fields, reader, path, depth + 1, each);
            }
        };
        each(path, leaf)
    }
}

/// `package/Name` of `package/msg/Name`.
fn short(name: &str) -> String {
    let mut parts = name.split('/');
    let (package, last) = (parts.next().unwrap_or_default(), parts.next_back());
    last.map_or_else(|| package.to_owned(), |last| format!("{package}/{last}"))
}

/// A line of a definition; nothing of a blank one, and of one that names a constant.
fn field(line: &str, package: &str) -> Result<Option<Field>, String> {
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else { return Ok(None) };
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, size)) => match size.trim_end_matches(']').parse() {
            Ok(size) => (kind, Count::Fixed(size)),
            Err(_) => (kind, Count::Any),
        },
    };
    // A text may be bounded: `string<=10`.
    let kind = kind.split("<=").next().unwrap_or_default();
    let kind = match kind {
        "bool" => Kind::Bool,
        "byte" | "char" | "uint8" => Kind::Whole(1, false),
        "int8" => Kind::Whole(1, true),
        "int16" => Kind::Whole(2, true),
        "uint16" => Kind::Whole(2, false),
        "int32" => Kind::Whole(4, true),
        "uint32" => Kind::Whole(4, false),
        "int64" => Kind::Whole(8, true),
        "uint64" => Kind::Whole(8, false),
        "float32" => Kind::Float(4),
        "float64" => Kind::Float(8),
        "string" => Kind::Text,
        "wstring" => return Err("it has texts of wide letters (wstring)".to_owned()),
        "time" | "builtin_interfaces/Time" | "builtin_interfaces/msg/Time" => {
            Kind::Time { signed: true }
        }
        "duration" | "builtin_interfaces/Duration" | "builtin_interfaces/msg/Duration" => {
            Kind::Time { signed: true }
        }
        "Header" => Kind::Message("std_msgs/Header".to_owned()),
        named if named.contains('/') => Kind::Message(short(named)),
        named => Kind::Message(format!("{package}/{named}")),
    };
    let name = name.to_owned();
    Ok(Some(Field { name, kind, count }))
}

/// Reads values, each at a multiple of its size.
struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, size: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(size);
        let taken = end.and_then(|end| self.data.get(self.at..end));
        self.at = self.at.saturating_add(size);
        taken.ok_or_else(|| "a message is shorter than its definition".to_owned())
    }

    fn whole(&mut self, size: usize, signed: bool) -> Result<i128, String> {
        self.at = self.at.next_multiple_of(size);
        let big = self.big;
        let kind = match signed {
            true => super::super::table::NumberKind::Signed,
            false => super::super::table::NumberKind::Unsigned,
        };
        Ok(super::super::table::Number { kind, size, big }.whole(self.take(size)?))
    }
}
