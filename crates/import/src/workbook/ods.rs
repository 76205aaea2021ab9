//! `.ods`: all sheets in one part; adjacent equal cells and rows are written once.

use super::super::limits::MOST_COLUMNS;
use super::super::xml::{Attributes, Event, Xml};
use super::parts::unreadable;
use super::sheet::{Sheet, Value};
use std::borrow::Cow;
use std::path::Path;
use zwidth_store::StoreError;

/// A sheet, before its cells are read.
pub(super) struct Named {
    pub(super) name: String,
    pub(super) has_values: bool,
}

/// The sheets.
pub(super) fn sheets(xml: &str) -> Result<Vec<Named>, String> {
    let mut sheets: Vec<Named> = Vec::new();
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name: "table", attributes } => {
                let name = attributes.get("name").unwrap_or_default().into_owned();
                sheets.push(Named { name, has_values: false });
            }
            // A cell without a type is blank, however it is formatted.
            Event::Begin { name: "table-cell", attributes }
                if attributes.get("value-type").is_some() =>
            {
                sheets.iter_mut().next_back().into_iter().for_each(|sheet| sheet.has_values = true);
            }
            _ => {}
        }
        if sheets.len() > MOST_COLUMNS {
            return Err(format!("it has more than {MOST_COLUMNS} sheets"));
        }
    }
    Ok(sheets)
}

/// Gives the rows of the sheet at a place.
pub(super) fn cells(
    path: &Path,
    xml: &str,
    wanted: usize,
    sheet: &mut Sheet,
) -> Result<(), StoreError> {
    let damaged = |why: String| unreadable(path, &why);
    let mut reader = Xml::new(xml);
    let mut tables = 0_usize;
    let mut line = 1_u64;
    while let Some(event) = reader.next().map_err(damaged)? {
        match event {
            Event::Begin { name: "table", .. } => tables += 1,
            Event::Begin { name: "table-row", attributes } if tables == wanted + 1 => {
                let repeated = attributes.number("number-rows-repeated").unwrap_or(1);
                let cells = row(&mut reader).map_err(damaged)?;
                sheet.row(line, repeated, &cells)?;
                line = line.saturating_add(repeated as u64);
            }
            _ => {}
        }
    }
    Ok(())
}

/// The cells of the row that began, up to its end.
fn row<'a>(reader: &mut Xml<'a>) -> Result<Vec<(usize, Value<'a>)>, String> {
    let mut place = 0_usize;
    let mut cells = Vec::new();
    loop {
        match reader.next()?.ok_or("its XML is cut off")? {
            Event::End("table-row") => return Ok(cells),
            Event::Begin { name: name @ ("table-cell" | "covered-table-cell"), attributes } => {
                let repeated = attributes.number("number-columns-repeated").unwrap_or(1);
                let value = value(attributes, texts(reader, name)?);
                if let Some(value) = value {
                    // One more than is read: what there is too much of is told by the sheet.
                    let room = (MOST_COLUMNS + 1).saturating_sub(place);
                    cells.extend((place..).take(repeated.min(room)).map(|at| (at, value.clone())));
                }
                place = place.saturating_add(repeated);
            }
            _ => {}
        }
    }
}

/// The paragraphs of the cell that began, up to its end; those of remarks are passed by.
fn texts<'a>(reader: &mut Xml<'a>, cell: &str) -> Result<Option<Cow<'a, str>>, String> {
    let (mut all, mut remarks): (Option<Cow<str>>, usize) = (None, 0);
    let mut paragraphs = 0_usize;
    loop {
        match reader.next()?.ok_or("its XML is cut off")? {
            Event::End(name) if name == cell => return Ok(all),
            Event::Begin { name: "annotation", .. } => remarks += 1,
            Event::End("annotation") => remarks = remarks.saturating_sub(1),
            Event::Begin { name: "p", .. } if remarks == 0 => paragraphs += 1,
            // Between blanks stand those that the text repeats, and a tab is an element.
            Event::Begin { name: "s" | "tab" | "line-break", .. } if remarks == 0 => {
                all.get_or_insert_default().to_mut().push(' ');
            }
            Event::Text(text) if remarks == 0 && paragraphs > 0 => {
                *all.get_or_insert_default() += text;
            }
            _ => {}
        }
    }
}

/// The value of a cell: numbers and dates stand in its attributes, texts in its paragraphs.
fn value<'a>(attributes: Attributes<'a>, text: Option<Cow<'a, str>>) -> Option<Value<'a>> {
    match attributes.get("value-type")?.as_ref() {
        "float" | "percentage" | "currency" => {
            let number = attributes.get("value").and_then(|value| value.trim().parse().ok());
            let number = number.filter(|number: &f64| number.is_finite());
            number.map(Value::Number).or_else(|| text.map(Value::Text))
        }
        "date" => attributes.get("date-value").or(text).map(Value::Text),
        "time" => attributes.get("time-value").or(text).map(Value::Text),
        "boolean" => attributes.get("boolean-value").or(text).map(Value::Text),
        _ => text.or_else(|| attributes.get("string-value")).map(Value::Text),
    }
}
