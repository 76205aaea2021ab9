//! The parameters of a C3D file: groups of named values.

use super::super::limits::{MOST_COLUMNS, MOST_NAME};
use std::collections::BTreeMap;

/// Bytes of a block; the file is counted in blocks from 1.
pub(super) const BLOCK: usize = 512;

/// How the processor wrote numbers that wrote the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Processor {
    /// The lowest byte first.
    Intel,
    /// The same of whole numbers; numbers with decimals as a VAX has them.
    Dec,
    /// The highest byte first.
    Mips,
}

impl Processor {
    fn of(byte: u8) -> Result<Self, String> {
        match byte {
            84 => Ok(Self::Intel),
            85 => Ok(Self::Dec),
            86 => Ok(Self::Mips),
            other => Err(format!("its numbers are written by an unknown processor, {other}")),
        }
    }

    /// A whole number of two bytes, without a sign.
    pub(super) fn word(self, bytes: &[u8]) -> Option<u16> {
        let bytes = *bytes.first_chunk::<2>()?;
        Some(match self {
            Self::Mips => u16::from_be_bytes(bytes),
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
        })
    }

    /// A number of four bytes with decimals.
    pub(super) fn float(self, bytes: &[u8]) -> Option<f32> {
        let [a, b, c, d] = *bytes.first_chunk::<4>()?;
        Some(match self {
            Self::Intel => f32::from_le_bytes([a, b, c, d]),
            Self::Mips => f32::from_be_bytes([a, b, c, d]),
            // The words are the other way round, and the exponent counts from 128 instead of 126.
            Self::Dec => f32::from_le_bytes([c, d, a, b]) / 4.0,
        })
    }
}

/// The values of a parameter, as they are written.
#[derive(Debug, Clone, PartialEq)]
struct Parameter<'a> {
    /// −1 letters, 1 bytes, 2 whole numbers, 4 numbers with decimals.
    kind: i8,
    size: Vec<usize>,
    data: &'a [u8],
}

/// The parameters of a file by `GROUP:NAME`, in capitals.
pub(super) struct Parameters<'a> {
    pub(super) processor: Processor,
    of: BTreeMap<String, Parameter<'a>>,
}

impl<'a> Parameters<'a> {
    /// Reads the section that begins at a block.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(super) fn read(bytes: &'a [u8], block: u8) -> Result<Self, String> {
        let cut_off = || "its parameters are cut off".to_owned();
        let begin = usize::from(block.saturating_sub(1)) * BLOCK;
        let processor = Processor::of(*bytes.get(begin + 3).ok_or_else(cut_off)?)?;
        let mut groups = BTreeMap::new();
        let mut named = Vec::new();
        let mut at = begin + 4;
        loop {
            let head =
                bytes.get(at..).and_then(|rest| rest.first_chunk::<2>()).ok_or_else(cut_off)?;
            // A name of negative length belongs to a parameter that is locked.
            let length = usize::from((head[0] as i8).unsigned_abs());
            let group = head[1] as i8;
            if length == 0 || group == 0 {
                break;
            }
            let name = bytes.get(at + 2..at + 2 + length).ok_or_else(cut_off)?;
            let name = String::from_utf8_lossy(name).trim().to_ascii_uppercase();
            let place = at + 2 + length;
            let next =
                bytes.get(place..).and_then(|rest| processor.word(rest)).ok_or_else(cut_off)?;
            if group < 0 {
                groups.insert(group.unsigned_abs(), name);
            } else {
                if named.len() == MOST_COLUMNS {
                    return Err(format!("it has more than {MOST_COLUMNS} parameters"));
                }
                named.push((group.unsigned_abs(), name, place + 2));
            }
            if next == 0 {
                break;
            }
            at = place + usize::from(next);
        }
        let mut of = BTreeMap::new();
        for (group, name, place) in named {
            let Some(group) = groups.get(&group) else { continue };
            let [kind, dimensions] =
                *bytes.get(place..).and_then(|rest| rest.first_chunk::<2>()).ok_or_else(cut_off)?;
            let from = place + 2 + usize::from(dimensions);
            let size = bytes.get(place + 2..from).ok_or_else(cut_off)?;
            let size: Vec<usize> = size.iter().map(|size| usize::from(*size)).collect();
            let kind = kind as i8;
            let count = size
                .iter()
                .try_fold(usize::from(kind.unsigned_abs()), |all, n| all.checked_mul(*n));
            let data = count
                .and_then(|count| bytes.get(from..from.checked_add(count)?))
                .ok_or_else(cut_off)?;
            // The first of a name: nothing keeps a file from having two.
            of.entry(format!("{group}:{name}")).or_insert(Parameter { kind, size, data });
        }
        Ok(Self { processor, of })
    }

    /// The numbers of a parameter; none where it is absent, or a text. Whole numbers carry a sign, or none.
    pub(super) fn numbers(&self, name: &str, signed: bool) -> Vec<f64> {
        let Some(Parameter { kind, data, .. }) = self.of.get(name) else { return Vec::new() };
        let word = |bytes: &[u8]| {
            let word = self.processor.word(bytes)?;
            Some(if signed { f64::from(word as i16) } else { f64::from(word) })
        };
        match kind {
            1 => data.iter().map(|byte| f64::from(*byte)).collect(),
            2 => data.chunks_exact(2).filter_map(word).collect(),
            4 => data
                .chunks_exact(4)
                .filter_map(|bytes| self.processor.float(bytes).map(f64::from))
                .collect(),
            _ => Vec::new(),
        }
    }

    /// The first number of a parameter, without a sign.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name, false).first().copied()
    }

    /// The texts of a parameter, without the blanks around them; none where it is absent, or not of texts.
    pub(super) fn texts(&self, name: &str) -> Vec<String> {
        let Some(Parameter { kind: -1, size, data }) = self.of.get(name) else { return Vec::new() };
        let length = size.first().copied().unwrap_or(1).clamp(1, MOST_NAME);
        data.chunks(length)
            .map(|text| String::from_utf8_lossy(text).trim_matches(['\0', ' ']).to_owned())
            .collect()
    }

    /// The texts of a list that goes on as `NAME2`, `NAME3`: a parameter has at most 255.
    pub(super) fn long_texts(&self, name: &str) -> Vec<String> {
        let further = (2..).map(|i| format!("{name}{i}"));
        let lists = std::iter::once(name.to_owned()).chain(further);
        lists
            .take_while(|name| self.of.contains_key(name))
            .flat_map(|name| self.texts(&name))
            .collect()
    }

    /// The same of numbers.
    pub(super) fn long_numbers(&self, name: &str, signed: bool) -> Vec<f64> {
        let further = (2..).map(|i| format!("{name}{i}"));
        let lists = std::iter::once(name.to_owned()).chain(further);
        let lists = lists.take_while(|name| self.of.contains_key(name));
        lists.flat_map(|name| self.numbers(&name, signed)).collect()
    }

    /// All values of a parameter as one text; nothing where it is absent.
    pub(super) fn in_words(&self, name: &str) -> Option<String> {
        let parameter = self.of.get(&name.to_ascii_uppercase())?;
        let name = name.to_ascii_uppercase();
        Some(match parameter.kind {
            -1 => self.texts(&name).join(" "),
            _ => Vec::from_iter(self.numbers(&name, true).iter().map(f64::to_string)).join(" "),
        })
    }
}
