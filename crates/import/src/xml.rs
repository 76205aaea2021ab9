//! XML as far as headers and workbooks need it: elements, attributes and texts, in their order.
//!
//! quick-xml finds the tags. It does not limit how deep they are nested, accepts a file that ends
//! in the middle, and cuts a text at every reference. Names are given without their prefix.
//! Comments, declarations and instructions are skipped.

use super::spelling::shown;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::Event as Read;
use quick_xml::events::attributes::Attributes as Written;
use quick_xml::{Reader, XmlVersion};
use std::borrow::Cow;

/// An element's beginning or end, or a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Event<'a> {
    Begin {
        name: &'a str,
        attributes: Attributes<'a>,
    },
    /// All up to the next tag.
    Text(Cow<'a, str>),
    /// One for every beginning.
    End(&'a str),
}

/// Elements within each other, at most.
const MOST_DEPTH: usize = 64;

/// Reads a text from the front on.
pub(super) struct Xml<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    /// The elements that have not ended.
    open: Vec<&'a str>,
    /// The tag behind the text that was given last.
    behind: Option<Read<'a>>,
}

impl<'a> Xml<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        // The reader's places do not count a byte-order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        reader.config_mut().allow_dangling_amp = true;
        Self { text, reader, open: Vec::new(), behind: None }
    }

    /// The next event; `None` at the end.
    ///
    /// # Errors
    /// A text that is cut off, or whose elements end in another order.
    pub(super) fn next(&mut self) -> Result<Option<Event<'a>>, String> {
        let mut text: Option<Cow<'a, str>> = None;
        loop {
            let read = match self.behind.take() {
                Some(read) => read,
                None => self.reader.read_event().map_err(|e| {
                    let place = self.reader.error_position();
                    let why = e.to_string();
                    format!("its XML is cut off or damaged at byte {place} ({})", shown(&why))
                })?,
            };
            let part = match read {
                Read::Text(part) => part.into_inner(),
                Read::CData(part) => part.into_inner(),
                // A reference that XML does not know stands as it is written.
                Read::GeneralRef(name) => {
                    match (name.resolve_char_ref(), resolve_predefined_entity(&name)) {
                        (Ok(Some(letter)), _) => Cow::Owned(letter.to_string()),
                        (_, Some(letter)) => Cow::Borrowed(letter),
                        _ => Cow::Owned(format!("&{};", &*name)),
                    }
                }
                Read::Comment(_) | Read::Decl(_) | Read::PI(_) | Read::DocType(_) => continue,
                tag if text.is_some() => {
                    self.behind = Some(tag);
                    return Ok(text.map(Event::Text));
                }
                Read::Start(tag) | Read::Empty(tag) => {
                    return self.begin(tag.len(), tag.name().as_ref().len()).map(Some);
                }
                Read::End(_) => return Ok(self.open.pop().map(Event::End)),
                Read::Eof if self.open.is_empty() => return Ok(None),
                Read::Eof => return Err("its XML is cut off".to_owned()),
            };
            *text.get_or_insert_default() += part;
        }
    }

    /// The element whose tag was read last, of so many bytes between `<` and `>` or `/>`: out of our own
    /// text, which lives longer than what the reader lends.
    fn begin(&mut self, length: usize, name: usize) -> Result<Event<'a>, String> {
        if self.open.len() == MOST_DEPTH {
            return Err(format!("its XML has more than {MOST_DEPTH} levels"));
        }
        let end = usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX);
        let tag = self.text.get(..end).and_then(|read| read.strip_suffix('>'));
        let tag = tag.map(|tag| tag.strip_suffix('/').unwrap_or(tag));
        let tag = tag.and_then(|tag| tag.get(tag.len().checked_sub(length)?..));
        let (name, attributes) =
            tag.and_then(|tag| tag.split_at_checked(name)).ok_or("its XML is damaged")?;
        let name = name.rsplit_once(':').map_or(name, |(_, local)| local);
        self.open.push(name);
        Ok(Event::Begin { name, attributes: Attributes(attributes) })
    }
}

/// The attributes of an element, as they stand in its tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Attributes<'a>(&'a str);

impl<'a> Attributes<'a> {
    /// The value of the first one of this name.
    pub(super) fn get(self, wanted: &str) -> Option<Cow<'a, str>> {
        let mut all = Written::new(self.0, 0);
        let mut readable = all.with_checks(false).filter_map(Result::ok);
        let attribute = readable.find(|one| one.key.local_name().as_ref() == wanted)?;
        Some(attribute.normalized_value(XmlVersion::Implicit1_0).unwrap_or(attribute.value))
    }

    /// The number that an attribute spells.
    pub(super) fn number(self, wanted: &str) -> Option<usize> {
        self.get(wanted)?.trim().parse().ok()
    }
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
    fn what_stands_before_the_first_element_and_within_a_text_is_passed_by() {
        let xml = "\u{feff}<!DOCTYPE a [<!ENTITY b \"c>\">]><a>s<!-- no -->t &amp<i r='1'/></a>";
        assert_eq!(told(xml).unwrap(), ["<a ", "st &amp", "<i 1", "/i", "/a"]);
    }

    #[test]
    fn what_is_damaged_is_told_with_its_place() {
        let error = told("<a><b></a>").unwrap_err();
        assert!(error.contains("at byte 6 (") && error.contains("</b>"), "{error}");
    }

    #[test]
    fn what_is_cut_off_or_too_deep_is_refused() {
        for xml in ["<a", "<a>", "<a><b></a>", "</a>", "<!-- ", "<a x='>", &"<a>".repeat(100)] {
            assert!(told(xml).is_err(), "{xml}");
        }
    }
}
