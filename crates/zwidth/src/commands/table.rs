//! `zwidth table`: a derived table, in any form.

use super::near::did_you_mean;
use crate::exit::Exit;
use crate::screen::Screen;
use crate::workbook::workbook;
use anyhow::{Context as _, bail};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use zwidth_plan as plan;
use zwidth_study::{StudyId, counted};
use zwidth_tables::{Format, Table, Wording};

#[derive(Debug, clap::Args)]
pub(crate) struct TableArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The table; omit it to list the tables, or with --xlsx for all of them
    pub(crate) name: Option<String>,
    /// The form in which to print it
    #[arg(long, default_value = Format::Markdown.extension(), value_parser = format_parser())]
    pub(crate) format: Format,
    /// Only these columns, in this order, by their names in the CSV form, with or without the unit
    #[arg(long, value_name = "COLUMN,…", value_delimiter = ',')]
    pub(crate) columns: Vec<String>,
    /// Significant digits of numbers, but for p values [default: as many as their uncertainty allows, where that is shown]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=15))]
    pub(crate) digits: Option<u8>,
    /// Write the table, or every table, into a new workbook, with every digit
    #[arg(long, value_name = "FILE.xlsx", conflicts_with_all = ["format", "digits"])]
    pub(crate) xlsx: Option<PathBuf>,
}

/// Writes tables into a workbook where no file is yet.
fn write_workbook(file: &Path, tables: &[Table], screen: &Screen) -> anyhow::Result<Exit> {
    let bytes = workbook(tables).with_context(|| format!("cannot make {}", file.display()))?;
    if file.exists() {
        bail!("{} exists already; name another file", file.display());
    }
    // Another program may have made the file since: it is not overwritten.
    let mut new = std::fs::File::create_new(file)
        .with_context(|| format!("cannot write {}", file.display()))?;
    new.write_all(&bytes).with_context(|| format!("cannot write {}", file.display()))?;
    let sheets = counted(tables.len(), "sheets");
    screen.say(format!("{}: {sheets}", file.display()));
    Ok(Exit::Fine)
}

/// The formats of a table that are text, by the extensions of their files.
fn format_parser() -> impl TypedValueParser<Value = Format> {
    let values = text_formats().map(|f| PossibleValue::new(f.extension()).help(f.about()));
    PossibleValuesParser::new(values).try_map(|word| {
        let format = text_formats().find(|format| format.extension() == word);
        format.ok_or_else(|| format!("'{word}' is not a format"))
    })
}

fn text_formats() -> impl Iterator<Item = Format> {
    Format::ALL.into_iter().filter(|format| format.is_text())
}

#[derive(Serialize)]
struct Entry {
    name: String,
    title: String,
    rows: usize,
}

pub(crate) fn table(root: &Path, command: &TableArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let data = super::load(root, &command.study)?;
    let printed: Vec<_> =
        plan::printed_tables(&data).into_iter().filter(plan::Printed::exists).collect();
    if printed.is_empty() {
        bail!("{} has no tables yet; make them with `zwidth run {}`", command.study, command.study);
    }
    if let (None, Some(file)) = (&command.name, &command.xlsx) {
        if !command.columns.is_empty() {
            bail!("--columns: name the table whose columns these are");
        }
        let tables: Result<Vec<Table>, _> = printed.iter().map(plan::Printed::read).collect();
        return write_workbook(file, &tables?, screen);
    }
    let Some(name) = &command.name else {
        let mut entries = Vec::new();
        let mut unread = Vec::new();
        for table in &printed {
            match table.about() {
                Ok((title, rows)) => entries.push(Entry { name: table.name(), title, rows }),
                Err(error) => unread.push(error),
            }
        }
        screen.give(&entries, || {
            let width = entries.iter().map(|e| e.name.chars().count()).max().unwrap_or_default();
            for Entry { name, title, rows } in &entries {
                let unit = if *rows == 1 { "row" } else { "rows" };
                screen.result(format!("{name:<width$}  {title} ({rows} {unit})"));
            }
        })?;
        unread.iter().for_each(|error| screen.warn(format!("unreadable: {error}")));
        return Ok(if unread.is_empty() { Exit::Fine } else { Exit::Partly });
    };
    let Some(table) = printed.iter().find(|table| table.name() == *name) else {
        let names: Vec<String> = printed.iter().map(plan::Printed::name).collect();
        // `contrasts` for contrasts_stiffness_n_per_rad, and others of its kind.
        let hint = match names.iter().find(|table| table.starts_with(name.as_str())) {
            Some(table) => format!("; there is {table}"),
            None => did_you_mean(name, names.iter().map(String::as_str)),
        };
        bail!(
            "{} has no table '{name}'{hint} (`zwidth table {}` lists them)",
            command.study,
            command.study
        );
    };
    let table = match table.read() {
        Ok(table) => table,
        Err(error) => {
            screen.warn(format!("unreadable: {error}"));
            bail!("{} has no table '{name}' that can be read", command.study);
        }
    };
    if let Some(file) = &command.xlsx {
        let table = if command.columns.is_empty() {
            table
        } else {
            table.with_columns(&command.columns)?
        };
        return write_workbook(file, &[table], screen);
    }
    if command.digits.is_some() && command.format.is_for_programs() {
        bail!(
            "{} has every digit: leave --digits out, or choose another --format",
            command.format.about()
        );
    }
    let wording = Wording { digits: command.digits.map(usize::from), ..Wording::of(&data.study) };
    let wanted = [(command.format, Path::new(name))];
    let printed = match command.columns.as_slice() {
        [] => plan::write_table(&table, &wanted, &wording, &BTreeMap::new())?,
        columns => {
            let table = table.with_columns(columns)?;
            table.to_bytes(&table, &wanted, &wording, &BTreeMap::new())?
        }
    };
    for bytes in printed {
        screen.file(&String::from_utf8(bytes)?);
    }
    Ok(Exit::Fine)
}
