//! XML as far as headers and workbooks need it: elements, attributes and texts, in the order in
//! which they stand.
//!
//! Names are told without their prefix. What comments, declarations and instructions say is passed
//! by.

use std::borrow::Cow;

/// What comes next.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Event<'a> {
    Begin {
        name: &'a str,
        attributes: Attributes<'a>,
    },
    Text(Cow<'a, str>),
    /// One for every beginning.
    End(&'a str),
}

/// Elements within each other, at most.
const MOST_DEPTH: usize = 64;

/// Reads a text from the front on.
pub(super) struct Xml<'a> {
    rest: &'a str,
    /// The elements that have not ended.
    open: Vec<&'a str>,
    /// Whether the last one ended as it began: `<a/>`.
    is_empty: bool,
}

impl<'a> Xml<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text, open: Vec::new(), is_empty: false }
    }

    /// What comes next, `None` at the end.
    ///
    /// # Errors
    /// A text that is cut off, or whose elements end in another order.
    pub(super) fn next(&mut self) -> Result<Option<Event<'a>>, String> {
        if std::mem::take(&mut self.is_empty) {
            return Ok(self.open.pop().map(Event::End));
        }
        loop {
            let Some(tail) = self.rest.strip_prefix('<') else {
                if self.rest.is_empty() {
                    return if self.open.is_empty() { Ok(None) } else { Err(cut_off()) };
                }
                let (text, rest) =
                    self.rest.split_at(self.rest.find('<').unwrap_or(self.rest.len()));
                self.rest = rest;
                return Ok(Some(Event::Text(plain(text))));
            };
            if let Some(comment) = tail.strip_prefix("!--") {
                self.rest = comment.split_once("-->").ok_or_else(cut_off)?.1;
                continue;
            }
            if let Some(data) = tail.strip_prefix("![CDATA[") {
                let (data, rest) = data.split_once("]]>").ok_or_else(cut_off)?;
                self.rest = rest;
                return Ok(Some(Event::Text(Cow::Borrowed(data))));
            }
            let end = end_of_tag(tail).ok_or_else(cut_off)?;
            let (tag, rest) = (&tail[..end], &tail[end + 1..]);
            self.rest = rest;
            if !tag.starts_with(['?', '!']) {
                return self.tag(tag).map(Some);
            }
        }
    }

    fn tag(&mut self, tag: &'a str) -> Result<Event<'a>, String> {
        if let Some(name) = tag.strip_prefix('/') {
            let name = local(name.trim_end());
            return match self.open.pop() {
                Some(open) if open == name => Ok(Event::End(open)),
                _ => Err("its XML is damaged: an element ends that did not begin".to_owned()),
            };
        }
        let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        let (name, attributes) =
            tag.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((tag, ""));
        let name = local(name);
        if self.open.len() == MOST_DEPTH {
            return Err(format!("its XML has more than {MOST_DEPTH} levels"));
        }
        self.open.push(name);
        self.is_empty = is_empty;
        Ok(Event::Begin { name, attributes: Attributes(attributes) })
    }
}

fn cut_off() -> String {
    "its XML is cut off".to_owned()
}

/// The place of the `>` that ends a tag: not one between quotes.
fn end_of_tag(text: &str) -> Option<usize> {
    let mut quote = None;
    text.bytes().position(|byte| {
        match (quote, byte) {
            (None, b'>') => return true,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
        false
    })
}

/// A name without its prefix.
fn local(name: &str) -> &str {
    name.rsplit_once(':').map_or(name, |(_, local)| local)
}

/// The attributes of an element, as they stand in its tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Attributes<'a>(&'a str);

impl<'a> Attributes<'a> {
    /// The value of the first one of this name.
    pub(super) fn get(self, wanted: &str) -> Option<Cow<'a, str>> {
        let mut rest = self.0;
        loop {
            let (name, tail) = rest.split_once('=')?;
            let tail = tail.trim_start();
            let quote = tail.chars().next().filter(|c| ['"', '\''].contains(c))?;
            let (value, tail) = tail[1..].split_once(quote)?;
            if local(name.trim()) == wanted {
                return Some(plain(value));
            }
            rest = tail;
        }
    }

    /// The number that an attribute spells.
    pub(super) fn number(self, wanted: &str) -> Option<usize> {
        self.get(wanted)?.trim().parse().ok()
    }
}

/// A text with XML's own five names, and characters by number, read as what they mean.
fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains('&') {
        return Cow::Borrowed(text);
    }
    let mut parts = text.split('&');
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(';').and_then(|(name, rest)| Some((letter(name)?, rest))) {
            Some((letter, rest)) => {
                plain.push(letter);
                plain.push_str(rest);
            }
            None => {
                plain.push('&');
                plain.push_str(part);
            }
        }
    }
    Cow::Owned(plain)
}

fn letter(name: &str) -> Option<char> {
    Some(match name {
        "amp" => '&',
        "lt" => '<',
        "gt" => '>',
        "quot" => '"',
        "apos" => '\'',
        _ => {
            let number = name.strip_prefix('#')?;
            let code = match number.strip_prefix('x') {
                Some(hex) => u32::from_str_radix(hex, 16),
                None => number.parse(),
            };
            return char::from_u32(code.ok()?);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(xml: &str) -> Result<Vec<String>, String> {
        let mut reader = Xml::new(xml);
        let mut told = Vec::new();
        while let Some(event) = reader.next()? {
            told.push(match event {
                Event::Begin { name, attributes } => {
                    format!("<{name} {}", attributes.get("r").unwrap_or_default())
                }
                Event::Text(text) => text.into_owned(),
                Event::End(name) => format!("/{name}"),
            });
        }
        Ok(told)
    }

    #[test]
    fn elements_attributes_and_texts_come_in_their_order() {
        let xml = "<?xml v='1'?><!-- <no> --><x:a q = \"1>2\" x:r='&lt;3'>t&amp;&#228;&#xe4;&no;<b/><![CDATA[<&]]></x:a>";
        assert_eq!(told(xml).unwrap(), ["<a <3", "t&ää&no;", "<b ", "/b", "<&", "/a"]);
    }

    #[test]
    fn what_is_cut_off_or_too_deep_is_refused() {
        for xml in ["<a", "<a>", "<a><b></a>", "</a>", "<!-- ", "<a x='>", &"<a>".repeat(100)] {
            assert!(told(xml).is_err(), "{xml}");
        }
    }
}
