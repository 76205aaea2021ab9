//! The members of a JSON object that is too large for memory: one block of the file at a time.

use crate::record::in_words;
use serde::Deserialize;
use serde_json::value::RawValue;
use zwidth_store::Content;

/// Bytes that are read at a time (4 MiB).
const BLOCK: usize = 1 << 22;

/// Most bytes of one member (256 MiB).
const MOST_MEMBER: usize = 1 << 28;

/// A member of the object.
#[derive(Debug)]
pub(crate) struct Member<'b> {
    pub(crate) name: String,
    /// Its value as it stands there.
    pub(crate) value: &'b str,
    /// Where in the file the value begins.
    pub(crate) from: u64,
}

/// Gives all members of the object that a file holds to `take`, in order, several at a time.
///
/// # Errors
/// Why the file is not one object, in words; what `take` refuses.
pub(crate) fn members(
    file: &Content,
    take: impl FnMut(Vec<Member>) -> Result<(), String>,
) -> Result<(), String> {
    members_by(BLOCK, file, take)
}

fn members_by(
    block: usize,
    file: &Content,
    mut take: impl FnMut(Vec<Member>) -> Result<(), String>,
) -> Result<(), String> {
    let mut bytes = Vec::new();
    let mut from = 0;
    let mut before = Before::Object;
    loop {
        if bytes.len() > MOST_MEMBER {
            return Err(format!("a record has more than {MOST_MEMBER} bytes"));
        }
        let end = from + bytes.len() as u64;
        // Of a member longer than a block twice as much each time: it is parsed from its beginning
        // again, and block by block that would take time by the square of its length.
        let more = (file.length() - end).min(block.max(bytes.len()) as u64) as usize;
        bytes.reserve_exact(more);
        bytes.extend_from_slice(&file.range(end, more).map_err(|e| e.to_string())?);
        let mut at = At { bytes: &bytes, next: 0 };
        let whole = std::iter::from_fn(|| at.member(&mut before, from).transpose());
        let whole = whole.collect::<Result<Vec<_>, String>>();
        take(whole.map_err(|what| format!("{what} (near byte {})", from + at.next as u64))?)?;
        let read = at.next;
        if end + more as u64 == file.length() {
            return match before {
                Before::Nothing if at.rest().is_empty() => Ok(()),
                Before::Nothing => Err("something stands behind the last record".to_owned()),
                _ => Err("it ends in the middle".to_owned()),
            };
        }
        bytes.drain(..read);
        from += read as u64;
    }
}

/// What has been read so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Before {
    /// The object begins.
    Object,
    /// Its brace was read: a member follows, or the end.
    Brace,
    /// A member was read: a comma follows, or the end.
    Member,
    /// The object has ended: nothing follows.
    Nothing,
}

/// A place in a block.
struct At<'b> {
    bytes: &'b [u8],
    next: usize,
}

