//! `.xlsx`: sheets, texts and formats are in parts of their own.

use super::super::limits::MOST_COLUMNS;
use super::super::xml::{Attributes, Event, Xml};
use super::dates::{is_date, is_date_number, iso};
use super::parts::{Parts, unreadable};
use super::sheet::{Sheet, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::StoreError;

const BOOK: &str = "xl/workbook.xml";
const LINKS: &str = "xl/_rels/workbook.xml.rels";
const TEXTS: &str = "xl/sharedStrings.xml";
const STYLES: &str = "xl/styles.xml";

/// The sheets, and the tables that their cells refer to.
pub(super) struct Book {
    pub(super) sheets: Vec<Named>,
    texts: Texts,
    /// Whether cells of each style hold dates.
    dates: Vec<bool>,
    since_1904: bool,
}

/// A sheet and the part that it stands in.
pub(super) struct Named {
    pub(super) name: String,
    pub(super) part: String,
}

/// Texts by number, one behind the other.
#[derive(Default)]
struct Texts {
    all: String,
    ends: Vec<usize>,
}

impl Texts {
    fn get(&self, number: usize) -> Option<&str> {
        let from =
            number.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied())?;
        self.all.get(from..*self.ends.get(number)?)
    }
}

impl Book {
    pub(super) fn read(parts: &mut Parts) -> Result<Self, String> {
        if parts.has("content.xml") && !parts.has(BOOK) {
            return Err("it is an .ods; set format = \"ods\" in [file]".to_owned());
        }
        let (sheets, since_1904) = sheets(&parts.text(BOOK)?, &parts.text(LINKS)?)?;
        let texts = if parts.has(TEXTS) { texts(&parts.text(TEXTS)?)? } else { Texts::default() };
        let dates = if parts.has(STYLES) { dates(&parts.text(STYLES)?)? } else { Vec::new() };
        Ok(Self { sheets, texts, dates, since_1904 })
    }

    /// Gives the rows of a sheet.
    pub(super) fn cells<'a>(
        &'a self,
        path: &Path,
        xml: &'a str,
        sheet: &mut Sheet,
    ) -> Result<(), StoreError> {
        let damaged = |why: String| unreadable(path, &why);
        let mut reader = Xml::new(xml);
        let (mut line, mut cells): (u64, Vec<(usize, Value)>) = (0, Vec::new());
        while let Some(event) = reader.next().map_err(damaged)? {
            match event {
                Event::Begin { name: "row", attributes } => {
                    let number = attributes.number("r").map(|row| row as u64);
                    // A row without a number follows the one before.
                    line = number.unwrap_or(line.saturating_add(1));
                }
                Event::Begin { name: "c", attributes } => {
                    let next = cells.last().map_or(0, |(place, _)| place + 1);
                    let place = attributes.get("r").and_then(|r| column(&r)).unwrap_or(next);
                    if cells.last().is_some_and(|(last, _)| *last >= place) {
                        return Err(damaged(format!("the cells of row {line} stand in no order")));
                    }
                    let value = self.value(attributes, &mut reader).map_err(damaged)?;
                    cells.extend(value.map(|value| (place, value)));
                }
                Event::End("row") => {
                    sheet.row(line, 1, &cells)?;
                    cells.clear();
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The value of the cell that began.
    fn value<'a>(
        &'a self,
        attributes: Attributes,
        reader: &mut Xml<'a>,
    ) -> Result<Option<Value<'a>>, String> {
        let Written { value, inline, formula } = written(reader)?;
        let kind = attributes.get("t").unwrap_or_default();
        if kind == "inlineStr" {
            return Ok(inline.map(Value::Text));
        }
        let Some(value) = value.filter(|value| !value.is_empty()) else {
            // Written by a program that does not calculate.
            return Ok(formula.map(|formula| Value::Text(Cow::Owned(format!("={formula}")))));
        };
        if kind == "s" {
            let text = value.trim().parse().ok().and_then(|number| self.texts.get(number));
            let text = text.ok_or_else(|| format!("it has no text number {value}"))?;
            return Ok(Some(Value::Text(Cow::Borrowed(text))));
        }
        if kind == "b" {
            let word = if value.trim() == "0" { "FALSE" } else { "TRUE" };
            return Ok(Some(Value::Text(Cow::Borrowed(word))));
        }
        let number = value.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        let Some(number) = number.filter(|_| kind.is_empty() || kind == "n") else {
            // A text that a formula gave, an error, a date in ISO.
            return Ok(Some(Value::Text(value)));
        };
        let is_date = attributes.number("s").and_then(|s| self.dates.get(s)).is_some_and(|d| *d);
        let date = iso(number, self.since_1904).filter(|_| is_date);
        Ok(Some(date.map_or(Value::Number(number), |date| Value::Text(Cow::Owned(date)))))
    }
}

/// The parts of a cell: its value, a text of its own, its formula.
#[derive(Default)]
struct Written<'a> {
    value: Option<Cow<'a, str>>,
    inline: Option<Cow<'a, str>>,
    formula: Option<Cow<'a, str>>,
}

