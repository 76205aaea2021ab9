//! `run --twice`: whether what was made comes out with the same bytes again.

use crate::screen::Screen;
use std::io::Write as _;
use zwidth_runner::{Job, Results, Scripts, Unlike, made_twice};
use zwidth_store::Layout;
use zwidth_study::counted;
use zwidth_tables::{Table, TableError, Values};

/// Makes the jobs again that are called so, and says whether the same bytes came out; returns what
/// differs.
pub(super) fn compare_twice(
    jobs: &[Job],
    name: &str,
    layout: &Layout,
    results: &Results,
    scripts: &Scripts,
    screen: &Screen,
) -> anyhow::Result<Vec<String>> {
    let mut differences = Vec::new();
    for job in jobs.iter().filter(|job| job.is_called(name)) {
        match made_twice(job, results, scripts)? {
            Err(why) => differences.push(format!("{}: made again, it failed: {why}", job.name)),
            Ok(unlike) if unlike.is_empty() => {
                let files = counted(job.outputs.len(), "files");
                screen.result(format!("{}: made twice, {files} with the same bytes", job.name));
            }
            Ok(unlike) => differences.extend(unlike.iter().map(|file| {
                let path = layout.shown(&file.path).display();
                format!("{}: made twice, {path} differs: {}", job.name, describe(file))
            })),
        }
    }
    Ok(differences)
}

/// How two contents of a file differ.
fn describe(file: &Unlike) -> String {
    if file.path.extension().is_some_and(|end| end == "parquet")
        && let Ok(Some(text)) = of_tables(&file.kept, &file.again)
    {
        return text;
    }
    let at = file.kept.iter().zip(&file.again).take_while(|(a, b)| a == b).count();
    let [kept, again] = [file.kept.len(), file.again.len()];
    format!("from byte {} on ({kept} bytes, then {again})", at + 1)
}

/// How two tables differ, if it is in their rows: the first value that differs, and how many others
/// do.
fn of_tables(kept: &[u8], again: &[u8]) -> Result<Option<String>, TableError> {
    let [kept, again] = [table(kept)?, table(again)?];
    if kept.height() != again.height() {
        return Ok(Some(format!("{} rows, then {}", kept.height(), again.height())));
    }
    let mut first = None;
    let mut others = 0;
    for column in kept.columns() {
        let name = &column.field.name;
        let texts = [&kept, &again].map(|table| table.column(name).map(|own| cells(&own.values)));
        let [Ok(then), Ok(now)] = texts else { return Ok(None) };
        for (row, (then, now)) in then.iter().zip(&now).enumerate() {
            if then == now {
                continue;
            }
            if first.is_none() {
                first = Some(format!("{name} in row {} is {then}, then {now}", row + 1));
            } else {
                others += 1;
            }
        }
    }
    Ok(first.map(|first| match others {
        0 => first,
        n => format!("{first}; and {n} other values"),
    }))
}

/// The values of a column as texts, to the last digit.
fn cells(values: &Values) -> Vec<String> {
    let none = || "none".to_owned();
    match values {
        Values::Float(all) => all.iter().map(|v| v.map_or_else(none, |v| v.to_string())).collect(),
        Values::Integer(all) => {
            all.iter().map(|v| v.map_or_else(none, |v| v.to_string())).collect()
        }
        Values::Text(all) => {
            all.iter().map(|v| v.as_ref().map_or_else(none, |v| v.to_string())).collect()
        }
        Values::Flag(all) => all.iter().map(|v| v.map_or_else(none, |v| v.to_string())).collect(),
    }
}

/// A table from the bytes of its file.
fn table(bytes: &[u8]) -> Result<Table, TableError> {
    let mut file = tempfile::NamedTempFile::new()?;
    file.write_all(bytes)?;
    Table::from_parquet(file.path())
}