impl<'b> At<'b> {
    /// The next member; `None`, and at the same place as before, if the block does not have it whole,
    /// or there is none.
    fn member(&mut self, before: &mut Before, from: u64) -> Result<Option<Member<'b>>, String> {
        let place = self.next;
        if *before == Before::Object && self.sign(b"{")?.is_some() {
            *before = Before::Brace;
            return self.member(before, from);
        }
        let sign = match *before {
            Before::Brace if self.rest().first() == Some(&b'}') => self.sign(b"}")?,
            // A member follows as if after a comma.
            Before::Brace => Some(b','),
            Before::Member => self.sign(b",}")?,
            Before::Object | Before::Nothing => None,
        };
        match sign {
            Some(b'}') => {
                *before = Before::Nothing;
                return Ok(None);
            }
            Some(_) => {}
            None => return Ok(None),
        }
        let name = self.value::<String>()?;
        let colon = if name.is_some() { self.sign(b":")? } else { None };
        let value = if colon.is_some() { self.value::<&RawValue>()? } else { None };
        let (Some(name), Some(value)) = (name, value) else {
            // The block does not have all of it.
            self.next = place;
            return Ok(None);
        };
        *before = Before::Member;
        let value = value.get();
        Ok(Some(Member { name, value, from: from + (self.next - value.len()) as u64 }))
    }

    /// What follows, without the blanks before it.
    fn rest(&self) -> &'b [u8] {
        let rest = &self.bytes[self.next..];
        // JSON has these four blanks and no others (RFC 8259, section 2).
        let blanks = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\n' | b'\r' | b'\t'));
        &rest[blanks.count()..]
    }

    /// One of these signs, if the block does not end before.
    fn sign(&mut self, signs: &[u8]) -> Result<Option<u8>, String> {
        let rest = self.rest();
        let Some(sign) = rest.first() else { return Ok(None) };
        if !signs.contains(sign) {
            let expected: Vec<String> =
                signs.iter().map(|s| format!("{:?}", char::from(*s))).collect();
            return Err(format!("expected {}", expected.join(" or ")));
        }
        self.next = self.bytes.len() - rest.len() + 1;
        Ok(Some(*sign))
    }

    /// A value, if the block has it whole.
    fn value<T: Deserialize<'b>>(&mut self) -> Result<Option<T>, String> {
        let rest = self.rest();
        let mut values = serde_json::Deserializer::from_slice(rest).into_iter::<T>();
        match values.next() {
            Some(Ok(value)) => {
                self.next = self.bytes.len() - rest.len() + values.byte_offset();
                Ok(Some(value))
            }
            Some(Err(error)) if !is_at_end(rest, &error) => {
                // Its line and column would be those of the block.
                let what = in_words(&error);
                Err(what
                    .rsplit_once(" at line ")
                    .map_or(what.as_str(), |(what, _)| what)
                    .to_owned())
            }
            _ => Ok(None),
        }
    }
}

/// Whether all that is wrong with a text may be that it ends. Of a number that is cut behind its sign
/// serde does not say so.
fn is_at_end(text: &[u8], error: &serde_json::Error) -> bool {
    let last = text.rsplit(|byte| *byte == b'\n').next().unwrap_or(text);
    let lines = 1 + text.iter().filter(|byte| **byte == b'\n').count();
    error.is_eof() || (error.line() == lines && error.column() >= last.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn read(block: usize, text: &str) -> Result<Vec<(String, String)>, String> {
        let (file, mut all) = (Content::of(text.into()), Vec::new());
        members_by(block, &file, |found| {
            for Member { name, value, from } in found {
                assert_eq!(text[from as usize..][..value.len()], *value, "where it says");
                all.push((name, value.to_owned()));
            }
            Ok(())
        })?;
        Ok(all)
    }

    #[test]
    fn members_are_the_same_whichever_blocks_the_file_is_read_in() {
        let text = " {\"a\\\"}{\":{\"x\": [-1.5e-7, \"},\\\\\"]} , \"θ\" : {} ,\n\"\":{\"y\":{\"z\":null}}}\n ";
        let whole: BTreeMap<String, serde_json::Value> = serde_json::from_str(text).unwrap();
        for block in 1..=text.len() {
            let found = read(block, text).unwrap();
            assert_eq!(found.len(), 3);
            for (name, value) in found {
                assert_eq!(
                    serde_json::from_str::<serde_json::Value>(&value).unwrap(),
                    whole[&name]
                );
            }
            assert_eq!(read(block, "{}").unwrap(), read(block, "\t{ }").unwrap());
        }
    }

    #[test]
    fn whatever_is_not_one_object_is_refused_in_whichever_blocks() {
        let texts = [
            "",
            " ",
            "[]",
            "7",
            "{",
            "{\"a\"",
            "{\"a\":",
            "{\"a\":{}",
            "{\"a\":{},",
            "{\"a\":{},}",
            "{,}",
            "{\"a\" {}}",
            "{\"a\":{}}x",
            "{\"a\":{}}}",
            "{\"a\":{}]",
            "{a:{}}",
            "{\"a\":}",
            "{\"a\":{} \"b\":{}}",
            "{}{}",
            "\u{0}",
        ];
        for text in texts {
            for block in 1..=text.len().max(1) {
                assert!(read(block, text).is_err(), "{text:?} by {block}");
            }
            assert!(
                serde_json::from_str::<serde_json::Map<String, serde_json::Value>>(text).is_err()
            );
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        assert_eq!(read(4, "{\"a\":{}; }").unwrap_err(), "expected ',' or '}' (near byte 7)");
        assert_eq!(read(4, "{\"a\":{}").unwrap_err(), "it ends in the middle");
    }
}