/// Reads up to the end of a cell.
fn written<'a>(reader: &mut Xml<'a>) -> Result<Written<'a>, String> {
    let mut written = Written::default();
    let mut within = "";
    loop {
        match reader.next()?.ok_or("its XML is cut off")? {
            Event::Begin { name, .. } => within = name,
            Event::End("c") => return Ok(written),
            Event::End(_) => within = "",
            Event::Text(text) => match within {
                "v" => *written.value.get_or_insert_default() += text,
                "t" => *written.inline.get_or_insert_default() += text,
                "f" => *written.formula.get_or_insert_default() += text,
                _ => {}
            },
        }
    }
}

/// The place, from 0, of a column by its letters: `AB12` → 27.
fn column(reference: &str) -> Option<usize> {
    let letters = reference.bytes().take_while(u8::is_ascii_alphabetic);
    let number = letters.fold(0_usize, |sum, letter| {
        sum.saturating_mul(26).saturating_add(usize::from(letter.to_ascii_uppercase() - b'A') + 1)
    });
    number.checked_sub(1)
}

/// Whether a cell has a value.
pub(super) fn has_values(xml: &str) -> Result<bool, String> {
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        if matches!(event, Event::Begin { name: "v" | "t" | "f", .. }) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The sheets, and whether days are counted from 1904 on.
fn sheets(book: &str, links: &str) -> Result<(Vec<Named>, bool), String> {
    let mut parts: BTreeMap<String, String> = BTreeMap::new();
    let mut reader = Xml::new(links);
    while let Some(event) = reader.next()? {
        if let Event::Begin { name: "Relationship", attributes } = event
            && let (Some(id), Some(target)) = (attributes.get("Id"), attributes.get("Target"))
        {
            let part = target.strip_prefix('/').map_or(format!("xl/{target}"), str::to_owned);
            parts.insert(id.into_owned(), part);
        }
    }
    let mut sheets = Vec::new();
    let mut since_1904 = false;
    let mut reader = Xml::new(book);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name: "workbookPr", attributes } => {
                let word = attributes.get("date1904");
                since_1904 = word.is_some_and(|word| ["1", "true"].contains(&word.as_ref()));
            }
            Event::Begin { name: "sheet", attributes } => {
                let part = attributes.get("id").and_then(|id| parts.get(id.as_ref()));
                let name = attributes.get("name").unwrap_or_default().into_owned();
                let part = part.ok_or("a sheet is listed that has no part")?.clone();
                sheets.push(Named { name, part });
            }
            _ => {}
        }
        if sheets.len() > MOST_COLUMNS {
            return Err(format!("it has more than {MOST_COLUMNS} sheets"));
        }
    }
    Ok((sheets, since_1904))
}

/// The texts that cells refer to by number. How they are pronounced (`rPh`) is passed by.
fn texts(xml: &str) -> Result<Texts, String> {
    let mut texts = Texts::default();
    let mut is_text = false;
    let mut is_phonetic = false;
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name: "t", .. } => is_text = !is_phonetic,
            Event::End("t") => is_text = false,
            Event::Begin { name: "rPh", .. } => is_phonetic = true,
            Event::End("rPh") => is_phonetic = false,
            Event::Text(text) if is_text => texts.all.push_str(&text),
            Event::End("si") => texts.ends.push(texts.all.len()),
            _ => {}
        }
    }
    Ok(texts)
}

/// Whether cells of each style hold dates.
fn dates(xml: &str) -> Result<Vec<bool>, String> {
    let mut own: BTreeMap<usize, bool> = BTreeMap::new();
    let mut dates = Vec::new();
    let mut is_cells = false;
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name: "numFmt", attributes } => {
                let format = attributes.number("numFmtId").zip(attributes.get("formatCode"));
                own.extend(format.map(|(number, code)| (number, is_date(&code))));
            }
            Event::Begin { name: "cellXfs", .. } => is_cells = true,
            Event::End("cellXfs") => is_cells = false,
            Event::Begin { name: "xf", attributes } if is_cells => {
                let number = attributes.number("numFmtId").unwrap_or(0);
                // A format of the workbook's own stands before the one that every workbook knows by that number.
                let is_date = own.get(&number).copied().unwrap_or(is_date_number(number));
                dates.push(is_date);
            }
            _ => {}
        }
    }
    Ok(dates)
}
